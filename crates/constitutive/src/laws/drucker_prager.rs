//! Drucker–Prager plasticity (constitutive sheet §2.4, §3.7.1; Bui & Nguyen 2021, eqs. 74–80).
//!
//! `f = √J2 + α I1 - k ≤ 0`, `g = √J2 + α_ψ I1`; elastic law linear. Cohesion and friction angle
//! may soften exponentially with the accumulated deviatoric plastic strain `κ`, the dilatancy angle
//! may decay with it. The return is fully implicit, on the smooth cone or to its apex; without
//! cohesion the apex is the stress-free state. How the cone is matched to Mohr–Coulomb decides the
//! strength: see [`Matching`]. Limits: softening has no length of its own (mesh-dependent bands).

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Elasticity;
use super::linear_elastic::stiff_warnings;
use super::strength_reduced::StrengthReduction;
use crate::lanes::Lanes;
use crate::model::{Facts, Kind, Model, StrainMeasure, check, not_negative};
use crate::{
    BLOCK, InitialCondition, Material, MaterialError, Motion, Point, PrincipalReturn, SmallStrain, SymTensor,
    Tangent,
};

const NAME: &str = "drucker-prager";

/// How the cone is fitted to the Mohr–Coulomb pyramid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Matching {
    /// Through the edges of triaxial compression: too strong by far in plane strain.
    #[default]
    Compression,
    /// Through the edges of triaxial extension.
    Extension,
    /// Inscribed cone: plane-strain strength for associated flow only.
    PlaneStrainAssociated,
    /// Exact strength and dilatancy of Mohr–Coulomb in plane strain, for any dilatancy angle.
    PlaneStrain,
}

/// Parameters of `drucker-prager`, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DruckerPragerSpec {
    /// Density (kg/m³), > 0.
    pub density: f64,
    /// Young's modulus (Pa), > 0.
    pub youngs_modulus: f64,
    /// Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Friction angle (degrees), 0 to 90 (excluded).
    pub friction_angle: f64,
    /// Cohesion (Pa), not negative.
    #[serde(default)]
    pub cohesion: f64,
    /// Dilatancy angle (degrees), between minus and plus the friction angle.
    #[serde(default)]
    pub dilatancy_angle: f64,
    /// How the cone is matched to Mohr–Coulomb.
    #[serde(default)]
    pub matching: Matching,
    /// Exponential softening of cohesion and friction; none when absent.
    #[serde(default)]
    pub softening: Option<Softening>,
    /// Rate at which the dilatancy angle decays with plastic strain.
    #[serde(default)]
    pub dilatancy_decay: f64,
    /// How the step is integrated.
    #[serde(default)]
    pub integration: Integration,
    /// Small strain in rate form, or logarithmic finite strain.
    #[serde(default)]
    pub strain_measure: StrainMeasure,
}

/// Exponential softening to residual strength (Bui & Nguyen eqs. 76–77).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Softening {
    /// Residual friction angle (degrees), at most the peak.
    pub residual_friction_angle: f64,
    /// Residual cohesion (Pa), at most the peak.
    pub residual_cohesion: f64,
    /// Rate of decay of the friction angle with plastic strain.
    pub friction_rate: f64,
    /// Rate of decay of the cohesion with plastic strain.
    pub cohesion_rate: f64,
    /// Allow residual values above the peak: strength then grows with plastic strain.
    #[serde(default)]
    pub hardening: bool,
}

impl Softening {
    /// For the samples of the models that soften.
    pub(super) const EXAMPLE: Self = Self {
        residual_friction_angle: 20.0,
        residual_cohesion: 2e3,
        friction_rate: 3.0,
        cohesion_rate: 5.0,
        hardening: false,
    };

    /// Friction angle (rad) and cohesion (Pa) at the plastic strain `kappa`, from those at the peak.
    pub(super) fn strength(&self, (friction, cohesion): (f64, f64), kappa: f64) -> (f64, f64) {
        let residual = self.residual_friction_angle.to_radians();
        (
            residual + (friction - residual) * (-self.friction_rate * kappa).exp(),
            self.residual_cohesion
                + (cohesion - self.residual_cohesion) * (-self.cohesion_rate * kappa).exp(),
        )
    }

    /// The same softening of a soil with `share` of its cohesion.
    pub(super) fn scaled_cohesion(self, share: f64) -> Self {
        Self { residual_cohesion: self.residual_cohesion * share, ..self }
    }

    /// Step in plastic strain for differences of a strength that softens and dilates less and less.
    pub(super) fn difference_step(softening: Option<Self>, dilatancy_decay: f64) -> f64 {
        let fastest = softening.map_or(0.0, |s| s.friction_rate.max(s.cohesion_rate));
        1e-5 / fastest.max(dilatancy_decay).max(1e-3)
    }

    /// Ranges of the strength of a frictional law and of its decay (angles in degrees), sheet §7.
    pub(super) fn check(
        softening: Option<Self>,
        friction_angle: f64,
        cohesion: f64,
        dilatancy_decay: f64,
    ) -> Result<(), MaterialError> {
        not_negative("cohesion", cohesion, "Pa")?;
        let strong = friction_angle > 0.0 || cohesion > 0.0;
        check("cohesion", cohesion, strong, "must be positive when the friction angle is 0")?;
        not_negative("dilatancy_decay", dilatancy_decay, "")?;
        softening.map_or(Ok(()), |s| s.validate(friction_angle, cohesion))
    }

    fn validate(&self, friction_angle: f64, cohesion: f64) -> Result<(), MaterialError> {
        let residual = self.residual_friction_angle;
        let (holds, rule) = if self.hardening {
            ((0.0..90.0).contains(&residual), "is not in 0..90 degrees (90 excluded)".to_owned())
        } else {
            let rule = format!("is not between 0 and the peak, {friction_angle} degrees");
            ((0.0..=friction_angle).contains(&residual), rule)
        };
        check("softening.residual_friction_angle", residual, holds, &rule)?;
        let residual = self.residual_cohesion;
        if self.hardening {
            not_negative("softening.residual_cohesion", residual, "Pa")?;
        } else {
            let rule = format!("is not between 0 and the peak, {cohesion} Pa");
            check("softening.residual_cohesion", residual, (0.0..=cohesion).contains(&residual), &rule)?;
        }
        for (name, rate) in
            [("softening.friction_rate", self.friction_rate), ("softening.cohesion_rate", self.cohesion_rate)]
        {
            check(name, rate, rate.is_finite() && rate >= 0.0, "must not be negative")?;
        }
        Ok(())
    }
}

/// How a plastic step is integrated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Integration {
    /// Fully implicit return to the cone or its apex.
    #[default]
    ClosestPoint,
    /// Algorithm 2 of Bui & Nguyen: one corrector with the slopes at the trial. The same as the return
    /// where strength is constant; otherwise what drifts outside is scaled back.
    SemiImplicit,
    /// Algorithm 1 of Bui & Nguyen: forward step with the elastoplastic stiffness from where the elastic
    /// part meets the cone; drift is taken back by tension cracking and stress scaling. Steps above half
    /// of the yield strain at zero pressure, `k/2G`, are divided: where a step turns the deviator around, the slope
    /// at its start says nothing about its end.
    Explicit,
}

impl DruckerPragerSpec {
    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<DruckerPrager, MaterialError> {
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        super::check_angles(self.friction_angle, self.dilatancy_angle)?;
        let (cohesion, decay) = (self.cohesion, self.dilatancy_decay);
        Softening::check(self.softening, self.friction_angle, cohesion, decay)?;
        if self.integration != Integration::ClosestPoint && self.strain_measure == StrainMeasure::Hencky {
            let rule = "only closest-point goes with strain_measure hencky";
            return Err(MaterialError::choice("integration", rule));
        }
        let constant = self.softening.is_none() && decay == 0.0;
        let law = DruckerPrager {
            name: NAME,
            elasticity,
            spec: self.clone(),
            constant,
            peak: Cone::default(),
            per_excess: 0.0,
        };
        let peak = law.softened_cone(0.0);
        let modulus =
            elasticity.shear_modulus + 9.0 * elasticity.bulk_modulus * peak.friction * peak.dilatancy;
        let rule = "contracts faster than this stiffness can follow (G + 9 K α α_ψ must be positive)";
        check("dilatancy_angle", self.dilatancy_angle, modulus > 0.0, rule)?;
        Ok(DruckerPrager { peak, per_excess: 1.0 / modulus, ..law })
    }
}

impl DruckerPragerSpec {
    /// What the samples have in common.
    fn example(matching: Matching) -> Self {
        Self {
            density: 2000.0,
            youngs_modulus: 20e6,
            poissons_ratio: 0.3,
            friction_angle: 30.0,
            cohesion: 10e3,
            dilatancy_angle: 10.0,
            matching,
            softening: None,
            dilatancy_decay: 0.0,
            integration: Integration::default(),
            strain_measure: StrainMeasure::Rate,
        }
    }
}

impl Model for DruckerPragerSpec {
    const FACTS: Facts = Facts {
        source: "Bui & Nguyen 2021, eqs. 74–80",
        kind: Kind::Solid,
        strain: "rate or Hencky",
        tangent: "analytic",
    };

    fn density(&self) -> f64 {
        self.density
    }

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(self.strain_measure.wrap(self.law()?))
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = stiff_warnings(self.poissons_ratio);
        warnings.extend(super::angle_warnings(self.friction_angle, self.dilatancy_angle));
        if self.matching == Matching::Compression && self.friction_angle >= 36.87 {
            warnings.push(
                "matching: above 36.87 degrees the compression cone admits tension in extension".to_owned(),
            );
        }
        if self.matching == Matching::PlaneStrainAssociated && self.dilatancy_angle != self.friction_angle {
            warnings.push("matching: plane-strain-associated is exact only for associated flow".to_owned());
        }
        warnings
    }

    fn strength_reduced(&self, reduction: &StrengthReduction) -> Option<Result<Self, MaterialError>> {
        let friction_angle = reduction.angle(self.friction_angle);
        let reduced = Self {
            friction_angle,
            cohesion: self.cohesion / reduction.factor,
            dilatancy_angle: reduction.dilatancy(self.dilatancy_angle, friction_angle),
            softening: reduction.softening(self.softening),
            ..self.clone()
        };
        Some(reduced.law().map(|_| reduced))
    }

    fn examples() -> Vec<Self> {
        let mut all = Vec::new();
        for strain_measure in [StrainMeasure::Rate, StrainMeasure::Hencky] {
            for softening in [None, Some(Softening::EXAMPLE)] {
                if strain_measure == StrainMeasure::Rate {
                    let integration = Integration::SemiImplicit;
                    all.push(Self { integration, softening, ..Self::example(Matching::Compression) });
                }
                let matchings = [
                    Matching::Compression,
                    Matching::Extension,
                    Matching::PlaneStrain,
                    Matching::PlaneStrainAssociated,
                ];
                all.extend(matchings.map(|matching| Self {
                    softening,
                    dilatancy_decay: if softening.is_some() { 2.0 } else { 0.0 },
                    strain_measure,
                    ..Self::example(matching)
                }));
            }
        }
        all
    }
}

/// The cone at some plastic strain: `√J2 + α I1 - k`, potential slope `α_ψ`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cone {
    /// Friction coefficient `α`.
    pub friction: f64,
    /// Strength at zero mean stress `k` (Pa).
    pub strength: f64,
    /// Dilatancy coefficient `α_ψ`.
    pub dilatancy: f64,
}

impl Cone {
    /// The cone of the given matching, angles in radians, cohesion in Pa.
    pub fn new(matching: Matching, friction_angle: f64, cohesion: f64, dilatancy_angle: f64) -> Self {
        let (sin, cos) = friction_angle.sin_cos();
        let root3 = 3f64.sqrt();
        // Slope of the edges for the two triaxial matchings; `sign` is -1 in compression.
        let triaxial = |angle: f64, sign: f64| 2.0 * angle.sin() / (root3 * (3.0 + sign * angle.sin()));
        let inscribed = |angle: f64| angle.tan() / (9.0 + 12.0 * angle.tan().powi(2)).sqrt();
        match matching {
            Matching::Compression | Matching::Extension => {
                let sign = if matching == Matching::Compression { -1.0 } else { 1.0 };
                Self {
                    friction: triaxial(friction_angle, sign),
                    strength: 6.0 * cohesion * cos / (root3 * (3.0 + sign * sin)),
                    dilatancy: triaxial(dilatancy_angle, sign),
                }
            }
            Matching::PlaneStrainAssociated => Self {
                friction: inscribed(friction_angle),
                strength: 3.0 * cohesion / (9.0 + 12.0 * friction_angle.tan().powi(2)).sqrt(),
                dilatancy: inscribed(dilatancy_angle),
            },
            Matching::PlaneStrain => {
                let dilatancy = inscribed(dilatancy_angle);
                let n = (1.0 - 3.0 * dilatancy * dilatancy).sqrt() + dilatancy * sin;
                Self { friction: sin / (3.0 * n), strength: cohesion * cos / n, dilatancy }
            }
        }
    }

    /// Round-off of an earlier return, which is not flow (Pa).
    #[inline]
    fn fuzz(&self, trial: &Invariants) -> f64 {
        8.0 * f64::EPSILON * (trial.root_j2 + self.friction * trial.i1.abs() + self.strength)
    }

    /// `√J2 + α I1 - k` (Pa).
    #[inline]
    pub fn yield_value(&self, root_j2: f64, i1: f64) -> f64 {
        root_j2 + self.friction * i1 - self.strength
    }
}

/// The law. See the module's head for source and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct DruckerPrager {
    name: &'static str,
    elasticity: Elasticity,
    spec: DruckerPragerSpec,
    constant: bool,
    peak: Cone,
    /// `1/(G + 9 K α α_ψ)` of the peak (1/Pa).
    per_excess: f64,
}

/// Internal variable: accumulated deviatoric plastic strain `κ`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlasticStrain {
    /// `κ = ∫ √(2/3 dε^p : dε^p)` of the deviatoric plastic strain.
    pub deviatoric: f64,
}

const ROOT_3: f64 = 1.732_050_807_568_877_2;

/// Deviator, `√J2` (Pa) and `I1` (Pa) of a stress.
struct Invariants {
    deviator: SymTensor,
    root_j2: f64,
    i1: f64,
}

impl Invariants {
    #[inline]
    fn of(stress: &SymTensor) -> Self {
        let deviator = stress.deviator();
        Self { deviator, root_j2: (0.5 * deviator.dot(&deviator)).sqrt(), i1: stress.trace() }
    }
}

/// Where the return of a trial ends.
enum Return {
    Elastic,
    /// Multiplier and the cone at the end of the step.
    Cone {
        multiplier: f64,
        cone: Cone,
    },
    Apex {
        mean: f64,
        plastic: f64,
    },
}

impl DruckerPrager {
    /// The same law under another name, for models that are a special case of it.
    pub(in crate::laws) fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// The same law with `share` of its cohesion, peak and residual.
    pub(super) fn scaled_cohesion(&self, share: f64) -> Self {
        let mut law = self.clone();
        law.spec.cohesion *= share;
        law.spec.softening = law.spec.softening.map(|s| s.scaled_cohesion(share));
        law.peak = law.softened_cone(0.0);
        law
    }

    /// Algorithm 2 of Bui & Nguyen 2021 (sheet §3.6) before its drift is taken back: the stress after one
    /// corrector with the slopes at the trial, and the multiplier.
    pub fn corrected(&self, trial: &SymTensor, kappa: f64) -> (SymTensor, f64) {
        let (k, g) = (self.elasticity.bulk_modulus, self.elasticity.shear_modulus);
        let (cone, rate) = (self.cone_at(kappa), self.cone_rate(kappa));
        let (deviator, i1) = (trial.deviator(), trial.trace());
        let root_j2 = (0.5 * deviator.dot(&deviator)).sqrt();
        let hardening = (rate.friction * i1 - rate.strength) / 3f64.sqrt();
        let modulus = g + 9.0 * k * cone.friction * cone.dilatancy - hardening;
        let multiplier = cone.yield_value(root_j2, i1).max(0.0) / modulus;
        let keep = if root_j2 > 0.0 { 1.0 - g * multiplier / root_j2 } else { 0.0 };
        let mean = i1 / 3.0 - 3.0 * k * cone.dilatancy * multiplier;
        (deviator * keep + SymTensor::isotropic(mean), multiplier)
    }

    /// Algorithm 1 of Bui & Nguyen 2021 (sheet §3.6) before its drift is taken back: from `stress` inside
    /// or on the cone by the strain increment `strain`, elastic up to the cone, then with the continuum
    /// elastoplastic stiffness (eq. 2.4) there. Returns the stress and the multiplier.
    pub fn forward(&self, stress: &SymTensor, strain: &SymTensor, kappa: f64) -> (SymTensor, f64) {
        let (k, g) = (self.elasticity.bulk_modulus, self.elasticity.shear_modulus);
        let (cone, rate) = (self.cone_at(kappa), self.cone_rate(kappa));
        let value = |s: &SymTensor| cone.yield_value(s.j2().sqrt(), s.trace());
        let elastic = self.elasticity.stress(strain);
        let trial = *stress + elastic;
        if value(&trial) <= 0.0 {
            return (trial, 0.0);
        }
        // The share of the step up to the cone, where the trial leaves it for good: f is convex.
        let scale = 1e-12 * (cone.strength + stress.norm());
        let (mut low, mut high) = (0.0, 1.0);
        if value(stress) < -scale {
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if value(&(*stress + elastic * middle)) <= 0.0 { low = middle } else { high = middle }
            }
        }
        let meeting = *stress + elastic * low;
        let (deviator, root_j2) = (meeting.deviator(), meeting.j2().sqrt());
        let rest = *strain * (1.0 - low);
        let shear = if root_j2 > 0.0 { g / root_j2 * deviator.dot(&rest) } else { 0.0 };
        let loading = shear + 3.0 * k * cone.friction * rest.trace();
        if loading <= 0.0 {
            return (trial, 0.0);
        }
        let hardening = (rate.friction * meeting.trace() - rate.strength) / 3f64.sqrt();
        let multiplier = loading / (g + 9.0 * k * cone.friction * cone.dilatancy - hardening);
        let back = if root_j2 > 0.0 { deviator * (g * multiplier / root_j2) } else { SymTensor::ZERO };
        (trial - back - SymTensor::isotropic(3.0 * k * cone.dilatancy * multiplier), multiplier)
    }

    /// Takes back drift out of the cone (sheet §2.4, Bui & Nguyen section 3.4): tension cracking moves the
    /// mean stress to the apex at most, stress scaling the deviator onto the cone.
    pub fn without_drift(&self, stress: SymTensor, kappa: f64) -> SymTensor {
        let cone = self.cone_at(kappa);
        let (deviator, mut i1) = (stress.deviator(), stress.trace());
        if cone.friction > 0.0 {
            i1 = i1.min(cone.strength / cone.friction);
        }
        let (root_j2, limit) =
            ((0.5 * deviator.dot(&deviator)).sqrt(), (cone.strength - cone.friction * i1).max(0.0));
        let keep = if root_j2 > limit { limit / root_j2 } else { 1.0 };
        deviator * keep + SymTensor::isotropic(i1 / 3.0)
    }

    /// The cone at plastic strain `kappa`.
    #[inline]
    pub fn cone_at(&self, kappa: f64) -> Cone {
        if self.constant { self.peak } else { self.softened_cone(kappa) }
    }

    fn softened_cone(&self, kappa: f64) -> Cone {
        let spec = &self.spec;
        let peak = (spec.friction_angle.to_radians(), spec.cohesion);
        let (friction, cohesion) = spec.softening.map_or(peak, |s| s.strength(peak, kappa));
        let dilatancy = spec.dilatancy_angle.to_radians() * (-spec.dilatancy_decay * kappa).exp();
        Cone::new(spec.matching, friction, cohesion, dilatancy)
    }

    /// Return map in invariants (sheet §3.7.1) of a trial, from plastic strain `kappa`.
    #[inline]
    fn return_map(&self, trial: &Invariants, kappa: f64) -> Result<Return, MaterialError> {
        if self.constant { self.peak_return(trial) } else { self.softening_return(trial, kappa) }
    }

    /// Step to a cone that stays, without branches: new stress and increment of plastic strain.
    #[inline(always)]
    fn peak_step(&self, strain: &SymTensor, stress: &SymTensor) -> (SymTensor, f64) {
        let trial = *stress + self.elasticity.stress(strain);
        let at = Invariants::of(&trial);
        let (cone, g) = (&self.peak, self.elasticity.shear_modulus);
        let excess = cone.yield_value(at.root_j2, at.i1);
        let flows = excess > cone.fuzz(&at);
        let multiplier = excess * self.per_excess;
        let on_cone = at.root_j2 - g * multiplier >= 0.0;
        let mean = at.i1 / 3.0 - 3.0 * self.elasticity.bulk_modulus * cone.dilatancy * multiplier;
        // `r - G Δλ`, from the yield condition: it then holds to the last digit of the result.
        let kept = (cone.strength - 3.0 * cone.friction * mean).max(0.0);
        let keep = if on_cone { kept / at.root_j2 } else { 0.0 };
        let mean = if on_cone { mean } else { cone.strength / (3.0 * cone.friction) };
        let plastic = if on_cone { multiplier / ROOT_3 } else { at.root_j2 / (g * ROOT_3) };
        let returned = at.deviator * keep + SymTensor::isotropic(mean);
        let mut stress = trial;
        for c in 0..6 {
            stress[c] = if flows { returned[c] } else { trial[c] };
        }
        (stress, if flows { plastic } else { 0.0 })
    }

    /// The return to a cone that stays.
    #[inline]
    fn peak_return(&self, trial: &Invariants) -> Result<Return, MaterialError> {
        let cone = &self.peak;
        let excess = cone.yield_value(trial.root_j2, trial.i1);
        if excess <= cone.fuzz(trial) {
            return Ok(Return::Elastic);
        }
        if !excess.is_finite() {
            return Err(self.not_finite());
        }
        let multiplier = excess * self.per_excess;
        if trial.root_j2 - self.elasticity.shear_modulus * multiplier >= 0.0 {
            return Ok(Return::Cone { multiplier, cone: *cone });
        }
        let plastic = trial.root_j2 / (self.elasticity.shear_modulus * ROOT_3);
        Ok(Return::Apex { mean: cone.strength / (3.0 * cone.friction), plastic })
    }

    fn softening_return(&self, trial: &Invariants, kappa: f64) -> Result<Return, MaterialError> {
        let Invariants { root_j2, i1, .. } = *trial;
        let cone = self.cone_at(kappa);
        let excess = cone.yield_value(root_j2, i1);
        if excess <= cone.fuzz(trial) {
            return Ok(Return::Elastic);
        }
        if !excess.is_finite() {
            return Err(self.not_finite());
        }
        let (k, g) = (self.elasticity.bulk_modulus, self.elasticity.shear_modulus);
        let start = excess / (g + 9.0 * k * cone.friction * cone.dilatancy);
        let at = |x: f64| {
            let cone = self.cone_at(kappa + x / ROOT_3);
            (cone.yield_value(root_j2 - g * x, i1 - 9.0 * k * cone.dilatancy * x), cone)
        };
        let (multiplier, cone) = solve_softening(at, start, excess, root_j2 / g, root_j2)?;
        if root_j2 - g * multiplier >= 0.0 {
            return Ok(Return::Cone { multiplier, cone });
        }
        // The deviatoric strain of the trial becomes plastic.
        let plastic = root_j2 / (g * ROOT_3);
        let cone = self.cone_at(kappa + plastic);
        Ok(Return::Apex { mean: cone.strength / (3.0 * cone.friction), plastic })
    }

    #[cold]
    fn not_finite(&self) -> MaterialError {
        MaterialError::Motion { model: self.name, reason: "the trial stress is not finite" }
    }

    /// The point at the end of a return.
    #[inline]
    fn returned(
        &self,
        trial: &SymTensor,
        invariants: &Invariants,
        end: &Return,
        state: PlasticStrain,
    ) -> Point<PlasticStrain> {
        match *end {
            Return::Elastic => Point { stress: *trial, state },
            Return::Cone { multiplier, cone } => {
                let mean =
                    invariants.i1 / 3.0 - 3.0 * self.elasticity.bulk_modulus * cone.dilatancy * multiplier;
                // `r - G Δλ`, from the yield condition: it then holds to the last digit of the result.
                let kept = (cone.strength - 3.0 * cone.friction * mean).max(0.0);
                let keep = if invariants.root_j2 > 0.0 { kept / invariants.root_j2 } else { 0.0 };
                let state = PlasticStrain { deviatoric: state.deviatoric + multiplier / ROOT_3 };
                Point { stress: invariants.deviator * keep + SymTensor::isotropic(mean), state }
            }
            Return::Apex { mean, plastic } => {
                let state = PlasticStrain { deviatoric: state.deviatoric + plastic };
                Point { stress: SymTensor::isotropic(mean), state }
            }
        }
    }

    /// The step of a law whose cone changes, or by an algorithm of the source.
    #[inline(never)]
    fn changing(
        &self,
        strain: &SymTensor,
        trial: &SymTensor,
        old: &Point<PlasticStrain>,
    ) -> Result<Point<PlasticStrain>, MaterialError> {
        if self.spec.integration != Integration::ClosestPoint {
            return self.step_of_source(strain, trial, old);
        }
        let invariants = Invariants::of(trial);
        let end = self.return_map(&invariants, old.state.deviatoric)?;
        Ok(self.returned(trial, &invariants, &end, old.state))
    }
}

/// Root of `at` between 0, where it is `excess > 0`, and `end`, by secants kept inside a shrinking
/// bracket; beyond `end` (apex) when there is none. Returns the root and the cone there.
fn solve_softening(
    at: impl Fn(f64) -> (f64, Cone),
    start: f64,
    excess: f64,
    end: f64,
    scale: f64,
) -> Result<(f64, Cone), MaterialError> {
    let (at_end, cone) = at(end);
    if at_end > 0.0 {
        return Ok((end * (1.0 + 1e-9) + f64::MIN_POSITIVE, cone));
    }
    let (mut low, mut high) = ((0.0, excess), (end, at_end));
    let mut x = start.clamp(0.0, end);
    for _ in 0..100 {
        let (value, cone) = at(x);
        if value.abs() <= 2.0 * f64::EPSILON * scale || high.0 - low.0 <= f64::EPSILON * end {
            return Ok((x, cone));
        }
        if value > 0.0 {
            low = (x, value);
        } else {
            high = (x, value);
        }
        let slope = 1e-6 * (high.0 - low.0);
        let derivative = (at(x + slope).0 - value) / slope;
        let newton = x - value / derivative;
        x = if newton > low.0 && newton < high.0 { newton } else { 0.5 * (low.0 + high.0) };
    }
    Err(MaterialError::NotConverged { model: NAME, reason: "softening return" })
}

impl SmallStrain for DruckerPrager {
    type State = PlasticStrain;

    fn name(&self) -> &'static str {
        self.name
    }

    fn initial(&self, initial: &InitialCondition) -> Result<Point<PlasticStrain>, MaterialError> {
        let stress = initial.stress;
        let excess = self.peak.yield_value(stress.j2().sqrt(), stress.trace());
        let scale = self.peak.strength + self.peak.friction * stress.trace().abs();
        super::check_initial(self.name, &stress, excess, scale)?;
        Ok(Point { stress, state: PlasticStrain::default() })
    }

    #[inline]
    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<PlasticStrain>,
    ) -> Result<Point<PlasticStrain>, MaterialError> {
        if self.constant && self.spec.integration == Integration::ClosestPoint {
            let (stress, plastic) = self.peak_step(strain, &old.stress);
            return Ok(Point { stress, state: PlasticStrain { deviatoric: old.state.deviatoric + plastic } });
        }
        self.changing(strain, &(old.stress + self.elasticity.stress(strain)), old)
    }

    #[inline]
    fn update_lanes(&self, lanes: &mut Lanes, states: &mut [PlasticStrain]) -> bool {
        if !self.constant || self.spec.integration != Integration::ClosestPoint {
            return false;
        }
        let mut plastic = [0.0; BLOCK];
        lanes.for_each(&mut plastic, |strain, stress| self.peak_step(strain, stress));
        for (state, increment) in states.iter_mut().zip(plastic) {
            state.deviatoric += increment;
        }
        true
    }

    /// Forward steps are held within a share of the yield strain.
    fn largest_step(&self) -> f64 {
        match self.spec.integration {
            Integration::Explicit => {
                (0.5 * self.peak.strength / self.elasticity.shear_modulus).clamp(1e-4, 1e-2)
            }
            _ => 1e-2,
        }
    }

    fn wave_modulus(&self, _point: &Point<PlasticStrain>) -> f64 {
        self.elasticity.p_wave_modulus()
    }

    /// Consistent tangent (sheet §3.10).
    fn tangent(&self, strain: &SymTensor, _motion: &Motion, old: &Point<PlasticStrain>) -> Option<Tangent> {
        if self.spec.integration != Integration::ClosestPoint {
            return None;
        }
        let kappa = old.state.deviatoric;
        let trial = old.stress + self.elasticity.stress(strain);
        let trial = Invariants::of(&trial);
        let Invariants { deviator, root_j2, i1 } = trial;
        match self.return_map(&trial, kappa).ok()? {
            Return::Elastic => Some(self.elasticity.tangent()),
            Return::Apex { plastic, .. } => Some(self.apex_tangent(&deviator, root_j2, kappa + plastic)),
            Return::Cone { multiplier, .. } => {
                Some(self.cone_tangent(&deviator, root_j2, i1, multiplier, kappa))
            }
        }
    }

    fn yield_value(&self, point: &Point<PlasticStrain>) -> Option<f64> {
        let cone = self.cone_at(point.state.deviatoric);
        Some(cone.yield_value(point.stress.j2().sqrt(), point.stress.trace()))
    }

    fn stored_energy(&self, point: &Point<PlasticStrain>) -> Option<f64> {
        Some(self.elasticity.energy(&point.stress))
    }

    fn dissipation(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<PlasticStrain>,
        new: &Point<PlasticStrain>,
    ) -> Option<f64> {
        let trial = old.stress + self.elasticity.stress(strain);
        Some(self.elasticity.dissipation(&trial, &new.stress))
    }

    fn output_names(&self) -> &'static [&'static str] {
        &["plastic_strain"]
    }

    fn outputs(&self, point: &Point<PlasticStrain>, out: &mut [f64]) {
        out[0] = point.state.deviatoric;
    }
}

impl DruckerPrager {
    /// One step by an algorithm of the source. Plastic strain follows the multiplier, at most what the
    /// trial has to give.
    fn step_of_source(
        &self,
        strain: &SymTensor,
        trial: &SymTensor,
        old: &Point<PlasticStrain>,
    ) -> Result<Point<PlasticStrain>, MaterialError> {
        let kappa = old.state.deviatoric;
        let root_j2 = trial.j2().sqrt();
        if !root_j2.is_finite() {
            return Err(MaterialError::Motion { model: self.name, reason: "the trial stress is not finite" });
        }
        let (stress, multiplier) = match self.spec.integration {
            Integration::Explicit => self.forward(&old.stress, strain, kappa),
            _ => self.corrected(trial, kappa),
        };
        // Past the apex the deviator does not turn over.
        let most = root_j2 / self.elasticity.shear_modulus;
        let flipped = stress.deviator().dot(&trial.deviator()) < 0.0;
        let stress = if flipped { SymTensor::isotropic(stress.trace() / 3.0) } else { stress };
        let state = PlasticStrain { deviatoric: kappa + multiplier.min(most) / 3f64.sqrt() };
        Ok(Point { stress: self.without_drift(stress, state.deviatoric), state })
    }

    /// Rate of change of the cone with plastic strain.
    fn cone_rate(&self, kappa: f64) -> Cone {
        if self.constant {
            return Cone::default();
        }
        let step = Softening::difference_step(self.spec.softening, self.spec.dilatancy_decay);
        let (plus, minus) = (self.softened_cone(kappa + step), self.softened_cone(kappa - step));
        let rate = |plus: f64, minus: f64| (plus - minus) / (2.0 * step);
        Cone {
            friction: rate(plus.friction, minus.friction),
            strength: rate(plus.strength, minus.strength),
            dilatancy: rate(plus.dilatancy, minus.dilatancy),
        }
    }

    fn cone_tangent(
        &self,
        deviator: &SymTensor,
        root_j2: f64,
        i1: f64,
        multiplier: f64,
        kappa: f64,
    ) -> Tangent {
        let (k, g) = (self.elasticity.bulk_modulus, self.elasticity.shear_modulus);
        let kappa = kappa + multiplier / 3f64.sqrt();
        let (cone, rate) = (self.cone_at(kappa), self.cone_rate(kappa));
        let alpha = cone.friction;
        // Flow of the mean stress with the multiplier, the decay of dilatancy included.
        let psi = cone.dilatancy + rate.dilatancy * multiplier / 3f64.sqrt();
        let hardening =
            (rate.friction * (i1 - 9.0 * k * cone.dilatancy * multiplier) - rate.strength) / 3f64.sqrt();
        let modulus = g + 9.0 * k * alpha * psi - hardening;
        let theta = 1.0 - g * multiplier / root_j2;
        let n = *deviator * (1.0 / (root_j2 * 2f64.sqrt()));
        let unit = SymTensor::IDENTITY;
        let mut tangent = self.elasticity.deviatoric_tangent(theta);
        tangent.add_dyad(2.0 * g * g * (multiplier / root_j2 - 1.0 / modulus), &n, &n);
        tangent.add_dyad(-3.0 * 2f64.sqrt() * k * g * alpha / modulus, &n, &unit);
        tangent.add_dyad(-3.0 * 2f64.sqrt() * k * g * psi / modulus, &unit, &n);
        tangent.add_dyad(k * (1.0 - 9.0 * k * alpha * psi / modulus), &unit, &unit);
        tangent
    }

    /// At the apex only softening moves the stress.
    fn apex_tangent(&self, deviator: &SymTensor, root_j2: f64, kappa: f64) -> Tangent {
        let mut tangent = Tangent::ZERO;
        if !self.constant && root_j2 > 0.0 {
            let (cone, rate) = (self.cone_at(kappa), self.cone_rate(kappa));
            let slope =
                (rate.strength - cone.strength / cone.friction * rate.friction) / (3.0 * cone.friction);
            let n = *deviator * (1.0 / (root_j2 * 2f64.sqrt()));
            tangent.add_dyad(slope * (2.0 / 3.0f64).sqrt(), &SymTensor::IDENTITY, &n);
        }
        tangent
    }
}

impl PrincipalReturn for DruckerPrager {
    fn elasticity(&self) -> &Elasticity {
        &self.elasticity
    }

    fn return_principal(
        &self,
        trial: [f64; 3],
        state: &PlasticStrain,
    ) -> Result<([f64; 3], PlasticStrain), MaterialError> {
        let [a, b, c] = trial;
        let old = Point { stress: SymTensor::diagonal(a, b, c), state: *state };
        let new = self.update(&SymTensor::ZERO, &Motion::STILL, &old)?;
        Ok(([new.stress[0], new.stress[1], new.stress[2]], new.state))
    }
    fn principal_tangent(&self, trial: [f64; 3], state: &PlasticStrain) -> Option<[[f64; 3]; 3]> {
        let [a, b, c] = trial;
        let old = Point { stress: SymTensor::diagonal(a, b, c), state: *state };
        let Tangent(full) = self.tangent(&SymTensor::ZERO, &Motion::STILL, &old)?;
        Some(std::array::from_fn(|a| std::array::from_fn(|b| full[a][b])))
    }
}
