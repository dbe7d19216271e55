//! Stress-free strain (sheet: constitutive §3.11; Bui & Nguyen 2021, section 4.5): shrinkage by drying,
//! swelling by wetting.
//!
//! An isotropic strain grows linearly to its final value and is subtracted from the motion passed to the inner
//! law: `Δε_mech = Δε - Δε_free 1/3`. Limit: isotropic and equal for all points of the material.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Warning;
use crate::adapters::wrapper::{WrappedMaterial, Wrapper};
use crate::contract::parameter_checks::{check, positive};
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::{Mat3, Material, MaterialError, MaterialSpec, Motion, SymTensor};

/// Parameters of `eigenstrain`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EigenstrainSpec {
    /// Final volumetric strain, expansion-positive, -0.5 to 0.5.
    pub volumetric_strain: f64,
    /// Linear growth time from the start (s), positive.
    pub duration: f64,
    /// Material that shrinks or swells.
    pub material: Box<MaterialSpec>,
}

impl EigenstrainSpec {
    /// Parameters from volumetric strain (-), duration (s) and material.
    #[must_use]
    pub fn new(volumetric_strain: f64, duration: f64, material: impl Into<MaterialSpec>) -> Self {
        Self { volumetric_strain, duration, material: Box::new(material.into()) }
    }
}

impl Model for EigenstrainSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Bui & Nguyen 2021, section 4.5",
        kind: ModelFamily::Wrapper,
        strain: "the inner law's",
        tangent: "the inner law's",
    };

    fn inner(&self) -> Option<&MaterialSpec> {
        Some(&self.material)
    }

    fn wrap_material(&self, inner: Arc<dyn Material>) -> Result<Arc<dyn Material>, MaterialError> {
        let strain = self.volumetric_strain;
        check("volumetric_strain", strain, strain.abs() <= 0.5, "is not between -0.5 and 0.5")?;
        positive("duration", self.duration, "s")?;
        let wrapper = Eigenstrain { volumetric: strain, duration: self.duration };
        Ok(Arc::new(WrappedMaterial::new(wrapper, inner)))
    }

    fn warnings(&self) -> Vec<Warning> {
        self.material.warnings().into_iter().map(|warning| warning.at("material")).collect()
    }

    fn strength_reduced(&self, reduction: &super::StrengthReduction) -> Option<Result<Self, MaterialError>> {
        let reduced = self.material.strength_reduced(reduction);
        Some(reduced.map(|material| Self { material: Box::new(material), ..self.clone() }))
    }

    fn examples() -> Vec<Self> {
        // Over before the first steps of the contract tests that matter: shrinkage is no motion.
        let around = |material| Self { volumetric_strain: 0.0, duration: 1.0, material: Box::new(material) };
        let inner =
            MaterialSpec::examples().into_iter().filter(|spec| spec.inner().is_none() && !spec.is_fluid());
        inner.take(4).map(around).collect()
    }
}

/// Stress-free strain that grows with time; its internal variable is the time since the start (s).
struct Eigenstrain {
    volumetric: f64,
    duration: f64,
}

impl Wrapper for Eigenstrain {
    type OwnState = f64;

    const NAME: &'static str = "eigenstrain";
    const TIME_DEPENDENT: bool = true;

    fn start(&self) -> f64 {
        0.0
    }

    fn inner_stress(&self, stress: &SymTensor, _time: &f64) -> SymTensor {
        *stress
    }

    fn outer_stress(&self, inner: &SymTensor, _time: &f64) -> SymTensor {
        *inner
    }

    fn step(&self, motion: &Motion, time: &f64) -> (Motion, f64) {
        let growing = (self.duration - time).clamp(0.0, motion.dt);
        let linear = self.volumetric * growing / self.duration / 3.0;
        let mut inside = *motion;
        if linear != 0.0 {
            inside.velocity_gradient_dt = motion.velocity_gradient_dt - Mat3::IDENTITY * linear;
            inside.deformation = motion.deformation * (-linear).exp();
        }
        (inside, time + motion.dt)
    }
}
