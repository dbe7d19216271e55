//! Shapes and their boolean combinations.

mod boundary_edges;
pub(crate) mod boundary_points;
pub(crate) mod box_classification;
pub(crate) mod microstructure;
mod terrain_layers;
mod volume;

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::plan::polygon::{PolygonVertices, polygon_crossings, signed_area};
pub(crate) use crate::shape::boundary_edges::{BoundaryEdge, PlanePoint, SectorMoments};
use crate::shape::microstructure::{CachedPacking, MicrostructureSpec, SpherePacking, sphere_count_error};
use crate::terrain::layer_options::{LayerRows, LayerThickness, ThicknessDirection};
use crate::terrain::terrain_layer::PlacedLayer;

/// Region of space. In 2D the third coordinate is not used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Shape {
    /// Axis-aligned box (1D interval, 2D rectangle).
    Box {
        /// Lower corner (m).
        min: Vec<f64>,
        /// Upper corner (m).
        max: Vec<f64>,
    },
    /// Ball (disk in 2D).
    Ball {
        /// Centre (m).
        centre: Vec<f64>,
        /// Radius (m), positive.
        radius: f64,
    },
    /// Polygon in 2D, without crossings, in either sense.
    Polygon {
        /// Corners (m), at least three.
        #[schemars(with = "Vec<[f64; 2]>")]
        vertices: PolygonVertices,
    },
    /// Upright cylinder in 3D.
    Cylinder {
        /// Centre of the lower face (m).
        base: [f64; 3],
        /// Axis: 0 is x.
        axis: usize,
        /// Radius (m), positive.
        radius: f64,
        /// Height along the axis (m), positive.
        height: f64,
    },
    /// Layer on terrain in 3D, as a map's release area; for bodies only.
    Layer {
        /// Raster obstacle below the layer.
        on: String,
        /// Outline in plan (m), GeoJSON or shapefile: all features; their holes are cut out. When absent the layer is where its raster is above zero.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        outline: Option<String>,
        /// Layer thickness (m).
        thickness: LayerThickness,
        /// Direction of thickness.
        #[serde(default)]
        measured: ThicknessDirection,
        /// Rows of points set on a lattice.
        #[serde(default, skip_serializing_if = "LayerRows::are_level")]
        rows: LayerRows,
        /// Layer built from its files; empty before they are read.
        #[serde(skip)]
        laid: PlacedLayer,
    },
    /// Region in 2D along an obstacle's line, between two lengths and distances; for bodies only.
    ArcLayer {
        /// Obstacle, a `profile`, or a `ground-line` with its points in the case.
        on: String,
        /// Length along the line to the start (m), non-negative.
        #[serde(default)]
        start: f64,
        /// Length along the line to the end (m).
        end: f64,
        /// Distance of the lower side from the line, outward (m).
        #[serde(default)]
        from: f64,
        /// Distance of the upper side (m).
        to: f64,
        /// Rows of points set on a lattice.
        #[serde(default, skip_serializing_if = "LayerRows::are_level")]
        rows: LayerRows,
        /// Its corners (m), once the obstacle is looked at: those along its lower side, then as many along its upper side, back.
        #[serde(skip)]
        outline: PolygonVertices,
    },
    /// Box of overlapping equal balls (2D discs), as sintered ice of snow. Not in 1D.
    Microstructure {
        /// Lower corner of the box (m).
        min: Vec<f64>,
        /// Upper corner (m).
        max: Vec<f64>,
        /// Ball diameter (m), less than the width of the box.
        diameter: f64,
        /// Solid share, above 0, at most 0.95. Random discs connect from 0.68 on, balls from 0.29.
        solid_fraction: f64,
        /// Seed of ball positions.
        #[serde(default)]
        seed: u64,
        /// Whether only mutually connected balls are kept.
        #[serde(default = "default_true")]
        connected: bool,
        /// The balls, once they are asked for.
        #[serde(skip)]
        grains: CachedPacking,
    },
    /// Points in any of the shapes.
    Union {
        /// The shapes.
        shapes: Vec<Shape>,
    },
    /// Points in all of the shapes.
    Intersection {
        /// The shapes.
        shapes: Vec<Shape>,
    },
    /// Points of one shape outside another.
    Difference {
        /// Shape that is cut.
        from: Box<Shape>,
        /// Removed shape.
        cut: Box<Shape>,
    },
}

/// Default of an option that is on.
fn default_true() -> bool {
    true
}

/// Error in the values of a shape.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{path}: {problem}")]
pub struct ShapeError {
    /// Path from the shape to the value, e.g. `shapes[1].radius`.
    pub path: String,
    /// Description of the error.
    pub problem: String,
}

impl ShapeError {
    /// Error at a key of a shape.
    fn new(path: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { path: path.into(), problem: problem.into() }
    }

    /// Error with the key of an enclosing shape before its path.
    fn under_path(mut self, parent: &str) -> Self {
        self.path = format!("{parent}.{}", self.path);
        self
    }
}

/// Checks that a position has as many finite coordinates as the space has axes.
fn check_point(name: &str, point: &[f64], dimension: usize) -> Result<(), ShapeError> {
    if point.len() != dimension {
        let problem = format!("has {} coordinates, the space has {dimension}", point.len());
        return Err(ShapeError::new(name, problem));
    }
    match point.iter().position(|c| !c.is_finite()) {
        Some(axis) => Err(ShapeError::new(format!("{name}[{axis}]"), "must be finite (m)")),
        None => Ok(()),
    }
}

/// Checks that a length is finite and positive (m).
fn check_length(name: &str, length: f64) -> Result<(), ShapeError> {
    if length.is_finite() && length > 0.0 {
        Ok(())
    } else {
        Err(ShapeError::new(name, format!("{length} must be finite and positive (m)")))
    }
}

impl Shape {
    /// Checks the shape for a space of `dimension` coordinates.
    ///
    /// # Errors
    /// The first invalid value: number of coordinates, order of corners, sign of a length, a polygon without area or with crossing edges,
    /// an empty combination.
    pub fn validate(&self, dimension: usize) -> Result<(), ShapeError> {
        match self {
            Self::Box { min, max } => {
                check_point("min", min, dimension)?;
                check_point("max", max, dimension)?;
                match (0..dimension).find(|&axis| min[axis] >= max[axis]) {
                    Some(axis) => {
                        let problem = format!("{} must be above min, {}", max[axis], min[axis]);
                        Err(ShapeError::new(format!("max[{axis}]"), problem))
                    }
                    None => Ok(()),
                }
            }
            Self::Ball { centre, radius } => {
                check_point("centre", centre, dimension)?;
                check_length("radius", *radius)
            }
            Self::Polygon { vertices } => validate_polygon(vertices, dimension),
            Self::Cylinder { base, axis, radius, height } => {
                check_point("base", base, dimension)?;
                if *axis > 2 {
                    return Err(ShapeError::new("axis", format!("{axis} is not in 0..=2")));
                }
                check_length("radius", *radius)?;
                check_length("height", *height)
            }
            Self::Microstructure { .. } => self.validate_microstructure(dimension),
            Self::ArcLayer { .. } => self.validate_arc_layer(dimension),
            Self::Layer { thickness, .. } => match thickness {
                _ if dimension != 3 => {
                    let problem = format!(
                        "a layer needs three dimensions, the space has {dimension}: in the plane `arc-layer` follows an obstacle"
                    );
                    Err(ShapeError::new("kind", problem))
                }
                LayerThickness::Uniform(thickness) => check_length("thickness", *thickness),
                LayerThickness::Raster(_) | LayerThickness::Attribute(_) => Ok(()),
            },
            Self::Union { shapes } | Self::Intersection { shapes } => {
                if shapes.is_empty() {
                    return Err(ShapeError::new("shapes", "must hold at least one shape"));
                }
                for (number, shape) in shapes.iter().enumerate() {
                    shape.validate(dimension).map_err(|e| e.under_path(&format!("shapes[{number}]")))?;
                }
                Ok(())
            }
            Self::Difference { from, cut } => {
                from.validate(dimension).map_err(|e| e.under_path("from"))?;
                cut.validate(dimension).map_err(|e| e.under_path("cut"))
            }
        }
    }

    /// Checks the arc lengths and heights of a layer along a ground line.
    fn validate_arc_layer(&self, dimension: usize) -> Result<(), ShapeError> {
        let Self::ArcLayer { start, end, from, to, .. } = self else { return Ok(()) };
        if dimension != 2 {
            let problem = format!("an arc-layer needs two dimensions, the space has {dimension}");
            return Err(ShapeError::new("kind", problem));
        }
        let not_negative = start.is_finite() && *start >= 0.0;
        for (key, value, holds, rule) in [
            ("start", start, not_negative, "not be negative".to_owned()),
            ("end", end, end.is_finite() && end > start, format!("be above start, {start}")),
            ("from", from, from.is_finite(), "be finite".to_owned()),
            ("to", to, to.is_finite() && to > from, format!("be above from, {from}")),
        ] {
            if !holds {
                return Err(ShapeError::new(key, format!("{value} must {rule} (m)")));
            }
        }
        Ok(())
    }

    /// Checks the box, grain diameter and solid fraction of a microstructure.
    fn validate_microstructure(&self, dimension: usize) -> Result<(), ShapeError> {
        let Self::Microstructure { min, max, diameter, solid_fraction, .. } = self else { return Ok(()) };
        if dimension == 1 {
            return Err(ShapeError::new("kind", "a microstructure needs two or three dimensions"));
        }
        Self::Box { min: min.clone(), max: max.clone() }.validate(dimension)?;
        check_length("diameter", *diameter)?;
        let narrow = (0..dimension).map(|c| max[c] - min[c]).fold(f64::INFINITY, f64::min);
        if *diameter >= narrow {
            let problem = format!("{diameter} must be less than the width of the box, {narrow} m");
            return Err(ShapeError::new("diameter", problem));
        }
        if !(*solid_fraction > 0.0 && *solid_fraction <= 0.95) {
            let problem = format!("{solid_fraction} is not between 0 and 0.95 (0 excluded)");
            return Err(ShapeError::new("solid_fraction", problem));
        }
        if let Some(problem) = sphere_count_error(min, max, *diameter, *solid_fraction) {
            return Err(ShapeError::new("diameter", problem));
        }
        if self.packing().is_none() {
            let problem = "no connected arrangement of so few balls was found: increase solid_fraction, or \
                           set connected to false";
            return Err(ShapeError::new("solid_fraction", problem));
        }
        Ok(())
    }

    /// Packing of a microstructure.
    fn packing(&self) -> Option<Arc<SpherePacking>> {
        let Self::Microstructure { min, max, diameter, solid_fraction, seed, connected, grains } = self
        else {
            return None;
        };
        let (diameter, fraction, seed, connected) = (*diameter, *solid_fraction, *seed, *connected);
        grains.packing(&MicrostructureSpec { min, max, diameter, fraction, seed, connected })
    }

    /// Whether `point` lies in the shape, its boundary included.
    pub fn contains(&self, point: &[f64]) -> bool {
        match self {
            Self::Box { min, max } => {
                point.iter().zip(min).zip(max).all(|((x, low), high)| low <= x && x <= high)
            }
            Self::Ball { centre, radius } => {
                let square: f64 = point.iter().zip(centre).map(|(x, c)| (x - c).powi(2)).sum();
                square <= radius * radius
            }
            Self::Polygon { vertices } | Self::ArcLayer { outline: vertices, .. } => vertices.contains(point),
            Self::Cylinder { base, axis, radius, height } => {
                let along = point[*axis] - base[*axis];
                let across: f64 = (0..3).filter(|c| c != axis).map(|c| (point[c] - base[c]).powi(2)).sum();
                (0.0..=*height).contains(&along) && across <= radius * radius
            }
            Self::Microstructure { min, max, .. } => {
                let inside = |c: usize| (min[c]..=max[c]).contains(&point[c]);
                (0..min.len()).all(inside)
                    && self.packing().is_some_and(|packing| packing.contains(&relative_to_corner(min, point)))
            }
            Self::Layer { laid, .. } => laid.contains(point),
            Self::Union { shapes } => shapes.iter().any(|shape| shape.contains(point)),
            Self::Intersection { shapes } => shapes.iter().all(|shape| shape.contains(point)),
            Self::Difference { from, cut } => from.contains(point) && !cut.contains(point),
        }
    }

    /// Lower and upper corner of the bounding box of a valid shape (m).
    pub fn bounds(&self, dimension: usize) -> (Vec<f64>, Vec<f64>) {
        match self {
            Self::Box { min, max } | Self::Microstructure { min, max, .. } => (min.clone(), max.clone()),
            Self::Ball { centre, radius } => {
                (centre.iter().map(|c| c - radius).collect(), centre.iter().map(|c| c + radius).collect())
            }
            Self::Polygon { vertices } | Self::ArcLayer { outline: vertices, .. } => {
                let fold = |start: f64, pick: fn(f64, f64) -> f64| -> Vec<f64> {
                    (0..2).map(|c| vertices.iter().map(|v| v[c]).fold(start, pick)).collect()
                };
                (fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max))
            }
            Self::Cylinder { base, axis, radius, height } => {
                let low = |c: usize| if c == *axis { base[c] } else { base[c] - radius };
                let high = |c: usize| if c == *axis { base[c] + height } else { base[c] + radius };
                ((0..3).map(low).collect(), (0..3).map(high).collect())
            }
            Self::Layer { laid, .. } => laid.bounds(),
            Self::Union { shapes } => combine(shapes, dimension, f64::min, f64::max),
            Self::Intersection { shapes } => combine(shapes, dimension, f64::max, f64::min),
            Self::Difference { from, .. } => from.bounds(dimension),
        }
    }

    /// Smallest extent of the shape (m): along an axis, across a layer, or of one sphere of a packing.
    pub fn min_thickness(&self, dimension: usize) -> f64 {
        let (low, high) = self.bounds(dimension);
        let along = low.iter().zip(&high).map(|(low, high)| high - low).fold(f64::INFINITY, f64::min);
        match self {
            Self::ArcLayer { from, to, .. } => along.min(to - from),
            Self::Layer { thickness: LayerThickness::Uniform(thickness), .. } => along.min(*thickness),
            Self::Microstructure { diameter, .. } => along.min(*diameter),
            _ => along,
        }
    }

    /// Coordinates along an axis (m) at which the line through `point` parallel to that axis may enter or leave a valid shape, unsorted.
    /// Between two neighbouring ones the line is entirely inside or outside.
    pub fn crossings(&self, point: &[f64], axis: usize) -> Vec<f64> {
        match self {
            Self::Box { min, max } => vec![min[axis], max[axis]],
            Self::Ball { centre, radius } => {
                let across = centre.iter().zip(point).enumerate().filter(|(c, _)| *c != axis);
                circle_crossings(centre[axis], *radius, across.map(|(_, (c, x))| (x - c).powi(2)).sum())
            }
            Self::Polygon { vertices } | Self::ArcLayer { outline: vertices, .. } => {
                polygon_crossings(vertices, point, axis)
            }
            Self::Cylinder { base, axis: own, height, .. } if *own == axis => {
                vec![base[axis], base[axis] + height]
            }
            Self::Cylinder { base, axis: own, radius, .. } => {
                let across = (0..3).filter(|c| *c != axis && c != own);
                circle_crossings(base[axis], *radius, across.map(|c| (point[c] - base[c]).powi(2)).sum())
            }
            Self::Microstructure { min, max, .. } => {
                let place = relative_to_corner(min, point);
                let balls = self.packing().map_or(Vec::new(), |packing| packing.crossings(&place, axis));
                let inside = balls.into_iter().map(|x| (min[axis] + x).clamp(min[axis], max[axis]));
                inside.chain([min[axis], max[axis]]).collect()
            }
            Self::Layer { laid, .. } => laid.crossings(point, axis),
            Self::Union { shapes } | Self::Intersection { shapes } => {
                shapes.iter().flat_map(|shape| shape.crossings(point, axis)).collect()
            }
            Self::Difference { from, cut } => {
                let mut all = from.crossings(point, axis);
                all.extend(cut.crossings(point, axis));
                all
            }
        }
    }
}

/// Coordinates at which a line crosses a circle or sphere. `square` is the squared distance of the line from the centre (m²).
fn circle_crossings(centre: f64, radius: f64, square: f64) -> Vec<f64> {
    let half = (radius * radius - square).max(0.0).sqrt();
    vec![centre - half, centre + half]
}

/// Position relative to the lower corner of a box (m), with three components.
fn relative_to_corner(min: &[f64], point: &[f64]) -> [f64; 3] {
    let mut place = [0.0; 3];
    min.iter().zip(point).enumerate().for_each(|(c, (low, x))| place[c] = x - low);
    place
}

/// Bounds of a combination of shapes, from the bounds of its parts by the functions `low` and `high`.
fn combine(
    shapes: &[Shape],
    dimension: usize,
    low: fn(f64, f64) -> f64,
    high: fn(f64, f64) -> f64,
) -> (Vec<f64>, Vec<f64>) {
    let all = shapes.iter().map(|shape| shape.bounds(dimension));
    let merge = |a: (Vec<f64>, Vec<f64>), b: (Vec<f64>, Vec<f64>)| {
        let join = |a: &[f64], b: &[f64], pick: fn(f64, f64) -> f64| -> Vec<f64> {
            a.iter().zip(b).map(|(a, b)| pick(*a, *b)).collect()
        };
        (join(&a.0, &b.0, low), join(&a.1, &b.1, high))
    };
    all.reduce(merge).unwrap_or_else(|| (vec![0.0; dimension], vec![0.0; dimension]))
}

/// Checks the number, coordinates and order of the vertices of a polygon.
fn validate_polygon(vertices: &PolygonVertices, dimension: usize) -> Result<(), ShapeError> {
    let count = vertices.len();
    if dimension != 2 {
        return Err(ShapeError::new(
            "kind",
            format!("a polygon needs two dimensions, the space has {dimension}"),
        ));
    }
    if count < 3 {
        return Err(ShapeError::new(
            "vertices",
            format!("{count} corners are too few, at least three are needed"),
        ));
    }
    for (number, vertex) in vertices.iter().enumerate() {
        check_point(&format!("vertices[{number}]"), vertex, 2)?;
    }
    if signed_area(vertices) == 0.0 {
        return Err(ShapeError::new("vertices", "the polygon has no area"));
    }
    vertices.crossing_edges().map_or(Ok(()), |(i, j)| {
        Err(ShapeError::new("vertices", format!("the edges from corner {i} and from corner {j} cross")))
    })
}

#[cfg(test)]
mod tests;
