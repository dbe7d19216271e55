//! Return of several trials at once: Newton's method for plastic volumetric strain and multiplier together (sheet:
//! snow-mpm §3.9). Returns that do not converge fall back to the bracketed solve.

use crate::adapters::hencky::any_nonzero;

use crate::laws::cohesive_cam_clay::{CamClayIntegration, CohesiveCamClay, CohesiveCamClayState};

/// Largest number of iterations before the bracketed solve; three to five are usual.
const ITERATIONS: usize = 14;

/// Relative change of stress in an iteration at which it ends. As convergence is quadratic, the next change would be below round-off.
const CONVERGENCE_TOLERANCE: f64 = 3e-8;

/// Largest argument `ξ max(-ε, 0)` of the series of the hyperbolic functions.
pub(super) const MAX_HYPERBOLIC_ARGUMENT: f64 = 4.0;

/// Ratios of consecutive terms of the power series of `sinh x / x` and of `cosh x`, in reversed order.
const SERIES: [[f64; 2]; 7] = {
    let mut quotients = [[0.0; 2]; 7];
    let mut i = 0;
    while i < 7 {
        let k = (14 - 2 * i) as f64;
        quotients[i] = [1.0 / (k * (k + 1.0)), 1.0 / (k * (k - 1.0))];
        i += 1;
    }
    quotients
};

/// Computes `sinh` and `cosh` of `0 <= x <= 4`, accurate to a few units of round-off, without branches.
#[inline(always)]
pub(super) fn hyperbolic(x: f64) -> (f64, f64) {
    let r = 0.125 * x;
    let r2 = r * r;
    let (mut s, mut c) = (1.0, 1.0);
    for k in 0..SERIES.len() {
        let [by_sinh, by_cosh] = SERIES[k];
        (s, c) = (1.0 + s * (r2 * by_sinh), 1.0 + c * (r2 * by_cosh));
    }
    let (mut s, mut c) = (r * s, c);
    for _ in 0..3 {
        (s, c) = (2.0 * s * c, 1.0 + 2.0 * s * s);
    }
    (s, c)
}

/// Trials in invariants, replaced by their returns.
pub(super) struct InvariantBatch<const N: usize> {
    /// Mean pressure (Pa), trial at first.
    pub(super) pressure: [f64; N],
    /// Deviatoric stress `q` (Pa), trial at first.
    pub(super) q: [f64; N],
    /// Plastic volumetric strain of the step.
    pub(super) volumetric: [f64; N],
    /// Plastic multiplier (1/Pa); infinite where the stress vanishes.
    pub(super) multiplier: [f64; N],
    /// Flag of each point: 1 if the trial yields, else 0.
    pub(super) yields: [f64; N],
    /// Flag of each point: 1 if the return needs the bracketed solve, else 0.
    pub(super) fallback: [f64; N],
}

impl<const N: usize> InvariantBatch<N> {
    /// Batch of trial pressures and deviatoric stresses (Pa), before their return to the yield surface.
    pub(super) fn from_trials(pressure: [f64; N], q: [f64; N]) -> Self {
        let zero = [0.0; N];
        Self { pressure, q, volumetric: zero, multiplier: zero, yields: zero, fallback: zero }
    }
}

/// Constants of the iteration, equal for all points of a material.
#[derive(Clone, Copy)]
struct NewtonConstants {
    slope: f64,
    cohesion_ratio: f64,
    bulk: f64,
    factor: f64,
    yield_tolerance: f64,
    /// Rates `2 K M²` and `6 μ`.
    rates: (f64, f64),
    implicit: f64,
}

/// Data of a point during the iteration.
#[derive(Clone, Copy)]
struct NewtonPoint {
    /// Trial pressure (Pa).
    pressure: f64,
    /// Trial deviatoric stress times `√(1 + 2β)` (Pa).
    scaled_q: f64,
    /// Hardening strain `-ε` or its equivalent at the start.
    strain: f64,
    /// Cohesion ratio of the point.
    cohesion: f64,
    /// Hardening strain per plastic volumetric strain and its sign: `a x + b |x|`.
    by_volume: f64,
    by_size: f64,
}

/// Unknowns and derivatives of the Newton iteration at several points, in one array per quantity.
struct NewtonPoints<const N: usize> {
    pressure: [f64; N],
    q: [f64; N],
    strain: [f64; N],
    cohesion: [f64; N],
    /// Factor `√(1 + 2β)`.
    root: [f64; N],
    by_volume: [f64; N],
    by_size: [f64; N],
}

impl<const N: usize> NewtonPoints<N> {
    /// Values of the Newton iteration at point `i`.
    #[inline(always)]
    fn point(&self, i: usize) -> NewtonPoint {
        NewtonPoint {
            pressure: self.pressure[i],
            scaled_q: self.root[i] * self.q[i],
            strain: self.strain[i],
            cohesion: self.cohesion[i],
            by_volume: self.by_volume[i],
            by_size: self.by_size[i],
        }
    }
}

/// Centre and radius of the yield surface at the start of the step, and position of a trial stress relative to them.
struct TrialDistance {
    centre: f64,
    radius: f64,
    x: f64,
    norm: f64,
}

/// Values of the two conditions at an iterate.
struct ConditionValues {
    centre: f64,
    radius: f64,
    x: f64,
    y: f64,
    norm: f64,
    /// Decay of `x` and `y` with the multiplier.
    decay: [f64; 2],
    flow: [f64; 3],
    yielding: [f64; 3],
}

impl NewtonConstants {
    /// Strength `p0` (Pa) and its slope with the hardening strain.
    #[inline(always)]
    fn strength(&self, strain: f64) -> (f64, f64) {
        let (s, c) = hyperbolic(self.factor * (-strain).max(0.0).min(MAX_HYPERBOLIC_ARGUMENT / self.factor));
        (self.bulk * s, if strain < 0.0 { -self.bulk * self.factor * c } else { 0.0 })
    }

    /// Distance of a trial from the surface at the start of the step.
    #[inline(always)]
    fn trial_distance(&self, point: &NewtonPoint) -> TrialDistance {
        let (p0, _) = self.strength(point.strain);
        let centre = 0.5 * (1.0 - point.cohesion) * p0;
        let radius = 0.5 * self.slope * (1.0 + point.cohesion) * p0;
        let (x, y) = (self.slope * (point.pressure - centre), point.scaled_q);
        TrialDistance { centre, radius, x, norm: (x * x + y * y).sqrt() }
    }

    /// Computes value and derivatives (by volumetric strain and multiplier) of the flow rule and of the yield condition.
    #[inline(always)]
    fn condition_values(&self, point: &NewtonPoint, volumetric: f64, gamma: f64) -> ConditionValues {
        let beta = point.cohesion;
        let rate = self.implicit * (point.by_volume + point.by_size * volumetric.signum());
        let (p0, slope) = self.strength(point.strain + rate * volumetric);
        let hardening = slope * rate;
        let half = 0.5 * (1.0 - beta);
        let (centre, moves) = (half * p0, half * hardening);
        let across = 0.5 * self.slope * (1.0 + beta);
        let (radius, grows) = (across * p0, across * hardening);
        let flattening = 1.0 + 2.0 * beta;
        let (a, b) = (self.rates.0, self.rates.1 * flattening);
        let (u, v) = (1.0 / (1.0 + a * gamma), 1.0 / (1.0 + b * gamma));
        let distance = point.pressure - centre;
        let (x, y) = (self.slope * distance * u, point.scaled_q * v);
        let norm = (x * x + y * y).sqrt();
        let inverse = 1.0 / norm;
        let ratio = radius * inverse;
        let taken = a * gamma * u;
        ConditionValues {
            centre,
            radius,
            x,
            y,
            norm,
            decay: [u, v],
            flow: [
                self.bulk * volumetric + distance * taken,
                self.bulk - moves * taken,
                distance * a * u * u,
            ],
            yielding: [
                norm - radius,
                -grows - ratio * (x * inverse) * self.slope * moves * u,
                -ratio * (a * x * x * u + b * y * y * v) * inverse,
            ],
        }
    }
}

impl CohesiveCamClay {
    /// Constants of the return map that all points of the material have in common.
    fn constants(&self) -> NewtonConstants {
        let (slope, bulk) = (self.spec.critical_state_slope, self.elasticity.bulk_modulus);
        NewtonConstants {
            slope,
            cohesion_ratio: self.spec.cohesion_ratio,
            bulk,
            factor: self.spec.hardening_factor,
            yield_tolerance: 1e-14 * slope * bulk,
            rates: (2.0 * bulk * slope * slope, 6.0 * self.elasticity.shear_modulus),
            implicit: match self.spec.integration {
                CamClayIntegration::Implicit => 1.0,
                CamClayIntegration::Explicit => 0.0,
            },
        }
    }

    /// Returns trial invariants to the yield surface and updates the states of the points that yield. Points that need the bracketed solve
    /// are unchanged.
    #[inline(always)]
    pub(super) fn return_invariant_batch<const N: usize>(
        &self,
        returns: &mut InvariantBatch<N>,
        states: &mut [CohesiveCamClayState; N],
    ) {
        let constants = self.constants();
        let points = self.start(returns, states);
        Self::find_yielding(&constants, &points, returns);
        if !any_nonzero(&returns.yields) {
            return;
        }
        let active = Self::initial_guess(&constants, &points, returns);
        if any_nonzero(&active) {
            Self::iterate(&constants, &points, returns, active);
        }
        Self::compute_stresses(&constants, &points, returns);
        for i in 0..N {
            if returns.yields[i] != 0.0 && returns.fallback[i] == 0.0 {
                self.advance(&mut states[i], returns.volumetric[i], points.q[i] - returns.q[i]);
            }
        }
    }

    /// Updates the state after a return with the plastic strain `volumetric` and the loss `lost` (Pa) of deviatoric stress.
    pub(super) fn advance(&self, state: &mut CohesiveCamClayState, volumetric: f64, lost: f64) {
        state.hardening_strain = self.hardening_strain_after(state, volumetric);
        state.volumetric += volumetric;
        state.deviatoric += lost / (3.0 * self.elasticity.shear_modulus);
        // Only with explicit integration: a return with hardening ends before.
        if self.softening(state).is_some() && state.hardening_strain >= 0.0 {
            state.hardening_strain = 0.0;
            state.collapsed = true;
        }
    }

    /// Initial values of the Newton iteration: the trial invariants with zero plastic strain.
    #[inline(always)]
    fn start<const N: usize>(
        &self,
        returns: &InvariantBatch<N>,
        states: &[CohesiveCamClayState; N],
    ) -> NewtonPoints<N> {
        let zero = [0.0; N];
        let mut points = NewtonPoints {
            pressure: returns.pressure,
            q: returns.q,
            strain: zero,
            cohesion: zero,
            root: zero,
            by_volume: zero,
            by_size: zero,
        };
        let beta = self.spec.cohesion_ratio;
        let root = (1.0 + 2.0 * beta).sqrt();
        for i in 0..N {
            let state = &states[i];
            let softening = self.softening(state);
            points.strain[i] = state.hardening_strain;
            (points.cohesion[i], points.root[i]) = if state.collapsed { (0.0, 1.0) } else { (beta, root) };
            points.by_volume[i] = if softening.is_some() { 0.0 } else { 1.0 };
            points.by_size[i] = softening.unwrap_or(0.0);
        }
        points
    }

    /// Flags the points that yield.
    #[inline(never)]
    fn find_yielding<const N: usize>(
        constants: &NewtonConstants,
        points: &NewtonPoints<N>,
        returns: &mut InvariantBatch<N>,
    ) {
        for i in 0..N {
            let TrialDistance { radius, norm, .. } = constants.trial_distance(&points.point(i));
            // Written so that NaN yields.
            let yields = (norm - radius > constants.yield_tolerance) | !(norm < f64::MAX);
            returns.yields[i] = if yields { 1.0 } else { 0.0 };
        }
    }

    /// Sets the initial guess of yielding points to the return with constant strength. Flags points that lose all stress and points that
    /// need the bracketed solve. Returns the flags of the points to iterate.
    #[inline(never)]
    fn initial_guess<const N: usize>(
        constants: &NewtonConstants,
        points: &NewtonPoints<N>,
        returns: &mut InvariantBatch<N>,
    ) -> [f64; N] {
        let mut active = [0.0; N];
        for i in 0..N {
            let point = points.point(i);
            let TrialDistance { centre, radius, x, norm } = constants.trial_distance(&point);
            let distance = point.pressure - centre;
            let (a, b) = (constants.rates.0, constants.rates.1 * (1.0 + 2.0 * point.cohesion));
            let inverse = 1.0 / radius;
            // From below the root of 1/‖v(γ)‖ = 1/radius, which is nearly linear and concave in γ.
            let gamma = ((x.abs() * inverse - 1.0) / a)
                .max((point.scaled_q * inverse - 1.0) / b)
                .max((norm * inverse - 1.0) / a.max(b));
            let taken = a * gamma / (1.0 + a * gamma);
            // Without softening: the strain consumes all of p0, or p0 is zero and no gap is to be closed.
            let strained = -point.pressure / constants.bulk;
            let emptied =
                (constants.implicit > 0.0) & (distance < 0.0) & (strained >= (-point.strain).max(0.0));
            let gaping = (constants.implicit == 0.0) | (strained + point.strain >= 0.0);
            let freed =
                (norm < f64::MAX) & (point.by_size == 0.0) & if radius == 0.0 { gaping } else { emptied };
            returns.multiplier[i] = if freed { f64::INFINITY } else { gamma };
            returns.volumetric[i] = if freed { strained } else { -distance * taken / constants.bulk };
            // Volumetric strain at which p0 vanishes; compaction of a slab has none.
            let dilates = distance < 0.0;
            let end = -point.strain / if point.by_size > 0.0 { point.by_size } else { 1.0 };
            let ends = (constants.implicit > 0.0) & (dilates | (point.by_size > 0.0));
            let offered = point.pressure.abs() / constants.bulk;
            let offered = if (point.pressure < 0.0) == dilates { offered } else { -offered };
            let reaches = ends & (offered >= end);
            let moving = (constants.implicit > 0.0) & (constants.cohesion_ratio > 1.0);
            // Written so that NaN falls back.
            let fine = (norm < f64::MAX)
                & (radius > 0.0)
                & (distance != 0.0)
                & (constants.factor * -point.strain < MAX_HYPERBOLIC_ARGUMENT)
                & !reaches
                & !moving;
            returns.fallback[i] = if fine | freed { 0.0 } else { returns.yields[i] };
            active[i] = if fine & !freed { returns.yields[i] } else { 0.0 };
        }
        active
    }

    /// Iterates by Newton's method; points that do not converge fall back.
    #[inline(never)]
    fn iterate<const N: usize>(
        constants: &NewtonConstants,
        points: &NewtonPoints<N>,
        returns: &mut InvariantBatch<N>,
        mut active: [f64; N],
    ) {
        let mut wrong = [0.0; N];
        for _ in 0..ITERATIONS {
            for i in 0..N {
                let point = points.point(i);
                let (volumetric, gamma) = (returns.volumetric[i], returns.multiplier[i]);
                let ConditionValues { radius, x, y, decay: [u, v], flow, yielding, .. } =
                    constants.condition_values(&point, volumetric, gamma);
                let determinant = flow[1] * yielding[2] - flow[2] * yielding[1];
                let inverse = 1.0 / determinant;
                let dx = (yielding[0] * flow[2] - flow[0] * yielding[2]) * inverse;
                let dg = (flow[0] * yielding[1] - flow[1] * yielding[0]) * inverse;
                let (a, b) = (constants.rates.0, constants.rates.1 * (1.0 + 2.0 * point.cohesion));
                let change =
                    constants.slope * constants.bulk * dx.abs() + (a * x.abs() * u + b * y * v) * dg.abs();
                // The direction of flow does not change, and p0 remains above zero.
                let next = volumetric + dx;
                let next = if next * volumetric < 0.0 { 0.1 * volumetric } else { next };
                let left = point.strain + (point.by_volume + point.by_size * next.signum()) * next;
                let next =
                    if (left >= 0.0) & (constants.implicit > 0.0) { 0.5 * (volumetric + next) } else { next };
                let multiplier = (gamma + dg).max(0.1 * gamma);
                let going = active[i] > 0.0;
                returns.volumetric[i] = if going { next } else { volumetric };
                returns.multiplier[i] = if going { multiplier } else { gamma };
                // A slope of the other sign: the return may have several solutions.
                wrong[i] += if going & !(determinant < 0.0) { 1.0 } else { 0.0 };
                active[i] = if going & !(change <= CONVERGENCE_TOLERANCE * radius) { 1.0 } else { 0.0 };
            }
            if !any_nonzero(&active) {
                break;
            }
        }
        for i in 0..N {
            let failed = (active[i] > 0.0) | (wrong[i] > 0.0);
            returns.fallback[i] = if failed { 1.0 } else { returns.fallback[i] };
        }
    }

    /// Computes the stresses of the returns.
    #[inline(never)]
    fn compute_stresses<const N: usize>(
        constants: &NewtonConstants,
        points: &NewtonPoints<N>,
        returns: &mut InvariantBatch<N>,
    ) {
        for i in 0..N {
            let point = points.point(i);
            let (volumetric, gamma) = (returns.volumetric[i], returns.multiplier[i]);
            let ConditionValues { centre, radius, x, y, norm, .. } =
                constants.condition_values(&point, volumetric, gamma);
            let ratio = radius / norm;
            let (p, q) = (centre + x * ratio / constants.slope, y * ratio / points.root[i]);
            let done = (returns.yields[i] > 0.0) & (returns.fallback[i] == 0.0);
            let freed = gamma == f64::INFINITY;
            let (p, q) = (if freed { 0.0 } else { p }, if freed { 0.0 } else { q });
            let failed = !(gamma > 0.0) | !(q.abs() < f64::MAX) | !(p.abs() < f64::MAX);
            let strain = if freed { volumetric } else { (p - point.pressure) / constants.bulk };
            returns.pressure[i] = if done & !failed { p } else { point.pressure };
            returns.q[i] = if done & !failed { q } else { points.q[i] };
            returns.volumetric[i] = if done & !failed { strain } else { 0.0 };
            returns.fallback[i] = if done & failed { 1.0 } else { returns.fallback[i] };
        }
    }
}
