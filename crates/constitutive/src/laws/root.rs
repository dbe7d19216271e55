//! Roots of scalar equations of the return maps.

/// Evaluations before a root is given up: bisection alone halves a bracket of doubles fewer times.
const EVALUATIONS: usize = 300;

/// Relative size of a step from which on Newton's method converges by leaps.
const NEAR: f64 = 1e-9;

/// Root of a function that falls from positive at `low` to negative at `high`, by Newton's method from
/// `start`, safeguarded by bisection. `f` gives value and derivative. `None` where it is not finite.
pub(super) fn falling_root(
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
        // Newton's step where it stays inside and the steps go on shrinking, the middle otherwise.
        let good = newton > low && newton < high && step.abs() <= 0.5 * last_step.abs();
        // Near the root a step that is not good is round-off.
        let settled = !good && step.abs() <= NEAR * x.abs();
        if settled || step.abs() <= f64::EPSILON * x.abs() || high - low <= f64::EPSILON * high.abs() {
            return Some(x);
        }
        let next = if good { newton } else { 0.5 * (low + high) };
        last_step = next - x;
        x = next;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_found_where_newton_alone_would_leave_or_crawl() {
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
