//! Discrete element method.

mod applications;
mod biaxial;
mod bookkeeping;
mod bounce;
mod cells;
mod collisions;
mod column;
mod crystal;
mod drum;
mod fabric;
mod gas;
mod incline;
mod laws;
mod membranes;
mod oblique;
mod plane_shear;
mod representative;
mod representative_spheres;
mod rest;
mod scene;
mod slope;
mod triaxial_sleeve;

use crate::benchmarks::Benchmark;

/// The benchmarks, in the order of the report.
pub const ALL: &[Benchmark] = &[
    collisions::BENCHMARK,
    bookkeeping::BENCHMARK,
    cells::BENCHMARK,
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
    incline::BENCHMARK,
    column::BENCHMARK,
    column::SWEEP,
    drum::BENCHMARK,
    drum::FINE,
    biaxial::BENCHMARK,
    biaxial::CRITICAL,
    fabric::BENCHMARK,
    representative::BENCHMARK,
    representative::WALLS,
    membranes::BENCHMARK,
    triaxial_sleeve::BENCHMARK,
    representative::WINDOWS,
    representative_spheres::BENCHMARK,
    representative_spheres::WINDOWS,
    representative_spheres::WALLS,
    applications::BENCHMARK,
];
