//! Program that steps the solver of each method and prints the time of a step of each.
//!
//! `cargo xtask downstream` copies it out of the repository, builds it with the defaults of Cargo and with the profile of the repository, and
//! compares the times.

use std::error::Error;
use std::time::Instant;

use colluvium_case::{Body, Case, Domain, Side, Simulation, Solver, Space, Stage, Wall};
use colluvium_constitutive::{LinearElasticSpec, MohrCoulombSpec};
use colluvium_dem::{Dem, DemOptions, Diameters, Fill, GrainKind, NormalLaw, PairSpec};
use colluvium_depth_sph::{DepthOptions, DepthSph};
use colluvium_mpm::{Mpm, MpmOptions, ShapeFunctions};
use colluvium_snow_mpm::{SnowMpm, SnowOptions};
use colluvium_sph::{Sph, SphOptions};

/// Steps before the measurement, in which the memory of the solver grows to its size.
const FIRST_STEPS: u32 = 10;

/// Column of sand in a box with smooth sides.
fn column() -> Case {
    let sand = MohrCoulombSpec { cohesion: 500.0, ..MohrCoulombSpec::new(1925.0, 1.98e6, 0.23, 31.0) };
    Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [0.5, 0.15]))
        .gravity([0.0, -9.81])
        .material("sand", sand)
        .body(Body::block("column", "sand", [0.0, 0.0], [0.1, 0.1]))
        .wall(Side::XMin, Wall::Smooth)
        .wall(Side::YMin, Wall::frictional(1.0))
        .stage(Stage::new("release", 10.0))
}

/// Cell of grains between four walls.
fn grains() -> Result<(Case, DemOptions), Box<dyn Error>> {
    let mut case = Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [0.2, 0.2]))
        .gravity([0.0, -9.81])
        .material("sand", LinearElasticSpec::new(2650.0, 1e7, 0.3))
        .body(Body::block("cell", "sand", [0.0, 0.0], [0.2, 0.2]))
        .stage(Stage::new("fall", 10.0));
    for side in [Side::XMin, Side::XMax, Side::YMin, Side::YMax] {
        case = case.wall(side, Wall::Smooth);
    }
    let diameters = Diameters::Uniform { min: 2e-3, max: 3e-3 };
    let sand = GrainKind::filled(2650.0, diameters, Fill::Random { solid_fraction: 0.75 });
    let law = NormalLaw::linear(1e7).restitution(0.3);
    Ok((case, DemOptions::new([("sand", sand)], [PairSpec::new(["sand", "sand"], law).friction(0.3)])))
}

/// Prints the mean time of a step of the solver, and the hash of its state at the end. `read` is called after each step.
fn measure<S: Solver>(
    name: &str,
    steps: u32,
    solver: Result<Simulation<S>, colluvium_case::CaseErrors>,
    mut read: impl FnMut(&Simulation<S>),
) -> Result<(), Box<dyn Error>> {
    let mut solver = solver?;
    for _ in 0..FIRST_STEPS {
        solver.step()?;
    }
    let start = Instant::now();
    for _ in 0..steps {
        solver.step()?;
        read(&solver);
    }
    let step = start.elapsed().as_secs_f64() / f64::from(steps);
    println!("{name} {step:e} {:016x}", solver.snapshot().hash());
    Ok(())
}

/// Measures the solvers; with RAYON_NUM_THREADS=1 in the environment on one thread.
fn main() -> Result<(), Box<dyn Error>> {
    let options = MpmOptions { shape: ShapeFunctions::Ugimp, ..MpmOptions::new(1e-3) };
    measure("mpm", 200, Mpm::new(options.clone()).solver::<2>(&column()), |_| {})?;
    let mut fastest = f64::NEG_INFINITY;
    measure("mpm-with-reading", 200, Mpm::new(options).solver::<2>(&column()), |solver| {
        fastest = solver.points().velocity().iter().map(|v| v[0]).fold(fastest, f64::max);
    })?;
    measure("snow-mpm", 100, SnowMpm::new(SnowOptions::new(2e-3)).solver::<2>(&column()), |_| {})?;
    measure("sph", 60, Sph::new(SphOptions::new(1e-3)).solver::<2>(&column()), |_| {})?;
    measure("depth-sph", 2000, DepthSph::new(DepthOptions::new(1e-4)).solver::<1>(&column()), |_| {})?;
    let (case, options) = grains()?;
    measure("dem", 500, Dem::new(options).solver::<2>(&case), |_| {})?;
    assert!(fastest.is_finite(), "the column has points");
    Ok(())
}
