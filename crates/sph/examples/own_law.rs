//! Flow of a shear-thinning liquid between two plates: a law of the program, and the closed form of its velocity.

use std::sync::Arc;

use colluvium_case::{Axis, Body, Case, Domain, Side, Space, Stage, Wall};
use colluvium_constitutive::{
    InitialCondition, Law, MaterialError, Motion, Point, PointLaw, StressUpdate, SymTensor,
};
use colluvium_sph::{Kernel, RoughWall, Sph, SphOptions, VelocityGradientOperator};

/// Liquid whose shear stress is a constant (Pa √s) times the root of the shear rate (1/s).
struct PowerLaw(f64);

impl Law for PowerLaw {
    fn name(&self) -> &'static str {
        "power-law"
    }
}

impl PointLaw for PowerLaw {
    /// Viscosity (Pa s) in the last step.
    type State = f64;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<f64>, MaterialError> {
        Ok(Point { stress: initial.stress, state: 0.0 })
    }

    fn wave_modulus(&self, _: &Point<f64>) -> f64 {
        1e4
    }

    fn viscosity(&self, point: &Point<f64>) -> f64 {
        point.state
    }
}

impl StressUpdate for PowerLaw {
    fn update(&self, motion: &Motion, _: &Point<f64>) -> Result<Point<f64>, MaterialError> {
        let rate = (motion.strain_increment() * (1.0 / motion.dt)).deviator();
        let viscosity = self.0 / (rate.norm() * 2f64.sqrt()).max(0.1).sqrt();
        let pressure = 1e4 * (motion.density / 1000.0 - 1.0);
        Ok(Point { stress: rate * (2.0 * viscosity) - SymTensor::isotropic(pressure), state: viscosity })
    }
}

/// Computes the steady flow under a gradient of 1000 Pa/m in a channel of 0.1 m and compares its velocity in the middle.
fn main() -> Result<(), Box<dyn std::error::Error>> {
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
    println!("{fastest:.4} m/s of {exact:.4} m/s");
    assert!((fastest / exact - 1.0).abs() < 0.05);
    Ok(())
}
