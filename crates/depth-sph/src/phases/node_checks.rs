//! Checks of the nodes that end a run (sheet: depth-sph §2.9, item 8 as amended).

use colluvium_case::FailureReason;
use rayon::prelude::*;

use crate::bed::Bed;
use crate::config::settings::FlowSettings;
use crate::phases::failure::FlowFailure;
use crate::phases::limits::FlowLimits;
use crate::phases::phase::PhaseSet;
use crate::points::MIN_NODES_PER_TASK;
use crate::points::phase_nodes::{PhaseNodes, norm};

/// Ratio of the speed of a node to the speed that gravity can cause, above which the run ends with an error.
const MAX_SPEED_RATIO: f64 = 3.0;

/// Checks all nodes at the end of a step.
///
/// # Errors
/// The first node that has failed.
pub fn check_nodes<const D: usize>(
    settings: &FlowSettings<D>,
    bed: &Bed<D>,
    limits: &FlowLimits,
    sets: &[PhaseSet<D>],
) -> Result<(), FlowFailure> {
    for set in sets {
        let failed = |i: usize| failure_of(settings, bed, limits, set, i);
        let found = (0..set.nodes.len())
            .into_par_iter()
            .with_min_len(MIN_NODES_PER_TASK)
            .find_map_first(|i| failed(i).is_some().then_some(i));
        if let Some(i) = found {
            return Err(FlowFailure::at_node(set, i, failed(i).unwrap_or_default()));
        }
    }
    Ok(())
}

/// Checks that positions, velocities and smoothing lengths are finite before neighbours are searched.
///
/// # Errors
/// The first node with a number that is not finite.
pub fn check_numbers<const D: usize>(sets: &[PhaseSet<D>]) -> Result<(), FlowFailure> {
    for set in sets {
        let PhaseNodes { position, velocity, length, .. } = &set.nodes;
        let failed = |i: usize| {
            let all = position[i].iter().chain(&velocity[i]).chain([&length[i]]);
            (!all.fold(0.0, |sum, x| sum + 0.0 * x).is_finite()).then_some(i)
        };
        let Some(i) = (0..set.len()).into_par_iter().with_min_len(MIN_NODES_PER_TASK).find_map_first(failed)
        else {
            continue;
        };
        let reason = if position[i].iter().all(|x| x.is_finite()) {
            format!(
                "its velocity, {:?} m/s, or its smoothing length, {} m, is not finite",
                velocity[i], length[i]
            )
        } else {
            "its position is not finite".to_owned()
        };
        return Err(FlowFailure::at_node(set, i, FailureReason::NotFinite(reason)));
    }
    Ok(())
}

/// Failure of a node, if a value is not finite or the speed exceeds three times that which gravity can cause (sheet: depth-sph §2.9, item 8
/// as amended).
fn failure_of<const D: usize>(
    settings: &FlowSettings<D>,
    bed: &Bed<D>,
    limits: &FlowLimits,
    set: &PhaseSet<D>,
    i: usize,
) -> Option<String> {
    let nodes = &set.nodes;
    let speed = norm(&nodes.velocity[i]);
    let place = nodes.position[i];
    if !(speed.is_finite() && place.iter().all(|x| x.is_finite()) && nodes.partial_thickness[i].is_finite()) {
        return Some(format!(
            "its position, its velocity, {:?} m/s, or its height, {} m, is not finite",
            nodes.velocity[i], nodes.partial_thickness[i]
        ));
    }
    if nodes.partial_thickness[i] < 0.0 {
        return Some(format!("its height, {} m, is negative", nodes.partial_thickness[i]));
    }
    let here = &set.bed[i];
    let speed = here.speed(&nodes.velocity[i]);
    // Within a step the level changes by no more than the slope over a cell.
    let cell = bed.cell().unwrap_or(0.0) * here.steepness().sqrt();
    let fall = (limits.max_initial_level - here.level).max(0.0) + nodes.depth[i] + cell;
    let plan_gravity = norm(&settings.plan_gravity);
    // Along a tilted frame the bed does not fall: gravity does its work along it.
    let run = (0..D).map(|c| (place[c] - nodes.origin[i][c]).abs()).fold(0.0, f64::max);
    let given = (2.0 * (settings.gravity * fall + plan_gravity * run)).sqrt();
    (speed > MAX_SPEED_RATIO * (given + limits.max_initial_speed)).then(|| {
        format!(
            "its speed along the bed, {speed:.3e} m/s, is more than {MAX_SPEED_RATIO} times the speed \
             that it can gain by gravity, {given:.3e} m/s: reduce `courant` or `spacing`, or increase \
             `terrain_smoothing`"
        )
    })
}
