//! Drift over a curved bed: velocities are transported from the tangent plane at one position to that at the next, by the rotation of
//! one normal into the other, so that speed along the bed is kept (sheet: depth-sph §2.9, as amended).

use rayon::prelude::*;

use crate::bed::bed_path::{BedPath, parallel_transport};
use crate::bed::{Bed, BedPoint};
use crate::boundary::FlowBoundaries;
use crate::config::settings::FlowSettings;
use crate::phases::phase::PhaseSet;
use crate::points::MIN_NODES_PER_TASK;
use crate::points::image_nodes::PlanBoundaries;
use crate::points::phase_nodes::{PlanVector, dot};

/// First half of the drift of a node with transport of its velocity along the bed. The velocity at the end of the half is iterated once,
/// which makes the drift of second order. Returns the position, and the bed there.
#[inline]
fn half_drift<const D: usize>(
    path: &BedPath<'_, D>,
    x: &PlanVector<D>,
    drift: &PlanVector<D>,
    slope: &PlanVector<D>,
    dt: f64,
) -> (PlanVector<D>, Option<BedPoint<D>>) {
    let after = |v: &PlanVector<D>| std::array::from_fn(|c| x[c] + dt * v[c]);
    let guess = after(drift);
    let Some(there) = path.bed_point(&guess) else { return (guess, None) };
    let place = after(&parallel_transport(drift, slope, &there.slope));
    (place, path.bed_point(&place))
}

/// First half of the drift, over `dt` (s), to the positions at which the bed is sampled in the middle of the step.
pub(crate) fn first_half_drift<const D: usize>(
    settings: &FlowSettings<D>,
    bed: &Bed<D>,
    boundary: &FlowBoundaries<D>,
    sets: &mut [PhaseSet<D>],
    dt: f64,
) {
    let carries = bed.transports_velocities(settings);
    let turns = carries && settings.curvature_in_friction && settings.has_resistance();
    let smoothed = settings.numerics.xsph > 0.0;
    let path = BedPath::new(bed, &boundary.walls);
    let has_outside = boundary.has_outside_nodes();
    for set in sets {
        let PhaseSet { nodes, bed, curvature_acceleration, scratch_vectors, .. } = set;
        bed.resize(nodes.len(), BedPoint::horizontal(0.0));
        curvature_acceleration.resize(nodes.len(), 0.0);
        let id = &nodes.id;
        let moves = nodes.position.par_iter_mut().zip(&mut nodes.velocity).zip(&mut nodes.slope);
        moves.zip(bed).zip(curvature_acceleration).enumerate().with_min_len(MIN_NODES_PER_TASK).for_each(
            |(i, ((((x, v), slope), point), curvature))| {
                let drift = if smoothed { scratch_vectors[i] } else { *v };
                *curvature = 0.0;
                let free = carries && !(has_outside && boundary.is_outside(id[i]));
                if free && slope[0].is_nan() {
                    *slope = path.bed_point(x).map_or([0.0; D], |point| point.slope);
                }
                if !free {
                    (0..D).for_each(|c| x[c] += dt * drift[c]);
                    if let Some(found) = path.bed_point(x) {
                        *point = found;
                    }
                    path.reflect(x, v, point);
                    *slope = point.slope;
                    return;
                }
                let (place, found) = half_drift(&path, x, &drift, slope, dt);
                *x = place;
                // Nodes beyond the bed keep the last bed below them until they are removed at the end of the step.
                let Some(found) = found else { return };
                *point = found;
                *v = parallel_transport(v, slope, &point.slope);
                if turns {
                    let ahead: PlanVector<D> = std::array::from_fn(|c| x[c] + dt * v[c]);
                    *curvature = curvature_acceleration_dt(v, slope, point, path.bed_point(&ahead).as_ref())
                        / (2.0 * dt);
                }
                path.reflect(x, v, point);
                *slope = point.slope;
            },
        );
    }
}

/// Second half of the drift, after which the velocities lie in the tangent planes of the bed at the nodes.
pub(crate) fn second_half_drift<const D: usize>(
    settings: &FlowSettings<D>,
    bed: &Bed<D>,
    boundary: &FlowBoundaries<D>,
    sets: &mut [PhaseSet<D>],
    dt: f64,
) {
    let carries = bed.transports_velocities(settings);
    let smoothed = settings.numerics.xsph > 0.0;
    let path = BedPath::new(bed, &boundary.walls);
    let has_outside = boundary.has_outside_nodes();
    for set in sets {
        let PhaseSet { nodes, bed, scratch_vectors, .. } = set;
        let id = &nodes.id;
        let moves = nodes.position.par_iter_mut().zip(&mut nodes.velocity).zip(&mut nodes.slope);
        moves.zip(&*bed).enumerate().with_min_len(MIN_NODES_PER_TASK).for_each(
            |(i, (((x, v), slope), point))| {
                let drift = if smoothed { scratch_vectors[i] } else { *v };
                (0..D).for_each(|c| x[c] += dt * drift[c]);
                let free = carries && !(has_outside && boundary.is_outside(id[i]));
                let mut last = path.bed_point(x).filter(|_| carries).unwrap_or(*point);
                if free {
                    *v = parallel_transport(v, &point.slope, &last.slope);
                }
                path.reflect(x, v, &mut last);
                *slope = last.slope;
            },
        );
    }
}

/// Transports velocities into the planes of a bed that has changed below the nodes (sheet: depth-sph §2.9, item 9 as amended).
pub(crate) fn transport_velocities<const D: usize>(
    settings: &FlowSettings<D>,
    bed: &Bed<D>,
    walls: &PlanBoundaries<D>,
    sets: &mut [PhaseSet<D>],
) {
    if !bed.transports_velocities(settings) {
        return;
    }
    let path = BedPath::new(bed, walls);
    for set in sets {
        let nodes = &mut set.nodes;
        let moves = nodes.position.par_iter().zip(&mut nodes.velocity).zip(&mut nodes.slope);
        moves.with_min_len(MIN_NODES_PER_TASK).for_each(|((x, v), slope)| {
            let Some(found) = path.bed_point(x) else { return };
            if !slope[0].is_nan() {
                *v = parallel_transport(v, slope, &found.slope);
            }
            *slope = found.slope;
        });
    }
}

/// Normal acceleration of a velocity that follows the bed, times the time step (m/s), from the slopes at the start and ahead (sheet:
/// depth-sph §2.9, item 5 as amended).
fn curvature_acceleration_dt<const D: usize>(
    v: &PlanVector<D>,
    before: &PlanVector<D>,
    here: &BedPoint<D>,
    ahead: Option<&BedPoint<D>>,
) -> f64 {
    let rise = dot(&here.slope, v);
    let after = ahead.map_or(0.0, |ahead| (dot(&ahead.slope, v) - rise) / ahead.steepness().sqrt());
    after + (rise - dot(before, v)) / (1.0 + dot(before, before)).sqrt()
}
