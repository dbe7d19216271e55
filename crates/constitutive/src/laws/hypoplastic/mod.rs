//! Hypoplasticity with critical state (sheet: constitutive §2.12, §3.7.10; Wu, Wang & Alipour 2020,
//! eqs. 10–23).
//!
//! `T̊ = C1 tr(T) D + C2 tr(T D)/tr(T) T + f_d (C3 T² + C4 T*²)/tr(T) ‖D‖` with the Jaumann rate and the
//! deviator `T*`: stress follows from strain by one nonlinear equation, without yield surface, elastic
//! range or split of strain. The density function `f_d = (a - 1) D_c + 1`, `D_c = (e_c - e)/(e_c - e_min)`,
//! gives dense soil a peak and every density the critical void ratio `e_c = p1 + p2 exp(p3 |tr T|)` in the end;
//! `a = q1 + q2 exp(q3 |tr T|)`. Void ratio follows from the strain, `1 + e = (1 + e₀) exp(tr ε)`.
//! Integrated by the modified Euler method with local error control.
//!
//! The four constants are given directly or by calibration on an isotropic and a critical state. The
//! calibration is degenerate for small friction angles: there a path stalls at a spurious stationary
//! state before it reaches failure. Such sets are rejected; given directly they raise a warning.
//! Limits: no memory but stress and void ratio (ratcheting in small cycles); stiff under very large
//! compression; the stress-free state is a floor at `minimum_pressure`. The viscous option adds the
//! acceleration-based viscous part.

mod integration;
mod parameters;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::pressure_elastic::VoidRatio;
use crate::contract::parameter_checks::{check, not_negative};
use crate::{InitialCondition, Law, MaterialError, Motion, Point, PointLaw, SmallStrain, SymTensor, Tangent};

pub use parameters::{Calibration, HypoplasticParameters, HypoplasticSpec};

/// Value of the key `model` in case files.
const NAME: &str = "hypoplastic";

/// Dimensionless constants of the rate equation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HypoplasticConstants {
    /// Constant `C1`, < 0: stiffness.
    pub c1: f64,
    /// Constant `C2`.
    pub c2: f64,
    /// Constant `C3`.
    pub c3: f64,
    /// Constant `C4`.
    pub c4: f64,
}

/// Critical state and density function, of `|tr T| = 3p`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CriticalState {
    /// Smallest void ratio `e_min`, non-negative.
    pub minimum_void_ratio: f64,
    /// Critical void ratio at infinite pressure (for `p3 < 0`).
    pub p1: f64,
    /// Critical void ratio without pressure, minus `p1`.
    pub p2: f64,
    /// Constant `p3` (1/Pa), at most 0.
    pub p3: f64,
    /// Constant `q1`.
    pub q1: f64,
    /// Constant `q2`.
    pub q2: f64,
    /// Constant `q3` (1/Pa), at most 0.
    pub q3: f64,
}

impl CriticalState {
    /// Critical void ratio at `|tr T|` (Pa).
    #[inline]
    pub fn critical_void_ratio(&self, trace: f64) -> f64 {
        self.p1 + self.p2 * (self.p3 * trace.abs()).exp()
    }

    /// Change of `f_d` with changes of `tr T` (Pa) and void ratio.
    fn density_change(&self, trace: f64, void_ratio: f64, (by_trace, by_void): (f64, f64)) -> f64 {
        let critical = self.critical_void_ratio(trace);
        let (distance, range) = (critical - void_ratio, critical - self.minimum_void_ratio);
        let grown = trace.signum() * by_trace;
        let lowered = self.p3 * (critical - self.p1) * grown;
        let a = self.q1 + self.q2 * (self.q3 * trace.abs()).exp();
        let (density, change) = if distance.abs() < range {
            (distance / range, (lowered - by_void) / range - distance * lowered / (range * range))
        } else {
            (distance.signum(), 0.0)
        };
        self.q3 * (a - self.q1) * grown * density + (a - 1.0) * change
    }

    /// Density function `f_d` (eqs. 19–22) at `tr T` (Pa) and void ratio `e`. `D_c` is limited to -1 to 1, because no soil is denser than
    /// `e_min`.
    #[inline]
    pub fn density_function(&self, trace: f64, void_ratio: f64) -> f64 {
        let critical = self.critical_void_ratio(trace);
        let (distance, range) = (critical - void_ratio, critical - self.minimum_void_ratio);
        let density = if distance.abs() < range { distance / range } else { distance.signum() };
        let a = self.q1 + self.q2 * (self.q3 * trace.abs()).exp();
        (a - 1.0) * density + 1.0
    }

    /// Checks the parameters of the critical void ratio.
    fn validate(&self) -> Result<(), MaterialError> {
        not_negative("critical_state.minimum_void_ratio", self.minimum_void_ratio, "")?;
        for (name, value) in [("critical_state.p3", self.p3), ("critical_state.q3", self.q3)] {
            check(name, value, value.is_finite() && value <= 0.0, "must be at most 0 (1/Pa)")?;
        }
        for (name, value) in [
            ("critical_state.p1", self.p1),
            ("critical_state.p2", self.p2),
            ("critical_state.q1", self.q1),
            ("critical_state.q2", self.q2),
        ] {
            check(name, value, value.is_finite(), "must be finite")?;
        }
        self.range_at(0.0)
    }

    /// Requires that the critical void ratio at a stress trace (Pa) is above the minimum void ratio.
    fn range_at(&self, trace: f64) -> Result<(), MaterialError> {
        let critical = self.critical_void_ratio(trace);
        let rule = format!("is not below the critical void ratio, {critical}");
        let smallest = self.minimum_void_ratio;
        check("critical_state.minimum_void_ratio", smallest, smallest < critical, &rule)
    }
}

/// Stationary state of triaxial compression: constant stress under continued strain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StationaryState {
    /// Ratio `R` of axial to lateral stress.
    pub stress_ratio: f64,
    /// Dilatancy angle (rad), `tan ψ = 2ν - 1`.
    pub dilatancy_angle: f64,
}

/// Square `t²` of a tensor.
#[inline]
fn squared(t: &SymTensor) -> SymTensor {
    let [xx, yy, zz, xy, yz, zx] = t.0;
    SymTensor([
        xx * xx + xy * xy + zx * zx,
        xy * xy + yy * yy + yz * yz,
        zx * zx + yz * yz + zz * zz,
        xx * xy + xy * yy + zx * yz,
        xy * zx + yy * yz + yz * zz,
        xx * zx + xy * yz + zx * zz,
    ])
}

/// Anticommutator `a b + b a`.
fn anticommutator(a: &SymTensor, b: &SymTensor) -> SymTensor {
    (a.to_matrix() * b.to_matrix()).sym() * 2.0
}

impl HypoplasticConstants {
    /// Table 1 of Wu, Wang & Alipour 2020 as printed. The calibration behind it (φ = 15°) is degenerate:
    /// it has three stationary states and stalls at the first.
    pub const TABLE_1: Self = Self { c1: -1.70, c2: -283.4, c3: -283.4, c4: 2419.3 };

    /// All stationary states of triaxial compression with `f_d = 1`, the lowest stress ratio first. They
    /// are the points of the failure surface on the triaxial axis, at which `D = -𝓛⁻¹N ‖D‖`.
    pub fn stationary_states(&self) -> Vec<StationaryState> {
        /// Number of intervals of the searched range of stress ratios.
        const COUNT: u32 = 8000;
        /// Largest stress ratio that is searched (-).
        const LARGEST: f64 = 1e3;
        let flow = |ratio: f64| self.failure_flow(&SymTensor::diagonal(-ratio, -1.0, -1.0), 1.0);
        let excess = |ratio: f64| flow(ratio).norm() - 1.0;
        let ratio = |i: u32| LARGEST.powf(f64::from(i) / f64::from(COUNT));
        let mut states = Vec::new();
        for i in 0..COUNT {
            let (mut low, mut high) = (ratio(i), ratio(i + 1));
            let below = excess(low) < 0.0;
            if below == (excess(high) < 0.0) {
                continue;
            }
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                if (excess(middle) < 0.0) == below {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let direction = flow(low);
            if direction[0] < 0.0 && excess(low).abs() < 1e-6 {
                let expansion = -direction[1] / direction[0];
                let dilatancy_angle = (2.0 * expansion - 1.0).atan();
                states.push(StationaryState { stress_ratio: low, dilatancy_angle });
            }
        }
        states
    }

    /// Strain rate that keeps the stress constant, `-𝓛⁻¹ N`, per unit of the norm of the strain rate. Its norm is 1 on the failure surface
    /// (eq. 14) and below 1 inside.
    pub fn failure_flow(&self, stress: &SymTensor, density_function: f64) -> SymTensor {
        let trace = stress.trace();
        let (alpha, beta) = (self.c1 * trace, self.c2 / trace);
        let n = self.nonlinear(stress, density_function);
        let projected = beta * stress.dot(&n) / (alpha + beta * stress.dot(stress));
        (*stress * projected - n) * (1.0 / alpha)
    }

    /// Nonlinear part of the rate per norm of the strain increment, terms with `c3` and `c4` (Pa).
    #[inline]
    fn nonlinear(&self, stress: &SymTensor, density_function: f64) -> SymTensor {
        let factor = density_function / stress.trace();
        squared(stress) * (self.c3 * factor) + squared(&stress.deviator()) * (self.c4 * factor)
    }

    /// Change of [`HypoplasticConstants::rate`] due to changes of stress, stretching and density function.
    fn rate_change(
        &self,
        (stress, d, density_function): (&SymTensor, &SymTensor, f64),
        (by_stress, by_d, by_density): (&SymTensor, &SymTensor, f64),
    ) -> SymTensor {
        let (trace, by_trace) = (stress.trace(), by_stress.trace());
        let (norm, projection) = (d.norm(), stress.dot(d));
        let linear = *d * (self.c1 * by_trace)
            + *by_d * (self.c1 * trace)
            + *stress
                * (self.c2 / trace * (by_stress.dot(d) + stress.dot(by_d) - projection * by_trace / trace))
            + *by_stress * (self.c2 * projection / trace);
        let unit = self.nonlinear(stress, 1.0);
        let turned = anticommutator(stress, by_stress) * (self.c3 / trace)
            + anticommutator(&stress.deviator(), &by_stress.deviator()) * (self.c4 / trace)
            - unit * (by_trace / trace);
        linear
            + turned * (density_function * norm)
            + unit * (by_density * norm + density_function * d.dot(by_d) / norm)
    }

    /// Co-rotational stress rate (Pa/s) at `stress` (Pa) and stretching `d` (1/s), eqs. 15 and 23.
    #[inline]
    pub fn rate(&self, stress: &SymTensor, d: &SymTensor, density_function: f64) -> SymTensor {
        let trace = stress.trace();
        *d * (self.c1 * trace)
            + *stress * (self.c2 * stress.dot(d) / trace)
            + self.nonlinear(stress, density_function) * d.norm()
    }
}

/// Hypoplastic frictional law. See the module's head for source and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Hypoplastic {
    constants: HypoplasticConstants,
    critical_state: Option<CriticalState>,
    void_ratio: f64,
    minimum_pressure: f64,
}

impl Hypoplastic {
    /// Constants of the law, calibrated or given by the case.
    pub fn constants(&self) -> &HypoplasticConstants {
        &self.constants
    }

    /// Density function `f_d` at `stress` (Pa) and void ratio.
    #[inline]
    pub fn density_function(&self, stress: &SymTensor, void_ratio: f64) -> f64 {
        self.critical_state.as_ref().map_or(1.0, |c| c.density_function(stress.trace(), void_ratio))
    }

    /// Stress increment of a strain increment at a stress (Pa) and void ratio.
    #[inline]
    fn slope(&self, stress: &SymTensor, void_ratio: f64, strain: &SymTensor) -> SymTensor {
        self.constants.rate(stress, strain, self.density_function(stress, void_ratio))
    }
}

impl Law for Hypoplastic {
    fn name(&self) -> &'static str {
        NAME
    }

    fn output_names(&self) -> &[&'static str] {
        &["void_ratio", "failure"]
    }
}

impl PointLaw for Hypoplastic {
    type State = VoidRatio;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<VoidRatio>, MaterialError> {
        let trace = initial.stress.trace();
        if !(initial.stress.is_finite() && trace < 0.0) {
            let reason = format!("the mean stress must be compressive, tr σ = {trace} Pa");
            return Err(MaterialError::Initial { model: NAME, reason });
        }
        if let Some(critical) = &self.critical_state {
            critical.range_at(trace)?;
        }
        Ok(Point { stress: initial.stress, state: VoidRatio { void_ratio: self.void_ratio } })
    }

    fn wave_modulus(&self, point: &Point<VoidRatio>) -> f64 {
        // Norm inequality on the rate equation.
        let stress = &point.stress;
        let HypoplasticConstants { c1, c2, c3, c4 } = self.constants;
        let density = self.density_function(stress, point.state.void_ratio).abs();
        let trace = stress.trace().abs().max(3.0 * self.minimum_pressure);
        let deviator = stress.deviator();
        trace * c1.abs()
            + stress.dot(stress) / trace * (c2.abs() + density * c3.abs())
            + deviator.dot(&deviator) / trace * density * c4.abs()
    }

    fn outputs(&self, point: &Point<VoidRatio>, out: &mut [f64]) {
        let void_ratio = point.state.void_ratio;
        out[0] = void_ratio;
        // 1 on the failure surface.
        out[1] = self
            .constants
            .failure_flow(&point.stress, self.density_function(&point.stress, void_ratio))
            .norm();
    }
}

impl SmallStrain for Hypoplastic {
    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<VoidRatio>,
    ) -> Result<Point<VoidRatio>, MaterialError> {
        if strain.norm() == 0.0 {
            return Ok(*old);
        }
        Ok(self.integrate(strain, old)?.point)
    }

    /// Tangent of the substeps of the update with their number fixed: exact between the strains at which that
    /// number changes.
    fn tangent(&self, strain: &SymTensor, _motion: &Motion, old: &Point<VoidRatio>) -> Option<Tangent> {
        self.substepped_tangent(strain, old)
    }

    fn max_strain_increment(&self) -> f64 {
        f64::INFINITY
    }
}
