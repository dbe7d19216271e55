//! Column of sand with a law of the program, a checkpoint, and a picture.

use std::error::Error;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use colluvium::case::{Body, Case, Domain, Side, Simulation, Solver, Space, Stage, Wall};
use colluvium::constitutive::{Corotational, Elasticity, MaterialError, SymTensor};
use colluvium::constitutive::{InitialCondition, Law, Motion, Point, PointLaw, SmallStrain};
use colluvium::mpm::{Mpm, MpmOptions, MpmSolver};
use colluvium::plots::{Picture, PointCloud};

/// Ratio of deviatoric stress to pressure at failure: `√3 sin φ` in plane strain at constant volume, with φ = 31°.
pub const STRESS_RATIO: f64 = 0.892;

/// Sand without cohesion and without dilatancy: `q ≤ M p`, and no tension. It has no state but its stress.
struct Sand(Elasticity);

impl Law for Sand {
    fn name(&self) -> &'static str {
        "sand"
    }
}

impl PointLaw for Sand {
    type State = ();

    fn initial(&self, initial: &InitialCondition) -> Result<Point<()>, MaterialError> {
        Ok(Point { stress: initial.stress, state: () })
    }

    fn wave_modulus(&self, _point: &Point<()>) -> f64 {
        self.0.p_wave_modulus()
    }
}

impl SmallStrain for Sand {
    fn update(&self, strain: &SymTensor, _: &Motion, old: &Point<()>) -> Result<Point<()>, MaterialError> {
        let trial = old.stress + self.0.stress(strain);
        let (pressure, q) = (trial.pressure().max(0.0), trial.q());
        // The deviator shrinks to the strength. In tension nothing remains.
        let share = if q > STRESS_RATIO * pressure { STRESS_RATIO * pressure / q } else { 1.0 };
        Ok(Point { stress: trial.deviator() * share - SymTensor::IDENTITY * pressure, state: () })
    }
}

/// Solver of a column of sand 0.1 m wide and high.
pub fn column() -> Result<Simulation<MpmSolver<2>>, Box<dyn Error>> {
    let sand = Corotational(Sand(Elasticity::new(1.98e6, 0.23)?));
    let case = Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [0.5, 0.15]))
        .gravity([0.0, -9.81])
        .law("sand", 1925.0, Arc::new(sand))
        .body(Body::block("column", "sand", [0.0, 0.0], [0.1, 0.1]))
        .wall(Side::XMin, Wall::Smooth)
        .wall(Side::YMin, Wall::frictional(1.0))
        .stage(Stage::new("release", 0.6));
    Ok(Mpm::new(MpmOptions::new(0.005)).solver::<2>(&case)?)
}

/// Writes a checkpoint during the collapse and a picture of the deposit to a folder.
pub fn collapse(folder: &Path) -> Result<Simulation<MpmSolver<2>>, Box<dyn Error>> {
    let mut solver = column()?;
    solver.step_to(0.1)?;
    solver.save(&mut File::create(folder.join("column.checkpoint"))?)?;
    solver.step_to(0.6)?;
    let picture = PointCloud::from_snapshot(&solver.snapshot(), "velocity", [0, 1]);
    picture.ok_or("no velocity")?.write(&folder.join("column.png"))?;
    Ok(solver)
}

/// Prints the front of the deposit (m).
fn main() -> Result<(), Box<dyn Error>> {
    let solver = collapse(Path::new("."))?;
    let front = solver.points().position().iter().map(|x| x[0]).fold(0.0, f64::max);
    println!("front at {front:.3} m; column.png has the picture");
    Ok(())
}
