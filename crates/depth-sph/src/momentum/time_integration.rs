//! Steps 1 to 7: time integration by leapfrog, midpoint rule or classical fourth order (sheet: depth-sph §3.4).

use rayon::prelude::*;

use crate::config::choices::{Phases, TimeScheme};
#[cfg(test)]
use crate::config::settings::FlowSettings;
use crate::context::FlowContext;
use crate::energy_balance::balance::EnergyBalance;
use crate::energy_balance::works::add_step_work;
use crate::flow_nodes::FlowNodes;
use crate::momentum::accelerations::evaluate;
use crate::momentum::curved_drift::{first_half_drift, second_half_drift};
use crate::momentum::effective_gravity::BedSampling;
use crate::momentum::resistance::apply_resistance;
use crate::momentum::runge_kutta::runge_kutta;
use crate::momentum::thickness_rates::find_thickness_rates;
use crate::momentum::velocities::{smooth_velocities, store_start_velocities, store_velocities};
use crate::phases::failure::FlowFailure;
use crate::phases::phase::PhaseSet;
use crate::points::MIN_NODES_PER_TASK;

/// Integrates positions and velocities over a step of `dt` (s), with drag and the resistance of the bed.
///
/// # Errors
/// The first node that a neighbour search cannot locate.
pub(crate) fn integrate<const D: usize>(
    context: &FlowContext<'_, D>,
    nodes: &mut FlowNodes<D>,
    balance: &mut EnergyBalance,
    dt: f64,
) -> Result<(), FlowFailure> {
    /// Stages of the midpoint scheme: fraction of the step, and weight of the rates of the stage in their mean.
    const MIDPOINT: [(f64, f64); 2] = [(0.0, 0.0), (0.5, 1.0)];
    /// Stages of the classical fourth-order scheme: fraction of the step, and weight of the rates of the stage in their mean.
    const CLASSICAL: [(f64, f64); 4] =
        [(0.0, 1.0 / 6.0), (0.5, 1.0 / 3.0), (0.5, 1.0 / 3.0), (1.0, 1.0 / 6.0)];
    match context.settings.numerics.integration {
        TimeScheme::Leapfrog => leapfrog(context, nodes, balance, dt),
        TimeScheme::RungeKutta2 => runge_kutta(context, nodes, balance, dt, &MIDPOINT),
        TimeScheme::RungeKutta4 => runge_kutta(context, nodes, balance, dt, &CLASSICAL),
    }
}

/// Leapfrog step: half a drift, a kick, half a drift.
fn leapfrog<const D: usize>(
    context: &FlowContext<'_, D>,
    nodes: &mut FlowNodes<D>,
    balance: &mut EnergyBalance,
    dt: f64,
) -> Result<(), FlowFailure> {
    let FlowContext { clock, settings, bed, boundary, limits } = *context;
    smooth_velocities(settings, &boundary.walls, &mut nodes.sets)?;
    first_half_drift(settings, bed, boundary, &mut nodes.sets, 0.5 * dt); // 7
    if settings.phases == Phases::Two {
        store_start_velocities(&mut nodes.sets);
    }
    evaluate(context, nodes, dt, Some(clock.time + 0.5 * dt), BedSampling::AlreadySampled)?; // 1 to 4, 9
    store_velocities(&mut nodes.sets);
    #[cfg(test)]
    scale_pressure_for_test(settings, &mut nodes.sets);
    add_accelerations(&mut nodes.sets, dt); // 4
    apply_resistance(settings, limits, nodes, dt); // 5, 6
    #[cfg(test)]
    scale_resistance_for_test(settings, &mut nodes.sets, dt);
    boundary.hold_velocities(&mut nodes.sets); // 10
    add_step_work(settings, boundary, &mut nodes.sets, balance, dt);
    if settings.numerics.continuity.is_rate() {
        find_thickness_rates(&settings.numerics, &mut nodes.sets);
        integrate_thickness(&mut nodes.sets, dt);
    }
    smooth_velocities(settings, &boundary.walls, &mut nodes.sets)?;
    second_half_drift(settings, bed, boundary, &mut nodes.sets, 0.5 * dt); // 7
    Ok(())
}

/// Adds the accelerations over `dt` (s) to the velocities.
fn add_accelerations<const D: usize>(sets: &mut [PhaseSet<D>], dt: f64) {
    for set in sets {
        let kicks = set.nodes.velocity.par_iter_mut().zip(&set.acceleration);
        kicks.with_min_len(MIN_NODES_PER_TASK).for_each(|(v, a)| {
            for c in 0..D {
                v[c] += dt * a[c];
            }
        });
    }
}

/// Adds the rates of height over `dt` (s) to the heights.
fn integrate_thickness<const D: usize>(sets: &mut [PhaseSet<D>], dt: f64) {
    for set in sets {
        for (height, rate) in set.nodes.partial_thickness.iter_mut().zip(&set.rate) {
            *height += dt * rate;
        }
    }
}

/// Multiplies pressure by the factor of a test.
#[cfg(test)]
fn scale_pressure_for_test<const D: usize>(settings: &FlowSettings<D>, sets: &mut [PhaseSet<D>]) {
    let (factor, drive) = (settings.numerics.test_factors[1] - 1.0, settings.plan_gravity);
    for set in sets {
        for (i, a) in set.acceleration.iter_mut().enumerate() {
            let (bed, viscous) = (&set.bed[i], &set.viscous[i]);
            for c in 0..D {
                a[c] += factor * (a[c] - viscous[c] + set.reaction[i] * bed.slope[c] - drive[c]);
            }
        }
    }
}

/// Multiplies the resistance to the kick by the factor of a test.
#[cfg(test)]
fn scale_resistance_for_test<const D: usize>(settings: &FlowSettings<D>, sets: &mut [PhaseSet<D>], dt: f64) {
    let factor = settings.numerics.test_factors[0];
    for set in sets {
        for (i, v) in set.nodes.velocity.iter_mut().enumerate() {
            for c in 0..D {
                let kicked = set.stored_velocity[i][c] + dt * set.acceleration[i][c];
                v[c] = kicked + factor * (v[c] - kicked);
            }
        }
    }
}
