//! Sampling shapes with points.

mod fitted;
mod gauss;
mod poisson;
mod terrain_rows;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{LayerRows, Shape};

pub use fitted::fitted_rows;
pub use gauss::gauss_per_cell;
pub use poisson::{poisson_disk, poisson_spaced};

/// Largest number of candidate points. More would not fit in memory.
const MAX_CANDIDATES: f64 = (1u64 << 28) as f64;

/// Sampling point with its share of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<const D: usize> {
    /// Position of the point (m).
    pub position: [f64; D],
    /// Length, area or volume of the part of the shape that the point represents (m, m² or m³).
    pub volume: f64,
}

/// Point arrangement in a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Sampling {
    /// Lattice of the method, any shape; round and oblique sides are stepped.
    #[default]
    Lattice,
    /// Rows along the sides, in the plane, for boxes, balls, polygons and combinations. The first is half a spacing inside; points are at
    /// their patches' centres, with exact area. Rows of round sides come first; the lattice fills the rest.
    Fitted,
    /// Random positions (Poisson disk), by `sampling_seed`, without lattice directions: no two points closer than a distance, no further
    /// point fits. They are as many as on a lattice, of equal volume.
    PoissonDisk,
}

impl Sampling {
    /// Whether it is the lattice, the default without an entry in a case.
    #[allow(clippy::trivially_copy_pass_by_ref, reason = "serde requires a reference")]
    pub fn is_lattice(&self) -> bool {
        *self == Self::Lattice
    }
}

/// Error in the sampling of a shape.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SamplingError {
    /// Number of points above the limit.
    #[error("the sampling would need about {0:.2e} points, more than 2^28: use a larger spacing")]
    TooMany(f64),
    /// Spacing that is not a length.
    #[error("spacing {0} must be finite and positive (m)")]
    Spacing(f64),
    /// Shape whose area or volume is not known in closed form.
    #[error("random sampling needs a simple shape whose area or volume is known, not a combination")]
    NoMeasure,
    /// Shape that is no combination of boxes, balls and polygons in the plane.
    #[error(
        "rows are fitted to boxes, balls and polygons in the plane, and to their combinations, with 2000 \
         sides at most"
    )]
    NoBoundaryEdges,
    /// Shape with parts that no point is near to.
    #[error("parts of the shape, {:.1e} of its area, are too thin for points {spacing} m apart: use a smaller spacing", lost.abs())]
    TooThin {
        /// The spacing (m).
        spacing: f64,
        /// Share of the area that no point represents.
        lost: f64,
    },
}

impl SamplingError {
    /// Stable code of the error, which `docs/messages.md` of the repository explains.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::TooMany(_) => "too-many-points",
            Self::TooThin { .. } => "too-thin-to-sample",
            Self::Spacing(_) | Self::NoMeasure | Self::NoBoundaryEdges => "sampling",
        }
    }
}

/// Samples a shape with `per_cell` points per direction in every cell of a grid with lower corner `origin` (m) and cell edge `cell` (m), at
/// `(i + 1/2) / per_cell` of the cell: those that lie in the shape, last axis fastest.
///
/// # Errors
/// When there would be more than 2²⁸ candidates, or the spacing is not a length.
pub fn per_cell<const D: usize>(
    shape: &Shape,
    origin: [f64; D],
    cell: f64,
    per_cell: usize,
) -> Result<Vec<Sample<D>>, SamplingError> {
    lattice(shape, origin, cell / per_cell as f64)
}

/// Samples a shape with a square lattice of the given `spacing` (m), whose first point is at half a spacing from `origin`. Only points in
/// the shape are kept; the last axis varies fastest. In a layer whose rows follow the terrain the points are on the lattice in plan only,
/// and along a line they follow the layer.
///
/// # Errors
/// When there would be more than 2²⁸ candidates, or the spacing is not a length.
pub fn lattice<const D: usize>(
    shape: &Shape,
    origin: [f64; D],
    spacing: f64,
) -> Result<Vec<Sample<D>>, SamplingError> {
    if let Shape::Layer { rows: LayerRows::Terrain, laid, .. } = shape
        && let Some(layer) = laid.layer()
    {
        return terrain_rows::sample_along_terrain(
            &CandidateCells::around_shape(shape, origin, spacing, 1.0)?,
            layer,
            origin,
            spacing,
        );
    }
    if let Shape::ArcLayer { rows: LayerRows::Terrain, outline, .. } = shape {
        CandidateCells::around_shape(shape, origin, spacing, 1.0)?;
        return Ok(terrain_rows::sample_along_line(outline, spacing));
    }
    let volume = spacing.powi(D as i32);
    let centre =
        |cell: [i64; D]| std::array::from_fn(|axis| origin[axis] + (cell[axis] as f64 + 0.5) * spacing);
    let positions = CandidateCells::around_shape(shape, origin, spacing, 1.0)?.indices().map(centre);
    Ok(positions.filter(|x| shape.contains(x)).map(|position| Sample { position, volume }).collect())
}

/// Cells of a grid that may overlap a shape, with their edge (m) and their indices from an origin.
struct CandidateCells<const D: usize> {
    first: [i64; D],
    count: [i64; D],
    total: i64,
}

impl<const D: usize> CandidateCells<D> {
    /// Cells around `shape`. Rejected when `per_cell` points in each would be more than 2²⁸.
    fn around_shape(
        shape: &Shape,
        origin: [f64; D],
        edge: f64,
        per_cell: f64,
    ) -> Result<Self, SamplingError> {
        if !(edge.is_finite() && edge > 0.0) {
            return Err(SamplingError::Spacing(edge));
        }
        let (low, high) = shape.bounds(D);
        let (mut first, mut count, mut total) = ([0; D], [0; D], 1.0);
        for axis in 0..D {
            let start = ((low[axis] - origin[axis]) / edge - 1.0).floor();
            let end = ((high[axis] - origin[axis]) / edge + 1.0).ceil();
            total *= (end - start).max(0.0);
            first[axis] = start as i64;
            count[axis] = (end - start).max(0.0) as i64;
        }
        if total * per_cell > MAX_CANDIDATES {
            return Err(SamplingError::TooMany(total * per_cell));
        }
        Ok(Self { first, count, total: total as i64 })
    }

    /// Indices of the cells, last axis fastest.
    fn indices(self) -> impl Iterator<Item = [i64; D]> {
        (0..self.total).map(move |number| {
            let mut rest = number;
            let mut cell = [0; D];
            for axis in (0..D).rev() {
                cell[axis] = self.first[axis] + rest % self.count[axis];
                rest /= self.count[axis];
            }
            cell
        })
    }
}

/// Samples a shape with `count` uniformly distributed random points, reproducible by the `seed`.
///
/// # Errors
/// For shapes without a known area or volume.
pub fn random<const D: usize>(
    shape: &Shape,
    count: usize,
    seed: u64,
) -> Result<Vec<Sample<D>>, SamplingError> {
    let measure = shape.measure(D).ok_or(SamplingError::NoMeasure)?;
    let (low, high) = shape.bounds(D);
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let volume = measure / count as f64;
    let mut samples = Vec::with_capacity(count);
    while samples.len() < count {
        let position = std::array::from_fn(|axis| generator.random_range(low[axis]..high[axis]));
        if shape.contains(&position) {
            samples.push(Sample { position, volume });
        }
    }
    Ok(samples)
}

/// Position strictly inside both shapes, if a search with about `resolution` points per direction finds one. Shapes that only touch do not
/// overlap.
pub fn common_interior_point(a: &Shape, b: &Shape, dimension: usize, resolution: usize) -> Option<Vec<f64>> {
    let ((low_a, high_a), (low_b, high_b)) = (a.bounds(dimension), b.bounds(dimension));
    let low: Vec<f64> = low_a.iter().zip(&low_b).map(|(a, b)| a.max(*b)).collect();
    let high: Vec<f64> = high_a.iter().zip(&high_b).map(|(a, b)| a.min(*b)).collect();
    let extent = |axis: usize| (high_a[axis] - low_a[axis]).min(high_b[axis] - low_b[axis]);
    if (0..dimension).any(|axis| high[axis] - low[axis] <= 1e-9 * extent(axis)) {
        return None;
    }
    let count = resolution.pow(dimension as u32);
    let place = |number: usize| -> Vec<f64> {
        let mut rest = number;
        let coordinate = |axis: usize| {
            let step = (rest % resolution) as f64 + 0.5;
            rest /= resolution;
            low[axis] + (high[axis] - low[axis]) * step / resolution as f64
        };
        (0..dimension).map(coordinate).collect()
    };
    let inside = |place: &[f64]| a.contains(place) && b.contains(place);
    // Round-off may put a position on a common face into both shapes; the positions beside it are not in both.
    let well_inside = |place: &[f64]| {
        let beside = |axis: usize, side: f64| {
            let mut beside = place.to_vec();
            beside[axis] += side * 1e-9 * extent(axis);
            inside(&beside)
        };
        (0..dimension).all(|axis| beside(axis, -1.0) && beside(axis, 1.0))
    };
    (0..count).map(place).find(|place| inside(place) && well_inside(place))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn disk(radius: f64) -> Shape {
        Shape::Ball { centre: vec![0.0, 0.0], radius }
    }

    #[test]
    fn a_box_of_whole_cells_is_filled_exactly() {
        let shape = Shape::Box { min: vec![0.2, 0.1, 0.0], max: vec![0.5, 0.4, 0.2] };
        let samples = per_cell(&shape, [0.0; 3], 0.1, 2).unwrap();
        assert_eq!(samples.len(), 3 * 3 * 2 * 8);
        let volume: f64 = samples.iter().map(|s| s.volume).sum();
        assert!((volume - 0.3 * 0.3 * 0.2).abs() < 1e-14);
    }

    #[test]
    fn the_area_of_a_disk_converges() {
        let error = |spacing: f64| {
            let samples = lattice(&disk(1.0), [0.0; 2], spacing).unwrap();
            (samples.iter().map(|s| s.volume).sum::<f64>() - std::f64::consts::PI).abs()
        };
        assert!(error(0.005) < 2e-3 && error(0.1) < 0.1);
    }

    #[test]
    fn random_samples_repeat_with_their_seed_and_carry_the_whole_area() {
        let sample = |seed| random::<2>(&disk(2.0), 500, seed).unwrap();
        assert_eq!(sample(7), sample(7));
        assert_ne!(sample(7), sample(8));
        let area: f64 = sample(7).iter().map(|s| s.volume).sum();
        assert!((area - 4.0 * std::f64::consts::PI).abs() < 1e-9);
    }

    #[test]
    fn layers_on_a_slope_that_share_a_side_do_not_overlap() {
        // Round-off puts search positions on the common face into both.
        let length = 1.5f64.hypot(3.0);
        let along = [3.0 / length, -1.5 / length];
        let at = |s: f64, n: f64| [-0.5 + s * along[0] - n * along[1], 0.5 + s * along[1] + n * along[0]];
        let layer = |from: f64, to: f64| Shape::Polygon {
            vertices: [at(0.5, from), at(2.5, from), at(2.5, to), at(0.5, to)].to_vec().into(),
        };
        assert_eq!(common_interior_point(&layer(0.0, 0.075), &layer(0.075, 0.4), 2, 24), None);
        assert!(common_interior_point(&layer(0.0, 0.08), &layer(0.075, 0.4), 2, 24).is_some());
    }

    #[test]
    fn touching_shapes_do_not_overlap() {
        let a = Shape::Box { min: vec![0.0, 0.0], max: vec![1.0, 1.0] };
        let b = Shape::Box { min: vec![1.0, 0.0], max: vec![2.0, 1.0] };
        let c = Shape::Box { min: vec![0.9, 0.5], max: vec![2.0, 1.0] };
        assert_eq!(common_interior_point(&a, &b, 2, 20), None);
        let place = common_interior_point(&a, &c, 2, 20).unwrap();
        assert!(a.contains(&place) && c.contains(&place));
    }

    #[test]
    fn too_fine_a_lattice_is_refused() {
        assert!(matches!(lattice(&disk(1.0), [0.0; 2], 1e-6), Err(SamplingError::TooMany(_))));
        assert!(matches!(lattice(&disk(1.0), [0.0; 2], f64::NAN), Err(SamplingError::Spacing(_))));
    }

    proptest! {
        #[test]
        fn samples_lie_in_the_shape_and_on_the_lattice(radius in 0.2..2.0f64, spacing in 0.05..0.3f64) {
            for sample in lattice(&disk(radius), [0.1, -0.2], spacing).unwrap() {
                prop_assert!(disk(radius).contains(&sample.position));
                let steps = (sample.position[0] - 0.1) / spacing - 0.5;
                prop_assert!((steps - steps.round()).abs() < 1e-9);
            }
        }
    }
}
