//! Functions shared by tests of runs.

use std::path::Path;

use colluvium_case::{Case, Method, Solver};
use colluvium_depth_sph::DepthSph;
use colluvium_depth_sph::flow::Flow;
use colluvium_points::Raster;
use colluvium_testkit::solver_runs::{single_threaded, start_solver};
use serde_json::Value;

/// Builds the solver of a case at the beginning of its first stage.
pub fn build(value: &Value) -> Box<dyn Solver> {
    start_solver(&DepthSph, &Case::from_json(&value.to_string()).unwrap())
}

/// Error with which a case is rejected.
pub fn refused(value: &Value) -> String {
    let case = Case::from_json(&value.to_string()).unwrap();
    DepthSph.plan(&case).map(|_| ()).unwrap_err().to_string()
}

/// Hash of the state after `steps` steps on a pool of `threads` threads, with a restart before step `restart` where there is one.
pub fn hash_after(value: &Value, threads: usize, steps: usize, restart: Option<usize>) -> u64 {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let mut solver = build(value);
        for step in 0..steps {
            if restart == Some(step) {
                let bytes = solver.checkpoint_bytes().unwrap();
                solver = build(value);
                solver.restore(&mut &bytes[..]).unwrap();
                solver.begin_stage(0, 0.0).unwrap();
            }
            solver.step(1.0).unwrap();
        }
        solver.snapshot().hash()
    })
}

/// Takes the largest stable steps until the time is `end` (s).
pub fn until(solver: &mut dyn Solver, end: f64) {
    while solver.time() < end - 1e-12 {
        solver.step(end - solver.time()).unwrap();
    }
}

/// Takes the largest stable steps until the time is `end` (s).
pub fn run<const D: usize>(flow: &mut Flow<D>, end: f64) {
    single_threaded();
    while flow.clock.time < end {
        let dt = flow.limit().dt.min(end - flow.clock.time);
        flow.advance(dt).unwrap();
    }
}

/// Writes an ESRI ASCII grid of `z` over a window.
pub fn grid(file: &Path, low: [f64; 2], counts: [usize; 2], spacing: f64, z: impl Fn(f64, f64) -> f64) {
    let raster = Raster::from_function(counts, low, [spacing; 2], z);
    let mut text = format!(
        "ncols {}\nnrows {}\nxllcenter {}\nyllcenter {}\ncellsize {spacing}\nnodata_value -9999\n",
        counts[0], counts[1], low[0], low[1]
    );
    for row in (0..counts[1]).rev() {
        for column in 0..counts[0] {
            let z = raster.value(column, row);
            text += &format!("{:?} ", if z.is_finite() { z } else { -9999.0 });
        }
        text.push('\n');
    }
    std::fs::write(file, text).unwrap();
}
