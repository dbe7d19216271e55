//! Hypoplasticity with critical state (constitutive sheet §2.12, §3.7.10; Wu, Wang & Alipour 2020,
//! eqs. 10–23).
//!
//! `T̊ = C1 tr(T) D + C2 tr(T D)/tr(T) T + f_d (C3 T² + C4 T*²)/tr(T) ‖D‖` with the Jaumann rate and the
//! deviator `T*`: stress follows strain by one nonlinear equation, without yield surface, elastic
//! range or split of strain. The density function `f_d = (a - 1) D_c + 1`, `D_c = (e_c - e)/(e_c - e_min)`,
//! lets dense soil peak and every density end at the critical void ratio `e_c = p1 + p2 exp(p3 |tr T|)`;
//! `a = q1 + q2 exp(q3 |tr T|)`. Void ratio follows the strain, `1 + e = (1 + e₀) exp(tr ε)`.
//! Integrated by the modified Euler method with local error control.
//!
//! The four constants are given directly or by calibration on an isotropic and a critical state. The
//! calibration is degenerate for small friction angles: there a path stalls at a spurious stationary
//! state before it reaches failure. Such sets are refused; given directly they raise a warning.
//! Limits: no memory but stress and void ratio (ratcheting in small cycles); stiff under very large
//! compression; the stress-free state is a floor at `minimum_pressure`. [`Viscous`] adds the
//! acceleration-based viscous part.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::acceleration_viscous::{AccelerationViscosity, Viscous, ViscousMode};
use super::pressure_elastic::VoidRatio;
use super::substep::{Advance, substepped};
use crate::model::{Facts, Kind, Model, check, not_negative, positive};
use crate::{Corotational, InitialCondition, Material, MaterialError, Motion, Point, SmallStrain, SymTensor};

const NAME: &str = "hypoplastic";

/// Largest strain increment that is integrated in one piece (sheet §3.8).
const PIECE: f64 = 1e-2;
/// Local error of a substep, relative to the stress (sheet §3.7.10).
const TOLERANCE: f64 = 1e-4;
/// Doublings of the number of substeps of a piece, to 1024 (1000 in the sheet).
const DOUBLINGS: u32 = 10;

/// Parameters of `hypoplastic`, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HypoplasticSpec {
    /// Density (kg/m³), > 0.
    pub density: f64,
    /// Void ratio at the start, > 0.
    pub void_ratio: f64,
    /// The four constants, or what they are calibrated on.
    pub parameters: HypoplasticParameters,
    /// Critical state; without it density has no influence (`f_d = 1`).
    #[serde(default)]
    pub critical_state: Option<CriticalState>,
    /// Mean pressure below which the skeleton counts as free of stress (Pa), > 0.
    #[serde(default = "minimum_pressure")]
    pub minimum_pressure: f64,
    /// Viscous stress driven by the acceleration of strain; none when absent.
    #[serde(default)]
    pub viscous: Option<AccelerationViscosity>,
}

fn minimum_pressure() -> f64 {
    10.0
}

/// Where the four constants come from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum HypoplasticParameters {
    /// Given directly; a set with spurious stationary states raises a warning only.
    Constants(Constants),
    /// By calibration; a set with spurious stationary states is refused.
    Calibration(Calibration),
}

/// The dimensionless constants of the rate equation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Constants {
    /// `C1`, < 0: stiffness.
    pub c1: f64,
    /// `C2`.
    pub c2: f64,
    /// `C3`.
    pub c3: f64,
    /// `C4`.
    pub c4: f64,
}

/// Two states the constants are calibrated on, angles in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Young's modulus at the start of triaxial compression from the isotropic state (Pa), > 0.
    pub youngs_modulus: f64,
    /// Pressure of that state (Pa), > 0.
    pub pressure: f64,
    /// Poisson's ratio of that state, 0 to 0.5.
    #[serde(default)]
    pub poissons_ratio: f64,
    /// Critical friction angle (degrees), between 0 and 90.
    pub friction_angle: f64,
    /// Dilatancy angle at failure (degrees), `tan ψ = 2ν - 1` with the ratio ν of lateral expansion to
    /// axial compression; between -45 and 45.
    #[serde(default)]
    pub dilatancy_angle: f64,
}

/// Critical-state line and density function; pressures enter as `|tr T| = 3p`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CriticalState {
    /// Smallest void ratio `e_min`, not negative.
    pub minimum_void_ratio: f64,
    /// `p1`: critical void ratio at infinite pressure (for `p3 < 0`).
    pub p1: f64,
    /// `p2`: critical void ratio without pressure, less `p1`.
    pub p2: f64,
    /// `p3` (1/Pa), at most 0.
    pub p3: f64,
    /// `q1`.
    pub q1: f64,
    /// `q2`.
    pub q2: f64,
    /// `q3` (1/Pa), at most 0.
    pub q3: f64,
}

impl CriticalState {
    /// Critical void ratio at `|tr T|` (Pa).
    #[inline]
    pub fn critical_void_ratio(&self, trace: f64) -> f64 {
        self.p1 + self.p2 * (self.p3 * trace.abs()).exp()
    }

    /// Density function `f_d` (eqs. 19–22) at `tr T` (Pa) and void ratio `e`. `D_c` is kept between -1 and
    /// 1: no soil is denser than `e_min`, and where the critical line has come down to `e_min` the
    /// quotient has lost its meaning.
    #[inline]
    pub fn density_function(&self, trace: f64, void_ratio: f64) -> f64 {
        let critical = self.critical_void_ratio(trace);
        let (distance, range) = (critical - void_ratio, critical - self.minimum_void_ratio);
        let density = if distance.abs() < range { distance / range } else { distance.signum() };
        let a = self.q1 + self.q2 * (self.q3 * trace.abs()).exp();
        (a - 1.0) * density + 1.0
    }

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

    fn range_at(&self, trace: f64) -> Result<(), MaterialError> {
        let critical = self.critical_void_ratio(trace);
        let rule = format!("is not below the critical void ratio, {critical}");
        let smallest = self.minimum_void_ratio;
        check("critical_state.minimum_void_ratio", smallest, smallest < critical, &rule)
    }
}

/// A state of triaxial compression in which stress stays while strain goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StationaryState {
    /// Ratio `R` of axial to lateral stress.
    pub stress_ratio: f64,
    /// Dilatancy angle (rad), `tan ψ = 2ν - 1`.
    pub dilatancy_angle: f64,
}

/// `t²`.
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

impl Constants {
    /// Table 1 of Wu, Wang & Alipour 2020 as printed. The calibration behind it (φ = 15°) is degenerate:
    /// it has three stationary states and stalls at the first.
    pub const TABLE_1: Self = Self { c1: -1.70, c2: -283.4, c3: -283.4, c4: 2419.3 };

    /// The constants of an isotropic state (initial stiffness, no change of lateral stress at the given
    /// Poisson's ratio) and of a stationary state in triaxial compression (eqs. 16–18).
    ///
    /// # Errors
    /// A parameter out of range, or a friction angle for which a loading path stalls before failure.
    pub fn calibrate(calibration: &Calibration) -> Result<Self, MaterialError> {
        let Calibration { youngs_modulus, pressure, poissons_ratio, friction_angle, dilatancy_angle } =
            *calibration;
        positive("parameters.calibration.youngs_modulus", youngs_modulus, "Pa")?;
        positive("parameters.calibration.pressure", pressure, "Pa")?;
        let holds = (0.0..0.5).contains(&poissons_ratio);
        check(
            "parameters.calibration.poissons_ratio",
            poissons_ratio,
            holds,
            "is not in 0..0.5 (0.5 excluded)",
        )?;
        let holds = friction_angle > 0.0 && friction_angle < 90.0;
        check(
            "parameters.calibration.friction_angle",
            friction_angle,
            holds,
            "is not between 0 and 90 degrees",
        )?;
        let holds = dilatancy_angle > -45.0 && dilatancy_angle < 45.0;
        check(
            "parameters.calibration.dilatancy_angle",
            dilatancy_angle,
            holds,
            "is not between -45 and 45 degrees",
        )?;

        let sin = friction_angle.to_radians().sin();
        let r = (1.0 + sin) / (1.0 - sin);
        let nu = 0.5 * (1.0 + dilatancy_angle.to_radians().tan());
        let norm = |nu: f64| (1.0 + 2.0 * nu * nu).sqrt();
        let (ni, n) = (norm(poissons_ratio), norm(nu));
        let c1 = -youngs_modulus / (3.0 * pressure * (1.0 + poissons_ratio));
        // C3 = slope C2 + shift, from no lateral stress rate in the isotropic state.
        let slope = (1.0 - 2.0 * poissons_ratio) / ni;
        let shift = -9.0 * poissons_ratio * c1 / ni;
        let (outer, inner) = ((r + 2.0).powi(2), r * r - 4.0);
        let c2 = (inner * n * shift - outer * (1.0 + 4.0 * nu) * c1)
            / ((r - 4.0) * (r - 2.0 * nu) - inner * n * slope);
        let c3 = slope * c2 + shift;
        let c4 = 9.0 * ((r - 2.0 * nu) * c2 - nu * outer * c1 - n * c3) / ((r - 1.0).powi(2) * n);
        let constants = Self { c1, c2, c3, c4 };
        let field = "parameters.calibration.friction_angle";
        let finite = [c1, c2, c3, c4].iter().all(|c| c.is_finite());
        check(field, friction_angle, finite, "has no calibration at this Poisson's ratio and dilatancy")?;
        let states = constants.stationary_states();
        let wanted = states.iter().any(|state| (state.stress_ratio - r).abs() < 1e-6 * r);
        let early = states.iter().find(|state| state.stress_ratio < r * (1.0 - 1e-6));
        if let Some(state) = early {
            let rule = format!(
                "stalls at the spurious stationary state R = {:.4}, ψ = {:.1}° before failure at R = {r:.4}",
                state.stress_ratio,
                state.dilatancy_angle.to_degrees()
            );
            return Err(MaterialError::Parameter { field, value: friction_angle, rule });
        }
        check(field, friction_angle, wanted, "is not reached by a compression path with these constants")?;
        Ok(constants)
    }

    /// All stationary states of triaxial compression with `f_d = 1`, the lowest stress ratio first. They
    /// are the points of the failure surface on the triaxial axis, at which `D = -𝓛⁻¹N ‖D‖`.
    pub fn stationary_states(&self) -> Vec<StationaryState> {
        const COUNT: u32 = 8000;
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

    /// `-𝓛⁻¹ N`: the strain rate, per unit of its own norm, that would keep `stress`. Its norm is 1 on the
    /// failure surface (eq. 14) and below 1 inside.
    pub fn failure_flow(&self, stress: &SymTensor, density_function: f64) -> SymTensor {
        let trace = stress.trace();
        let (alpha, beta) = (self.c1 * trace, self.c2 / trace);
        let n = self.nonlinear(stress, density_function);
        let projected = beta * stress.dot(&n) / (alpha + beta * stress.dot(stress));
        (*stress * projected - n) * (1.0 / alpha)
    }

    #[inline]
    fn nonlinear(&self, stress: &SymTensor, density_function: f64) -> SymTensor {
        let factor = density_function / stress.trace();
        squared(stress) * (self.c3 * factor) + squared(&stress.deviator()) * (self.c4 * factor)
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

impl HypoplasticSpec {
    /// Checks the ranges and builds the frictional law, without its viscous part.
    ///
    /// # Errors
    /// The first parameter out of range; a calibration with spurious stationary states.
    pub fn law(&self) -> Result<Hypoplastic, MaterialError> {
        positive("void_ratio", self.void_ratio, "")?;
        positive("minimum_pressure", self.minimum_pressure, "Pa")?;
        let constants = match &self.parameters {
            HypoplasticParameters::Calibration(calibration) => Constants::calibrate(calibration)?,
            HypoplasticParameters::Constants(constants) => {
                let c1 = constants.c1;
                check("parameters.constants.c1", c1, c1.is_finite() && c1 < 0.0, "must be negative")?;
                for (name, value) in [
                    ("parameters.constants.c2", constants.c2),
                    ("parameters.constants.c3", constants.c3),
                    ("parameters.constants.c4", constants.c4),
                ] {
                    check(name, value, value.is_finite(), "must be finite")?;
                }
                *constants
            }
        };
        if let Some(critical) = &self.critical_state {
            critical.validate()?;
        }
        Ok(Hypoplastic {
            constants,
            critical_state: self.critical_state,
            void_ratio: self.void_ratio,
            minimum_pressure: self.minimum_pressure,
        })
    }
}

impl Model for HypoplasticSpec {
    const FACTS: Facts = Facts {
        source: "Wu, Wang & Alipour 2020, eqs. 8–32",
        kind: Kind::Solid,
        strain: "rate",
        tangent: "numerical",
    };

    fn density(&self) -> f64 {
        self.density
    }

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        let frictional = Corotational(self.law()?);
        Ok(match self.viscous {
            None => Arc::new(frictional),
            Some(viscosity) => Arc::new(Viscous::new(frictional, viscosity)?),
        })
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if let HypoplasticParameters::Constants(constants) = &self.parameters {
            let states = constants.stationary_states();
            if states.len() != 1 {
                let ratios: Vec<String> = states.iter().map(|s| format!("{:.4}", s.stress_ratio)).collect();
                warnings.push(format!(
                    "parameters.constants: triaxial compression has {} stationary states (stress ratios {}) instead of one",
                    states.len(),
                    ratios.join(", ")
                ));
            }
        }
        if let Some(critical) = &self.critical_state
            && self.void_ratio <= critical.minimum_void_ratio
        {
            warnings.push(format!(
                "void_ratio: {} is not above the smallest void ratio, {}",
                self.void_ratio, critical.minimum_void_ratio
            ));
        }
        if self.viscous.is_some_and(|viscous| viscous.mode == ViscousMode::RateMaterial) {
            warnings.push(
                "viscous.mode: rate-material is not objective; use it in element tests only".to_owned(),
            );
        }
        warnings
    }

    /// Soft soil: over a step of several per cent the stress of a stiff one grows or fades by so many orders of
    /// magnitude that the contract's tolerances lose their meaning.
    fn examples() -> Vec<Self> {
        let plain = Self {
            density: 1700.0,
            void_ratio: 0.7,
            parameters: HypoplasticParameters::Calibration(Calibration {
                youngs_modulus: 2e6,
                pressure: 100e3,
                poissons_ratio: 0.0,
                friction_angle: 30.0,
                dilatancy_angle: 0.0,
            }),
            critical_state: None,
            minimum_pressure: minimum_pressure(),
            viscous: None,
        };
        let critical_state = CriticalState {
            minimum_void_ratio: 0.5,
            p1: 0.5,
            p2: 0.5,
            p3: -5e-7,
            q1: 1.0,
            q2: -0.2,
            q3: -1e-7,
        };
        let dense = Self { critical_state: Some(critical_state), ..plain.clone() };
        let viscous = AccelerationViscosity { a: -8e-4, m1: 0.5, m2: 1e-3, mode: ViscousMode::Integrated };
        let viscous = Self { viscous: Some(viscous), ..dense.clone() };
        vec![plain, dense, viscous]
    }
}

/// The frictional law. See the module's head for source and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Hypoplastic {
    constants: Constants,
    critical_state: Option<CriticalState>,
    void_ratio: f64,
    minimum_pressure: f64,
}

impl Hypoplastic {
    /// The constants, calibrated or given.
    pub fn constants(&self) -> &Constants {
        &self.constants
    }

    /// `f_d` at `stress` (Pa) and void ratio.
    #[inline]
    pub fn density_function(&self, stress: &SymTensor, void_ratio: f64) -> f64 {
        self.critical_state.as_ref().map_or(1.0, |c| c.density_function(stress.trace(), void_ratio))
    }

    #[inline]
    fn slope(&self, stress: &SymTensor, void_ratio: f64, strain: &SymTensor) -> SymTensor {
        self.constants.rate(stress, strain, self.density_function(stress, void_ratio))
    }

    /// Modified Euler over one piece of strain, in as many substeps as the local error asks for. They are
    /// equal, their number a power of two: the update is smooth between the few strains at which that
    /// number changes, so its tangent means something.
    fn integrate(
        &self,
        strain: &SymTensor,
        old: &Point<VoidRatio>,
    ) -> Result<Advance<VoidRatio>, MaterialError> {
        (0..=DOUBLINGS)
            .find_map(|k| self.in_substeps(1 << k, strain, old))
            .map(|point| Advance { point, dissipated: 0.0 })
            .ok_or(MaterialError::NotConverged { model: NAME, reason: "too many substeps" })
    }

    /// Modified Euler in `count` equal substeps (sheet §3.7.10); `None` where the local error of one of them
    /// is too large.
    fn in_substeps(
        &self,
        count: u32,
        strain: &SymTensor,
        old: &Point<VoidRatio>,
    ) -> Option<Point<VoidRatio>> {
        let share = 1.0 / f64::from(count);
        let part = *strain * share;
        let growth = part.trace().exp();
        let Point { mut stress, state: VoidRatio { mut void_ratio } } = *old;
        for _ in 0..count {
            let next_void_ratio = (1.0 + void_ratio) * growth - 1.0;
            if stress.pressure() <= self.minimum_pressure {
                // The skeleton is free of stress and stays so as long as it opens.
                stress = SymTensor::isotropic(-self.minimum_pressure);
            }
            if stress.pressure() > self.minimum_pressure || part.trace() < 0.0 {
                let first = self.slope(&stress, void_ratio, &part);
                let predicted = stress + first;
                let second = self.slope(&predicted, next_void_ratio, &part);
                let error = 0.5 * (second - first).norm() / stress.norm();
                // A substep that loses half the pressure is too long whatever the error says.
                if !(error < TOLERANCE && predicted.pressure() > 0.5 * stress.pressure()) {
                    return None;
                }
                stress += (first + second) * 0.5;
            }
            void_ratio = next_void_ratio;
        }
        if stress.pressure() <= self.minimum_pressure {
            stress = SymTensor::isotropic(-self.minimum_pressure);
        }
        Some(Point { stress, state: VoidRatio { void_ratio } })
    }
}

impl SmallStrain for Hypoplastic {
    type State = VoidRatio;

    fn name(&self) -> &'static str {
        NAME
    }

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

    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<VoidRatio>,
    ) -> Result<Point<VoidRatio>, MaterialError> {
        if strain.norm() == 0.0 {
            return Ok(*old);
        }
        Ok(substepped(NAME, strain, PIECE, old, |part, from| self.integrate(part, from))?.point)
    }

    fn wave_modulus(&self, point: &Point<VoidRatio>) -> f64 {
        // Norm inequality on the rate equation.
        let stress = &point.stress;
        let Constants { c1, c2, c3, c4 } = self.constants;
        let density = self.density_function(stress, point.state.void_ratio).abs();
        let trace = stress.trace().abs().max(3.0 * self.minimum_pressure);
        let deviator = stress.deviator();
        trace * c1.abs()
            + stress.dot(stress) / trace * (c2.abs() + density * c3.abs())
            + deviator.dot(&deviator) / trace * density * c4.abs()
    }

    fn output_names(&self) -> &'static [&'static str] {
        &["void_ratio", "failure"]
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
