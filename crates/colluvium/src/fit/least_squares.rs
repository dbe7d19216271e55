//! Least squares in the unit cube: global samples, the method of Levenberg and Marquardt with bounds, and a pattern search.
//!
//! The mean square of the residuals `r(u)` is minimised over `0 ≤ u ≤ 1`. A step solves `(JᵀJ + λ D) δ = -Jᵀr` for the coordinates that
//! are not held at a bound (Marquardt 1963, *J. Soc. Ind. Appl. Math.* 11, 431–441); J is a matrix of differences. The pattern search
//! moves along the axes (Hooke and Jeeves 1961, *J. ACM* 8, 212–229): it needs no derivative, which laws with a kink do not have.

use std::cell::Cell;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Width of the differences in the local search.
const DIFFERENCE: f64 = 1e-4;
/// Width of the differences at the minimum, for uncertainties.
const WIDE_DIFFERENCE: f64 = 1e-3;
/// Mean square of the residuals below which the search ends: tolerances times a millionth.
const NEGLIGIBLE: f64 = 1e-12;
/// Relative decrease below which a search ends.
const DECREASE: f64 = 1e-8;
/// Length of steps below which a search ends.
const SHORTEST_STEP: f64 = 1e-7;
/// Largest number of steps of a local search.
const STEPS: usize = 60;
/// Square of a sensitivity, over that of the largest, below which a parameter has no effect.
const INSENSITIVE: f64 = 1e-10;
/// First and last length of the steps of the pattern search.
const PATTERN: [f64; 2] = [0.05, 5e-4];
/// Largest damping.
const MAX_DAMPING: f64 = 1e8;

/// Point of the unit cube with its residuals.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ResidualPoint {
    /// Coordinates.
    pub(super) point: Vec<f64>,
    /// Residuals over their tolerances.
    pub(super) residuals: Vec<f64>,
    /// Mean square of the residuals.
    pub(super) mean_square: f64,
}

/// Residuals at a point; `None` where they cannot be computed.
pub(super) type Residuals<'a> = dyn Fn(&[f64]) -> Option<Vec<f64>> + Sync + 'a;

/// Search for the least mean square, with a limited number of evaluations.
pub(super) struct LeastSquares<'a> {
    residuals: &'a Residuals<'a>,
    left: Cell<usize>,
    used: Cell<usize>,
}

impl<'a> LeastSquares<'a> {
    /// Search with a limit of evaluations.
    pub(super) fn new(residuals: &'a Residuals<'a>, limit: usize) -> Self {
        Self { residuals, left: Cell::new(limit), used: Cell::new(0) }
    }

    /// Number of evaluations.
    pub(super) fn evaluations(&self) -> usize {
        self.used.get()
    }

    /// Whether the search ended at its limit of evaluations.
    pub(super) fn is_exhausted(&self) -> bool {
        self.left.get() == 0
    }

    /// Evaluates points simultaneously; `None` at points that fail. Points beyond the limit are left out, and set it to zero.
    pub(super) fn evaluate(&self, points: &[Vec<f64>]) -> Vec<Option<ResidualPoint>> {
        let count = points.len().min(self.left.get());
        self.used.set(self.used.get() + count);
        self.left.set(if count < points.len() { 0 } else { self.left.get() - count });
        let evaluated = |point: &Vec<f64>| {
            let residuals = (self.residuals)(point)?;
            let mean_square = residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len() as f64;
            mean_square.is_finite().then(|| ResidualPoint { point: point.clone(), residuals, mean_square })
        };
        points[..count].par_iter().map(evaluated).collect()
    }

    /// Minimum from a start: the method of Levenberg and Marquardt and the pattern search by turns.
    pub(super) fn minimise(&self, start: ResidualPoint) -> ResidualPoint {
        let mut best = self.levenberg_marquardt(start);
        while best.mean_square > NEGLIGIBLE && !self.is_exhausted() {
            let moved = self.pattern_search(best.clone());
            let gain = 1.0 - moved.mean_square / best.mean_square;
            best = moved;
            if gain < 1e-5 {
                break;
            }
            best = self.levenberg_marquardt(best);
        }
        best
    }

    /// Local search by the method of Levenberg and Marquardt.
    pub(super) fn levenberg_marquardt(&self, start: ResidualPoint) -> ResidualPoint {
        let (mut best, mut damping) = (start, 1e-2);
        for _ in 0..STEPS {
            if best.mean_square <= NEGLIGIBLE || self.is_exhausted() {
                break;
            }
            let jacobian = self.jacobian(&best);
            let Some(next) = self.damped_step(&best, &jacobian, &mut damping) else { break };
            let decrease = 1.0 - next.mean_square / best.mean_square;
            best = next;
            if decrease < DECREASE {
                break;
            }
        }
        best
    }

    /// First point with a smaller mean square for increasing damping; `None` if there is none.
    fn damped_step(
        &self,
        best: &ResidualPoint,
        jacobian: &DMatrix<f64>,
        damping: &mut f64,
    ) -> Option<ResidualPoint> {
        while *damping < MAX_DAMPING && !self.is_exhausted() {
            let point = bounded_step(best, jacobian, *damping);
            let length = point.iter().zip(&best.point).fold(0.0, |l: f64, (a, b)| l.max((a - b).abs()));
            if length < SHORTEST_STEP {
                return None;
            }
            let next = self.evaluate(&[point]).pop().flatten();
            if let Some(next) = next.filter(|next| next.mean_square < best.mean_square) {
                *damping = (*damping / 8.0).max(1e-9);
                return Some(next);
            }
            *damping *= 4.0;
        }
        None
    }

    /// Derivatives of the residuals by one-sided differences within the cube. A column is zero where both sides fail.
    fn jacobian(&self, at: &ResidualPoint) -> DMatrix<f64> {
        let count = at.point.len();
        let side = |k: usize, outwards: bool| {
            let ahead = if at.point[k] + DIFFERENCE > 1.0 { -DIFFERENCE } else { DIFFERENCE };
            moved(&at.point, k, if outwards { -ahead } else { ahead })
        };
        let mut columns: Vec<Option<ResidualPoint>> =
            self.evaluate(&(0..count).map(|k| side(k, false)).collect::<Vec<_>>());
        columns.resize(count, None);
        for (k, column) in columns.iter_mut().enumerate().filter(|(_, column)| column.is_none()) {
            *column = self.evaluate(&[side(k, true)]).pop().flatten();
        }
        let derivative = |i: usize, k: usize| {
            columns[k]
                .as_ref()
                .map_or(0.0, |other| (other.residuals[i] - at.residuals[i]) / (other.point[k] - at.point[k]))
        };
        DMatrix::from_fn(at.residuals.len(), count, derivative)
    }

    /// Local search along the axes with decreasing steps.
    fn pattern_search(&self, start: ResidualPoint) -> ResidualPoint {
        let (mut best, mut step) = (start, PATTERN[0]);
        while step >= PATTERN[1] && !self.is_exhausted() {
            let sides = (0..best.point.len()).flat_map(|k| [(k, step), (k, -step)]);
            let points: Vec<Vec<f64>> = sides
                .map(|(k, step)| moved(&best.point, k, step))
                .filter(|point| *point != best.point)
                .collect();
            let lowest = self.evaluate(&points).into_iter().flatten().min_by(by_mean_square);
            match lowest.filter(|lowest| lowest.mean_square < best.mean_square * (1.0 - DECREASE)) {
                Some(lowest) => best = lowest,
                None => step *= 0.5,
            }
        }
        best
    }
}

/// Order by the mean square.
pub(super) fn by_mean_square(a: &ResidualPoint, b: &ResidualPoint) -> std::cmp::Ordering {
    a.mean_square.total_cmp(&b.mean_square)
}

/// Derivatives of the residuals at a minimum by central differences within the cube, with the number of evaluations. A column is zero
/// where a side fails.
pub(super) fn central_jacobian(residuals: &Residuals<'_>, at: &ResidualPoint) -> DMatrix<f64> {
    let count = at.point.len();
    let sides: Vec<Vec<f64>> = (0..count)
        .flat_map(|k| [moved(&at.point, k, WIDE_DIFFERENCE), moved(&at.point, k, -WIDE_DIFFERENCE)])
        .collect();
    let search = LeastSquares::new(residuals, sides.len());
    let found = search.evaluate(&sides);
    let derivative = |i: usize, k: usize| {
        let [above, below] = [&found[2 * k], &found[2 * k + 1]].map(|side| side.as_ref().unwrap_or(at));
        let width = above.point[k] - below.point[k];
        if width > 0.0 { (above.residuals[i] - below.residuals[i]) / width } else { 0.0 }
    };
    DMatrix::from_fn(at.residuals.len(), count, derivative)
}

/// Point moved along an axis, within the cube.
fn moved(point: &[f64], axis: usize, step: f64) -> Vec<f64> {
    let mut point = point.to_vec();
    point[axis] = (point[axis] + step).clamp(0.0, 1.0);
    point
}

/// Point after a damped step. Coordinates at a bound towards which they would move, and those without effect, are held.
fn bounded_step(best: &ResidualPoint, jacobian: &DMatrix<f64>, damping: f64) -> Vec<f64> {
    let gradient = jacobian.transpose() * DVector::from_column_slice(&best.residuals);
    let normal = jacobian.transpose() * jacobian;
    let largest = normal.diagonal().max();
    let is_free = |k: &usize| {
        let leaves =
            (best.point[*k] <= 0.0 && gradient[*k] > 0.0) || (best.point[*k] >= 1.0 && gradient[*k] < 0.0);
        !leaves && normal[(*k, *k)] > INSENSITIVE * largest
    };
    let free: Vec<usize> = (0..best.point.len()).filter(is_free).collect();
    let diagonal = |k: usize| damping * (normal[(k, k)] + 1e-3 * largest);
    let matrix = DMatrix::from_fn(free.len(), free.len(), |i, j| {
        normal[(free[i], free[j])] + if i == j { diagonal(free[i]) } else { 0.0 }
    });
    let right = DVector::from_fn(free.len(), |i, _| -gradient[free[i]]);
    let mut point = best.point.clone();
    if let Some(factor) = matrix.cholesky() {
        let step = factor.solve(&right);
        for (i, k) in free.iter().enumerate() {
            point[*k] = (point[*k] + step[i]).clamp(0.0, 1.0);
        }
    }
    point
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solve(residuals: &Residuals<'_>, start: &[f64], limit: usize) -> (ResidualPoint, usize, bool) {
        let search = LeastSquares::new(residuals, limit);
        let start = search.evaluate(&[start.to_vec()]).pop().flatten().unwrap();
        let found = search.minimise(start);
        (found, search.evaluations(), search.is_exhausted())
    }

    #[test]
    fn the_minimum_of_rosenbrocks_valley_is_found() {
        let valley = |u: &[f64]| {
            let (x, y) = (4.0 * u[0] - 2.0, 4.0 * u[1] - 2.0);
            Some(vec![10.0 * (y - x * x), 1.0 - x])
        };
        let (found, used, exhausted) = solve(&valley, &[0.2, 0.75], 1000);
        assert!(!exhausted && used < 400, "{used}");
        // The search ends at a root mean square of a millionth; the smallest slope of the residuals is about 1.
        assert!(found.point.iter().all(|u| (u - 0.75).abs() < 1e-5), "{:?}", found.point);
    }

    #[test]
    fn a_minimum_beyond_a_bound_is_found_on_the_bound() {
        let plane = |u: &[f64]| Some(vec![u[0] + 0.5, 2.0 * (u[1] - 0.3), u[0] + u[1]]);
        let (found, ..) = solve(&plane, &[0.9, 0.9], 500);
        // With u₀ = 0 the minimum of 4 (u₁ - 0.3)² + u₁² is at 0.24.
        assert_eq!(found.point[0], 0.0);
        assert!((found.point[1] - 0.24).abs() < 1e-5, "{:?}", found.point);
    }

    #[test]
    fn a_kink_at_the_minimum_does_not_stop_the_search() {
        let kinked = |u: &[f64]| {
            let peak = (u[0] - 0.4).abs() + 0.2 * (u[1] - 0.7).abs();
            Some(vec![1.0 + peak, 0.5 * (u[0] - 0.4)])
        };
        let (found, ..) = solve(&kinked, &[0.05, 0.1], 2000);
        // The last steps of the pattern search have a length of 5e-4 to 1e-3.
        assert!(
            (found.point[0] - 0.4).abs() < 1e-3 && (found.point[1] - 0.7).abs() < 1e-3,
            "{:?}",
            found.point
        );
    }

    #[test]
    fn failing_points_are_avoided_and_the_limit_ends_the_search() {
        let partial = |u: &[f64]| (u[0] < 0.6).then(|| vec![u[0] - 0.59999, u[1] - 0.5]);
        let (found, ..) = solve(&partial, &[0.1, 0.1], 1000);
        assert!((found.point[0] - 0.59999).abs() < 1e-4 && (found.point[1] - 0.5).abs() < 1e-5);
        let (_, used, exhausted) = solve(&partial, &[0.1, 0.1], 5);
        assert!(exhausted && used <= 5);
    }

    #[test]
    fn central_differences_are_exact_for_linear_residuals() {
        let plane = |u: &[f64]| Some(vec![3.0 * u[0] - u[1], 2.0 * u[1]]);
        let at =
            ResidualPoint { point: vec![0.0, 0.5], residuals: plane(&[0.0, 0.5]).unwrap(), mean_square: 0.0 };
        let jacobian = central_jacobian(&plane, &at);
        let expected = DMatrix::from_row_slice(2, 2, &[3.0, -1.0, 0.0, 2.0]);
        assert!((jacobian - expected).abs().max() < 1e-10);
    }
}
