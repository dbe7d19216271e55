//! Grains of a specimen: their origin, and those still to enter.

use crate::specimen::Specimen;
use crate::specimen::pluviation::GrainSource;
use colluvium_case::Warning;

/// Preparation of the specimen: sources of grains during the run, reports on the filling of bodies, and origin from a file.
#[derive(Debug)]
pub struct SpecimenPreparation {
    /// Bodies whose grains enter during the run.
    pub sources: Vec<GrainSource>,
    /// Id of the next grain that enters.
    pub next_id: u32,
    /// Reports on the filling of bodies.
    pub reports: Vec<Specimen>,
    /// Origin of the specimen from a file.
    pub source: SpecimenSource,
}

/// Origin of the grains and contacts in a specimen file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpecimenSource {
    /// Whether the grains of each body of the case are from the file.
    pub bodies: Vec<bool>,
    /// Whether contacts were bonded, or cohesive from the start on.
    pub has_bonds: bool,
    /// Largest overlap over the smaller radius.
    pub overlap: f64,
    /// Notes on the specimen for the user.
    pub notes: Vec<Warning>,
}

impl SpecimenSource {
    /// Whether the grains of body number `body` are from the file.
    pub fn has_body(&self, body: usize) -> bool {
        self.bodies.get(body).is_some_and(|given| *given)
    }
}
