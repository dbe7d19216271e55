//! Sampling of bodies with points.

use colluvium_points::{Sample, Sampling, Shape, fitted_rows, lattice, poisson_spaced};

use crate::CaseErrorKind;
use crate::description::{Body, PointFile, Space};
use crate::{Case, CaseError};

impl Case {
    /// Approximate number of points in each body at a spacing (m). For a body with a file of points, their number in the file.
    pub fn point_counts(&self, spacing: f64) -> Vec<f64> {
        let dimension = self.dimension();
        let filled = |body: &Body| body.shape.volume(dimension, false) / spacing.powi(dimension as i32);
        let count = |body: &Body| body.points.as_ref().map_or_else(|| filled(body), PointFile::count);
        self.bodies.iter().map(count).collect()
    }

    /// Points of body number `number`, about a `spacing` (m) apart, by its `sampling`; a lattice begins half a spacing from `origin` (m).
    ///
    /// # Errors
    /// When its shape cannot be sampled this way, with the path of the invalid value.
    pub fn samples<const D: usize>(
        &self,
        number: usize,
        origin: [f64; D],
        spacing: f64,
    ) -> Result<Vec<Sample<D>>, CaseError> {
        let body = &self.bodies[number];
        let (key, samples) = match body.sampling {
            Sampling::Lattice => ("shape", lattice(&body.shape, origin, spacing)),
            Sampling::Fitted => ("sampling", fitted_rows(&body.shape, origin, spacing)),
            Sampling::PoissonDisk => {
                let samples = poisson_spaced(&body.shape, spacing, body.sampling_seed);
                ("sampling", samples.map(|samples| self.weighted_by_radius(&body.shape, samples)))
            }
        };
        samples.map_err(|error| {
            CaseError::new(
                format!("bodies[{number}].{key}"),
                CaseErrorKind::coded(error.code(), error.to_string()),
            )
        })
    }

    /// Scales random points of an axisymmetric shape to equal areas in the plane. The areas are such that the volumes of the points sum up
    /// to that of the shape: the scatter of the radii does not become a scatter of the mass.
    fn weighted_by_radius<const D: usize>(
        &self,
        shape: &Shape,
        mut samples: Vec<Sample<D>>,
    ) -> Vec<Sample<D>> {
        if self.space == Space::Axisymmetric {
            let held: f64 = samples.iter().map(|sample| sample.position[0] * sample.volume).sum();
            let scale = shape.volume(D, true) / held;
            samples.iter_mut().for_each(|sample| sample.volume *= scale);
        }
        samples
    }
}
