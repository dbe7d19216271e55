//! Surroundings of the nodes during the integration of a step.

use crate::bed::Bed;
use crate::boundary::FlowBoundaries;
use crate::clock::Clock;
use crate::config::settings::FlowSettings;
use crate::phases::limits::FlowLimits;

/// Parts of a flow that a step and the outputs read without changing them.
#[derive(Clone, Copy)]
pub struct FlowContext<'a, const D: usize> {
    /// Time at the beginning of the step.
    pub clock: &'a Clock,
    /// Material, gravity and numerical parameters, constant during the run.
    pub settings: &'a FlowSettings<D>,
    /// The bed.
    pub bed: &'a Bed<D>,
    /// Walls, inflows and open boundaries.
    pub boundary: &'a FlowBoundaries<D>,
    /// Bounds of depth and speed.
    pub limits: &'a FlowLimits,
}
