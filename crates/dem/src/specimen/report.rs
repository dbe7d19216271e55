//! What a specimen is, against what was asked for.

use std::fmt;

/// A body that was filled with grains: how densely, and how they touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Specimen {
    /// Name of the body.
    pub body: String,
    /// Grains.
    pub grains: usize,
    /// Share of its shape that is not grains; what reaches out of the shape counts as in it.
    pub porosity: f64,
    /// The porosity that was asked for; none of lattices and of grains that are dropped.
    pub requested_porosity: Option<f64>,
    /// Contacts a grain, each counted for both of its grains: those with other bodies among them, those with walls not.
    pub coordination: f64,
}

impl fmt::Display for Specimen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "body {:?}: {} grains, porosity {:.4}", self.body, self.grains, self.porosity)?;
        if let Some(asked) = self.requested_porosity {
            write!(f, " ({asked:.4} asked for)")?;
        }
        write!(f, ", {:.2} contacts a grain", self.coordination)
    }
}
