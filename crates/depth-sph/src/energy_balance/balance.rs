//! Energy balance: initial energy, inflow, and the work of forces, each computed from its own force and not as the remainder
//! (sheet: depth-sph §2.9, item 7 as amended).

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::bed::bed_path::{BedPath, dot_along_bed};
use crate::bed::{Bed, BedPoint};
use crate::boundary::FlowBoundaries;
use crate::config::choices::{DepthFrame, Phases};
use crate::config::settings::FlowSettings;
use crate::phases::phase::PhaseSet;
use crate::points::MIN_NODES_PER_TASK;
use crate::points::phase_nodes::PlanVector;

/// Error of the energy balance, as a share of the exchanged energy, above which there is a warning.
const BALANCE_TOLERANCE: f64 = 0.01;
/// Lower bound of the exchanged energy as a share of the pressure energy, for flows that are almost at rest.
const MIN_EXCHANGE_FRACTION: f64 = 0.1;

/// Energies of the material in the flow, without nodes outside its boundaries (J).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FlowEnergies {
    /// Kinetic energy of the motion along the bed.
    pub kinetic: f64,
    /// Potential energy of the level of the bed, and of gravity along the plan.
    pub bed: f64,
    /// Pressure energy, `½ Σ m g_* h`.
    pub pressure: f64,
}

impl FlowEnergies {
    /// Sum of all (J).
    pub fn total(&self) -> f64 {
        self.kinetic + self.bed + self.pressure
    }
}

/// Work and energy exchange since the start, by cause (J).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyBalance {
    /// Energy at the start; none before.
    start: Option<FlowEnergies>,
    /// Dissipation by resistance of the bed, drag and erosion.
    pub friction: f64,
    /// Dissipation by artificial viscosity.
    pub viscosity: f64,
    /// Work of pressure on the flow.
    pub pressure_work: f64,
    /// Work of pressure in the last step.
    last_pressure_work: f64,
    /// Energy of the inflow minus that of the outflow (J).
    pub inflow: f64,
    /// Work of a body force of a program (J).
    pub applied_work: f64,
    /// Energy before a program has changed velocities, until the next step (J).
    before_change: Option<f64>,
    /// Largest kinetic energy so far.
    peak: f64,
}

/// Current energy balance (J).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyBalanceSummary {
    /// Current energy.
    pub current_energy: FlowEnergies,
    /// Error of the energy balance: energy in excess of the exchanged one (J).
    pub error: f64,
    /// Work of the pressure forces minus the decrease of the pressure energy (J).
    pub difference: f64,
    /// Exchanged energy: the largest of drop, kinetic energy and losses.
    pub exchanged_energy: f64,
}

impl EnergyBalanceSummary {
    /// Whether the energy is off by more than a hundredth of the exchanged energy.
    pub fn is_off(&self) -> bool {
        !(self.error.abs() <= BALANCE_TOLERANCE * self.exchanged_energy)
    }
}

/// Bed slope in the metric of speeds and energies (-); zero in the small-slope approximation.
#[inline]
pub(super) fn metric_slope<const D: usize>(settings: &FlowSettings<D>, bed: &BedPoint<D>) -> PlanVector<D> {
    if settings.frame == DepthFrame::Horizontal { bed.slope } else { [0.0; D] }
}

/// Energies of a node (J), from the bed below it. A node outside the bed has the bed point at which it left.
fn node_energies<const D: usize>(
    settings: &FlowSettings<D>,
    path: &BedPath<'_, D>,
    set: &PhaseSet<D>,
    i: usize,
    density: f64,
) -> FlowEnergies {
    let nodes = &set.nodes;
    let mass = density * nodes.volume[i];
    let x = &nodes.position[i];
    let bed = path.bed_point(x).or_else(|| set.bed.get(i).copied()).unwrap_or(BedPoint::horizontal(0.0));
    let v = &nodes.velocity[i];
    let drive = &settings.plan_gravity;
    let run: f64 = (0..D).map(|c| drive[c] * (x[c] - nodes.origin[i][c])).sum();
    FlowEnergies {
        kinetic: 0.5 * mass * dot_along_bed(&metric_slope(settings, &bed), v, v),
        bed: mass * (settings.gravity * bed.level - run),
        pressure: 0.5 * mass * nodes.effective_gravity[i] * nodes.depth[i],
    }
}

/// Energies of the material in the flow, without nodes outside its boundaries (J).
pub fn energies<const D: usize>(
    settings: &FlowSettings<D>,
    bed: &Bed<D>,
    boundary: &FlowBoundaries<D>,
    sets: &[PhaseSet<D>],
) -> FlowEnergies {
    let mut sum = FlowEnergies::default();
    let path = BedPath::new(bed, &boundary.walls);
    for (number, set) in sets.iter().enumerate() {
        let density = settings.set_density(sets.len(), number);
        let one = |i: usize| {
            if boundary.is_outside(set.nodes.id[i]) {
                FlowEnergies::default()
            } else {
                node_energies(settings, &path, set, i, density)
            }
        };
        for own in
            (0..set.len()).into_par_iter().with_min_len(MIN_NODES_PER_TASK).map(one).collect::<Vec<_>>()
        {
            sum.kinetic += own.kinetic;
            sum.bed += own.bed;
            sum.pressure += own.pressure;
        }
    }
    sum
}

/// Whether the pressure has an energy that is a function of depth: for a single phase without earth pressure. Otherwise its work is summed.
fn pressure_has_energy<const D: usize>(settings: &FlowSettings<D>) -> bool {
    settings.phases == Phases::One && settings.earth_pressure.is_none()
}

impl EnergyBalance {
    /// Starts the balance before the first step, with the energy at present.
    pub fn start_with(&mut self, energies: impl FnOnce() -> FlowEnergies) {
        if self.start.is_none() {
            self.start = Some(energies());
        }
    }

    /// Whether the balance has started.
    pub fn has_started(&self) -> bool {
        self.start.is_some()
    }

    /// Energy balance with the energy at present.
    pub fn summary<const D: usize>(
        &self,
        settings: &FlowSettings<D>,
        mut current_energy: FlowEnergies,
    ) -> EnergyBalanceSummary {
        let changed = self.before_change.map_or(0.0, |before| current_energy.total() - before);
        let input = self.inflow + self.applied_work + changed;
        // Heights are those of the middle of the last step.
        current_energy.pressure -= 0.5 * self.last_pressure_work;
        let start = self.start.unwrap_or(current_energy);
        let difference = self.pressure_work + current_energy.pressure - start.pressure;
        let pressure = if pressure_has_energy(settings) {
            current_energy.pressure
        } else {
            start.pressure - self.pressure_work
        };
        let lost = self.friction + self.viscosity;
        let error = current_energy.kinetic + current_energy.bed + pressure + lost - start.total() - input;
        let drop = start.bed + start.pressure - current_energy.bed - current_energy.pressure + input;
        let largest = drop.max(lost).max(self.peak).max(current_energy.kinetic);
        EnergyBalanceSummary {
            current_energy,
            error,
            difference,
            exchanged_energy: largest.max(MIN_EXCHANGE_FRACTION * current_energy.pressure),
        }
    }

    /// Adds an external change of the flow to the balance; its energy counts as inflow.
    pub fn add_external_change(&mut self, before: f64, after: f64) {
        self.inflow += after - before;
    }

    /// Records the energy before a program changes velocities, once the balance has started.
    pub fn begin_program_change(&mut self, energy: impl FnOnce() -> f64) {
        if self.has_started() && self.before_change.is_none() {
            self.before_change = Some(energy());
        }
    }

    /// Adds the change of velocities by a program to the balance before a step; its energy counts as inflow.
    pub fn end_program_change(&mut self, energy: impl FnOnce() -> f64) {
        if let Some(before) = self.before_change.take() {
            self.add_external_change(before, energy());
        }
    }

    /// Adds an inflow to the balance: energy of the material, and an equal work of the pressure at the inlet.
    pub fn add_inflow(&mut self, before: &FlowEnergies, after: &FlowEnergies) {
        self.inflow += after.total() - before.total() + after.pressure - before.pressure;
    }

    /// Adds erosion to the balance: the kinetic energy that nodes lose counts as friction.
    pub fn add_erosion(&mut self, before: &FlowEnergies, after: &FlowEnergies) {
        self.add_inflow(before, after);
        let lost = before.kinetic - after.kinetic;
        self.friction += lost;
        self.inflow += lost;
    }

    /// Adds the work of friction, viscosity and pressure to the balance (J).
    pub(super) fn add_works(&mut self, [friction, viscosity, pressure]: [f64; 3]) {
        self.friction -= friction.min(0.0);
        self.viscosity -= viscosity.min(0.0);
        self.pressure_work += pressure;
        self.last_pressure_work = pressure;
    }

    /// Updates the largest kinetic energy (J).
    pub fn update_peak_kinetic(&mut self, kinetic: f64) {
        self.peak = self.peak.max(kinetic);
    }
}
