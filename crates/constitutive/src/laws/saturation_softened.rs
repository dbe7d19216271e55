//! Loss of strength by wetting (sheet: constitutive §2.17; after Bui & Nguyen 2021, section 4.6).
//!
//! The cohesion of the inner law depends on the degree of saturation of the step,
//! `c = c_sat + (c_dry - c_sat)(1 - S_r)`; the inner law's own cohesion is `c_dry`. Without pore
//! fluid (`S_r = 0`) nothing changes. Limit: rate-form Drucker–Prager and Mohr–Coulomb.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{DruckerPrager, Elasticity, MohrCoulomb, PlasticStrain};
use crate::Warning;
use crate::contract::parameter_checks::check;
use crate::laws::model::{Model, ModelFamily, ModelInfo, StrainMeasure};
use crate::{
    Corotational, InitialCondition, Law, Material, MaterialError, MaterialSpec, Motion, Point, PointLaw,
    SmallStrain, SymTensor, Tangent,
};

/// Value of the key `model` in case files.
const NAME: &str = "saturation-softened";

/// Parameters of `saturation-softened`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SaturationSoftenedSpec {
    /// Cohesion of saturated soil (Pa), 0 to the dry one.
    pub saturated_cohesion: f64,
    /// Dry soil: `drucker-prager` or `mohr-coulomb`, rate form, constant strength.
    pub material: Box<MaterialSpec>,
}

impl SaturationSoftenedSpec {
    /// Parameters from saturated cohesion (Pa) and material.
    #[must_use]
    pub fn new(saturated_cohesion: f64, material: impl Into<MaterialSpec>) -> Self {
        Self { saturated_cohesion, material: Box::new(material.into()) }
    }
}

impl Model for SaturationSoftenedSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "after Bui & Nguyen 2021, section 4.6",
        kind: ModelFamily::Wrapper,
        strain: "rate",
        tangent: "the inner law's",
    };

    fn inner(&self) -> Option<&MaterialSpec> {
        Some(&self.material)
    }

    fn wrap_material(&self, _inner: Arc<dyn Material>) -> Result<Arc<dyn Material>, MaterialError> {
        let saturated_law = self.saturated_cohesion;
        let within = |dry: f64| {
            let rule = format!("is not between 0 and the cohesion of the material, {dry} Pa");
            check("saturated_cohesion", saturated_law, (0.0..=dry).contains(&saturated_law), &rule)
        };
        let under = |error: MaterialError| error.with_model(self.material.name()).under_key("material");
        let refuse = |rule: &str| Err(MaterialError::incompatible_options("material", rule));
        match &*self.material {
            MaterialSpec::DruckerPrager(spec) if spec.strain_measure == StrainMeasure::Rate => {
                within(spec.cohesion)?;
                let law = spec.law().map_err(under)?;
                Ok(Arc::new(Corotational(SaturationSoftened { law, dry_law: spec.cohesion, saturated_law })))
            }
            MaterialSpec::MohrCoulomb(spec) if spec.strain_measure == StrainMeasure::Rate => {
                within(spec.cohesion)?;
                if spec.tensile_strength.is_some() {
                    return refuse("a tension cut-off is not available with loss of strength by saturation");
                }
                let law = spec.law().map_err(under)?;
                Ok(Arc::new(Corotational(SaturationSoftened { law, dry_law: spec.cohesion, saturated_law })))
            }
            _ => refuse("must be drucker-prager or mohr-coulomb in rate form"),
        }
    }

    fn warnings(&self) -> Vec<Warning> {
        self.material.warnings().into_iter().map(|warning| warning.at("material")).collect()
    }

    fn examples() -> Vec<Self> {
        let around = |material| Self { saturated_cohesion: 1e3, material: Box::new(material) };
        let fits = |spec: &MaterialSpec| spec.inner().is_none() && around(spec.clone()).build().is_ok();
        MaterialSpec::examples().into_iter().filter(fits).map(around).collect()
    }
}

/// Law whose cohesion can be multiplied by a factor.
pub(crate) trait ScalableCohesion: SmallStrain<State = PlasticStrain> + Clone {
    /// Returns the law with peak and residual cohesion multiplied by `share`.
    fn with_cohesion_share(&self, share: f64) -> Self;
}

impl ScalableCohesion for DruckerPrager {
    fn with_cohesion_share(&self, share: f64) -> Self {
        self.scaled_cohesion(share)
    }
}

impl ScalableCohesion for MohrCoulomb {
    fn with_cohesion_share(&self, share: f64) -> Self {
        self.scaled_cohesion(share)
    }
}

/// Law whose cohesion decreases with the degree of saturation. The comment of this module gives its source and limits.
#[derive(Clone, Debug)]
struct SaturationSoftened<L> {
    law: L,
    dry_law: f64,
    saturated_law: f64,
}

/// State of the inner law with the saturation at the end of the last step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct WettedState {
    plastic_strain: PlasticStrain,
    saturation: f64,
}

impl<L: ScalableCohesion> SaturationSoftened<L> {
    /// Law with the cohesion interpolated between its dry and its saturated value at a degree of saturation.
    fn law_at_saturation(&self, saturation: f64) -> L {
        if saturation == 0.0 || self.dry_law == 0.0 {
            return self.law.clone();
        }
        let cohesion = self.saturated_law + (self.dry_law - self.saturated_law) * (1.0 - saturation);
        self.law.with_cohesion_share(cohesion / self.dry_law)
    }

    /// Point with the plastic state of the inner law, without the saturation.
    fn plastic_point(point: &Point<WettedState>) -> Point<PlasticStrain> {
        Point { stress: point.stress, state: point.state.plastic_strain }
    }
}

impl<L: ScalableCohesion> Law for SaturationSoftened<L> {
    fn name(&self) -> &'static str {
        NAME
    }

    fn output_names(&self) -> &[&'static str] {
        self.law.output_names()
    }
}

impl<L: ScalableCohesion> PointLaw for SaturationSoftened<L> {
    type State = WettedState;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<WettedState>, MaterialError> {
        let Point { stress, state } = self.law.initial(initial)?;
        Ok(Point { stress, state: WettedState { plastic_strain: state, saturation: 0.0 } })
    }

    fn wave_modulus(&self, point: &Point<WettedState>) -> f64 {
        self.law.wave_modulus(&Self::plastic_point(point))
    }

    fn yield_value(&self, point: &Point<WettedState>) -> Option<f64> {
        self.law_at_saturation(point.state.saturation).yield_value(&Self::plastic_point(point))
    }

    fn linear_elasticity(&self) -> Option<&Elasticity> {
        self.law.linear_elasticity()
    }

    fn outputs(&self, point: &Point<WettedState>, out: &mut [f64]) {
        self.law.outputs(&Self::plastic_point(point), out);
    }
}

impl<L: ScalableCohesion> SmallStrain for SaturationSoftened<L> {
    fn update(
        &self,
        strain: &SymTensor,
        motion: &Motion,
        old: &Point<WettedState>,
    ) -> Result<Point<WettedState>, MaterialError> {
        let saturation = motion.pore.saturation;
        if !(0.0..=1.0).contains(&saturation) {
            return Err(MaterialError::Motion { model: NAME, reason: "saturation is not between 0 and 1" });
        }
        let Point { stress, state } =
            self.law_at_saturation(saturation).update(strain, motion, &Self::plastic_point(old))?;
        Ok(Point { stress, state: WettedState { plastic_strain: state, saturation } })
    }

    fn tangent(&self, strain: &SymTensor, motion: &Motion, old: &Point<WettedState>) -> Option<Tangent> {
        self.law_at_saturation(motion.pore.saturation).tangent(strain, motion, &Self::plastic_point(old))
    }
}
