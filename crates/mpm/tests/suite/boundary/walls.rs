//! Walls: separation, bilateral walls, motion.

use colluvium_case::{Budget, Method};
use colluvium_mpm::Mpm;
use colluvium_testkit::read_case;
use serde_json::{Value, json};

use crate::boundary::elastic_block;

#[test]
fn a_wall_with_separation_adds_no_energy_to_a_bouncing_body() {
    let ball = json!([{ "name": "b", "material": "m", "shape": { "kind": "ball", "centre": [0.5, 0.3], "radius": 0.2 },
                        "velocity": { "kind": "uniform", "value": [0.5, -2] } }]);
    let smooth = json!({ "side": "y-min", "wall": { "kind": "smooth" }, "separation": true });
    let rubbing = json!({ "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": 0.3 } });
    for wall in [smooth, rubbing] {
        for scheme in ["usl", "musl"] {
            let options = json!({ "cell_size": 0.05, "stress_update": scheme, "courant": 0.2 });
            let report = elastic_block()
                .with(json!({
                    "bodies": ball, "boundaries": [wall], "stages": [{ "name": "s", "duration": 0.15 }],
                    "methods": { "mpm": options }
                }))
                .solve(&Mpm);
            assert!(report.end.momentum[1] > 0.0, "it is on its way up");
            let kept = (report.end.kinetic + report.end.elastic) / report.start.kinetic;
            assert!(kept < 1.01 && kept > 0.7, "{wall}, {scheme}: {kept}");
        }
    }
}

#[test]
fn a_bilateral_wall_holds_a_hanging_body_without_friction() {
    let hanging = |bilateral: bool, fluid: Value, options: Value| {
        let mut text = json!({
            "gravity": [0, -10],
            "bodies": [{ "name": "b", "material": "m", "velocity": { "kind": "uniform", "value": [0.5, 0] },
                         "shape": { "kind": "box", "min": [0.35, 0.7], "max": [0.65, 1] } }],
            "boundaries": [{ "side": "y-max", "wall": { "kind": "frictional", "friction_coefficient": 0.5 } }],
            "stages": [{ "name": "s", "duration": 0.1 }],
            "methods": { "mpm": options }
        });
        if bilateral {
            text["boundaries"][0]["wall"]["bilateral"] = json!(true);
        }
        if !fluid.is_null() {
            text["bodies"][0]["pore_fluid"] = fluid;
        }
        elastic_block().with(text).solve(&Mpm).end
    };
    let fluid = || json!({ "porosity": 0.4, "intrinsic_permeability": 1e-8, "bulk_modulus": 1e6 });
    for options in [
        json!({ "cell_size": 0.05 }),
        json!({ "cell_size": 0.05, "stress_update": "usl", "wall_friction": "acceleration" }),
        json!({ "cell_size": 0.05, "stress_update": "usf", "fixed_nodes": "momentum", "wall_friction": "acceleration" }),
        json!({ "cell_size": 0.05, "shape": "linear", "mesh": { "kind": "box" } }),
    ] {
        for fluid in [Value::Null, fluid()] {
            let [held, dropped] =
                [true, false].map(|bilateral| hanging(bilateral, fluid.clone(), options.clone()));
            // The held body oscillates by its elasticity; a body in free fall has 1 m/s after 0.1 s.
            let speed = |end: &Budget| [end.momentum[0] / end.mass, end.momentum[1] / end.mass];
            assert!(speed(&held)[1].abs() < 0.2, "{options}: {:?}", speed(&held));
            assert!((speed(&dropped)[1] + 1.0).abs() < 0.02, "{options}: {:?}", speed(&dropped));
        }
    }
}

#[test]
fn walls_that_would_leave_their_plane_are_refused() {
    let bar = |speed: f64| {
        read_case(&json!({
            "title": "test", "space": "1d", "domain": { "min": [0], "max": [1] }, "gravity": [0],
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e5, "poissons_ratio": 0.2 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] } }],
            "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } },
                           { "side": "x-max", "wall": { "kind": "smooth" }, "velocity": [speed] }],
            "stages": [{ "name": "a", "duration": 1 }],
            "methods": { "mpm": { "cell_size": 0.1 } }
        }))
    };
    for speed in [0.2, -0.2] {
        let error = Mpm.build(&bar(speed)).err().unwrap().to_string();
        assert!(
            error.contains("boundaries[1].velocity") && error.contains("rigid body or a patch"),
            "{error}"
        );
    }
    assert!(Mpm.build(&bar(0.04)).is_ok());
}
