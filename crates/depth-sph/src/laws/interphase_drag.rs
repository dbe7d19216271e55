//! Drag between grains and pore fluid, `R = C_d (v_w - v_s)` per unit of total volume (sheet: depth-sph §2.4).

use colluvium_constitutive::MaybeInfinite;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Bounds of the porosity in drag and permeability.
const POROSITIES: (f64, f64) = (1e-3, 1.0 - 1e-3);

/// Drag between grains and pore fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "law", rename_all = "kebab-case", deny_unknown_fields)]
pub enum InterphaseDrag {
    /// No drag.
    #[default]
    None,
    /// Anderson and Jackson, Pitman and Le: `C_d = n (1 - n) (ρ_s - ρ_w) g / (V_T n^m)`.
    Anderson {
        /// Settling velocity `V_T` of a grain (m/s), positive; `"none"` for no drag.
        settling_velocity: MaybeInfinite,
        /// Exponent `m`, 0 to 10: that of Richardson and Zaki less one.
        #[serde(default = "default_exponent")]
        exponent: f64,
    },
    /// Darcy: `C_d = n² ρ_w g / K`.
    Darcy {
        /// Hydraulic conductivity `K` (m/s), positive.
        permeability: f64,
    },
    /// Kozeny and Carman: Darcy's law with `k_w = d² n³ / (180 μ_w (1 - n)²)`.
    KozenyCarman {
        /// Median grain diameter `d` (m), positive.
        diameter: f64,
        /// Fluid viscosity `μ_w` (Pa s), positive.
        viscosity: f64,
    },
    /// Ergun: `C_d = 150 μ_w (1 - n)²/(n d²) + 1.75 ρ_w (1 - n) |u| / d`.
    Ergun {
        /// Grain diameter `d` (m), positive.
        diameter: f64,
        /// Fluid viscosity `μ_w` (Pa s), positive.
        viscosity: f64,
    },
}

/// Default exponent of the drag law (-).
const fn default_exponent() -> f64 {
    1.0
}

/// Densities of the components of a mixture, and gravity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MixtureDensities {
    /// Density of the grains, `ρ_s` (kg/m³).
    pub grain: f64,
    /// Density of the fluid, `ρ_w` (kg/m³).
    pub fluid: f64,
    /// Gravity (m/s²).
    pub gravity: f64,
}

impl MixtureDensities {
    /// Density of the mixture at porosity `n` (kg/m³).
    #[inline]
    pub fn mixture(&self, n: f64) -> f64 {
        (1.0 - n) * self.grain + n * self.fluid
    }

    /// Submerged density `ρ' = (1 - n)(ρ_s - ρ_w)` (kg/m³).
    #[inline]
    pub fn submerged_density(&self, n: f64) -> f64 {
        (1.0 - n) * (self.grain - self.fluid)
    }
}

impl InterphaseDrag {
    /// Checks the parameters.
    ///
    /// # Errors
    /// The name of the first parameter that is out of range, and the reason.
    pub fn validate(&self) -> Result<(), (&'static str, String)> {
        let positive = |name: &'static str, value: f64, unit: &str| {
            let holds = value > 0.0 && value.is_finite();
            if holds { Ok(()) } else { Err((name, format!("{value} must be positive ({unit})"))) }
        };
        match *self {
            Self::None => Ok(()),
            Self::Anderson { settling_velocity, exponent } => {
                if let MaybeInfinite::Number(velocity) = settling_velocity {
                    positive("settling_velocity", velocity, "m/s")?;
                }
                let problem = || ("exponent", format!("{exponent} is not in 0..=10"));
                if (0.0..=10.0).contains(&exponent) { Ok(()) } else { Err(problem()) }
            }
            Self::Darcy { permeability } => positive("permeability", permeability, "m/s"),
            Self::KozenyCarman { diameter, viscosity } | Self::Ergun { diameter, viscosity } => {
                positive("diameter", diameter, "m")?;
                positive("viscosity", viscosity, "Pa s")
            }
        }
    }

    /// Whether the coefficient depends on the relative speed.
    pub fn depends_on_slip(&self) -> bool {
        matches!(self, Self::Ergun { .. })
    }

    /// Drag coefficient `C_d` (kg m⁻³ s⁻¹) at porosity `n` and a relative speed (m/s).
    #[inline]
    pub fn coefficient(&self, n: f64, slip: f64, densities: &MixtureDensities) -> f64 {
        let n = n.clamp(POROSITIES.0, POROSITIES.1);
        let MixtureDensities { grain, fluid, gravity } = *densities;
        match *self {
            Self::None => 0.0,
            Self::Anderson { settling_velocity, exponent } => {
                n * (1.0 - n) * (grain - fluid) * gravity
                    / (settling_velocity.or_infinity() * n.powf(exponent))
            }
            Self::Darcy { permeability } => n * n * fluid * gravity / permeability,
            Self::KozenyCarman { diameter, viscosity } => {
                180.0 * viscosity * (1.0 - n).powi(2) / (n * diameter * diameter)
            }
            Self::Ergun { diameter, viscosity } => {
                150.0 * viscosity * (1.0 - n).powi(2) / (n * diameter * diameter)
                    + 1.75 * fluid * (1.0 - n) * slip / diameter
            }
        }
    }

    /// Permeability `k_w = n²/C_d` (m³ s/kg) at porosity `n` of fluid with little relative velocity; infinite without drag.
    pub fn permeability(&self, n: f64, densities: &MixtureDensities) -> f64 {
        let n = n.clamp(POROSITIES.0, POROSITIES.1);
        n * n / self.coefficient(n, 0.0, densities)
    }

    /// Rate `β` (1/s) at which a relative velocity relaxes at porosity `n`.
    #[inline]
    pub fn relaxation(&self, n: f64, slip: f64, densities: &MixtureDensities) -> f64 {
        let n = n.clamp(POROSITIES.0, POROSITIES.1);
        let inertia = 1.0 / ((1.0 - n) * densities.grain) + 1.0 / (n * densities.fluid);
        self.coefficient(n, slip, densities) * inertia
    }
}

/// Relaxation of slip by drag within a step of `β Δt`: share `f` of the initial slip that is lost, and share `f̄` of the slip that remains
/// of the change by the forces (sheet: depth-sph §3.4, as amended).
#[inline]
pub fn relaxation_shares(beta_dt: f64) -> (f64, f64) {
    if beta_dt <= 0.0 {
        return (0.0, 0.0);
    }
    let old = -(-beta_dt).exp_m1();
    // For small steps `1 - f/x` loses its digits: x/2 - x²/6 + x³/24.
    let new = if beta_dt < 1e-3 {
        beta_dt * (0.5 - beta_dt * (1.0 / 6.0 - beta_dt / 24.0))
    } else {
        1.0 - old / beta_dt
    };
    (old, new)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHEET: MixtureDensities = MixtureDensities { grain: 2500.0, fluid: 1000.0, gravity: 9.81 };

    #[test]
    fn drag_is_that_of_the_sheet() {
        let drag = InterphaseDrag::Anderson { settling_velocity: 1e-3.into(), exponent: 1.0 };
        assert!((drag.coefficient(0.3, 0.0, &SHEET) / 1.030_05e7 - 1.0).abs() < 1e-6);
        assert!((drag.permeability(0.3, &SHEET) / 8.7374e-9 - 1.0).abs() < 1e-5);
        assert!((drag.relaxation(0.3, 0.0, &SHEET) / 4.0221e4 - 1.0).abs() < 1e-5);
        let conductivity = drag.permeability(0.3, &SHEET) * 1000.0 * 9.81;
        let darcy = InterphaseDrag::Darcy { permeability: conductivity };
        assert!((darcy.coefficient(0.3, 0.0, &SHEET) / 1.030_05e7 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn laminar_ergun_is_five_sixths_of_kozeny_carman() {
        let (diameter, viscosity) = (2e-3, 1e-3);
        let ergun = InterphaseDrag::Ergun { diameter, viscosity }.coefficient(0.4, 0.0, &SHEET);
        let kozeny = InterphaseDrag::KozenyCarman { diameter, viscosity }.coefficient(0.4, 0.0, &SHEET);
        assert!((ergun / kozeny - 150.0 / 180.0).abs() < 1e-12);
    }

    /// V15: one solid and one fluid parcel; any step gives the exact result.
    #[test]
    fn slip_relaxes_as_the_closed_form() {
        let drag = InterphaseDrag::Anderson { settling_velocity: 0.1.into(), exponent: 1.0 };
        let beta = drag.relaxation(0.3, 1.0, &SHEET);
        assert!((beta - 402.21).abs() < 5e-3, "{beta}");
        let (solid, fluid) = (0.7 * 2500.0, 0.3 * 1000.0);
        for (time, exact) in [(1e-3, [0.048_462, 0.717_303]), (10e-3, [0.143_720, 0.161_635])] {
            for steps in [1, 7] {
                let (mut v, mut w) = (0.0, 1.0);
                for _ in 0..steps {
                    let (f, _) = relaxation_shares(beta * time / f64::from(steps));
                    let u = w - v;
                    v += fluid / (solid + fluid) * f * u;
                    w -= solid / (solid + fluid) * f * u;
                }
                assert!((v - exact[0]).abs() < 5e-7 && (w - exact[1]).abs() < 5e-7, "{v} {w}");
                let momentum: f64 = solid * v + fluid * w;
                assert!((momentum / fluid - 1.0).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn forces_of_a_step_relax_by_their_own_share() {
        // u' = a - β u from u₀ over Δt.
        for x in [1e-6, 1e-3, 0.1, 3.0, 400.0] {
            let (f, mean) = relaxation_shares(x);
            let exact = (1.0 - (-x).exp()) / x;
            assert!((1.0 - mean - exact).abs() < 1e-9, "{x}: {mean}");
            assert!((f - (1.0 - (-x).exp())).abs() < 1e-12);
        }
    }

    #[test]
    fn wrong_parameters_are_named() {
        let free = InterphaseDrag::Anderson { settling_velocity: MaybeInfinite::INFINITE, exponent: 1.0 };
        assert!(free.validate().is_ok() && free.coefficient(0.4, 1.0, &SHEET) == 0.0);
        let wrong = InterphaseDrag::Anderson { settling_velocity: (-1.0).into(), exponent: 1.0 };
        assert_eq!(wrong.validate().unwrap_err().0, "settling_velocity");
        let wrong = InterphaseDrag::Anderson { settling_velocity: 1.0.into(), exponent: 11.0 };
        assert_eq!(wrong.validate().unwrap_err().0, "exponent");
    }
}
