//! Depth-integrated smoothed particle hydrodynamics.

mod block;
mod cap;
mod column;
mod deposit;
mod incline;
mod invariants;
mod lake;
mod locked;
mod open_end;
mod parts;
mod ritter;
mod rough;
mod scalar;
mod stoker;
mod terrain;
mod thacker;
mod uniform;
mod yu_tung;

use crate::benchmarks::Benchmark;

/// The benchmarks, in the order of the report.
pub const ALL: &[Benchmark] = &[
    scalar::BENCHMARK,
    ritter::BENCHMARK,
    stoker::BENCHMARK,
    lake::BENCHMARK,
    incline::BENCHMARK,
    cap::BENCHMARK,
    uniform::BENCHMARK,
    column::BENCHMARK,
    block::BENCHMARK,
    thacker::BENCHMARK,
    invariants::BENCHMARK,
    locked::BENCHMARK,
    open_end::BENCHMARK,
    deposit::SATURATED,
    deposit::MUD,
    terrain::RASTER,
    rough::BENCHMARK,
    terrain::DEBRIS,
    yu_tung::BENCHMARK,
];
