//! The return of several trials at once: Newton's method for plastic volumetric strain and multiplier together (sheet:
//! snow-mpm §3.9). What it does not settle is left to the bracketed solve.

use super::{CamClayIntegration, CohesiveCamClay, CohesiveCamClayState};

/// Iterations before a return is left to the bracketed solve; three to five are usual.
const ITERATIONS: usize = 14;

/// Change of stress in an iteration, over the size of the surface, after which the next one is beyond round-off:
/// convergence is quadratic.
const CLOSE: f64 = 3e-8;

/// Largest `ξ max(-ε, 0)` of the series of the hyperbolic functions.
pub(super) const LARGEST: f64 = 4.0;

/// Quotients of neighbouring terms of the series of `sinh x / x` and of `cosh x`, the last ones first.
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

/// `sinh` and `cosh` of `0 <= x <= 4`, to some digits of round-off, without branches.
#[inline(always)]
pub(super) fn hyperbolic(x: f64) -> (f64, f64) {
    let r = 0.125 * x;
    let r2 = r * r;
    let (mut s, mut c) = (1.0, 1.0);
    for [by_sinh, by_cosh] in SERIES {
        (s, c) = (1.0 + r2 * s * by_sinh, 1.0 + r2 * c * by_cosh);
    }
    let (mut s, mut c) = (r * s, c);
    for _ in 0..3 {
        (s, c) = (2.0 * s * c, 1.0 + 2.0 * s * s);
    }
    (s, c)
}

/// Trials in invariants, and where they end.
pub(super) struct Returns<const N: usize> {
    /// Mean pressure (Pa), trial at first.
    pub(super) pressure: [f64; N],
    /// Deviatoric stress `q` (Pa), trial at first.
    pub(super) q: [f64; N],
    /// Plastic volumetric strain of the step.
    pub(super) volumetric: [f64; N],
    /// Plastic multiplier (1/Pa).
    pub(super) multiplier: [f64; N],
    /// One where the trial yields, else zero.
    pub(super) yields: [f64; N],
    /// One where the return is left to the bracketed solve, else zero.
    pub(super) left: [f64; N],
}

impl<const N: usize> Returns<N> {
    pub(super) fn of(pressure: [f64; N], q: [f64; N]) -> Self {
        let zero = [0.0; N];
        Self { pressure, q, volumetric: zero, multiplier: zero, yields: zero, left: zero }
    }
}

/// What is the same for all points of a material.
#[derive(Clone, Copy)]
struct Constants {
    slope: f64,
    cohesion_ratio: f64,
    bulk: f64,
    factor: f64,
    fuzz: f64,
    /// `2 K M²` and `6 μ`.
    rates: (f64, f64),
    implicit: f64,
}

/// A point during the iteration.
#[derive(Clone, Copy)]
struct Point {
    pressure: f64,
    q: f64,
    /// `-ε` or what takes its place, at the start.
    strain: f64,
    /// Cohesion ratio of the point.
    cohesion: f64,
    /// Hardening strain per plastic volumetric strain and its sign: `a x + b |x|`.
    by_volume: f64,
    by_size: f64,
}

/// The conditions at a guess.
struct At {
    centre: f64,
    radius: f64,
    x: f64,
    y: f64,
    norm: f64,
    flow: [f64; 3],
    yielding: [f64; 3],
}

impl Constants {
    /// `p0` and its slope with the hardening strain.
    #[inline(always)]
    fn strength(&self, strain: f64) -> (f64, f64) {
        let (s, c) = hyperbolic(self.factor * (-strain).max(0.0).min(LARGEST / self.factor));
        (self.bulk * s, if strain < 0.0 { -self.bulk * self.factor * c } else { 0.0 })
    }

    /// Value and derivatives (by volumetric strain and multiplier) of the flow rule and of the yield condition.
    #[inline(always)]
    fn at(&self, point: &Point, volumetric: f64, gamma: f64) -> At {
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
        let (x, y) = (self.slope * distance * u, flattening.sqrt() * point.q * v);
        let norm = (x * x + y * y).sqrt();
        let ratio = radius / norm;
        let taken = a * gamma * u;
        At {
            centre,
            radius,
            x,
            y,
            norm,
            flow: [
                self.bulk * volumetric + distance * taken,
                self.bulk - moves * taken,
                distance * a * u * u,
            ],
            yielding: [
                norm - radius,
                -grows - ratio * (x / norm) * self.slope * moves * u,
                -ratio * (a * x * x * u + b * y * y * v) / norm,
            ],
        }
    }
}

impl CohesiveCamClay {
    fn constants(&self) -> Constants {
        let (slope, bulk) = (self.spec.critical_state_slope, self.elasticity.bulk_modulus);
        Constants {
            slope,
            cohesion_ratio: self.spec.cohesion_ratio,
            bulk,
            factor: self.spec.hardening_factor,
            fuzz: 1e-14 * slope * bulk,
            rates: (2.0 * bulk * slope * slope, 6.0 * self.elasticity.shear_modulus),
            implicit: match self.spec.integration {
                CamClayIntegration::Implicit => 1.0,
                CamClayIntegration::Explicit => 0.0,
            },
        }
    }

    /// Returns trials in invariants and steps the states of those that yield. Points that are left are untouched.
    #[inline(always)]
    pub(super) fn return_several<const N: usize>(
        &self,
        returns: &mut Returns<N>,
        states: &mut [CohesiveCamClayState; N],
    ) {
        let constants = self.constants();
        let points = std::array::from_fn(|i| self.start(returns, &states[i], i));
        Self::judge(&constants, &points, returns);
        if returns.yields.iter().all(|&yields| yields == 0.0) {
            return;
        }
        Self::iterate(&constants, &points, returns);
        for i in 0..N {
            if returns.yields[i] != 0.0 && returns.left[i] == 0.0 {
                let q = returns.q[i];
                self.advance(&mut states[i], returns.volumetric[i], points[i].q - q);
            }
        }
    }

    /// State after a return that takes `volumetric` and, of the deviatoric stress, `lost` (Pa).
    pub(super) fn advance(&self, state: &mut CohesiveCamClayState, volumetric: f64, lost: f64) {
        state.hardening_strain = self.hardened(state, volumetric);
        state.volumetric += volumetric;
        state.deviatoric += lost / (3.0 * self.elasticity.shear_modulus);
        // Only with explicit integration: a return with hardening ends before.
        if self.softening(state).is_some() && state.hardening_strain >= 0.0 {
            state.hardening_strain = 0.0;
            state.collapsed = true;
        }
    }

    #[inline(always)]
    fn start<const N: usize>(
        &self,
        returns: &Returns<N>,
        state: &CohesiveCamClayState,
        index: usize,
    ) -> Point {
        let softening = self.softening(state);
        Point {
            pressure: returns.pressure[index],
            q: returns.q[index],
            strain: state.hardening_strain,
            cohesion: if state.collapsed { 0.0 } else { self.spec.cohesion_ratio },
            by_volume: if softening.is_some() { 0.0 } else { 1.0 },
            by_size: softening.unwrap_or(0.0),
        }
    }

    /// Which points yield, which of these are left, and where the others start: at the return with frozen strength.
    #[inline(never)]
    fn judge<const N: usize>(constants: &Constants, points: &[Point; N], returns: &mut Returns<N>) {
        for i in 0..N {
            let point = points[i];
            let at = constants.at(&point, 0.0, 0.0);
            let yields = at.norm - at.radius > constants.fuzz;
            let distance = point.pressure - at.centre;
            let (a, b) = (constants.rates.0, constants.rates.1 * (1.0 + 2.0 * point.cohesion));
            // From below the root of 1/‖v(γ)‖ = 1/radius, which is nearly linear and concave in γ.
            let gamma = ((at.x.abs() / at.radius - 1.0) / a)
                .max((at.y / at.radius - 1.0) / b)
                .max((at.norm / at.radius - 1.0) / a.max(b));
            let taken = a * gamma / (1.0 + a * gamma);
            returns.multiplier[i] = gamma;
            returns.volumetric[i] = -distance * taken / constants.bulk;
            // Volumetric strain at which nothing of p0 is left; compaction of a slab has none.
            let dilates = distance < 0.0;
            let end = -point.strain / if point.by_size > 0.0 { point.by_size } else { 1.0 };
            let ends = (constants.implicit > 0.0) & (dilates | (point.by_size > 0.0));
            let offered = point.pressure.abs() / constants.bulk;
            let offered = if (point.pressure < 0.0) == dilates { offered } else { -offered };
            let reaches = ends & (offered >= end);
            let moving = (constants.implicit > 0.0) & (constants.cohesion_ratio > 1.0);
            // Written so that NaN is left.
            let fine = (at.norm < f64::MAX)
                & (at.radius > 0.0)
                & (distance != 0.0)
                & (constants.factor * -point.strain < LARGEST)
                & !reaches
                & !moving;
            returns.yields[i] = if yields | !(at.norm < f64::MAX) { 1.0 } else { 0.0 };
            returns.left[i] = if returns.yields[i] * if fine { 0.0 } else { 1.0 } > 0.0 { 1.0 } else { 0.0 };
        }
    }

    #[inline(never)]
    fn iterate<const N: usize>(constants: &Constants, points: &[Point; N], returns: &mut Returns<N>) {
        let mut active: [f64; N] = std::array::from_fn(|i| returns.yields[i] * (1.0 - returns.left[i]));
        let mut wrong = [0.0; N];
        for _ in 0..ITERATIONS {
            let mut on = 0.0;
            for i in 0..N {
                let point = points[i];
                let (volumetric, gamma) = (returns.volumetric[i], returns.multiplier[i]);
                let At { radius, x, y, flow, yielding, .. } = constants.at(&point, volumetric, gamma);
                let determinant = flow[1] * yielding[2] - flow[2] * yielding[1];
                let dx = (yielding[0] * flow[2] - flow[0] * yielding[2]) / determinant;
                let dg = (flow[0] * yielding[1] - flow[1] * yielding[0]) / determinant;
                let (a, b) = (constants.rates.0, constants.rates.1 * (1.0 + 2.0 * point.cohesion));
                let (u, v) = (1.0 + a * gamma, 1.0 + b * gamma);
                let change =
                    constants.slope * constants.bulk * dx.abs() + (a * x.abs() / u + b * y / v) * dg.abs();
                // The side of flow does not change, and p0 stays above zero.
                let next = volumetric + dx;
                let next = if next * volumetric < 0.0 { 0.1 * volumetric } else { next };
                let left = point.strain + (point.by_volume + point.by_size * next.signum()) * next;
                let next =
                    if (left >= 0.0) & (constants.implicit > 0.0) { 0.5 * (volumetric + next) } else { next };
                let multiplier = (gamma + dg).max(0.1 * gamma);
                let going = active[i] > 0.0;
                returns.volumetric[i] = if going { next } else { volumetric };
                returns.multiplier[i] = if going { multiplier } else { gamma };
                // A slope of the other sign: the return may have several ends.
                wrong[i] += if going & !(determinant < 0.0) { 1.0 } else { 0.0 };
                active[i] = if going & !(change <= CLOSE * radius) { 1.0 } else { 0.0 };
                on += active[i];
            }
            if on == 0.0 {
                break;
            }
        }
        for i in 0..N {
            let point = points[i];
            let (volumetric, gamma) = (returns.volumetric[i], returns.multiplier[i]);
            let At { centre, radius, x, y, norm, .. } = constants.at(&point, volumetric, gamma);
            let ratio = radius / norm;
            let flattening = (1.0 + 2.0 * point.cohesion).sqrt();
            let (p, q) = (centre + x * ratio / constants.slope, y * ratio / flattening);
            let done = (returns.yields[i] > 0.0) & (returns.left[i] == 0.0);
            let failed = (active[i] > 0.0)
                | (wrong[i] > 0.0)
                | !(gamma > 0.0)
                | !(q.abs() < f64::MAX)
                | !(p.abs() < f64::MAX);
            returns.pressure[i] = if done & !failed { p } else { point.pressure };
            returns.q[i] = if done & !failed { q } else { point.q };
            returns.volumetric[i] = if done & !failed { (p - point.pressure) / constants.bulk } else { 0.0 };
            returns.left[i] = if done & failed { 1.0 } else { returns.left[i] };
        }
    }
}
