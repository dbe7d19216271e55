//! Slope whose water level the program lowers while it runs: effective stresses, their closed form, and the movement of the slope.

use colluvium::case::{Body, Case, CaseError, Domain, Side, Space, Stage, Wall};
use colluvium::constitutive::MohrCoulombSpec;
use colluvium::mpm::{Mpm, MpmOptions, MpmSolver};
use colluvium::points::Shape;

/// Height of the slope of 1:1, and distance of its toe from the left side (m).
const HEIGHT: f64 = 4.0;
const TOE: f64 = 12.0;

/// Weight of the water in the volume of saturated soil of 2000 kg/m³, over the mass of that soil (m/s²).
const UPLIFT: f64 = 9.81 * 1000.0 / 2000.0;

/// Sets the force `-∇u` of the water on the grains. The pressure `u` is hydrostatic below a water table: the level (m) of the open water, or,
/// with a `lag` of 1, the surface of the ground above it (Morgenstern 1963).
fn set_water(solver: &mut MpmSolver<2>, level: f64, lag: f64) -> Result<(), CaseError> {
    solver.set_body_force(move |x, _, _| {
        let ground = HEIGHT.min(TOE - x[0]);
        let table = level + lag * (ground - level).max(0.0);
        let gradient = if ground > level && ground < HEIGHT { lag } else { 0.0 };
        if x[1] < table { [UPLIFT * gradient, UPLIFT] } else { [0.0; 2] }
    })
}

/// Mean effective vertical stress (Pa, compression-positive) beside the left side, and position of the foremost point (m).
fn stress_and_front(solver: &MpmSolver<2>) -> [f64; 2] {
    let (position, stress) = (solver.points().position(), solver.points().stress());
    let beside = position.iter().zip(stress.iter()).filter(|(x, _)| x[0] < 0.5);
    let (sum, count) = beside.fold((0.0, 0.0), |(sum, count), (_, stress)| (sum - stress[1], count + 1.0));
    [sum / count, position.iter().map(|x| x[0]).fold(0.0, f64::max)]
}

/// Stress (Pa) and front (m) before and after a drawdown: a slow one with a `lag` of 0, a rapid one with 1.
pub fn drawdown(lag: f64) -> Result<[[f64; 2]; 2], Box<dyn std::error::Error>> {
    let vertices = vec![[0.0, 0.0], [TOE, 0.0], [TOE - HEIGHT, HEIGHT], [0.0, HEIGHT]].into();
    let case = Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [20.0, 5.0]))
        .gravity([0.0, -9.81])
        .material("soil", MohrCoulombSpec { cohesion: 3e3, ..MohrCoulombSpec::new(2e3, 1e7, 0.3, 30.0) })
        .body(Body::new("slope", "soil", Shape::Polygon { vertices }))
        .wall(Side::XMin, Wall::Smooth)
        .wall(Side::YMin, Wall::Rough)
        .stage(Stage { damping: 0.3, ..Stage::new("drawdown", 6.0) });
    let mut solver = Mpm::new(MpmOptions::new(0.5)).solver::<2>(&case)?;
    set_water(&mut solver, HEIGHT, lag)?;
    solver.step_to(2.0)?;
    let before = stress_and_front(&solver);
    while !solver.is_complete() {
        let level = HEIGHT * (2.0 - 0.5 * solver.time()).max(0.0);
        set_water(&mut solver, level, lag)?;
        solver.step()?;
    }
    Ok([before, stress_and_front(&solver)])
}

/// Prints stress and front before and after.
fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("slow drawdown: {:.3?}, rapid drawdown: {:.3?}", drawdown(0.0)?, drawdown(1.0)?);
    Ok(())
}
