//! Snowball that falls through air: a drag of the program acts on it until it hits the ground, where it is compacted. The program then sets
//! its velocities to zero.

use colluvium_case::{Body, Case, Domain, Side, Space, Stage, Wall};
use colluvium_constitutive::CohesiveCamClaySpec;
use colluvium_snow_mpm::{SnowMpm, SnowOptions};

/// Mean vertical velocity (m/s) of points with equal masses.
fn mean_velocity<'a>(velocities: impl Iterator<Item = &'a [f64; 2]>) -> f64 {
    let (sum, count) = velocities.fold((0.0, 0.0), |(sum, count), v| (sum + v[1], count + 1.0));
    sum / count
}

/// Velocity of the impact (m/s), its closed form, and the largest density (kg/m³) of the compacted snow.
pub fn impact() -> Result<[f64; 3], Box<dyn std::error::Error>> {
    let (gravity, drag) = (9.81, 3.0);
    let snow = CohesiveCamClaySpec {
        cohesion_ratio: 0.3,
        ..CohesiveCamClaySpec::new(400.0, 3e6, 0.3, 1.2, 3000.0, 1.0)
    };
    let case = Case::new(Space::PlaneStrain, Domain::new([-0.4, 0.0], [0.4, 1.6]))
        .gravity([0.0, -gravity])
        .material("snow", snow)
        .body(Body::ball("ball", "snow", [0.0, 1.2], 0.2))
        .wall(Side::YMin, Wall::Rough)
        .stage(Stage::new("fall", 2.0));
    let mut solver = SnowMpm::new(SnowOptions::new(0.04)).solver::<2>(&case)?;
    solver.set_body_force(move |_, v, _| v.map(|v| -drag * v))?;
    // Nodes two cells above the ground are free of the wall.
    while solver.points().position().iter().all(|x| x[1] > 0.1) {
        solver.step()?;
    }
    let (impact, time) = (mean_velocity(solver.points().velocity().iter()), solver.time());
    let exact = -gravity / drag * (1.0 - (-drag * time).exp());
    solver.clear_body_force();
    while mean_velocity(solver.points().velocity().iter()) < 0.05 * impact {
        solver.step()?;
    }
    solver.velocities_mut().for_each(|v| *v = [0.0; 2]);
    solver.step_to(solver.time() + 0.1)?;
    let densest = solver.points().density().fold(0.0, f64::max);
    Ok([impact, exact, densest])
}

/// Prints velocity and density.
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let [impact, exact, densest] = impact()?;
    println!("impact at {impact:.4} m/s of {exact:.4} m/s, snow of up to {densest:.0} kg/m³");
    Ok(())
}
