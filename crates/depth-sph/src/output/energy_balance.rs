//! Energy balance: initial energy, inflow, and the work of forces, each computed from its own force and not as the remainder
//! (sheet: depth-sph §2.9, item 7 as amended).

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::bed::BedPoint;
use crate::config::choices::{DepthFrame, Phases};
use crate::flow::Flow;
use crate::momentum::curved_drift::dot_along_bed;
use crate::phases::phase::{PhaseSet, TASK};
use crate::phases::phase_nodes::PlanVector;

/// Share of the exchanged energy by which the balance may be off without a warning.
const BALANCE_TOLERANCE: f64 = 0.01;
/// Share of the pressure energy that is the least exchanged energy, for flows that are nearly at rest.
const STILL_FRACTION: f64 = 0.1;

/// Energy of the flow that has entered and not left (J).
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

/// Works that have changed the energy of a flow (J).
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
    /// Energy of inflow less that of outflow.
    pub entered: f64,
    /// Largest kinetic energy so far.
    peak: f64,
}

/// Current energy balance (J).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyBalanceSummary {
    /// Current energy.
    pub now: FlowEnergies,
    /// Excess of energy.
    pub error: f64,
    /// Work of pressure beyond the loss of pressure energy.
    pub difference: f64,
    /// Exchanged energy: the largest of drop, kinetic energy and losses.
    pub exchanged: f64,
}

impl EnergyBalanceSummary {
    /// Whether the energy is off by more than a hundredth of the exchanged energy.
    pub fn is_off(&self) -> bool {
        !(self.error.abs() <= BALANCE_TOLERANCE * self.exchanged)
    }
}

impl<const D: usize> Flow<D> {
    /// Energy of a node (J), from the bed below it; of one beyond the bed from the last bed there.
    fn node_energies(&self, number: usize, i: usize) -> FlowEnergies {
        let set = &self.sets[number];
        let nodes = &set.nodes;
        let mass = self.density(number) * nodes.volume[i];
        let x = &nodes.position[i];
        let bed = self.floor_at(x).or_else(|| set.bed.get(i).copied()).unwrap_or(BedPoint::flat(0.0));
        let v = &nodes.velocity[i];
        let drive = &self.settings.plan_gravity;
        let run: f64 = (0..D).map(|c| drive[c] * (x[c] - nodes.origin[i][c])).sum();
        FlowEnergies {
            kinetic: 0.5 * mass * dot_along_bed(&self.energy_slope(&bed), v, v),
            bed: mass * (self.settings.gravity * bed.level - run),
            pressure: 0.5 * mass * nodes.effective_gravity[i] * nodes.depth[i],
        }
    }

    /// Slope with which motion along the bed is measured: zero where slopes are taken as small.
    #[inline]
    fn energy_slope(&self, bed: &BedPoint<D>) -> PlanVector<D> {
        if self.settings.frame == DepthFrame::Horizontal { bed.slope } else { [0.0; D] }
    }

    /// Energy of the flow that has entered and not left.
    pub fn energies(&self) -> FlowEnergies {
        let mut sum = FlowEnergies::default();
        for (number, set) in self.sets.iter().enumerate() {
            let one = |i: usize| {
                if self.is_outside(set.nodes.id[i]) {
                    FlowEnergies::default()
                } else {
                    self.node_energies(number, i)
                }
            };
            for own in (0..set.len()).into_par_iter().with_min_len(TASK).map(one).collect::<Vec<_>>() {
                sum.kinetic += own.kinetic;
                sum.bed += own.bed;
                sum.pressure += own.pressure;
            }
        }
        sum
    }

    /// Whether pressure has an energy that follows from heights: of one phase without earth pressure. Otherwise its work is summed.
    fn pressure_has_energy(&self) -> bool {
        self.settings.phases == Phases::One && self.settings.earth_pressure.is_none()
    }

    /// Starts the balance before the first step.
    pub(crate) fn start_energy_balance(&mut self) {
        if self.energy_balance.start.is_none() {
            self.energy_balance.start = Some(self.energies());
        }
    }

    /// Current energy balance.
    pub fn energy_balance_summary(&self) -> EnergyBalanceSummary {
        let (ledger, mut now) = (&self.energy_balance, self.energies());
        // Heights are those of the middle of the last step.
        now.pressure -= 0.5 * ledger.last_pressure_work;
        let start = ledger.start.unwrap_or(now);
        let difference = ledger.pressure_work + now.pressure - start.pressure;
        let pressure =
            if self.pressure_has_energy() { now.pressure } else { start.pressure - ledger.pressure_work };
        let lost = ledger.friction + ledger.viscosity;
        let error = now.kinetic + now.bed + pressure + lost - start.total() - ledger.entered;
        let drop = start.bed + start.pressure - now.bed - now.pressure + ledger.entered;
        let most = drop.max(lost).max(ledger.peak).max(now.kinetic);
        EnergyBalanceSummary { now, error, difference, exchanged: most.max(STILL_FRACTION * now.pressure) }
    }

    /// Applies a change from outside the flow: its energy counts as inflow.
    pub fn with_external_change<R>(&mut self, change: impl FnOnce(&mut Self) -> R) -> R {
        if self.energy_balance.start.is_none() {
            return change(self);
        }
        let before = self.energies().total();
        let result = change(self);
        self.energy_balance.entered += self.energies().total() - before;
        result
    }

    /// Applies an inflow: its energy enters, and pressure does work at the inlet, as much again as its own energy.
    pub(crate) fn with_inflow<R>(&mut self, change: impl FnOnce(&mut Self) -> R) -> R {
        let before = self.energies();
        let result = change(self);
        let after = self.energies();
        self.energy_balance.entered += after.total() - before.total() + after.pressure - before.pressure;
        result
    }

    /// Applies erosion: the kinetic energy that nodes lose counts as friction.
    pub(crate) fn with_erosion(&mut self, change: impl FnOnce(&mut Self)) {
        let before = self.energies();
        self.with_inflow(change);
        let lost = before.kinetic - self.energies().kinetic;
        self.energy_balance.friction += lost;
        self.energy_balance.entered += lost;
    }

    /// Stores the velocities before the kick.
    pub(crate) fn store_velocities(&mut self) {
        self.sets.iter_mut().for_each(|set| set.stored_velocity.clone_from(&set.nodes.velocity));
    }

    /// Adds the works of a step: of a kick over `dt` (s) from the stored velocities, and of the resistance to it.
    pub(crate) fn add_step_work(&mut self, dt: f64) {
        let works = self.works(|flow, set, i| {
            let slope = flow.energy_slope(&set.bed[i]);
            let (old, new) = (&set.stored_velocity[i], &set.nodes.velocity[i]);
            let mean: PlanVector<D> = std::array::from_fn(|c| 0.5 * (old[c] + new[c]));
            let held: PlanVector<D> = std::array::from_fn(|c| new[c] - old[c] - dt * set.acceleration[i][c]);
            let [viscous, push] = flow.force_works(set, i, dt, &mean);
            [dot_along_bed(&slope, &held, &mean), viscous, push]
        });
        self.add_works(works);
    }

    /// Adds the works of the forces of a stage of weight `dt` (s); resistance is added against stored velocities.
    pub(crate) fn add_stage_work(&mut self, dt: f64) {
        let works = self.works(|flow, set, i| {
            let [viscous, push] = flow.force_works(set, i, dt, &set.nodes.velocity[i]);
            [0.0, viscous, push]
        });
        self.add_works(works);
    }

    /// Adds the work of resistance since the velocities were stored.
    pub(crate) fn add_resistance_work(&mut self) {
        let works = self.works(|flow, set, i| {
            let slope = flow.energy_slope(&set.bed[i]);
            let (old, new) = (&set.stored_velocity[i], &set.nodes.velocity[i]);
            let work = dot_along_bed(&slope, new, new) - dot_along_bed(&slope, old, old);
            [0.5 * work, 0.0, 0.0]
        });
        self.add_works(works);
    }

    /// Works per mass of viscosity and of pressure over `dt` (s) at this velocity (J/kg).
    #[inline]
    fn force_works(&self, set: &PhaseSet<D>, i: usize, dt: f64, velocity: &PlanVector<D>) -> [f64; 2] {
        let (bed, viscous) = (&set.bed[i], &set.viscous[i]);
        let (all, reaction) = (&set.acceleration[i], set.reaction[i]);
        let slope = self.energy_slope(bed);
        let push: PlanVector<D> = std::array::from_fn(|c| {
            all[c] - viscous[c] + reaction * bed.slope[c] - self.settings.plan_gravity[c]
        });
        [dt * dot_along_bed(&slope, viscous, velocity), dt * dot_along_bed(&slope, &push, velocity)]
    }

    /// Sums of works per mass of friction, viscosity and pressure, over the nodes in their order (J). Resistance never adds energy:
    /// of one phase at no node, of two in no step.
    fn works(&mut self, one: impl Fn(&Self, &PhaseSet<D>, usize) -> [f64; 3] + Sync) -> [f64; 3] {
        let single = self.settings.phases == Phases::One;
        let mut sums = [0.0; 3];
        for number in 0..self.sets.len() {
            let density = self.density(number);
            let mut works = std::mem::take(&mut self.sets[number].works);
            let (flow, set) = (&*self, &self.sets[number]);
            let of_node = |i: usize| {
                if flow.is_outside(set.nodes.id[i]) {
                    return [0.0; 3];
                }
                let mut works = one(flow, set, i).map(|work| density * set.nodes.volume[i] * work);
                if single {
                    works[0] = works[0].min(0.0);
                }
                works
            };
            (0..set.len()).into_par_iter().with_min_len(TASK).map(of_node).collect_into_vec(&mut works);
            for own in &works {
                (0..3).for_each(|k| sums[k] += own[k]);
            }
            self.sets[number].works = works;
        }
        sums
    }

    fn add_works(&mut self, [friction, viscosity, push]: [f64; 3]) {
        let ledger = &mut self.energy_balance;
        ledger.friction -= friction.min(0.0);
        ledger.viscosity -= viscosity.min(0.0);
        ledger.pressure_work += push;
        ledger.last_pressure_work = push;
    }

    /// Updates the largest kinetic energy (J).
    pub fn update_peak_kinetic(&mut self, kinetic: f64) {
        self.energy_balance.peak = self.energy_balance.peak.max(kinetic);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use colluvium_constitutive::basal::BasalSpec;

    use super::*;
    use crate::bed::test_terrain::RoughSlope;
    use crate::bed::{Bed, TerrainBed};
    use crate::config::choices::PressureForceForm;
    use crate::config::settings::{BedZone, FlowSettings};
    use crate::flow::PlanBoundaries;
    use crate::phases::phase_nodes::NewNode;

    fn rough() -> Bed<2> {
        let slope = RoughSlope::new(0.577, 60.0, [40.0, 200.0], 0.1, 3);
        let raster = slope.raster([0.0; 2], [500.0, 120.0], 5.0);
        Bed::Surface(Arc::new(TerrainBed::new(TerrainBed::smoothed(&raster, 1)).unwrap()))
    }

    fn heap(bed: Bed<2>, friction: Option<f64>, depth: f64, spacing: f64) -> Flow<2> {
        heap_of(PressureForceForm::Automatic, bed, friction, depth, spacing)
    }

    fn heap_of(
        form: PressureForceForm,
        bed: Bed<2>,
        friction: Option<f64>,
        depth: f64,
        spacing: f64,
    ) -> Flow<2> {
        let mut nodes = Vec::new();
        for k in 0..100 {
            let position = [20.5 + spacing * f64::from(k % 10), 50.5 + spacing * f64::from(k / 10)];
            let volume = depth * spacing * spacing;
            let length = 1.3 * spacing;
            nodes.push(NewNode { body: 0, position, velocity: [0.0; 2], volume, length, scale: 1.69 });
        }
        let mut settings = FlowSettings::plain(1000.0);
        settings.numerics.momentum = form;
        if let Some(angle) = friction {
            let spec = format!(r#"{{ "model": "coulomb", "friction_angle": {angle} }}"#);
            let spec: BasalSpec = serde_json::from_str(&spec).unwrap();
            settings.zones = vec![BedZone::everywhere(Some(spec.build().unwrap()))];
        }
        Flow::new(settings, bed, PlanBoundaries::default(), &[nodes]).unwrap()
    }

    fn run(flow: &mut Flow<2>, end: f64) -> EnergyBalanceSummary {
        while flow.time < end {
            let dt = flow.limit().dt.min(end - flow.time + 1e-12);
            flow.advance(dt).unwrap();
        }
        flow.energy_balance_summary()
    }

    /// Without pressure and friction only gravity does work.
    #[test]
    fn a_node_that_slides_freely_keeps_its_energy() {
        let mut flow = heap(rough(), None, 1e-9, 3.0);
        while flow.time < 6.0 {
            flow.advance(flow.limit().dt.min(0.01)).unwrap();
        }
        let account = flow.energy_balance_summary();
        assert!(account.error.abs() < 1e-5 * account.exchanged, "{account:?}");
    }

    #[test]
    fn the_account_of_a_flow_with_friction_closes_and_friction_only_takes() {
        let mut flow = heap(rough(), Some(15.0), 0.5, 2.0);
        let account = run(&mut flow, 8.0);
        assert!(account.error.abs() < 2e-3 * account.exchanged, "{account:?}");
        assert!(flow.energy_balance.friction > 0.2 * account.exchanged && !account.is_off());
    }

    #[test]
    fn friction_that_pushes_is_told() {
        let mut flow = heap(rough(), Some(5.0), 0.5, 2.0);
        flow.test_factors[0] = -1.0;
        assert!(run(&mut flow, 4.0).is_off());
    }

    /// Pressure of the form that keeps energy, so that only the fault has an effect.
    #[test]
    fn pressure_that_pumps_is_told() {
        let spreading = || heap_of(PressureForceForm::Variational, Bed::Flat(0.0), None, 2.0, 1.0);
        let mut flow = spreading();
        assert!(!run(&mut flow, 1.0).is_off(), "{:?}", flow.energy_balance_summary());
        let mut flow = spreading();
        flow.test_factors[1] = 1.2;
        assert!(run(&mut flow, 1.0).is_off(), "{:?}", flow.energy_balance_summary());
    }
}
