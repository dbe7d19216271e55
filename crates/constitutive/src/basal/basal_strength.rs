//! Static shear strength of a base.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::basal::BasalFlow;

/// Basal strength: friction and cohesion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BasalStrength {
    /// Coefficient of friction `tan φ`.
    pub friction: f64,
    /// Cohesion `c` (Pa).
    pub cohesion: f64,
    /// Dependence of cohesion on the normal stress.
    pub form: CohesionForm,
    /// Constant pore-pressure ratio `r_u`: share of the normal stress carried by water.
    pub pore_pressure_ratio: f64,
}

/// Dependence of basal cohesion on normal stress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CohesionForm {
    /// Constant: `s = σ' tan φ + c`.
    #[default]
    Constant,
    /// Zero without normal stress (Bartelt et al. 2015, eq. 6; RAMMS): `s = σ' tan φ + (1 - tan φ) c (1 - e^(-σ'/c))`, for `tan φ` up to 1.
    Ramms,
}

impl BasalStrength {
    /// Strength of a frictionless base without cohesion.
    pub const ZERO: Self =
        Self { friction: 0.0, cohesion: 0.0, form: CohesionForm::Constant, pore_pressure_ratio: 0.0 };

    /// Effective normal stress on the base (Pa), compression-positive, never tensile.
    #[inline]
    pub fn effective_stress(&self, flow: &BasalFlow) -> f64 {
        ((1.0 - self.pore_pressure_ratio) * flow.normal_stress - flow.pore_pressure).max(0.0)
    }

    /// Shear strength (Pa) of the base under `flow`.
    #[inline]
    pub fn shear_strength(&self, flow: &BasalFlow) -> f64 {
        let stress = self.effective_stress(flow);
        let cohesion = match self.form {
            CohesionForm::Constant => self.cohesion,
            CohesionForm::Ramms if self.cohesion > 0.0 => {
                -(1.0 - self.friction) * self.cohesion * (-stress / self.cohesion).exp_m1()
            }
            CohesionForm::Ramms => 0.0,
        };
        stress * self.friction + cohesion
    }
}
