//! Porous structures of overlapping balls of equal size: sintered grains, as of snow (sheet: snow-mpm A4).

use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::{Arc, PoisonError, RwLock};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Distance of the centres of two connected grains over their diameter: below it they share a neck.
const NECK_RATIO: f64 = 0.9;

/// Number of sampling points per direction for the solid fraction, by number of dimensions.
const COUNTING_POINTS: [usize; 3] = [4096, 256, 72];

/// Largest number of trial positions per grain of the packing.
const MAX_THROWS_PER_GRAIN: usize = 4000;

/// Largest number of trial positions in all, and for each grain of a large packing: seconds of computing time.
const MAX_THROWS: [usize; 2] = [5_000_000, 50];

/// Approximate largest number of spheres of a microstructure.
const MAX_SPHERES: f64 = 1e6;

/// Error text for a microstructure of too many spheres; `None` where their number is allowed.
pub(crate) fn sphere_count_error(min: &[f64], max: &[f64], diameter: f64, fraction: f64) -> Option<String> {
    let whole: f64 = min.iter().zip(max).map(|(low, high)| (high - low) / diameter).product();
    // Ratio to the volume of the cube around the ball.
    let ball = if min.len() == 2 { PI / 4.0 } else { PI / 6.0 };
    // At random positions, balls of n times the volume of the box cover 1 - exp(-n) of it.
    let balls = -(1.0 - fraction).ln() * whole / ball;
    (balls > MAX_SPHERES).then(|| {
        format!(
            "{diameter} m gives about {balls:.1e} balls, more than {MAX_SPHERES:e}: use larger balls, or \
             a smaller box"
        )
    })
}

/// Parameters of a microstructure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MicrostructureSpec<'a> {
    /// Lower corner of the box (m).
    pub min: &'a [f64],
    /// Upper corner (m).
    pub max: &'a [f64],
    /// Diameter of the grains (m).
    pub diameter: f64,
    /// Solid fraction of the box.
    pub fraction: f64,
    /// Seed of the positions of the grains.
    pub seed: u64,
    /// Whether all grains are connected.
    pub connected: bool,
}

impl MicrostructureSpec<'_> {
    /// Edge lengths of the box (m).
    fn extents(&self) -> impl Iterator<Item = f64> {
        self.min.iter().zip(self.max).map(|(low, high)| high - low)
    }
}

/// Packing of a microstructure. It is computed at the first request, and again for other parameters. Any two compare equal: the shape's own
/// parameters identify them.
#[derive(Debug, Default)]
pub struct CachedPacking(RwLock<Option<PackedMicrostructure>>);

impl PartialEq for CachedPacking {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Clone for CachedPacking {
    fn clone(&self) -> Self {
        Self(RwLock::new(self.0.read().unwrap_or_else(PoisonError::into_inner).clone()))
    }
}

/// Packing with the parameters for which it was computed.
#[derive(Clone, Debug)]
struct PackedMicrostructure {
    extents: Vec<f64>,
    diameter: f64,
    fraction: f64,
    seed: u64,
    connected: bool,
    packing: Option<Arc<SpherePacking>>,
}

impl PackedMicrostructure {
    /// Packs spheres for the parameters `wanted`, and keeps them with the parameters.
    fn pack(wanted: &MicrostructureSpec<'_>) -> Self {
        let MicrostructureSpec { diameter, fraction, seed, connected, .. } = *wanted;
        let packing = pack_spheres(wanted).map(Arc::new);
        Self { extents: wanted.extents().collect(), diameter, fraction, seed, connected, packing }
    }

    /// Whether the packing fits the parameters `wanted`. A translated box has the same grains, with edges equal to round-off.
    fn matches(&self, wanted: &MicrostructureSpec<'_>) -> bool {
        let near = |(a, b): (f64, &f64)| (a - b).abs() <= 1e-9 * b.abs();
        (self.diameter, self.fraction, self.seed, self.connected)
            == (wanted.diameter, wanted.fraction, wanted.seed, wanted.connected)
            && self.extents.len() == wanted.min.len()
            && wanted.extents().zip(&self.extents).all(near)
    }
}

/// Packing of overlapping spheres in a box.
#[derive(Debug)]
pub(crate) struct SpherePacking {
    /// Centres relative to the lower corner of the box (m).
    centres: Vec<[f64; 3]>,
    /// Indices of the grains in cubic cells as wide as a grain.
    cells: HashMap<[i64; 3], Vec<u32>>,
    dimension: usize,
    radius: f64,
    /// Solid fraction of the box.
    pub fraction: f64,
}

impl CachedPacking {
    /// Packing for the parameters `wanted`; `None` where that fraction of connected grains cannot be packed.
    pub(crate) fn packing(&self, wanted: &MicrostructureSpec<'_>) -> Option<Arc<SpherePacking>> {
        let held = self.0.read().unwrap_or_else(PoisonError::into_inner);
        if let Some(made) = held.as_ref().filter(|made| made.matches(wanted)) {
            return made.packing.clone();
        }
        drop(held);
        let mut held = self.0.write().unwrap_or_else(PoisonError::into_inner);
        if !held.as_ref().is_some_and(|made| made.matches(wanted)) {
            *held = Some(PackedMicrostructure::pack(wanted));
        }
        held.as_ref().and_then(|made| made.packing.clone())
    }
}

impl SpherePacking {
    /// Cell of the search grid that contains a position.
    fn cell_of(&self, x: &[f64; 3]) -> [i64; 3] {
        x.map(|c| (c / (2.0 * self.radius)).floor() as i64)
    }

    /// Adds a sphere.
    fn add(&mut self, centre: [f64; 3]) {
        let cube = self.cell_of(&centre);
        self.cells.entry(cube).or_default().push(self.centres.len() as u32);
        self.centres.push(centre);
    }

    /// Grains whose centre is within `reach` (m), at most a diameter, of a position relative to the lower corner of the box (m).
    fn grains_near(&self, x: &[f64; 3], reach: f64) -> impl Iterator<Item = usize> {
        let (middle, last) = (self.cell_of(x), if self.dimension == 3 { 1 } else { 0 });
        let range = |axis: usize| {
            let width = if axis == 2 { last } else { 1 };
            middle[axis] - width..=middle[axis] + width
        };
        let (rows, columns) = (range(1), range(2));
        let cubes = range(0).flat_map(move |i| {
            let columns = columns.clone();
            rows.clone().flat_map(move |j| columns.clone().map(move |k| [i, j, k]))
        });
        let x = *x;
        let all =
            cubes.filter_map(move |cube| self.cells.get(&cube)).flatten().map(|&number| number as usize);
        all.filter(move |&number| square_distance(&self.centres[number], &x) <= reach * reach)
    }

    /// Whether a position relative to the lower corner of the box (m) lies in a grain.
    pub(crate) fn contains(&self, x: &[f64; 3]) -> bool {
        self.grains_near(x, self.radius).next().is_some()
    }

    /// Coordinates at which the line along `axis` through a position relative to the lower corner of the box (m) crosses grains.
    pub(crate) fn crossings(&self, x: &[f64; 3], axis: usize) -> Vec<f64> {
        let mut found = Vec::new();
        for centre in &self.centres {
            let across: f64 = (0..3).filter(|c| *c != axis).map(|c| (x[c] - centre[c]).powi(2)).sum();
            let half = self.radius * self.radius - across;
            if half > 0.0 {
                found.extend([centre[axis] - half.sqrt(), centre[axis] + half.sqrt()]);
            }
        }
        found
    }

    /// Largest set of connected grains.
    fn largest_cluster(&self) -> Vec<usize> {
        let mut of = vec![usize::MAX; self.centres.len()];
        let mut largest = Vec::new();
        for start in 0..self.centres.len() {
            if of[start] != usize::MAX {
                continue;
            }
            let (mut cluster, mut next) = (vec![start], 0);
            of[start] = start;
            while let Some(&grain) = cluster.get(next) {
                next += 1;
                let near: Vec<usize> =
                    self.grains_near(&self.centres[grain], NECK_RATIO * 2.0 * self.radius).collect();
                for other in near {
                    if of[other] == usize::MAX {
                        of[other] = start;
                        cluster.push(other);
                    }
                }
            }
            if cluster.len() > largest.len() {
                largest = cluster;
            }
        }
        largest.sort_unstable();
        largest
    }
}

/// Square of the distance of two positions (m²).
fn square_distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum()
}

/// Sampling points for the solid fraction.
struct SolidFractionGrid {
    sizes: [f64; 3],
    node_counts: [usize; 3],
    solid: Vec<bool>,
    count: usize,
}

impl SolidFractionGrid {
    /// Grid of nodes over a box, at which the solid fraction is counted.
    fn new(sizes: [f64; 3], dimension: usize) -> Self {
        let node_counts =
            std::array::from_fn(|c| if c < dimension { COUNTING_POINTS[dimension - 1] } else { 1 });
        Self { sizes, node_counts, solid: vec![false; node_counts.iter().product()], count: 0 }
    }

    /// Position of a node of the grid (m).
    fn node_position(&self, index: [usize; 3]) -> [f64; 3] {
        std::array::from_fn(|c| self.sizes[c] * (index[c] as f64 + 0.5) / self.node_counts[c] as f64)
    }

    /// Marks the nodes inside a sphere as solid.
    fn mark_solid(&mut self, centre: &[f64; 3], radius: f64) {
        let range = |c: usize| {
            let per = self.node_counts[c] as f64 / self.sizes[c].max(f64::MIN_POSITIVE);
            if self.node_counts[c] == 1 {
                return 0..1;
            }
            let low = ((centre[c] - radius) * per).floor().max(0.0) as usize;
            low..(((centre[c] + radius) * per).ceil().max(0.0) as usize).min(self.node_counts[c])
        };
        for i in range(0) {
            for j in range(1) {
                for k in range(2) {
                    let number = (i * self.node_counts[1] + j) * self.node_counts[2] + k;
                    if !self.solid[number]
                        && square_distance(&self.node_position([i, j, k]), centre) <= radius * radius
                    {
                        self.solid[number] = true;
                        self.count += 1;
                    }
                }
            }
        }
    }

    /// Share of the nodes that are solid.
    fn fraction(&self) -> f64 {
        self.count as f64 / self.solid.len() as f64
    }
}

/// Places random grains until the solid fraction is reached; `None` where that is not possible. For connected grains, only the largest
/// cluster is kept, and further grains must touch it.
fn pack_spheres(wanted: &MicrostructureSpec<'_>) -> Option<SpherePacking> {
    let dimension = wanted.min.len();
    let mut sizes = [0.0; 3];
    (0..dimension).for_each(|c| sizes[c] = wanted.max[c] - wanted.min[c]);
    let radius = 0.5 * wanted.diameter;
    let empty =
        || SpherePacking { centres: Vec::new(), cells: HashMap::new(), dimension, radius, fraction: 0.0 };
    let mut generator = ChaCha8Rng::seed_from_u64(wanted.seed);
    let mut throw = || {
        let mut centre = [0.0; 3];
        (0..dimension).for_each(|c| centre[c] = generator.random_range(0.0..sizes[c]));
        centre
    };
    let (mut packing, mut counted) = (empty(), SolidFractionGrid::new(sizes, dimension));
    while counted.fraction() < wanted.fraction {
        let centre = throw();
        counted.mark_solid(&centre, radius);
        packing.add(centre);
    }
    if wanted.connected {
        let kept = packing.largest_cluster();
        let all = std::mem::replace(&mut packing, empty());
        counted = SolidFractionGrid::new(sizes, dimension);
        for grain in kept {
            counted.mark_solid(&all.centres[grain], radius);
            packing.add(all.centres[grain]);
        }
        let count = all.centres.len();
        let largest = (MAX_THROWS_PER_GRAIN * count).min(MAX_THROWS[0] + MAX_THROWS[1] * count);
        let mut throws = 0;
        while counted.fraction() < wanted.fraction {
            throws += 1;
            if throws > largest {
                return None;
            }
            let centre = throw();
            if packing.grains_near(&centre, NECK_RATIO * wanted.diameter).next().is_some() {
                counted.mark_solid(&centre, radius);
                packing.add(centre);
            }
        }
    }
    packing.fraction = counted.fraction();
    Some(packing)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Shape;

    fn structure(dimension: usize, fraction: f64, seed: u64) -> Shape {
        Shape::Microstructure {
            min: vec![1.0; dimension],
            max: vec![4.0; dimension],
            diameter: 0.3,
            solid_fraction: fraction,
            seed,
            connected: true,
            grains: CachedPacking::default(),
        }
    }

    #[test]
    fn a_microstructure_has_the_prescribed_solid_fraction() {
        for (dimension, fraction, steps) in [(2, 0.72, 700usize), (3, 0.35, 90)] {
            let shape = structure(dimension, fraction, 3);
            shape.validate(dimension).unwrap();
            let place = |number: usize| -> Vec<f64> {
                let at = |axis: u32| (number / steps.pow(axis)) % steps;
                (0..dimension).map(|c| 1.0 + 3.0 * (at(c as u32) as f64 + 0.37) / steps as f64).collect()
            };
            let all = steps.pow(dimension as u32);
            let solid = (0..all).filter(|number| shape.contains(&place(*number))).count();
            let found = solid as f64 / all as f64;
            assert!((found - fraction).abs() < 0.01, "{dimension}: {found}");
            let volume = shape.measure(dimension).unwrap();
            assert!((volume / 3f64.powi(dimension as i32) - found).abs() < 0.01);
            assert!(!shape.contains(&vec![0.99; dimension]));
        }
    }

    #[test]
    fn all_grains_are_connected_and_repeatable_for_a_seed() {
        let wanted = MicrostructureSpec {
            min: &[0.0, 0.0],
            max: &[3.0, 3.0],
            diameter: 0.3,
            fraction: 0.6,
            seed: 5,
            connected: true,
        };
        let (packing, again) = (pack_spheres(&wanted).unwrap(), pack_spheres(&wanted).unwrap());
        assert_eq!(packing.largest_cluster().len(), packing.centres.len());
        assert_eq!(packing.centres, again.centres);
        let loose = pack_spheres(&MicrostructureSpec { connected: false, ..wanted }).unwrap();
        assert!(loose.largest_cluster().len() < loose.centres.len());
        assert!(pack_spheres(&MicrostructureSpec { seed: 6, ..wanted }).unwrap().centres != packing.centres);
    }

    #[test]
    fn a_resized_box_is_filled_anew_and_a_translated_one_is_not() {
        let mut shape = structure(2, 0.72, 3);
        let solid = |shape: &Shape| shape.measure(2).unwrap();
        let first = solid(&shape);
        let moved = |shape: &mut Shape, low: f64, high: f64| {
            let Shape::Microstructure { min, max, .. } = shape else { unreachable!() };
            (*min, *max) = (vec![low; 2], vec![high; 2]);
        };
        moved(&mut shape, 1e5 + 1.0, 1e5 + 4.0);
        assert!((solid(&shape) - first).abs() < 1e-9 * first);
        moved(&mut shape, 1.0, 7.0);
        assert!((solid(&shape) - 0.72 * 36.0).abs() < 0.02 * 36.0, "{}", solid(&shape));
        let beyond = (0..100)
            .filter(|k| shape.contains(&[4.2 + 0.3 * f64::from(k % 10), 4.2 + 0.3 * f64::from(k / 10)]));
        assert!(beyond.count() > 30);
    }

    #[test]
    fn microstructures_that_grains_cannot_form_are_refused() {
        let error = |shape: Shape| shape.validate(2).unwrap_err().to_string();
        assert!(error(structure(2, 1.0, 0)).starts_with("solid_fraction"));
        let Shape::Microstructure { min, max, solid_fraction, seed, connected, grains, .. } =
            structure(2, 0.7, 0)
        else {
            unreachable!()
        };
        let of = |diameter: f64| Shape::Microstructure {
            min: min.clone(),
            max: max.clone(),
            diameter,
            solid_fraction,
            seed,
            connected,
            grains: grains.clone(),
        };
        assert!(error(of(4.0)).starts_with("diameter"));
        // Grains of 1.2 times nine square metres in all.
        let many = error(of(1e-5));
        assert!(many.contains("about 1.4e11 balls, more than 1e6"), "{many}");
    }
}
