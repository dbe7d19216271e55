//! Finite-strain material point method of snow.

mod avalanche;
mod bar;
mod cantilever;
mod column;
mod incline;
mod manufactured;
mod microstructure;
mod oedometer;
mod propagation_saw_test;
mod remote_triggering;
mod return_mappings;
mod rigid_motion;
mod snowball;
mod softening;

use colluvium::case::{Case, RunReport};
use serde_json::Value;

use crate::benchmarks::{Benchmark, load_case, run_in_memory, set_method_option};

/// Benchmarks, in the order of the report.
pub const ALL: &[Benchmark] = &[
    return_mappings::BENCHMARK,
    softening::BENCHMARK,
    rigid_motion::BENCHMARK,
    bar::VIBRATION,
    bar::SELF_WEIGHT,
    manufactured::BENCHMARK,
    oedometer::BENCHMARK,
    incline::BENCHMARK,
    cantilever::BENCHMARK,
    snowball::BENCHMARK,
    column::BENCHMARK,
    propagation_saw_test::CRITICAL,
    propagation_saw_test::SPEED,
    avalanche::BENCHMARK,
    microstructure::BENCHMARK,
    remote_triggering::BENCHMARK,
];

/// Case `validation/snow-mpm/<name>/case.json` with some options of the method changed.
fn case_with_options(name: &str, options: &Value) -> Result<Case, String> {
    let mut case = load_case(&format!("snow-mpm/{name}"))?;
    for (key, value) in options.as_object().into_iter().flatten() {
        set_method_option(&mut case, "snow-mpm", key, value.clone());
    }
    Ok(case)
}

/// Runs a case in memory, with all frames.
fn run_snow_case(case: &Case) -> Result<RunReport, String> {
    run_in_memory("snow-mpm", case)
}
