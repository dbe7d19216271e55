//! Saturated bodies on obstacles (docs/theory/mpm.md, obstacles).

use std::fmt::Write as _;

use colluvium_case::{Budget, Method, Solver};
use colluvium_mpm::Mpm;
use colluvium_testkit::{advance_steps, advance_to, read_case, scalars, start_solver, vectors, with_keys};
use serde_json::{Value, json};

const GRAVITY: f64 = 9.81;
const BOTH: [&str; 2] = ["nodes", "points"];

/// Grains of 2650 kg/m³ at a porosity of 0.4, whose skeleton has this modulus (Pa).
fn soil(modulus: f64) -> Value {
    json!({ "m": { "model": "linear-elastic", "density": 1590, "youngs_modulus": modulus, "poissons_ratio": 0.0 } })
}

/// Water, of a bulk modulus that leaves a skeleton of 10 MPa a hundredth of a load.
fn water(pressure: &Value) -> Value {
    json!({ "porosity": 0.4, "permeability": 1e-3, "bulk_modulus": 5e7, "pressure": pressure })
}

#[test]
fn a_saturated_layer_is_slowed_by_friction_of_its_effective_stress() {
    // The floor stands, or moves below a layer that stands.
    for (obstacles, moves) in [("nodes", false), ("points", false), ("points", true)] {
        let mut value = json!({
            "title": "layer", "space": "plane-strain", "gravity": [0, -GRAVITY], "materials": soil(1e7),
            "domain": { "min": [0, -0.4], "max": [0.4, 1.2], "periodic": ["x"] },
            "bodies": [{
                "name": "layer", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.4, 0.8] },
                "velocity": { "kind": "uniform", "value": [2, 0] },
                "stress": { "kind": "k0", "surface": 0.8, "coefficient": 0 },
                "pore_fluid": water(&json!({ "kind": "hydrostatic", "surface": 0.8 }))
            }],
            "obstacles": [{
                "name": "floor", "shape": { "kind": "plane", "point": [0, 0], "normal": [0, 1] },
                "wall": { "kind": "frictional", "friction_coefficient": 0.3 }
            }],
            "stages": [{ "name": "slide", "duration": 0.1 }],
            "methods": { "mpm": { "cell_size": 0.1, "obstacles": obstacles } }
        });
        if moves {
            value["bodies"][0]["velocity"]["value"] = json!([0, 0]);
            value["obstacles"][0]["motion"] = json!({ "velocity": [-2, 0] });
        }
        let case = read_case(&value);
        let mut solver = start_solver(&Mpm, &case);
        // On points the block first compresses the penalty springs, and their force is too small until pore water has drained.
        advance_to(&mut *solver, 0.5);
        let (start, from) = (solver.totals(), solver.time());
        advance_to(&mut *solver, 0.7);
        let lost = start.momentum[0] - solver.totals().momentum[0];
        let slowed = lost / start.mass / (solver.time() - from);
        // The pore pressure carries 1000 of 1990 kg/m³.
        let exact = 0.3 * GRAVITY * 990.0 / 1990.0;
        assert!((slowed / exact - 1.0).abs() < 0.02, "{obstacles}, {moves}: {slowed} for {exact}");
    }
}

/// A saturated block that falls and slides onto a slope of straight pieces.
fn thrown(obstacles: &str) -> Value {
    json!({
        "title": "slope", "space": "plane-strain", "gravity": [0, -GRAVITY], "materials": soil(1e6),
        "domain": { "min": [0, 0], "max": [3, 2] },
        "bodies": [{
            "name": "block", "material": "m", "shape": { "kind": "box", "min": [0.3, 1.3], "max": [0.9, 1.7] },
            "velocity": { "kind": "uniform", "value": [1.0, -1.0] },
            "pore_fluid": water(&json!({ "kind": "hydrostatic", "surface": 1.7 }))
        }],
        "obstacles": [{
            "name": "ground", "wall": { "kind": "frictional", "friction_coefficient": 0.4 },
            "shape": { "kind": "ground-line", "points": [[-0.1, 1.2], [1.1, 1.1], [2.3, 0.3], [3.7, 0.2]] }
        }],
        "measures": { "push": { "kind": "reaction", "target": "ground" } },
        "stages": [{ "name": "slide", "duration": 0.5 }],
        "methods": { "mpm": { "cell_size": 0.1, "obstacles": obstacles } }
    })
}

fn bits(solver: &dyn Solver) -> Vec<u64> {
    solver.scalar_outputs().iter().map(|reading| reading.2.to_bits()).collect()
}

/// The block with the ground of its obstacle, or on a level floor that lies on nodes.
fn on(obstacles: &str) -> Value {
    let mut value = thrown(obstacles);
    if obstacles == "nodes" {
        value["obstacles"][0]["shape"] = json!({ "kind": "plane", "point": [0, 1.2], "normal": [0, 1] });
    }
    value
}

#[test]
fn momentum_lost_by_a_saturated_block_is_the_reaction() {
    for (obstacles, fixed) in [("nodes", "force"), ("nodes", "momentum"), ("points", "force")] {
        let mut value = on(obstacles);
        value["methods"]["mpm"]["fixed_nodes"] = json!(fixed);
        let case = read_case(&value);
        let mut solver = start_solver(&Mpm, &case);
        let start = solver.totals();
        advance_to(&mut *solver, 0.3);
        let (end, push) = (solver.totals(), solver.reaction("ground").unwrap());
        // The mass of the water is that of its pores, which open and close.
        let weight = start.momentum[1] - end.momentum[1] - push.impulse[1];
        let own = GRAVITY * start.mass * solver.time();
        assert!((weight / own - 1.0).abs() < 1e-3, "{obstacles}, {fixed}: {weight} for {own}");
        let lost = start.momentum[0] - end.momentum[0];
        assert!((push.impulse[0] - lost).abs() < 1e-3 * own, "{obstacles}, {fixed}: {lost} and {push:?}");
        assert!(push.impulse[1] < -0.2 * own, "it has met the ground: {push:?}");
    }
}

#[test]
fn a_leaning_obstacle_on_nodes_is_refused_beside_pore_fluid() {
    let problem = Mpm.build(&read_case(&thrown("nodes"))).map(|_| ()).unwrap_err().to_string();
    assert!(
        problem.starts_with("obstacles[0].shape: with a pore fluid") && problem.contains("`points`"),
        "{problem}"
    );
}

#[test]
fn saturated_bodies_on_obstacles_are_bit_identical_on_threads_and_after_a_restart() {
    for obstacles in BOTH {
        let case = read_case(&on(obstacles));
        let run = |threads: usize, cut: bool| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut solver = start_solver(&Mpm, &case);
                advance_steps(&mut *solver, 300);
                if cut {
                    let saved = solver.checkpoint_bytes().unwrap();
                    solver = start_solver(&Mpm, &case);
                    solver.restore(&mut saved.as_slice()).unwrap();
                    solver.begin_stage(0, 0.0).unwrap();
                }
                advance_steps(&mut *solver, 300);
                (solver.snapshot(), solver.totals(), solver.reaction("ground").unwrap(), bits(&*solver))
            })
        };
        let whole = run(1, false);
        assert!(whole.2.impulse[1] < 0.0, "{obstacles}");
        assert_eq!(whole, run(2, false), "{obstacles}");
        assert_eq!(whole, run(2, true), "{obstacles}");
    }
}

/// A saturated column of 0.4 m by 0.8 m between smooth sides on a floor, under its weight from a state without stress.
fn column(floor: &Value, walls: bool) -> Value {
    let smooth = json!({ "kind": "smooth" });
    let mut value = json!({
        "title": "column", "space": "plane-strain", "gravity": [0, -GRAVITY], "materials": soil(1e6),
        "domain": { "min": [0, 0], "max": [0.4, 1.0] },
        "bodies": [{
            "name": "column", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.4, 0.8] },
            "pore_fluid": water(&json!({ "kind": "uniform", "value": 0 }))
        }],
        "stages": [{ "name": "settle", "duration": 1 }],
        "methods": { "mpm": { "cell_size": 0.1 } }
    });
    if walls {
        value["boundaries"] = json!([
            { "side": "x-min", "wall": smooth }, { "side": "x-max", "wall": smooth }, { "side": "y-min", "wall": floor }
        ]);
    } else {
        let plane = |name: &str, point: [f64; 2], normal: [f64; 2], wall: &Value| json!({ "name": name, "shape": { "kind": "plane", "point": point, "normal": normal }, "wall": wall });
        value["obstacles"] = json!([
            plane("left", [0.0, 0.0], [1.0, 0.0], &smooth),
            plane("right", [0.4, 0.0], [-1.0, 0.0], &smooth),
            plane("floor", [0.0, 0.0], [0.0, 1.0], floor)
        ]);
    }
    value
}

#[test]
fn axis_aligned_planes_act_on_both_phases_as_walls_do() {
    for floor in [
        json!({ "kind": "smooth" }),
        json!({ "kind": "rough" }),
        json!({ "kind": "frictional", "friction_coefficient": 0.2 }),
    ] {
        let run = |walls: bool| {
            let mut value = column(&floor, walls);
            value["gravity"] = json!([2.0, -GRAVITY]);
            let mut solver = start_solver(&Mpm, &read_case(&value));
            advance_steps(&mut *solver, 400);
            let snapshot = solver.snapshot();
            let mut velocities = vectors(&snapshot, "velocity");
            velocities.extend(vectors(&snapshot, "liquid_velocity"));
            (velocities, scalars(&snapshot, "pore_pressure"))
        };
        let (walls, planes) = (run(true), run(false));
        let speed = walls.0.iter().flatten().fold(0.0f64, |largest, v| largest.max(v.abs()));
        for (a, b) in walls.0.iter().zip(&planes.0) {
            assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-9 * speed), "{floor}: {a:?}, {b:?}");
        }
        let largest = walls.1.iter().fold(0.0f64, |largest, p| largest.max(p.abs()));
        assert!(walls.1.iter().zip(&planes.1).all(|(a, b)| (a - b).abs() < 1e-9 * largest), "{floor}");
    }
}

#[test]
fn check_names_nodes_where_they_are_exact_beside_pore_fluid() {
    let has_warning = |obstacles: &str, lowered: f64| {
        let mut value = column(&json!({ "kind": "smooth" }), false);
        value["domain"] = json!({ "min": [0, -0.2 - lowered], "max": [0.4, 1.0 - lowered] });
        value["methods"]["mpm"]["obstacles"] = json!(obstacles);
        let warnings = Mpm.plan(&read_case(&value)).unwrap().warnings;
        warnings
            .iter()
            .any(|warning| warning.text.starts_with("methods.mpm.obstacles: with points, stress and pore"))
    };
    assert!(has_warning("points", 0.0) && !has_warning("nodes", 0.0));
    // Where the floor is between two nodes there is no better form.
    assert!(!has_warning("points", 0.03));
}

/// Results at two times of the column on points, rotated by `angle` (radians) with its gravity: settlement of row 14 against that of row
/// 4 of 16 (m), mean pore pressure of the six rows in the middle (Pa).
fn settled(angle: f64) -> [[f64; 2]; 2] {
    let (sin, cos) = angle.sin_cos();
    let turned = |[s, n]: [f64; 2]| [cos * s - sin * n, sin * s + cos * n];
    let (mut places, mut text) = (Vec::new(), String::from("x,y,volume\n"));
    for number in 0..8 * 16 {
        places.push([0.025 + 0.05 * f64::from(number % 8), 0.025 + 0.05 * f64::from(number / 8)]);
        let [x, y] = turned(places[places.len() - 1]);
        writeln!(text, "{x},{y},0.0025").unwrap();
    }
    let file = std::env::temp_dir().join(format!("colluvium-{}-{angle}.csv", std::process::id()));
    std::fs::write(&file, text).unwrap();
    let mut value = column(&json!({ "kind": "smooth" }), false);
    value["domain"] = json!({ "min": [-1.03, -0.47], "max": [1.07, 1.13] });
    value["gravity"] = json!(turned([0.0, -GRAVITY]));
    value["bodies"][0]["points"] = json!({ "file": file });
    let corners = [[0.0, 0.0], [0.4, 0.0], [0.4, 0.8], [0.0, 0.8]].map(turned);
    value["bodies"][0]["shape"] = json!({ "kind": "polygon", "vertices": corners });
    for obstacle in value["obstacles"].as_array_mut().unwrap() {
        for key in ["point", "normal"] {
            let of: [f64; 2] = serde_json::from_value(obstacle["shape"][key].clone()).unwrap();
            obstacle["shape"][key] = json!(turned(of));
        }
    }
    value["bodies"][0]["pore_fluid"]["permeability"] = json!(4e-3);
    value["methods"]["mpm"] = json!({ "cell_size": 0.1, "obstacles": "points" });
    let case = read_case(&value);
    let mut solver = start_solver(&Mpm, &case);
    std::fs::remove_file(&file).unwrap();
    [0.375, 2.0].map(|time| {
        advance_to(&mut *solver, time);
        let snapshot = solver.snapshot();
        let sunk = |i: usize| {
            let x = snapshot.positions[i];
            places[i][1] - (-sin * x[0] + cos * x[1])
        };
        let pressures = scalars(&snapshot, "pore_pressure");
        let row = |of: &dyn Fn(usize) -> f64, row: usize| (8 * row..8 * row + 8).map(of).sum::<f64>() / 8.0;
        [row(&sunk, 14) - row(&sunk, 4), (5..11).map(|r| row(&|i| pressures[i], r)).sum::<f64>() / 6.0]
    })
}

#[test]
fn a_saturated_column_consolidates_on_a_leaning_floor_as_on_a_level_one() {
    let (level, leaning) = (settled(0.0), settled(0.5));
    for ([sunk, pressure], [own_sunk, own_pressure]) in leaning.into_iter().zip(level) {
        // Points that lie otherwise in the cells: 1 % of the settlement, and 3 % of a pressure that differs from row to row by more.
        assert!((sunk / own_sunk - 1.0).abs() < 0.015, "{level:?} {leaning:?}");
        assert!((pressure / own_pressure - 1.0).abs() < 0.05, "{level:?} {leaning:?}");
    }
    // The pore pressure decreases, and the skeleton settles: γ'/M (H z - z²/2) between the rows in the end.
    let end = 9712.0 / 1e6 * (0.8 * 0.5 - 0.5 * (0.725f64.powi(2) - 0.225f64.powi(2)));
    assert!(leaning[0][0] < 0.5 * end && (0.9..1.0).contains(&(leaning[1][0] / end)), "{leaning:?} {end}");
}

/// Impact of a saturated block on the ground: least distance of a centre from it (m), share of the energy of its grains that remains, error
/// of the momentum balance over the momentum at the start, and energy removed by the penetration limit (J).
fn impact(wall: &Value, options: &Value, stiffness: f64) -> (f64, f64, f64, f64) {
    let mut value = thrown("points");
    value["bodies"][0]["velocity"] = json!({ "kind": "uniform", "value": [5.0, -30.0] });
    value["obstacles"][0]["wall"] = wall.clone();
    value["methods"]["mpm"] = with_keys(value["methods"]["mpm"].clone(), options);
    value["methods"]["mpm"]["obstacle_stiffness"] = json!(stiffness);
    let case = read_case(&value);
    let standing = case.placed_obstacles::<2>().unwrap();
    let mut solver = start_solver(&Mpm, &case);
    let grains = |budget: &Budget| budget.mass - budget.liquid.unwrap().mass;
    let start = solver.totals();
    // Liquid mass is that in the pores: inflow and outflow in a step have its velocity. Points move first, or last.
    let first = options["stress_update"] == "usf";
    let (mut nearest, mut came, mut masses) = (f64::INFINITY, [0.0; 2], scalars(&solver.snapshot(), "mass"));
    while solver.time() < 0.05 {
        let (before, mass) = (solver.snapshot(), solver.totals().mass);
        advance_steps(&mut *solver, 1);
        let snapshot = solver.snapshot();
        let weighed = if first { solver.totals().mass } else { mass };
        came[1] -= GRAVITY * weighed * (snapshot.time - before.time);
        let now = scalars(&snapshot, "mass");
        let water = vectors(if first { &before } else { &snapshot }, "liquid_velocity");
        for (p, x) in snapshot.positions.iter().enumerate() {
            (0..2).for_each(|c| came[c] += (now[p] - masses[p]) * water[p][c]);
            let gap = standing[0].surface.gap(&[x[0], x[1]], 1.0);
            nearest = gap.map_or(nearest, |gap| nearest.min(gap.distance));
        }
        masses = now;
    }
    let (end, push) = (solver.totals(), solver.reaction("ground").unwrap());
    let off = |c: usize| (start.momentum[c] + came[c] - end.momentum[c] - push.impulse[c]).abs();
    let stopped =
        solver.scalar_outputs().into_iter().find(|(name, ..)| name == "obstacles.stopped").unwrap().2;
    (nearest, grains(&end) / grains(&start), off(0).max(off(1)) / (30.0 * start.mass), stopped)
}

/// The springs of the water turn the block back; where they are weaker by forty times its points are stopped.
#[test]
fn a_fast_saturated_block_does_not_penetrate_the_ground() {
    let frictional = json!({ "kind": "frictional", "friction_coefficient": 0.4 });
    for stiffness in [4.0, 0.1] {
        let mut stopped = 0.0;
        for (wall, options) in [
            (&frictional, json!({})),
            (&frictional, json!({ "stress_update": "usl", "shape": "quadratic" })),
            (&json!({ "kind": "smooth" }), json!({})),
            (&json!({ "kind": "rough" }), json!({ "stress_update": "usf" })),
        ] {
            let (nearest, grains, off, taken) = impact(wall, &options, stiffness);
            assert!(nearest > 0.0, "{stiffness} {wall} {options}: {nearest} m");
            assert!((grains - 1.0).abs() < 1e-12, "{stiffness} {wall} {options}: {grains}");
            assert!(off < 1e-9, "{stiffness} {wall} {options}: {off}");
            stopped += taken;
        }
        assert_eq!(stopped > 0.0, stiffness < 1.0, "{stopped} J");
    }
}

#[test]
fn contacts_with_pore_fluid_are_rejected_with_an_alternative() {
    let mut value = thrown("points");
    let other = |rigid: bool| json!({ "name": "other", "material": "m", "rigid": rigid, "shape": { "kind": "box", "min": [1.5, 1.3], "max": [1.9, 1.7] } });
    value["bodies"].as_array_mut().unwrap().push(other(false));
    value["methods"]["mpm"]["contacts"] =
        json!([{ "bodies": ["block", "other"], "friction_coefficient": 0.3 }]);
    let refused = |value: &Value| Mpm.plan(&read_case(&value.clone())).map(|_| ()).unwrap_err().to_string();
    let problem = refused(&value);
    assert!(problem.starts_with("methods.mpm.contacts: are not available with a pore_fluid"), "{problem}");
    assert!(problem.contains("obstacles points") && problem.contains("undrained"), "{problem}");
    let mut rigid = thrown("points");
    rigid["bodies"].as_array_mut().unwrap().push(other(true));
    let problem = refused(&rigid);
    assert!(problem.starts_with("bodies[1].rigid: ") && problem.contains("obstacles.motion"), "{problem}");
    // Without fluid that flows, the law has it.
    value["bodies"][0].as_object_mut().unwrap().remove("pore_fluid");
    value["materials"]["wet"] = json!({ "model": "undrained", "skeleton": value["materials"]["m"], "porosity": 0.4, "fluid_bulk_modulus": 2e9 });
    value["bodies"][0]["material"] = json!("wet");
    value["obstacles"] = json!([]);
    value["measures"] = json!({});
    value["methods"]["mpm"].as_object_mut().unwrap().remove("obstacles");
    Mpm.plan(&read_case(&value)).unwrap();
}
