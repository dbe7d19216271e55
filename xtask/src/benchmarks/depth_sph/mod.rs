//! Depth-integrated smoothed particle hydrodynamics.

mod block;
mod common_cases;
mod consolidation;
mod deposit;
mod incline;
mod invariants;
mod lake_at_rest;
mod open_boundary;
mod parabolic_cap;
mod ritter;
mod rough_terrain;
mod scalar_transport;
mod stoker;
mod terrain;
mod thacker;
mod two_phase_dam_break;
mod uniform_flow;
mod yu_tung;

use crate::benchmarks::Benchmark;

/// Benchmarks, in the order of the report.
pub const ALL: &[Benchmark] = &[
    scalar_transport::BENCHMARK,
    ritter::BENCHMARK,
    stoker::BENCHMARK,
    lake_at_rest::BENCHMARK,
    incline::BENCHMARK,
    parabolic_cap::BENCHMARK,
    uniform_flow::BENCHMARK,
    consolidation::BENCHMARK,
    block::BENCHMARK,
    thacker::BENCHMARK,
    invariants::BENCHMARK,
    two_phase_dam_break::BENCHMARK,
    open_boundary::BENCHMARK,
    deposit::SATURATED_DEPOSIT,
    deposit::MUD,
    terrain::RASTER,
    rough_terrain::BENCHMARK,
    terrain::DEBRIS,
    yu_tung::BENCHMARK,
];
