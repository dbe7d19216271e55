//! Materials as a case file gives them: the one list of models.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::laws::{Elasticity, LinearElastic};
use crate::{Corotational, Material, MaterialError};

/// A material of a case file: the model's name and its parameters, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "model", rename_all = "kebab-case")]
pub enum MaterialSpec {
    /// Linear isotropic elasticity in rate form.
    LinearElastic(LinearElasticSpec),
}

/// Parameters of `linear-elastic`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LinearElasticSpec {
    /// Density (kg/m³), > 0.
    pub density: f64,
    /// Young's modulus (Pa), > 0.
    pub youngs_modulus: f64,
    /// Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
}

impl MaterialSpec {
    /// Name of the model.
    pub fn name(&self) -> &'static str {
        match self {
            Self::LinearElastic(_) => "linear-elastic",
        }
    }

    /// Initial density (kg/m³).
    pub fn density(&self) -> f64 {
        match self {
            Self::LinearElastic(spec) => spec.density,
        }
    }

    /// What is allowed but worth a word, each starting with the parameter's name.
    pub fn warnings(&self) -> Vec<String> {
        Vec::new()
    }

    /// True for parameters that mean something in plane strain only.
    pub fn assumes_plane_strain(&self) -> bool {
        false
    }

    /// The law, parameters checked and angles converted.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        match self {
            Self::LinearElastic(spec) => {
                let elasticity = Elasticity::new(spec.youngs_modulus, spec.poissons_ratio)?;
                Ok(Arc::new(Corotational(LinearElastic { elasticity })))
            }
        }
    }
}
