//! Cohesive Cam Clay for porous brittle solids: snow slabs and weak layers (constitutive sheet §2.15,
//! §3.7.6; Gaume et al. 2018; Gaume et al. 2020, eqs. 54–58).
//!
//! In Kirchhoff stress `τ` with `p = -tr τ / 3` and `q = √(3/2 s:s)`:
//! `y = (1 + 2β) q² + M² (p + β p0)(p - p0) ≤ 0`, associated flow, linear elasticity in logarithmic strain.
//! Slab: `p0 = K sinh(ξ max(-ε, 0))` with the plastic volumetric strain `ε = ln det F_P`: packing hardens,
//! dilation softens. Weak layer: an anticrack strain takes the place of `ε`, which grows by `α |dε|`
//! until it reaches zero; there the layer has collapsed, cohesion and `p0` vanish, and from then on it
//! packs like a cohesionless slab.
//!
//! The return is implicit in `p0`: one bracketed unknown, the plastic volumetric strain of the step,
//! around the projection onto an ellipse of given size. A collapse within a step releases the stress;
//! what is left of the trial's compaction packs the debris, its deviator is lost. Limits: three
//! dimensions and plane strain (`ε_zz` is a member of the state); softening has no length of its own; where
//! `α ξ cosh(ξ x0) ≥ 1` the weak layer snaps, that is, loses its stress at once under controlled strain.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Elasticity;
use super::linear_elastic::stiff_warnings;
use crate::model::{Facts, Kind, Model, not_negative, positive};
use crate::{
    Hencky, InitialCondition, Material, MaterialError, Motion, Point, PrincipalReturn, SmallStrain, SymTensor,
};

const NAME: &str = "cohesive-cam-clay";

/// Parameters of `cohesive-cam-clay`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CohesiveCamClaySpec {
    /// Density (kg/m³), > 0.
    pub density: f64,
    /// Young's modulus (Pa), > 0.
    pub youngs_modulus: f64,
    /// Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Slope `M = q/p` of the critical state without cohesion, > 0.
    pub critical_state_slope: f64,
    /// Isotropic tensile strength over `p0`, β, not negative.
    #[serde(default)]
    pub cohesion_ratio: f64,
    /// Isotropic compressive strength `p0` at the start (Pa), > 0.
    pub compressive_strength: f64,
    /// How fast `p0` follows the plastic volumetric strain, ξ, > 0.
    pub hardening_factor: f64,
    /// What changes `p0`.
    #[serde(default)]
    pub hardening: CamClayHardening,
}

/// What changes the isotropic compressive strength of `cohesive-cam-clay`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum CamClayHardening {
    /// Plastic compaction hardens, plastic dilation softens.
    #[default]
    Slab,
    /// Plastic volume change of either sign softens until the layer collapses; then as the slab, without
    /// cohesion.
    WeakLayer {
        /// Anticrack strain per plastic volumetric strain before the collapse, α, > 0.
        softening_factor: f64,
    },
}

impl CohesiveCamClaySpec {
    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<CohesiveCamClay, MaterialError> {
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        positive("critical_state_slope", self.critical_state_slope, "")?;
        not_negative("cohesion_ratio", self.cohesion_ratio, "")?;
        positive("compressive_strength", self.compressive_strength, "Pa")?;
        positive("hardening_factor", self.hardening_factor, "")?;
        if let CamClayHardening::WeakLayer { softening_factor } = self.hardening {
            positive("hardening.softening_factor", softening_factor, "")?;
        }
        Ok(CohesiveCamClay { elasticity, spec: self.clone() })
    }
}

impl Model for CohesiveCamClaySpec {
    const FACTS: Facts = Facts {
        source: "Gaume et al. 2020, eqs. 54–58",
        kind: Kind::Solid,
        strain: "Hencky",
        tangent: "analytic",
    };

    fn density(&self) -> f64 {
        self.density
    }

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(Arc::new(Hencky(self.law()?)))
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = stiff_warnings(self.poissons_ratio);
        if let (CamClayHardening::WeakLayer { softening_factor }, Ok(law)) = (self.hardening, self.law()) {
            let slope =
                softening_factor * law.strength(law.initial_strain()).1.abs() / law.elasticity.bulk_modulus;
            if slope >= 1.0 {
                warnings.push(format!(
                    "hardening.softening_factor: {softening_factor} makes the weak layer snap (α ξ cosh(ξ x0) = \
                     {slope:.3}, stable below 1)"
                ));
            }
        }
        warnings
    }

    fn examples() -> Vec<Self> {
        let with = |hardening_factor, hardening| Self {
            density: 250.0,
            youngs_modulus: 20e6,
            poissons_ratio: 0.3,
            critical_state_slope: 0.8,
            cohesion_ratio: 0.1,
            compressive_strength: 200e3,
            hardening_factor,
            hardening,
        };
        vec![
            with(10.0, CamClayHardening::Slab),
            with(0.5, CamClayHardening::WeakLayer { softening_factor: 1.0 }),
            with(1.0, CamClayHardening::WeakLayer { softening_factor: 3.0 }),
        ]
    }
}

/// The yield surface at some compressive strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// Slope `M`.
    pub slope: f64,
    /// Cohesion ratio `β`.
    pub cohesion_ratio: f64,
    /// Isotropic compressive strength `p0` (Pa).
    pub strength: f64,
}

/// Where a projection onto an [`Ellipse`] ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Mean pressure (Pa).
    pub pressure: f64,
    /// Deviatoric stress `q` (Pa).
    pub q: f64,
    /// Plastic multiplier `Δγ` of `y` (1/Pa); infinite where the surface is a point.
    pub multiplier: f64,
    /// Plastic volumetric strain of the step, expansion positive.
    pub volumetric: f64,
}

impl Ellipse {
    fn centre(&self) -> f64 {
        0.5 * (1.0 - self.cohesion_ratio) * self.strength
    }

    /// `M` times the half axis along `p`.
    fn radius(&self) -> f64 {
        0.5 * self.slope * (1.0 + self.cohesion_ratio) * self.strength
    }

    /// `1 + 2β`.
    fn flattening(&self) -> f64 {
        1.0 + 2.0 * self.cohesion_ratio
    }

    /// `√((1 + 2β) q² + M² (p - p_c)²) - M a` with centre `p_c` and half axis `a`: a stress (Pa) of the same
    /// sign as `y`, which is its product with the sum of the two terms.
    #[inline]
    pub fn yield_value(&self, pressure: f64, q: f64) -> f64 {
        (self.flattening().sqrt() * q).hypot(self.slope * (pressure - self.centre())) - self.radius()
    }

    /// Decay of `M (p - p_c)` and of `√(1 + 2β) q` with the multiplier.
    fn rates(&self, elasticity: &Elasticity) -> (f64, f64) {
        (
            2.0 * elasticity.bulk_modulus * self.slope * self.slope,
            6.0 * elasticity.shear_modulus * self.flattening(),
        )
    }

    /// Associated return of a trial at fixed size (sheet §3.7.6); a trial inside stays.
    pub fn return_map(&self, elasticity: &Elasticity, pressure: f64, q: f64) -> Projection {
        // Also where the strength is beyond all numbers.
        if !(self.yield_value(pressure, q) > 0.0) {
            return Projection { pressure, q, multiplier: 0.0, volumetric: 0.0 };
        }
        let radius = self.radius();
        if radius == 0.0 {
            let volumetric = -pressure / elasticity.bulk_modulus;
            return Projection { pressure: 0.0, q: 0.0, multiplier: f64::INFINITY, volumetric };
        }
        let (a, b) = self.rates(elasticity);
        let (x, y) = (self.slope * (pressure - self.centre()), self.flattening().sqrt() * q);
        // From below the root of 1/‖v(γ)‖ = 1/radius, which is nearly linear and concave in γ.
        let mut gamma = ((x.abs() / radius - 1.0) / a)
            .max((y / radius - 1.0) / b)
            .max((x.hypot(y) / radius - 1.0) / a.max(b))
            .max(0.0);
        for _ in 0..50 {
            let (u, v) = (1.0 + a * gamma, 1.0 + b * gamma);
            let (x, y) = (x / u, y / v);
            let norm = x.hypot(y);
            let step = (norm - radius) * norm * norm / (radius * (a * x * x / u + b * y * y / v));
            gamma += step;
            // Written so that NaN ends it.
            if !(step.abs() > 2.0 * f64::EPSILON * gamma) {
                break;
            }
        }
        let u = 1.0 + a * gamma;
        let change = -(pressure - self.centre()) * (a * gamma / u);
        Projection {
            pressure: self.centre() + x / (self.slope * u),
            q: q / (1.0 + b * gamma),
            multiplier: gamma,
            volumetric: change / elasticity.bulk_modulus,
        }
    }
}

/// The law, in small strain; [`CohesiveCamClaySpec`] builds it on logarithmic strains. See the module's
/// head for source and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct CohesiveCamClay {
    elasticity: Elasticity,
    spec: CohesiveCamClaySpec,
}

/// Internal variables of [`CohesiveCamClay`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CohesiveCamClayState {
    /// What `p0` follows: plastic volumetric strain of a slab (less that which gives the initial `p0`), of a
    /// weak layer its anticrack strain; negative where there is strength.
    pub hardening_strain: f64,
    /// Plastic volumetric strain since the start, expansion positive.
    pub volumetric: f64,
    /// `∫ √(2/3 dε^p : dε^p)` of the deviatoric plastic strain.
    pub deviatoric: f64,
    /// True for a weak layer after its collapse.
    pub collapsed: bool,
}

/// Where a step ends.
enum Landing {
    Elastic,
    /// Without stress.
    Free,
    Surface(Surface),
}

/// A return to the surface of the end of the step.
struct Surface {
    ellipse: Ellipse,
    /// `dp0/dx` with the plastic volumetric strain `x` of the step (Pa).
    hardening: f64,
    /// Trial pressure and deviatoric stress (Pa).
    trial: (f64, f64),
    projection: Projection,
}

/// Derivatives of the two conditions of a return, on flow and on yield, with respect to the plastic
/// volumetric strain `x`, the multiplier `γ`, and the trial's `p` and `q`.
struct Conditions {
    flow: [f64; 4],
    yielding: [f64; 4],
}

impl Surface {
    fn conditions(&self, elasticity: &Elasticity) -> Conditions {
        let (slope, k) = (self.ellipse.slope, elasticity.bulk_modulus);
        let beta = self.ellipse.cohesion_ratio;
        let (a, b) = self.ellipse.rates(elasticity);
        let gamma = self.projection.multiplier;
        let (u, v) = (1.0 + a * gamma, 1.0 + b * gamma);
        let taken = a * gamma / u;
        let (distance, root) = (self.trial.0 - self.ellipse.centre(), self.ellipse.flattening().sqrt());
        let (x, y) = (slope * distance / u, root * self.trial.1 / v);
        let centre = 0.5 * (1.0 - beta) * self.hardening;
        let radius = 0.5 * slope * (1.0 + beta) * self.hardening;
        Conditions {
            flow: [1.0 - centre * taken / k, distance * a / (k * u * u), taken / k, 0.0],
            yielding: [
                -x * slope * centre / u - self.ellipse.radius() * radius,
                -a * x * x / u - b * y * y / v,
                x * slope / u,
                y * root / v,
            ],
        }
    }

    /// `∂(p, q)/∂(p, q)` of the trial, by the implicit-function theorem.
    fn slopes(&self, elasticity: &Elasticity) -> [[f64; 2]; 2] {
        let Conditions { flow, yielding } = self.conditions(elasticity);
        let (_, b) = self.ellipse.rates(elasticity);
        let v = 1.0 + b * self.projection.multiplier;
        let determinant = flow[0] * yielding[1] - flow[1] * yielding[0];
        let columns: [(f64, f64); 2] = [2, 3].map(|c| {
            let strain = -(flow[c] * yielding[1] - flow[1] * yielding[c]) / determinant;
            let multiplier = -(flow[0] * yielding[c] - yielding[0] * flow[c]) / determinant;
            (elasticity.bulk_modulus * strain, -self.projection.q * b / v * multiplier)
        });
        [[1.0 + columns[0].0, columns[1].0], [columns[0].1, 1.0 / v + columns[1].1]]
    }
}

impl CohesiveCamClay {
    /// The hardening strain of the initial strength, `-asinh(p0/K)/ξ`.
    pub fn initial_strain(&self) -> f64 {
        let ratio = self.spec.compressive_strength / self.elasticity.bulk_modulus;
        -ratio.asinh() / self.spec.hardening_factor
    }

    /// Compressive strength `p0` (Pa) at a hardening strain, and its slope.
    fn strength(&self, strain: f64) -> (f64, f64) {
        if strain < 0.0 {
            let (k, xi) = (self.elasticity.bulk_modulus, self.spec.hardening_factor);
            (k * (-xi * strain).sinh(), -k * xi * (xi * strain).cosh())
        } else {
            (0.0, 0.0)
        }
    }

    /// The yield surface of a state.
    pub fn ellipse(&self, state: &CohesiveCamClayState) -> Ellipse {
        Ellipse {
            slope: self.spec.critical_state_slope,
            cohesion_ratio: if state.collapsed { 0.0 } else { self.spec.cohesion_ratio },
            strength: self.strength(state.hardening_strain).0,
        }
    }

    /// Anticrack strain per plastic volumetric strain, of a weak layer that still stands.
    fn softening(&self, state: &CohesiveCamClayState) -> Option<f64> {
        match self.spec.hardening {
            CamClayHardening::WeakLayer { softening_factor } if !state.collapsed => Some(softening_factor),
            _ => None,
        }
    }

    fn hardened(&self, state: &CohesiveCamClayState, volumetric: f64) -> f64 {
        let grown = self.softening(state).map_or(volumetric, |factor| factor * volumetric.abs());
        state.hardening_strain + grown
    }

    /// The return at a guess of the plastic volumetric strain.
    fn surface(&self, trial: (f64, f64), state: &CohesiveCamClayState, volumetric: f64) -> Surface {
        let (strength, slope) = self.strength(self.hardened(state, volumetric));
        let rate = self.softening(state).map_or(1.0, |factor| factor * volumetric.signum());
        let ellipse = Ellipse { strength, ..self.ellipse(state) };
        let projection = ellipse.return_map(&self.elasticity, trial.0, trial.1);
        Surface { ellipse, hardening: slope * rate, trial, projection }
    }

    /// Return of a trial `(p, q)` (Pa): where it ends, and the state there.
    fn land(
        &self,
        trial: (f64, f64),
        state: &CohesiveCamClayState,
    ) -> Result<(Landing, CohesiveCamClayState), MaterialError> {
        let frozen = self.ellipse(state);
        // Round-off of a strain is not flow: a weak layer may snap at any overshoot.
        let fuzz = 1e-14 * frozen.slope * self.elasticity.bulk_modulus;
        let excess = frozen.yield_value(trial.0, trial.1);
        if excess <= fuzz {
            return Ok((Landing::Elastic, *state));
        }
        if !excess.is_finite() {
            return Err(MaterialError::Motion { model: NAME, reason: "the trial stress is not finite" });
        }
        let offered = -trial.0 / self.elasticity.bulk_modulus;
        let first = frozen.return_map(&self.elasticity, trial.0, trial.1).volumetric;
        // Plastic volumetric strain at which nothing of p0 is left.
        let end = match self.softening(state) {
            Some(factor) => Some((-state.hardening_strain / factor).copysign(first)),
            None if first >= 0.0 => Some((-state.hardening_strain).max(0.0)),
            // The gap of an earlier dilation must close first.
            None if frozen.strength == 0.0 && offered + state.hardening_strain >= 0.0 => {
                return Ok(self.freed(trial, state, offered));
            }
            None => None,
        };
        if let Some(end) = end
            && (offered - end) * first.signum() >= 0.0
        {
            return match self.softening(state) {
                Some(_) => self.collapsed(trial, state, offered, end),
                None => Ok(self.freed(trial, state, offered)),
            };
        }
        let bound = end.unwrap_or_else(|| self.enough_packing(trial, state, first));
        let volumetric = self.solve(trial, state, first, bound)?;
        let surface = self.surface(trial, state, volumetric);
        let Projection { q, .. } = surface.projection;
        let new = CohesiveCamClayState {
            hardening_strain: self.hardened(state, volumetric),
            volumetric: state.volumetric + volumetric,
            deviatoric: state.deviatoric + (trial.1 - q) / (3.0 * self.elasticity.shear_modulus),
            ..*state
        };
        Ok((Landing::Surface(surface), new))
    }

    /// All of the trial strain, `offered` of it volumetric, is plastic; no stress is left.
    fn freed(
        &self,
        trial: (f64, f64),
        state: &CohesiveCamClayState,
        offered: f64,
    ) -> (Landing, CohesiveCamClayState) {
        let new = CohesiveCamClayState {
            hardening_strain: state.hardening_strain + offered,
            volumetric: state.volumetric + offered,
            deviatoric: state.deviatoric + trial.1 / (3.0 * self.elasticity.shear_modulus),
            ..*state
        };
        (Landing::Free, new)
    }

    /// The layer collapses after the plastic volumetric strain `end` (eq. 2.18): no stress, no cohesion;
    /// what is left of the volumetric strain `offered` opens a gap or packs the debris.
    fn collapsed(
        &self,
        trial: (f64, f64),
        state: &CohesiveCamClayState,
        offered: f64,
        end: f64,
    ) -> Result<(Landing, CohesiveCamClayState), MaterialError> {
        let (_, debris) = self.freed(trial, state, end);
        let debris = CohesiveCamClayState { hardening_strain: 0.0, collapsed: true, ..debris };
        let left = offered - end;
        let pressure = -self.elasticity.bulk_modulus * left;
        if left >= 0.0 {
            return Ok(self.freed((pressure, 0.0), &debris, left));
        }
        match self.land((pressure, 0.0), &debris)? {
            // Too little to tell from nothing.
            (Landing::Elastic, _) => Ok(self.freed((pressure, 0.0), &debris, left)),
            landed => Ok(landed),
        }
    }

    /// A compaction that hardens more than the return asks for, from that at frozen strength: enough by
    /// itself unless the centre of the surface moves into tension as it grows, that is for `β > 1`.
    fn enough_packing(&self, trial: (f64, f64), state: &CohesiveCamClayState, first: f64) -> f64 {
        let mut bound = first;
        for _ in 0..60 {
            if bound <= self.surface(trial, state, bound).projection.volumetric {
                break;
            }
            bound *= 2.0;
        }
        bound
    }

    /// The plastic volumetric strain that reproduces itself when `p0` is taken at its end, between nothing
    /// and `bound`: Newton's method kept inside a shrinking bracket.
    fn solve(
        &self,
        trial: (f64, f64),
        state: &CohesiveCamClayState,
        first: f64,
        bound: f64,
    ) -> Result<f64, MaterialError> {
        let (mut low, mut high) = if first < 0.0 { (bound, 0.0) } else { (0.0, bound) };
        let small = 0.1 * f64::EPSILON * (trial.0.abs() + trial.1) / self.elasticity.bulk_modulus;
        let mut x = 0.0;
        for _ in 0..200 {
            // At nothing the sign of a softening's slope is that of the flow to come.
            let side = if x == 0.0 { f64::MIN_POSITIVE.copysign(first) } else { x };
            let surface = self.surface(trial, state, side);
            let mapped = surface.projection.volumetric;
            let residual = x - mapped;
            if residual.abs() <= f64::EPSILON * x.abs() + small {
                return Ok(x);
            }
            if residual < 0.0 {
                low = x;
            } else {
                high = x;
            }
            let gamma = surface.projection.multiplier;
            let slope = if gamma > 0.0 && gamma.is_finite() {
                let Conditions { flow, yielding } = surface.conditions(&self.elasticity);
                flow[0] - flow[1] * yielding[0] / yielding[1]
            } else {
                1.0
            };
            let newton = x - residual / slope;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - x).abs() <= f64::EPSILON * x.abs() + small {
                return Ok(next);
            }
            x = next;
        }
        Err(MaterialError::NotConverged { model: NAME, reason: "hardening return" })
    }
}

impl SmallStrain for CohesiveCamClay {
    type State = CohesiveCamClayState;

    fn name(&self) -> &'static str {
        NAME
    }

    fn initial(&self, initial: &InitialCondition) -> Result<Point<CohesiveCamClayState>, MaterialError> {
        let stress = initial.stress;
        let state = CohesiveCamClayState {
            hardening_strain: self.initial_strain(),
            volumetric: 0.0,
            deviatoric: 0.0,
            collapsed: false,
        };
        let ellipse = self.ellipse(&state);
        let excess = ellipse.yield_value(stress.pressure(), stress.q());
        super::check_initial(NAME, &stress, excess, ellipse.radius())?;
        Ok(Point { stress, state })
    }

    #[inline]
    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<CohesiveCamClayState>,
    ) -> Result<Point<CohesiveCamClayState>, MaterialError> {
        let trial = old.stress + self.elasticity.stress(strain);
        let (pressure, q) = (trial.pressure(), trial.q());
        let (landing, state) = self.land((pressure, q), &old.state)?;
        let stress = match landing {
            Landing::Elastic => trial,
            Landing::Free => SymTensor::ZERO,
            Landing::Surface(Surface { projection, .. }) => {
                let shrink = if q > 0.0 { projection.q / q } else { 0.0 };
                trial.deviator() * shrink - SymTensor::isotropic(projection.pressure)
            }
        };
        Ok(Point { stress, state })
    }

    fn wave_modulus(&self, _point: &Point<CohesiveCamClayState>) -> f64 {
        self.elasticity.p_wave_modulus()
    }

    fn yield_value(&self, point: &Point<CohesiveCamClayState>) -> Option<f64> {
        Some(self.ellipse(&point.state).yield_value(point.stress.pressure(), point.stress.q()))
    }

    fn stored_energy(&self, point: &Point<CohesiveCamClayState>) -> Option<f64> {
        Some(self.elasticity.energy(&point.stress))
    }

    fn dissipation(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<CohesiveCamClayState>,
        new: &Point<CohesiveCamClayState>,
    ) -> Option<f64> {
        let trial = old.stress + self.elasticity.stress(strain);
        Some(self.elasticity.dissipation(&trial, &new.stress))
    }

    fn output_names(&self) -> &'static [&'static str] {
        &["plastic_strain", "plastic_volumetric_strain", "compressive_strength", "collapsed"]
    }

    fn outputs(&self, point: &Point<CohesiveCamClayState>, out: &mut [f64]) {
        let state = &point.state;
        out[0] = state.deviatoric;
        out[1] = state.volumetric;
        out[2] = self.ellipse(state).strength;
        out[3] = f64::from(u8::from(state.collapsed));
    }
}

impl PrincipalReturn for CohesiveCamClay {
    fn elasticity(&self) -> &Elasticity {
        &self.elasticity
    }

    fn return_principal(
        &self,
        trial: [f64; 3],
        state: &CohesiveCamClayState,
    ) -> Result<([f64; 3], CohesiveCamClayState), MaterialError> {
        let [a, b, c] = trial;
        let old = Point { stress: SymTensor::diagonal(a, b, c), state: *state };
        let new = self.update(&SymTensor::ZERO, &Motion::STILL, &old)?;
        Ok(([new.stress[0], new.stress[1], new.stress[2]], new.state))
    }

    fn principal_tangent(&self, trial: [f64; 3], state: &CohesiveCamClayState) -> Option<[[f64; 3]; 3]> {
        let [a, b, c] = trial;
        let stress = SymTensor::diagonal(a, b, c);
        let (pressure, q) = (stress.pressure(), stress.q());
        let surface = match self.land((pressure, q), state).ok()?.0 {
            Landing::Elastic => return Some(self.elasticity.principal()),
            Landing::Free => return Some([[0.0; 3]; 3]),
            Landing::Surface(surface) => surface,
        };
        let (k, mu) = (self.elasticity.bulk_modulus, self.elasticity.shear_modulus);
        let [[pp, pq], [qp, qq]] = surface.slopes(&self.elasticity);
        // The debris of a collapse in the step has lost the deviator of the trial.
        let kept = if surface.trial.1 == 0.0 && q > 0.0 { 0.0 } else { 1.0 };
        let (_, rate) = surface.ellipse.rates(&self.elasticity);
        let shrink = kept / (1.0 + rate * surface.projection.multiplier);
        let s = stress.deviator();
        let direction = |i: usize| if q > 0.0 { kept * s[i] / (q * (2.0f64 / 3.0).sqrt()) } else { 0.0 };
        let (two_mu, root6_mu, root23) = (2.0 * mu, 6f64.sqrt() * mu, (2.0f64 / 3.0).sqrt());
        Some(std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let (ni, nj) = (direction(i), direction(j));
                let unit = if i == j { 1.0 } else { 0.0 };
                pp * k - pq * root6_mu * nj
                    + shrink * two_mu * (unit - 1.0 / 3.0)
                    + root23 * ni * ((qq - shrink) * root6_mu * nj - qp * k)
            })
        }))
    }
}
