//! Peak memory of a few steps of many spheres, of a row of the measures, and of a run that writes frames: bytes per sphere. The
//! argument is their approximate number, a million without one. Nothing is measured where the system does not report memory.

use colluvium_case::{Case, RunOptions, Solver, run_with_plan};
use colluvium_dem::{Dem, spheres};
use serde_json::json;

const DIAMETER: f64 = 0.01;
const TIME_STEP: f64 = 2e-5;
const STEPS: u32 = 4;

/// Overlapping hexagonal layers at rest on a floor, about `count` spheres.
fn case(count: f64) -> Case {
    let side = DIAMETER * (count / 2f64.sqrt()).cbrt();
    let cube = json!({ "kind": "box", "min": [0, 0, 0], "max": [side, side, side] });
    let wall = json!({ "kind": "frictional", "friction_coefficient": 0.5 });
    let sides =
        ["x-min", "x-max", "y-min", "y-max", "z-min"].map(|side| json!({ "side": side, "wall": wall }));
    let case = json!({
        "title": "spheres", "space": "3d", "gravity": [0, 0, -9.81],
        "domain": { "min": [0, 0, 0], "max": [side, side, 1.1 * side] },
        "materials": { "s": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
        "bodies": [{ "name": "b", "material": "s", "shape": cube }],
        "boundaries": sides,
        "stages": [{ "name": "rest", "duration": f64::from(STEPS) * TIME_STEP }],
        "output": { "frames": f64::from(STEPS) * TIME_STEP },
        "methods": { "dem": {
            "grains": { "s": { "density": 2500, "diameter": { "distribution": "equal", "value": DIAMETER },
                               "fill": { "kind": "lattice", "packing": "hexagonal", "pitch": 0.999 * DIAMETER } } },
            "pairs": [{ "between": ["s", "s"], "normal": { "law": "linear", "stiffness": 2e4, "damping_ratio": 0.1 },
                        "tangential": { "stiffness_ratio": 2.0 / 7.0 }, "friction": { "coefficient": 0.5 } }],
            "skin": 0.1, "time_step": TIME_STEP
        } }
    });
    Case::from_json(&case.to_string()).expect("a valid case")
}

/// Peak memory of the program since the last call (bytes); `None` where the system does not report it.
fn peak() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    Some(1024.0 * kilobytes)
}

fn main() {
    let asked = std::env::args().skip(1).find_map(|argument| argument.parse().ok());
    let case = case(asked.unwrap_or(1e6));
    let mut solver = spheres(&case).expect("a solver");
    let count = solver.point_count() as f64;
    let tell = |what: &str| {
        if let Some(bytes) = peak() {
            println!("{what}: {:.0} bytes a sphere of {count}", bytes / count);
        }
    };
    tell("made");
    solver.begin_stage(0, 0.0).expect("a stage");
    for _ in 0..STEPS {
        solver.step(1.0).expect("a stable step");
    }
    tell("steps");
    let seen = solver.snapshot();
    tell("what a row is read off");
    let numbers = solver.scalar_outputs().len() + usize::from(solver.budget().is_some());
    tell(&format!("row of {numbers} readings"));
    drop(seen);
    drop(solver);
    let folder = tempfile::tempdir().expect("a folder");
    let options = RunOptions { output_folder: Some(folder.path().to_owned()), ..RunOptions::default() };
    let solver = Box::new(spheres(&case).expect("a solver"));
    tell("made again");
    let report = run_with_plan(&Dem, &case, solver, &options).expect("a run");
    tell(&format!("run of {} steps with frames", report.steps));
}
