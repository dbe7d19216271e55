//! Helpers shared by the tests.

use colluvium_case::{Case, RunReport, Solver};
use colluvium_sph::Sph;
use colluvium_testkit::solver_runs as cases;

pub use colluvium_testkit::solver_runs::{advance_steps, case_with, scalars, stresses, vectors, with_keys};

/// Runs a case to its end.
pub fn solve(case: &Case) -> RunReport {
    cases::solve(&Sph, case)
}

/// Solver at the start of the first stage.
pub fn begin(case: &Case) -> Box<dyn Solver> {
    cases::start_solver(&Sph, case)
}
