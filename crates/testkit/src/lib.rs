//! Test helpers of the other crates. Only tests and benches depend on this crate.
//!
//! [`assert_near`] and [`assert_close`] compare numbers, [`CountingAllocator`] counts allocations, and [`solver_runs`] makes cases and runs
//! solvers by the traits of [`colluvium_case`]; [`taylor_green`] and [`cohesive_bar`] are cases of several methods.

mod allocations;
pub mod cohesive_bar;
pub mod pairwise;
pub mod solver_runs;
pub mod taylor_green;

pub use allocations::{CountingAllocator, allocations_during};

/// Asserts that `found` is within `tolerance` of `exact`.
///
/// # Panics
/// When it is not, also when it is NaN.
#[track_caller]
pub fn assert_near(found: f64, exact: f64, tolerance: f64) {
    assert!((found - exact).abs() <= tolerance, "{found} for {exact}");
}

/// Asserts that `found` is within `tolerance` of `exact`: relative to `exact` where that is above one, absolute below.
///
/// # Panics
/// When it is not, also when it is NaN.
#[track_caller]
pub fn assert_close(found: f64, exact: f64, tolerance: f64) {
    assert_near(found, exact, tolerance * exact.abs().max(1.0));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances_are_relative_above_one_and_absolute_below() {
        assert_close(1001.0, 1000.0, 1.001e-3);
        assert_close(1e-4, 0.0, 1e-3);
        assert!(std::panic::catch_unwind(|| assert_close(1002.0, 1000.0, 1e-3)).is_err());
        assert!(std::panic::catch_unwind(|| assert_close(2e-3, 0.0, 1e-3)).is_err());
        assert!(std::panic::catch_unwind(|| assert_near(f64::NAN, 0.0, 1e9)).is_err());
    }
}
