//! Smoothed particle hydrodynamics.

mod balance;
mod cantilever;
mod cantilever_3d;
mod cavity;
mod clay;
mod column;
mod columns;
mod critical;
mod cylinders;
mod dam_pressure;
mod drum;
mod flow;
mod footing;
mod geostatic;
mod membrane;
mod operators;
mod pairing;
mod ranks;
mod ring;
mod shear;
mod slope;
mod tensile;
mod threads;
mod vortices;
mod waves;

use crate::benchmarks::Benchmark;

/// The benchmarks, in the order of the report.
pub const ALL: &[Benchmark] = &[
    operators::BENCHMARK,
    balance::BENCHMARK,
    waves::BENCHMARK,
    flow::BENCHMARK,
    vortices::BENCHMARK,
    cavity::BENCHMARK,
    dam_pressure::BENCHMARK,
    shear::BENCHMARK,
    pairing::BENCHMARK,
    geostatic::BENCHMARK,
    column::BENCHMARK,
    slope::BENCHMARK,
    tensile::BENCHMARK,
    ring::BENCHMARK,
    cantilever_3d::BENCHMARK,
    cantilever_3d::UPDATED,
    drum::BENCHMARK,
    drum::FINE,
    threads::BENCHMARK,
    ranks::BENCHMARK,
    critical::SHEAR,
    critical::COLUMNS,
    critical::COLUMNS_FINE,
    cantilever::BENCHMARK,
    columns::BENCHMARK,
    columns::SWEEP,
    clay::BENCHMARK,
    clay::FINE,
    cylinders::BENCHMARK,
    footing::BENCHMARK,
    footing::SMOOTH,
    footing::SOILS,
    footing::SOILS_FINE,
    membrane::BENCHMARK,
];
