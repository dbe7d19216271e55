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
