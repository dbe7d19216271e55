//! Snow that breaks and packs (sheet: constitutive §2.14, §3.7.7; Stomakhin et al. 2013; Gaume et al.
//! 2020, eqs. 46–53).
//!
//! Elasticity `fixed-corotated` (or Hencky's) in the elastic part of `F = F_E F_P`, whose principal
//! stretches are clamped to `1 - θ_c … 1 + θ_s`; the excess becomes plastic and changes
//! `J_P = det F_P`. Moduli depend on it, `μ = μ0 h`, `λ = λ0 h`, `h = exp(ξ (1 - J_P))`: compacted snow gets
//! stiffer, torn snow softer. `J_P` enters `h` between `least_plastic_volume` and
//! `largest_plastic_volume`.
//!
//! State: `b_E - 1` and `J_P`, sufficient for an isotropic law, and `J = J_P √det b_E`. Limits: the
//! clamp is a rule on stretches, not a flow rule: it has no potential, and with stiffening the elastic
//! energy may grow by plastic flow, so no dissipation is defined. Stress at the clamp depends on the
//! stiffness alone: there is no friction angle.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::finite_elastic::{
    PrincipalStress, check_finite, elongations, solve_deformation, updated_left_cauchy_green, volume_change,
};
use super::linear_elastic::{snow_ratio_warnings, text_above};
use super::{Elasticity, FixedCorotated};
use crate::Warning;
use crate::contract::parameter_checks::{check, not_negative, positive};
use crate::contract::tangent::{from_spatial, kirchhoff_tangent, numerical_tangent};
use crate::laws::model::with_defaults;
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::return_maps::substepping::substepped_motion;
use crate::{
    InitialCondition, Law, Mat3, Material, MaterialError, Motion, Point, PointLaw, Spectrum, StressUpdate,
    SymTensor, Tangent,
};

/// Value of the key `model` in case files.
const NAME: &str = "snow";

/// Strain increment above which a step is divided (sheet: constitutive §3.8).
const LARGEST_STEP: f64 = 0.2;

/// Parameters of `snow`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SnowSpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Initial Young's modulus (Pa), positive.
    pub youngs_modulus: f64,
    /// Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Largest principal elastic compression θ_c, between 0 and 1.
    #[serde(default = "critical_compression")]
    pub critical_compression: f64,
    /// Largest principal elastic extension θ_s, positive.
    #[serde(default = "critical_stretch")]
    pub critical_stretch: f64,
    /// Hardening factor ξ of moduli, non-negative.
    #[serde(default = "hardening_factor")]
    pub hardening_factor: f64,
    /// Elastic law of the stretches.
    #[serde(default)]
    pub elastic_law: SnowElasticity,
    /// Lower bound of plastic volume ratio `J_P`, above 0, at most 1; denser snow hardens no further.
    #[serde(default = "least_plastic_volume")]
    pub least_plastic_volume: f64,
    /// Upper bound of plastic volume ratio `J_P`, at least 1; looser snow softens no further.
    #[serde(default = "largest_plastic_volume")]
    pub largest_plastic_volume: f64,
}

// Published defaults (sheet: constitutive §2.14).
/// Default critical compression `θ_c` of the elastic stretches (-).
fn critical_compression() -> f64 {
    0.025
}

/// Default critical stretch `θ_s` of the elastic stretches (-).
fn critical_stretch() -> f64 {
    0.0075
}

/// Default hardening coefficient `ξ` (-).
fn hardening_factor() -> f64 {
    10.0
}

/// Default lower bound of the plastic volume ratio (-).
fn least_plastic_volume() -> f64 {
    0.6
}

/// Default upper bound of the plastic volume ratio (-).
fn largest_plastic_volume() -> f64 {
    20.0
}

/// Elastic law of snow's stretches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SnowElasticity {
    /// `τ_A = 2μ s_A (s_A - 1) + λ J_E (J_E - 1)`, the original.
    #[default]
    FixedCorotated,
    /// `τ_A = 2μ ln s_A + λ ln J_E`.
    Hencky,
}

impl SnowSpec {
    /// Parameters from density (kg/m³), Young's modulus (Pa) and Poisson's ratio (-); all others have the defaults of a case file.
    #[must_use]
    pub fn new(density: f64, youngs_modulus: f64, poissons_ratio: f64) -> Self {
        with_defaults(&[
            ("density", density),
            ("youngs_modulus", youngs_modulus),
            ("poissons_ratio", poissons_ratio),
        ])
    }

    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<Snow, MaterialError> {
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        let compression = self.critical_compression;
        let inside = compression > 0.0 && compression < 1.0;
        check("critical_compression", compression, inside, "is not between 0 and 1 (exclusive)")?;
        positive("critical_stretch", self.critical_stretch, "")?;
        not_negative("hardening_factor", self.hardening_factor, "")?;
        let smallest = self.least_plastic_volume;
        check(
            "least_plastic_volume",
            smallest,
            smallest > 0.0 && smallest <= 1.0,
            "is not in 0..=1 (0 excluded)",
        )?;
        let largest = self.largest_plastic_volume;
        check(
            "largest_plastic_volume",
            largest,
            largest >= 1.0 && largest.is_finite(),
            "must be at least 1",
        )?;
        Ok(Snow { elasticity, spec: self.clone() })
    }
}

impl Model for SnowSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Stomakhin et al. 2013; Gaume et al. 2020, eqs. 46–53",
        kind: ModelFamily::Solid,
        strain: "finite",
        tangent: "analytic",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(Arc::new(self.law()?))
    }

    // Sheet: snow-mpm §7.
    fn warnings(&self) -> Vec<Warning> {
        let mut warnings = snow_ratio_warnings(self.poissons_ratio);
        let usual =
            "snow fails at smaller elastic strains. Usual are 0.025 in compression and 0.0075 in stretch";
        for (name, value) in
            [("critical_compression", self.critical_compression), ("critical_stretch", self.critical_stretch)]
        {
            let text = text_above((name, value, 0.2), usual);
            warnings.extend(text.map(|text| Warning::new("large-elastic-strain", text)));
        }
        let steps =
            "compacted snow becomes so stiff that time steps decrease by orders of magnitude. Usual is 10";
        let text = text_above(("hardening_factor", self.hardening_factor, 30.0), steps);
        warnings.extend(text.map(|text| Warning::new("stiffening-snow", text)));
        warnings
    }

    fn examples() -> Vec<Self> {
        let with = |elastic_law| Self {
            density: 400.0,
            youngs_modulus: 20e6,
            poissons_ratio: 0.2,
            critical_compression: critical_compression(),
            critical_stretch: critical_stretch(),
            hardening_factor: hardening_factor(),
            elastic_law,
            least_plastic_volume: least_plastic_volume(),
            largest_plastic_volume: largest_plastic_volume(),
        };
        [SnowElasticity::FixedCorotated, SnowElasticity::Hencky].map(with).into()
    }
}

/// Snow law. See the module's head for source and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Snow {
    elasticity: Elasticity,
    spec: SnowSpec,
}

/// State of a point of [`Snow`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SnowState {
    /// Elastic left Cauchy–Green tensor minus the unit tensor, `b_E - 1`, which resolves small strains without cancellation.
    pub elastic: SymTensor,
    /// Plastic volume over initial volume, `J_P`.
    pub plastic_volume: f64,
}

/// Stretches of a step after the clamp.
struct ClampedStretches {
    trial: SymTensor,
    spectrum: Spectrum,
    /// Stretches less one after the clamp.
    elongations: [f64; 3],
    /// Directions that were clamped.
    is_clamped: [bool; 3],
    plastic_volume: f64,
}

impl ClampedStretches {
    /// Volume ratio `J`, the product of the plastic and elastic ones.
    fn jacobian(&self) -> f64 {
        self.plastic_volume * (1.0 + volume_change(self.elongations))
    }
}

impl Snow {
    /// Hardening factor of the stiffness, `h = exp(ξ (1 - J_P))`.
    #[inline]
    pub fn hardening(&self, plastic_volume: f64) -> f64 {
        let bounded = plastic_volume.clamp(self.spec.least_plastic_volume, self.spec.largest_plastic_volume);
        (self.spec.hardening_factor * (1.0 - bounded)).exp()
    }

    /// Derivative `dh/d ln J_P` of the hardening factor.
    fn hardening_slope(&self, plastic_volume: f64) -> f64 {
        let bounds = self.spec.least_plastic_volume..=self.spec.largest_plastic_volume;
        if bounds.contains(&plastic_volume) {
            -self.spec.hardening_factor * plastic_volume * self.hardening(plastic_volume)
        } else {
            0.0
        }
    }

    /// Principal Kirchhoff stresses of elastic elongations (stretches minus one) without hardening (Pa).
    #[inline]
    fn principal(&self, elongations: [f64; 3]) -> PrincipalStress {
        match self.spec.elastic_law {
            SnowElasticity::FixedCorotated => {
                FixedCorotated { elasticity: self.elasticity }.principal(elongations)
            }
            SnowElasticity::Hencky => {
                let strains = elongations.map(f64::ln_1p);
                let volumetric = self.elasticity.lame() * strains.iter().sum::<f64>();
                let stress = strains.map(|e| volumetric + 2.0 * self.elasticity.shear_modulus * e);
                PrincipalStress { stress, slope: self.elasticity.principal() }
            }
        }
    }

    /// Clamps the principal stretches of `trial = b_E - 1` to the elastic limits of the snow.
    #[inline]
    fn clamp_stretches(&self, trial: SymTensor, plastic_volume: f64) -> ClampedStretches {
        let (low, high) = (-self.spec.critical_compression, self.spec.critical_stretch);
        let spectrum = trial.spectrum();
        let stretched = elongations(spectrum.values);
        // Round-off of an earlier clamp does not count as flow.
        let fuzz = 4.0 * f64::EPSILON;
        let cut = stretched.map(|e| e < low - fuzz || e > high + fuzz);
        if !cut.contains(&true) {
            return ClampedStretches {
                trial,
                spectrum,
                elongations: stretched,
                is_clamped: cut,
                plastic_volume,
            };
        }
        let elongations: [f64; 3] =
            std::array::from_fn(|a| if cut[a] { stretched[a].clamp(low, high) } else { stretched[a] });
        let taken = (1.0 + volume_change(stretched)) / (1.0 + volume_change(elongations));
        ClampedStretches {
            trial,
            spectrum,
            elongations,
            is_clamped: cut,
            plastic_volume: plastic_volume * taken,
        }
    }

    /// Clamped elastic stretches and plastic volume ratio after a motion.
    fn step(&self, motion: &Motion, state: &SnowState) -> Result<ClampedStretches, MaterialError> {
        Ok(self
            .clamp_stretches(updated_left_cauchy_green(NAME, &state.elastic, motion)?, state.plastic_volume))
    }

    /// Cauchy stress (Pa) and state of clamped elastic stretches.
    fn point(&self, clamped: &ClampedStretches) -> Result<Point<SnowState>, MaterialError> {
        let ClampedStretches { spectrum, elongations, plastic_volume, .. } = clamped;
        let elastic = if clamped.is_clamped.contains(&true) {
            spectrum.compose(elongations.map(|e| e * (2.0 + e)))
        } else {
            clamped.trial
        };
        let scale = self.hardening(*plastic_volume) / clamped.jacobian();
        let stress = spectrum.compose(self.principal(*elongations).stress) * scale;
        Ok(Point {
            stress: check_finite(NAME, stress)?,
            state: SnowState { elastic, plastic_volume: *plastic_volume },
        })
    }

    /// Principal elastic elongations of a state, stretches minus one.
    fn elongations(&self, state: &SnowState) -> [f64; 3] {
        elongations(state.elastic.spectrum().values)
    }
}

impl Law for Snow {
    fn name(&self) -> &'static str {
        NAME
    }

    fn output_names(&self) -> &[&'static str] {
        &["plastic_volume", "hardening"]
    }
}

impl PointLaw for Snow {
    type State = SnowState;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<SnowState>, MaterialError> {
        let elastic = solve_deformation(NAME, &initial.stress, &self.elasticity, |e| self.principal(e))?;
        let clamped = self.clamp_stretches(elastic, 1.0);
        if let Some(a) = clamped.is_clamped.iter().position(|cut| *cut) {
            let [low, high] = [-self.spec.critical_compression, self.spec.critical_stretch];
            let reason = format!(
                "the stress needs an elastic stretch of 1 + {:.4e}, outside 1 + {low} … 1 + {high} (stress {:?} Pa)",
                elongations(clamped.spectrum.values)[a],
                initial.stress.0
            );
            return Err(MaterialError::Initial { model: NAME, reason });
        }
        self.point(&clamped)
    }

    fn wave_modulus(&self, point: &Point<SnowState>) -> f64 {
        let elongations = self.elongations(&point.state);
        let jacobian = point.state.plastic_volume * (1.0 + volume_change(elongations));
        // max (c_AAAA + τ_A) of §3.9, no less than at rest, plus ten per cent for compaction in the step.
        let PrincipalStress { stress, slope } = self.principal(elongations);
        let at_rest = self.elasticity.p_wave_modulus();
        let modulus = (0..3).map(|a| slope[a][a] - stress[a]).fold(at_rest, f64::max);
        1.1 * modulus * self.hardening(point.state.plastic_volume) / jacobian
    }

    /// Yield value (Pa): excess of a stretch over its bound, times the P-wave modulus.
    fn yield_value(&self, point: &Point<SnowState>) -> Option<f64> {
        let (low, high) = (-self.spec.critical_compression, self.spec.critical_stretch);
        let [largest, _, smallest] = self.elongations(&point.state);
        let modulus = self.elasticity.p_wave_modulus() * self.hardening(point.state.plastic_volume);
        Some(modulus * (largest - high).max(low - smallest))
    }

    fn stored_energy(&self, point: &Point<SnowState>) -> Option<f64> {
        let elongations = self.elongations(&point.state);
        let energy = match self.spec.elastic_law {
            SnowElasticity::FixedCorotated => {
                FixedCorotated { elasticity: self.elasticity }.energy(elongations)
            }
            SnowElasticity::Hencky => {
                let strains = elongations.map(f64::ln_1p);
                let stress = self.principal(elongations).stress;
                0.5 * (0..3).map(|a| stress[a] * strains[a]).sum::<f64>()
            }
        };
        let jacobian = point.state.plastic_volume * (1.0 + volume_change(elongations));
        Some(energy * self.hardening(point.state.plastic_volume) / jacobian)
    }

    fn outputs(&self, point: &Point<SnowState>, out: &mut [f64]) {
        out[0] = point.state.plastic_volume;
        out[1] = self.hardening(point.state.plastic_volume);
    }
}

impl StressUpdate for Snow {
    #[inline]
    fn update(&self, motion: &Motion, old: &Point<SnowState>) -> Result<Point<SnowState>, MaterialError> {
        if motion.deformation == Mat3::IDENTITY {
            return Ok(*old);
        }
        let step = |part: &Motion, from: &Point<SnowState>| self.point(&self.step(part, &from.state)?);
        let strain = motion.strain_increment();
        if strain.dot(&strain) <= LARGEST_STEP * LARGEST_STEP {
            return step(motion, old);
        }
        substepped_motion(motion, LARGEST_STEP, old, step)
    }

    /// Consistent tangent: a clamped stretch changes the plastic volume ratio and thereby the moduli.
    fn tangent(&self, motion: &Motion, old: &Point<SnowState>) -> Result<Tangent, MaterialError> {
        if motion.strain_increment().norm() > LARGEST_STEP {
            return numerical_tangent(motion, |m| StressUpdate::update(self, m, old).map(|p| p.stress));
        }
        let clamped = self.step(motion, &old.state)?;
        let PrincipalStress { stress, slope } = self.principal(clamped.elongations);
        let (h, rate) =
            (self.hardening(clamped.plastic_volume), self.hardening_slope(clamped.plastic_volume));
        let block = std::array::from_fn(|a| {
            std::array::from_fn(|b| if clamped.is_clamped[b] { rate * stress[a] } else { h * slope[a][b] })
        });
        let stress = stress.map(|s| h * s);
        let squares = clamped.spectrum.values.map(|b| 1.0 + b);
        let c = kirchhoff_tangent(&clamped.spectrum, stress, squares, &block);
        let jacobian = clamped.jacobian();
        let cauchy = clamped.spectrum.compose(stress) * (1.0 / jacobian);
        let singular = MaterialError::Motion { model: NAME, reason: "the step inverts the point" };
        from_spatial(&c, motion, jacobian, &cauchy).ok_or(singular)
    }
}
