//! Layer of soil under its weight, brought to rest by a loop of the program: it reads the kinetic energy and sets all velocities to zero at
//! each of its peaks (dynamic relaxation).

use colluvium_case::{Body, Case, Domain, Side, Space, Stage, Wall};
use colluvium_constitutive::LinearElasticSpec;
use colluvium_sph::{Sph, SphOptions};

/// Mean vertical stress (Pa) and settlement (m) of the layer at rest, and their closed forms.
pub fn settled_layer() -> Result<[[f64; 2]; 2], Box<dyn std::error::Error>> {
    let (density, modulus, gravity, height) = (2000.0, 2e6, 10.0, 1.0);
    let case = Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [0.4, 1.2]))
        .gravity([0.0, -gravity])
        .material("soil", LinearElasticSpec::new(density, modulus, 0.0))
        .body(Body::block("layer", "soil", [0.0, 0.0], [0.4, height]))
        .wall(Side::XMin, Wall::Smooth)
        .wall(Side::XMax, Wall::Smooth)
        .wall(Side::YMin, Wall::Smooth)
        .stage(Stage::new("settle", 10.0));
    let mut solver = Sph::new(SphOptions::new(0.05)).solver::<2>(&case)?;
    let top = |positions: &[[f64; 2]]| positions.iter().map(|x| x[1]).fold(0.0, f64::max);
    let start = top(solver.particles().position());
    let (mut before, mut peaks) = (0.0, 0);
    while peaks < 20 {
        solver.step()?;
        let particles = solver.particles();
        let energies = particles.mass().iter().zip(particles.velocity());
        let kinetic: f64 = energies.map(|(mass, v)| 0.5 * mass * (v[0] * v[0] + v[1] * v[1])).sum();
        if kinetic < before {
            solver.velocities_mut().for_each(|v| *v = [0.0; 2]);
            peaks += 1;
        }
        before = if kinetic < before { 0.0 } else { kinetic };
    }
    let particles = solver.particles();
    let vertical: f64 =
        particles.stress().iter().zip(particles.volume()).map(|(s, volume)| s[1] * volume).sum();
    let (mean, settlement) = (vertical / particles.volume().sum::<f64>(), start - top(particles.position()));
    let exact = [-0.5 * density * gravity * height, 0.5 * density * gravity * height * height / modulus];
    Ok([[mean, settlement], exact])
}

/// Prints stress and settlement.
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let [[mean, settlement], exact] = settled_layer()?;
    println!("mean vertical stress {mean:.0} Pa of {:.0} Pa", exact[0]);
    println!("settlement {settlement:.5} m of {:.5} m", exact[1]);
    Ok(())
}
