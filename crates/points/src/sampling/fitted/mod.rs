//! Points in rows along the edges of a plane shape, each with the area of its Voronoi patch.

mod boundary_rows;
mod voronoi_patches;

use crate::sampling::fitted::voronoi_patches::VoronoiPatches;

use super::{CandidateCells, Sample, SamplingError};
use crate::Shape;
use crate::search::neighbours::CellList;
use crate::shape::{BoundaryEdge, PlanePoint};

/// Smallest distance of the lattice points that fill the space between the rows from other points (spacings).
const LATTICE_CLEARANCE: f64 = 0.8;

/// Smallest distance of single points that fill the remaining gaps from other points (spacings).
const FILL_CLEARANCE: f64 = 0.9;

/// Relative difference of a patch area from the square of the spacing above which its point and its neighbours are moved.
const MAX_AREA_DEVIATION: f64 = 0.15;

/// Largest number of iterations that move uneven points to the centroids of their patches (Lloyd 1982).
const MAX_RELAXATIONS: usize = 30;

/// Distance from an uneven point within which other points are moved too (spacings).
const RELAXATION_RADIUS: f64 = 2.0;

/// Distance from an edge below which points are not moved (spacings).
const FIXED_DISTANCE: f64 = 0.8;

/// Share of the area that may be lost to round-off.
const MAX_LOST_AREA: f64 = 1e-9;

/// Plane region with its edges.
pub(super) struct PlanarRegion<'a> {
    /// Shape that contains the points.
    pub(super) shape: &'a Shape,
    /// Edges of the boundary of the shape.
    pub(super) sides: Vec<BoundaryEdge>,
    /// Spacing of the points (m).
    pub(super) spacing: f64,
}

impl PlanarRegion<'_> {
    /// Distance to the nearest edge (m).
    fn distance_to_boundary(&self, x: PlanePoint) -> f64 {
        self.sides.iter().map(|side| side.distance(x)).fold(f64::INFINITY, f64::min)
    }
}

/// Samples a plane shape by rows of points along its edges, about a `spacing` (m) apart. The first row is half a spacing from the edge, and
/// rows end where they meet those of another edge. The space between the rows is filled from the lattice that begins at `origin` (m), and
/// unevenly spaced points there are moved. Each point is the centroid of its Voronoi patch and has its exact area, so that areas and their
/// moments sum up to those of the shape. Points are sorted by columns, from low to high.
///
/// # Errors
/// When the shape has edges other than straight lines and arcs, or is too thin in places, when there would be more than 2²⁸ candidates, or
/// the spacing is not a length.
pub fn fitted_rows<const D: usize>(
    shape: &Shape,
    origin: [f64; D],
    spacing: f64,
) -> Result<Vec<Sample<D>>, SamplingError> {
    if D != 2 {
        return Err(SamplingError::NoBoundaryEdges);
    }
    let samples = in_plane(shape, [origin[0], origin[1]], spacing)?;
    let in_space = |sample: Sample<2>| Sample {
        position: std::array::from_fn(|c| sample.position[c]),
        volume: sample.volume,
    };
    Ok(samples.into_iter().map(in_space).collect())
}

/// Samples of a plane shape: points in rows along its edges, with the areas of their Voronoi patches.
fn in_plane(shape: &Shape, origin: PlanePoint, spacing: f64) -> Result<Vec<Sample<2>>, SamplingError> {
    let cells = CandidateCells::around_shape(shape, origin, spacing, 1.0)?;
    let sides = shape.boundary_edges().ok_or(SamplingError::NoBoundaryEdges)?;
    let region = PlanarRegion { shape, sides, spacing };
    let mut apart = boundary_rows::rows_along_boundary(&region);
    fill(&region, cells.first, cells.count, origin, &mut apart);
    let mut points = apart.into_points();
    relax_uneven_points(&region, &mut points);
    let patches = VoronoiPatches::new(&region, &points);
    let mut samples: Vec<(PlanePoint, f64)> =
        (0..points.len()).map(|i| patches.centroid_and_area(i)).collect();
    for ((centre, _), point) in samples.iter_mut().zip(&points) {
        if !shape.contains(centre) {
            *centre = *point;
        }
    }
    let reference =
        [cells.first[0] as f64 * spacing + origin[0], cells.first[1] as f64 * spacing + origin[1]];
    let exact: f64 = region.sides.iter().map(|side| side.sector_moments(reference).area).sum();
    let found: f64 = samples.iter().map(|(_, area)| area).sum();
    if (found - exact).abs() > MAX_LOST_AREA * exact {
        return Err(SamplingError::TooThin { spacing, lost: 1.0 - found / exact });
    }
    let column = |x: &PlanePoint| ((x[0] - origin[0]) / spacing).floor();
    samples.sort_by(|(a, _), (b, _)| column(a).total_cmp(&column(b)).then(a[1].total_cmp(&b[1])));
    Ok(samples.into_iter().map(|(position, volume)| Sample { position, volume }).collect())
}

/// Fills the space between the rows with lattice points, and then remaining gaps with single points.
fn fill(
    region: &PlanarRegion<'_>,
    first: [i64; 2],
    count: [i64; 2],
    origin: PlanePoint,
    points: &mut boundary_rows::SpacedPoints,
) {
    let spacing = region.spacing;
    for (parts, apart) in [(1i64, LATTICE_CLEARANCE), (4, FILL_CLEARANCE)] {
        let edge = spacing / parts as f64;
        for number in 0..count[0] * count[1] * parts * parts {
            let [column, row] = [number / (count[1] * parts), number % (count[1] * parts)];
            let place = |c: usize, k: i64| origin[c] + ((first[c] * parts + k) as f64 + 0.5) * edge;
            let x = [place(0, column), place(1, row)];
            // A point on an edge would have half a patch.
            if points.is_free(x, apart * spacing)
                && region.shape.contains(&x)
                && (parts > 1 || region.distance_to_boundary(x) > 0.25 * spacing)
            {
                points.add(x);
            }
        }
    }
}

/// Moves the points of uneven patches and their neighbours, except those next to an edge, to the centroids of their patches.
fn relax_uneven_points(region: &PlanarRegion<'_>, points: &mut [PlanePoint]) {
    let (spacing, whole) = (region.spacing, region.spacing * region.spacing);
    let uneven: Vec<PlanePoint> = {
        let patches = VoronoiPatches::new(region, points);
        let off = |i: &usize| (patches.centroid_and_area(*i).1 / whole - 1.0).abs() > MAX_AREA_DEVIATION;
        (0..points.len()).filter(off).map(|i| points[i]).collect()
    };
    let mut near = CellList::new();
    if uneven.is_empty() || near.build(&uneven, RELAXATION_RADIUS * spacing).is_err() {
        return;
    }
    let moves = |x: &PlanePoint| {
        let mut nearest = f64::INFINITY;
        near.visit(x, |j| {
            let other = uneven[j as usize];
            nearest = nearest.min((x[0] - other[0]).hypot(x[1] - other[1]));
        });
        nearest < 1e-9 * spacing
            || (nearest < RELAXATION_RADIUS * spacing
                && region.distance_to_boundary(*x) > FIXED_DISTANCE * spacing)
    };
    let free: Vec<usize> = (0..points.len()).filter(|i| moves(&points[*i])).collect();
    for _ in 0..MAX_RELAXATIONS {
        let patches = VoronoiPatches::new(region, points);
        let moved: Vec<PlanePoint> = free.iter().map(|i| patches.centroid_and_area(*i).0).collect();
        drop(patches);
        for (i, x) in free.iter().zip(moved) {
            if region.shape.contains(&x) {
                points[*i] = x;
            }
        }
    }
}

#[cfg(test)]
mod tests;
