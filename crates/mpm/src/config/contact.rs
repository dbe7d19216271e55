//! Contacts of `methods.mpm`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Contact of two bodies (sheet: mpm §2.12): they may separate, and slide by Coulomb's law with adhesion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyContact {
    /// Names of the two bodies.
    pub bodies: [String; 2],
    /// Coefficient of friction, tangent of the friction angle of the interface.
    #[serde(default)]
    pub friction_coefficient: f64,
    /// Adhesion (Pa): shear strength of the interface without normal stress, while it is closed.
    #[serde(default)]
    pub adhesion: f64,
    /// Direction from the first body to the second, where the interface is a plane; from the gradients of the
    /// bodies' volumes when absent.
    #[serde(default)]
    pub normal: Option<Vec<f64>>,
    /// When the bodies act on each other; when absent `gap`, but `approach` where `normal` is given and on a mesh.
    #[serde(default)]
    pub test: Option<ContactTest>,
    /// A normal force that grows with the overlap of the bodies, in place of velocities that do not approach; with `test`
    /// `gap`.
    #[serde(default)]
    pub penalty: Option<PenaltyContact>,
}

impl BodyContact {
    /// When the bodies act on each other, on a grid or on a mesh.
    pub fn test(&self, on_mesh: bool) -> ContactTest {
        // A given plane defines where bodies touch; without it bodies that come near would catch at their corners.
        let usual = if on_mesh || self.normal.is_some() { ContactTest::Approach } else { ContactTest::Gap };
        self.test.unwrap_or(usual)
    }

    /// Checks the values; the error is the key and the problem.
    pub(crate) fn validate(&self, on_mesh: bool) -> Result<(), (&'static str, String)> {
        for (key, value) in [("friction_coefficient", self.friction_coefficient), ("adhesion", self.adhesion)]
        {
            if !(value.is_finite() && value >= 0.0) {
                return Err((key, format!("{value} must be finite and not negative")));
            }
        }
        let test = self.test(on_mesh);
        if on_mesh && test == ContactTest::Gap {
            let problem = "gap needs a structured grid, whose shape functions tell the distance of a surface: use approach";
            return Err(("test", problem.to_owned()));
        }
        self.penalty.map_or(Ok(()), |penalty| penalty.validate(test)).map_err(|problem| ("penalty", problem))
    }
}

/// Penalty contact (sheet: mpm §4 row 58; after Ma, Zhang & Lian): the normal stress is `stiffness` times the overlap, and
/// friction ends at a shear strength.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PenaltyContact {
    /// Normal stress for an overlap of one metre (Pa/m), > 0. A step never parts the bodies by more than the overlap,
    /// however stiff they are.
    pub stiffness: f64,
    /// Largest shear stress (Pa), not negative, whatever the normal stress; no limit when absent.
    #[serde(default)]
    pub shear_strength: Option<f64>,
}

impl PenaltyContact {
    /// Checks the values together with the test of contact; the error describes the problem.
    pub(crate) fn validate(&self, test: ContactTest) -> Result<(), String> {
        if test != ContactTest::Gap {
            return Err("needs test gap, which tells the overlap".to_owned());
        }
        if !(self.stiffness.is_finite() && self.stiffness > 0.0) {
            return Err(format!("the stiffness {} must be finite and positive (Pa/m)", self.stiffness));
        }
        match self.shear_strength {
            Some(strength) if !(strength.is_finite() && strength >= 0.0) => {
                Err(format!("the shear strength {strength} must be finite and not negative (Pa)"))
            }
            _ => Ok(()),
        }
    }
}

/// When two bodies act on each other at a node that knows both, besides that their velocities approach
/// (sheet: mpm §2.12).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ContactTest {
    /// Always: contact begins up to a cell early, and what rolls or comes near at an angle is held back. With normals from
    /// the gradients of volumes corners dig in: a block that slides down loses more than half of its acceleration.
    Approach,
    /// Where their surfaces touch, by what the node knows of their volumes and surfaces. What rests upon another
    /// bounces more, since nothing dampens the approach. Not on a mesh.
    Gap,
}
