//! Boundaries in plan: inflows, open sides and ends, and the nodes beyond them.
//!
//! The module reads nodes near a side and adds or removes nodes beyond it (sheet: depth-sph §3.9).

pub(crate) mod body_force;
pub(crate) mod inflow_nodes;
pub(crate) mod open;
pub(crate) mod stages;

use crate::boundary::open::OpenBoundary;
use crate::inflow::{Inflow, WaitingNodes};
use crate::phases::phase::PhaseSet;
use crate::points::image_nodes::PlanBoundaries;
use crate::points::phase_nodes::PhaseNodes;

/// Treatment of nodes that leave the bed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OutsideNodes {
    /// Nodes are removed and counted.
    #[default]
    Remove,
    /// Nodes end the run.
    Fail,
}

/// Boundaries of a flow in plan.
#[derive(Clone, Debug, Default)]
pub struct FlowBoundaries<const D: usize> {
    /// Walls and periodic boundaries of the plan.
    pub walls: PlanBoundaries<D>,
    /// Inflow lines with their rows of nodes.
    pub inflows: Vec<Inflow<D>>,
    /// Nodes behind the inflow lines, which have not entered the flow yet.
    pub waiting_nodes: WaitingNodes<D>,
    /// Open boundaries, through which waves leave or material flows in.
    pub open_sides: Vec<OpenBoundary<D>>,
    /// Treatment of nodes that leave the bed.
    pub outside: OutsideNodes,
}

impl<const D: usize> FlowBoundaries<D> {
    /// Boundaries that consist of walls and periodic boundaries only.
    pub fn from_walls(walls: PlanBoundaries<D>) -> Self {
        Self { walls, ..Self::default() }
    }

    /// Whether there are inflow lines or open boundaries.
    pub fn has_openings(&self) -> bool {
        !(self.inflows.is_empty() && self.open_sides.is_empty())
    }

    /// Whether there are nodes behind an inflow line or outside an open boundary.
    pub fn has_outside_nodes(&self) -> bool {
        !(self.waiting_nodes.nodes.is_empty() && self.open_sides.is_empty())
    }

    /// Whether a node is behind an inflow line or outside an open boundary; `id` is its number.
    pub fn is_outside(&self, id: u64) -> bool {
        self.waiting_nodes.position_and_velocity(id).is_some() || self.is_far_field_node(id)
    }

    /// Whether a node is outside an open boundary; `id` is its number.
    pub fn is_far_field_node(&self, id: u64) -> bool {
        self.open_sides.iter().any(|end| end.state.ids.binary_search(&id).is_ok())
    }

    /// Whether a node is outside a boundary with inflow; `id` is its number.
    pub fn is_inlet_node(&self, id: u64) -> bool {
        self.open_sides.iter().any(|end| end.has_inlet() && end.state.ids.binary_search(&id).is_ok())
    }

    /// Volume that has entered (m³).
    pub fn inflow_volume(&self) -> f64 {
        let lines: f64 = self.inflows.iter().map(Inflow::entered_volume).sum();
        let passed = |end: &OpenBoundary<D>| end.state.outflow.iter().sum::<f64>();
        self.open_sides.iter().filter(|end| end.has_inlet()).fold(lines, |sum, end| sum - passed(end))
    }

    /// Volume of pore fluid with separate nodes that has flowed in (m³).
    pub fn fluid_entered(&self) -> f64 {
        let of_line = |inflow: &Inflow<D>| inflow.porosity.unwrap_or(0.0) * inflow.entered_volume();
        let lines: f64 = self.inflows.iter().map(of_line).sum();
        self.open_sides
            .iter()
            .filter(|end| end.has_inlet())
            .fold(lines, |sum, end| sum - end.state.outflow[1])
    }

    /// Net volume that has flowed out through open boundaries without inflow (m³).
    pub fn outflow_volume(&self) -> f64 {
        self.open_sides.iter().filter(|end| !end.has_inlet()).flat_map(|end| end.state.outflow).sum()
    }

    /// Volume of the nodes behind inflow lines and outside open boundaries (m³).
    pub fn waiting_volume(&self, sets: &[PhaseSet<D>]) -> f64 {
        let waiting: f64 = self.inflows.iter().map(Inflow::waiting_volume).sum();
        if self.open_sides.is_empty() { waiting } else { waiting + self.far_field_volume(sets) }
    }

    /// Volume of the nodes outside open boundaries (m³; m² in profiles).
    pub fn far_field_volume(&self, sets: &[PhaseSet<D>]) -> f64 {
        let beyond = |nodes: &PhaseNodes<D>| -> f64 {
            let own = nodes.id.iter().zip(&nodes.volume).filter(|(id, _)| self.is_far_field_node(**id));
            own.map(|(_, volume)| volume).sum()
        };
        sets.iter().map(|set| beyond(&set.nodes)).sum()
    }

    /// Restores the prescribed velocities of the nodes behind inflow lines and outside open boundaries.
    pub(crate) fn hold_velocities(&self, sets: &mut [PhaseSet<D>]) {
        self.hold_far_field_velocities(sets);
        self.hold_waiting_velocities(sets);
    }
}
