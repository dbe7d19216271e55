//! Works of the forces of a step, for the energy balance (sheet: depth-sph §2.9, item 7 as amended).

use rayon::prelude::*;

use crate::bed::bed_path::dot_along_bed;
use crate::boundary::FlowBoundaries;
use crate::config::choices::Phases;
use crate::config::settings::FlowSettings;
use crate::energy_balance::balance::{EnergyBalance, metric_slope};
use crate::phases::phase::PhaseSet;
use crate::points::MIN_NODES_PER_TASK;
use crate::points::phase_nodes::PlanVector;

/// Adds the work of a step: of the forces over `dt` (s) from the stored velocities on, and of the bed resistance.
pub(crate) fn add_step_work<const D: usize>(
    settings: &FlowSettings<D>,
    boundary: &FlowBoundaries<D>,
    sets: &mut [PhaseSet<D>],
    balance: &mut EnergyBalance,
    dt: f64,
) {
    let mean_velocity = |set: &PhaseSet<D>, i: usize| -> PlanVector<D> {
        let (old, new) = (&set.stored_velocity[i], &set.nodes.velocity[i]);
        std::array::from_fn(|c| 0.5 * (old[c] + new[c]))
    };
    balance.applied_work += body_force_work(settings, boundary, sets, dt, mean_velocity);
    let works = sum_works(settings, boundary, sets, |set, i| {
        let slope = metric_slope(settings, &set.bed[i]);
        let (old, new) = (&set.stored_velocity[i], &set.nodes.velocity[i]);
        let mean: PlanVector<D> = std::array::from_fn(|c| 0.5 * (old[c] + new[c]));
        let held: PlanVector<D> = std::array::from_fn(|c| new[c] - old[c] - dt * set.acceleration[i][c]);
        let [viscous, pressure] = force_works(settings, set, i, dt, &mean);
        [dot_along_bed(&slope, &held, &mean), viscous, pressure]
    });
    balance.add_works(works);
}

/// Adds the work of the forces in a Runge–Kutta stage of weight `dt` (s), and of the resistance since the stored velocities.
pub(crate) fn add_stage_work<const D: usize>(
    settings: &FlowSettings<D>,
    boundary: &FlowBoundaries<D>,
    sets: &mut [PhaseSet<D>],
    balance: &mut EnergyBalance,
    dt: f64,
) {
    balance.applied_work += body_force_work(settings, boundary, sets, dt, |set, i| set.nodes.velocity[i]);
    let works = sum_works(settings, boundary, sets, |set, i| {
        let [viscous, pressure] = force_works(settings, set, i, dt, &set.nodes.velocity[i]);
        [0.0, viscous, pressure]
    });
    balance.add_works(works);
}

/// Adds the work of the bed resistance since the velocities were stored.
pub(crate) fn add_resistance_work<const D: usize>(
    settings: &FlowSettings<D>,
    boundary: &FlowBoundaries<D>,
    sets: &mut [PhaseSet<D>],
    balance: &mut EnergyBalance,
) {
    let works = sum_works(settings, boundary, sets, |set, i| {
        let slope = metric_slope(settings, &set.bed[i]);
        let (old, new) = (&set.stored_velocity[i], &set.nodes.velocity[i]);
        let work = dot_along_bed(&slope, new, new) - dot_along_bed(&slope, old, old);
        [0.5 * work, 0.0, 0.0]
    });
    balance.add_works(works);
}

/// Work of the body force of a program over `dt` (s) at velocities (m/s) of the nodes (J), summed in their order.
fn body_force_work<const D: usize>(
    settings: &FlowSettings<D>,
    boundary: &FlowBoundaries<D>,
    sets: &[PhaseSet<D>],
    dt: f64,
    velocity: impl Fn(&PhaseSet<D>, usize) -> PlanVector<D>,
) -> f64 {
    let mut sum = 0.0;
    for (number, set) in sets.iter().enumerate() {
        let density = settings.set_density(sets.len(), number);
        for (i, acceleration) in set.nodes.body_acceleration.iter().enumerate() {
            if !boundary.is_outside(set.nodes.id[i]) {
                let slope = metric_slope(settings, &set.bed[i]);
                let power = dot_along_bed(&slope, acceleration, &velocity(set, i));
                sum += dt * density * set.nodes.volume[i] * power;
            }
        }
    }
    sum
}

/// Work per mass of viscosity and pressure over `dt` (s) at a velocity (J/kg).
#[inline]
fn force_works<const D: usize>(
    settings: &FlowSettings<D>,
    set: &PhaseSet<D>,
    i: usize,
    dt: f64,
    velocity: &PlanVector<D>,
) -> [f64; 2] {
    let (bed, viscous) = (&set.bed[i], &set.viscous[i]);
    let (all, reaction) = (&set.acceleration[i], set.reaction[i]);
    let slope = metric_slope(settings, bed);
    let mut pressure: PlanVector<D> =
        std::array::from_fn(|c| all[c] - viscous[c] + reaction * bed.slope[c] - settings.plan_gravity[c]);
    if let Some(of_program) = set.nodes.body_acceleration.get(i) {
        (0..D).for_each(|c| pressure[c] -= of_program[c]);
    }
    [dt * dot_along_bed(&slope, viscous, velocity), dt * dot_along_bed(&slope, &pressure, velocity)]
}

/// Sums the work of friction, viscosity and pressure over the nodes (J), in the order of the nodes. Resistance never adds energy: in a
/// single phase at no node, in two phases in no step.
fn sum_works<const D: usize>(
    settings: &FlowSettings<D>,
    boundary: &FlowBoundaries<D>,
    sets: &mut [PhaseSet<D>],
    one: impl Fn(&PhaseSet<D>, usize) -> [f64; 3] + Sync,
) -> [f64; 3] {
    let single = settings.phases == Phases::One;
    let has_outside = boundary.has_outside_nodes();
    let (count, mut sums) = (sets.len(), [0.0; 3]);
    for (number, set) in sets.iter_mut().enumerate() {
        let density = settings.set_density(count, number);
        let mut works = std::mem::take(&mut set.works_per_step);
        let of_set = &*set;
        let of_node = |i: usize| {
            if has_outside && boundary.is_outside(of_set.nodes.id[i]) {
                return [0.0; 3];
            }
            let mut works = one(of_set, i).map(|work| density * of_set.nodes.volume[i] * work);
            if single {
                works[0] = works[0].min(0.0);
            }
            works
        };
        (0..of_set.len())
            .into_par_iter()
            .with_min_len(MIN_NODES_PER_TASK)
            .map(of_node)
            .collect_into_vec(&mut works);
        for own in &works {
            (0..3).for_each(|k| sums[k] += own[k]);
        }
        set.works_per_step = works;
    }
    sums
}
