//! Acceleration-based viscous stress in addition to a frictional law (sheet: constitutive §2.12, AL2 eqs. 8–9,
//! 25–33: Wu, Wang & Alipour 2020).
//!
//! `T = T_i + T_v`: the frictional law gives `T_i`, and `T̊_v = η1 D̊ + η (T D̊ + D̊ T) + η3 D̊²` with `η = A √(m1 + m2 ‖D‖²)`, `A < 0`;
//! `η1` and `η3` are 0 where not given, as in the source's own model. As printed, with all objective terms, that rate has
//! no steady state. It is used in one of two ways:
//!
//! * `integrated`: the rate integrated at frozen `T` and fixed direction of `D`,
//!   `T_v = η1 D + Φ(‖D‖)(T D̂ + D̂ T)`. Objective and without memory; the equation `T = T_i + T_v` is linear
//!   in `T` and is solved in the principal axes of `D`, `T_ab = (T_i + η1 D)_ab / (1 - Φ (d_a + d_b))`. The term
//!   with `η3` depends on how fast `D` was reached and has no such integral.
//! * `rate-material`: differences of `D` over the step, no objective terms: the source's own simple
//!   shear. Not objective; element tests only.
//!
//! Limits: in directions of compression the factor grows without bound as `Φ (d_a + d_b)` goes to 1
//! (shear rates of some 300 1/s with the source's constants); it is kept below 10. Where `T_i` has
//! reached the floor of the frictional law only `T_v` follows the rate ("gas-like").

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::contract::parameter_checks::{check, not_negative, positive};
use crate::contract::tangent::numerical_tangent;
use crate::{
    InitialCondition, Law, MaterialError, Motion, Point, PointLaw, StressUpdate, SymTensor, Tangent,
};

/// Upper bound of the ratio of a total stress component to the rate-independent one, `T/T_i`.
const MAX_AMPLIFICATION: f64 = 10.0;

/// Integration of the viscous rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ViscousMode {
    /// Closed form at current rate: objective.
    #[default]
    Integrated,
    /// Differences of stretching: element tests only.
    RateMaterial,
}

/// Viscous stress with acceleration term.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AccelerationViscosity {
    /// Coefficient `A` (s), < 0.
    pub a: f64,
    /// Coefficient `m1` of viscosity `η = A √(m1 + m2 ‖D‖²)`, positive.
    pub m1: f64,
    /// Coefficient `m2` (s²), non-negative.
    #[serde(default)]
    pub m2: f64,
    /// Viscosity `η1` (Pa s) of `η1 D̊`, non-negative.
    #[serde(default)]
    pub eta1: f64,
    /// Coefficient `η3` (Pa s³) of `η3 D̊²`, normal stresses alone; `rate-material` only.
    #[serde(default)]
    pub eta3: f64,
    /// Integration of the viscous rate.
    #[serde(default)]
    pub mode: ViscousMode,
}

impl AccelerationViscosity {
    /// Viscosity of the coefficients `A` (s) and `m1` (-), all others zero.
    #[must_use]
    pub fn new(a: f64, m1: f64) -> Self {
        Self { a, m1, m2: 0.0, eta1: 0.0, eta3: 0.0, mode: ViscousMode::default() }
    }

    /// Coefficient `η = A √(m1 + m2 x²)` (s) at the stretching `x = ‖D‖` (1/s).
    #[inline]
    pub fn eta(&self, x: f64) -> f64 {
        self.a * (self.m1 + self.m2 * x * x).sqrt()
    }

    /// Integral `Φ(x) = ∫₀ˣ η`.
    #[inline]
    pub fn phi(&self, x: f64) -> f64 {
        let root = (self.m2 / self.m1).sqrt() * x;
        // `asinh(r)/r`, with the limit 1.
        let ratio = if root > 0.0 { root.asinh() / root } else { 1.0 };
        0.5 * x * (self.eta(x) + self.a * self.m1.sqrt() * ratio)
    }

    /// Total stress `T` with `T = T_i + η1 D + Φ (T D̂ + D̂ T)`.
    pub fn total(&self, inviscid: &SymTensor, stretching: &SymTensor) -> SymTensor {
        self.amplified(&(*inviscid + *stretching * self.eta1), stretching)
    }

    /// Stress `T` with `T = T_0 + Φ (T D̂ + D̂ T)`: linear in `T_0`.
    fn amplified(&self, inviscid: &SymTensor, stretching: &SymTensor) -> SymTensor {
        let rate = stretching.norm();
        if rate == 0.0 {
            return *inviscid;
        }
        let phi = self.phi(rate) / rate;
        let spectrum = stretching.spectrum();
        let axes = spectrum.rotation();
        let mut local = inviscid.rotated(&axes.transpose());
        for (k, &(a, b)) in crate::tensors::tensor::PAIRS.iter().enumerate() {
            let share = phi * (spectrum.values[a] + spectrum.values[b]);
            local[k] /= (1.0 - share).max(1.0 / MAX_AMPLIFICATION);
        }
        local.rotated(&axes)
    }

    /// Increment `η1 ΔD + η (T ΔD + ΔD T) + η3 ΔD²/Δt` of the viscous stress under the stress `T`. The stretching changes from `from` to
    /// `to` (1/s) in the time `dt` (s).
    pub fn increment(&self, stress: &SymTensor, from: &SymTensor, to: &SymTensor, dt: f64) -> SymTensor {
        let eta = self.eta(((*from + *to) * 0.5).norm());
        let change = (*to - *from).to_matrix();
        (stress.to_matrix() * change).sym() * (2.0 * eta)
            + change.sym() * self.eta1
            + (change * change).sym() * (self.eta3 / dt)
    }

    /// Checks signs and ranges of the viscosity parameters.
    fn validate(&self) -> Result<(), MaterialError> {
        check("viscous.a", self.a, self.a.is_finite() && self.a < 0.0, "must be negative (s)")?;
        positive("viscous.m1", self.m1, "")?;
        not_negative("viscous.m2", self.m2, "s²")?;
        not_negative("viscous.eta1", self.eta1, "Pa s")?;
        let fits = self.eta3 == 0.0 || (self.eta3.is_finite() && self.mode == ViscousMode::RateMaterial);
        check("viscous.eta3", self.eta3, fits, "needs mode rate-material (Pa s³)")
    }
}

/// Frictional law with an added viscous stress. See the module's head.
#[derive(Clone, Debug, PartialEq)]
pub struct AccelerationViscous<L> {
    frictional: L,
    viscosity: AccelerationViscosity,
}

/// State of a point: rate-independent and viscous parts of the stress.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViscousState<S> {
    /// Internal variables of the frictional law.
    pub frictional: S,
    /// Stress of the frictional law `T_i` (Pa).
    pub inviscid: SymTensor,
    /// Viscous stress `T_v` (Pa).
    pub viscous: SymTensor,
    /// Stretching of the last step (1/s).
    pub stretching: SymTensor,
}

impl<L: StressUpdate> AccelerationViscous<L> {
    /// Returns the law `frictional` with the added `viscosity`.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn new(frictional: L, viscosity: AccelerationViscosity) -> Result<Self, MaterialError> {
        viscosity.validate()?;
        Ok(Self { frictional, viscosity })
    }

    /// Point with the stress and state of the law without the viscous part.
    fn inviscid_point(point: &Point<ViscousState<L::State>>) -> Point<L::State> {
        Point { stress: point.state.inviscid, state: point.state.frictional.clone() }
    }
}

impl<L: StressUpdate> Law for AccelerationViscous<L> {
    fn name(&self) -> &'static str {
        self.frictional.name()
    }

    fn is_isotropic(&self) -> bool {
        self.frictional.is_isotropic()
    }

    fn stress_tolerance(&self) -> f64 {
        self.frictional.stress_tolerance()
    }

    fn is_time_dependent(&self) -> bool {
        true
    }

    fn output_names(&self) -> &[&'static str] {
        self.frictional.output_names()
    }
}

impl<L: StressUpdate> PointLaw for AccelerationViscous<L> {
    type State = ViscousState<L::State>;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<Self::State>, MaterialError> {
        let Point { stress, state } = self.frictional.initial(initial)?;
        let zero = SymTensor::ZERO;
        Ok(Point {
            stress,
            state: ViscousState { frictional: state, inviscid: stress, viscous: zero, stretching: zero },
        })
    }

    fn wave_modulus(&self, point: &Point<Self::State>) -> f64 {
        let phi = self.viscosity.phi(point.state.stretching.norm());
        let factor = (1.0 - 2.0 * phi.abs()).max(1.0 / MAX_AMPLIFICATION);
        self.frictional.wave_modulus(&Self::inviscid_point(point)) / factor
    }

    /// Effective viscosity (Pa s) at the current rate and pressure: `T_v ≈ 2 |η| p D` for a small change of `D`.
    fn viscosity(&self, point: &Point<Self::State>) -> f64 {
        let own = self.viscosity.eta(point.state.stretching.norm()).abs() * point.stress.pressure().abs();
        own + 0.5 * self.viscosity.eta1
    }

    fn outputs(&self, point: &Point<Self::State>, out: &mut [f64]) {
        self.frictional.outputs(&Self::inviscid_point(point), out);
    }
}

impl<L: StressUpdate> StressUpdate for AccelerationViscous<L> {
    fn update(&self, motion: &Motion, old: &Point<Self::State>) -> Result<Point<Self::State>, MaterialError> {
        let invalid = |reason| MaterialError::Motion { model: self.name(), reason };
        if !(motion.dt > 0.0) {
            return Err(invalid("the time step must be positive"));
        }
        let Point { stress: inviscid, state } = self.frictional.update(motion, &Self::inviscid_point(old))?;
        let stretching = motion.strain_increment() * (1.0 / motion.dt);
        let stress = match self.viscosity.mode {
            ViscousMode::Integrated => self.viscosity.total(&inviscid, &stretching),
            ViscousMode::RateMaterial => {
                // Stress of the middle of the step, by three sweeps.
                let mut stress = inviscid + old.state.viscous;
                for _ in 0..3 {
                    let middle = (old.stress + stress) * 0.5;
                    let change =
                        self.viscosity.increment(&middle, &old.state.stretching, &stretching, motion.dt);
                    stress = inviscid + old.state.viscous + change;
                }
                stress
            }
        };
        if !stress.is_finite() {
            return Err(invalid("the viscous stress is not finite"));
        }
        let state = ViscousState { frictional: state, inviscid, viscous: stress - inviscid, stretching };
        Ok(Point { stress, state })
    }

    /// Consistent tangent: the total stress is linear in the frictional one and a smooth function of the stretching.
    fn tangent(&self, motion: &Motion, old: &Point<Self::State>) -> Result<Tangent, MaterialError> {
        if self.viscosity.mode == ViscousMode::RateMaterial {
            return numerical_tangent(motion, |m| self.update(m, old).map(|p| p.stress));
        }
        let inner = Self::inviscid_point(old);
        let frictional = self.frictional.tangent(motion, &inner)?;
        let inviscid = self.frictional.update(motion, &inner)?.stress;
        let strain = motion.strain_increment();
        let total = |stress: &SymTensor, strain: &SymTensor| {
            self.viscosity.total(stress, &(*strain * (1.0 / motion.dt)))
        };
        let step = 1e-5 * strain.norm().max(1e-9);
        let mut tangent = Tangent::ZERO;
        for column in 0..6 {
            // Engineering shear: half in each of the two entries.
            let mut change = SymTensor::ZERO;
            change[column] = if column < 3 { step } else { 0.5 * step };
            let slope = total(&inviscid, &(strain + change)) - total(&inviscid, &(strain - change));
            let column_of = SymTensor(frictional.0.map(|row| row[column]));
            let carried = self.viscosity.amplified(&column_of, &(strain * (1.0 / motion.dt)));
            let stress = carried + slope * (0.5 / step);
            for (row, value) in tangent.0.iter_mut().zip(stress.0) {
                row[column] = value;
            }
        }
        Ok(tangent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MINIMAL: AccelerationViscosity = AccelerationViscosity {
        a: -8e-4,
        m1: 0.5,
        m2: 1e-3,
        eta1: 0.0,
        eta3: 0.0,
        mode: ViscousMode::Integrated,
    };

    /// Matrices of eq. 29: in simple shear the first term gives shear, the third normal stress alone.
    #[test]
    fn terms_of_the_rate_in_simple_shear() {
        let (lateral, normal, shear, g, dt) = (-80.0, -100.0, 30.0, 0.4, 0.01);
        let stress = SymTensor([lateral, normal, -70.0, shear, 0.0, 0.0]);
        let faster = SymTensor([0.0, 0.0, 0.0, g, 0.0, 0.0]);
        let of = |viscosity: AccelerationViscosity| {
            viscosity.increment(&stress, &SymTensor::ZERO, &faster, dt)
                - MINIMAL.increment(&stress, &SymTensor::ZERO, &faster, dt)
        };
        let direct = of(AccelerationViscosity { eta1: 7.0, ..MINIMAL });
        assert!((direct - SymTensor([0.0, 0.0, 0.0, 7.0 * g, 0.0, 0.0])).norm() < 1e-14);
        let squared = of(AccelerationViscosity { eta3: -5.0, ..MINIMAL });
        let exact = -5.0 * g * g / dt;
        assert!((squared - SymTensor::diagonal(exact, exact, 0.0)).norm() < 1e-12);
        let eta = MINIMAL.eta(0.5 * faster.norm());
        let second = MINIMAL.increment(&stress, &SymTensor::ZERO, &faster, dt) * (1.0 / eta);
        let exact = SymTensor([2.0 * shear * g, 2.0 * shear * g, 0.0, (lateral + normal) * g, 0.0, 0.0]);
        assert!((second - exact).norm() < 1e-12);
    }

    #[test]
    fn the_first_term_integrates_to_a_newtonian_viscosity() {
        let newtonian = AccelerationViscosity { a: -1e-300, eta1: 7.0, ..MINIMAL };
        let (inviscid, rate) = (SymTensor::isotropic(-10.0), SymTensor([0.1, -0.3, 0.2, 0.4, -0.1, 0.2]));
        assert!((newtonian.total(&inviscid, &rate) - (inviscid + rate * 7.0)).norm() < 1e-13);
        let refused = AccelerationViscosity { eta3: 1.0, ..MINIMAL }.validate().unwrap_err().to_string();
        assert!(refused.starts_with("viscous.eta3: 1"), "{refused}");
        assert!(
            AccelerationViscosity { eta3: 1.0, mode: ViscousMode::RateMaterial, ..MINIMAL }
                .validate()
                .is_ok()
        );
    }
}
