//! Smoothed particle hydrodynamics.

mod cantilever;
mod cantilever_3d;
mod cavity;
mod column;
mod column_collapse;
mod conservation;
mod critical_state;
mod cylinders;
mod dam_pressure;
mod domain_decomposition;
mod drum;
mod footing;
mod geostatic;
mod membrane;
mod operators;
mod pairing;
mod ring;
mod sensitive_clay;
mod simple_shear;
mod slope;
mod tensile;
mod threads;
mod viscous_flow;
mod vortices;
mod waves;

use crate::benchmarks::Benchmark;

/// Benchmarks, in the order of the report.
pub const ALL: &[Benchmark] = &[
    operators::BENCHMARK,
    conservation::BENCHMARK,
    waves::BENCHMARK,
    viscous_flow::BENCHMARK,
    vortices::BENCHMARK,
    cavity::BENCHMARK,
    dam_pressure::BENCHMARK,
    simple_shear::BENCHMARK,
    pairing::BENCHMARK,
    geostatic::BENCHMARK,
    column::BENCHMARK,
    slope::BENCHMARK,
    tensile::BENCHMARK,
    ring::BENCHMARK,
    cantilever_3d::BENCHMARK,
    cantilever_3d::UPDATED_LAGRANGIAN,
    drum::BENCHMARK,
    drum::FINE_DRUM,
    threads::BENCHMARK,
    domain_decomposition::BENCHMARK,
    critical_state::SHEAR,
    critical_state::COLUMNS,
    critical_state::COLUMNS_FINE,
    cantilever::BENCHMARK,
    column_collapse::BENCHMARK,
    column_collapse::ASPECT_SWEEP,
    sensitive_clay::BENCHMARK,
    sensitive_clay::FINE_RUNS,
    cylinders::BENCHMARK,
    footing::BENCHMARK,
    footing::SMOOTH,
    footing::SOILS,
    footing::SOILS_FINE,
    membrane::BENCHMARK,
];
