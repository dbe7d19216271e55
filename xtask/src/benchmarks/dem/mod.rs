//! Discrete element method.

mod biaxial;
mod bookkeeping;
mod bounce;
mod collisions;
mod column;
mod crystal;
mod fabric;
mod gas;
mod laws;
mod oblique;
mod plane_shear;
mod rest;
mod scene;
mod slope;

use crate::benchmarks::Benchmark;

/// The benchmarks, in the order of the report.
pub const ALL: &[Benchmark] = &[
    collisions::BENCHMARK,
    bookkeeping::BENCHMARK,
    bounce::BENCHMARK,
    oblique::BENCHMARK,
    slope::BENCHMARK,
    slope::ROLLING,
    rest::BENCHMARK,
    gas::BENCHMARK,
    laws::BENCHMARK,
    laws::BONDS,
    crystal::BENCHMARK,
    crystal::STRENGTH,
    plane_shear::BENCHMARK,
    plane_shear::TABLE,
    column::BENCHMARK,
    column::SWEEP,
    biaxial::BENCHMARK,
    biaxial::CRITICAL,
    fabric::BENCHMARK,
];
