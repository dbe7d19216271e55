//! The points that methods set in bodies.

use colluvium_points::{Sample, Sampling, fitted, lattice, poisson_spaced};

use crate::{Case, CaseError};

impl Case {
    /// Points of body `number`, about a `spacing` (m) apart, as its `sampling` says: the lattice begins half a spacing from `origin` (m).
    ///
    /// # Errors
    /// When its shape cannot be sampled so, by the path of what is wrong.
    pub fn samples<const D: usize>(
        &self,
        number: usize,
        origin: [f64; D],
        spacing: f64,
    ) -> Result<Vec<Sample<D>>, CaseError> {
        let body = &self.bodies[number];
        let (key, samples) = match body.sampling {
            Sampling::Lattice => ("shape", lattice(&body.shape, origin, spacing)),
            Sampling::Fitted => ("sampling", fitted(&body.shape, origin, spacing)),
            Sampling::PoissonDisk => ("sampling", poisson_spaced(&body.shape, spacing, body.sampling_seed)),
        };
        samples.map_err(|error| CaseError::new(format!("bodies[{number}].{key}"), error.to_string()))
    }
}
