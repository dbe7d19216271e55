//! Bingham profile over a base: shear stress from mean speed, exactly and by the economised quadratic (sheet:
//! depth-sph §2.6.2), and the speed after an implicit step (§3.5).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::BasalFlow;

/// Solution of the cubic of the Bingham profile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BinghamSolution {
    /// Exact to round-off.
    #[default]
    Exact,
    /// Economised quadratic (Pastor et al. 2004): within -2.8 % to +5.2 %, the latter at rest.
    Quadratic,
}

/// Root `ζ = τ_y/τ_b` in (0, 1] of `ζ³ - (3 + a) ζ + 2 = 0`, `a >= 0`.
#[inline]
pub fn plug_ratio(a: f64) -> f64 {
    plug_root(a, 0.0, a).0
}

/// Root `ζ` in (0, 1] of `ζ³ - (3 + a) ζ + 2 + push = 0` with `held = a - push >= 0`, and `1 - ζ`. Each is accurate to round-off: at rest
/// the root is double, so that Newton's method solves for `1 - ζ`.
#[inline]
fn plug_root(a: f64, push: f64, held: f64) -> (f64, f64) {
    let mut gap = 2.0 * held / (a + (a * a + 12.0 * held).sqrt()).max(f64::MIN_POSITIVE);
    for _ in 0..6 {
        let slope = gap * (3.0 * gap - 6.0) - a;
        if slope < 0.0 {
            gap -= (gap * gap * (gap - 3.0) - a * gap + held) / slope;
        }
    }
    let mut zeta = 1.0 - gap;
    if zeta < 0.5 {
        for _ in 0..2 {
            zeta -= (zeta * zeta * zeta - (3.0 + a) * zeta + 2.0 + push) / (3.0 * zeta * zeta - (3.0 + a));
        }
    }
    (zeta.clamp(f64::MIN_POSITIVE, 1.0), gap)
}

/// Plug ratio `ζ` by the economised quadratic `3/2 ζ² - (57/16 + a) ζ + 65/32 = 0`.
#[inline]
pub fn plug_ratio_quadratic(a: f64) -> f64 {
    quadratic(57.0 / 16.0 + a, 65.0 / 32.0)
}

/// Smaller root of `3/2 ζ² - b ζ + c = 0`.
#[inline]
fn quadratic(b: f64, c: f64) -> f64 {
    2.0 * c / (b * (1.0 + (1.0 - 6.0 * c / b / b).max(0.0).sqrt()))
}

impl BinghamSolution {
    /// Ratio of the shear stress of a column at incipient motion to the yield stress.
    #[inline]
    pub(super) fn static_factor(self) -> f64 {
        match self {
            Self::Exact => 1.0,
            Self::Quadratic => 1.0 / plug_ratio_quadratic(0.0),
        }
    }

    /// Basal shear stress (Pa) at the mean shear rate `v̄/h` (1/s).
    #[inline]
    pub(super) fn shear_stress(self, yield_stress: f64, viscosity: f64, rate: f64) -> f64 {
        let a = 6.0 * viscosity * rate / yield_stress;
        if !a.is_finite() {
            return 3.0 * viscosity * rate;
        }
        match self {
            Self::Exact => yield_stress / plug_ratio(a),
            Self::Quadratic => yield_stress / plug_ratio_quadratic(a),
        }
    }

    /// Speed (m/s) after an implicit step in which the column does not stop. `held` is the speed minus the loss by the static stress. With
    /// `A = h τ_y/(6μ)` the speed of a plug ratio is `A a(ζ)`, so that `v₁ + k τ_y/ζ = v₀` is again a cubic (or quadratic) equation in `ζ`.
    #[inline]
    pub(super) fn speed_after_step(
        self,
        yield_stress: f64,
        viscosity: f64,
        flow: &BasalFlow,
        impulse: f64,
        held: f64,
    ) -> f64 {
        if viscosity == 0.0 {
            return held;
        }
        let push = 6.0 * viscosity * impulse / flow.depth;
        let scale = flow.depth * yield_stress / (6.0 * viscosity);
        let (speed, left) = (flow.speed / scale, held / scale);
        if !speed.is_finite() {
            return flow.speed / (1.0 + 0.5 * push);
        }
        let next = match self {
            Self::Exact => {
                let (zeta, gap) = plug_root(speed, push, left);
                gap * gap * (3.0 - gap) / zeta
            }
            Self::Quadratic => {
                let rest = plug_ratio_quadratic(0.0);
                let linear = 57.0 / 16.0 - 3.0 * rest;
                let (b, c) = (linear + speed, rest * left);
                let gap = 2.0 * c / (b + (b * b + 6.0 * c).sqrt());
                let zeta = quadratic(57.0 / 16.0 + speed, 65.0 / 32.0 + push);
                gap * (1.5 * gap + linear) / zeta
            }
        };
        (scale * next).clamp(0.0, held)
    }
}
