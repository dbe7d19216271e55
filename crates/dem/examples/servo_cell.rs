//! Isotropic compression of disks by a servo of the program, which moves the four walls of a cell.

use colluvium_case::{Body, Case, Domain, Side, Space, Stage, Wall};
use colluvium_constitutive::LinearElasticSpec;
use colluvium_dem::{Dem, DemOptions, Diameters, Fill, GrainKind, NormalLaw, PairSpec};

/// Confining stress (Pa, tension-positive).
const TARGET: f64 = -1e5;

/// Largest speed of a wall (m/s).
const SPEED: f64 = 0.2;

/// Walls by their names, each with its axis and the sign of the direction into the cell.
const WALLS: [(Side, &str, usize, f64); 4] = [
    (Side::XMin, "x-min", 0, 1.0),
    (Side::XMax, "x-max", 0, -1.0),
    (Side::YMin, "y-min", 1, 1.0),
    (Side::YMax, "y-max", 1, -1.0),
];

/// Compresses the cell, and prints the stresses on the walls.
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut case = Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [0.05, 0.05]))
        .material("sand", LinearElasticSpec::new(2650.0, 1e7, 0.3)) // only its name is used
        .body(Body::block("cell", "sand", [0.0, 0.0], [0.05, 0.05]))
        .stage(Stage { damping: 0.2, ..Stage::new("compression", 0.05) });
    for (side, ..) in WALLS {
        case = case.wall(side, Wall::Smooth);
    }
    let diameter = Diameters::Uniform { min: 2e-3, max: 3e-3 };
    let sand = GrainKind::filled(2650.0, diameter, Fill::Random { solid_fraction: 0.75 });
    let law = NormalLaw::linear(1e7).restitution(0.3);
    let options = DemOptions::new([("sand", sand)], [PairSpec::new(["sand", "sand"], law).friction(0.3)]);
    let mut solver = Dem::new(options).solver::<2>(&case)?;
    let gain = SPEED / TARGET.abs();
    while !solver.is_complete() {
        for (_, name, axis, inward) in WALLS {
            let measured = solver.wall(name).ok_or("no wall")?.normal_stress();
            let mut velocity = [0.0; 2];
            velocity[axis] = inward * (gain * (measured - TARGET)).clamp(-SPEED, SPEED);
            solver.set_wall_velocity(name, velocity)?;
        }
        solver.step()?;
    }
    let grains = solver.grains();
    println!("{} grains, {} contacts at {:.3} s", grains.len(), solver.contacts().len(), solver.time());
    for (_, name, ..) in WALLS {
        let wall = solver.wall(name).ok_or("no wall")?;
        println!("{name}: {:.2} kPa at {:.2} mm", 1e-3 * wall.normal_stress(), 1e3 * wall.position());
        assert!((wall.normal_stress() / TARGET - 1.0).abs() < 0.01, "the wall misses its stress");
    }
    Ok(())
}
