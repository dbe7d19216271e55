//! Numbers out of many numbers: the largest, a straight line through points.

/// The larger of both; not a number where one of them is none, so that a check fails on it.
pub fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a >= b { a } else { b }
}

/// The largest of what a benchmark found.
pub trait Largest {
    /// NaN, which fails every check, where there are no numbers or one of them is none.
    fn largest(self) -> f64;
}

impl<I: Iterator<Item = f64>> Largest for I {
    fn largest(self) -> f64 {
        self.reduce(larger).unwrap_or(f64::NAN)
    }
}

/// Slope of the straight line through the points, by least squares.
pub fn slope(points: &[(f64, f64)]) -> f64 {
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
    fn what_is_no_number_is_the_largest() {
        assert_eq!([3.0, -1.0, 7.0].into_iter().largest(), 7.0);
        for list in [&[][..], &[f64::NAN, 1.0], &[1.0, f64::NAN], &[1.0, f64::NAN, 2.0]] {
            assert!(list.iter().copied().largest().is_nan(), "{list:?}");
        }
    }

    #[test]
    fn the_slope_of_a_line_is_its_own_and_scatter_counts_by_squares() {
        let line: Vec<(f64, f64)> = (0..5).map(|i| (f64::from(i), 2.0 - 0.5 * f64::from(i))).collect();
        assert!((slope(&line) + 0.5).abs() < 1e-15);
        // Sums of squares 2 about the mean of x, and of products 3.
        assert_eq!(slope(&[(0.0, 0.0), (1.0, 0.0), (2.0, 3.0)]), 1.5);
    }
}
