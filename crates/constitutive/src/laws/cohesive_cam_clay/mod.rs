//! Cohesive Cam Clay for porous brittle solids: snow slabs and weak layers (sheet: constitutive §2.15,
//! §3.7.6; Gaume et al. 2018; Gaume et al. 2020, eqs. 54–58).
//!
//! In Kirchhoff stress `τ` with `p = -tr τ / 3` and `q = √(3/2 s:s)`:
//! `y = (1 + 2β) q² + M² (p + β p0)(p - p0) ≤ 0`, associated flow, linear elasticity in logarithmic strain.
//! Slab: `p0 = K sinh(ξ max(-ε, 0))` with the plastic volumetric strain `ε = ln det F_P`: compaction hardens,
//! dilation softens. Weak layer: an anticrack strain replaces `ε`, which grows by `α |dε|`
//! until it reaches zero; there the layer has collapsed, cohesion and `p0` vanish, and from then on it
//! hardens like a cohesionless slab.
//!
//! The return is implicit in `p0`, or explicit with the `p0` of the start of the step
//! ([`CamClayIntegration`]): Newton's method for plastic volumetric strain and multiplier together, a bracketed solve
//! where it does not converge. A collapse within a step releases the stress;
//! the rest of the trial's compaction compacts the debris, its deviator is lost. With
//! invariants of the plane (`d = 2`) the law is that of two dimensions, see [`StressInvariants`](crate::laws::StressInvariants).
//! Limits: softening has no internal length; where `α ξ cosh(ξ x0) ≥ 1` the weak layer loses its stress at once under controlled strain.

mod batch_newton;
mod bracketed_return;
mod parameters;
mod yield_ellipse;

#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

use super::Elasticity;
use crate::adapters::hencky::{InvariantReturn, ReturnResult, SimdBatch, any_nonzero, select};
use crate::{
    InitialCondition, Law, MaterialError, Motion, Point, PointLaw, PrincipalReturn, SmallStrain, SymTensor,
};

use crate::laws::cohesive_cam_clay::batch_newton::InvariantBatch;
use crate::laws::cohesive_cam_clay::yield_ellipse::HardeningReturn;

pub use crate::laws::cohesive_cam_clay::yield_ellipse::{EllipseReturn, YieldEllipse};
pub use parameters::{CamClayHardening, CamClayIntegration, CohesiveCamClaySpec};

const NAME: &str = "cohesive-cam-clay";

/// Cohesive Cam Clay law, in small strain; [`CohesiveCamClaySpec`] builds it on logarithmic strains. See the module's
/// head for source and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct CohesiveCamClay {
    elasticity: Elasticity,
    spec: CohesiveCamClaySpec,
}

/// Internal variables of [`CohesiveCamClay`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CohesiveCamClayState {
    /// Hardening strain of `p0`: plastic volumetric strain of a slab (less that of the initial `p0`), anticrack strain of a
    /// weak layer; negative where there is strength.
    pub hardening_strain: f64,
    /// Plastic volumetric strain since the start, expansion positive.
    pub volumetric: f64,
    /// Deviatoric plastic strain `∫ √(2/3 dε^p : dε^p)`.
    pub deviatoric: f64,
    /// Whether a weak layer has collapsed.
    pub collapsed: bool,
}

/// Result of the return of a step.
enum ReturnEnd {
    Elastic,
    /// Return to zero stress.
    StressFree,
    Surface(HardeningReturn),
}

impl CohesiveCamClay {
    /// Hardening strain of the initial strength, `-asinh(p0/K)/ξ`.
    pub fn initial_strain(&self) -> f64 {
        let ratio = self.spec.compressive_strength / self.elasticity.bulk_modulus;
        -ratio.asinh() / self.spec.hardening_factor
    }

    /// Compressive strength `p0` (Pa) at a hardening strain, and its slope.
    fn strength(&self, strain: f64) -> (f64, f64) {
        if strain < 0.0 {
            let (k, xi) = (self.elasticity.bulk_modulus, self.spec.hardening_factor);
            let argument = -xi * strain;
            let (sinh, cosh) = if argument < batch_newton::MAX_HYPERBOLIC_ARGUMENT {
                batch_newton::hyperbolic(argument)
            } else {
                (argument.sinh(), argument.cosh())
            };
            (k * sinh, -k * xi * cosh)
        } else {
            (0.0, 0.0)
        }
    }

    /// Yield surface of a state.
    pub fn ellipse(&self, state: &CohesiveCamClayState) -> YieldEllipse {
        YieldEllipse {
            slope: self.spec.critical_state_slope,
            cohesion_ratio: if state.collapsed { 0.0 } else { self.spec.cohesion_ratio },
            strength: self.strength(state.hardening_strain).0,
        }
    }

    /// Anticrack strain per plastic volumetric strain, of a weak layer before its collapse.
    fn softening(&self, state: &CohesiveCamClayState) -> Option<f64> {
        match self.spec.hardening {
            CamClayHardening::WeakLayer { softening_factor } if !state.collapsed => Some(softening_factor),
            _ => None,
        }
    }

    fn hardening_strain_after(&self, state: &CohesiveCamClayState, volumetric: f64) -> f64 {
        let grown = self.softening(state).map_or(volumetric, |factor| factor * volumetric.abs());
        state.hardening_strain + grown
    }

    /// Return at a guess of the plastic volumetric strain.
    fn surface(&self, trial: (f64, f64), state: &CohesiveCamClayState, volumetric: f64) -> HardeningReturn {
        let surface = self.surface_at(trial, state, volumetric);
        let projection = surface.ellipse.return_map(&self.elasticity, trial.0, trial.1);
        HardeningReturn { projection, ..surface }
    }

    /// Surface after the plastic volumetric strain `volumetric`, before any return to it.
    fn surface_at(
        &self,
        trial: (f64, f64),
        state: &CohesiveCamClayState,
        volumetric: f64,
    ) -> HardeningReturn {
        let (strength, slope) = self.strength(self.hardening_strain_after(state, volumetric));
        let rate = self.softening(state).map_or(1.0, |factor| factor * volumetric.signum());
        let ellipse = YieldEllipse { strength, ..self.ellipse(state) };
        let projection = EllipseReturn { pressure: trial.0, q: trial.1, multiplier: 0.0, volumetric: 0.0 };
        HardeningReturn { ellipse, hardening: slope * rate, trial, projection }
    }

    /// Return of a trial `(p, q)` (Pa) and the state after it.
    fn return_map(
        &self,
        trial: (f64, f64),
        state: &CohesiveCamClayState,
    ) -> Result<(ReturnEnd, CohesiveCamClayState), MaterialError> {
        let (mut returns, mut new) = (InvariantBatch::from_trials([trial.0], [trial.1]), [*state]);
        self.return_invariant_batch(&mut returns, &mut new);
        let InvariantBatch {
            pressure: [pressure],
            q: [q],
            volumetric: [volumetric],
            multiplier: [multiplier],
            ..
        } = returns;
        if returns.fallback[0] != 0.0 {
            return self.return_map_bracketed(trial, state);
        }
        if returns.yields[0] == 0.0 {
            return Ok((ReturnEnd::Elastic, *state));
        }
        if multiplier == f64::INFINITY {
            return Ok((ReturnEnd::StressFree, new[0]));
        }
        let projection = EllipseReturn { pressure, q, multiplier, volumetric };
        let surface = match self.spec.integration {
            CamClayIntegration::Implicit => {
                HardeningReturn { projection, ..self.surface_at(trial, state, volumetric) }
            }
            CamClayIntegration::Explicit => {
                HardeningReturn { ellipse: self.ellipse(state), hardening: 0.0, trial, projection }
            }
        };
        Ok((ReturnEnd::Surface(surface), new[0]))
    }
}

impl Law for CohesiveCamClay {
    fn name(&self) -> &'static str {
        NAME
    }

    fn output_names(&self) -> &[&'static str] {
        &["plastic_strain", "plastic_volumetric_strain", "compressive_strength", "collapsed"]
    }
}

impl PointLaw for CohesiveCamClay {
    type State = CohesiveCamClayState;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<CohesiveCamClayState>, MaterialError> {
        let stress = initial.stress;
        let state = CohesiveCamClayState {
            hardening_strain: self.initial_strain(),
            volumetric: 0.0,
            deviatoric: 0.0,
            collapsed: false,
        };
        let ellipse = self.ellipse(&state);
        let (pressure, q) = (stress.pressure(), stress.q());
        if self.spec.return_initial_stress_to_yield && stress.is_finite() {
            let EllipseReturn { pressure, q: kept, .. } = ellipse.return_map(&self.elasticity, pressure, q);
            let share = if q > 0.0 { kept / q } else { 0.0 };
            return Ok(Point { stress: stress.deviator() * share - SymTensor::isotropic(pressure), state });
        }
        super::check_initial(NAME, &stress, ellipse.yield_value(pressure, q), ellipse.radius())?;
        Ok(Point { stress, state })
    }

    fn wave_modulus(&self, _point: &Point<CohesiveCamClayState>) -> f64 {
        self.elasticity.p_wave_modulus()
    }

    fn yield_value(&self, point: &Point<CohesiveCamClayState>) -> Option<f64> {
        Some(self.ellipse(&point.state).yield_value(point.stress.pressure(), point.stress.q()))
    }

    fn linear_elasticity(&self) -> Option<&Elasticity> {
        Some(&self.elasticity)
    }

    fn outputs(&self, point: &Point<CohesiveCamClayState>, out: &mut [f64]) {
        let state = &point.state;
        out[0] = state.deviatoric;
        out[1] = state.volumetric;
        out[2] = self.ellipse(state).strength;
        out[3] = f64::from(u8::from(state.collapsed));
    }
}

impl SmallStrain for CohesiveCamClay {
    #[inline]
    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<CohesiveCamClayState>,
    ) -> Result<Point<CohesiveCamClayState>, MaterialError> {
        let trial = old.stress + self.elasticity.stress(strain);
        let (pressure, q) = (trial.pressure(), trial.q());
        let (landing, state) = self.return_map((pressure, q), &old.state)?;
        let stress = match landing {
            ReturnEnd::Elastic => trial,
            ReturnEnd::StressFree => SymTensor::ZERO,
            ReturnEnd::Surface(HardeningReturn { projection, .. }) => {
                let shrink = if q > 0.0 { projection.q / q } else { 0.0 };
                trial.deviator() * shrink - SymTensor::isotropic(projection.pressure)
            }
        };
        Ok(Point { stress, state })
    }
}

impl PrincipalReturn for CohesiveCamClay {
    fn elasticity(&self) -> &Elasticity {
        &self.elasticity
    }

    fn supports_batch(&self) -> bool {
        true
    }

    #[inline]
    fn return_batch<const N: usize>(&self, few: &mut SimdBatch<N>, states: &mut [CohesiveCamClayState; N]) {
        let mut returns = InvariantBatch::from_trials([0.0; N], [0.0; N]);
        for i in 0..N {
            let stress = few.stress_of(i);
            (returns.pressure[i], returns.q[i]) = (stress.pressure(), stress.q());
        }
        let trial = returns.q;
        self.return_invariant_batch(&mut returns, states);
        few.is_yielding = returns.yields;
        if !any_nonzero(&returns.yields) {
            return;
        }
        for i in 0..N {
            let stress = few.stress_of(i);
            let share = if trial[i] > 0.0 { returns.q[i] / trial[i] } else { 0.0 };
            let returned = stress.deviator() * share - SymTensor::isotropic(returns.pressure[i]);
            let yields = returns.yields[i] != 0.0;
            few.set_stress(i, &select(yields, &returned, &stress));
            few.fallback[i] = few.fallback[i].max(returns.fallback[i]);
        }
    }

    fn return_principal(
        &self,
        trial: [f64; 3],
        state: &CohesiveCamClayState,
    ) -> Result<([f64; 3], CohesiveCamClayState), MaterialError> {
        let [a, b, c] = trial;
        let old = Point { stress: SymTensor::diagonal(a, b, c), state: *state };
        let new = self.update(&SymTensor::ZERO, &Motion::AT_REST, &old)?;
        Ok(([new.stress[0], new.stress[1], new.stress[2]], new.state))
    }

    fn principal_tangent(&self, trial: [f64; 3], state: &CohesiveCamClayState) -> Option<[[f64; 3]; 3]> {
        let [a, b, c] = trial;
        let stress = SymTensor::diagonal(a, b, c);
        let (pressure, q) = (stress.pressure(), stress.q());
        let surface = match self.return_map((pressure, q), state).ok()?.0 {
            ReturnEnd::Elastic => return Some(self.elasticity.principal()),
            ReturnEnd::StressFree => return Some([[0.0; 3]; 3]),
            ReturnEnd::Surface(surface) => surface,
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

impl InvariantReturn for CohesiveCamClay {
    fn return_invariants(
        &self,
        trial: (f64, f64),
        state: &CohesiveCamClayState,
    ) -> ReturnResult<CohesiveCamClayState> {
        let (landing, new) = self.return_map(trial, state)?;
        let end = match landing {
            ReturnEnd::Elastic => None,
            ReturnEnd::StressFree => Some((0.0, 0.0)),
            ReturnEnd::Surface(HardeningReturn { projection, .. }) => {
                Some((projection.pressure, projection.q))
            }
        };
        Ok((end, new))
    }
}
