//! Poisson-disk sampling.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{CandidateCells, Sample, SamplingError};
use crate::Shape;
use crate::shape::box_classification::BoxLocation;

/// Number of halvings of the uncovered cells. The remaining cells are then smaller than a thousandth of the distance.
const SUBDIVISION_LEVELS: u32 = 10;

/// Number of trial points in each uncovered cell at each halving.
const DARTS_PER_CELL: usize = 2;

/// Number of uncovered cells, over that at the start, at which the search ends. Only boundaries between the parts of a combination, which
/// [`Shape::classify_box`] cannot resolve, lead to so many.
const MAX_GROWTH: usize = 16;

/// Samples a shape with random points of which no two are closer than `distance` (m), until no further point fits. The result is
/// reproducible by the `seed`. Cells are visited in order, last axis fastest, and every point represents the same share of the measure of
/// the shape (for combinations, of an estimate within about a thousandth).
///
/// Darts are thrown at the grid cells that no disk covers; uncovered cells are halved, and darts are thrown again (Ebeida, Mitchell,
/// Patney, Davidson & Owens 2012, Computer Graphics Forum 31, 785–794).
///
/// # Errors
/// When there would be more than 2²⁸ candidates, or the distance is not a length.
pub fn poisson_disk<const D: usize>(
    shape: &Shape,
    distance: f64,
    seed: u64,
) -> Result<Vec<Sample<D>>, SamplingError> {
    if !(distance.is_finite() && distance > 0.0) {
        return Err(SamplingError::Spacing(distance));
    }
    let mut disks = Disks::new(shape, distance)?;
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let mut open = disks.all_cells(shape);
    let largest = MAX_GROWTH * open.len() + 1000;
    for level in 0..=SUBDIVISION_LEVELS {
        for _ in 0..DARTS_PER_CELL * open.len() {
            let cell = &open[generator.random_range(0..open.len())];
            let (low, edge) = disks.corner(cell, level);
            let dart = std::array::from_fn(|axis| low[axis] + edge * generator.random::<f64>());
            if shape.contains(&dart) {
                disks.add(dart);
            }
        }
        if level < SUBDIVISION_LEVELS {
            open = disks.subdivide_uncovered(shape, &open, level);
        }
        if open.is_empty() || open.len() > largest {
            break;
        }
    }
    let positions: Vec<[f64; D]> = disks.points.into_iter().flatten().collect();
    let volume = shape_measure::<D>(shape)? / positions.len().max(1) as f64;
    Ok(positions.into_iter().map(|position| Sample { position, volume }).collect())
}

/// Number of points per length, area or volume at jamming of random sequential adsorption, for a least distance of one (1D: Rényi 1958; 2D
/// and 3D: Torquato, Uche & Stillinger 2006, Phys. Rev. E 74, 061308, with coverings 0.547 and 0.384).
const JAMMING_DENSITY: [f64; 3] = [0.7476, 0.6965, 0.7336];

/// Relative tolerance of the number of points.
const COUNT_TOLERANCE: f64 = 0.01;

/// Largest number of repetitions of the sampling until the number of points is within the tolerance.
const MAX_PASSES: usize = 6;

/// Samples a shape as [`poisson_disk`] does, with about as many points as a lattice of this `spacing` (m) has. The distance is that of
/// jamming, then adjusted, since the density of points is higher at the boundary than within.
///
/// # Errors
/// See [`poisson_disk`].
pub fn poisson_spaced<const D: usize>(
    shape: &Shape,
    spacing: f64,
    seed: u64,
) -> Result<Vec<Sample<D>>, SamplingError> {
    let wanted = shape_measure::<D>(shape)? / spacing.powi(D as i32);
    let root = 1.0 / D as f64;
    let mut distance = spacing * JAMMING_DENSITY[D - 1].powf(root);
    let mut samples = poisson_disk(shape, distance, seed)?;
    for _ in 1..MAX_PASSES {
        let ratio = samples.len() as f64 / wanted;
        if samples.is_empty() || (ratio - 1.0).abs() <= COUNT_TOLERANCE.max(0.5 / wanted) {
            break;
        }
        distance *= ratio.powf(root);
        samples = poisson_disk(shape, distance, seed)?;
    }
    Ok(samples)
}

/// Length, area or volume of a shape (m, m² or m³): in closed form, or counted on a lattice of about a million cells.
fn shape_measure<const D: usize>(shape: &Shape) -> Result<f64, SamplingError> {
    if let Some(measure) = shape.measure(D) {
        return Ok(measure);
    }
    /// Approximate number of lattice cells in the bounding box of the shape.
    const CELLS: f64 = 1e6;
    let (low, high) = shape.bounds(D);
    let all: f64 = low.iter().zip(&high).map(|(low, high)| high - low).product();
    let samples =
        super::lattice::<D>(shape, std::array::from_fn(|c| low[c]), (all / CELLS).powf(1.0 / D as f64))?;
    Ok(samples.iter().map(|sample| sample.volume).sum())
}

/// Centres of disks of equal radius, on a grid whose cells contain at most one centre.
struct Disks<const D: usize> {
    low: [f64; D],
    edge: f64,
    count: [usize; D],
    distance: f64,
    points: Vec<Option<[f64; D]>>,
}

impl<const D: usize> Disks<D> {
    /// Empty Poisson-disk sample of a shape, on a grid of cells that hold one point each.
    fn new(shape: &Shape, distance: f64) -> Result<Self, SamplingError> {
        let (low, _) = shape.bounds(D);
        let low: [f64; D] = std::array::from_fn(|axis| low[axis]);
        let edge = distance / (D as f64).sqrt();
        // One cell of margin at either end: no dart falls outside.
        let cells = CandidateCells::around_shape(shape, low, edge, 1.0)?;
        Ok(Self {
            low: std::array::from_fn(|axis| low[axis] + cells.first[axis] as f64 * edge),
            edge,
            count: cells.count.map(|count| count as usize),
            distance,
            points: vec![None; cells.total as usize],
        })
    }

    /// All cells that may contain a point of the shape.
    fn all_cells(&self, shape: &Shape) -> Vec<[u32; D]> {
        let index = |number: usize| {
            let mut rest = number;
            let mut cell = [0; D];
            for axis in (0..D).rev() {
                cell[axis] = (rest % self.count[axis]) as u32;
                rest /= self.count[axis];
            }
            cell
        };
        (0..self.points.len()).map(index).filter(|cell| self.cell_meets_shape(shape, cell, 0)).collect()
    }

    /// Lower corner and edge (m) of a cell that has been halved `level` times.
    fn corner(&self, cell: &[u32; D], level: u32) -> ([f64; D], f64) {
        let edge = self.edge / f64::from(1u32 << level);
        (std::array::from_fn(|axis| self.low[axis] + f64::from(cell[axis]) * edge), edge)
    }

    /// Whether a cell of a refinement level has a part inside the shape.
    fn cell_meets_shape(&self, shape: &Shape, cell: &[u32; D], level: u32) -> bool {
        let (low, edge) = self.corner(cell, level);
        shape.classify_box(&low, &low.map(|l| l + edge)) != BoxLocation::Outside
    }

    /// Whether `visit` is true for one of the centres in the cells that a disk around `x` overlaps.
    fn any_centre_near(&self, x: &[f64; D], visit: impl Fn(&[f64; D]) -> bool) -> bool {
        let reach = (D as f64).sqrt().ceil() as i64;
        let width = 2 * reach + 1;
        let home: [i64; D] = std::array::from_fn(|axis| ((x[axis] - self.low[axis]) / self.edge) as i64);
        (0..width.pow(D as u32)).any(|number| {
            let (mut rest, mut slot) = (number, 0);
            for axis in 0..D {
                let index = home[axis] + rest % width - reach;
                rest /= width;
                if index < 0 || index >= self.count[axis] as i64 {
                    return false;
                }
                slot = slot * self.count[axis] + index as usize;
            }
            self.points[slot].as_ref().is_some_and(&visit)
        })
    }

    /// Adds the centre `x` unless another centre is closer than the distance.
    fn add(&mut self, x: [f64; D]) {
        let square = self.distance * self.distance;
        let close = |other: &[f64; D]| (0..D).map(|c| (x[c] - other[c]).powi(2)).sum::<f64>() < square;
        if self.any_centre_near(&x, close) {
            return;
        }
        let slot = (0..D).fold(0, |slot, axis| {
            let index = ((x[axis] - self.low[axis]) / self.edge) as usize;
            slot * self.count[axis] + index.min(self.count[axis] - 1)
        });
        // Two centres in one cell can only be its opposite corners, to the last bit; the first is kept.
        self.points[slot].get_or_insert(x);
    }

    /// Halves the edges of uncovered cells, and returns the parts that the shape may touch and that no single disk covers.
    fn subdivide_uncovered(&self, shape: &Shape, open: &[[u32; D]], level: u32) -> Vec<[u32; D]> {
        let children = open.iter().flat_map(|cell| {
            (0..1u32 << D).map(move |part| std::array::from_fn(|axis| 2 * cell[axis] + (part >> axis & 1)))
        });
        children
            .filter(|cell| !self.is_covered(cell, level + 1) && self.cell_meets_shape(shape, cell, level + 1))
            .collect()
    }

    /// Whether one disk covers a whole cell, so that no further point fits into it.
    fn is_covered(&self, cell: &[u32; D], level: u32) -> bool {
        let (low, edge) = self.corner(cell, level);
        let square = self.distance * self.distance;
        let middle = low.map(|l| l + 0.5 * edge);
        self.any_centre_near(&middle, |centre| {
            let farthest = |c: usize| (low[c] - centre[c]).abs().max((low[c] + edge - centre[c]).abs());
            (0..D).map(|c| farthest(c).powi(2)).sum::<f64>() < square
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CellList;
    use proptest::prelude::*;

    /// Checks that no two points are closer than the distance, and that no position in the shape is farther from all points.
    fn is_a_maximal_packing<const D: usize>(shape: &Shape, distance: f64, seed: u64, probes: usize) {
        let samples = poisson_disk::<D>(shape, distance, seed).unwrap();
        assert!(samples.iter().all(|s| shape.contains(&s.position)));
        let all: Vec<[f64; D]> = samples.iter().map(|s| s.position).collect();
        let reach = distance * 1.002;
        let mut cells = CellList::new();
        cells.build(&all, reach).unwrap();
        let nearest = |x: &[f64; D], but: usize| {
            let mut nearest = f64::INFINITY;
            cells.visit(x, |j| {
                let square: f64 = (0..D).map(|c| (x[c] - all[j as usize][c]).powi(2)).sum();
                if j as usize != but {
                    nearest = nearest.min(square.sqrt());
                }
            });
            nearest
        };
        assert!(
            (0..all.len()).all(|i| nearest(&all[i], i) >= distance * (1.0 - 1e-12)),
            "two points are too close"
        );
        let probes = crate::random::<D>(shape, probes, seed + 1)
            .unwrap_or_else(|_| crate::lattice(shape, [0.0; D], distance / 7.0).unwrap());
        for probe in probes {
            assert!(nearest(&probe.position, usize::MAX) <= reach, "there is room at {:?}", probe.position);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]
        #[test]
        fn poisson_samples_keep_their_distance_and_are_maximal(seed in 0..1000u64, distance in 0.05..0.3f64) {
            let ball = |dimension: usize| Shape::Ball { centre: vec![0.1; dimension], radius: 1.0 };
            is_a_maximal_packing::<1>(&ball(1), distance, seed, 2000);
            is_a_maximal_packing::<2>(&ball(2), distance, seed, 20_000);
            is_a_maximal_packing::<3>(&ball(3), 2.0 * distance, seed, 20_000);
        }

        #[test]
        fn corners_and_cuts_are_filled_as_well(seed in 0..1000u64) {
            // A sharp tip, a re-entrant corner, a hole and a shape in three dimensions with an edge.
            let polygon = Shape::Polygon { vertices: vec![[0.0, 0.0], [3.0, 0.2], [1.0, 1.0], [0.8, 0.4], [0.0, 1.5]].into() };
            is_a_maximal_packing::<2>(&polygon, 0.1, seed, 20_000);
            let hole = Box::new(Shape::Ball { centre: vec![0.3, 0.5], radius: 0.2 });
            is_a_maximal_packing::<2>(&Shape::Difference { from: Box::new(polygon), cut: hole }, 0.1, seed, 0);
            let cylinder = Shape::Cylinder { base: [0.0; 3], axis: 2, radius: 0.5, height: 0.6 };
            is_a_maximal_packing::<3>(&cylinder, 0.2, seed, 20_000);
            let cubes = [0.0, 0.3].map(|low| Shape::Box { min: vec![low; 3], max: vec![low + 0.5; 3] });
            is_a_maximal_packing::<3>(&Shape::Union { shapes: cubes.to_vec() }, 0.15, seed, 0);
        }
    }

    /// Checks the number of points against a lattice, their distance and evenness, and that they represent the whole volume.
    fn matches_a_lattice<const D: usize>(shape: &Shape, spacing: f64, most_off: f64, minimum: f64) {
        let samples = poisson_spaced::<D>(shape, spacing, 3).unwrap();
        let volume = shape.measure(D).unwrap();
        let wanted = volume / spacing.powi(D as i32);
        let count = samples.len() as f64;
        assert!((count / wanted - 1.0).abs() <= most_off, "{D}: {count} points for {wanted}");
        let sum: f64 = samples.iter().map(|sample| sample.volume).sum();
        assert!((sum / volume - 1.0).abs() < 1e-12, "{D}: {sum}");
        let apart = |a: &Sample<D>, b: &Sample<D>| {
            (0..D).map(|c| (a.position[c] - b.position[c]).powi(2)).sum::<f64>().sqrt()
        };
        let nearest =
            samples.iter().enumerate().flat_map(|(i, a)| samples[..i].iter().map(move |b| apart(a, b)));
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        assert!(nearest > minimum * spacing, "{D}: {nearest} m");
        // Either half of the shape has half of the points, except for those on the cut.
        for axis in 0..D {
            let (low, high) = shape.bounds(D);
            let middle = 0.5 * (low[axis] + high[axis]);
            let below = samples.iter().filter(|sample| sample.position[axis] < middle).count() as f64;
            let scatter = count.powf(0.5 * (D as f64 - 1.0) / D as f64);
            assert!((below - 0.5 * count).abs() <= 2.0 + 2.0 * scatter, "{D}: {below} of {count}");
        }
        assert_eq!(samples, poisson_spaced::<D>(shape, spacing, 3).unwrap());
        assert_ne!(samples, poisson_spaced::<D>(shape, spacing, 4).unwrap());
    }

    #[test]
    fn points_at_random_are_as_many_as_on_a_lattice_and_carry_the_whole_volume() {
        let cube = |dimension: usize| Shape::Box { min: vec![0.2; dimension], max: vec![1.2; dimension] };
        matches_a_lattice::<1>(&cube(1), 0.005, 0.02, 0.7);
        matches_a_lattice::<2>(&cube(2), 0.05, 0.02, 0.8);
        matches_a_lattice::<3>(&cube(3), 0.1, 0.02, 0.85);
        let ball = Shape::Ball { centre: vec![0.0; 2], radius: 1.0 };
        matches_a_lattice::<2>(&ball, 0.07, 0.02, 0.8);
    }

    #[test]
    fn the_seed_alone_decides() {
        let ball = Shape::Ball { centre: vec![0.0, 0.0], radius: 1.0 };
        let sample = |seed| poisson_disk::<2>(&ball, 0.1, seed).unwrap();
        assert_eq!(sample(3), sample(3));
        assert_ne!(sample(3), sample(4));
    }

    #[test]
    fn volumes_add_up_to_the_shape() {
        let total =
            |shape: &Shape| poisson_disk::<2>(shape, 0.05, 1).unwrap().iter().map(|s| s.volume).sum::<f64>();
        let ball = |radius: f64| Shape::Ball { centre: vec![0.0, 0.0], radius };
        assert!((total(&ball(1.0)) - std::f64::consts::PI).abs() < 1e-12);
        let ring = Shape::Difference { from: Box::new(ball(1.0)), cut: Box::new(ball(0.5)) };
        let exact = 0.75 * std::f64::consts::PI;
        assert!((total(&ring) / exact - 1.0).abs() < 1e-3, "counted on a lattice");
    }

    #[test]
    fn density_is_that_of_a_random_packing() {
        // Random sequential adsorption jams at 0.547 of the plane covered by disks of half the
        // distance; a maximal sampling is that limit (Feder 1980, J. Theor. Biol. 87, 237-254).
        let shape = Shape::Box { min: vec![0.0; 2], max: vec![1.0; 2] };
        let distance = 0.01;
        let count = poisson_disk::<2>(&shape, distance, 5).unwrap().len() as f64;
        // Centres may lie on the boundary, so the area that contains the disks is wider by the distance.
        let cover = count * std::f64::consts::PI * 0.25 * distance * distance / (1.0 + distance).powi(2);
        assert!((cover - 0.547).abs() < 0.01, "{cover}");
    }

    #[test]
    fn invalid_point_spacings_are_refused() {
        let ball = Shape::Ball { centre: vec![0.0; 3], radius: 1.0 };
        assert!(matches!(poisson_disk::<3>(&ball, 0.0, 1), Err(SamplingError::Spacing(_))));
        assert!(matches!(poisson_disk::<3>(&ball, 1e-4, 1), Err(SamplingError::TooMany(_))));
        let alone = poisson_disk::<3>(&ball, 10.0, 1).unwrap();
        assert_eq!(alone.len(), 1);
    }
}
