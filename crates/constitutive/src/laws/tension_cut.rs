//! Tension cut-off around an elastic law (sheet: constitutive §2.5, §3.11): Rankine's criterion.
//!
//! After the elastic step no principal stress exceeds the tensile strength; flow is associated, so the
//! return couples the principal stresses through the elasticity. Mohr–Coulomb has a cut-off of its own
//! (`tensile_strength`), with the corners between both surfaces.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::multi_surface::{ActiveSet, YieldPlane, active_set, return_to, tangent};
use super::{Elasticity, LinearElasticSpec};
use crate::Warning;
use crate::adapters::hencky::small_strain_tangent;
use crate::contract::parameter_checks::not_negative;
use crate::laws::model::with_defaults;
use crate::laws::model::{Model, ModelFamily, ModelInfo, StrainMeasure};
use crate::{
    InitialCondition, Law, Material, MaterialError, Motion, Point, PointLaw, PrincipalReturn, SmallStrain,
    SymTensor, Tangent,
};

/// Value of the key `model` in case files.
const NAME: &str = "tension-cut";

/// Parameters of `tension-cut`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TensionCutSpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Young's modulus (Pa), positive.
    pub youngs_modulus: f64,
    /// Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Largest principal tension (Pa), non-negative.
    pub tensile_strength: f64,
    /// Strain measure.
    #[serde(default)]
    pub strain_measure: StrainMeasure,
    /// Return of initial stress outside yield; otherwise refused.
    #[serde(default)]
    pub return_initial_stress_to_yield: bool,
}

impl TensionCutSpec {
    /// Parameters from density (kg/m³), Young's modulus (Pa), Poisson's ratio (-) and tensile strength (Pa); all others have their
    /// defaults.
    #[must_use]
    pub fn new(density: f64, youngs_modulus: f64, poissons_ratio: f64, tensile_strength: f64) -> Self {
        with_defaults(&[
            ("density", density),
            ("youngs_modulus", youngs_modulus),
            ("poissons_ratio", poissons_ratio),
            ("tensile_strength", tensile_strength),
        ])
    }

    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<TensionCut, MaterialError> {
        not_negative("tensile_strength", self.tensile_strength, "Pa")?;
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        Ok(TensionCut {
            elasticity,
            strength: self.tensile_strength,
            return_initial_stress_to_yield: self.return_initial_stress_to_yield,
        })
    }
}

impl Model for TensionCutSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Rankine; multi-surface return",
        kind: ModelFamily::Solid,
        strain: "rate or Hencky",
        tangent: "analytic",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(self.strain_measure.wrap(self.law()?))
    }

    fn warnings(&self) -> Vec<Warning> {
        let Self { density, youngs_modulus, poissons_ratio, strain_measure, .. } = *self;
        LinearElasticSpec { density, youngs_modulus, poissons_ratio, strain_measure }.warnings()
    }

    fn examples() -> Vec<Self> {
        let with = |strain_measure| Self {
            density: 2000.0,
            youngs_modulus: 20e6,
            poissons_ratio: 0.3,
            tensile_strength: 5e3,
            strain_measure,
            return_initial_stress_to_yield: false,
        };
        [StrainMeasure::Rate, StrainMeasure::Hencky].map(with).into()
    }
}

/// Tension cut-off law. See the module's head for source and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TensionCut {
    elasticity: Elasticity,
    strength: f64,
    return_initial_stress_to_yield: bool,
}

impl TensionCut {
    /// Yield planes of the three principal stresses, each at the tensile strength (Pa).
    fn planes(&self) -> [YieldPlane; 3] {
        let plane = |c| {
            let normal = std::array::from_fn(|i| if i == c { 1.0 } else { 0.0 });
            YieldPlane { normal, offset: self.strength, flow: normal }
        };
        [plane(0), plane(1), plane(2)]
    }

    /// Planes that are active after the return of principal trial stresses (Pa); `None` inside the cut-off.
    fn active_planes(&self, trial: [f64; 3]) -> Option<ActiveSet> {
        let slack = 8.0 * f64::EPSILON * (self.strength + trial[0].abs());
        if trial[0] <= self.strength + slack {
            return None;
        }
        active_set(&self.planes(), &self.elasticity, trial)
    }
}

impl Law for TensionCut {
    fn name(&self) -> &'static str {
        NAME
    }
}

impl PointLaw for TensionCut {
    type State = ();

    fn initial(&self, initial: &InitialCondition) -> Result<Point<()>, MaterialError> {
        if self.return_initial_stress_to_yield && initial.stress.is_finite() {
            let start = Point { stress: initial.stress, state: () };
            return self.update(&SymTensor::ZERO, &Motion::AT_REST, &start);
        }
        let principal = initial.stress.principal_values();
        super::check_initial(NAME, &initial.stress, principal[0] - self.strength, initial.stress.norm())?;
        Ok(Point { stress: initial.stress, state: () })
    }

    fn wave_modulus(&self, _point: &Point<()>) -> f64 {
        self.elasticity.p_wave_modulus()
    }

    fn yield_value(&self, point: &Point<()>) -> Option<f64> {
        Some(point.stress.spectrum().values[0] - self.strength)
    }

    fn linear_elasticity(&self) -> Option<&Elasticity> {
        Some(&self.elasticity)
    }
}

impl SmallStrain for TensionCut {
    #[inline]
    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<()>,
    ) -> Result<Point<()>, MaterialError> {
        let trial = old.stress + self.elasticity.stress(strain);
        let spectrum = trial.spectrum();
        let (stress, ()) = self.return_principal(spectrum.values, &())?;
        let stress = if stress == spectrum.values { trial } else { spectrum.compose(stress) };
        Ok(Point { stress, state: () })
    }

    fn tangent(&self, strain: &SymTensor, _motion: &Motion, old: &Point<()>) -> Option<Tangent> {
        small_strain_tangent(self, &(old.stress + self.elasticity.stress(strain)), &old.state)
    }
}

impl PrincipalReturn for TensionCut {
    fn elasticity(&self) -> &Elasticity {
        &self.elasticity
    }

    fn return_principal(&self, trial: [f64; 3], _state: &()) -> Result<([f64; 3], ()), MaterialError> {
        if !trial.iter().all(|s| s.is_finite()) {
            return Err(MaterialError::Motion { model: NAME, reason: "the trial stress is not finite" });
        }
        let Some(set) = self.active_planes(trial) else { return Ok((trial, ())) };
        let planes = self.planes();
        let onto = |stress| return_to(&planes, set, &self.elasticity, stress);
        Ok((onto(onto(trial)), ()))
    }

    fn principal_tangent(&self, trial: [f64; 3], _state: &()) -> Option<[[f64; 3]; 3]> {
        Some(match self.active_planes(trial) {
            None => self.elasticity.principal(),
            Some(set) => tangent(&self.planes(), set, &self.elasticity),
        })
    }
}
