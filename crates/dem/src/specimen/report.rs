//! Report on a specimen: actual and requested properties.

use std::fmt;

/// Report on a body that was filled with grains: density and contacts.
#[derive(Clone, Debug, PartialEq)]
pub struct Specimen {
    /// Name of the body.
    pub body: String,
    /// Number of grains.
    pub grains: usize,
    /// Porosity of the shape; parts of grains outside the shape are counted as inside.
    pub porosity: f64,
    /// Requested porosity; `None` for lattices and for grains that are dropped.
    pub requested_porosity: Option<f64>,
    /// Coordination number, with contacts to other bodies and without those to walls.
    pub coordination: f64,
}

impl fmt::Display for Specimen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "body {:?}: {} grains, porosity {:.4}", self.body, self.grains, self.porosity)?;
        if let Some(asked) = self.requested_porosity {
            write!(f, " ({asked:.4} requested)")?;
        }
        write!(f, ", {:.2} contacts per grain", self.coordination)
    }
}
