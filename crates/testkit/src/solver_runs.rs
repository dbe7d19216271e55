//! Cases and solvers for tests. Failures are errors of the test and panic.

use colluvium_case::{Case, Method, RunOptions, RunReport, Snapshot, Solver, run};
use serde_json::Value;

/// Object with its top-level keys replaced by those of `more`.
pub fn with_keys(mut object: Value, more: &Value) -> Value {
    object.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    object
}

/// Reads a case, which must be valid.
#[track_caller]
pub fn read_case(text: &Value) -> Case {
    Case::from_json(&text.to_string()).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Error about the case of a text: it is invalid, or the method rejects it.
#[track_caller]
pub fn refusal(method: &dyn Method, text: &Value) -> String {
    match Case::from_json(&text.to_string()) {
        Err(errors) => errors.to_string(),
        Ok(case) => method.plan(&case).expect_err("the case is refused").to_string(),
    }
}

/// Case of `text` with its top-level keys replaced by those of `more`.
#[track_caller]
pub fn case_with(text: Value, more: &Value) -> Case {
    read_case(&with_keys(text, more))
}

/// Restricts the parallel loops of the calling thread to that thread. Tests run in parallel on all threads of a machine, and loops in the
/// global pool would wake its threads at each step. A thread of another pool stays in that pool.
pub fn single_threaded() {
    if rayon::current_thread_index().is_none() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().unwrap();
        // The thread belongs to the pool until it ends.
        std::mem::forget(pool);
    }
}

/// Runs a case to its end.
pub fn solve(method: &dyn Method, case: &Case) -> RunReport {
    single_threaded();
    run(case, method.build(case).unwrap(), &RunOptions::default()).unwrap()
}

/// Solver at the start of the first stage.
pub fn start_solver(method: &dyn Method, case: &Case) -> Box<dyn Solver> {
    single_threaded();
    build_solver(method, case)
}

/// Solver in its first stage, restored from a saved state.
pub fn resume_solver(method: &dyn Method, case: &Case, saved: &[u8]) -> Box<dyn Solver> {
    single_threaded();
    let mut solver = method.build(case).unwrap();
    solver.restore(&mut &saved[..]).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    solver
}

/// Solver of a case at the start of its first stage.
fn build_solver(method: &dyn Method, case: &Case) -> Box<dyn Solver> {
    let mut solver = method.build(case).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    solver
}

// Steps run on a thread of a pool, as in a run: from any other thread each loop of a step would wake a thread of the pool.

/// Takes `steps` steps of the largest stable size.
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

/// Takes steps of the largest stable size until the time is `end` (s) or later.
pub fn advance_to(solver: &mut dyn Solver, end: f64) {
    rayon::scope(|_| {
        while solver.time() < end {
            advance_steps(solver, 1);
        }
    });
}

/// Takes steps of the largest stable size, the last one shorter, so that the time at the end is `end` (s).
pub fn advance_exactly_to(solver: &mut dyn Solver, end: f64) {
    rayon::scope(|_| {
        while solver.time() < end - 1e-12 {
            solver.step(end - solver.time()).unwrap();
        }
    });
}

/// Hash of the state after `steps` steps on a pool of `threads` threads. With `restart`, the solver is saved before that step and a new one
/// continues.
pub fn hash_after(
    method: &dyn Method,
    text: &Value,
    threads: usize,
    steps: usize,
    restart: Option<usize>,
) -> u64 {
    let case = read_case(text);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let mut solver = build_solver(method, &case);
        for step in 0..steps {
            if restart == Some(step) {
                solver = resume_solver(method, &case, &solver.checkpoint_bytes().unwrap());
            }
            solver.step(1.0).unwrap();
        }
        solver.snapshot().hash()
    })
}

/// Asserts that a run of the case has equal bits on one thread and on two; `name` is the case in the message.
#[track_caller]
pub fn assert_same_on_threads(method: &dyn Method, case: &Case, name: &str) {
    let hash = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solve(method, case).snapshot.hash())
    };
    assert_eq!(hash(1), hash(2), "{name}: hashes on one thread and on two");
}

/// Asserts that a solver restored from a checkpoint has equal bits. The solver is advanced, saved, and advanced again.
#[track_caller]
pub fn assert_same_after_restart(method: &dyn Method, case: &Case, advance: impl Fn(&mut dyn Solver)) {
    let mut whole = start_solver(method, case);
    advance(&mut *whole);
    let mut restored = resume_solver(method, case, &whole.checkpoint_bytes().unwrap());
    advance(&mut *whole);
    advance(&mut *restored);
    assert_eq!(restored.snapshot().hash(), whole.snapshot().hash(), "hashes without and with a restart");
}

/// Asserts that thirty steps of `case` allocate no memory, after `first` steps in which lists and the queues of the threads may still grow.
/// The test's allocator is [`CountingAllocator`](crate::CountingAllocator), and no other test runs in parallel.
///
/// # Panics
/// When a step allocates; `name` is the case in the message.
pub fn assert_allocates_nothing(method: &dyn Method, case: &Case, first: usize, name: &str) {
    let mut solver = build_solver(method, case);
    advance_steps(&mut *solver, first);
    let count = crate::allocations_during(|| advance_steps(&mut *solver, 30));
    assert_eq!(count, 0, "{name}: allocations in 30 steps");
}

/// Current value of a scalar output of a solver.
#[track_caller]
pub fn scalar_output(solver: &dyn Solver, name: &str) -> f64 {
    let outputs = solver.scalar_outputs();
    outputs.iter().find(|(own, ..)| own == name).unwrap_or_else(|| panic!("no output {name}")).2
}

/// Values of a scalar field.
pub fn scalars(snapshot: &Snapshot, name: &str) -> Vec<f64> {
    snapshot.scalars(name).unwrap().to_vec()
}

/// Values of a vector field.
pub fn vectors(snapshot: &Snapshot, name: &str) -> Vec<[f64; 3]> {
    snapshot.vectors(name).unwrap().to_vec()
}

/// Stresses of the points (Pa).
pub fn stresses(snapshot: &Snapshot) -> Vec<[f64; 6]> {
    snapshot.tensors("stress").unwrap().iter().map(|s| s.0).collect()
}
