//! Flow: its owners, and one step (sheet: depth-sph §3.4).

mod critical_step;
#[cfg(test)]
mod energy_balance_tests;
mod enter_and_leave;
mod erosion;
mod initialisation;
mod opening;
#[cfg(test)]
mod single_phase_energy_tests;

use crate::bed::{Bed, BedPoint};
use crate::boundary::body_force::ProgramForce;
use crate::boundary::inflow_nodes::reset_inflow_columns;
use crate::clock::Clock;
use crate::config::settings::FlowSettings;
use crate::context::FlowContext;
use crate::energy_balance::balance::energies;
use crate::flow::critical_step::critical_step;
use crate::flow::enter_and_leave::{remove_outside, update_openings};
use crate::flow::erosion::erode_bed;
use crate::momentum::time_integration::integrate;
use crate::output::flow_view::FlowView;
use crate::output::totals::totals;
use crate::phases::node_checks::check_nodes;
use crate::points::phase_nodes::PlanVector;

pub use crate::boundary::open::{Inlet, OpenBoundary, Opening};
pub use crate::boundary::{FlowBoundaries, OutsideNodes};
pub use crate::energy_balance::FlowRecords;
pub use crate::energy_balance::balance::{EnergyBalance, EnergyBalanceSummary, FlowEnergies};
pub use crate::flow::critical_step::LimitingNode;
pub use crate::flow_nodes::FlowNodes;
pub use crate::output::totals::PhaseTotals;
pub use crate::phases::failure::FlowFailure;
pub use crate::phases::limits::FlowLimits;
pub use crate::phases::phase::PhaseSet;
pub use crate::points::image_nodes::PlanBoundaries;

/// Depth-integrated flow over a bed: settings, bed, nodes, boundaries and records.
pub struct Flow<const D: usize> {
    /// Time and number of steps.
    pub clock: Clock,
    /// Material, gravity and numerical parameters, constant during the run.
    pub settings: FlowSettings<D>,
    /// The bed.
    pub bed: Bed<D>,
    /// Walls, inflows and open boundaries.
    pub boundary: FlowBoundaries<D>,
    /// Nodes of each phase, with their columns of pore pressure.
    pub nodes: FlowNodes<D>,
    /// Bounds of depth and speed by the initial state.
    pub limits: FlowLimits,
    /// Energy balance, and volumes that have left the flow or have been eroded.
    pub records: FlowRecords,
    /// Body force of a program.
    pub(crate) body_force: ProgramForce<D>,
}

impl<const D: usize> Flow<D> {
    /// Advances the flow by a step of `dt` (s); step numbers in the code are those of the sheet (depth-sph §3.4).
    ///
    /// # Errors
    /// The first node that has failed.
    pub fn advance(&mut self, dt: f64) -> Result<(), FlowFailure> {
        let Self { clock, settings, bed, boundary, nodes, limits, records, body_force } = self;
        let balance = &mut records.energy_balance;
        body_force.update(clock, &mut nodes.sets[0])?;
        balance.start_with(|| energies(settings, bed, boundary, &nodes.sets));
        balance.end_program_change(|| energies(settings, bed, boundary, &nodes.sets).total());
        update_openings(clock, settings, bed, boundary, nodes, balance, dt)?; // 10
        if boundary.has_openings() {
            body_force.update(clock, &mut nodes.sets[0])?;
        }
        reset_inflow_columns(boundary, nodes); // 9
        nodes.sort(settings, clock.step)?;
        integrate(&FlowContext { clock, settings, bed, boundary, limits }, nodes, balance, dt)?; // 1 to 7, 9
        erode_bed(clock, settings, bed, boundary, &mut nodes.sets, records, dt); // 8
        clock.end(dt);
        check_nodes(settings, bed, limits, &nodes.sets)?;
        remove_outside(settings, bed, boundary, nodes, records) // 10
    }

    /// Records the energy before a program changes velocities.
    pub(crate) fn begin_program_change(&mut self) {
        let Self { settings, bed, boundary, nodes, records, .. } = self;
        let energy = || energies(settings, bed, boundary, &nodes.sets).total();
        records.energy_balance.begin_program_change(energy);
    }

    /// Read-only view of the flow for outputs.
    pub fn view(&self) -> FlowView<'_, D> {
        let Self { clock, settings, bed, boundary, nodes, records, .. } = self;
        FlowView { clock, settings, bed, boundary, nodes, records }
    }

    /// Largest stable step (s): waves in the frame of each node, and its motion over the bed.
    pub fn limit(&self) -> LimitingNode {
        critical_step(&self.settings, &self.bed, &self.boundary.inflows, &self.nodes.sets)
    }

    /// Bed below a node; a horizontal one of level zero outside its extent, where nodes remain until the end of the step.
    pub fn bed_below(&self, x: &PlanVector<D>) -> BedPoint<D> {
        self.bed.bed_below(x)
    }

    /// Mass, momentum and energies of a node set, summed in the order of node numbers.
    pub fn totals(&self, set: usize) -> PhaseTotals<D> {
        totals(&self.settings, &self.bed, &self.nodes.sets, set)
    }

    /// Current energies with the error of their balance.
    pub fn energy_balance_summary(&self) -> EnergyBalanceSummary {
        self.view().energy_balance()
    }

    /// Volume of the nodes outside open boundaries (m³; m² in profiles).
    pub fn far_field_volume(&self) -> f64 {
        self.boundary.far_field_volume(&self.nodes.sets)
    }

    /// Volume of the nodes behind inflow lines and outside open boundaries (m³).
    pub fn waiting_volume(&self) -> f64 {
        self.boundary.waiting_volume(&self.nodes.sets)
    }
}
