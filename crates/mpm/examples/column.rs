//! Collapse of a column of sand: a case described in Rust, and a loop of the program over its steps.

use colluvium_case::{Body, Case, Domain, Side, Space, Stage, Wall};
use colluvium_constitutive::MohrCoulombSpec;
use colluvium_mpm::{Mpm, MpmOptions, ShapeFunctions};

/// Front of the deposit (m) and largest velocity (m/s) of a column of sand with a cohesion (Pa).
pub fn collapse(cohesion: f64) -> Result<[f64; 2], Box<dyn std::error::Error>> {
    let sand = MohrCoulombSpec { cohesion, ..MohrCoulombSpec::new(1925.0, 1.98e6, 0.23, 31.0) };
    let case = Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [0.5, 0.15]))
        .gravity([0.0, -9.81])
        .material("sand", sand)
        .body(Body::block("column", "sand", [0.0, 0.0], [0.1, 0.1]))
        .wall(Side::XMin, Wall::Smooth)
        .wall(Side::YMin, Wall::frictional(1.0))
        .stage(Stage::new("release", 0.6));
    let options = MpmOptions { shape: ShapeFunctions::Ugimp, ..MpmOptions::new(0.005) };
    let mut solver = Mpm::new(options).solver::<2>(&case)?;
    let mut fastest = 0.0;
    while solver.time() < 0.6 {
        solver.step()?;
        fastest = solver.points().velocity().iter().map(|v| v[0]).fold(fastest, f64::max);
    }
    let front = solver.points().position().iter().map(|x| x[0]).fold(0.0, f64::max);
    Ok([front, fastest])
}

/// Prints the front of a column that collapses, and of one that stands.
fn main() -> Result<(), Box<dyn std::error::Error>> {
    for cohesion in [20.0, 500.0] {
        let [front, fastest] = collapse(cohesion)?;
        println!("cohesion {cohesion} Pa: front at {front:.3} m, largest velocity {fastest:.2} m/s");
    }
    Ok(())
}
