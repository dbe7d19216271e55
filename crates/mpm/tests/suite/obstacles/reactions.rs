//! Reactions of obstacles to bodies at rest: in axisymmetry the momentum lost by a falling body, in the plane and in space the weight of
//! grains and water (docs/theory/mpm.md, obstacles).

use colluvium_case::Solver;
use colluvium_mpm::Mpm;
use colluvium_testkit::{advance_to, read_case, scalars, start_solver};
use serde_json::{Value, json};

const GRAVITY: f64 = 9.81;
const BOTH: [&str; 2] = ["nodes", "points"];

/// Mean force (N) of the bodies on the obstacle `ground` between two times (s).
fn mean_reaction(solver: &mut dyn Solver, from: f64, to: f64) -> [f64; 3] {
    let mut impulse = |time: f64| {
        advance_to(&mut *solver, time);
        solver.reaction("ground").unwrap().impulse
    };
    let (start, end) = (impulse(from), impulse(to));
    std::array::from_fn(|c| (end[c] - start[c]) / (to - from))
}

/// A parallelogram from 0.5 m to 1.1 m, 0.3 m high, on a slope that falls outwards by a third: a block, or a ring on a cone.
fn on_a_slope(space: &str, obstacles: &str, wall: &Value, stage: &Value) -> Value {
    let at = |x: f64, above: f64| [x, 1.0 - x / 3.0 + above];
    let corners = [at(0.5, 0.0), at(1.1, 0.0), at(1.1, 0.3), at(0.5, 0.3)];
    let ground =
        json!({ "kind": "polygon", "vertices": [at(0.0, 0.0), at(2.0, 0.0), [2.0, -0.5], [0.0, -0.5]] });
    json!({
        "title": "on a slope", "space": space, "gravity": [0, -GRAVITY],
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.2 } },
        "domain": { "min": [0, 0], "max": [2, 1.5] },
        "bodies": [{ "name": "body", "material": "m", "shape": { "kind": "polygon", "vertices": corners } }],
        "obstacles": [{ "name": "ground", "shape": ground, "wall": wall }],
        "stages": [stage],
        "measures": { "reaction": { "kind": "reaction", "target": "ground" } },
        "methods": { "mpm": { "cell_size": 0.1, "obstacles": obstacles } }
    })
}

#[test]
fn momentum_lost_by_a_ring_on_a_cone_is_the_reaction_per_radian() {
    // Pappus: the area times the radius of its centroid.
    let exact = 1000.0 * GRAVITY * 0.6 * 0.3 * 0.8;
    for obstacles in BOTH {
        let wall = json!({ "kind": "frictional", "friction_coefficient": 0.3 });
        let value = on_a_slope("axisymmetric", obstacles, &wall, &json!({ "name": "fall", "duration": 0.5 }));
        let mut solver = start_solver(&Mpm, &read_case(&value));
        let weight = GRAVITY * solver.totals().mass;
        assert!((weight / exact - 1.0).abs() < 0.02, "{obstacles}: points in cells, {weight} {exact}");
        let start = solver.totals().momentum[1];
        advance_to(&mut *solver, 0.5);
        let lost = weight * solver.time() + solver.totals().momentum[1] - start;
        let reaction = -solver.reaction("ground").unwrap().impulse[1];
        assert!(reaction > 0.3 * weight * 0.5, "{obstacles}: it lies on the cone: {reaction} {weight}");
        assert!((reaction / lost - 1.0).abs() < 1e-6, "{obstacles}: {reaction} {lost}");
    }
}

/// The impulses that stop points are in balance with their weight: a damping that counts them as unbalanced forces carries a tenth of this
/// block.
#[test]
fn an_obstacle_carries_a_damped_block_whose_base_is_stepped() {
    for space in ["plane-strain", "axisymmetric"] {
        for obstacles in BOTH {
            let stage = json!({ "name": "rest", "duration": 1, "damping": 0.5 });
            let value = on_a_slope(space, obstacles, &json!({ "kind": "rough" }), &stage);
            let mut solver = start_solver(&Mpm, &read_case(&value));
            let weight = GRAVITY * solver.totals().mass;
            let [_, up, _] = mean_reaction(&mut *solver, 0.5, 1.0);
            assert!((-up / weight - 1.0).abs() < 0.01, "{space}, {obstacles}: {up} {weight}");
        }
    }
}

/// Reactions (N) of a floor and a wall that a block is pressed into the corner of, listed in one order or the other.
fn in_a_corner(obstacles: &str, wall: &Value, wall_first: bool) -> [[f64; 3]; 2] {
    let plane = |name: &str, normal: [f64; 2]| json!({ "name": name, "shape": { "kind": "plane", "point": [0, 0], "normal": normal }, "wall": wall });
    let mut planes = vec![plane("floor", [0.0, 1.0]), plane("wall", [0.8, 0.6])];
    if wall_first {
        planes.reverse();
    }
    let value = json!({
        "title": "corner", "space": "plane-strain", "gravity": [-5, -GRAVITY],
        "materials": { "m": { "model": "linear-elastic", "density": 1600, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
        "domain": { "min": [-0.9, -0.2], "max": [1.2, 1.2] },
        "bodies": [{ "name": "block", "material": "m",
                     "shape": { "kind": "polygon", "vertices": [[0, 0], [0.8, 0], [0.8, 0.8], [-0.6, 0.8]] } }],
        "obstacles": planes,
        "stages": [{ "name": "rest", "duration": 1, "damping": 0.5 }],
        "measures": { "of_floor": { "kind": "reaction", "target": "floor" }, "of_wall": { "kind": "reaction", "target": "wall" } },
        "methods": { "mpm": { "cell_size": 0.1, "obstacles": obstacles } }
    });
    let mut solver = start_solver(&Mpm, &read_case(&value));
    advance_to(&mut *solver, 0.3);
    for x in &solver.snapshot().positions {
        let before = [x[1], 0.8 * x[0] + 0.6 * x[1]].into_iter().fold(f64::INFINITY, f64::min);
        assert!(before > -0.01, "{obstacles}, {wall}: no point is behind a plane: {x:?}");
    }
    ["floor", "wall"].map(|name| solver.reaction(name).unwrap().impulse)
}

#[test]
fn reactions_in_a_corner_do_not_depend_on_the_order_of_the_obstacles() {
    for wall in [
        json!({ "kind": "rough" }),
        json!({ "kind": "frictional", "friction_coefficient": 0.4 }),
        json!({ "kind": "smooth" }),
    ] {
        for obstacles in BOTH {
            let [one, other] = [false, true].map(|first| in_a_corner(obstacles, &wall, first));
            let scale = one[0][1].abs();
            for (a, b) in one.as_flattened().iter().zip(other.as_flattened()) {
                assert!((a - b).abs() < 1e-9 * scale, "{obstacles}, {wall}: {one:?} {other:?}");
            }
        }
    }
}

/// A saturated column, 0.8 m high, between smooth sides on an obstacle.
fn column(space: &str, obstacles: &str) -> Value {
    let (low, high, top) = match space {
        "3d" => (vec![0.0; 3], vec![0.2, 0.2, 0.8], vec![0.2, 0.2, 1.0]),
        _ => (vec![0.0; 2], vec![0.4, 0.8], vec![0.4, 1.0]),
    };
    let up = low.len() - 1;
    let along = |of: f64| -> Vec<f64> { (0..=up).map(|c| if c == up { of } else { 0.0 }).collect() };
    let sides = ["x-min", "x-max", "y-min", "y-max"];
    let boundaries: Vec<Value> =
        sides[..2 * up].iter().map(|side| json!({ "side": side, "wall": { "kind": "smooth" } })).collect();
    json!({
        "title": "column", "space": space, "gravity": along(-GRAVITY),
        "materials": { "m": { "model": "linear-elastic", "density": 1590, "youngs_modulus": 1e6, "poissons_ratio": 0.0 } },
        "domain": { "min": low, "max": top }, "boundaries": boundaries,
        "bodies": [{
            "name": "column", "material": "m", "shape": { "kind": "box", "min": low, "max": high },
            "pore_fluid": {
                "porosity": 0.4, "permeability": 4e-3, "bulk_modulus": 5e7,
                "pressure": { "kind": "uniform", "value": 0 }
            }
        }],
        "obstacles": [{
            "name": "ground", "shape": { "kind": "plane", "point": along(0.0), "normal": along(1.0) },
            "wall": { "kind": "smooth" }
        }],
        "stages": [{ "name": "settle", "duration": 2 }],
        "measures": { "reaction": { "kind": "reaction", "target": "ground" } },
        "methods": { "mpm": { "cell_size": 0.1, "obstacles": obstacles } }
    })
}

#[test]
fn an_obstacle_carries_the_grains_and_the_water_of_a_column_at_rest() {
    for space in ["plane-strain", "3d"] {
        for obstacles in BOTH {
            let mut solver = start_solver(&Mpm, &read_case(&column(space, obstacles)));
            let force = mean_reaction(&mut *solver, 1.5, 2.0);
            let weight = GRAVITY * solver.totals().mass;
            let up = if space == "3d" { 2 } else { 1 };
            assert!((force[up] / -weight - 1.0).abs() < 0.01, "{space}, {obstacles}: {force:?} {weight}");
            // In the pores the pressure of water alone is left.
            let pressures = scalars(&solver.snapshot(), "pore_pressure");
            let (mean, still) =
                (pressures.iter().sum::<f64>() / pressures.len() as f64, 1000.0 * GRAVITY * 0.4);
            assert!((mean / still - 1.0).abs() < 0.05, "{space}, {obstacles}: {mean} {still}");
        }
    }
}

/// A saturated block that water seeps out of, on a slope, or a ring on a cone.
fn saturated_on_a_slope(space: &str, damping: f64) -> Value {
    let stage = json!({ "name": "rest", "duration": 1, "damping": damping });
    let mut value = on_a_slope(space, "points", &json!({ "kind": "rough" }), &stage);
    value["materials"]["m"]["density"] = json!(1590);
    value["bodies"][0]["pore_fluid"] = json!({
        "porosity": 0.4, "permeability": 1e-3, "bulk_modulus": 5e7, "pressure": { "kind": "uniform", "value": 0 }
    });
    value
}

/// The impulses that stop points, and the drag of seeping water on grains, are in balance with the weight of both and are not damped.
#[test]
fn an_obstacle_carries_a_damped_saturated_block_that_water_seeps_out_of() {
    for space in ["plane-strain", "axisymmetric"] {
        for damping in [0.05, 0.2, 0.5] {
            let mut solver = start_solver(&Mpm, &read_case(&saturated_on_a_slope(space, damping)));
            let weight = GRAVITY * solver.totals().mass;
            let [_, up, _] = mean_reaction(&mut *solver, 0.5, 1.0);
            assert!((-up / weight - 1.0).abs() < 0.005, "{space}, {damping}: {up} {weight}");
        }
    }
}

/// Mean of the excess pore pressure over that at the start, of a column that consolidates under its weight (Terzaghi 1923, with a
/// pressure that grows with the depth at the start), at a time factor.
fn excess_left(time_factor: f64) -> f64 {
    let mode = |m: i32| {
        let root = std::f64::consts::FRAC_PI_2 * f64::from(2 * m + 1);
        f64::from(1 - 2 * (m % 2)) * 4.0 / root.powi(3) * (-root * root * time_factor).exp()
    };
    (0..20).map(mode).sum()
}

/// A damping by the force that drives seepage took half of it away (sheet: mpm §2.13).
#[test]
fn damping_does_not_slow_consolidation_and_the_weight_is_carried_throughout() {
    for (space, obstacles) in [("plane-strain", "nodes"), ("plane-strain", "points"), ("3d", "points")] {
        let dampings = [0.0, 0.5];
        let left = dampings.map(|damping| {
            let mut value = column(space, obstacles);
            value["stages"][0]["damping"] = json!(damping);
            let mut solver = start_solver(&Mpm, &read_case(&value));
            let up = mean_reaction(&mut *solver, 0.2, 0.8)[if space == "3d" { 2 } else { 1 }];
            let weight = GRAVITY * solver.totals().mass;
            assert!((-up / weight - 1.0).abs() < 0.005, "{space}, {obstacles}, {damping}: {up} {weight}");
            let pressures = scalars(&solver.snapshot(), "pore_pressure");
            let mean = pressures.iter().sum::<f64>() / pressures.len() as f64;
            let (still, start) = (1000.0 * GRAVITY * 0.4, 990.0 * GRAVITY * 0.4);
            (mean - still) / start
        });
        let rate = 4e-3 / (9810.0 * (1e-6 + 0.4 / 5e7));
        let exact = excess_left(rate * 0.8 / 0.64);
        // The springs of obstacles on points take water in before they hold it, damped or not.
        let of = if obstacles == "nodes" { exact } else { left[0] };
        assert!((left[1] - of).abs() < 0.03, "{space}, {obstacles}: {left:?} {exact}");
    }
}
