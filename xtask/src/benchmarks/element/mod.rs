//! Laws at one material point.

mod contract;
mod critical_state;
mod element_tests;
mod finite_strain;
mod flow;
mod flow_cycles;
mod localisation;
mod returns;

use crate::benchmarks::Benchmark;

/// The benchmarks, in the order of the report.
pub const ALL: &[Benchmark] = &[
    element_tests::BENCHMARK,
    returns::BENCHMARK,
    contract::BENCHMARK,
    critical_state::BENCHMARK,
    flow::BENCHMARK,
    finite_strain::BENCHMARK,
    localisation::BENCHMARK,
];
