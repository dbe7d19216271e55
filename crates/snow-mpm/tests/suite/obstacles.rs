//! Obstacles on the nodes (sheet: snow-mpm §3.7).

use colluvium_case::Solver;
use colluvium_snow_mpm::SnowMpm;
use colluvium_testkit::{advance_to, read_case, refusal, scalar_output, start_solver, vectors};
use serde_json::{Value, json};

/// Down the plane, which falls by 30 degrees.
const DOWN: [f64; 2] = [0.866_025_403_784_438_6, -0.5];

const GRAVITY: f64 = 9.81;

/// A block on a plane along no axis (sheet: snow-mpm V15).
fn block_on_plane(wall: &Value) -> Value {
    json!({
        "title": "block on a plane", "space": "plane-strain", "gravity": [0, -GRAVITY],
        "domain": { "min": [0, 0], "max": [4, 3] },
        "materials": { "m": { "model": "linear-elastic", "strain_measure": "hencky", "density": 400, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
        "bodies": [{ "name": "block", "material": "m", "shape": { "kind": "polygon",
            "vertices": [[0.519_615, 2.1], [1.385_641, 1.6], [1.635_641, 2.033_013], [0.769_615, 2.533_013]] } }],
        "obstacles": [{ "name": "plane", "wall": wall,
            "shape": { "kind": "plane", "point": [0, 2.4], "normal": [-DOWN[1], DOWN[0]] } }],
        // Dropped at once, an elastic block bounces, and slips while it is light.
        "stages": [
            { "name": "settle", "duration": 0.5, "gravity_ramp": 0.3, "damping": 0.5 },
            { "name": "slide", "duration": 0.6 }
        ],
        "methods": { "snow-mpm": { "cell_size": 0.05 } }
    })
}

/// After settling: mean acceleration down the plane (m/s²), way down it (m), and work of walls and that of friction over that of
/// gravity.
fn slid(wall: &Value) -> [f64; 4] {
    let case = read_case(&block_on_plane(wall));
    let mut solver = start_solver(&SnowMpm, &case);
    let works = |solver: &dyn Solver| {
        ["work_of_walls", "obstacles.friction", "work_of_gravity"].map(|name| scalar_output(solver, name))
    };
    let mean = |all: &[[f64; 3]]| {
        all.iter().map(|v| v[0] * DOWN[0] + v[1] * DOWN[1]).sum::<f64>() / all.len() as f64
    };
    advance_to(&mut *solver, 0.5);
    solver.end_stage(&case.stages[0]).unwrap();
    solver.begin_stage(1, 0.5).unwrap();
    let (start, before) = (solver.snapshot(), works(&*solver));
    advance_to(&mut *solver, 1.1);
    let (end, after) = (solver.snapshot(), works(&*solver));
    let displacement = mean(&end.positions) - mean(&start.positions);
    let rate =
        (mean(&vectors(&end, "velocity")) - mean(&vectors(&start, "velocity"))) / (end.time - start.time);
    let [walls, friction, gravity] = std::array::from_fn(|k| after[k] - before[k]);
    [rate, displacement, walls / gravity, friction / gravity]
}

#[test]
fn a_block_slides_on_a_plane_along_no_axis_by_coulombs_law() {
    let [rate, _, walls, friction] = slid(&json!({ "kind": "frictional", "friction_coefficient": 0.3 }));
    let exact = GRAVITY * (0.5 - 0.3 * DOWN[0]);
    let [_, displacement, ..] = slid(&json!({ "kind": "frictional", "friction_coefficient": 0.7 }));
    assert!((rate / exact - 1.0).abs() < 5e-3, "{rate} for {exact}");
    assert!(displacement.abs() < 1e-3, "{displacement}");
    // The share of a rigid block; a settling block lifts off for short times without friction.
    let share = 0.3 * DOWN[0] / 0.5;
    assert!(
        (friction / share - 1.0).abs() < 0.02 && (walls + friction).abs() < 0.01,
        "{friction} for {share}, {walls}"
    );
}

#[test]
fn a_block_on_a_smooth_plane_slides_without_friction() {
    let [rate, _, work, friction] = slid(&json!({ "kind": "smooth" }));
    let exact = 0.5 * GRAVITY;
    assert!((rate / exact - 1.0).abs() < 1e-3, "{rate} for {exact}");
    assert!(work.abs() < 5e-3 && friction.abs() < 1e-12, "{work} {friction}");
}

#[test]
fn bodies_inside_obstacles_and_adhesion_are_refused_by_path() {
    let mut case = block_on_plane(&json!({ "kind": "rough" }));
    case["bodies"][0]["shape"] = json!({ "kind": "box", "min": [0.5, 2.0], "max": [1.0, 2.5] });
    let error = refusal(&SnowMpm, &case);
    assert!(
        error.starts_with("bodies[0].shape: the point at [0.5") && error.contains("\"plane\""),
        "{error}"
    );
    let wall = json!({ "kind": "frictional", "friction_coefficient": 0.3, "adhesion": 10 });
    let error = refusal(&SnowMpm, &block_on_plane(&wall));
    assert!(error.starts_with("obstacles[0].wall.adhesion: snow-mpm"), "{error}");
}

/// A block of snow that a ball on its way runs into, without gravity.
fn rammed(wall: &Value) -> Value {
    let mut case = block_on_plane(wall);
    case["gravity"] = json!([0, 0]);
    case["bodies"][0]["shape"] = json!({ "kind": "box", "min": [1.5, 1], "max": [2.5, 2] });
    case["obstacles"] = json!([{ "name": "ram", "wall": wall, "motion": { "velocity": [3, 0.5] },
        "shape": { "kind": "ball", "centre": [1.2, 1.5], "radius": 0.25 } }]);
    case["stages"] = json!([{ "name": "ram", "duration": 0.1 }]);
    case["measures"] = json!({ "ram": { "kind": "reaction", "target": "ram", "about": [0, 0] },
        "pressure": { "kind": "impact-pressure", "target": "ram", "direction": [2, 0], "area": 0.5 } });
    case
}

#[test]
fn reaction_of_a_moving_obstacle_equals_the_momentum_of_the_body() {
    for wall in [
        json!({ "kind": "rough" }),
        json!({ "kind": "smooth" }),
        json!({ "kind": "frictional", "friction_coefficient": 0.4 }),
    ] {
        let case = read_case(&rammed(&wall));
        let mut solver = start_solver(&SnowMpm, &case);
        advance_to(&mut *solver, 0.08);
        let given = solver.totals().momentum;
        let reaction = solver.reaction("ram").unwrap().impulse;
        // The ball has moved by 0.24 m, and met the block after 0.05 m.
        assert!(given[0] > 0.25 * 400.0 * 3.0, "{wall}: {given:?}");
        for c in 0..2 {
            assert!((given[c] + reaction[c]).abs() < 1e-9 * given[0], "{wall}: {given:?} {reaction:?}");
        }
        let readings = colluvium_case::measure::read_solver(&case, &*solver);
        let pressure = readings.iter().find(|(name, ..)| name == "pressure.impulse").unwrap().2;
        assert!((pressure + given[0] / 0.5).abs() < 1e-9 * given[0], "{pressure}");
        // Work of the ball is the energy of the block plus the numerical dissipation.
        let work = scalar_output(&*solver, "work_of_walls");
        let budget = solver.totals();
        assert!((work / (budget.kinetic + budget.elastic) - 1.0).abs() < 0.2, "{wall}: {work} {budget:?}");
    }
}

/// Angular momentum, over that at the start, of a disc that turns by 1 rad/s in a rough bowl after 0.05 s.
fn spin_kept(bowl: &Value) -> f64 {
    let mut case = block_on_plane(&json!({ "kind": "rough" }));
    case["gravity"] = json!([0, 0]);
    case["bodies"][0]["shape"] = json!({ "kind": "ball", "centre": [2, 1.5], "radius": 0.5 });
    case["bodies"][0]["velocity"] =
        json!({ "kind": "linear", "value": [0, 0], "origin": [2, 1.5], "gradient": [[0, -1], [1, 0]] });
    case["obstacles"][0]["shape"] =
        json!({ "kind": "ball", "centre": [2, 1.5], "radius": 0.5, "hollow": true });
    case["obstacles"][0]["motion"] = bowl.clone();
    case["stages"] = json!([{ "name": "turn", "duration": 0.1 }]);
    let case = read_case(&case);
    let mut solver = start_solver(&SnowMpm, &case);
    let before = solver.totals();
    assert!(before.momentum[0].abs() < 1e-9);
    advance_to(&mut *solver, 0.05);
    solver.totals().angular_momentum[2] / before.angular_momentum[2]
}

#[test]
fn a_bowl_rotating_with_its_contents_leaves_the_rotation_unchanged() {
    let turning = spin_kept(&json!({ "rotation": 180.0 / std::f64::consts::PI, "centre": [2, 1.5] }));
    assert!((turning - 1.0).abs() < 1e-3, "{turning}");
    let still = spin_kept(&Value::Null);
    assert!(still < 0.5, "{still}");
}

#[test]
fn reaction_of_a_settled_block_is_its_weight() {
    let mut case = block_on_plane(&json!({ "kind": "rough" }));
    case["bodies"][0]["shape"] = json!({ "kind": "box", "min": [1.5, 1], "max": [2.5, 1.5] });
    case["obstacles"][0]["shape"] = json!({ "kind": "plane", "point": [0, 1], "normal": [0, 1] });
    case["measures"] = json!({ "ground": { "kind": "reaction", "target": "plane" } });
    case["stages"] = json!([
        { "name": "settle", "duration": 0.5, "gravity_ramp": 0.3, "damping": 0.5 },
        { "name": "rest", "duration": 0.5 }
    ]);
    let case = read_case(&case);
    let mut solver = start_solver(&SnowMpm, &case);
    let state = |solver: &dyn Solver| {
        [solver.reaction("plane").unwrap().impulse[1], solver.totals().momentum[1], solver.time()]
    };
    advance_to(&mut *solver, 0.5);
    solver.end_stage(&case.stages[0]).unwrap();
    solver.begin_stage(1, 0.5).unwrap();
    let before = state(&*solver);
    advance_to(&mut *solver, 1.0);
    let after = state(&*solver);
    let [reaction, gained, time] = std::array::from_fn(|k| after[k] - before[k]);
    let weight = 400.0 * 0.5 * GRAVITY * time;
    // The weight less the reaction of the ground accelerates the block.
    assert!((reaction + weight + gained).abs() < 1e-7 * weight, "{reaction} {gained} {weight}");
    assert!((reaction / weight + 1.0).abs() < 0.05, "{reaction} of {weight}");
}

#[test]
fn reactions_of_too_many_obstacles_are_refused() {
    let mut case = rammed(&json!({ "kind": "smooth" }));
    for number in 0..8 {
        let shape = json!({ "kind": "ball", "centre": [0.1, 0.1 + 0.2 * f64::from(number)], "radius": 0.01 });
        case["obstacles"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "name": format!("o{number}"), "wall": { "kind": "rough" }, "shape": shape }));
        case["measures"][format!("z{number}")] =
            json!({ "kind": "reaction", "target": format!("o{number}") });
    }
    let error = refusal(&SnowMpm, &case);
    assert!(error.starts_with("measures.z7.target: snow-mpm records the reactions"), "{error}");
}

#[test]
fn a_block_is_braked_where_an_obstacle_has_a_rough_part() {
    let case = read_case(&json!({
        "title": "block", "space": "plane-strain", "gravity": [0, -GRAVITY],
        "domain": { "min": [0, 0.3], "max": [3, 0.9] },
        "materials": { "m": { "model": "linear-elastic", "strain_measure": "hencky", "density": 400, "youngs_modulus": 1e6, "poissons_ratio": 0.0 } },
        "bodies": [{ "name": "block", "material": "m", "shape": { "kind": "box", "min": [0.3, 0.5], "max": [0.9, 0.6] },
            "velocity": { "kind": "uniform", "value": [2, 0] } }],
        "obstacles": [{ "name": "floor", "wall": { "kind": "smooth" }, "separation": true,
            "shape": { "kind": "plane", "point": [0, 0.5], "normal": [0, 1] },
            "regions": [{ "shape": { "kind": "box", "min": [1.225], "max": [5] },
                "wall": { "kind": "frictional", "friction_coefficient": 0.3 } }] }],
        "stages": [{ "name": "slide", "duration": 2 }],
        "methods": { "snow-mpm": { "cell_size": 0.05 } }
    }));
    let mut solver = start_solver(&SnowMpm, &case);
    let middle = |solver: &dyn Solver| {
        let places = solver.snapshot().positions;
        places.iter().map(|x| x[0]).sum::<f64>() / places.len() as f64
    };
    advance_to(&mut *solver, 0.15);
    let kept = solver.totals().momentum[0] / solver.totals().mass / 2.0;
    assert!((kept - 1.0).abs() < 2e-3, "on the smooth part: {kept}");
    advance_to(&mut *solver, 1.6);
    // Over the edge friction grows with the share of the base on the rough part, so that the front stops v²/(2 μ g) + L/2 beyond it.
    let exact = 4.0 / (2.0 * 0.3 * GRAVITY) + 0.3;
    let displacement = middle(&*solver) + 0.3 - 1.225;
    eprintln!("{displacement} {exact}");
    assert!((displacement / exact - 1.0).abs() < 0.03, "{displacement} for {exact}");
}

#[test]
fn obstacle_moment_equals_the_angular_momentum_of_the_body_and_speed_limits_the_step() {
    let mut value = rammed(&json!({ "kind": "smooth" }));
    // Below the middle of the block, which begins to turn.
    value["obstacles"][0]["shape"]["centre"] = json!([1.2, 1.2]);
    value["obstacles"][0]["motion"] = json!({ "velocity": [3, 0] });
    value["methods"]["snow-mpm"]["transfer"] = json!("apic");
    let mut solver = start_solver(&SnowMpm, &read_case(&value.clone()));
    let mut given = 0.0;
    while solver.time() < 0.08 {
        let dt = solver.step(1.0).unwrap().dt;
        given -= dt * solver.reaction("ram").unwrap().moment_about(&[2.0, 1.5, 0.0]).unwrap()[2];
    }
    // Momentum is in the middle of the block, or near it.
    let totals = solver.totals();
    let [px, py, _] = totals.momentum;
    let turn = totals.angular_momentum[2] - (2.0 * py - 1.5 * px);
    assert!(given > 0.0 && (turn / given - 1.0).abs() < 0.02, "{turn} for {given}");
    value["obstacles"][0]["motion"] = json!({ "velocity": [300, 0] });
    let step = start_solver(&SnowMpm, &read_case(&value.clone())).limit();
    assert_eq!((step.dt, step.limit.to_string().as_str()), (0.5 * 0.05 / 300.0, "motion of an obstacle"));
    value["methods"]["snow-mpm"]["time_step"] = json!(2e-4);
    let error = refusal(&SnowMpm, &value);
    assert!(
        error.starts_with("methods.snow-mpm.time_step") && error.contains("motion of an obstacle"),
        "{error}"
    );
}
