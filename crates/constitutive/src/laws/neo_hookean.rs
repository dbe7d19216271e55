//! Compressible neo-Hookean elasticity (constitutive sheet §2.13).
//!
//! Kirchhoff stress `τ = μ (b - 1) + λ ln J 1` with the left Cauchy–Green tensor `b`; energy
//! `Ψ = μ/2 (tr b - 3) - μ ln J + λ/2 (ln J)²` per initial volume. Path-independent at any strain.
//! Limit: under extreme compression the logarithmic volumetric term softens.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Elasticity;
use super::linear_elastic::stiff_warnings;
use crate::hencky::carried;
use crate::model::{Facts, Kind, Model};
use crate::tangent::from_spatial;
use crate::{InitialCondition, Material, MaterialError, Motion, Point, StressUpdate, SymTensor, Tangent};

const NAME: &str = "neo-hookean";

/// Parameters of `neo-hookean`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NeoHookeanSpec {
    /// Density (kg/m³), > 0.
    pub density: f64,
    /// Young's modulus at small strain (Pa), > 0.
    pub youngs_modulus: f64,
    /// Poisson's ratio at small strain, between -1 and 0.5.
    pub poissons_ratio: f64,
}

impl Model for NeoHookeanSpec {
    const FACTS: Facts = Facts {
        source: "Larese et al. 2020, 4.3.1; Bonet & Wood 2008",
        kind: Kind::Solid,
        strain: "finite",
        tangent: "analytic",
    };

    fn density(&self) -> f64 {
        self.density
    }

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(Arc::new(NeoHookean { elasticity: Elasticity::new(self.youngs_modulus, self.poissons_ratio)? }))
    }

    fn warnings(&self) -> Vec<String> {
        stiff_warnings(self.poissons_ratio)
    }

    fn examples() -> Vec<Self> {
        vec![Self { density: 2000.0, youngs_modulus: 20e6, poissons_ratio: 0.3 }]
    }
}

/// The law. See the module's head for source and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    /// Elastic constants at small strain.
    pub elasticity: Elasticity,
}

/// Left Cauchy–Green tensor of a point less the unit tensor, `b - 1`: small strains keep their digits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeftCauchyGreen(pub SymTensor);

/// `ln J` of `b - 1`, from `J² - 1 = I1 + I2 + I3` of that tensor.
fn log_jacobian(b: &SymTensor) -> f64 {
    let i1 = b.trace();
    let i2 = 0.5 * (i1 * i1 - b.dot(b));
    0.5 * (i1 + i2 + b.determinant()).ln_1p()
}

impl NeoHookean {
    /// Cauchy stress (Pa) of the left Cauchy–Green tensor less the unit tensor.
    #[inline]
    pub fn stress(&self, b: &SymTensor) -> SymTensor {
        let log = log_jacobian(b);
        let (mu, lame) = (self.elasticity.shear_modulus, self.elasticity.lame());
        (*b * mu + SymTensor::isotropic(lame * log)) * (-log).exp()
    }

    /// The tensor `b - 1` whose Cauchy stress is `stress`: its volume ratio by bisection in the logarithm.
    fn deformation_of(&self, stress: &SymTensor) -> Option<SymTensor> {
        let (mu, lame) = (self.elasticity.shear_modulus, self.elasticity.lame());
        let spectrum = stress.spectrum();
        let changes = |log: f64| spectrum.values.map(|s| (log.exp() * s - lame * log) / mu);
        let residual = |log: f64| {
            let changes = changes(log);
            if changes.iter().all(|c| *c > -1.0) {
                changes.iter().map(|c| c.ln_1p()).sum::<f64>() - 2.0 * log
            } else {
                f64::NEG_INFINITY
            }
        };
        let (mut low, mut high) = (-2.0, 2.0);
        if !(residual(low) > 0.0 && residual(high) < 0.0) {
            return None;
        }
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if residual(middle) > 0.0 { low = middle } else { high = middle }
        }
        Some(spectrum.compose(changes(0.5 * (low + high))))
    }
}

impl StressUpdate for NeoHookean {
    type State = LeftCauchyGreen;

    fn name(&self) -> &'static str {
        NAME
    }

    fn initial(&self, initial: &InitialCondition) -> Result<Point<LeftCauchyGreen>, MaterialError> {
        if initial.stress == SymTensor::ZERO {
            return Ok(Point { stress: SymTensor::ZERO, state: LeftCauchyGreen(SymTensor::ZERO) });
        }
        let reason = "no deformation of moderate size carries this stress".to_owned();
        let b = self.deformation_of(&initial.stress).ok_or(MaterialError::Initial { model: NAME, reason })?;
        Ok(Point { stress: self.stress(&b), state: LeftCauchyGreen(b) })
    }

    #[inline]
    fn update(
        &self,
        motion: &Motion,
        old: &Point<LeftCauchyGreen>,
    ) -> Result<Point<LeftCauchyGreen>, MaterialError> {
        let b = carried(&old.state.0, &motion.deformation);
        let stretch = motion.deformation.determinant();
        if !(stretch > 0.0 && b.is_finite()) {
            return Err(MaterialError::Motion { model: NAME, reason: "the step inverts the point" });
        }
        let stress = self.stress(&b);
        if !stress.is_finite() {
            return Err(MaterialError::Motion { model: NAME, reason: "the stress is not finite" });
        }
        Ok(Point { stress, state: LeftCauchyGreen(b) })
    }

    fn tangent(&self, motion: &Motion, old: &Point<LeftCauchyGreen>) -> Result<Tangent, MaterialError> {
        let new = StressUpdate::update(self, motion, old)?;
        let log = log_jacobian(&new.state.0);
        let (mu, lame) = (self.elasticity.shear_modulus, self.elasticity.lame());
        // c = λ 1⊗1 + 2 (μ - λ ln J) I
        let mut c = Tangent::ZERO;
        c.add_dyad(lame, &SymTensor::IDENTITY, &SymTensor::IDENTITY);
        for i in 0..3 {
            c.0[i][i] += 2.0 * (mu - lame * log);
            c.0[i + 3][i + 3] += mu - lame * log;
        }
        let singular = MaterialError::Motion { model: NAME, reason: "the step inverts the point" };
        from_spatial(&c, motion, log.exp(), &new.stress).ok_or(singular)
    }

    fn wave_modulus(&self, point: &Point<LeftCauchyGreen>) -> f64 {
        let b = &point.state.0;
        let (mu, lame) = (self.elasticity.shear_modulus, self.elasticity.lame());
        let log = log_jacobian(b);
        // max (c_AAAA + τ_A) / J of §3.9.
        (lame + 2.0 * mu - lame * log + mu * b.principal_values()[0]) * (-log).exp()
    }

    fn stored_energy(&self, point: &Point<LeftCauchyGreen>) -> Option<f64> {
        let b = &point.state.0;
        let (mu, lame) = (self.elasticity.shear_modulus, self.elasticity.lame());
        let log = log_jacobian(b);
        Some((0.5 * mu * b.trace() - mu * log + 0.5 * lame * log * log) * (-log).exp())
    }

    fn dissipation(
        &self,
        _motion: &Motion,
        _old: &Point<LeftCauchyGreen>,
        _new: &Point<LeftCauchyGreen>,
    ) -> Option<f64> {
        Some(0.0)
    }
}
