//! Seiche of a tank that a program shakes at the frequency of its first mode, and damps afterwards.

use std::f64::consts::{PI, TAU};

use colluvium_case::{Body, Case, Domain, Side, Space, Stage, Wall};
use colluvium_constitutive::NewtonianFluidSpec;
use colluvium_depth_sph::{DepthOptions, DepthSolver, DepthSph};

/// Length and depth of the tank (m).
const TANK: (f64, f64) = (10.0, 1.0);

/// Gravity, and amplitude of the acceleration of the tank (m/s²).
const GRAVITY: f64 = 9.81;
const SHAKING: f64 = 0.01;

/// Amplitude of the first mode of the elevation (m), `2/L ∫ (h - H) cos(πx/L) dx`.
fn first_mode(solver: &DepthSolver<1>) -> f64 {
    let nodes = solver.nodes();
    let (position, depth, volume) = (nodes.position(), nodes.depth(), nodes.volume());
    let each = position.iter().zip(depth.iter()).zip(volume.iter());
    let part =
        |((x, h), volume): ((&[f64; 1], &f64), &f64)| volume / h * (h - TANK.1) * (PI * x[0] / TANK.0).cos();
    2.0 / TANK.0 * each.map(part).sum::<f64>()
}

/// Largest amplitude (m) of the first mode during three periods of shaking, that of the theory, and the amplitude at the end.
pub fn amplitudes() -> Result<[f64; 3], Box<dyn std::error::Error>> {
    let (length, depth) = TANK;
    let frequency = PI / length * (GRAVITY * depth).sqrt();
    let shaken = 3.0 * TAU / frequency;
    let case = Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [length, 2.0]))
        .gravity([0.0, -GRAVITY])
        .material("water", NewtonianFluidSpec::new(1000.0, 2e6))
        .body(Body::block("water", "water", [0.0, 0.0], [length, depth]))
        .wall(Side::XMin, Wall::Smooth)
        .wall(Side::XMax, Wall::Smooth)
        .wall(Side::YMin, Wall::Smooth)
        .stage(Stage::new("shaking and rest", 2.0 * shaken));
    let options = DepthOptions { viscosity_linear: 0.0, ..DepthOptions::new(0.1) };
    let mut solver = DepthSph::new(options).solver::<1>(&case)?;
    solver.set_body_force(move |_, _, t| [SHAKING * (frequency * t).sin()])?;
    let mut largest: f64 = 0.0;
    while solver.time() < shaken {
        solver.step_at_most(shaken - solver.time())?;
        largest = largest.max(first_mode(&solver).abs());
    }
    // Shallow-water theory: at resonance the amplitude grows as 2 H A t / (L ω).
    let exact = 2.0 * depth * SHAKING * shaken / (length * frequency);
    // Drag in place of the shaking: waves decay by exp(-k t / 2).
    solver.set_body_force(|_, v, _| [-0.5 * v[0]])?;
    solver.step_to(2.0 * shaken)?;
    Ok([largest, exact, first_mode(&solver)])
}

/// Prints the amplitudes.
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let [largest, exact, last] = amplitudes()?;
    println!("largest amplitude {largest:.4} m, by theory {exact:.4} m, at the end {last:.5} m");
    Ok(())
}
