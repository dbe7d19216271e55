//! Means of controlled stresses of cells and walls during deformation (sheet: dem §3.7).

use colluvium_case::Solver;
use colluvium_dem::{DemSolver, disks};
use colluvium_testkit::{read_case, scalar_output, single_threaded};
use serde_json::{Value, json};

const PRESSURE: f64 = 1e5;
const DIAMETER: f64 = 0.01;
const DENSITY: f64 = 2600.0;
const GRAINS: f64 = 100.0;
/// Number of steps between stress samples.
const BLOCK: f64 = 8.0;

/// Inertial time of a grain under the pressure, √(m/P) (s).
fn unit() -> f64 {
    (DENSITY * std::f64::consts::PI * 0.25 * DIAMETER * DIAMETER / PRESSURE).sqrt()
}

fn side() -> f64 {
    (GRAINS * std::f64::consts::PI * 0.25 * DIAMETER * DIAMETER / 0.78).sqrt()
}

/// Disks compressed without friction and then sheared at an inertial number.
fn case(inertial: f64, strain: f64, periodic: bool, own: &Value) -> Value {
    let (side, unit) = (side(), unit());
    let stage = |name: &str, duration: f64, damping: f64| json!({ "name": name, "duration": duration * unit, "damping": damping });
    let domain = if periodic {
        json!({ "min": [0, 0], "max": [side, side], "periodic": ["x", "y"] })
    } else {
        json!({ "min": [-side, -side], "max": [2.0 * side, 2.0 * side] })
    };
    let wall = |side: &str, name: &str, position: f64| json!({ "side": side, "name": name, "position": position, "wall": { "kind": "smooth" } });
    let mut boundaries = json!([]);
    if !periodic {
        let top = wall("y-max", "top", side);
        boundaries = json!([
            wall("x-min", "left", 0.0),
            wall("x-max", "right", side),
            wall("y-min", "floor", 0.0),
            top
        ]);
        boundaries[3]["velocity"] = json!([0.0, -inertial / unit * side]);
    }
    json!({
        "title": "biaxial", "space": "plane-strain", "domain": domain, "gravity": [0, 0], "boundaries": boundaries,
        "materials": { "g": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
        "bodies": [{ "name": "b", "material": "g", "shape": { "kind": "box", "min": [0, 0], "max": [side, side] } }],
        "stages": [stage("press", 150.0, 0.2), stage("shear", strain / inertial, 0.0)],
        "methods": { "dem": {
            "grains": { "g": {
                "density": DENSITY, "fill": { "kind": "random", "solid_fraction": 0.75 },
                "diameter": { "distribution": "uniform", "min": 0.8 * DIAMETER, "max": 1.2 * DIAMETER }
            } },
            "pairs": [{
                "between": ["g", "g"], "friction": { "coefficient": 0.5 },
                "normal": { "law": "linear", "stiffness": 1e3 * PRESSURE, "restitution": 0.2 }
            }],
            "stages": {
                "press": without_friction(if periodic { cell(&json!({ "stress": -PRESSURE })) } else { platens(&["right", "top"]) }),
                "shear": own
            }
        } }
    })
}

/// Options of a stage with frictionless grains.
fn without_friction(mut stage: Value) -> Value {
    stage["pairs"] = json!([{ "between": ["g", "g"], "friction": { "coefficient": 0 } }]);
    stage
}

fn cell(along: &Value) -> Value {
    json!({ "cell": { "xx": { "stress": -PRESSURE }, "yy": along } })
}

fn platens(names: &[&str]) -> Value {
    let press = json!({ "stress": -PRESSURE, "speed": 3.0 });
    json!({ "walls": names.iter().map(|name| ((*name).to_owned(), press.clone())).collect::<serde_json::Map<_, _>>() })
}

/// Means of a stress over the pressure in windows of 1 % of shear strain, and the warning of the run at its end.
fn means(
    value: &Value,
    name: &str,
    inertial: f64,
    windows: usize,
) -> (Vec<f64>, Vec<colluvium_case::Warning>) {
    single_threaded();
    let case = read_case(value);
    let mut solver: DemSolver<2, 1> = disks(&case).unwrap();
    let step = solver.limit().dt;
    let run = |solver: &mut DemSolver<2, 1>, time: f64| {
        let blocks = (time / step / BLOCK).ceil() as usize;
        let mut sum = 0.0;
        for _ in 0..blocks {
            for _ in 0..BLOCK as usize {
                solver.step(step).unwrap();
            }
            sum += scalar_output(solver, name);
        }
        -sum / (blocks as f64 * PRESSURE)
    };
    solver.begin_stage(0, 0.0).unwrap();
    let pressed = (case.stages[0].duration / step).ceil() as usize;
    for _ in 0..pressed {
        solver.step(step).unwrap();
    }
    let start = solver.time();
    solver.begin_stage(1, start).unwrap();
    let window = 0.01 * unit() / inertial;
    let means = (0..windows).map(|_| run(&mut solver, window)).collect();
    (means, solver.warnings_at_end())
}

#[test]
fn a_cell_that_is_shortened_holds_its_lateral_stress_in_the_mean() {
    let inertial = 1e-3;
    for damping in [None, Some(0.0), Some(0.3)] {
        let mut shear = cell(&json!({ "rate": -inertial / unit() }));
        shear["cell"]["damping"] = json!(damping);
        let (means, remarks) = means(&case(inertial, 0.03, true, &shear), "cell_stress.xx", inertial, 3);
        assert!(means.iter().all(|mean| (mean - 1.0).abs() < 5e-3), "{damping:?}: {means:?}");
        assert!(remarks.is_empty(), "{remarks:?}");
    }
}

#[test]
fn platens_hold_their_stress_in_the_mean_while_another_one_moves() {
    let inertial = 1e-3;
    let value = case(inertial, 0.03, false, &platens(&["left", "right"]));
    let (means, remarks) = means(&value, "wall.right.stress", inertial, 3);
    assert!(means.iter().all(|mean| (mean - 1.0).abs() < 5e-3), "{means:?}");
    assert!(remarks.is_empty(), "{remarks:?}");
}

#[test]
fn a_run_reports_controlled_stresses_that_were_not_reached() {
    // A wall whose speed limit is too low.
    let inertial = 5e-3;
    let mut slow = platens(&["left", "right"]);
    slow["walls"]["right"]["speed"] = json!(1e-6);
    slow["walls"]["left"]["speed"] = json!(1e-6);
    let (means, remarks) = means(&case(inertial, 0.06, false, &slow), "wall.right.stress", inertial, 6);
    assert!(means[5] > 1.02, "{means:?}");
    let text = colluvium_testkit::lines(&remarks);
    assert!(text.contains("stage \"shear\": the controlled stress of the wall \"right\" was"), "{text}");
}
