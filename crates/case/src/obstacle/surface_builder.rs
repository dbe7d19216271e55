//! Surfaces built from the shapes of obstacles.

use std::any::Any;
use std::path::Path;

use colluvium_points::Raster;
use colluvium_points::surface::{
    BallSurface, FacettedSurface, GroundProfile, HalfSpace, HeightField, PlacedSurface, RevolvedSurface,
    RigidTransform, SharedSurface, SurfaceError,
};

use crate::description::{ObstacleShape, ProfilePiece};
use crate::files::column_file::{Quantity, read_pairs};
use crate::files::decimal_sum::relative_to_origin;
use crate::files::terrain_files::{self, FileError};
use crate::{CaseError, CaseErrorKind};

/// Error in a shape: path below it, and description.
type ShapeProblem = (String, CaseErrorKind);

/// Surface of a shape with the path `path` in its case; `origin` (m) is subtracted from coordinates of its file.
pub(super) fn surface<const D: usize>(
    shape: &ObstacleShape,
    path: &str,
    origin: &[f64; 3],
) -> Result<SharedSurface<D>, CaseError> {
    let made = match shape {
        ObstacleShape::Plane { point, normal } => plane(point, normal),
        ObstacleShape::Box { min, max } => box_surface(min, max),
        ObstacleShape::Ball { centre, radius, hollow } => ball(centre, *radius, *hollow),
        ObstacleShape::GroundLine { points, file } => {
            ground_line(points, file.as_deref(), origin).map(FacettedSurface::into_shared).and_then(in_space)
        }
        ObstacleShape::Profile { start, pieces } => {
            profile(*start, pieces).map(GroundProfile::into_shared).and_then(in_space)
        }
        ObstacleShape::Polygon { vertices } => FacettedSurface::polygon(vertices)
            .map_err(from_polygon_error)
            .map(FacettedSurface::into_shared)
            .and_then(in_space),
        ObstacleShape::Extruded { vertices, axis, from, to } => axis_of_space(*axis)
            .and_then(|()| FacettedSurface::extruded(vertices, *axis, *from, *to).map_err(from_polygon_error))
            .map(FacettedSurface::into_shared)
            .and_then(in_space),
        ObstacleShape::Turned { vertices, axis, centre } => {
            surface_of_revolution(vertices, *axis, *centre).map(PlacedSurface::into_shared).and_then(in_space)
        }
        ObstacleShape::Raster { file, spacing } => {
            raster(file, *spacing, origin).map(HeightField::into_shared).and_then(in_space)
        }
        ObstacleShape::Mesh { file } => {
            let mesh =
                terrain_files::read_mesh(Path::new(file), &|axis, x| relative_to_origin(x, origin[axis]));
            mesh.map_err(file_error).map(FacettedSurface::into_shared).and_then(in_space)
        }
    };
    made.map_err(|problem| error_at(path, problem))
}

/// Heights (m) of a shape with the path `path` in its case, where it is a raster.
pub(super) fn raster_of(
    shape: &ObstacleShape,
    path: &str,
    origin: &[f64; 3],
) -> Result<Option<Raster>, CaseError> {
    let ObstacleShape::Raster { file, spacing } = shape else { return Ok(None) };
    heights(file, *spacing, origin).map(Some).map_err(|problem| error_at(path, problem))
}

/// Error of a shape with the JSON path of its key.
fn error_at(path: &str, (key, problem): ShapeProblem) -> CaseError {
    match key.as_str() {
        "" => CaseError::new(path, problem),
        key => CaseError::new(format!("{path}.{key}"), problem),
    }
}

/// Key and message of an error of a surface.
fn from_surface_error(error: SurfaceError) -> ShapeProblem {
    (error.path, error.problem.into())
}

/// Key and message of an error of a surface whose corners are the key `vertices`.
fn from_polygon_error(error: SurfaceError) -> ShapeProblem {
    let path = match error.path.strip_prefix("points") {
        Some(index) => format!("vertices{index}"),
        None if error.path.starts_with("facets") => "vertices".to_owned(),
        None => error.path,
    };
    (path, error.problem.into())
}

/// Error of a shape at its key `file`.
fn file_problem(file: &str, problem: impl Into<String>) -> ShapeProblem {
    ("file".to_owned(), CaseErrorKind::file(file, problem))
}

/// Error of a shape whose file cannot be read, at its key `file`.
fn file_error(error: FileError) -> ShapeProblem {
    ("file".to_owned(), error.into())
}

/// Surface of `N` coordinates in a space of `D` coordinates; an error where the numbers differ.
fn in_space<const N: usize, const D: usize>(
    surface: SharedSurface<N>,
) -> Result<SharedSurface<D>, ShapeProblem> {
    let surface: Box<dyn Any> = Box::new(surface);
    let own = surface.downcast::<SharedSurface<D>>().map(|own| *own);
    own.map_err(|_| {
        (
            String::new(),
            CaseErrorKind::coded(
                "wrong-dimension",
                format!("is a shape of {N} dimensions, the space has {D}"),
            ),
        )
    })
}

/// Vector of the space from a list of components, whose length has been checked.
fn vector<const D: usize>(values: &[f64]) -> [f64; D] {
    std::array::from_fn(|c| values.get(c).copied().unwrap_or(f64::NAN))
}

/// Half-space below a plane.
fn plane<const D: usize>(point: &[f64], normal: &[f64]) -> Result<SharedSurface<D>, ShapeProblem> {
    HalfSpace::new(vector::<D>(point), vector(normal)).map(HalfSpace::into_shared).map_err(from_surface_error)
}

/// Surface of a box.
fn box_surface<const D: usize>(min: &[f64], max: &[f64]) -> Result<SharedSurface<D>, ShapeProblem> {
    FacettedSurface::around_box(vector::<D>(min), vector(max))
        .map(FacettedSurface::into_shared)
        .map_err(from_surface_error)
}

/// Surface of a ball, or of a ball-shaped cavity where `hollow`.
fn ball<const D: usize>(centre: &[f64], radius: f64, hollow: bool) -> Result<SharedSurface<D>, ShapeProblem> {
    BallSurface::new(vector::<D>(centre), radius, hollow)
        .map(BallSurface::into_shared)
        .map_err(from_surface_error)
}

/// Checks that an axis is one of the three of space.
fn axis_of_space(axis: usize) -> Result<(), ShapeProblem> {
    let problem = || CaseErrorKind::out_of_range(axis as f64, "is not in 0..=2");
    if axis < 3 { Ok(()) } else { Err(("axis".to_owned(), problem())) }
}

/// Surface of a ground line, from its points or from a file.
fn ground_line(
    points: &[[f64; 2]],
    file: Option<&str>,
    origin: &[f64; 3],
) -> Result<FacettedSurface<2>, ShapeProblem> {
    let Some(file) = file else { return FacettedSurface::ground_line(points).map_err(from_surface_error) };
    let names: [(Quantity, &[&str]); 2] = [
        (Quantity::Length, &["x", "distance", "station", "chainage", "dist"]),
        (Quantity::Length, &["y", "z", "height", "elevation", "level", "altitude"]),
    ];
    let points = read_pairs(file, names)
        .map(|points| points.into_iter().map(|x| plan_relative_to_origin(x, origin)).collect::<Vec<_>>());
    let points = points.map_err(|problem| ("file".to_owned(), problem.in_table(file)))?;
    let in_file = |error: SurfaceError| file_problem(file, format!("{}: {}", error.path, error.problem));
    FacettedSurface::ground_line(&points).map_err(in_file)
}

/// Position in plan relative to the origin of the domain (m).
fn plan_relative_to_origin(x: [f64; 2], origin: &[f64; 3]) -> [f64; 2] {
    std::array::from_fn(|c| relative_to_origin(x[c], origin[c]))
}

/// Ground profile of lines and arcs from a starting point.
fn profile(start: [f64; 2], pieces: &[ProfilePiece]) -> Result<GroundProfile, ShapeProblem> {
    let mut profile = GroundProfile::starting_at(start);
    for (number, piece) in pieces.iter().enumerate() {
        let added = match piece.centre {
            Some(centre) => profile.arc_to(piece.to, centre),
            None => profile.line_to(piece.to),
        };
        added.map_err(|error| (format!("pieces[{number}].{}", error.path), error.problem.into()))?;
    }
    profile.close().map_err(from_surface_error)
}

/// Surface of revolution of a polygon about a line parallel to an axis through `centre`.
fn surface_of_revolution(
    vertices: &[[f64; 2]],
    axis: usize,
    centre: [f64; 3],
) -> Result<PlacedSurface<3>, ShapeProblem> {
    axis_of_space(axis)?;
    // Coordinates along the axis are those of space.
    let offset: [f64; 3] = std::array::from_fn(|c| if c == axis { 0.0 } else { centre[c] });
    let shape = RevolvedSurface::new(vertices, axis).map_err(from_polygon_error)?;
    Ok(PlacedSurface { surface: shape.into_shared(), transform: RigidTransform::default().shifted(&offset) })
}

/// Heights of a raster file; `origin` (m) is subtracted.
fn heights(file: &str, spacing: Option<f64>, origin: &[f64; 3]) -> Result<Raster, ShapeProblem> {
    let mut raster = terrain_files::read_raster(Path::new(file)).map_err(file_error)?;
    (0..2).for_each(|c| raster.origin[c] = relative_to_origin(raster.origin[c], origin[c]));
    raster.values.iter_mut().filter(|z| z.is_finite()).for_each(|z| *z = relative_to_origin(*z, origin[2]));
    match spacing {
        Some(spacing) => {
            let problem = |error: String| CaseErrorKind::file(file, error);
            raster.resampled([spacing; 2]).map_err(|error| ("spacing".to_owned(), problem(error.to_string())))
        }
        None => Ok(raster),
    }
}

/// Surface of a raster file of heights, relative to the origin of the domain.
fn raster(file: &str, spacing: Option<f64>, origin: &[f64; 3]) -> Result<HeightField, ShapeProblem> {
    let raster = heights(file, spacing, origin)?;
    HeightField::new(raster).map_err(|error| file_problem(file, error.to_string()))
}
