//! Fixed-corotated elasticity (sheet: constitutive §2.13; Stomakhin et al. 2012, 2013).
//!
//! Energy `Ψ = μ Σ (s_A - 1)² + λ/2 (J - 1)²` per initial volume of the principal stretches `s_A`; Kirchhoff
//! stress `τ = 2μ (F - R) Fᵀ + λ (J - 1) J 1`, in principal values `τ_A = 2μ s_A (s_A - 1) + λ J (J - 1)`.
//! Path-independent. Parameters: Young's modulus (Pa) and Poisson's ratio at small strain. Limits: the stress
//! is finite however far the point is flattened, so it does not prevent points from inverting.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Elasticity;
use super::finite_elastic::{FiniteElastic, PrincipalStress, elongations, solve_deformation, volume_change};
use super::linear_elastic::incompressibility_warnings;
use crate::Warning;
use crate::contract::tangent::kirchhoff_tangent;
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::{Material, MaterialError, SymTensor, Tangent};

/// Parameters of `fixed-corotated`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixedCorotatedSpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Small-strain Young's modulus (Pa), positive.
    pub youngs_modulus: f64,
    /// Small-strain Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
}

impl FixedCorotatedSpec {
    /// Parameters from density (kg/m³), Young's modulus (Pa) and Poisson's ratio (-).
    #[must_use]
    pub fn new(density: f64, youngs_modulus: f64, poissons_ratio: f64) -> Self {
        Self { density, youngs_modulus, poissons_ratio }
    }
}

impl Model for FixedCorotatedSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Stomakhin et al. 2013; Gaume et al. 2020, 4.1",
        kind: ModelFamily::Solid,
        strain: "finite",
        tangent: "analytic",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        Ok(Arc::new(FixedCorotated { elasticity }))
    }

    fn warnings(&self) -> Vec<Warning> {
        incompressibility_warnings(self.poissons_ratio)
    }

    fn examples() -> Vec<Self> {
        vec![Self { density: 2000.0, youngs_modulus: 20e6, poissons_ratio: 0.3 }]
    }
}

/// Fixed-corotated law. See the module's head for source and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedCorotated {
    /// Elastic constants at small strain.
    pub elasticity: Elasticity,
}

impl FixedCorotated {
    /// Principal Kirchhoff stresses (Pa) of principal elongations (stretches minus one).
    #[inline]
    pub fn principal(&self, elongations: [f64; 3]) -> PrincipalStress {
        let (mu, lame) = (self.elasticity.shear_modulus, self.elasticity.lame());
        let change = volume_change(elongations);
        let jacobian = 1.0 + change;
        let volumetric = lame * jacobian * change;
        let stress = elongations.map(|e| 2.0 * mu * (1.0 + e) * e + volumetric);
        let mut slope = [[lame * jacobian * (jacobian + change); 3]; 3];
        for (a, e) in elongations.into_iter().enumerate() {
            slope[a][a] += 2.0 * mu * (1.0 + e) * (1.0 + 2.0 * e);
        }
        PrincipalStress { stress, slope }
    }

    /// Elastic energy per unit initial volume (J/m³) of principal elongations (stretches minus one).
    pub fn energy(&self, elongations: [f64; 3]) -> f64 {
        let change = volume_change(elongations);
        self.elasticity.shear_modulus * elongations.iter().map(|e| e * e).sum::<f64>()
            + 0.5 * self.elasticity.lame() * change * change
    }
}

impl FiniteElastic for FixedCorotated {
    const NAME: &'static str = "fixed-corotated";

    #[inline]
    fn cauchy_stress(&self, b: &SymTensor) -> SymTensor {
        let spectrum = b.spectrum();
        let elongations = elongations(spectrum.values);
        spectrum.compose(self.principal(elongations).stress) * (1.0 / (1.0 + volume_change(elongations)))
    }

    fn deformation_for_stress(&self, stress: &SymTensor) -> Result<SymTensor, MaterialError> {
        solve_deformation(Self::NAME, stress, &self.elasticity, |e| self.principal(e))
    }

    fn spatial_tangent(&self, b: &SymTensor) -> Tangent {
        let spectrum = b.spectrum();
        let PrincipalStress { stress, slope } = self.principal(elongations(spectrum.values));
        kirchhoff_tangent(&spectrum, stress, spectrum.values.map(|b| 1.0 + b), &slope)
    }

    fn max_wave_modulus(&self, b: &SymTensor, _stress: &SymTensor) -> f64 {
        let (mu, lame) = (self.elasticity.shear_modulus, self.elasticity.lame());
        let values = b.spectrum().values;
        let jacobian = 1.0 + volume_change(elongations(values));
        // max (c_AAAA + τ_A) / J of §3.9, which is 2 μ s² + λ J² in the direction stretched most.
        2.0 * mu * (1.0 + values[0]) / jacobian + lame * jacobian
    }

    fn initial_energy(&self, b: &SymTensor) -> f64 {
        self.energy(elongations(b.spectrum().values))
    }
}
