//! Contacts of `methods.mpm`.

use colluvium_case::CaseErrorKind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Contact of two bodies: separation, Coulomb friction, adhesion (sheet: mpm §2.12).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyContact {
    /// Names of both bodies.
    pub bodies: [String; 2],
    /// Interface friction coefficient.
    #[serde(default)]
    pub friction_coefficient: f64,
    /// Adhesion (Pa): shear strength of the closed interface without normal stress.
    #[serde(default)]
    pub adhesion: f64,
    /// Direction from the first body to the second, for plane interfaces; from volume gradients when absent.
    #[serde(default)]
    pub normal: Option<Vec<f64>>,
    /// Contact test; when absent `gap`, or `approach` on a mesh and with `normal`.
    #[serde(default)]
    pub test: Option<ContactTest>,
    /// Normal force that grows with overlap, in place of a velocity condition. Needs `test` `gap`.
    #[serde(default)]
    pub penalty: Option<PenaltyContact>,
}

impl BodyContact {
    /// Contact of two bodies without friction and adhesion.
    #[must_use]
    pub fn new(bodies: [impl Into<String>; 2]) -> Self {
        Self {
            bodies: bodies.map(Into::into),
            friction_coefficient: 0.0,
            adhesion: 0.0,
            normal: None,
            test: None,
            penalty: None,
        }
    }

    /// Test of contact, on a grid or on a mesh.
    pub fn test(&self, on_mesh: bool) -> ContactTest {
        // A given plane defines where bodies touch; without it bodies that come near would catch at their corners.
        let usual = if on_mesh || self.normal.is_some() { ContactTest::Approach } else { ContactTest::Gap };
        self.test.unwrap_or(usual)
    }

    /// Checks the values; the error is the key and the problem.
    pub(crate) fn validate(&self, on_mesh: bool) -> Result<(), (&'static str, CaseErrorKind)> {
        for (key, value) in [("friction_coefficient", self.friction_coefficient), ("adhesion", self.adhesion)]
        {
            if !(value.is_finite() && value >= 0.0) {
                return Err((key, CaseErrorKind::out_of_range(value, "must be finite and not negative")));
            }
        }
        let test = self.test(on_mesh);
        if on_mesh && test == ContactTest::Gap {
            let problem = "gap needs a structured grid, whose shape functions give the distance of a surface: \
                           use approach";
            return Err(("test", CaseErrorKind::coded("needs-other-key", problem)));
        }
        self.penalty
            .map_or(Ok(()), |penalty| penalty.validate(test))
            .map_err(|problem| ("penalty", problem.into()))
    }
}

/// Penalty contact (sheet: mpm §4 row 58; after Ma, Zhang & Lian): normal stress from overlap, friction up to a shear strength.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PenaltyContact {
    /// Normal stress per metre of overlap (Pa/m), positive. A step separates bodies at most by the overlap.
    pub stiffness: f64,
    /// Largest shear stress (Pa) at any normal stress, non-negative; unlimited when absent.
    #[serde(default)]
    pub shear_strength: Option<f64>,
}

impl PenaltyContact {
    /// Penalty contact of a stiffness (Pa/m), without an upper bound of the shear stress.
    #[must_use]
    pub fn new(stiffness: f64) -> Self {
        Self { stiffness, shear_strength: None }
    }

    /// Checks the values, and that the contact criterion `test` supports them; the error describes the problem.
    pub(crate) fn validate(&self, test: ContactTest) -> Result<(), String> {
        if test != ContactTest::Gap {
            return Err("needs test gap, which measures the overlap".to_owned());
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

/// Contact condition at a node with both bodies' mass, besides approach (sheet: mpm §2.12).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ContactTest {
    /// Approaching velocities alone. Contact begins up to a cell early, and slows bodies that roll or approach at an angle. With normals
    /// from volume gradients a sliding block loses more than half its acceleration.
    Approach,
    /// Closed gap, estimated at the node from volumes and surfaces. Resting bodies bounce more, as approach is not damped. Not on a mesh.
    Gap,
}
