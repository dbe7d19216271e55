//! Steps 1 to 4 and 9: accelerations of the nodes at their positions and velocities (sheet: depth-sph §3.4).

use crate::config::choices::{Phases, PressureForceForm};
use crate::config::settings::FlowSettings;
use crate::context::FlowContext;
use crate::flow_nodes::FlowNodes;
use crate::momentum::depth_pressures::{find_earth_pressure, find_phase_pressures, find_single_pressures};
use crate::momentum::effective_gravity::{BedSampling, sample_bed};
use crate::phases::depths::{find_depths, find_heights};
use crate::phases::failure::FlowFailure;
use crate::phases::phase::PhaseSet;

/// Finds all accelerations of the nodes for a step of `dt` (s). Pore pressure is advanced to `time` (s) where that is given.
///
/// # Errors
/// The first node that a neighbour search cannot locate.
pub(super) fn evaluate<const D: usize>(
    context: &FlowContext<'_, D>,
    nodes: &mut FlowNodes<D>,
    dt: f64,
    time: Option<f64>,
    sampling: BedSampling,
) -> Result<(), FlowFailure> {
    let FlowContext { settings, bed, boundary, limits, .. } = *context;
    let FlowNodes { sets, pore_columns, .. } = nodes;
    find_heights(settings, &boundary.walls, sets)?; // 1, 2
    find_depths(settings, limits, sets); // 2
    sample_bed(settings, bed, sets, sampling); // 3
    if let (Some(time), false) = (time, pore_columns.is_empty()) {
        pore_columns.advance(settings, &sets[0], time); // 9
    }
    find_earth_pressure(settings, &mut sets[0]); // 4
    match settings.phases {
        Phases::Two => find_phase_pressures(settings, sets, pore_columns),
        Phases::One | Phases::Layers => find_single_pressures(settings, sets, pore_columns),
    }
    accelerate(settings, sets, dt); // 4
    sets.iter_mut().for_each(add_body_force);
    Ok(())
}

/// Adds the acceleration by a body force of a program, which is that at the start of the step.
fn add_body_force<const D: usize>(set: &mut PhaseSet<D>) {
    for (acceleration, of_program) in set.acceleration.iter_mut().zip(&set.nodes.body_acceleration) {
        (0..D).for_each(|c| acceleration[c] += of_program[c]);
    }
}

/// Computes the accelerations of all nodes.
fn accelerate<const D: usize>(settings: &FlowSettings<D>, sets: &mut [PhaseSet<D>], dt: f64) {
    let roles = [settings.role(0), settings.role(1)];
    let densities = &settings.material.densities;
    let automatic =
        settings.phases == Phases::Two && settings.numerics.momentum == PressureForceForm::Automatic;
    let weak_at = |porosity: f64| settings.drag.relaxation(porosity, 0.0, densities) * dt < 1.0;
    let [first, second] = sets else {
        sets[0].accelerate(settings, roles[0], |_| false, None);
        return;
    };
    let layers = settings.phases == Phases::Layers;
    for role in 0..2 {
        let (set, other) = if role == 0 { (&mut *first, &*second) } else { (&mut *second, &*first) };
        let porosity = set.neighbour_data.porosity.clone();
        let weak = |i: usize| automatic && weak_at(porosity[i]);
        set.accelerate(settings, roles[role], weak, layers.then_some(&other.neighbour_data));
    }
}
