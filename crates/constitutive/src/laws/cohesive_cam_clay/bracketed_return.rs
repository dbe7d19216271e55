//! Return of cohesive Cam Clay by one bracketed unknown, the plastic volumetric strain of the step, with the states that it ends in: on
//! the surface, without stress, and after the collapse of a weak layer.

use crate::MaterialError;
use crate::laws::cohesive_cam_clay::yield_ellipse::{HardeningReturn, ReturnConditions, YieldEllipse};
use crate::laws::cohesive_cam_clay::{
    CamClayIntegration, CohesiveCamClay, CohesiveCamClayState, NAME, ReturnEnd,
};

/// Number of Newton iterations after which the bracketed return only bisects; up to twelve are usual.
const NEWTON: usize = 60;

impl CohesiveCamClay {
    /// Return map like [`CohesiveCamClay::return_map`] with a single bracketed unknown, the plastic volumetric strain of the step. Each
    /// evaluation projects the trial onto an ellipse of fixed size. Also for trials that consume all of the strength.
    pub(super) fn return_map_bracketed(
        &self,
        trial: (f64, f64),
        state: &CohesiveCamClayState,
    ) -> Result<(ReturnEnd, CohesiveCamClayState), MaterialError> {
        let frozen = self.ellipse(state);
        // Round-off of a strain does not count as flow: a weak layer may lose its stress at any overshoot.
        let fuzz = 1e-14 * frozen.slope * self.elasticity.bulk_modulus;
        let excess = frozen.yield_value(trial.0, trial.1);
        if excess <= fuzz {
            return Ok((ReturnEnd::Elastic, *state));
        }
        if !excess.is_finite() {
            return Err(MaterialError::Motion { model: NAME, reason: "the trial stress is not finite" });
        }
        let offered = -trial.0 / self.elasticity.bulk_modulus;
        if self.spec.integration == CamClayIntegration::Explicit {
            return Ok(self.return_map_fixed_strength(&frozen, trial, state, offered));
        }
        let first = frozen.return_map(&self.elasticity, trial.0, trial.1).volumetric;
        // Plastic volumetric strain at which p0 vanishes.
        let end = match self.softening(state) {
            Some(factor) => Some((-state.hardening_strain / factor).copysign(first)),
            None if first >= 0.0 => Some((-state.hardening_strain).max(0.0)),
            // The gap of an earlier dilation must close first.
            None if frozen.strength == 0.0 && offered + state.hardening_strain >= 0.0 => {
                return Ok(self.stress_free_state(trial, state, offered));
            }
            None => None,
        };
        if let Some(end) = end
            && (offered - end) * first.signum() >= 0.0
        {
            return match self.softening(state) {
                Some(_) => self.collapsed_state(trial, state, offered, end),
                None => Ok(self.stress_free_state(trial, state, offered)),
            };
        }
        let bound = end.unwrap_or_else(|| self.sufficient_compaction(trial, state, first));
        let volumetric = self.solve(trial, state, first, bound)?;
        let surface = self.surface(trial, state, volumetric);
        let mut new = *state;
        self.advance(&mut new, volumetric, trial.1 - surface.projection.q);
        Ok((ReturnEnd::Surface(surface), new))
    }

    /// Return to the surface of the start of the step; without strength the stress vanishes.
    fn return_map_fixed_strength(
        &self,
        frozen: &YieldEllipse,
        trial: (f64, f64),
        state: &CohesiveCamClayState,
        offered: f64,
    ) -> (ReturnEnd, CohesiveCamClayState) {
        if frozen.strength == 0.0 {
            return self.stress_free_state(trial, state, offered);
        }
        let projection = frozen.return_map(&self.elasticity, trial.0, trial.1);
        let mut new = *state;
        self.advance(&mut new, projection.volumetric, trial.1 - projection.q);
        (ReturnEnd::Surface(HardeningReturn { ellipse: *frozen, hardening: 0.0, trial, projection }), new)
    }

    /// Stress-free state after a trial strain that is entirely plastic; `offered` is its volumetric part.
    pub(super) fn stress_free_state(
        &self,
        trial: (f64, f64),
        state: &CohesiveCamClayState,
        offered: f64,
    ) -> (ReturnEnd, CohesiveCamClayState) {
        let new = CohesiveCamClayState {
            hardening_strain: state.hardening_strain + offered,
            volumetric: state.volumetric + offered,
            deviatoric: state.deviatoric + trial.1 / (3.0 * self.elasticity.shear_modulus),
            ..*state
        };
        (ReturnEnd::StressFree, new)
    }

    /// State after the collapse of the layer at the plastic volumetric strain `end` (eq. 2.18), without stress and cohesion. The remaining
    /// part of the volumetric strain `offered` opens a gap or compacts the debris.
    pub(super) fn collapsed_state(
        &self,
        trial: (f64, f64),
        state: &CohesiveCamClayState,
        offered: f64,
        end: f64,
    ) -> Result<(ReturnEnd, CohesiveCamClayState), MaterialError> {
        let (_, debris) = self.stress_free_state(trial, state, end);
        let debris = CohesiveCamClayState { hardening_strain: 0.0, collapsed: true, ..debris };
        let left = offered - end;
        let pressure = -self.elasticity.bulk_modulus * left;
        if left >= 0.0 {
            return Ok(self.stress_free_state((pressure, 0.0), &debris, left));
        }
        match self.return_map((pressure, 0.0), &debris)? {
            // Too small to differ from zero.
            (ReturnEnd::Elastic, _) => Ok(self.stress_free_state((pressure, 0.0), &debris, left)),
            returned => Ok(returned),
        }
    }

    /// Upper bound of the plastic compaction of a step, from the return with constant strength. For `β > 1`, where the centre of the
    /// surface moves into tension, it is increased until it is sufficient.
    fn sufficient_compaction(&self, trial: (f64, f64), state: &CohesiveCamClayState, first: f64) -> f64 {
        let mut bound = first;
        for _ in 0..60 {
            if bound <= self.surface(trial, state, bound).projection.volumetric {
                break;
            }
            bound *= 2.0;
        }
        bound
    }

    /// Plastic volumetric strain of the step for which `p0` is that at its end, as a fixed point between zero and `bound`.
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
        for iteration in 0..200 {
            // At zero the sign of a softening's slope is that of the subsequent flow.
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
                let ReturnConditions { flow, yielding } = surface.conditions(&self.elasticity);
                flow[0] - flow[1] * yielding[0] / yielding[1]
            } else {
                1.0
            };
            let newton = x - residual / slope;
            // Near the end round-off of the map may make steps of Newton's method alternate: the bracket is then bisected.
            let inside = newton > low && newton < high && iteration < NEWTON;
            let next = if inside { newton } else { 0.5 * (low + high) };
            if (next - x).abs() <= f64::EPSILON * x.abs() + small {
                return Ok(next);
            }
            x = next;
        }
        Err(MaterialError::NotConverged { model: NAME, reason: "hardening return" })
    }
}
