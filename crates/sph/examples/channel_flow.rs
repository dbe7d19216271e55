//! Flow of a shear-thinning liquid between two plates: a law of the program, and the closed form of its velocity.

use std::error::Error;
use std::sync::Arc;

use colluvium_case::{Axis, Body, Case, Domain, Side, Space, Stage, Wall};
use colluvium_sph::{Kernel, RoughWall, Sph, SphOptions, VelocityGradientOperator};
use power_law::PowerLaw;

#[path = "laws/power_law.rs"]
mod power_law;

/// Velocity (m/s) in the middle of a channel of 0.1 m in steady flow under a gradient of 1000 Pa/m, and its closed form.
pub fn velocity_in_the_middle() -> Result<[f64; 2], Box<dyn Error>> {
    let domain = Domain { periodic: vec![Axis::X], ..Domain::new([0.0, 0.0], [0.05, 0.1]) };
    let case = Case::new(Space::PlaneStrain, domain)
        .gravity([1.0, 0.0])
        .law("liquid", 1000.0, Arc::new(PowerLaw(20.0)))
        .body(Body::block("liquid", "liquid", [0.0, 0.0], [0.05, 0.1]))
        .wall(Side::YMin, Wall::Rough)
        .wall(Side::YMax, Wall::Rough)
        .stage(Stage::new("flow", 1.0));
    let options = SphOptions {
        kernel: Kernel::WendlandC2,
        smoothing: 1.5,
        viscosity_linear: 0.0,
        velocity_gradient: VelocityGradientOperator::Corrected,
        rough_wall: RoughWall::Mirror,
        hourglass_viscosity: 1.0,
        ..SphOptions::new(0.005)
    };
    let mut solver = Sph::new(options).solver::<2>(&case)?;
    solver.step_to(1.0)?;
    let fastest = solver.particles().velocity().iter().map(|v| v[0]).fold(0.0, f64::max);
    // (1/3) (ρ g / k)² (H/2)³.
    let exact = (1000.0f64 / 20.0).powi(2) * 0.05f64.powi(3) / 3.0;
    Ok([fastest, exact])
}

/// Prints the velocity.
fn main() -> Result<(), Box<dyn Error>> {
    let [fastest, exact] = velocity_in_the_middle()?;
    println!("{fastest:.4} m/s of {exact:.4} m/s");
    Ok(())
}
