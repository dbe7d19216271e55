//! Flow as outputs see it: all of its parts, none of which they change.

use crate::bed::Bed;
use crate::boundary::FlowBoundaries;
use crate::clock::Clock;
use crate::config::settings::FlowSettings;
use crate::energy_balance::FlowRecords;
use crate::energy_balance::balance::{EnergyBalanceSummary, energies};
use crate::flow_nodes::FlowNodes;
use crate::phases::phase::PhaseSet;

/// Read-only view of a flow for outputs.
#[derive(Clone, Copy)]
pub struct FlowView<'a, const D: usize> {
    /// Time and number of steps.
    pub clock: &'a Clock,
    /// Material, gravity and numerical parameters, constant during the run.
    pub settings: &'a FlowSettings<D>,
    /// The bed.
    pub bed: &'a Bed<D>,
    /// Walls, inflows and open boundaries.
    pub boundary: &'a FlowBoundaries<D>,
    /// Nodes of each phase, with their columns of pore pressure.
    pub nodes: &'a FlowNodes<D>,
    /// Energy balance, and volumes that have left or have been eroded.
    pub records: &'a FlowRecords,
}

impl<'a, const D: usize> FlowView<'a, D> {
    /// Node sets of the flow.
    pub fn sets(&self) -> &'a [PhaseSet<D>] {
        &self.nodes.sets
    }

    /// Density of a set (kg/m³).
    pub fn density(&self, set: usize) -> f64 {
        self.settings.set_density(self.nodes.sets.len(), set)
    }

    /// Whether the bed is eroded anywhere.
    pub fn has_erosion(&self) -> bool {
        self.settings.zones.iter().any(|zone| zone.erosion.is_some())
    }

    /// Current energies with the error of their balance.
    pub fn energy_balance(&self) -> EnergyBalanceSummary {
        let now = energies(self.settings, self.bed, self.boundary, &self.nodes.sets);
        self.records.energy_balance.summary(self.settings, now)
    }
}
