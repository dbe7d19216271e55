//! Roots of scalar equations of the return maps.

/// Largest number of evaluations per root: bisection alone halves a bracket of doubles fewer times.
const EVALUATIONS: usize = 300;

/// Relative size of a step below which Newton's method converges quadratically.
const NEWTON_RANGE: f64 = 1e-9;

/// Root of a decreasing function that is positive at `low` and negative at `high`, by Newton's method from `start` with bisection as a
/// safeguard.
pub(crate) fn falling_root(
    low: f64,
    high: f64,
    start: f64,
    mut f: impl FnMut(f64) -> (f64, f64),
) -> Option<f64> {
    let (mut low, mut high) = (low, high);
    let mut x = start.clamp(low, high);
    let mut last_step = high - low;
    for _ in 0..EVALUATIONS {
        let (value, slope) = f(x);
        if !value.is_finite() {
            return None;
        }
        if value == 0.0 {
            return Some(x);
        }
        if value > 0.0 {
            low = x;
        } else {
            high = x;
        }
        let step = -value / slope;
        let newton = x + step;
        // Newton's step where it stays inside and the steps keep shrinking, the middle otherwise.
        let good = newton > low && newton < high && step.abs() <= 0.5 * last_step.abs();
        // Near the root a step that does not shrink is round-off.
        let settled = !good && step.abs() <= NEWTON_RANGE * x.abs();
        if settled || step.abs() <= f64::EPSILON * x.abs() || high - low <= f64::EPSILON * high.abs() {
            return Some(x);
        }
        let next = if good { newton } else { 0.5 * (low + high) };
        last_step = next - x;
        x = next;
    }
    None
}

/// Number of evaluations of [`first_fixed_point`] with secant steps. Later steps are doubled, so that the search ends.
const MAX_SECANT_STEPS: usize = 20;

/// Smallest positive fixed point of a bounded `map`, to within `small`, where `first > 0` is the map of 0.
///
/// The search marches from `first`, each stride by the secant of the last two points, at most to twice the position, until
/// `map(x) < x`; then [`falling_root`] solves inside the last stride. Of several fixed points it thus finds the least,
/// unless two of them lie within one stride. A rising map has no fixed point below `map(x)`, so no stride is shorter than
/// that. The last evaluation of `map` is at the point returned. `None` where the map is not finite.
pub(crate) fn first_fixed_point(first: f64, small: f64, mut map: impl FnMut(f64) -> f64) -> Option<f64> {
    // Difference `map(x) - x`; zero where it is round-off.
    let mut ahead = |x: f64| {
        let ahead = map(x) - x;
        if ahead.abs() <= small { 0.0 } else { ahead }
    };
    let (mut low, mut x) = ((0.0, first), first);
    for evaluation in 0..EVALUATIONS {
        let value = ahead(x);
        if value == 0.0 {
            return Some(x);
        }
        let slope = (value - low.1) / (x - low.0);
        let secant = x - value / slope;
        if value < 0.0 {
            let mut last = (x, value);
            return falling_root(low.0, x, secant, |x| {
                let value = ahead(x);
                let slope = (value - last.1) / (x - last.0);
                last = (x, value);
                (value, slope)
            });
        }
        if !value.is_finite() {
            return None;
        }
        low = (x, value);
        let near = slope < 0.0 && evaluation < MAX_SECANT_STEPS;
        x = (x + value).max(if near { secant.min(2.0 * x) } else { 2.0 * x });
    }
    None
}

/// Returns `difference`, or zero if it is below the round-off of its terms. `terms` is the sum of their magnitudes.
#[inline]
pub(crate) fn drop_round_off(difference: f64, terms: f64) -> f64 {
    if difference.abs() <= 2.0 * f64::EPSILON * terms { 0.0 } else { difference }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fixed point and the number of evaluations.
    fn fixed_point(first: f64, map: impl Fn(f64) -> f64) -> (f64, usize) {
        let (mut evaluations, mut last) = (0, f64::NAN);
        let found = first_fixed_point(first, 1e-15, |x| {
            (evaluations, last) = (evaluations + 1, x);
            map(x)
        });
        assert_eq!(found, Some(last), "the last evaluation is at the fixed point");
        (last, evaluations)
    }

    #[test]
    fn a_fixed_point_is_found_however_steep_the_map() {
        // x = a + b (1 - exp(-x)): iterated, the map itself converges like s^n, s = b exp(-x), and leaps for b > 1.
        for b in [0.0f64, 0.01, 0.5, 0.9, 0.97, 0.99, 1.0, 1.01, 1.1, 3.0, 100.0] {
            for a in [1e-14f64, 1e-9, 1e-4, 0.3] {
                let (x, evaluations) = fixed_point(a, |x| a - b * (-x).exp_m1());
                assert!((a - b * (-x).exp_m1() - x).abs() <= 1e-15 && x >= a, "{a} {b}: {x}");
                assert!(evaluations <= 80, "{evaluations} evaluations for {a}, {b}");
            }
        }
    }

    #[test]
    fn the_smallest_of_several_fixed_points_is_found() {
        // Fixed points where (x - 1)(x - 2)(x - 4) vanishes; the map rises.
        let map = |x: f64| x.min(5.0) - 0.04 * (x - 1.0) * (x - 2.0) * (x - 4.0);
        let (x, _) = fixed_point(map(0.0), map);
        assert!((x - 1.0).abs() < 1e-12, "{x}");
        // A jump of the map: the position of the jump where it is the first with `map(x) < x`.
        let (x, _) = fixed_point(1.0, |x| if x < 1.5 { 2.0 } else { 1.0 });
        assert!((x - 1.5).abs() < 1e-15, "{x}");
        // Falling map.
        let (x, _) = fixed_point(1.0, |x| (-x).exp());
        assert!((x - 0.567_143_290_409_783_8).abs() < 1e-15, "{x}");
        assert_eq!(first_fixed_point(1.0, 0.0, |_| f64::NAN), None);
        assert_eq!(first_fixed_point(1.0, 0.0, |x| 2.0 * x), None);
    }

    #[test]
    fn roots_are_found_where_newton_diverges_or_converges_slowly() {
        // 2 - exp(x) from far right, a cube root's inverse, and a function flat at its start.
        let exact = falling_root(0.0, 600.0, 500.0, |x| (2.0 - x.exp(), -x.exp())).unwrap();
        assert!((exact - 2f64.ln()).abs() < 1e-15);
        let cubic = falling_root(-1.0, 3.0, 3.0, |x| (1.0 - x.powi(3), -3.0 * x * x)).unwrap();
        assert!((cubic - 1.0).abs() < 1e-15);
        let flat = falling_root(0.0, 10.0, 0.0, |x| (1.0 - x * x, -2.0 * x)).unwrap();
        assert!((flat - 1.0).abs() < 1e-15);
        assert_eq!(falling_root(0.0, 1.0, 0.5, |_| (f64::NAN, 1.0)), None);
    }
}
