//! Obstacles with regions, and moments of their reactions (docs/theory/mpm.md, obstacles).

use colluvium_case::{Case, Method, Solver};
use colluvium_mpm::Mpm;
use colluvium_testkit::{advance_to, read_case, start_solver};
use serde_json::{Value, json};

const GRAVITY: f64 = 9.81;
const BOTH: [&str; 2] = ["nodes", "points"];

/// A flat block, 0.6 m long and 0.1 m high, on a smooth floor at y = 0.5 m with a rough part from x = 1.225 m on, between two nodes.
fn block(obstacles: &str, shape: &Value) -> Value {
    json!({
        "title": "block", "space": "plane-strain", "gravity": [0, -GRAVITY],
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.0 } },
        "domain": { "min": [0, 0.3], "max": [3, 0.8] },
        "bodies": [{
            "name": "block", "material": "m", "shape": { "kind": "box", "min": [0.3, 0.5], "max": [0.9, 0.6] },
            "stress": { "kind": "k0", "surface": 0.6, "coefficient": 0 },
            "velocity": { "kind": "uniform", "value": [2.0, 0.0] }
        }],
        "obstacles": [{
            "name": "floor", "wall": { "kind": "smooth" }, "separation": true, "shape": shape,
            "regions": [{
                "shape": { "kind": "box", "min": [1.225], "max": [5] },
                "wall": { "kind": "frictional", "friction_coefficient": 0.3 }
            }]
        }],
        "stages": [{ "name": "slide", "duration": 2 }],
        "methods": { "mpm": { "cell_size": 0.05, "obstacles": obstacles } }
    })
}

fn level() -> Value {
    json!({ "kind": "plane", "point": [0, 0.5], "normal": [0, 1] })
}

fn middle(solver: &dyn Solver) -> f64 {
    let places = solver.snapshot().positions;
    places.iter().map(|x| x[0]).sum::<f64>() / places.len() as f64
}

#[test]
fn a_block_slides_over_the_smooth_part_and_is_braked_on_the_rough_one() {
    for obstacles in BOTH {
        let case = read_case(&block(obstacles, &level()));
        let mut solver = start_solver(&Mpm, &case);
        advance_to(&mut *solver, 0.15);
        // Its front has come to 1.2 m.
        let kept = solver.totals().momentum[0] / solver.totals().mass / 2.0;
        assert!((kept - 1.0).abs() < 1e-3, "{obstacles}: {kept}");
        advance_to(&mut *solver, 1.6);
        // Over the edge friction grows with the share of the base on the rough part, so that the front stops v²/(2 μ g) + L/2 beyond it.
        let exact = 4.0 / (2.0 * 0.3 * GRAVITY) + 0.3;
        let distance = middle(&*solver) + 0.3 - 1.225;
        assert!((distance / exact - 1.0).abs() < 0.03, "{obstacles}: {distance} for {exact}");
        let still = solver.totals().momentum[0] / solver.totals().mass;
        assert!(still.abs() < 0.02, "{obstacles}: {still}");
    }
}

#[test]
fn a_block_separates_where_the_part_without_separation_ends() {
    // A smooth floor without separation holds it against gravity upwards; beyond the edge nothing does.
    let mut value = block("points", &level());
    value["gravity"] = json!([0.0, 1.0]);
    value["bodies"][0]["stress"] = json!({ "kind": "none" });
    value["obstacles"][0]["separation"] = json!(false);
    let case = read_case(&value);
    let mut solver = start_solver(&Mpm, &case);
    let height = |solver: &dyn Solver| {
        let places = solver.snapshot().positions;
        places.iter().map(|x| x[1]).sum::<f64>() / places.len() as f64 - 0.55
    };
    advance_to(&mut *solver, 0.15);
    assert!(height(&*solver).abs() < 1e-3, "{}", height(&*solver));
    // The tail passes the edge at 0.4625 s.
    advance_to(&mut *solver, 0.8);
    assert!(height(&*solver) > 0.03, "{}", height(&*solver));
}

#[test]
fn the_moment_of_a_reaction_is_that_of_the_weight() {
    for obstacles in BOTH {
        let mut value = block(obstacles, &level());
        value["bodies"][0]["velocity"] = json!({ "kind": "rest" });
        value["obstacles"][0]["wall"] = json!({ "kind": "rough" });
        value["measures"] = json!({ "push": { "kind": "reaction", "target": "floor", "about": [0.1, 0.5] } });
        value["stages"] = json!([{ "name": "rest", "duration": 1, "damping": 0.7 }]);
        let case = read_case(&value);
        let mut solver = start_solver(&Mpm, &case);
        advance_to(&mut *solver, 0.5);
        let weight = 0.06 * 1000.0 * GRAVITY;
        let readings = colluvium_case::measure::read_solver(&case, &*solver);
        let (_, unit, moment) = readings.iter().find(|(name, ..)| name == "push.moment").unwrap();
        // Half a metre to the right of the place, downwards: clockwise.
        let exact = -0.5 * weight;
        assert!(unit == "N m" && (moment / exact - 1.0).abs() < 2e-3, "{obstacles}: {moment} for {exact}");
    }
}

#[test]
fn invalid_regions_are_rejected_by_path() {
    let problem = |change: &dyn Fn(&mut Value)| {
        let mut value = block("points", &level());
        change(&mut value);
        match Case::from_json(&value.to_string()) {
            Err(errors) => errors.to_string(),
            Ok(case) => Mpm.build(&case).map(|_| ()).unwrap_err().to_string(),
        }
    };
    let region = |key: &str, value: Value| {
        let key = key.to_owned();
        move |case: &mut Value| case["obstacles"][0]["regions"][0][key.as_str()] = value.clone()
    };
    let found = problem(&region("shape", json!({ "kind": "box", "min": [0, 0], "max": [1, 1] })));
    assert!(found.starts_with("obstacles[0].regions[0].shape.min: "), "{found}");
    let found = problem(&region("outline", json!("part.geojson")));
    assert_eq!(found, "obstacles[0].regions[0].shape: give one of a shape, an outline and a raster");
    let found = problem(&|case: &mut Value| {
        case["obstacles"][0]["regions"][0] =
            json!({ "raster": { "file": "cover.asc" }, "wall": { "kind": "rough" } });
    });
    assert!(found.starts_with("obstacles[0].regions[0].raster: a raster over a plan needs"), "{found}");
    let found = problem(&|case: &mut Value| {
        case["obstacles"][0]["regions"][0] =
            json!({ "outline": "part.geojson", "wall": { "kind": "rough" } });
    });
    assert!(found.starts_with("obstacles[0].regions[0].outline: an outline in plan needs"), "{found}");
    let found = problem(&region("wall", json!({ "kind": "frictional", "friction_coefficient": -1 })));
    assert!(found.starts_with("obstacles[0].regions[0].wall.friction_coefficient: -1"), "{found}");
    let found = problem(&|case: &mut Value| case["obstacles"][0]["motion"] = json!({ "velocity": [1, 0] }));
    assert!(found.starts_with("obstacles[0].regions: are fixed in plan"), "{found}");
    let found = problem(&|case: &mut Value| {
        case["methods"]["mpm"]["obstacles"] = json!("nodes");
        case["obstacles"][0]["regions"][0]["wall"]["adhesion"] = json!(10);
    });
    assert!(found.starts_with("obstacles[0].regions[0].wall.adhesion: mpm"), "{found}");
    let found = problem(&|case: &mut Value| {
        case["measures"] = json!({ "push": { "kind": "reaction", "target": "floor", "about": [0] } });
    });
    assert!(found.starts_with("measures.push.about"), "{found}");
}
