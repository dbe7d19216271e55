//! Uncertainty of fitted parameters: standard deviations and correlations from the sensitivities at the minimum.

use nalgebra::{DMatrix, SymmetricEigen};

/// Eigenvalue of the normal matrix, over the largest, below which a combination of parameters has no effect.
const SINGULAR: f64 = 1e-12;
/// Standard deviation as a share of the range above which a parameter is not determined.
const UNDETERMINED: f64 = 0.25;

/// Uncertainty of fitted parameters from the sensitivities `J` of the residuals over their tolerances: covariance `s² (JᵀJ)⁻¹` with
/// `s² = max(1, Σr²/(n - m))` for n data and m parameters. The residuals are taken as independent.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterUncertainty {
    /// Standard deviations as shares of the ranges.
    pub deviations: Vec<f64>,
    /// Correlations, row by row.
    pub correlations: Vec<Vec<f64>>,
}

impl ParameterUncertainty {
    /// Uncertainty from sensitivities (rows are data, columns parameters) and residuals.
    pub(super) fn new(jacobian: &DMatrix<f64>, residuals: &[f64]) -> Self {
        let count = jacobian.ncols();
        let eigen = SymmetricEigen::new(jacobian.transpose() * jacobian);
        let largest = eigen.eigenvalues.max();
        let freedom = residuals.len().saturating_sub(count).max(1) as f64;
        let variance = (residuals.iter().map(|r| r * r).sum::<f64>() / freedom).max(1.0);
        let covariance = |i: usize, j: usize| -> f64 {
            let terms = (0..count).map(|k| {
                let (vector, value) = (eigen.eigenvectors.column(k), eigen.eigenvalues[k]);
                vector[i] * vector[j] / value.max(SINGULAR * largest)
            });
            variance * terms.sum::<f64>()
        };
        if !(largest > 0.0) {
            let identity = |i: usize| (0..count).map(|j| f64::from(u8::from(i == j))).collect();
            let correlations = (0..count).map(identity).collect();
            return Self { deviations: vec![f64::INFINITY; count], correlations };
        }
        let deviations: Vec<f64> = (0..count).map(|k| covariance(k, k).sqrt()).collect();
        let correlation = |i: usize, j: usize| match i == j {
            true => 1.0,
            false => (covariance(i, j) / (deviations[i] * deviations[j])).clamp(-1.0, 1.0),
        };
        let correlations = (0..count).map(|i| (0..count).map(|j| correlation(i, j)).collect()).collect();
        Self { deviations, correlations }
    }

    /// Whether the data determine a parameter: its standard deviation is at most a quarter of the range.
    pub fn is_determined(&self, parameter: usize) -> bool {
        self.deviations[parameter] <= UNDETERMINED
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviations_of_a_straight_line_are_those_of_linear_regression() {
        // y = a + b x at x = -1, 0, 1, 2 with unit tolerance: var b = 1/Σ(x - x̄)² = 1/5, var a = 1/4 + x̄²/5, cov = -x̄/5.
        let x = [-1.0, 0.0, 1.0, 2.0];
        let jacobian = DMatrix::from_fn(4, 2, |i, k| if k == 0 { 1.0 } else { x[i] });
        let exact = ParameterUncertainty::new(&jacobian, &[0.0; 4]);
        let [var_a, var_b, cov] = [0.25 + 0.25 / 5.0, 0.2, -0.5 / 5.0];
        assert!((exact.deviations[0] - f64::sqrt(var_a)).abs() < 1e-12);
        assert!((exact.deviations[1] - f64::sqrt(var_b)).abs() < 1e-12);
        assert!((exact.correlations[0][1] - cov / f64::sqrt(var_a * var_b)).abs() < 1e-12);
        // Residuals above the tolerance enlarge the deviations: s² = 4·9/(4 - 2).
        let rough = ParameterUncertainty::new(&jacobian, &[3.0, -3.0, -3.0, 3.0]);
        assert!((rough.deviations[1] / exact.deviations[1] - f64::sqrt(18.0)).abs() < 1e-12);
    }

    #[test]
    fn parameters_without_effect_and_with_only_a_sum_are_not_determined() {
        let none = DMatrix::from_fn(5, 2, |i, k| if k == 0 { 10.0 + i as f64 } else { 0.0 });
        let found = ParameterUncertainty::new(&none, &[0.0; 5]);
        assert!(found.is_determined(0) && !found.is_determined(1));
        let sum = DMatrix::from_fn(5, 3, |i, k| if k == 2 { 7.0 * (i as f64 - 2.0) } else { 10.0 });
        let found = ParameterUncertainty::new(&sum, &[0.0; 5]);
        assert!(!found.is_determined(0) && !found.is_determined(1) && found.is_determined(2));
        assert!(found.correlations[0][1] < -0.999, "{:?}", found.correlations);
    }
}
