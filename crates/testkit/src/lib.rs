//! Test helpers of the other crates. Only tests and benches depend on this crate.
//!
//! [`assert_near`], [`assert_close`], [`assert_relative`] and [`assert_digits`] compare numbers. [`CaseBuilder`] makes cases. [`solve`],
//! [`start_solver`] and [`advance_to`] run solvers by the traits of [`colluvium_case`]. [`CountingAllocator`] counts allocations.
//! [`taylor_green`] and [`cohesive_bar`] are cases of several methods.

mod allocations;
mod case_file;
pub mod cohesive_bar;
pub mod pairwise;
mod raster_files;
mod solver_runs;
pub mod taylor_green;

pub use allocations::{CountingAllocator, allocations_during};
pub use case_file::CaseBuilder;
pub use pairwise::set_value;
pub use raster_files::write_ascii_grid;
pub use solver_runs::{
    advance_exactly_to, advance_steps, advance_to, assert_allocates_nothing, assert_same_after_restart,
    assert_same_on_threads, case_with, hash_after, read_case, refusal, resume_solver, scalar_output, scalars,
    single_threaded, solve, start_solver, stresses, take_steps, vectors, with_keys,
};

/// Texts of all values of a list, one a line.
pub fn lines(list: &[impl std::fmt::Display]) -> String {
    list.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

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

/// Asserts that `found` is within the relative `tolerance` of `exact`.
///
/// # Panics
/// When it is not, also when it is NaN.
#[track_caller]
pub fn assert_relative(found: f64, exact: f64, tolerance: f64) {
    let error = (found / exact - 1.0).abs();
    assert!(error <= tolerance, "{found} for {exact}, a relative error of {error:e}");
}

/// Asserts that `found` agrees with `exact` to `digits` significant digits as printed: half a unit of the last one.
///
/// # Panics
/// When it does not, also when it is NaN.
#[track_caller]
pub fn assert_digits(found: f64, exact: f64, digits: i32) {
    let unit = 10f64.powi(exact.abs().log10().floor() as i32 + 1 - digits);
    assert_near(found, exact, 0.5 * unit * (1.0 + 1e-9));
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

    #[test]
    fn relative_tolerances_hold_for_small_numbers() {
        assert_relative(-1.001e-9, -1e-9, 1.1e-3);
        assert!(std::panic::catch_unwind(|| assert_relative(1.01e-9, 1e-9, 1e-3)).is_err());
    }

    #[test]
    fn printed_digits_agree_to_half_a_unit_of_the_last() {
        assert_digits(123.449, 123.4, 4);
        assert_digits(-0.012_34, -0.0123, 3);
        assert!(std::panic::catch_unwind(|| assert_digits(123.46, 123.4, 4)).is_err());
    }
}
