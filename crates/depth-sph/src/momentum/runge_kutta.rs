//! Explicit Runge–Kutta steps (sheet: depth-sph §3.4).

use crate::config::choices::Phases;
use crate::context::FlowContext;
use crate::energy_balance::balance::EnergyBalance;
use crate::energy_balance::works::{add_resistance_work, add_stage_work};
use crate::flow_nodes::FlowNodes;
use crate::momentum::accelerations::evaluate;
use crate::momentum::effective_gravity::BedSampling;
use crate::momentum::resistance::apply_resistance;
use crate::momentum::thickness_rates::find_thickness_rates;
use crate::momentum::velocities::{store_start_velocities, store_velocities};
use crate::phases::failure::FlowFailure;
use crate::phases::phase::PhaseSet;
use crate::points::image_nodes::PlanBoundaries;
use crate::points::phase_nodes::PlanVector;

/// State of a node set at the beginning of a Runge–Kutta step, and the weighted sums of the rates of its stages.
#[derive(Clone, Debug, Default)]
struct StageSums<const D: usize> {
    position: Vec<PlanVector<D>>,
    velocity: Vec<PlanVector<D>>,
    partial_thickness: Vec<f64>,
    rates: [Vec<PlanVector<D>>; 2],
    thickness_rate: Vec<f64>,
}

/// Explicit Runge–Kutta step of `dt` (s): each stage with its time and its weight.
pub(super) fn runge_kutta<const D: usize>(
    context: &FlowContext<'_, D>,
    nodes: &mut FlowNodes<D>,
    balance: &mut EnergyBalance,
    dt: f64,
    stages: &[(f64, f64)],
) -> Result<(), FlowFailure> {
    let FlowContext { clock, settings, boundary, limits, .. } = *context;
    if settings.phases == Phases::Two {
        store_start_velocities(&mut nodes.sets);
    }
    let rates = settings.numerics.continuity.is_rate();
    let mut sums: Vec<StageSums<D>> = nodes.sets.iter().map(StageSums::from_set).collect();
    for (number, (place, weight)) in stages.iter().enumerate() {
        if number > 0 {
            for (set, sums) in nodes.sets.iter_mut().zip(&sums) {
                sums.set_stage(set, place * dt, rates);
            }
            reflect(&boundary.walls, &mut nodes.sets);
        }
        // Pore pressure stays that of the beginning of the step.
        evaluate(context, nodes, dt, (number == 0).then_some(clock.time), BedSampling::Required)?;
        if rates {
            find_thickness_rates(&settings.numerics, &mut nodes.sets);
        }
        add_stage_work(settings, boundary, &mut nodes.sets, balance, weight * dt);
        for (set, sums) in nodes.sets.iter_mut().zip(&mut sums) {
            sums.add(set, weight * dt, rates);
        }
    }
    for (set, sums) in nodes.sets.iter_mut().zip(sums) {
        sums.set_result(set, rates);
    }
    reflect(&boundary.walls, &mut nodes.sets);
    store_velocities(&mut nodes.sets);
    apply_resistance(settings, limits, nodes, dt);
    boundary.hold_velocities(&mut nodes.sets);
    add_resistance_work(settings, boundary, &mut nodes.sets, balance);
    Ok(())
}

/// Reflects nodes that have passed a wall.
fn reflect<const D: usize>(walls: &PlanBoundaries<D>, sets: &mut [PhaseSet<D>]) {
    if walls.are_open() {
        return;
    }
    for set in sets {
        for (x, v) in set.nodes.position.iter_mut().zip(&mut set.nodes.velocity) {
            walls.reflect(x, v);
        }
    }
}

impl<const D: usize> StageSums<D> {
    /// Initial values of the sums of a Runge–Kutta step, from the state of a node set.
    fn from_set(set: &PhaseSet<D>) -> Self {
        let zero = vec![[0.0; D]; set.nodes.len()];
        Self {
            position: set.nodes.position.clone(),
            velocity: set.nodes.velocity.clone(),
            partial_thickness: set.nodes.partial_thickness.clone(),
            thickness_rate: vec![0.0; zero.len()],
            rates: [zero.clone(), zero],
        }
    }

    /// Sets the state after `dt` (s) with the rates of the previous stage. Heights by summation follow from the next summation.
    fn set_stage(&self, set: &mut PhaseSet<D>, dt: f64, with_heights: bool) {
        let nodes = &mut set.nodes;
        for i in 0..nodes.len() {
            for c in 0..D {
                nodes.position[i][c] = self.position[i][c] + dt * nodes.velocity[i][c];
                nodes.velocity[i][c] = self.velocity[i][c] + dt * set.acceleration[i][c];
            }
            if with_heights {
                nodes.partial_thickness[i] = self.partial_thickness[i] + dt * set.rate[i];
            }
        }
    }

    /// Adds the rates of a stage with the weight `dt` (s).
    fn add(&mut self, set: &PhaseSet<D>, dt: f64, with_heights: bool) {
        for i in 0..set.nodes.len() {
            for c in 0..D {
                self.rates[0][i][c] += dt * set.nodes.velocity[i][c];
                self.rates[1][i][c] += dt * set.acceleration[i][c];
            }
            if with_heights {
                self.thickness_rate[i] += dt * set.rate[i];
            }
        }
    }

    /// Sets the state at the end of the step. Heights by summation stay those of the last stage.
    fn set_result(self, set: &mut PhaseSet<D>, with_heights: bool) {
        let nodes = &mut set.nodes;
        for i in 0..nodes.len() {
            for c in 0..D {
                nodes.position[i][c] = self.position[i][c] + self.rates[0][i][c];
                nodes.velocity[i][c] = self.velocity[i][c] + self.rates[1][i][c];
            }
            if with_heights {
                nodes.partial_thickness[i] = self.partial_thickness[i] + self.thickness_rate[i];
            }
        }
    }
}
