//! What the tests share.

use colluvium_case::{Case, Method, RunOptions, RunReport, Snapshot, Solver, run};
use colluvium_mpm::Mpm;
use serde_json::Value;

/// An object with the keys of `more` at its top in place of its own.
pub fn with(mut object: Value, more: &Value) -> Value {
    object.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    object
}

/// The case `text` with the keys of `more` at its top in place of its own.
pub fn changed(text: Value, more: &Value) -> Case {
    Case::from_json(&with(text, more).to_string()).unwrap()
}

/// Runs a case to its end.
pub fn solve(case: &Case) -> RunReport {
    run(case, Mpm.build(case).unwrap(), &RunOptions::default()).unwrap()
}

/// A solver at the start of the first stage.
pub fn begin(case: &Case) -> Box<dyn Solver> {
    let mut solver = Mpm.build(case).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    solver
}

/// Takes steps as large as is stable.
pub fn advance(solver: &mut dyn Solver, steps: usize) {
    for _ in 0..steps {
        let dt = solver.time_step().dt;
        solver.step(dt).unwrap();
    }
}

/// Takes steps as large as is stable until the time is `end` (s) or later.
pub fn advance_to(solver: &mut dyn Solver, end: f64) {
    while solver.time() < end {
        advance(solver, 1);
    }
}

/// A field of scalars.
pub fn scalars(snapshot: &Snapshot, name: &str) -> Vec<f64> {
    snapshot.scalars(name).unwrap().to_vec()
}

/// A field of vectors.
pub fn vectors(snapshot: &Snapshot, name: &str) -> Vec<[f64; 3]> {
    snapshot.vectors(name).unwrap().to_vec()
}

/// The stresses (Pa).
pub fn stresses(snapshot: &Snapshot) -> Vec<[f64; 6]> {
    snapshot.tensors("stress").unwrap().iter().map(|s| s.0).collect()
}
