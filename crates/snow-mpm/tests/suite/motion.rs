//! Motions with closed forms, and conservation.

use colluvium_snow_mpm::SnowMpm;
use colluvium_testkit::{
    advance_steps, advance_to, assert_near, read_case, scalar_output, solve, start_solver, stresses, vectors,
};
use serde_json::{Value, json};

use crate::bodies::{ball, block};

fn transfers() -> [Value; 4] {
    [
        json!({ "transfer": "apic" }),
        json!({ "transfer": "apic", "shape": "quadratic" }),
        json!({ "transfer": "flip", "flip_ratio": 1 }),
        json!({ "transfer": "flip" }),
    ]
}

#[test]
fn a_translation_keeps_velocity_and_shape() {
    // Sheet: snow-mpm V4.
    for options in transfers() {
        let mut solver = start_solver(
            &SnowMpm,
            &read_case(&block(&json!({ "kind": "uniform", "value": [3, -2] }), &options)),
        );
        let start = solver.snapshot();
        advance_steps(&mut *solver, 40);
        let end = solver.snapshot();
        for (velocity, (a, b)) in
            vectors(&end, "velocity").iter().zip(start.positions.iter().zip(&end.positions))
        {
            assert_near(velocity[0], 3.0, 1e-11);
            assert_near(velocity[1], -2.0, 1e-11);
            assert_near(b[0] - a[0], 3.0 * end.time, 1e-12);
        }
        assert!(stresses(&end).as_flattened().iter().all(|s| s.abs() < 1e-5), "{options}");
    }
}

/// A strip between smooth walls is strained along itself alone, as all that there is in one dimension.
#[test]
fn a_bar_in_one_dimension_oscillates_as_a_confined_strip_does() {
    let ran = |plane: bool| {
        let mut value =
            block(&json!({ "kind": "linear", "value": [0], "origin": [1], "gradient": [[3]] }), &json!({}));
        value["space"] = json!("1d");
        value["domain"] = json!({ "min": [0], "max": [2] });
        value["gravity"] = json!([0]);
        value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [0.5], "max": [1.5] });
        if plane {
            value["space"] = json!("plane-strain");
            value["domain"] = json!({ "min": [0, 0], "max": [2, 0.4] });
            value["gravity"] = json!([0, 0]);
            value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [0.5, 0], "max": [1.5, 0.4] });
            value["bodies"][0]["velocity"] =
                json!({ "kind": "linear", "value": [0, 0], "origin": [1, 0], "gradient": [[3, 0], [0, 0]] });
            let smooth = |side: &str| json!({ "side": side, "wall": { "kind": "smooth" } });
            value["boundaries"] = json!([smooth("y-min"), smooth("y-max")]);
        }
        let mut solver = start_solver(&SnowMpm, &read_case(&value));
        for _ in 0..100 {
            solver.step(1e-4).unwrap();
        }
        let totals = solver.totals();
        [
            totals.kinetic / totals.mass,
            totals.elastic / totals.mass,
            scalar_output(&*solver, "energy_numerical") / totals.mass,
        ]
    };
    let (bar, strip) = (ran(false), ran(true));
    assert!(bar[1] > 0.1 * bar[0], "{bar:?}");
    for (one, two) in bar.iter().zip(strip) {
        assert_near(*one, two, 5e-3 * (bar[0] + bar[1]));
    }
}

#[test]
fn free_fall_is_that_of_the_integrator() {
    // Sheet: snow-mpm V4.
    for options in transfers() {
        let mut value = block(&json!({ "kind": "uniform", "value": [0.5, 1] }), &options);
        value["gravity"] = json!([0, -9.81]);
        value["methods"]["snow-mpm"]["time_step"] = json!(2e-4);
        let mut solver = start_solver(&SnowMpm, &read_case(&value));
        let start = solver.snapshot();
        for _ in 0..100 {
            solver.step(2e-4).unwrap();
        }
        let (end, t) = (solver.snapshot(), solver.time());
        let fall = t - 0.5 * 9.81 * t * (t + 2e-4);
        for (a, b) in start.positions.iter().zip(&end.positions) {
            assert_near(b[0] - a[0], 0.5 * t, 1e-12);
            assert_near(b[1] - a[1], fall, 1e-12);
        }
    }
}

#[test]
fn apic_keeps_an_affine_motion_and_both_momenta() {
    // Sheet: snow-mpm V4 and V11; matter without stiffness first.
    let field = json!({ "kind": "linear", "value": [0.2, 0.1], "origin": [1, 1], "gradient": [[0.3, -2.0], [1.0, -0.4]] });
    let mut value = block(&field, &json!({}));
    value["materials"]["m"]["youngs_modulus"] = json!(1e-9);
    let mut solver = start_solver(&SnowMpm, &read_case(&value));
    let start = solver.snapshot();
    solver.step(1e-3).unwrap();
    let end = solver.snapshot();
    for (x, v) in start.positions.iter().zip(vectors(&end, "velocity")) {
        assert_near(v[0], 0.2 + 0.3 * (x[0] - 1.0) - 2.0 * (x[1] - 1.0), 1e-12);
        assert_near(v[1], 0.1 + 1.0 * (x[0] - 1.0) - 0.4 * (x[1] - 1.0), 1e-12);
    }
    let spin =
        json!({ "kind": "linear", "value": [0.2, 0.1], "origin": [1, 1], "gradient": [[0, -10], [10, 0]] });
    for shape in ["cubic", "quadratic"] {
        let mut solver = start_solver(
            &SnowMpm,
            &read_case(&block(&spin, &json!({ "shape": shape, "courant_elastic": 0.3 }))),
        );
        let start = solver.totals();
        advance_steps(&mut *solver, 300);
        let end = solver.totals();
        for c in 0..2 {
            assert_near(end.momentum[c] / start.momentum[c], 1.0, 1e-11);
        }
        assert_near(end.angular_momentum[2] / start.angular_momentum[2], 1.0, 1e-11);
        let lost = 1.0 - (end.kinetic + end.elastic) / start.kinetic;
        assert!((0.0..1e-3).contains(&lost), "{shape}: {lost}");
    }
}

#[test]
fn filtered_energy_is_zero_for_affine_motion_with_apic_and_positive_with_pic() {
    let affine = json!({ "kind": "linear", "value": [0.2, 0.1], "origin": [1, 1], "gradient": [[0.3, -2.0], [1.0, -0.4]] });
    let spin =
        json!({ "kind": "linear", "value": [0.2, 0.1], "origin": [1, 1], "gradient": [[0, -10], [10, 0]] });
    for (transfer, field, steps) in [("apic", &affine, 1), ("flip", &spin, 20)] {
        let mut value = block(field, &json!({ "transfer": transfer, "flip_ratio": 0.0 }));
        value["materials"]["m"]["youngs_modulus"] = json!(1e-9);
        let mut solver = start_solver(&SnowMpm, &read_case(&value));
        let start = solver.totals();
        for _ in 0..steps {
            solver.step(1e-4).unwrap();
        }
        let filtered = scalar_output(&*solver, "energy_filtered");
        // Without stiffness the points' energy changes on its way to the nodes and back only.
        assert_near(filtered, start.kinetic - solver.totals().kinetic, 1e-9 * start.kinetic);
        assert_near(scalar_output(&*solver, "energy_numerical"), filtered, 1e-9 * start.kinetic);
        match transfer {
            "apic" => assert_near(filtered, 0.0, 1e-9 * start.kinetic),
            _ => assert!(filtered > 0.01 * start.kinetic, "{filtered} of {}", start.kinetic),
        }
    }
}

#[test]
fn the_energy_balance_closes_with_the_numerical_dissipation() {
    let mut solver = start_solver(&SnowMpm, &read_case(&ball(&json!({}))));
    let start = solver.totals();
    advance_to(&mut *solver, 0.03);
    let end = solver.totals();
    let plastic = scalar_output(&*solver, "energy_plastic");
    let walls = scalar_output(&*solver, "work_of_walls");
    let gravity = scalar_output(&*solver, "work_of_gravity");
    let numerical = scalar_output(&*solver, "energy_numerical");
    assert_near(gravity, start.potential - end.potential, 1e-9 * start.kinetic);
    assert_near(
        start.kinetic + gravity + walls,
        end.kinetic + end.elastic + plastic + numerical,
        1e-9 * start.kinetic,
    );
    assert!(plastic > 0.0 && walls < 0.0, "{plastic} {walls}");
    assert!((0.0..0.2 * start.kinetic).contains(&numerical), "{numerical} of {}", start.kinetic);
    assert!(scalar_output(&*solver, "energy_filtered") > 0.0);
}

#[test]
fn a_ball_comes_to_rest_on_the_floor_and_none_of_it_passes() {
    let mut solver = start_solver(&SnowMpm, &read_case(&ball(&json!({}))));
    advance_to(&mut *solver, 0.15);
    let end = solver.snapshot();
    let lowest = end.positions.iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
    assert!((-0.04..0.06).contains(&lowest), "{lowest}");
    let mean = end.positions.iter().map(|x| x[0]).sum::<f64>() / end.positions.len() as f64;
    assert_near(mean, 0.0, 1e-9);
    assert!(solver.totals().momentum[1] > -0.3 * 5.0 * solver.totals().mass, "the floor has stopped it");
}

#[test]
fn a_block_slides_down_an_incline_by_coulombs_law() {
    // Sheet: snow-mpm V15: gravity is turned by 30 degrees; the block settles while it is held, and with more friction it
    // stays.
    let slide = |friction: f64| {
        let (sine, cosine) = (0.5, 0.75f64.sqrt());
        let value = json!({
            "title": "incline", "space": "plane-strain", "domain": { "min": [0, 0], "max": [3, 1] },
            "gravity": [9.81 * sine, -9.81 * cosine],
            "materials": { "m": { "model": "linear-elastic", "strain_measure": "hencky", "density": 400,
                "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
            "bodies": [{ "name": "block", "material": "m",
                "shape": { "kind": "box", "min": [0.5, 0], "max": [1.5, 0.5] } }],
            "boundaries": [
                { "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": friction } },
                { "name": "glue", "side": "y-min", "position": 1e-3, "wall": { "kind": "rough" } }
            ],
            "stages": [
                { "name": "settle", "duration": 0.5, "gravity_ramp": 0.3, "damping": 0.5,
                  "reset": ["displacement", "velocity"] },
                { "name": "go", "duration": 0.5, "remove_boundaries": ["glue"] }
            ],
            "methods": { "snow-mpm": { "cell_size": 0.1 } }
        });
        let report = solve(&SnowMpm, &read_case(&value));
        let moved = vectors(&report.snapshot, "displacement");
        let mean = moved.iter().map(|u| u[0]).sum::<f64>() / moved.len() as f64;
        (mean, 0.5 * 9.81 * (sine - friction * cosine) * 0.25)
    };
    let (moved, exact) = slide(0.3);
    assert_near(moved / exact, 1.0, 0.01);
    let (moved, _) = slide(0.7);
    assert_near(moved, 0.0, 1e-3);
}
