//! Drift over a curved bed: velocities are transported from the tangent plane at one position to that at the next, by the rotation of
//! one normal into the other, so that speed along the bed is kept (sheet: depth-sph §2.9, as amended).

use rayon::prelude::*;

use crate::bed::{Bed, BedPoint};
use crate::config::choices::DepthFrame;
use crate::flow::{Flow, PlanBoundaries};
use crate::phases::phase::{PhaseSet, TASK};
use crate::phases::phase_nodes::{PlanVector, dot};

/// Scalar product of two vectors in plan along a bed of this slope.
#[inline]
pub fn dot_along_bed<const D: usize>(slope: &PlanVector<D>, a: &PlanVector<D>, b: &PlanVector<D>) -> f64 {
    dot(a, b) + dot(slope, a) * dot(slope, b)
}

/// Velocity along the plane of slope `from`, transported into that of slope `to`: `V - V·n'/(1 + n·n') (n + n')` in plan, which keeps
/// its magnitude.
#[inline]
pub fn parallel_transport<const D: usize>(
    v: &PlanVector<D>,
    from: &PlanVector<D>,
    to: &PlanVector<D>,
) -> PlanVector<D> {
    let (root, other) = ((1.0 + dot(from, from)).sqrt(), (1.0 + dot(to, to)).sqrt());
    let off = dot(from, v) - dot(to, v);
    let share = off / (other + (1.0 + dot(from, to)) / root);
    std::array::from_fn(|c| v[c] + share * (from[c] / root + to[c] / other))
}

/// Bed below the path of a node, with walls and periods.
struct BedPath<'a, const D: usize> {
    bed: &'a Bed<D>,
    ends: &'a PlanBoundaries<D>,
    open: bool,
}

impl<const D: usize> BedPath<'_, D> {
    /// Bed at a position, mirrored and repeated beyond walls and ends of periods; `None` where there is none.
    #[inline]
    fn at(&self, x: &PlanVector<D>) -> Option<BedPoint<D>> {
        if self.open {
            return self.bed.at(x);
        }
        let (mut inside, mut origin) = (*x, [0.0; D]);
        let signs = self.ends.mirror(&mut inside);
        self.ends.wrap(&mut inside, &mut origin);
        self.bed.at(&inside).map(|point| point.mirrored(&signs))
    }

    /// Reflects a node that has passed a wall, with its velocity and the bed below it.
    #[inline]
    fn reflect(&self, x: &mut PlanVector<D>, v: &mut PlanVector<D>, point: &mut BedPoint<D>) {
        if !self.open {
            let signs = self.ends.mirror(&mut { *x });
            *point = point.mirrored(&signs);
            self.ends.reflect(x, v);
        }
    }
}

/// Half a drift of a node with transport: by its velocity at the end of the half, with a first guess and one iteration, without which
/// the order is one. Returns the position, and the bed there.
#[inline]
fn half_drift<const D: usize>(
    floor: &BedPath<'_, D>,
    x: &PlanVector<D>,
    drift: &PlanVector<D>,
    slope: &PlanVector<D>,
    dt: f64,
) -> (PlanVector<D>, Option<BedPoint<D>>) {
    let after = |v: &PlanVector<D>| std::array::from_fn(|c| x[c] + dt * v[c]);
    let guess = after(drift);
    let Some(there) = floor.at(&guess) else { return (guess, None) };
    let place = after(&parallel_transport(drift, slope, &there.slope));
    (place, floor.at(&place))
}

impl<const D: usize> Flow<D> {
    /// Whether velocities are transported between tangent planes: over a bed with slopes, in vertical depths over steep terrain.
    pub(crate) fn uses_parallel_transport(&self) -> bool {
        self.settings.frame == DepthFrame::Horizontal && !self.bed.is_flat()
    }

    /// First half of the drift, over `dt` (s), to the positions at which the bed is sampled in the middle of the step.
    pub(crate) fn first_half_drift(&mut self, dt: f64) {
        let carries = self.uses_parallel_transport();
        let turns = carries && self.settings.curvature_in_friction && self.settings.has_resistance();
        let smoothed = self.settings.numerics.xsph > 0.0;
        for number in 0..self.sets.len() {
            let mut set = std::mem::take(&mut self.sets[number]);
            let floor = BedPath { bed: &self.bed, ends: &self.ends, open: self.ends.are_open() };
            let PhaseSet { nodes, bed, curvature_acceleration: turning, scratch_vectors: spare, .. } =
                &mut set;
            bed.resize(nodes.len(), BedPoint::flat(0.0));
            turning.resize(nodes.len(), 0.0);
            let held = self.holds_any();
            let id = &nodes.id;
            let moves = nodes.position.par_iter_mut().zip(&mut nodes.velocity).zip(&mut nodes.slope);
            moves.zip(bed).zip(turning).enumerate().with_min_len(TASK).for_each(
                |(i, ((((x, v), slope), point), turned))| {
                    let drift = if smoothed { spare[i] } else { *v };
                    *turned = 0.0;
                    let free = carries && !(held && self.is_outside(id[i]));
                    if free && slope[0].is_nan() {
                        *slope = floor.at(x).map_or([0.0; D], |point| point.slope);
                    }
                    if !free {
                        (0..D).for_each(|c| x[c] += dt * drift[c]);
                        if let Some(found) = floor.at(x) {
                            *point = found;
                        }
                        floor.reflect(x, v, point);
                        *slope = point.slope;
                        return;
                    }
                    let (place, found) = half_drift(&floor, x, &drift, slope, dt);
                    *x = place;
                    // Nodes beyond the bed keep the last bed below them until they are removed at the end of the step.
                    let Some(found) = found else { return };
                    *point = found;
                    *v = parallel_transport(v, slope, &point.slope);
                    if turns {
                        let ahead: PlanVector<D> = std::array::from_fn(|c| x[c] + dt * v[c]);
                        *turned =
                            curvature_acceleration(v, slope, point, floor.at(&ahead).as_ref()) / (2.0 * dt);
                    }
                    floor.reflect(x, v, point);
                    *slope = point.slope;
                },
            );
            self.sets[number] = set;
        }
    }

    /// Second half of the drift, after which velocities lie in the tangent planes at the nodes.
    pub(crate) fn second_half_drift(&mut self, dt: f64) {
        let carries = self.uses_parallel_transport();
        let smoothed = self.settings.numerics.xsph > 0.0;
        for number in 0..self.sets.len() {
            let mut set = std::mem::take(&mut self.sets[number]);
            let floor = BedPath { bed: &self.bed, ends: &self.ends, open: self.ends.are_open() };
            let PhaseSet { nodes, bed, scratch_vectors: spare, .. } = &mut set;
            let held = self.holds_any();
            let id = &nodes.id;
            let moves = nodes.position.par_iter_mut().zip(&mut nodes.velocity).zip(&mut nodes.slope);
            moves.zip(&*bed).enumerate().with_min_len(TASK).for_each(|(i, (((x, v), slope), point))| {
                let drift = if smoothed { spare[i] } else { *v };
                (0..D).for_each(|c| x[c] += dt * drift[c]);
                let free = carries && !(held && self.is_outside(id[i]));
                let mut last = floor.at(x).filter(|_| carries).unwrap_or(*point);
                if free {
                    *v = parallel_transport(v, &point.slope, &last.slope);
                }
                floor.reflect(x, v, &mut last);
                *slope = last.slope;
            });
            self.sets[number] = set;
        }
    }

    /// Transports velocities into the planes of a bed that has changed below the nodes (sheet: depth-sph §2.9, item 9 as amended).
    pub(crate) fn transport_velocities(&mut self) {
        if !self.uses_parallel_transport() {
            return;
        }
        let floor = BedPath { bed: &self.bed, ends: &self.ends, open: self.ends.are_open() };
        for set in &mut self.sets {
            let nodes = &mut set.nodes;
            let moves = nodes.position.par_iter().zip(&mut nodes.velocity).zip(&mut nodes.slope);
            moves.with_min_len(TASK).for_each(|((x, v), slope)| {
                let Some(found) = floor.at(x) else { return };
                if !slope[0].is_nan() {
                    *v = parallel_transport(v, slope, &found.slope);
                }
                *slope = found.slope;
            });
        }
    }

    /// Bed at a position, mirrored and repeated beyond walls and ends of periods; `None` where there is none.
    pub(crate) fn floor_at(&self, x: &PlanVector<D>) -> Option<BedPoint<D>> {
        BedPath { bed: &self.bed, ends: &self.ends, open: self.ends.are_open() }.at(x)
    }

    /// Whether there are nodes behind a line of inflow or beyond an open side.
    fn holds_any(&self) -> bool {
        !(self.waiting_nodes.nodes.is_empty() && self.open_boundaries.is_empty())
    }
}

/// Acceleration along the normal of the bed, times the time step, of a velocity in the middle of it that follows the bed: from the
/// slope at its beginning to that ahead (m/s; sheet: depth-sph §2.9, item 5 as amended).
fn curvature_acceleration<const D: usize>(
    v: &PlanVector<D>,
    before: &PlanVector<D>,
    here: &BedPoint<D>,
    ahead: Option<&BedPoint<D>>,
) -> f64 {
    let rise = dot(&here.slope, v);
    let after = ahead.map_or(0.0, |ahead| (dot(&ahead.slope, v) - rise) / ahead.steepness().sqrt());
    after + (rise - dot(before, v)) / (1.0 + dot(before, before)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_carried_keeps_its_size_and_comes_back() {
        let (v, a, b) = ([3.0, -1.0], [0.4, 1.3], [-2.0, 0.3]);
        let w = parallel_transport(&v, &a, &b);
        assert!((dot_along_bed(&a, &v, &v) - dot_along_bed(&b, &w, &w)).abs() < 1e-12);
        let back = parallel_transport(&w, &b, &a);
        assert!((0..2).all(|c| (back[c] - v[c]).abs() < 1e-12));
    }

    /// Along a circular arc all of the rotation is in the plane of the motion.
    #[test]
    fn a_profile_keeps_the_speed_along_its_bed() {
        let w = parallel_transport(&[2.0], &[0.0], &[-1.0]);
        assert!((w[0] - 2f64.sqrt()).abs() < 1e-15, "{w:?}");
    }
}
