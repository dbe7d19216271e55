//! What tests of runs share.

use colluvium_case::{Case, Solver};
use colluvium_depth_sph::DepthSph;
use colluvium_depth_sph::flow::Flow;
use colluvium_testkit::cases::begin;
use serde_json::Value;

/// The solver of a case at the beginning of its first stage.
pub fn build(value: &Value) -> Box<dyn Solver> {
    begin(&DepthSph, &Case::from_json(&value.to_string()).unwrap())
}

/// Hash of the state after so many steps on a pool of so many threads, with a restart before step `restart` where there is one.
pub fn hash_after(value: &Value, threads: usize, steps: usize, restart: Option<usize>) -> u64 {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let mut solver = build(value);
        for step in 0..steps {
            if restart == Some(step) {
                let bytes = solver.saved().unwrap();
                solver = build(value);
                solver.restore(&mut &bytes[..]).unwrap();
                solver.begin_stage(0, 0.0).unwrap();
            }
            solver.step(1.0).unwrap();
        }
        solver.snapshot().hash()
    })
}

/// Takes steps as large as is stable until the time is `end` (s).
pub fn run<const D: usize>(flow: &mut Flow<D>, end: f64) {
    while flow.time < end {
        let dt = flow.limit().dt.min(end - flow.time);
        flow.advance(dt).unwrap();
    }
}
