//! Sand without cohesion at finite strain (sheet: snow-mpm §2.10b, c; Klar et al. 2016; Tampubolon et al. 2017).
//!
//! A cone in Kirchhoff stress, `q ≤ M p` with `M = √(3/2) d α`, `α = √(2/3) 2 sin φ / (3 - sin φ)` and the number `d` of
//! dimensions of the invariants ([`StressInvariants`]); linear elasticity in logarithmic strain; flow is
//! isochoric. With `d = 3` the cone passes through triaxial compression; with `d = 2` it has two thirds of that slope, as the
//! source prints it. The friction angle may change with flow ([`SandHardening`]); its value at the end of a step is used,
//! where the source uses that of the start: both agree as steps shrink.
//!
//! A trial in tension returns to the stress-free apex, and the volumetric strain `v` opened there
//! is stored. With `volume_correction` it is added to the trial's volumetric strain: no stress until the opening is closed. Without,
//! opened sand keeps the gained volume.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::linear_elastic::incompressibility_warnings;
use super::strength_reduced::StrengthReduction;
use super::{Elasticity, angle_warnings};
use crate::Warning;
use crate::adapters::hencky::{InvariantReturn, ReturnResult, StressInvariants};
use crate::contract::parameter_checks::{check, not_negative};
use crate::laws::model::with_defaults;
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::return_maps::scalar_roots::falling_root;
use crate::{
    InitialCondition, Law, Material, MaterialError, Motion, Point, PointLaw, PrincipalReturn, SmallStrain,
    SymTensor,
};

/// Value of the key `model` in case files.
const NAME: &str = "sand";

/// Constant `√6`.
const ROOT_6: f64 = 2.449_489_742_783_178;

/// Tolerance of a returned stress for round-off, relative to the stress.
const YIELD_TOLERANCE: f64 = 8.0 * f64::EPSILON;

/// Parameters of `sand`, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SandSpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Young's modulus (Pa), positive.
    pub youngs_modulus: f64,
    /// Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Friction angle (degrees), above 0, below 90; with `hardening` after much flow.
    pub friction_angle: f64,
    /// Change of friction with flow; none when absent.
    #[serde(default)]
    pub hardening: Option<SandHardening>,
    /// Whether volume gained in tension must close before stress is carried; otherwise it stays.
    #[serde(default = "default_true")]
    pub volume_correction: bool,
    /// Tensor of invariants.
    #[serde(default)]
    pub invariants: StressInvariants,
    /// Return of initial stress outside yield; otherwise refused.
    #[serde(default)]
    pub return_initial_stress_to_yield: bool,
}

fn default_true() -> bool {
    true
}

/// Friction angle in flow: `φ = h0 + (h1 a - h3) exp(-h2 a)`, with `h0` the `friction_angle`, `a` the sum of plastic strain norms; defaults
/// of Klar et al. 2016.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SandHardening {
    /// Initial growth `h1` (degrees), non-negative.
    #[serde(default = "growth")]
    pub growth: f64,
    /// Decay rate `h2`, positive.
    #[serde(default = "default_decay_rate")]
    pub fading: f64,
    /// Initial deficit `h3` (degrees), non-negative, below `friction_angle`.
    #[serde(default = "default_angle_difference")]
    pub below: f64,
}

/// Default initial growth `h1` of the friction angle with plastic strain (degrees).
fn growth() -> f64 {
    9.0
}
/// Default decay rate `h2` of the change of the friction angle (-).
fn default_decay_rate() -> f64 {
    0.2
}
/// Default difference `h3` of the friction angle and its initial value (degrees).
fn default_angle_difference() -> f64 {
    10.0
}

impl Default for SandHardening {
    /// Values of Klar et al. 2016.
    fn default() -> Self {
        Self { growth: growth(), fading: default_decay_rate(), below: default_angle_difference() }
    }
}

impl SandHardening {
    /// Change of the friction angle (degrees) after the plastic strain `flow`, and its slope.
    fn friction_change(&self, flow: f64) -> (f64, f64) {
        let (left, fade) = (self.growth * flow - self.below, (-self.fading * flow).exp());
        (left * fade, (self.growth - self.fading * left) * fade)
    }

    /// Largest change of the friction angle (degrees).
    fn max_friction_change(&self) -> f64 {
        if self.growth == 0.0 {
            return 0.0;
        }
        self.friction_change(1.0 / self.fading + self.below / self.growth).0.max(0.0)
    }
}

/// Law of cohesionless sand in small strain, which [`SandSpec`] applies to logarithmic strains.
#[derive(Clone, Debug, PartialEq)]
pub struct Sand {
    /// Elastic constants of `d` dimensions.
    elasticity: Elasticity,
    spec: SandSpec,
}

/// Internal variables of [`Sand`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SandState {
    /// Sum of the norms of the plastic strain of the steps.
    pub plastic_strain: f64,
    /// Volumetric strain gained at the apex and not yet closed.
    pub volume_correction: f64,
}

impl Sand {
    /// Friction angle (degrees) after the plastic strain `flow`.
    pub fn friction_angle(&self, flow: f64) -> f64 {
        self.spec.friction_angle
            + self.spec.hardening.map_or(0.0, |hardening| hardening.friction_change(flow).0)
    }

    /// Slope `M` of the cone at the plastic strain `flow`, and its derivative.
    fn slope(&self, flow: f64) -> (f64, f64) {
        let (sin, cos) = self.friction_angle(flow).to_radians().sin_cos();
        let share = 2.0 * self.spec.invariants.dimensions();
        let turns =
            self.spec.hardening.map_or(0.0, |hardening| hardening.friction_change(flow).1.to_radians());
        (share * sin / (3.0 - sin), share * 3.0 * cos / (3.0 - sin).powi(2) * turns)
    }

    /// Return of a trial stress to the cone at constant pressure: deviatoric stress `q` (Pa) and plastic strain.
    fn return_to_cone(&self, pressure: f64, q: f64, flow: f64) -> Result<(f64, f64), MaterialError> {
        let per_strain = ROOT_6 * self.elasticity.shear_modulus;
        if self.spec.hardening.is_none() {
            let kept = self.slope(flow).0 * pressure;
            return Ok((kept, (q - kept) / per_strain));
        }
        let largest = q / per_strain;
        let excess = |grown: f64| {
            let (slope, rate) = self.slope(flow + grown);
            (q - per_strain * grown - slope * pressure, -per_strain - rate * pressure)
        };
        let grown = falling_root(0.0, largest, 0.0, excess)
            .ok_or(MaterialError::NotConverged { model: NAME, reason: "hardening return" })?;
        Ok((self.slope(flow + grown).0 * pressure, grown))
    }

    /// Return map, see [`InvariantReturn::return_invariants`].
    fn return_map(&self, (pressure, q): (f64, f64), state: &SandState) -> ReturnResult<SandState> {
        if !(pressure + q).is_finite() {
            return Err(MaterialError::Motion { model: NAME, reason: "the trial stress is not finite" });
        }
        let bulk = self.elasticity.bulk_modulus;
        let closed = pressure - bulk * state.volume_correction;
        if closed <= 0.0 {
            if pressure == 0.0 && q == 0.0 {
                return Ok((None, *state));
            }
            let volumetric = -pressure / bulk / self.spec.invariants.dimensions().sqrt();
            let shear = q / (ROOT_6 * self.elasticity.shear_modulus);
            let opened = if self.spec.volume_correction { -closed / bulk } else { 0.0 };
            return Ok((
                Some((0.0, 0.0)),
                SandState {
                    plastic_strain: state.plastic_strain + shear.hypot(volumetric),
                    volume_correction: opened,
                },
            ));
        }
        let shut = SandState { volume_correction: 0.0, ..*state };
        if q - self.slope(state.plastic_strain).0 * closed <= YIELD_TOLERANCE * q {
            return Ok(((state.volume_correction > 0.0).then_some((closed, q)), shut));
        }
        let (kept, grown) = self.return_to_cone(closed, q, state.plastic_strain)?;
        Ok((Some((closed, kept)), SandState { plastic_strain: state.plastic_strain + grown, ..shut }))
    }

    /// Yield function `q - M p` at the mobilised friction (Pa), positive outside the surface.
    fn excess(&self, stress: &SymTensor, state: &SandState) -> f64 {
        stress.q() - self.slope(state.plastic_strain).0 * stress.pressure()
    }
}

impl Law for Sand {
    fn name(&self) -> &'static str {
        NAME
    }

    fn output_names(&self) -> &[&'static str] {
        &["plastic_strain", "opened_strain", "friction_angle"]
    }
}

impl PointLaw for Sand {
    type State = SandState;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<SandState>, MaterialError> {
        let (stress, state) = (initial.stress, SandState::default());
        if self.spec.return_initial_stress_to_yield && stress.is_finite() {
            let old = Point { stress, state };
            let Point { stress, .. } = self.update(&SymTensor::ZERO, &Motion::AT_REST, &old)?;
            return Ok(Point { stress, state });
        }
        super::check_initial(NAME, &stress, self.excess(&stress, &state), stress.norm())?;
        Ok(Point { stress, state })
    }

    fn wave_modulus(&self, _point: &Point<SandState>) -> f64 {
        self.elasticity.p_wave_modulus()
    }

    fn linear_elasticity(&self) -> Option<&Elasticity> {
        Some(&self.elasticity)
    }

    fn yield_value(&self, point: &Point<SandState>) -> Option<f64> {
        Some(self.excess(&point.stress, &point.state))
    }

    fn outputs(&self, point: &Point<SandState>, out: &mut [f64]) {
        out[0] = point.state.plastic_strain;
        out[1] = point.state.volume_correction;
        out[2] = self.friction_angle(point.state.plastic_strain);
    }
}

impl SmallStrain for Sand {
    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<SandState>,
    ) -> Result<Point<SandState>, MaterialError> {
        let trial = old.stress + self.elasticity.stress(strain);
        let q = trial.q();
        let (end, state) = self.return_map((trial.pressure(), q), &old.state)?;
        let stress = match end {
            None => trial,
            Some((pressure, kept)) => {
                let share = if q > 0.0 { kept / q } else { 0.0 };
                trial.deviator() * share - SymTensor::isotropic(pressure)
            }
        };
        Ok(Point { stress, state })
    }

    /// Infinite strain increment: the return is exact at any size, because it keeps the principal directions.
    fn max_strain_increment(&self) -> f64 {
        f64::INFINITY
    }
}

impl PrincipalReturn for Sand {
    fn elasticity(&self) -> &Elasticity {
        &self.elasticity
    }

    fn return_principal(
        &self,
        trial: [f64; 3],
        state: &SandState,
    ) -> Result<([f64; 3], SandState), MaterialError> {
        let [a, b, c] = trial;
        let old = Point { stress: SymTensor::diagonal(a, b, c), state: *state };
        let new = self.update(&SymTensor::ZERO, &Motion::AT_REST, &old)?;
        Ok(([new.stress[0], new.stress[1], new.stress[2]], new.state))
    }
}

impl InvariantReturn for Sand {
    fn return_invariants(&self, trial: (f64, f64), state: &SandState) -> ReturnResult<SandState> {
        self.return_map(trial, state)
    }
}

impl SandSpec {
    /// Parameters from density (kg/m³), Young's modulus (Pa), Poisson's ratio (-) and friction angle (degrees); all others have their
    /// defaults.
    #[must_use]
    pub fn new(density: f64, youngs_modulus: f64, poissons_ratio: f64, friction_angle: f64) -> Self {
        with_defaults(&[
            ("density", density),
            ("youngs_modulus", youngs_modulus),
            ("poissons_ratio", poissons_ratio),
            ("friction_angle", friction_angle),
        ])
    }

    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<Sand, MaterialError> {
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        let angle = self.friction_angle;
        let rule = "is not between 0 and 90 degrees (both excluded)";
        check("friction_angle", angle, angle > 0.0 && angle < 90.0, rule)?;
        if let Some(hardening) = &self.hardening {
            let SandHardening { growth, fading, below } = *hardening;
            not_negative("hardening.growth", growth, "degrees")?;
            crate::contract::parameter_checks::positive("hardening.fading", fading, "")?;
            let rule = format!("is not between 0 and the friction angle, {angle} degrees (excluded)");
            check("hardening.below", below, (0.0..angle).contains(&below), &rule)?;
            let largest = angle + hardening.max_friction_change();
            let rule = format!("raises the friction angle to {largest:.4} degrees, which must stay below 90");
            check("hardening.growth", growth, largest < 90.0, &rule)?;
        }
        Ok(Sand { elasticity: self.invariants.elasticity(elasticity), spec: self.clone() })
    }
}

impl Model for SandSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Klar et al. 2016; Tampubolon et al. 2017",
        kind: ModelFamily::Solid,
        strain: "Hencky",
        tangent: "numerical",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(self.invariants.wrap(self.law()?))
    }

    fn warnings(&self) -> Vec<Warning> {
        let mut warnings = incompressibility_warnings(self.poissons_ratio);
        warnings.extend(angle_warnings(self.friction_angle, 0.0));
        if self.invariants == StressInvariants::Plane {
            warnings.push(Warning::new(
                "weak-matching",
                "invariants: plane makes sand weaker: the slope of its cone is two thirds of that of the \
                 friction angle in triaxial compression. Use space, or calibrate the angle",
            ));
        }
        warnings
    }

    fn strength_reduced(&self, reduction: &StrengthReduction) -> Option<Result<Self, MaterialError>> {
        if self.hardening.is_some() {
            return None;
        }
        let reduced = Self { friction_angle: reduction.angle(self.friction_angle), ..self.clone() };
        Some(reduced.law().map(|_| reduced))
    }

    fn examples() -> Vec<Self> {
        let with = |volume_correction, hardening| Self {
            density: 1600.0,
            youngs_modulus: 20e6,
            poissons_ratio: 0.3,
            friction_angle: 35.0,
            hardening,
            volume_correction,
            invariants: StressInvariants::Space,
            return_initial_stress_to_yield: false,
        };
        let hardening = SandHardening {
            growth: growth(),
            fading: default_decay_rate(),
            below: default_angle_difference(),
        };
        vec![with(true, None), with(false, None), with(true, Some(hardening))]
    }
}
