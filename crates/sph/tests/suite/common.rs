//! What the tests share.

use colluvium_case::{Case, Method, RunOptions, RunReport, Snapshot, Solver, run};
use colluvium_sph::Sph;
use serde_json::Value;

/// The case `text` with the keys of `more` at its top in place of its own.
pub fn changed(mut text: Value, more: &Value) -> Case {
    for (key, value) in more.as_object().unwrap() {
        text[key] = value.clone();
    }
    Case::from_json(&text.to_string()).unwrap()
}

/// Runs a case to its end.
pub fn solve(case: &Case) -> RunReport {
    run(case, Sph.build(case).unwrap(), &RunOptions::default()).unwrap()
}

/// A solver at the start of the first stage.
pub fn begin(case: &Case) -> Box<dyn Solver> {
    let mut solver = Sph.build(case).unwrap();
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
