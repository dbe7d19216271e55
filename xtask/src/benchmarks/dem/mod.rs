//! Discrete element method.

mod applications;
mod biaxial;
mod bounce;
mod case_builders;
mod collisions;
mod column;
mod contact_laws;
mod crystal;
mod drum;
mod fabric;
mod gas;
mod incline;
mod invariants;
mod laguerre_cells;
mod membranes;
mod oblique_impact;
mod plane_shear;
mod representative_disks;
mod representative_spheres;
mod rolling_slope;
mod static_equilibrium;
mod triaxial_sleeve;

use crate::benchmarks::Benchmark;

/// Benchmarks, in the order of the report.
pub const ALL: &[Benchmark] = &[
    collisions::BENCHMARK,
    invariants::BENCHMARK,
    laguerre_cells::BENCHMARK,
    bounce::BENCHMARK,
    oblique_impact::BENCHMARK,
    rolling_slope::BENCHMARK,
    rolling_slope::ROLLING,
    static_equilibrium::BENCHMARK,
    gas::BENCHMARK,
    contact_laws::BENCHMARK,
    contact_laws::BONDS,
    crystal::BENCHMARK,
    crystal::STRENGTH,
    plane_shear::BENCHMARK,
    plane_shear::TABLE,
    incline::BENCHMARK,
    column::BENCHMARK,
    column::ASPECT_SWEEP,
    drum::BENCHMARK,
    drum::FINE_DRUM,
    biaxial::BENCHMARK,
    biaxial::CRITICAL,
    fabric::BENCHMARK,
    representative_disks::BENCHMARK,
    representative_disks::WALLS,
    membranes::BENCHMARK,
    triaxial_sleeve::BENCHMARK,
    representative_disks::WINDOW_TESTS,
    representative_spheres::BENCHMARK,
    representative_spheres::WINDOW_TESTS,
    representative_spheres::WALLS,
    applications::BENCHMARK,
];
