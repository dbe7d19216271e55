//! Statistics: largest value, least value over a box, straight line through points.

/// Larger of two numbers; NaN where one of them is NaN, so that a check fails.
pub fn max_or_nan(a: f64, b: f64) -> f64 {
    if a.is_nan() || a >= b { a } else { b }
}

/// Mean and standard deviation of samples.
pub fn mean_and_deviation(drawn: &[f64]) -> (f64, f64) {
    let mean = drawn.iter().sum::<f64>() / drawn.len() as f64;
    let square = drawn.iter().map(|own| (own - mean).powi(2)).sum::<f64>() / (drawn.len() - 1) as f64;
    (mean, square.sqrt())
}

/// Extension of iterators by a largest value that is NaN where one number is NaN.
pub trait MaxOrNan {
    /// Returns the largest value. It is NaN, which fails every check, where there are no numbers or one of them is NaN.
    fn max_or_nan(self) -> f64;
}

impl<I: Iterator<Item = f64>> MaxOrNan for I {
    fn max_or_nan(self) -> f64 {
        self.reduce(max_or_nan).unwrap_or(f64::NAN)
    }
}

/// Number of passes of a search, each in a finer box around the best position.
const SEARCH_ROUNDS: usize = 12;

/// Least value of a function over a box, and its position, by repeated search on a grid. Each pass has `places` positions along each axis
/// in a box `narrower` times as wide as the previous one. `None` where no value is finite.
pub fn grid_search_minimum<const N: usize>(
    limits: [(f64, f64); N],
    (places, narrower): (usize, f64),
    value: impl Fn([f64; N]) -> f64,
) -> Option<(f64, [f64; N])> {
    let (mut bounds, mut best) = (limits, (f64::INFINITY, [0.0; N]));
    for _ in 0..SEARCH_ROUNDS {
        for number in 0..places.pow(N as u32) {
            let mut rest = number;
            let at: [f64; N] = std::array::from_fn(|axis| {
                let (low, high) = bounds[axis];
                let k = rest % places;
                rest /= places;
                low + (high - low) * k as f64 / (places - 1) as f64
            });
            let found = value(at);
            if found < best.0 {
                best = (found, at);
            }
        }
        for axis in 0..N {
            let half = 0.5 * narrower * (bounds[axis].1 - bounds[axis].0);
            let (low, high) = limits[axis];
            bounds[axis] = ((best.1[axis] - half).max(low), (best.1[axis] + half).min(high));
        }
    }
    best.0.is_finite().then_some(best)
}

/// Slope of the regression line through points, by least squares.
pub fn regression_slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (mx, my) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (xy, xx) = points
        .iter()
        .fold((0.0, 0.0), |(xy, xx), p| (xy + (p.0 - mx) * (p.1 - my), xx + (p.0 - mx) * (p.0 - mx)));
    xy / xx
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nan_is_the_maximum_of_a_list_that_contains_it() {
        assert_eq!([3.0, -1.0, 7.0].into_iter().max_or_nan(), 7.0);
        for list in [&[][..], &[f64::NAN, 1.0], &[1.0, f64::NAN], &[1.0, f64::NAN, 2.0]] {
            assert!(list.iter().copied().max_or_nan().is_nan(), "{list:?}");
        }
    }

    #[test]
    fn grid_search_finds_the_minimum_or_the_nearest_bound() {
        let bowl = |[x, y]: [f64; 2]| (x - 0.3).powi(2) + (y - 2.0).powi(2);
        let (_, at) = grid_search_minimum([(-1.0, 1.0), (0.0, 1.0)], (9, 0.5), bowl).unwrap();
        assert!((at[0] - 0.3).abs() < 1e-3 && at[1] == 1.0, "{at:?}");
        assert!(grid_search_minimum([(0.0, 1.0)], (9, 0.5), |_| f64::NAN).is_none());
    }

    #[test]
    fn the_slope_of_a_line_is_its_own_and_scatter_counts_by_squares() {
        let line: Vec<(f64, f64)> = (0..5).map(|i| (f64::from(i), 2.0 - 0.5 * f64::from(i))).collect();
        assert!((regression_slope(&line) + 0.5).abs() < 1e-15);
        // Sums of squares 2 about the mean of x, and of products 3.
        assert_eq!(regression_slope(&[(0.0, 0.0), (1.0, 0.0), (2.0, 3.0)]), 1.5);
    }
}
