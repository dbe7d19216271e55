//! Compressible neo-Hookean elasticity (sheet: constitutive §2.13).
//!
//! Kirchhoff stress `τ = μ (b - 1) + U 1` with the left Cauchy–Green tensor `b`. Volumetric term, by
//! choice: `U = λ ln J` with energy `Ψ = μ/2 (tr b - 3) - μ ln J + λ/2 (ln J)²` per initial volume, or
//! `U = λ/2 (J² - 1)` with `λ/4 (J² - 1) - λ/2 ln J` in place of its last term. Path-independent at any
//! strain. Limits: under extreme compression the logarithmic term softens; the quadratic one is softer
//! in compression and stiffer in extension throughout.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Elasticity;
use super::finite_elastic::{FiniteElastic, jacobian, log_jacobian};
use super::linear_elastic::incompressibility_warnings;
use crate::Warning;
use crate::laws::model::with_defaults;
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::{Material, MaterialError, SymTensor, Tangent};

/// Parameters of `neo-hookean`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NeoHookeanSpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Small-strain Young's modulus (Pa), positive.
    pub youngs_modulus: f64,
    /// Small-strain Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Pressure as function of volume.
    #[serde(default)]
    pub volumetric_law: VolumetricLaw,
}

impl NeoHookeanSpec {
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

/// Volumetric term `U` of the Kirchhoff stress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VolumetricLaw {
    /// `λ ln J`.
    #[default]
    Logarithmic,
    /// `λ/2 (J² - 1)`.
    Quadratic,
}

impl Model for NeoHookeanSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Larese et al. 2020, 4.3.1; Bonet & Wood 2008",
        kind: ModelFamily::Solid,
        strain: "finite",
        tangent: "analytic",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        Ok(Arc::new(NeoHookean { elasticity, volumetric_law: self.volumetric_law }))
    }

    fn warnings(&self) -> Vec<Warning> {
        incompressibility_warnings(self.poissons_ratio)
    }

    fn examples() -> Vec<Self> {
        let with = |volumetric_law| Self {
            density: 2000.0,
            youngs_modulus: 20e6,
            poissons_ratio: 0.3,
            volumetric_law,
        };
        [VolumetricLaw::Logarithmic, VolumetricLaw::Quadratic].map(with).into()
    }
}

/// Neo-Hookean law. See the module's head for source and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    /// Elastic constants at small strain.
    pub elasticity: Elasticity,
    /// Dependence of pressure on the volume.
    pub volumetric_law: VolumetricLaw,
}

/// Volumetric stress, its derivative and its energy at a given volume.
struct VolumetricTerm {
    /// Kirchhoff stress `U` (Pa).
    stress: f64,
    /// Slope `dU/d ln J` (Pa).
    slope: f64,
    /// Energy per unit initial volume (J/m³).
    energy: f64,
}

impl NeoHookean {
    /// Volumetric stress (Pa), its slope and energy (J/m³) at the logarithm of the volume ratio.
    fn volumetric(&self, log: f64) -> VolumetricTerm {
        let lame = self.elasticity.lame();
        match self.volumetric_law {
            VolumetricLaw::Logarithmic => {
                VolumetricTerm { stress: lame * log, slope: lame, energy: 0.5 * lame * log * log }
            }
            VolumetricLaw::Quadratic => {
                let change = (2.0 * log).exp_m1();
                VolumetricTerm {
                    stress: 0.5 * lame * change,
                    slope: lame * (1.0 + change),
                    energy: 0.25 * lame * change - 0.5 * lame * log,
                }
            }
        }
    }

    /// Tensor `b - 1` of the Cauchy stress `stress`: its volume ratio by bisection in the logarithm.
    fn deformation_of(&self, stress: &SymTensor) -> Option<SymTensor> {
        let mu = self.elasticity.shear_modulus;
        let spectrum = stress.spectrum();
        let changes = |log: f64| spectrum.values.map(|s| (log.exp() * s - self.volumetric(log).stress) / mu);
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

impl FiniteElastic for NeoHookean {
    const NAME: &'static str = "neo-hookean";

    #[inline]
    fn cauchy_stress(&self, b: &SymTensor) -> SymTensor {
        let log = log_jacobian(b);
        (*b * self.elasticity.shear_modulus + SymTensor::isotropic(self.volumetric(log).stress))
            * (1.0 / jacobian(b))
    }

    fn deformation_for_stress(&self, stress: &SymTensor) -> Result<SymTensor, MaterialError> {
        if *stress == SymTensor::ZERO {
            return Ok(SymTensor::ZERO);
        }
        let reason = "no moderate deformation gives this stress".to_owned();
        self.deformation_of(stress).ok_or(MaterialError::Initial { model: Self::NAME, reason })
    }

    fn spatial_tangent(&self, b: &SymTensor) -> Tangent {
        let VolumetricTerm { stress, slope, .. } = self.volumetric(log_jacobian(b));
        let shear = self.elasticity.shear_modulus - stress;
        // c = dU/d ln J 1⊗1 + 2 (μ - U) I
        let mut c = Tangent::ZERO;
        c.add_dyad(slope, &SymTensor::IDENTITY, &SymTensor::IDENTITY);
        for i in 0..3 {
            c.0[i][i] += 2.0 * shear;
            c.0[i + 3][i + 3] += shear;
        }
        c
    }

    fn max_wave_modulus(&self, b: &SymTensor, largest: f64, _stress: &SymTensor) -> f64 {
        let mu = self.elasticity.shear_modulus;
        let log = log_jacobian(b);
        let VolumetricTerm { stress, slope, .. } = self.volumetric(log);
        // max (c_AAAA + τ_A) / J of §3.9.
        (slope + 2.0 * mu - stress + mu * largest) / jacobian(b)
    }

    fn initial_energy(&self, b: &SymTensor) -> f64 {
        let mu = self.elasticity.shear_modulus;
        let log = log_jacobian(b);
        0.5 * mu * b.trace() - mu * log + self.volumetric(log).energy
    }
}
