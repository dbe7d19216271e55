//! St. Venant–Kirchhoff elasticity (sheet: constitutive §2.13; Gaume et al. 2020, eqs. 15–16).
//!
//! Linear in the Green strain: energy `Ψ = λ/2 (tr E)² + μ tr E²` per initial volume, Kirchhoff stress
//! `τ = λ/2 (tr b - 3) b + μ (b² - b)`. Path-independent. Parameters: Young's modulus (Pa) and Poisson's
//! ratio at small strain. Limits: in compression the nominal stress passes a maximum (at a stretch of 0.58
//! without lateral strain) and falls to nothing as the point is flattened; not for large compression.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Elasticity;
use super::finite_elastic::{FiniteElastic, PrincipalStress, jacobian, solve_deformation};
use super::linear_elastic::incompressibility_warnings;
use crate::Warning;
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::tensors::tensor::PAIRS;
use crate::{Material, MaterialError, SymTensor, Tangent};

/// Parameters of `st-venant-kirchhoff`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StVenantKirchhoffSpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Small-strain Young's modulus (Pa), positive.
    pub youngs_modulus: f64,
    /// Small-strain Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
}

impl StVenantKirchhoffSpec {
    /// Parameters from density (kg/m³), Young's modulus (Pa) and Poisson's ratio (-).
    #[must_use]
    pub fn new(density: f64, youngs_modulus: f64, poissons_ratio: f64) -> Self {
        Self { density, youngs_modulus, poissons_ratio }
    }
}

impl Model for StVenantKirchhoffSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Gaume et al. 2020, eqs. 15–16",
        kind: ModelFamily::Solid,
        strain: "finite",
        tangent: "analytic",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        Ok(Arc::new(StVenantKirchhoff { elasticity }))
    }

    fn warnings(&self) -> Vec<Warning> {
        incompressibility_warnings(self.poissons_ratio)
    }

    fn examples() -> Vec<Self> {
        vec![Self { density: 2000.0, youngs_modulus: 20e6, poissons_ratio: 0.3 }]
    }
}

/// St. Venant–Kirchhoff law. See the module's head for source and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StVenantKirchhoff {
    /// Elastic constants at small strain.
    pub elasticity: Elasticity,
}

impl StVenantKirchhoff {
    /// Kirchhoff stress (Pa) of the left Cauchy–Green tensor minus the unit tensor.
    #[inline(always)]
    pub fn kirchhoff_stress(&self, b: &SymTensor) -> SymTensor {
        let (mu, lame) = (self.elasticity.shear_modulus, self.elasticity.lame());
        let square = SymTensor::IDENTITY.rotated(&b.to_matrix());
        (*b + SymTensor::IDENTITY) * (0.5 * lame * b.trace()) + (*b + square) * mu
    }

    /// Principal Kirchhoff stresses (Pa) of principal elongations (stretches minus one).
    pub fn principal(&self, elongations: [f64; 3]) -> PrincipalStress {
        let (mu, lame) = (self.elasticity.shear_modulus, self.elasticity.lame());
        let change = elongations.map(|e| e * (2.0 + e));
        let trace: f64 = change.iter().sum();
        let stress = change.map(|c| (0.5 * lame * trace + mu * c) * (1.0 + c));
        let slope = std::array::from_fn(|a| {
            let square = 1.0 + change[a];
            let mut row = change.map(|c| lame * square * (1.0 + c));
            row[a] += 2.0 * (mu * square * square + stress[a]);
            row
        });
        PrincipalStress { stress, slope }
    }
}

impl FiniteElastic for StVenantKirchhoff {
    const NAME: &'static str = "st-venant-kirchhoff";

    #[inline(always)]
    fn cauchy_stress(&self, b: &SymTensor) -> SymTensor {
        self.kirchhoff_stress(b) * (1.0 / jacobian(b))
    }

    fn deformation_for_stress(&self, stress: &SymTensor) -> Result<SymTensor, MaterialError> {
        solve_deformation(Self::NAME, stress, &self.elasticity, |e| self.principal(e))
    }

    fn spatial_tangent(&self, b: &SymTensor) -> Tangent {
        let b = *b + SymTensor::IDENTITY;
        // c = λ b⊗b + μ (b_ik b_jl + b_il b_jk)
        let mut c = Tangent::ZERO;
        c.add_dyad(self.elasticity.lame(), &b, &b);
        for (row, &(i, j)) in PAIRS.iter().enumerate() {
            for (column, &(k, l)) in PAIRS.iter().enumerate() {
                c.0[row][column] += self.elasticity.shear_modulus
                    * (b.component(i, k) * b.component(j, l) + b.component(i, l) * b.component(j, k));
            }
        }
        c
    }

    fn max_wave_modulus(&self, b: &SymTensor, largest: f64, stress: &SymTensor) -> f64 {
        // max (c_AAAA + τ_A) / J of §3.9, without the reduction by compression.
        let square = 1.0 + largest;
        let tension = stress.greatest_principal_value().max(0.0);
        self.elasticity.p_wave_modulus() * square * square / jacobian(b) + tension
    }

    fn initial_energy(&self, b: &SymTensor) -> f64 {
        let (mu, lame) = (self.elasticity.shear_modulus, self.elasticity.lame());
        let trace = b.trace();
        0.125 * lame * trace * trace + 0.25 * mu * b.dot(b)
    }
}
