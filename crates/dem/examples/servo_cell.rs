//! Isotropic compression of disks by a servo of the program, which moves the four walls of a cell.

use colluvium_case::{Body, Case, Domain, Side, Space, Stage, Wall};
use colluvium_constitutive::LinearElasticSpec;
use colluvium_dem::{Dem, DemOptions, Diameters, Fill, GrainKind, NormalLaw, PairSpec};

/// Confining stress (Pa, tension-positive).
pub const TARGET: f64 = -1e5;

/// Largest speed of a wall (m/s).
const SPEED: f64 = 0.2;

/// Walls by their names, each with its axis and the sign of the direction into the cell.
const WALLS: [(Side, &str, usize, f64); 4] = [
    (Side::XMin, "x-min", 0, 1.0),
    (Side::XMax, "x-max", 0, -1.0),
    (Side::YMin, "y-min", 1, 1.0),
    (Side::YMax, "y-max", 1, -1.0),
];

/// Normal stresses on the walls (Pa) after the compression, by the names of the walls.
pub fn wall_stresses() -> Result<Vec<(&'static str, f64)>, Box<dyn std::error::Error>> {
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
    WALLS
        .iter()
        .map(|(_, name, ..)| Ok((*name, solver.wall(name).ok_or("no wall")?.normal_stress())))
        .collect()
}

/// Prints the stresses.
fn main() -> Result<(), Box<dyn std::error::Error>> {
    for (name, stress) in wall_stresses()? {
        println!("{name}: {:.2} kPa of {:.2} kPa", 1e-3 * stress, 1e-3 * TARGET);
    }
    Ok(())
}
