//! Body force of a program on the grains.

use colluvium_case::{BodyForce, SolverError};

use crate::clock::Clock;
use crate::points::grains::Grains;

/// Body force of a program, with the memory that a step reuses.
#[derive(Default)]
pub struct ProgramForce<const D: usize> {
    /// Body force; none at the start.
    pub acting: Option<BodyForce<D>>,
    /// Accelerations of the grains (m/s²).
    accelerations: Vec<[f64; D]>,
}

impl<const D: usize> ProgramForce<D> {
    /// Computes the forces on all grains at the start of a step. Grains with prescribed motion have one too, which does not move them.
    ///
    /// # Errors
    /// The first grain whose acceleration is not finite; the forces on the grains are then unchanged.
    pub fn update<const R: usize>(
        &mut self,
        clock: &Clock,
        grains: &mut Grains<D, R>,
    ) -> Result<(), SolverError> {
        let Some(acting) = &self.acting else { return Ok(()) };
        let accelerations = &mut self.accelerations;
        accelerations.resize(grains.len(), [0.0; D]);
        let found = acting.accelerations(&grains.position, &grains.velocity, clock.time, accelerations);
        found.map_err(|invalid| clock.grain_error(grains, invalid.point, invalid.to_string()))?;
        let forces = &mut grains.body_force;
        forces.clear();
        forces.extend(accelerations.iter().zip(&grains.mass).map(|(a, mass)| a.map(|a| mass * a)));
        Ok(())
    }
}
