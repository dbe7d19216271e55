//! Obstacles on the points (docs/theory/mpm.md, obstacles).

use colluvium_case::{Budget, Case, Method, Reaction, Snapshot, Solver};
use colluvium_mpm::Mpm;
use colluvium_testkit::{advance_exactly_to, advance_steps, read_case, scalar_output, start_solver};
use serde_json::{Value, json};

pub const GRAVITY: f64 = 9.81;

/// A block of 0.6 m by 0.3 m on a floor at y = 0.5 m, whose points stand in rows along it.
pub fn block(wall: &Value) -> Value {
    let elastic =
        json!({ "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.0 });
    json!({
        "title": "block", "space": "plane-strain", "gravity": [0, -GRAVITY], "materials": { "m": elastic },
        "domain": { "min": [0, 0], "max": [2, 1.5] },
        "bodies": [{ "name": "block", "material": "m", "shape": { "kind": "box", "min": [0.3, 0.5], "max": [0.9, 0.8] } }],
        "obstacles": [{
            "name": "floor", "wall": wall,
            "shape": { "kind": "plane", "point": [0, 0.5], "normal": [0, 1] }
        }],
        "stages": [{ "name": "rest", "duration": 1, "damping": 0.7 }],
        "measures": { "reaction": { "kind": "reaction", "target": "floor" } },
        "methods": { "mpm": { "cell_size": 0.1, "obstacles": "points" } }
    })
}

pub fn frictional(coefficient: f64) -> Value {
    json!({ "kind": "frictional", "friction_coefficient": coefficient })
}

#[test]
fn the_reaction_of_a_block_at_rest_is_its_weight() {
    let case = read_case(&block(&frictional(0.5)));
    let mut solver = start_solver(&Mpm, &case);
    advance_exactly_to(&mut *solver, 1.0);
    let weight = 0.6 * 0.3 * 1000.0 * GRAVITY;
    let reaction = solver.reaction("floor").unwrap();
    assert!((reaction.force[1] / -weight - 1.0).abs() < 1e-3, "{reaction:?} {weight}");
    assert!(reaction.force[0].abs() < 1e-3 * weight);
    assert!((reaction.impulse[1] / -weight - 1.0).abs() < 0.1, "{reaction:?}");
    // A stress of 2943 Pa on springs of 4 M V/h² a point of half a cell: 2943/1e6 times half a cell, as 0.5/4 = 0.125 and M = E.
    let lowest = solver.snapshot().positions.iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
    let sunk = 0.525 - lowest;
    let exact = 2943.0 / 1e6 * 0.5 * 0.1;
    assert!((sunk / exact - 1.0).abs() < 0.35, "{sunk} {exact}: with the strain of half a point");
}

#[test]
fn friction_slows_a_block_by_coulombs_law_and_its_work_is_the_energy_lost() {
    let mut value = block(&frictional(0.3));
    value["bodies"][0]["velocity"] = json!({ "kind": "uniform", "value": [1.0, 0.0] });
    value["stages"] = json!([{ "name": "slide", "duration": 0.2 }]);
    value["materials"]["m"]["youngs_modulus"] = json!(1e7);
    let case = read_case(&value);
    let mut solver = start_solver(&Mpm, &case);
    let mass = 180.0;
    let start = solver.totals();
    let total = |solver: &dyn Solver| {
        let budget = solver.totals();
        let own = budget.kinetic + budget.elastic + budget.potential;
        own + scalar_output(solver, "obstacles.friction") + scalar_output(solver, "obstacles.stored")
    };
    let before = total(&*solver);
    advance_exactly_to(&mut *solver, 0.2);
    let slowed = (start.momentum[0] - solver.totals().momentum[0]) / mass;
    let exact = 0.3 * GRAVITY * 0.2;
    assert!((slowed / exact - 1.0).abs() < 0.02, "{slowed} {exact}");
    let lost = 0.5 * mass * (1.0 - (1.0 - exact).powi(2));
    let friction = scalar_output(&*solver, "obstacles.friction");
    assert!((friction / lost - 1.0).abs() < 0.03, "{friction} {lost}");
    assert!((total(&*solver) - before).abs() < 0.005 * lost, "{} {before}", total(&*solver));
}

/// Every contact has friction from its first step on: while all slides the impulse along the floor is the coefficient times that across it.
#[test]
fn a_block_that_bounces_as_it_slides_has_all_its_friction() {
    let mut value = block(&frictional(0.3));
    value["bodies"][0]["velocity"] = json!({ "kind": "uniform", "value": [2.0, -0.3] });
    value["stages"] = json!([{ "name": "slide", "duration": 0.2 }]);
    for options in [json!({}), json!({ "courant": 0.9 }), json!({ "stress_update": "usf" })] {
        let mut value = value.clone();
        let mpm = value["methods"]["mpm"].as_object_mut().unwrap();
        mpm.extend(options.as_object().unwrap().clone());
        let mut solver = start_solver(&Mpm, &read_case(&value));
        let mut left = 0;
        while solver.time() < 0.2 {
            solver.step(0.2 - solver.time()).unwrap();
            left += u32::from(solver.reaction("floor").unwrap().force[1] == 0.0);
        }
        let [along, across, _] = solver.reaction("floor").unwrap().impulse;
        assert!(left > 0 && across < 0.0, "it bounces: {left} {across}");
        assert!((along / (-0.3 * across) - 1.0).abs() < 1e-9, "{options}: {along} {across}");
    }
}

#[test]
fn rough_obstacles_hold_points_in_contact_and_release_them_with_separation() {
    let rise = |separation: bool, kind: &str| {
        let mut value = block(&json!({ "kind": kind }));
        value["obstacles"][0]["separation"] = json!(separation);
        value["gravity"] = json!([1, 1]);
        let case = read_case(&value);
        let mut solver = start_solver(&Mpm, &case);
        advance_exactly_to(&mut *solver, 0.3);
        let places = solver.snapshot().positions;
        let mean = |c: usize| places.iter().map(|x| x[c]).sum::<f64>() / places.len() as f64;
        [mean(0) - 0.6, mean(1) - 0.65]
    };
    let [slip, up] = rise(false, "rough");
    assert!(slip.abs() < 1e-3 && up.abs() < 1e-3, "{slip} {up}");
    let [slip, up] = rise(true, "rough");
    // Local damping of 0.7 leaves 0.3 of the acceleration.
    let free = 0.5 * 0.3 * 0.09;
    assert!((up / free - 1.0).abs() < 0.05 && (slip / free - 1.0).abs() < 0.05, "{slip} {up} {free}");
    let [slip, up] = rise(false, "smooth");
    assert!((slip / free - 1.0).abs() < 0.05 && up.abs() < 1e-3, "{slip} {up}");
}

#[test]
fn adhesion_holds_a_block_that_friction_does_not() {
    // The base has an adhesion of 0.6 m times 200 Pa = 120 N against the 180 N of the load, and friction of 0.01 of the weight; or 400 Pa.
    let displacement = |adhesion: f64| {
        let mut wall = frictional(0.01);
        wall["adhesion"] = json!(adhesion);
        let mut value = block(&wall);
        value["gravity"] = json!([1.0, -1.0]);
        value["stages"] = json!([{ "name": "push", "duration": 0.4, "gravity_ramp": 0.1 }]);
        let case = read_case(&value);
        let mut solver = start_solver(&Mpm, &case);
        advance_exactly_to(&mut *solver, 0.4);
        solver.totals().momentum[0] / 180.0
    };
    assert!(displacement(400.0).abs() < 0.02, "{}", displacement(400.0));
    let slides = displacement(200.0);
    assert!(slides > 0.05 && slides < 0.2, "{slides}");
}

#[test]
fn a_sliding_and_vibrating_block_has_its_full_adhesion() {
    let slowed = |adhesion: f64| {
        let mut wall = frictional(0.1);
        wall["adhesion"] = json!(adhesion);
        let mut value = block(&wall);
        value["gravity"] = json!([0, -9.81]);
        value["stages"] = json!([{ "name": "slide", "duration": 0.3 }]);
        value["bodies"][0]["velocity"] = json!({ "kind": "uniform", "value": [3.0, 0.0] });
        let case = read_case(&value);
        let mut solver = start_solver(&Mpm, &case);
        let start = solver.totals();
        advance_exactly_to(&mut *solver, 0.3);
        (start.momentum[0] - solver.totals().momentum[0]) / solver.time()
    };
    // 0.6 m of base.
    let (friction, both) = (slowed(0.0), slowed(1000.0));
    assert!(((both - friction) / 600.0 - 1.0).abs() < 0.05, "{friction} {both}");
}

#[test]
fn a_disk_rolls_down_a_slope_of_points_and_check_warns_of_one_of_nodes() {
    let slope = 20f64.to_radians();
    let disk = |obstacles: &str| {
        read_case(&json!({
            "title": "roll", "space": "plane-strain", "domain": { "min": [0, -0.5], "max": [12, 2] },
            "gravity": [9.81 * slope.sin(), -9.81 * slope.cos()],
            "materials": { "m": { "model": "linear-elastic", "density": 2000, "youngs_modulus": 1e7, "poissons_ratio": 0.3 } },
            "bodies": [{ "name": "disk", "material": "m", "sampling": "fitted",
                         "shape": { "kind": "ball", "centre": [1, 0.5], "radius": 0.5 } }],
            "obstacles": [{ "name": "o", "shape": { "kind": "plane", "normal": [0, 1], "point": [0, 0] },
                            "wall": frictional(0.7) }],
            "stages": [{ "name": "s", "duration": 0.5 }],
            "methods": { "mpm": { "cell_size": 0.1, "obstacles": obstacles } }
        }))
    };
    let mut solver = start_solver(&Mpm, &disk("points"));
    advance_exactly_to(&mut *solver, 0.5);
    let end = solver.totals();
    let speed = end.momentum[0] / end.mass;
    // A rigid disk; this one is five cells in radius.
    let rigid = 2.0 / 3.0 * 9.81 * slope.sin() * solver.time();
    assert!((0.85..1.02).contains(&(speed / rigid)), "{speed} {rigid}");
    let has_warning = |obstacles: &str| {
        let warnings = Mpm.plan(&disk(obstacles)).unwrap().warnings;
        warnings.iter().any(|warning| {
            warning.text.starts_with("bodies[0]: disk is round") && warning.text.contains("points")
        })
    };
    assert!(has_warning("nodes") && !has_warning("points"));
}

/// State of a run after a number of steps on a number of threads, restarted from a checkpoint after the first of them where it is `cut`:
/// points, sums, reaction of `floor`, and the bits of its scalar outputs.
pub fn on_floor(
    case: &Case,
    steps: [usize; 2],
    threads: usize,
    cut: bool,
) -> (Snapshot, Budget, Reaction, Vec<u64>) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let mut solver = start_solver(&Mpm, case);
        advance_steps(&mut *solver, steps[0]);
        if cut {
            let saved = solver.checkpoint_bytes().unwrap();
            solver = start_solver(&Mpm, case);
            solver.restore(&mut saved.as_slice()).unwrap();
            solver.begin_stage(0, 0.0).unwrap();
        }
        advance_steps(&mut *solver, steps[1]);
        let readings = solver.scalar_outputs().iter().map(|reading| reading.2.to_bits()).collect();
        (solver.snapshot(), solver.totals(), solver.reaction("floor").unwrap(), readings)
    })
}

#[test]
fn penalty_contact_is_bit_identical_on_two_threads_and_after_a_restart() {
    let mut value = block(&frictional(0.3));
    value["bodies"][0]["velocity"] = json!({ "kind": "uniform", "value": [2.0, -0.5] });
    value["obstacles"][0]["shape"] = json!({ "kind": "ground-line", "points": [[-1, 0.6], [0.2, 0.5], [1.0, 0.45], [1.2, 0.6], [3, 0.7]] });
    let case = read_case(&value);
    let run = |threads: usize, cut: bool| on_floor(&case, [150, 250], threads, cut);
    let whole = run(1, false);
    assert!(whole.2.impulse[1] < 0.0);
    assert!(whole == run(2, false), "two threads");
    assert!(whole == run(1, true), "restored");
}

#[test]
fn point_centres_stay_above_a_ground_line_with_corners() {
    let mut value = block(&frictional(0.2));
    value["bodies"][0]["velocity"] = json!({ "kind": "uniform", "value": [1.0, -0.5] });
    value["stages"] = json!([{ "name": "slide", "duration": 1 }]);
    value["obstacles"][0]["shape"] = json!({ "kind": "ground-line", "points": [[-1, 0.7], [0.2, 0.45], [0.9, 0.4], [1.2, 0.55], [3, 1.2]] });
    let case: Case = read_case(&value);
    let standing = case.placed_obstacles::<2>().unwrap();
    let mut solver = start_solver(&Mpm, &case);
    while solver.time() < 1.0 {
        advance_steps(&mut *solver, 10);
        for x in solver.snapshot().positions {
            assert!(!standing[0].surface.contains(&[x[0], x[1]]), "{x:?} at {}", solver.time());
        }
    }
    let deep = solver.warnings_at_end().into_iter().find(|remark| remark.text.contains("obstacle"));
    assert!(deep.is_none(), "{deep:?}");
}

#[test]
fn options_without_support_for_obstacles_on_points_are_rejected_by_path() {
    let refused = |change: &dyn Fn(&mut Value)| {
        let mut value = block(&frictional(0.2));
        change(&mut value);
        Mpm.build(&read_case(&value)).map(|_| ()).unwrap_err().to_string()
    };
    let found = refused(&|case| {
        case["obstacles"] = json!([]);
        case["measures"] = json!({});
    });
    assert!(found.starts_with("methods.mpm.obstacles: points needs an obstacle"), "{found}");
    let found = refused(&|case| case["methods"]["mpm"]["obstacle_stiffness"] = json!(0));
    assert!(found.starts_with("methods.mpm.obstacle_stiffness: 0 is not in"), "{found}");
    let found = refused(&|case| {
        case["methods"]["mpm"] = json!({ "cell_size": 0.1, "obstacle_stiffness": 2 });
    });
    assert!(found.contains("needs obstacles points"), "{found}");
    let found = refused(&|case| case["methods"]["mpm"]["formulation"] = json!("small-displacement"));
    assert!(
        found.starts_with("methods.mpm.obstacles: points needs formulation updated-lagrangian"),
        "{found}"
    );
}

/// A plate of a fifth of a cell flies at a block, faster than its waves.
#[test]
fn a_fast_thin_plate_carries_the_points_that_it_meets() {
    let mut value = block(&json!({ "kind": "smooth" }));
    value["gravity"] = json!([0, 0]);
    value["obstacles"][0]["shape"] = json!({ "kind": "box", "min": [-9, -0.5], "max": [9, -0.48] });
    value["obstacles"][0]["motion"] = json!({ "velocity": [0, 60] });
    value["stages"] = json!([{ "name": "hit", "duration": 0.022 }]);
    value["measures"] = json!({});
    let mut solver = start_solver(&Mpm, &read_case(&value.clone()));
    let step = solver.limit();
    assert_eq!(step.limit.to_string(), "motion of an obstacle");
    assert!((step.dt - 0.25 * 0.1 / 60.0).abs() < 1e-15);
    advance_exactly_to(&mut *solver, 0.022);
    let lowest = solver.snapshot().positions.iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
    let plate = -0.48 + 60.0 * solver.time();
    assert!(lowest > plate, "a point is at {lowest} m, the plate at {plate} m");
    value["methods"]["mpm"]["time_step"] = json!(1e-3);
    let error = start_solver(&Mpm, &read_case(&value)).step(1.0).unwrap_err().to_string();
    assert!(error.contains("methods.mpm.time_step") && error.contains("motion of an obstacle"), "{error}");
}
