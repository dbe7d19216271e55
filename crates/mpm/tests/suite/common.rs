//! What the tests share.

use colluvium_case::{Case, RunReport, Solver};
use colluvium_mpm::Mpm;
use colluvium_testkit::cases;

pub use colluvium_testkit::cases::{advance, advance_to, changed, scalars, steps, stresses, vectors, with};

/// Runs a case to its end.
pub fn solve(case: &Case) -> RunReport {
    cases::solve(&Mpm, case)
}

/// A solver at the start of the first stage.
pub fn begin(case: &Case) -> Box<dyn Solver> {
    cases::begin(&Mpm, case)
}

/// What a method tells of its state under this name, at the time.
pub fn reading(solver: &dyn Solver, name: &str) -> f64 {
    solver.readings().into_iter().find(|(own, ..)| own == name).unwrap().2
}
