//! Rigid bodies that move by Newton's law (sheet: sph §2.14).

use colluvium_case::{Case, Method};
use colluvium_sph::Sph;
use serde_json::{Value, json};

use crate::common::{begin, changed, solve, vectors};

/// A rigid block of 0.2 m × 0.1 m and 10 kg, in empty space.
fn case(more: &Value) -> Case {
    changed(
        json!({
            "title": "test", "space": "plane-strain", "domain": { "min": [-1, -1], "max": [2, 2] }, "gravity": [0, 0],
            "materials": {
                "wood": { "model": "newtonian-fluid", "density": 500, "bulk_modulus": 2e5, "viscosity": 0 },
                "water": { "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 4e5, "viscosity": 0 },
                "soft": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.2 }
            },
            "bodies": [block([0.4, 0.4])],
            "stages": [{ "name": "s", "duration": 0.1, "motions": [{ "of": "block", "velocity": [null, null], "turns": true }] }],
            "methods": { "sph": { "spacing": 0.02 } }
        }),
        more,
    )
}

fn block([x, y]: [f64; 2]) -> Value {
    json!({ "name": "block", "material": "wood", "rigid": true,
            "shape": { "kind": "box", "min": [x, y], "max": [x + 0.2, y + 0.1] } })
}

#[test]
fn a_free_block_falls_and_spins_as_one() {
    let mut spinning = block([0.4, 0.4]);
    spinning["velocity"] = json!({ "kind": "linear", "value": [0.5, 0.3], "origin": [0.5, 0.45], "gradient": [[0, -8], [8, 0]] });
    let report = solve(&case(&json!({
        "gravity": [1, -3], "bodies": [spinning],
        "stages": [{ "name": "s", "duration": 0.1,
                     "motions": [{ "of": "block", "velocity": [null, null], "force": [10, 0], "turns": true }] }]
    })));
    let velocities = vectors(&report.snapshot, "velocity");
    let n = velocities.len() as f64;
    let mean: [f64; 2] = std::array::from_fn(|c| velocities.iter().map(|v| v[c]).sum::<f64>() / n);
    // 10 N on 10 kg beside gravity.
    assert!((mean[0] - 0.7).abs() < 1e-9 && mean[1].abs() < 1e-9, "{mean:?}");
    let x = &report.snapshot.positions;
    let middle: [f64; 2] = std::array::from_fn(|c| x.iter().map(|x| x[c]).sum::<f64>() / n);
    let moved = vectors(&report.snapshot, "displacement");
    for ((x, v), u) in x.iter().zip(&velocities).zip(&moved) {
        let arm = [x[0] - middle[0], x[1] - middle[1]];
        let before = (x[0] - u[0] - 0.5).hypot(x[1] - u[1] - 0.45);
        assert!((arm[0].hypot(arm[1]) - before).abs() < 1e-12);
        assert!(
            (v[0] - mean[0] + 8.0 * arm[1]).abs() < 1e-6 && (v[1] - mean[1] - 8.0 * arm[0]).abs() < 1e-6,
            "{v:?}"
        );
    }
}

#[test]
fn a_collision_of_a_rigid_block_keeps_momentum() {
    let mut flying = block([0.4, 0.43]);
    flying["velocity"] = json!({ "kind": "uniform", "value": [0.2, -2] });
    let report = solve(&case(&json!({
        "bodies": [flying, { "name": "bed", "material": "soft", "shape": { "kind": "box", "min": [0.46, 0.2], "max": [0.76, 0.4] } }]
    })));
    let (before, after) = (report.start.momentum, report.end.momentum);
    for c in 0..2 {
        assert!((after[c] - before[c]).abs() < 1e-9 * 20.0, "{before:?} {after:?}");
    }
    // They have met.
    assert!(
        report.end.kinetic < 0.95 * report.start.kinetic,
        "{} {}",
        report.end.kinetic,
        report.start.kinetic
    );
}

#[test]
fn a_block_of_half_the_density_of_water_floats_with_half_of_it_under_water() {
    // A tank 0.8 m wide, filled 0.3 m deep around a block that dips in 0.08 m of its height of 0.1 m and comes up.
    let part = |name: &str, min: [f64; 2], max: [f64; 2]| json!({ "name": name, "material": "water", "shape": { "kind": "box", "min": min, "max": max } });
    let report = solve(&case(&json!({
        "gravity": [0, -9.81], "domain": { "min": [0, 0], "max": [0.8, 1] },
        "bodies": [part("left", [0.0, 0.0], [0.3, 0.3]), part("below", [0.3, 0.0], [0.5, 0.22]),
                   part("right", [0.5, 0.0], [0.8, 0.3]), block([0.3, 0.22])],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "x-min", "wall": { "kind": "smooth" } },
                       { "side": "x-max", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "s", "duration": 3, "gravity_ramp": 0.5, "damping": 0.05,
                     "motions": [{ "of": "block", "velocity": [0, null] }] }]
    })));
    let of_block =
        report.snapshot.positions.iter().zip(&report.snapshot.bodies).filter(|(_, body)| **body == 3);
    let heights: Vec<f64> = of_block.map(|(x, _)| x[1]).collect();
    let middle = heights.iter().sum::<f64>() / heights.len() as f64;
    // Water of 0.224 m² and half of the block fill 0.8 m.
    let level = (0.8 * 0.3 - 0.2 * 0.08 + 0.5 * 0.2 * 0.1) / 0.8;
    // A particle sees the surface as the middle between two rows: half a spacing.
    assert!((middle - level).abs() < 0.01, "{middle} {level}");
}

/// What it bears is all that changes its momentum beside weight and force, whether it follows forces or its velocity is prescribed.
#[test]
fn a_rigid_body_tells_the_force_on_it() {
    let mut flying = block([0.4, 0.43]);
    flying["velocity"] = json!({ "kind": "uniform", "value": [0.2, -2] });
    let bed = json!({ "name": "bed", "material": "soft", "shape": { "kind": "box", "min": [0.46, 0.2], "max": [0.76, 0.4] } });
    for motion in [json!([null, null]), json!([0.2, -2])] {
        let free = motion[0].is_null();
        let case = case(&json!({
            "gravity": [0, -5], "bodies": [flying.clone(), bed.clone()], "output": { "measures": 0.01 },
            "measures": { "push": { "kind": "reaction", "of": "block" } },
            "stages": [{ "name": "s", "duration": 0.05, "motions": [{ "of": "block", "velocity": motion, "force": if free { json!([3, 0]) } else { json!([0, 0]) }, "turns": true }] }]
        }));
        let report = solve(&case);
        let impulse =
            |axis: &str| *report.table.column(&format!("push.impulse.{axis}")).unwrap().last().unwrap();
        let mass = &report.snapshot;
        let momentum = |body: u32| -> [f64; 2] {
            let masses = colluvium_testkit::cases::scalars(mass, "mass");
            let all = vectors(mass, "velocity").into_iter().zip(masses).zip(&mass.bodies);
            all.filter(|(_, of)| **of == body)
                .fold([0.0; 2], |sum, ((v, m), _)| [sum[0] + m * v[0], sum[1] + m * v[1]])
        };
        // Of the block, 10 kg, and of the bed, 60 kg: velocities stand half a step behind forces.
        let (block, bed) = (momentum(0), momentum(1));
        assert!(impulse("y") > 1.0, "{}", impulse("y"));
        for (c, axis) in ["x", "y"].into_iter().enumerate() {
            let taken = [0.0, 60.0 * -5.0 * 0.05][c] - bed[c];
            assert!((impulse(axis) - taken).abs() < 0.01 * impulse("y"), "{axis}: {} {taken}", impulse(axis));
            if free {
                let gained = block[c] - [2.0 + 3.0 * 0.05, -20.0 - 10.0 * 5.0 * 0.05][c];
                assert!(
                    (impulse(axis) - gained).abs() < 0.01 * impulse("y"),
                    "{axis}: {} {gained}",
                    impulse(axis)
                );
            }
        }
    }
}

#[test]
fn what_rigid_bodies_do_not_go_with_is_refused_by_name() {
    let refused =
        |more: Value| Sph.plan(&case(&more)).map_or_else(|error| error.to_string(), |_| String::new());
    let euler = json!({ "methods": { "sph": { "spacing": 0.02, "integration": "predictor-corrector" } } });
    assert!(refused(euler).contains("leapfrog"));
    let periodic = json!({ "domain": { "min": [-1, -1], "max": [2, 2], "periodic": ["x"] } });
    assert!(refused(periodic).contains("rigid"));
    let mut solver = begin(&case(&json!({})));
    solver.step(1e-4).unwrap();
}
