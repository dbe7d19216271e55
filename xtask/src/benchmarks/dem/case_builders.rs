//! Cases of grains: files under `validation/dem` that a benchmark changes, and solvers that it steps.

use std::f64::consts::PI;

use colluvium::case::{Case, Solver};
use colluvium::dem::{self, DemSolver};
use serde_json::{Value, json};

/// Reads the case `validation/dem/<folder>/case.json` as a JSON value, which may be changed.
pub fn load(folder: &str) -> Result<Value, String> {
    let path = crate::root().join("validation/dem").join(folder).join("case.json");
    crate::benchmarks::recorder::record_file(&path);
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
}

/// Reads a case from a JSON value.
pub fn parse_case(value: &Value) -> Result<Case, String> {
    Case::from_json(&value.to_string()).map_err(|errors| errors.to_string())
}

/// Solver of disks at the start of the first stage.
pub fn disk_solver(value: &Value) -> Result<DemSolver<2, 1>, String> {
    started_solver(dem::disks(&parse_case(value)?).map_err(|error| error.to_string())?)
}

/// Solver of spheres at the start of the first stage.
pub fn sphere_solver(value: &Value) -> Result<DemSolver<3, 3>, String> {
    started_solver(dem::spheres(&parse_case(value)?).map_err(|error| error.to_string())?)
}

/// Solver at the start of its first stage.
fn started_solver<const D: usize, const R: usize>(
    mut solver: DemSolver<D, R>,
) -> Result<DemSolver<D, R>, String>
where
    DemSolver<D, R>: Solver,
{
    solver.begin_stage(0, 0.0).map_err(|error| error.to_string())?;
    Ok(solver)
}

/// Makes one step of `dt` (s).
pub fn step(solver: &mut impl Solver, dt: f64) -> Result<(), String> {
    solver.step(dt).map(|_| ()).map_err(|error| error.to_string())
}

/// Scalar output of the solver under a name; NaN where there is none.
pub fn output_value(solver: &impl Solver, name: &str) -> f64 {
    solver.scalar_outputs().iter().find(|(own, ..)| own == name).map_or(f64::NAN, |(_, _, value)| *value)
}

/// Grain of a file: position (m), radius (m), velocity (m/s).
pub type GrainData = (Vec<f64>, f64, Vec<f64>);

/// Writes the grains of a body as a file of points, under `target/validation/points`. Single grains may reach beyond a periodic domain and
/// overlap each other.
pub fn grain_file(name: &str, grains: &[GrainData]) -> Result<Value, String> {
    let folder = crate::root().join("target/validation/points");
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    std::fs::create_dir_all(&folder).map_err(failed)?;
    let axes = &["x", "y", "z"][..grains.first().map_or(0, |grain| grain.0.len())];
    let mut text = format!("{},volume,velocity_{}\n", axes.join(","), axes.join(",velocity_"));
    for (place, radius, velocity) in grains {
        let volume = if axes.len() == 2 { PI * radius * radius } else { 4.0 / 3.0 * PI * radius.powi(3) };
        let numbers: Vec<String> =
            place.iter().chain([&volume]).chain(velocity).map(|number| format!("{number:e}")).collect();
        text += &(numbers.join(",") + "\n");
    }
    let file = folder.join(format!("{name}.csv"));
    std::fs::write(&file, text).map_err(failed)?;
    Ok(json!({ "file": file }))
}

/// Options of DEM in a case.
pub fn method_options(value: &mut Value) -> &mut Value {
    &mut value["methods"]["dem"]
}

/// Linear normal law, as the JSON value of the first pair.
pub fn linear_law(stiffness: f64, damping_ratio: f64, clamp: bool) -> Value {
    json!({ "law": "linear", "stiffness": stiffness, "damping_ratio": damping_ratio, "clamp": clamp })
}
