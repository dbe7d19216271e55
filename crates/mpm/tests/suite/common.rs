//! Functions that the tests share.

use colluvium_case::{Case, RunReport, Solver};
use colluvium_mpm::Mpm;
use colluvium_testkit::solver_runs as cases;

pub use colluvium_testkit::solver_runs::{
    advance_steps, advance_to, case_with, scalars, stresses, take_steps, vectors, with_keys,
};

/// Runs a case to its end.
pub fn solve(case: &Case) -> RunReport {
    cases::solve(&Mpm, case)
}

/// A solver at the start of the first stage.
pub fn begin(case: &Case) -> Box<dyn Solver> {
    cases::start_solver(&Mpm, case)
}

/// Current value of a scalar output.
pub fn scalar_output(solver: &dyn Solver, name: &str) -> f64 {
    solver.scalar_outputs().into_iter().find(|(own, ..)| own == name).unwrap().2
}
