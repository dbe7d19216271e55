//! Linear isotropic elasticity (sheet: constitutive §2.2; Hooke's law in rate form).
//!
//! `σ̇ = λ tr(D) 1 + 2G D` in the co-rotating frame. Parameters: Young's modulus (Pa) and Poisson's
//! ratio. Limits: hypoelastic at finite strain, so a closed strain path may leave a residual stress.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Warning;
use crate::adapters::hencky::SimdBatch;
use crate::contract::component_arrays::ComponentArrays;
use crate::contract::elasticity::Elasticity;
use crate::laws::model::with_defaults;
use crate::laws::model::{Model, ModelFamily, ModelInfo, StrainMeasure};
use crate::{
    BLOCK_SIZE, InitialCondition, Law, Material, MaterialError, Motion, Point, PointLaw, PrincipalReturn,
    SmallStrain, SymTensor, Tangent,
};

/// Parameters of `linear-elastic`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LinearElasticSpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Young's modulus (Pa), positive.
    pub youngs_modulus: f64,
    /// Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Strain measure.
    #[serde(default)]
    pub strain_measure: StrainMeasure,
}

impl LinearElasticSpec {
    /// Parameters from density (kg/m³), Young's modulus (Pa) and Poisson's ratio (-); all others have the defaults of a case file.
    #[must_use]
    pub fn new(density: f64, youngs_modulus: f64, poissons_ratio: f64) -> Self {
        with_defaults(&[
            ("density", density),
            ("youngs_modulus", youngs_modulus),
            ("poissons_ratio", poissons_ratio),
        ])
    }
}

impl Model for LinearElasticSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Hooke; Gaume et al. 2020, eqs. 17–19",
        kind: ModelFamily::Solid,
        strain: "rate or Hencky",
        tangent: "analytic",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        let law = LinearElastic { elasticity: Elasticity::new(self.youngs_modulus, self.poissons_ratio)? };
        Ok(self.strain_measure.wrap(law))
    }

    fn warnings(&self) -> Vec<Warning> {
        incompressibility_warnings(self.poissons_ratio)
    }

    fn examples() -> Vec<Self> {
        let with = |strain_measure| Self {
            density: 2000.0,
            youngs_modulus: 20e6,
            poissons_ratio: 0.3,
            strain_measure,
        };
        [StrainMeasure::Rate, StrainMeasure::Hencky].map(with).into()
    }
}

/// Warnings about nearly incompressible solids (sheet: mpm §7).
pub(crate) fn incompressibility_warnings(poissons_ratio: f64) -> Vec<Warning> {
    if poissons_ratio >= 0.49 {
        vec![Warning::new(
            "locking",
            format!(
                "poissons_ratio: {poissons_ratio} makes explicit time steps short, and low-order grids lock. \
             Give less than 0.49, or a remedy such as methods.mpm.volumetric_strain"
            ),
        )]
    } else {
        Vec::new()
    }
}

/// Warnings of Poisson's ratios that are unusual for snow (sheet: snow-mpm §7).
pub(crate) fn snow_ratio_warnings(poissons_ratio: f64) -> Vec<Warning> {
    if poissons_ratio > 0.45 {
        vec![Warning::new(
            "locking",
            format!(
                "poissons_ratio: {poissons_ratio} is above 0.45: low-order grids lock. Give 0.45 or \
                      less"
            ),
        )]
    } else if poissons_ratio < 0.0 {
        vec![Warning::new(
            "negative-poissons-ratio",
            format!(
                "poissons_ratio: {poissons_ratio} is negative: the material contracts laterally under \
             compression. Give 0 or more"
            ),
        )]
    } else {
        Vec::new()
    }
}

/// Text of a warning where `value` of the parameter `name` is above `limit`.
pub(crate) fn text_above((name, value, limit): (&str, f64, f64), why: &str) -> Option<String> {
    (value > limit).then(|| format!("{name}: {value} is above {limit}: {why}"))
}

/// Linear elasticity. See the module's head for source and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearElastic {
    /// Elastic constants.
    pub elasticity: Elasticity,
}

impl Law for LinearElastic {
    fn name(&self) -> &'static str {
        "linear-elastic"
    }
}

impl PointLaw for LinearElastic {
    type State = ();

    fn initial(&self, initial: &InitialCondition) -> Result<Point<()>, MaterialError> {
        Ok(Point { stress: initial.stress, state: () })
    }

    fn wave_modulus(&self, _point: &Point<()>) -> f64 {
        self.elasticity.p_wave_modulus()
    }

    fn linear_elasticity(&self) -> Option<&Elasticity> {
        Some(&self.elasticity)
    }
}

impl SmallStrain for LinearElastic {
    #[inline]
    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<()>,
    ) -> Result<Point<()>, MaterialError> {
        Ok(Point { stress: old.stress + self.elasticity.stress(strain), state: () })
    }

    #[inline]
    fn update_component_arrays(&self, lanes: &mut ComponentArrays, _states: &mut [()]) -> bool {
        lanes.for_each(&mut [0.0; BLOCK_SIZE], |strain, stress| {
            (*stress + self.elasticity.stress(strain), 0.0)
        });
        true
    }

    fn max_strain_increment(&self) -> f64 {
        f64::INFINITY
    }

    fn tangent(&self, _strain: &SymTensor, _motion: &Motion, _old: &Point<()>) -> Option<Tangent> {
        Some(self.elasticity.tangent())
    }

    fn dissipation(&self, _: &SymTensor, _: &Motion, _: &Point<()>, _: &Point<()>) -> Option<f64> {
        Some(0.0)
    }
}

impl PrincipalReturn for LinearElastic {
    fn supports_batch(&self) -> bool {
        true
    }

    fn return_batch<const N: usize>(&self, _few: &mut SimdBatch<N>, _states: &mut [(); N]) {}

    fn elasticity(&self) -> &Elasticity {
        &self.elasticity
    }

    fn return_principal(&self, trial: [f64; 3], _state: &()) -> Result<([f64; 3], ()), MaterialError> {
        Ok((trial, ()))
    }

    fn principal_tangent(&self, _trial: [f64; 3], _state: &()) -> Option<[[f64; 3]; 3]> {
        Some(self.elasticity.principal())
    }
}
