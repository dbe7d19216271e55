//! Cases and solvers. Whatever fails here is the test's own mistake, and panics.

use colluvium_case::{Case, Method, RunOptions, RunReport, Snapshot, Solver, run};
use serde_json::Value;

/// An object with the keys of `more` at its top in place of its own.
pub fn with_keys(mut object: Value, more: &Value) -> Value {
    object.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    object
}

/// The case `text` with the keys of `more` at its top in place of its own.
pub fn case_with(text: Value, more: &Value) -> Case {
    Case::from_json(&with_keys(text, more).to_string()).unwrap()
}

/// Leaves what the caller's thread computes in parallel to that thread. Tests keep all threads of a machine busy side by side, and loops of a
/// step that go to the pool of all would wake its threads each time. What runs in a pool already stays there.
pub fn single_threaded() {
    if rayon::current_thread_index().is_none() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().unwrap();
        // The thread is of the pool for as long as it lives.
        std::mem::forget(pool);
    }
}

/// Runs a case to its end.
pub fn solve(method: &dyn Method, case: &Case) -> RunReport {
    single_threaded();
    run(case, method.build(case).unwrap(), &RunOptions::default()).unwrap()
}

/// A solver at the start of the first stage.
pub fn start_solver(method: &dyn Method, case: &Case) -> Box<dyn Solver> {
    single_threaded();
    build_solver(method, case)
}

fn build_solver(method: &dyn Method, case: &Case) -> Box<dyn Solver> {
    let mut solver = method.build(case).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    solver
}

// Steps are taken on a thread of a pool, as runs take them: each loop of a step would wake one from any other.

/// Takes steps as large as is stable.
pub fn advance_steps(solver: &mut dyn Solver, steps: usize) {
    rayon::scope(|_| {
        for _ in 0..steps {
            let dt = solver.limit().dt;
            solver.step(dt).unwrap();
        }
    });
}

/// Takes `count` steps of `dt` (s).
pub fn take_steps(solver: &mut dyn Solver, count: usize, dt: f64) {
    rayon::scope(|_| {
        for _ in 0..count {
            solver.step(dt).unwrap();
        }
    });
}

/// Takes steps as large as is stable until the time is `end` (s) or later.
pub fn advance_to(solver: &mut dyn Solver, end: f64) {
    rayon::scope(|_| {
        while solver.time() < end {
            advance_steps(solver, 1);
        }
    });
}

/// Asserts that thirty steps of `case` allocate nothing, after `first` steps that may: lists and the queues of the threads
/// grow in them. The test's allocator is [`CountingAllocator`](crate::CountingAllocator), and it runs alone.
///
/// # Panics
/// When a step allocates; `name` says which case it was.
pub fn assert_allocates_nothing(method: &dyn Method, case: &Case, first: usize, name: &str) {
    let mut solver = build_solver(method, case);
    advance_steps(&mut *solver, first);
    let count = crate::allocations_during(|| advance_steps(&mut *solver, 30));
    assert_eq!(count, 0, "{name}: allocations in 30 steps");
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
