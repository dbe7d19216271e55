//! Stiffness of the skeleton for the equation of pore pressure.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::MaterialError;
use crate::contract::parameter_checks::{not_negative, positive};

/// Stiffness of the skeleton for the equation of pore pressure (Pastor et al. 2020, eq. 58; sheet: depth-sph §2.7).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SkeletonSpec {
    /// Young's modulus (Pa), positive.
    pub youngs_modulus: f64,
    /// Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Lateral confinement of a column.
    #[serde(default)]
    pub confinement: LateralConfinement,
}

/// Lateral confinement of a column: mean over vertical effective stress `α`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum LateralConfinement {
    /// Equal stress on the sides and the top: `α = 1`.
    Isotropic {},
    /// No lateral strain: `α = (1 + 2 k_0)/3`. With the elastic `k_0` the stiffness is the oedometric modulus. The
    /// default.
    OneDimensional {
        /// Coefficient of lateral stress, not negative; `ν/(1 - ν)` when absent.
        #[serde(default)]
        k0: Option<f64>,
    },
    /// Source formula `α = k_0`, as printed. The stiffness grows without bound as `k_0` vanishes.
    SourceK0 {
        /// Coefficient of lateral stress, > 0.
        k0: f64,
    },
    /// Value of `α`.
    Value {
        /// Ratio `α` (-), > 0.
        alpha: f64,
    },
}

impl Default for LateralConfinement {
    fn default() -> Self {
        Self::OneDimensional { k0: None }
    }
}

impl SkeletonSpec {
    /// Skeleton of a Young's modulus (Pa) and a Poisson's ratio, without lateral strain.
    #[must_use]
    pub fn new(youngs_modulus: f64, poissons_ratio: f64) -> Self {
        Self { youngs_modulus, poissons_ratio, confinement: LateralConfinement::default() }
    }

    /// Volumetric stiffness `K_v/α` (Pa), `K_v = E/(3(1 - 2ν))`.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn stiffness(&self) -> Result<f64, MaterialError> {
        let elasticity = crate::laws::Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        let alpha = match self.confinement {
            LateralConfinement::Isotropic {} => 1.0,
            LateralConfinement::OneDimensional { k0 } => {
                let k0 = k0.unwrap_or(self.poissons_ratio / (1.0 - self.poissons_ratio));
                not_negative("confinement.k0", k0, "")?;
                (1.0 + 2.0 * k0) / 3.0
            }
            LateralConfinement::SourceK0 { k0 } => {
                positive("confinement.k0", k0, "")?;
                k0
            }
            LateralConfinement::Value { alpha } => {
                positive("confinement.alpha", alpha, "")?;
                alpha
            }
        };
        Ok(elasticity.bulk_modulus / alpha)
    }
}
