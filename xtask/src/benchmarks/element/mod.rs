//! Laws at one material point.

mod basal_laws;
mod critical_state;
mod elastic_tests;
mod element_tests;
mod finite_strain;
mod flow_cycles;
mod flow_laws;
mod law_contract;
mod localisation;
mod return_mappings;

use crate::benchmarks::Benchmark;

/// Benchmarks, in the order of the report.
pub const ALL: &[Benchmark] = &[
    element_tests::BENCHMARK,
    return_mappings::BENCHMARK,
    law_contract::BENCHMARK,
    critical_state::BENCHMARK,
    flow_laws::BENCHMARK,
    finite_strain::BENCHMARK,
    localisation::BENCHMARK,
];
