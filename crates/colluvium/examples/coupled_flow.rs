//! Water that runs against an elastic wall: depth-integrated SPH and MPM, coupled by hand.

use std::error::Error;

use colluvium::case::{Body, Case, Domain, Side, Solver, Space, Stage, Wall};
use colluvium::constitutive::{LinearElasticSpec, NewtonianFluidSpec};
use colluvium::depth_sph::{DepthOptions, DepthSph};
use colluvium::mpm::{Mpm, MpmOptions};

/// Length of the reach (m), and depth of the arriving water and of the water behind the reflected bore (m).
const LENGTH: f64 = 20.0;
const DEPTHS: [f64; 2] = [1.0, 1.6];

/// Gravity (m/s²), densities of water and wall (kg/m³), thickness of the wall and height of its foot (m).
const GRAVITY: f64 = 9.81;
const DENSITIES: [f64; 2] = [1000.0, 2000.0];
const WALL: [f64; 2] = [1.0, 0.5];

/// Force of the wall on its foundation (N/m) behind the reflected bore, and its closed form `ρ g h² / 2`.
pub fn force_on_foundation() -> Result<[f64; 2], Box<dyn Error>> {
    let ([arriving, reflected], [thickness, foot]) = (DEPTHS, WALL);
    // Mass and momentum across a bore that leaves water at rest.
    let speed = (reflected - arriving) * (0.5 * GRAVITY * (1.0 / arriving + 1.0 / reflected)).sqrt();
    let water = Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [LENGTH, 3.0]))
        .gravity([0.0, -GRAVITY])
        .material("water", NewtonianFluidSpec::new(DENSITIES[0], 2e6))
        .body(Body::block("water", "water", [0.0, 0.0], [LENGTH, arriving]).velocity([speed, 0.0]))
        .wall(Side::XMax, Wall::Smooth)
        .wall(Side::YMin, Wall::Smooth)
        .stage(Stage::new("flow", 4.0));
    let wall = Case::new(Space::PlaneStrain, Domain::new([-0.5, 0.0], [1.5, 3.0]))
        .material("concrete", LinearElasticSpec::new(DENSITIES[1], 2e7, 0.2))
        .body(Body { rigid: true, ..Body::block("rock", "concrete", [-0.5, 0.0], [1.5, foot]) })
        .body(Body::block("wall", "concrete", [0.0, foot], [thickness, foot + 2.0]))
        .stage(Stage { damping: 0.3, ..Stage::new("flow", 4.0) });
    let mut flow = DepthSph::new(DepthOptions::new(0.1)).solver::<1>(&water)?;
    let mut wall = Mpm::new(MpmOptions::new(0.125)).solver::<2>(&wall)?;
    while !flow.is_complete() {
        flow.step()?;
        let (depth, velocity) = flow.gauge(&[LENGTH - 0.2]).ok_or("no gauge")?;
        // Pressure on the wetted face by the weight and the momentum of the water, carried by the thickness behind it.
        wall.set_body_force(move |x, _, _| {
            let below = foot + depth - x[1];
            let pressure = DENSITIES[0] * (GRAVITY * below + velocity[0] * velocity[0]);
            [if below > 0.0 { pressure / (DENSITIES[1] * thickness) } else { 0.0 }, 0.0]
        })?;
        wall.step_to(flow.time())?;
    }
    let force = wall.reaction("rock").ok_or("no reaction")?.force[0];
    Ok([force, 0.5 * DENSITIES[0] * GRAVITY * reflected * reflected])
}

/// Prints the force.
fn main() -> Result<(), Box<dyn Error>> {
    let [force, exact] = force_on_foundation()?;
    println!("force on the foundation {force:.0} N/m, closed form {exact:.0} N/m");
    Ok(())
}
