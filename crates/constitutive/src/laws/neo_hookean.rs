//! Compressible neo-Hookean elasticity (constitutive sheet §2.13).
//!
//! Kirchhoff stress `τ = μ (b - 1) + λ ln J 1` with the left Cauchy–Green tensor `b`; energy
//! `Ψ = μ/2 (tr b - 3) - μ ln J + λ/2 (ln J)²` per initial volume. Path-independent at any strain.
//! Limit: under extreme compression the logarithmic volumetric term softens.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Elasticity, check};
use crate::{InitialCondition, MaterialError, Motion, Point, StressUpdate, SymTensor};

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

impl NeoHookeanSpec {
    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<NeoHookean, MaterialError> {
        check(
            "density",
            self.density,
            self.density.is_finite() && self.density > 0.0,
            "must be positive (kg/m³)",
        )?;
        Ok(NeoHookean { elasticity: Elasticity::new(self.youngs_modulus, self.poissons_ratio)? })
    }
}

/// The law. See the module's head for source and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    /// Elastic constants at small strain.
    pub elasticity: Elasticity,
}

/// Left Cauchy–Green tensor of a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeftCauchyGreen(pub SymTensor);

impl NeoHookean {
    /// Cauchy stress of the left Cauchy–Green tensor `b` (Pa).
    #[inline]
    pub fn stress(&self, b: &SymTensor) -> SymTensor {
        let jacobian = b.determinant().sqrt();
        let (mu, lame) = (self.elasticity.shear_modulus, self.elasticity.lame());
        let volumetric = SymTensor::isotropic(lame * jacobian.ln() - mu);
        (*b * mu + volumetric) * (1.0 / jacobian)
    }

    /// The tensor `b` whose Cauchy stress is `stress`: its volume ratio by bisection in the logarithm.
    fn deformation_of(&self, stress: &SymTensor) -> Option<SymTensor> {
        let (mu, lame) = (self.elasticity.shear_modulus, self.elasticity.lame());
        let spectrum = stress.spectrum();
        let squares = |log: f64| spectrum.values.map(|s| 1.0 + (log.exp() * s - lame * log) / mu);
        let residual = |log: f64| {
            let [a, b, c] = squares(log);
            if a > 0.0 && b > 0.0 && c > 0.0 { (a * b * c).ln() - 2.0 * log } else { f64::NEG_INFINITY }
        };
        let (mut low, mut high) = (-2.0, 2.0);
        if !(residual(low) > 0.0 && residual(high) < 0.0) {
            return None;
        }
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if residual(middle) > 0.0 { low = middle } else { high = middle }
        }
        Some(spectrum.compose(squares(0.5 * (low + high))))
    }
}

impl StressUpdate for NeoHookean {
    type State = LeftCauchyGreen;

    fn name(&self) -> &'static str {
        NAME
    }

    fn initial(&self, initial: &InitialCondition) -> Result<Point<LeftCauchyGreen>, MaterialError> {
        if initial.stress == SymTensor::ZERO {
            return Ok(Point { stress: SymTensor::ZERO, state: LeftCauchyGreen(SymTensor::IDENTITY) });
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
        let b = old.state.0.rotated(&motion.deformation);
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

    fn wave_modulus(&self, point: &Point<LeftCauchyGreen>) -> f64 {
        let b = &point.state.0;
        let (mu, lame) = (self.elasticity.shear_modulus, self.elasticity.lame());
        let jacobian = b.determinant().sqrt();
        // max (c_AAAA + τ_A) / J of §3.9.
        let log = lame * jacobian.ln();
        (lame + mu - log + mu * b.principal_values()[0]) / jacobian
    }

    fn stored_energy(&self, point: &Point<LeftCauchyGreen>) -> Option<f64> {
        let b = &point.state.0;
        let (mu, lame) = (self.elasticity.shear_modulus, self.elasticity.lame());
        let jacobian = b.determinant().sqrt();
        let log = jacobian.ln();
        Some((0.5 * mu * (b.trace() - 3.0) - mu * log + 0.5 * lame * log * log) / jacobian)
    }
}
