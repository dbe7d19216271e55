//! The fluid in the pores of a body (sheet: mpm §2.3).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::description::Velocity;
use crate::description::formula::Formula;

/// Independent fluid in a body's pores. The material is then the dry skeleton in effective stresses, its `density` that of grains times one
/// minus porosity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PoreFluid {
    /// Initial porosity, above 0, below 1.
    pub porosity: f64,
    /// Hydraulic conductivity under the case's gravity (m/s), or give `intrinsic_permeability`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub permeability: Option<f64>,
    /// Intrinsic permeability (m²), with `viscosity`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub intrinsic_permeability: Option<f64>,
    /// Fluid density (kg/m³).
    #[serde(default = "PoreFluid::water_density")]
    pub density: f64,
    /// Fluid bulk modulus (Pa).
    #[serde(default = "PoreFluid::water_bulk_modulus")]
    pub bulk_modulus: f64,
    /// Dynamic fluid viscosity (Pa s).
    #[serde(default = "PoreFluid::water_viscosity")]
    pub viscosity: f64,
    /// Initial pore pressure.
    #[serde(default)]
    pub pressure: PorePressure,
    /// Initial excess pressure at the base over full liquefaction, 0 to 1, for depth-integrated flow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub excess_ratio: Option<f64>,
    /// Initial fluid velocity (m/s); the body's by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Velocity>,
    /// Cavitation tension (Pa), non-negative; none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cavitation_strength: Option<f64>,
}

impl PoreFluid {
    /// Default density of the pore fluid: that of water (kg/m³).
    pub(crate) fn water_density() -> f64 {
        1000.0
    }

    /// At 10 °C with a trace of air, as in the scientific manual of Anura3D.
    pub(crate) fn water_bulk_modulus() -> f64 {
        2.15e9
    }

    /// Default viscosity of the pore fluid: that of water (Pa s).
    pub(crate) fn water_viscosity() -> f64 {
        1e-3
    }
}

/// Initial field of pore pressure.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum PorePressure {
    /// Zero pore pressure.
    #[default]
    None,
    /// Uniform pressure.
    Uniform {
        /// Pressure (Pa), compression-positive.
        value: f64,
    },
    /// Formula of the coordinates.
    Formula {
        /// Pressure (Pa), compression-positive.
        value: Formula,
    },
    /// Hydrostatic: weight of the fluid above.
    Hydrostatic {
        /// Fluid surface coordinate along gravity (m).
        surface: f64,
    },
}

impl PoreFluid {
    /// Drag force per volume and Darcy velocity, `ρ g / k` or viscosity over intrinsic permeability (Pa s/m²), under gravity of magnitude
    /// `gravity` (m/s²).
    pub fn resistance(&self, gravity: f64) -> f64 {
        match (self.permeability, self.intrinsic_permeability) {
            (Some(conductivity), _) => self.density * gravity / conductivity,
            (None, Some(permeability)) => self.viscosity / permeability,
            (None, None) => f64::NAN,
        }
    }

    /// Density of the saturated body (kg/m³) for a skeleton of the given dry density.
    pub fn saturated_density(&self, dry: f64) -> f64 {
        dry + self.porosity * self.density
    }

    /// Coordinate along the axis of gravity (m) of the surface of a hydrostatic pressure; `None` for other fields.
    pub fn surface(&self) -> Option<f64> {
        match self.pressure {
            PorePressure::Hydrostatic { surface } => Some(surface),
            PorePressure::None | PorePressure::Uniform { .. } | PorePressure::Formula { .. } => None,
        }
    }

    /// Initial pore pressure at `x` (Pa) under `gravity` (m/s²).
    pub fn pressure_at(&self, x: [f64; 3], gravity: [f64; 3]) -> f64 {
        match &self.pressure {
            PorePressure::None => 0.0,
            PorePressure::Uniform { value } => *value,
            PorePressure::Formula { value } => value.evaluate(x),
            PorePressure::Hydrostatic { surface } => {
                let Some(axis) = (0..3).find(|&axis| gravity[axis] != 0.0) else { return 0.0 };
                let depth = ((x[axis] - *surface) * gravity[axis].signum()).max(0.0);
                self.density * gravity[axis].abs() * depth
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fluid() -> PoreFluid {
        serde_json::from_str(r#"{ "porosity": 0.4, "permeability": 1e-3 }"#).unwrap()
    }

    #[test]
    fn both_permeabilities_give_the_same_drag() {
        let hydraulic = fluid();
        assert!((hydraulic.resistance(9.81) - 9.81e6).abs() < 1e-6);
        let permeability = Some(1e-3 * 1e-3 / (1000.0 * 9.81));
        let intrinsic = PoreFluid { permeability: None, intrinsic_permeability: permeability, ..hydraulic };
        assert!((intrinsic.resistance(0.0) - 9.81e6).abs() < 1e-6);
    }

    #[test]
    fn hydrostatic_pressure_grows_along_gravity_from_the_surface() {
        let fluid = PoreFluid { pressure: PorePressure::Hydrostatic { surface: 2.0 }, ..fluid() };
        assert_eq!(fluid.pressure_at([0.0, 1.5, 0.0], [0.0, -10.0, 0.0]), 5e3);
        assert_eq!(fluid.pressure_at([0.0, 2.5, 0.0], [0.0, -10.0, 0.0]), 0.0);
        assert_eq!(fluid.saturated_density(1590.0), 1990.0);
    }
}
