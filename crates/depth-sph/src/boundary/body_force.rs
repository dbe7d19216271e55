//! Body force of a program on the nodes.

use colluvium_case::BodyForce;

use crate::clock::Clock;
use crate::phases::failure::FlowFailure;
use crate::phases::phase::PhaseSet;

/// Body force of a program, with the memory that a step reuses.
#[derive(Default)]
pub struct ProgramForce<const D: usize> {
    /// Body force; none at the start.
    pub acting: Option<BodyForce<D>>,
    /// Accelerations of the nodes (m/s²).
    accelerations: Vec<[f64; D]>,
}

impl<const D: usize> ProgramForce<D> {
    /// Computes the accelerations of the nodes of a single phase at the start of a step.
    ///
    /// # Errors
    /// The first node whose acceleration is not finite; the accelerations of the nodes are then unchanged.
    pub fn update(&mut self, clock: &Clock, set: &mut PhaseSet<D>) -> Result<(), FlowFailure> {
        let Some(acting) = &self.acting else { return Ok(()) };
        let accelerations = &mut self.accelerations;
        accelerations.resize(set.len(), [0.0; D]);
        let found = acting.accelerations(&set.nodes.position, &set.nodes.velocity, clock.time, accelerations);
        found.map_err(|invalid| FlowFailure::at_node(set, invalid.point, invalid.to_string()))?;
        set.nodes.body_acceleration.clone_from(accelerations);
        Ok(())
    }
}
