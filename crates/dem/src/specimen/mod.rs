//! Random packings: grains at random places grow to their sizes while overlaps are pushed apart (radius expansion; sheet:
//! dem §3.8.6). Further methods: layers pressed one on another, [`undercompaction`], and drop and roll of [disks](drop_and_roll_2d) and
//! [spheres](drop_and_roll_3d).

pub mod drop_and_roll_2d;
pub mod drop_and_roll_3d;
pub(crate) mod file;
pub(crate) mod fill_report;
pub(crate) mod pluviation;
pub(crate) mod pluviation_entry;
mod report;
pub mod size_distributions;
pub(crate) mod specimen_preparation;
pub mod undercompaction;

use std::ops::Range;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
pub use report::Specimen;

use crate::boundary::periodic_cell::PeriodicCell;
use crate::neighbours::size_classes::SizeClasses;
use crate::points::grains::volume;
use crate::points::vector::{difference, dot};

/// Initial radius over final radius.
const INITIAL_RADIUS_RATIO: f64 = 0.6;
/// Number of growth steps.
const GROWTH: usize = 40;
/// Number of relaxation iterations at each radius before the final one.
const RELAXATION_ITERATIONS: usize = 60;
/// Number of relaxation iterations at the final radius.
const LAST_RELAXATION_ITERATIONS: usize = 20_000;
/// Number of iterations after which the relaxation ends unless large overlaps have decreased.
const STALL_ITERATIONS: usize = 1000;
/// Relative decrease of the overlap below which the relaxation has stalled.
const MIN_DECREASE: f64 = 0.02;
/// Overlap over its tolerance above which a stalled relaxation ends.
const FAR_FACTOR: f64 = 1.5;
/// Tolerance of the overlap over the smaller radius.
const OVERLAP_TOLERANCE: f64 = 0.01;
/// Number of attempts at a packing, because a random packing can jam.
const DRAWINGS: usize = 3;
/// Largest possible solid fractions of equal disks and spheres (sheet: dem §0); disks of several sizes can be denser.
const DENSEST: [f64; 2] = [0.9069, 0.7405];

/// Container of a packing: a box, with an optional round wall inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Container<const D: usize> {
    /// Lower corner (m).
    pub low: [f64; D],
    /// Upper corner (m).
    pub high: [f64; D],
    /// Axes along which the box is periodic.
    pub periodic: [bool; D],
    /// Round wall inside the box, if there is one.
    pub round_wall: Option<RoundWall<D>>,
}

/// Round wall of a disk or ball, or of a cylinder along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundWall<const D: usize> {
    /// Axis of the cylinder; `None` for a disk or a ball.
    pub axis: Option<usize>,
    /// Centre, or a point on the axis (m).
    pub centre: [f64; D],
    /// Radius (m).
    pub radius: f64,
}

impl<const D: usize> RoundWall<D> {
    /// Vector from the centre or the axis to a point (m).
    fn apart(&self, x: &[f64; D]) -> [f64; D] {
        std::array::from_fn(|c| if self.axis == Some(c) { 0.0 } else { x[c] - self.centre[c] })
    }

    /// Whether a point is inside the round wall.
    fn contains(&self, x: &[f64; D]) -> bool {
        let apart = self.apart(x);
        dot(&apart, &apart) <= self.radius * self.radius
    }

    /// Moves a ball inside the wall.
    fn confine(&self, x: &mut [f64; D], radius: f64) {
        let apart = self.apart(x);
        let (distance, largest) = (dot(&apart, &apart).sqrt(), (self.radius - radius).max(0.0));
        if distance > largest {
            for c in 0..D {
                x[c] -= apart[c] * (1.0 - largest / distance);
            }
        }
    }
}

/// Heap of grains that are dropped one after another.
trait GrainHeap<const D: usize> {
    /// Resting position (m) of a grain that is dropped over a position; `None` if it rolls without end. The last coordinate of `over` is
    /// infinite.
    fn resting_position(&self, over: [f64; D], radius: f64, random: &mut ChaCha8Rng) -> Option<[f64; D]>;

    /// Adds a grain at rest.
    fn add(&mut self, place: [f64; D], radius: f64);
}

/// Number of consecutive grains that come to rest above the container, after which it is full.
const MAX_FAILURES: usize = 200;

impl<const D: usize> Container<D> {
    /// Drops grains at random positions on a heap until the container is full. `draw` gives the radius of each grain (m).
    ///
    /// # Errors
    /// When the container would hold more than `limit` of them.
    fn drop_grains(
        &self,
        heap: &mut impl GrainHeap<D>,
        limit: usize,
        random: &mut ChaCha8Rng,
        mut draw: impl FnMut(&mut ChaCha8Rng) -> f64,
    ) -> Result<(), String> {
        let (mut count, mut above) = (0, 0);
        while above < MAX_FAILURES {
            let radius = draw(random);
            let mut over = [f64::INFINITY; D];
            for axis in 0..D - 1 {
                let margin = if self.periodic[axis] { 0.0 } else { radius };
                over[axis] =
                    self.low[axis] + margin + (self.width(axis) - 2.0 * margin) * random.random::<f64>();
            }
            match heap.resting_position(over, radius, random) {
                Some(place) if place[D - 1] + radius <= self.high[D - 1] => {
                    heap.add(place, radius);
                    (count, above) = (count + 1, 0);
                }
                _ => above += 1,
            }
            if count > limit {
                return Err(format!("more than {limit} grains"));
            }
        }
        Ok(())
    }

    /// Volume of the container (m³), in the plane its area (m²).
    pub fn volume(&self) -> f64 {
        match self.round_wall {
            None => (0..D).map(|axis| self.width(axis)).product(),
            Some(RoundWall { axis: None, radius, .. }) => volume(D, radius),
            Some(RoundWall { axis: Some(axis), radius, .. }) => volume(D - 1, radius) * self.width(axis),
        }
    }

    /// Area of the sections across the last axis, which are all equal (m²; m in the plane).
    fn section(&self) -> f64 {
        match self.round_wall {
            None => (0..D - 1).map(|axis| self.width(axis)).product(),
            Some(RoundWall { radius, .. }) => volume(D - 1, radius),
        }
    }

    /// Width of the container along an axis (m).
    fn width(&self, axis: usize) -> f64 {
        self.high[axis] - self.low[axis]
    }

    /// Shortest vector between two points across periodic boundaries (m).
    fn separation(&self, a: &[f64; D], b: &[f64; D]) -> [f64; D] {
        let mut apart = difference(a, b);
        for c in 0..D {
            if self.periodic[c] {
                apart[c] -= self.width(c) * (apart[c] / self.width(c)).round();
            }
        }
        apart
    }

    /// Coordinate inside the container along a periodic axis (m); unchanged along other axes.
    fn wrapped_coordinate(&self, axis: usize, x: f64) -> f64 {
        let (low, width) = (self.low[axis], self.width(axis));
        if self.periodic[axis] { x - width * ((x - low) / width).floor() } else { x }
    }

    /// Rejects a box narrower than two of the largest balls along one of the axes; `largest` is their radius (m).
    fn check_width(&self, mut axes: Range<usize>, largest: f64) -> Result<(), String> {
        match axes.find(|&axis| self.width(axis) < 4.0 * largest) {
            Some(axis) => Err(format!(
                "is {} m wide along {}, less than two of the largest grains",
                self.width(axis),
                ["x", "y", "z"][axis]
            )),
            None => Ok(()),
        }
    }

    /// Moves a point back into the box, a ball of that radius inside its walls.
    fn confine(&self, x: &mut [f64; D], radius: f64) {
        for c in 0..D {
            if self.periodic[c] {
                x[c] = self.wrapped_coordinate(c, x[c]);
            } else {
                x[c] = x[c].max(self.low[c] + radius).min(self.high[c] - radius);
            }
        }
        if let Some(round) = &self.round_wall {
            round.confine(x, radius);
        }
    }

    /// Random point in the container (m).
    fn random_position(&self, random: &mut ChaCha8Rng) -> [f64; D] {
        loop {
            let x = std::array::from_fn(|c| self.low[c] + self.width(c) * random.random::<f64>());
            if self.round_wall.is_none_or(|round| round.contains(&x)) {
                return x;
            }
        }
    }
}

/// Random packing of balls with given radii (m): positions, with overlaps of at most 1 % of the smaller radius.
///
/// # Errors
/// When the balls do not fit, with the remaining overlap.
pub fn pack<const D: usize>(
    container: &Container<D>,
    radii: &[f64],
    random: &mut ChaCha8Rng,
) -> Result<Vec<[f64; D]>, String> {
    let largest = radii.iter().copied().fold(0.0, f64::max);
    container.check_width(0..D, largest)?;
    let fraction = radii.iter().map(|r| volume(D, *r)).sum::<f64>() / container.volume();
    let spread = largest / radii.iter().copied().fold(f64::INFINITY, f64::min);
    if fraction >= 1.0 || (spread < 1.01 && fraction > DENSEST[D - 2]) {
        return Err(format!("a solid fraction of {fraction:.4} is higher than that of any packing"));
    }
    let (mut positions, mut deepest) = relax_random(container, radii, random)?;
    for _ in 1..DRAWINGS {
        if deepest > OVERLAP_TOLERANCE {
            (positions, deepest) = relax_random(container, radii, random)?;
        }
    }
    check_overlap(deepest, fraction)?;
    Ok(positions)
}

/// Random positions of balls that grow and push each other apart, and the largest remaining overlap over the smaller radius.
fn relax_random<const D: usize>(
    container: &Container<D>,
    radii: &[f64],
    random: &mut ChaCha8Rng,
) -> Result<(Vec<[f64; D]>, f64), String> {
    let mut positions: Vec<[f64; D]> = radii
        .iter()
        .map(|radius| {
            let mut x = container.random_position(random);
            container.confine(&mut x, *radius);
            x
        })
        .collect();
    let mut deepest = 0.0;
    for step in 0..=GROWTH {
        let scale = INITIAL_RADIUS_RATIO + (1.0 - INITIAL_RADIUS_RATIO) * step as f64 / GROWTH as f64;
        let pushes = if step == GROWTH { LAST_RELAXATION_ITERATIONS } else { RELAXATION_ITERATIONS };
        deepest = separate_overlaps(container, &mut positions, radii, scale, pushes)?;
    }
    Ok((positions, deepest))
}

/// Refuses overlaps above the tolerance.
fn check_overlap(deepest: f64, fraction: f64) -> Result<(), String> {
    if deepest <= OVERLAP_TOLERANCE {
        return Ok(());
    }
    Err(format!(
        "a solid fraction of {fraction:.4} leaves overlaps of {deepest:.3} of the smaller radius: give a \
         lower one, and compact the body in a stage"
    ))
}

/// Moves overlapping balls apart, each by half the overlap, in at most `pushes` iterations. Returns the largest remaining overlap over the
/// smaller radius.
fn separate_overlaps<const D: usize>(
    container: &Container<D>,
    positions: &mut [[f64; D]],
    radii: &[f64],
    scale: f64,
    pushes: usize,
) -> Result<f64, String> {
    let largest = radii.iter().copied().fold(0.0, f64::max);
    let mean = radii.iter().sum::<f64>() / radii.len().max(1) as f64;
    // The skin suits most grains; the result does not depend on it.
    let skin = 0.4 * largest.min(3.0 * mean);
    let scaled: Vec<f64> = radii.iter().map(|radius| scale * radius).collect();
    let mut near = NearPairs::default();
    let mut listed: Vec<[f64; D]> = Vec::new();
    let (mut shifts, mut deepest) = (vec![[0.0; D]; positions.len()], f64::INFINITY);
    let mut progress = OverlapProgress { min_overlap: f64::INFINITY, previous_overlap: f64::INFINITY };
    for push in 0..pushes {
        let moved = |listed: &[[f64; D]]| {
            let displacement = |(x, y): (&[f64; D], &[f64; D])| {
                let displacement = container.separation(x, y);
                dot(&displacement, &displacement)
            };
            positions.iter().zip(listed).map(displacement).fold(0.0, f64::max).sqrt()
        };
        if listed.is_empty() || 2.0 * moved(&listed) > skin {
            near.list(container, positions, &scaled, skin)?;
            listed = positions.to_vec();
        }
        shifts.fill([0.0; D]);
        deepest = 0.0f64;
        for &(i, j) in &near.pairs {
            let (i, j) = (i as usize, j as usize);
            let apart = container.separation(&positions[i], &positions[j]);
            let distance = dot(&apart, &apart).sqrt();
            let overlap = scale * (radii[i] + radii[j]) - distance;
            if overlap <= 0.0 {
                continue;
            }
            deepest = deepest.max(overlap / (scale * radii[i].min(radii[j])));
            // A little more than half each, so that few iterations are needed.
            let share = 0.55 * overlap / distance.max(1e-9 * largest);
            for c in 0..D {
                shifts[i][c] += share * apart[c];
                shifts[j][c] -= share * apart[c];
            }
        }
        if deepest <= 0.9 * OVERLAP_TOLERANCE || progress.has_stalled(push, deepest) {
            break;
        }
        for ((x, shift), radius) in positions.iter_mut().zip(&shifts).zip(radii) {
            for c in 0..D {
                x[c] += shift[c];
            }
            container.confine(x, scale * radius);
        }
    }
    Ok(deepest)
}

/// Progress of the relaxation: smallest value of the largest overlap in the last and in the previous iterations.
struct OverlapProgress {
    min_overlap: f64,
    previous_overlap: f64,
}

impl OverlapProgress {
    /// Whether overlaps far above the tolerance no longer decrease.
    fn has_stalled(&mut self, push: usize, deepest: f64) -> bool {
        self.min_overlap = self.min_overlap.min(deepest);
        if push % STALL_ITERATIONS != STALL_ITERATIONS - 1 {
            return false;
        }
        let stalls = self.min_overlap > FAR_FACTOR * OVERLAP_TOLERANCE
            && self.min_overlap > (1.0 - MIN_DECREASE) * self.previous_overlap;
        (self.previous_overlap, self.min_overlap) = (self.min_overlap, f64::INFINITY);
        stalls
    }
}

/// Pairs of balls close to each other, with the search grid.
#[derive(Default)]
struct NearPairs<const D: usize> {
    classes: SizeClasses<D>,
    pairs: Vec<(u32, u32)>,
}

impl<const D: usize> NearPairs<D> {
    /// Lists the pairs of balls with gaps below `gap` (m), across periodic boundaries, in the order of their numbers.
    fn list(
        &mut self,
        container: &Container<D>,
        positions: &[[f64; D]],
        radii: &[f64],
        gap: f64,
    ) -> Result<(), String> {
        let cell = PeriodicCell::new(container.low, container.high, container.periodic);
        self.classes.build(positions, radii, &cell, gap).map_err(|error| error.to_string())?;
        let pairs = &mut self.pairs;
        pairs.clear();
        self.classes.visit(radii, |i, j, _| {
            let (apart, limit) =
                (container.separation(&positions[i], &positions[j]), radii[i] + radii[j] + gap);
            if dot(&apart, &apart) < limit * limit {
                pairs.push((i.min(j) as u32, i.max(j) as u32));
            }
        });
        pairs.sort_unstable();
        pairs.dedup();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    #[test]
    fn a_packing_has_its_fraction_without_overlaps() {
        let container =
            Container { low: [0.0; 2], high: [20.0, 20.0], periodic: [true, false], round_wall: None };
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let radii: Vec<f64> = (0..360).map(|_| 0.4 + 0.2 * random.random::<f64>()).collect();
        let fraction: f64 = radii.iter().map(|r| std::f64::consts::PI * r * r).sum::<f64>() / 400.0;
        assert!(fraction > 0.68);
        let positions = pack(&container, &radii, &mut random).unwrap();
        for i in 0..positions.len() {
            assert!(positions[i][1] > radii[i] - 1e-9 && positions[i][1] < 20.0 - radii[i] + 1e-9);
            for j in 0..i {
                let apart = container.separation(&positions[i], &positions[j]);
                let overlap = radii[i] + radii[j] - dot(&apart, &apart).sqrt();
                assert!(overlap <= 0.011 * radii[i].min(radii[j]), "{i} {j} {overlap}");
            }
        }
        let again = ChaCha8Rng::seed_from_u64(5);
        let mut again = again;
        let radii: Vec<f64> = (0..360).map(|_| 0.4 + 0.2 * again.random::<f64>()).collect();
        assert_eq!(pack(&container, &radii, &mut again).unwrap(), positions);
    }

    #[test]
    fn too_dense_a_packing_is_refused() {
        let container = Container { low: [0.0; 3], high: [10.0; 3], periodic: [true; 3], round_wall: None };
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let error = pack(&container, &[0.5; 1430], &mut random).unwrap_err();
        assert!(error.contains("0.7487"), "{error}");
    }
}
