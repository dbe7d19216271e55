//! Observed order of convergence (Celik et al. 2008, *J. Fluids Eng.* 130, 078001).

/// Safety factor of the grid convergence index with three grids.
const SAFETY_FACTOR: f64 = 1.25;
/// Largest order that is considered.
const MAX_ORDER: f64 = 20.0;

/// Result of a convergence study with three runs of increasing resolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConvergenceOrder {
    /// Observed order of convergence. NaN where the values oscillate, or where they differ more on the finer side.
    pub order: f64,
    /// Value extrapolated to zero size (Richardson); NaN without an order.
    pub limit: f64,
    /// Grid convergence index of the finest run: the relative uncertainty of its value. NaN without an order.
    pub grid_convergence_index: f64,
}

/// Observed order of convergence from the sizes and the values of three runs, coarse to fine: `p` of `f = limit + C h^p`, from `(f₁ -
/// f₂)/(f₂ - f₃) = (h₁^p - h₂^p)/(h₂^p - h₃^p)`.
pub fn observed_order(sizes: [f64; 3], values: [f64; 3]) -> ConvergenceOrder {
    let none = ConvergenceOrder { order: f64::NAN, limit: f64::NAN, grid_convergence_index: f64::NAN };
    let [coarse, fine] = [sizes[0] / sizes[1], sizes[1] / sizes[2]];
    let [first, second] = [values[0] - values[1], values[1] - values[2]];
    let refined = coarse > 1.0 && fine > 1.0;
    if !refined || values.iter().any(|value| !value.is_finite()) {
        return none;
    }
    if first == 0.0 && second == 0.0 {
        return ConvergenceOrder { order: f64::NAN, limit: values[2], grid_convergence_index: 0.0 };
    }
    // The ratio grows with the order from its value for order zero.
    let ratio = |p: f64| (p * coarse.ln()).exp_m1() / -(-p * fine.ln()).exp_m1();
    let found = first / second;
    if !(found > coarse.ln() / fine.ln() && found < ratio(MAX_ORDER)) {
        return none;
    }
    let (mut low, mut high) = (0.0, MAX_ORDER);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if ratio(middle) < found { low = middle } else { high = middle }
    }
    let order = 0.5 * (low + high);
    let step = second / (fine.powf(order) - 1.0);
    ConvergenceOrder {
        order,
        limit: values[2] - step,
        grid_convergence_index: SAFETY_FACTOR * (step / values[2]).abs(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_a_power_law_is_recovered_for_any_refinement_ratios() {
        for exponent in [0.7, 1.0, 2.0, 3.5] {
            for sizes in [[0.4, 0.2, 0.1], [0.5, 0.3, 0.1], [1.0, 0.9, 0.5]] {
                let value = |h: f64| 3.0 - 2.0 * h.powf(exponent);
                let found = observed_order(sizes, sizes.map(value));
                assert!((found.order - exponent).abs() < 1e-9, "{exponent} {sizes:?}: {found:?}");
                assert!((found.limit - 3.0).abs() < 1e-9);
                let error = 3.0 / value(sizes[2]) - 1.0;
                assert!((found.grid_convergence_index - 1.25 * error).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn non_convergent_series_have_no_observed_order() {
        let sizes = [0.4, 0.2, 0.1];
        for values in [[1.0, 2.0, 1.0], [1.0, 2.0, 4.0], [1.0, 2.0, f64::NAN], [1.0, 2.0, 2.0]] {
            assert!(observed_order(sizes, values).order.is_nan(), "{values:?}");
        }
        assert!(observed_order([0.1, 0.2, 0.4], [1.0, 1.5, 1.75]).order.is_nan(), "from fine to coarse");
        assert_eq!(observed_order(sizes, [2.0; 3]).limit, 2.0);
    }
}
