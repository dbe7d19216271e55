//! Smoothing of stress and density against closed forms and symmetries (sheet: sph §2.10, §2.13).

use std::f64::consts::PI;

use colluvium_case::{Case, Method, Snapshot};
use colluvium_sph::Sph;
use colluvium_testkit::{advance_steps, case_with, scalars, solve, start_solver, stresses, vectors};
use serde_json::{Value, json};

/// Elastic block; `more` replaces or adds keys, `sph` options.
fn elastic_square(more: &Value, sph: &Value) -> Case {
    let mut methods = json!({ "spacing": 0.05, "viscosity_linear": 0 });
    for (key, value) in sph.as_object().unwrap() {
        methods[key] = value.clone();
    }
    let mut text = json!({
        "title": "test", "space": "plane-strain", "domain": { "min": [-1, -1], "max": [2, 2] }, "gravity": [0, 0],
        "materials": { "m": elastic() },
        "bodies": [body("b", "m", [0.0, 0.0], &json!({}))],
        "stages": [{ "name": "s", "duration": 0.01 }]
    });
    text["methods"] = json!({ "sph": methods });
    case_with(text, more)
}

fn elastic() -> Value {
    json!({ "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 })
}

/// Square of 0.4 m with its lower corner at `low` (m).
fn body(name: &str, material: &str, low: [f64; 2], more: &Value) -> Value {
    let shape = json!({ "kind": "box", "min": low, "max": low.map(|c| c + 0.4) });
    let mut body = json!({ "name": name, "material": material, "shape": shape });
    for (key, value) in more.as_object().unwrap() {
        body[key] = value.clone();
    }
    body
}

/// Velocity field with the gradient `gradient` (1/s) about the middle of a body at the origin.
fn linear(gradient: [[f64; 2]; 2]) -> Value {
    json!({ "velocity": { "kind": "linear", "value": [0, 0], "origin": [0.2, 0.2], "gradient": gradient } })
}

#[test]
fn regularisation_continues_after_a_velocity_reset() {
    let soil = json!({ "model": "drucker-prager", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.3,
                       "friction_angle": 20, "cohesion": 1000 });
    let more = json!({
        "domain": { "min": [-1, 0], "max": [2, 2] }, "gravity": [0, -10], "materials": { "m": soil },
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "settle", "duration": 0.02, "damping": 0.5, "reset": ["velocity"] },
                   { "name": "go", "duration": 0.02 }]
    });
    let report =
        solve(&Sph, &elastic_square(&more, &json!({ "regularisation": "mls", "regularisation_steps": 1 })));
    assert!((report.snapshot.time - 0.04).abs() < 1e-9);
}

#[test]
fn laws_that_are_not_in_rate_form_are_not_smoothed() {
    for law in [
        json!({ "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e5, "viscosity": 150,
                "cavitation_strength": 1e9 }),
        json!({ "model": "neo-hookean", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 }),
    ] {
        let more = json!({
            "materials": { "m": elastic(), "other": law },
            "bodies": [body("b", "other", [0.0, 0.0], &linear([[2.0, 3.0], [0.0, -1.0]])), body("rest", "m", [1.0, 0.0], &json!({}))]
        });
        let hash = |sph: Value| solve(&Sph, &elastic_square(&more, &sph)).snapshot.hash();
        assert_eq!(
            hash(json!({})),
            hash(json!({ "regularisation": "mls", "regularisation_steps": 1 })),
            "{law}"
        );
    }
}

#[test]
fn stress_smoothing_requires_a_law_in_rate_form() {
    for law in [
        json!({ "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e5, "viscosity": 150 }),
        json!({ "model": "neo-hookean", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 }),
        json!({ "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25, "strain_measure": "hencky" }),
    ] {
        for (name, value) in [("regularisation", json!("mls")), ("stress_diffusion", json!(0.1))] {
            let alone = json!({ "materials": { "m": law } });
            let error = Sph.plan(&elastic_square(&alone, &json!({ name: value }))).unwrap_err().to_string();
            assert!(error.starts_with(&format!("methods.sph.{name}: is for laws in rate form")), "{error}");
            let bodies = [body("b", "m", [0.0, 0.0], &json!({})), body("c", "e", [1.0, 0.0], &json!({}))];
            let beside = json!({ "materials": { "m": law, "e": elastic() }, "bodies": bodies });
            assert!(Sph.plan(&elastic_square(&beside, &json!({ name: value }))).is_ok());
        }
    }
}

/// Stresses of a held body after `duration` (s), with smoothing in every step.
fn smoothed_while_held(law: &Value, motion: &Value, duration: f64) -> Vec<[f64; 6]> {
    let more = json!({
        "materials": { "m": elastic(), "held": law },
        "bodies": [body("b", "held", [0.0, 0.0], motion), body("rest", "m", [1.0, 0.0], &json!({}))],
        "stages": [{ "name": "s", "duration": duration }]
    });
    let sph = json!({ "regularisation": "mls", "regularisation_steps": 1, "held": ["b"],
                      "velocity_gradient": "corrected", "continuity": "volume" });
    let snapshot = solve(&Sph, &elastic_square(&more, &sph)).snapshot;
    let all = snapshot.bodies.iter().zip(stresses(&snapshot));
    all.filter(|(body, _)| **body == 0).map(|(_, stress)| stress).collect()
}

/// Swelling of 1 % in 1 s that is prevented.
#[test]
fn stress_smoothing_does_not_advance_time_dependent_laws() {
    let law =
        json!({ "model": "eigenstrain", "volumetric_strain": 0.01, "duration": 1, "material": elastic() });
    let bulk_modulus = 1e6 / (3.0 * (1.0 - 2.0 * 0.25));
    let exact = -bulk_modulus * 0.01 * 0.05;
    for stress in smoothed_while_held(&law, &json!({}), 0.05) {
        assert!((0..3).all(|c| (stress[c] / exact - 1.0).abs() < 1e-9), "{stress:?} {exact}");
    }
}

/// Flow at 5 1/s for many relaxation times μ/G.
#[test]
fn stress_smoothing_does_not_relax_viscous_stress() {
    let law = json!({ "model": "bingham", "density": 1000, "bulk_modulus": 1e6, "shear_modulus": 1e5, "yield_stress": 200,
                      "viscosity": 100, "cavitation_strength": 1e9 });
    for stress in smoothed_while_held(&law, &linear([[0.0, 5.0], [0.0, 0.0]]), 0.02) {
        assert!((stress[3] / (200.0 + 100.0 * 5.0) - 1.0).abs() < 1e-3, "{stress:?}");
    }
}

/// The energy that an evenly stretched body loses by the hourglass viscosity is that of the waves from its surfaces; smoothed
/// stress does not increase it.
#[test]
fn smoothing_keeps_the_gradients_for_the_hourglass_viscosity() {
    let motion = linear([[5.0, 0.0], [0.0, -5.0]]);
    let stretch = json!({ "bodies": [body("b", "m", [0.0, 0.0], &motion)] });
    let energy = |hourglass: f64, regularisation: &str| {
        let sph = json!({ "momentum": "corrected", "hourglass_viscosity": hourglass, "continuity": "volume",
                          "regularisation": regularisation, "regularisation_steps": 1 });
        let mut solver = start_solver(&Sph, &elastic_square(&stretch, &sph));
        advance_steps(&mut *solver, 5);
        let end = solver.totals();
        end.kinetic + end.elastic
    };
    let lost = |regularisation: &str| 1.0 - energy(1.0, regularisation) / energy(0.0, regularisation);
    let (plain, smoothed) = (lost("none"), lost("mls"));
    assert!(plain < 0.01 && smoothed < 2.0 * plain, "{plain} {smoothed}");
}

/// Plane wave along a periodic square of 1 m, polarised along `amplitude`, after some steps.
fn wave(material: &Value, amplitude: [f64; 2], sph: &Value) -> Snapshot {
    let shape = json!({ "kind": "box", "min": [0, 0], "max": [1, 1] });
    let velocity = json!({ "kind": "sine", "amplitude": amplitude, "wave_vector": [2.0 * PI, 0] });
    let more = json!({
        "domain": { "min": [0, 0], "max": [1, 1], "periodic": ["x", "y"] }, "materials": { "m": material },
        "bodies": [{ "name": "b", "material": "m", "shape": shape, "velocity": velocity }]
    });
    let mut solver = start_solver(&Sph, &elastic_square(&more, sph));
    advance_steps(&mut *solver, 20);
    solver.snapshot()
}

/// Largest sum of a field at two positions half a wave apart, over the largest value.
fn asymmetry(snapshot: &Snapshot, values: &[f64]) -> f64 {
    let places = &snapshot.positions;
    let partner = |x: &[f64; 3]| {
        let apart = |y: &[f64; 3]| {
            let along = (y[0] - x[0]).abs() - 0.5;
            along.hypot(y[1] - x[1])
        };
        (0..places.len()).min_by(|a, b| apart(&places[*a]).total_cmp(&apart(&places[*b]))).unwrap()
    };
    let sums = places.iter().zip(values).map(|(x, value)| (value + values[partner(x)]).abs());
    sums.fold(0.0, f64::max) / values.iter().fold(0.0, |largest, value| value.abs().max(largest))
}

/// After smoothing, density reset or shifting, the solver kicks with the accelerations of the new state.
#[test]
fn velocity_verlet_uses_accelerations_of_the_smoothed_state() {
    let water = json!({ "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e6, "viscosity": 0.1,
                        "cavitation_strength": 1e9 });
    let motion = json!({ "velocity": { "kind": "sine", "amplitude": [1, -1], "wave_vector": [11, 17] } });
    for (material, sph) in [
        (elastic(), json!({ "regularisation": "mls" })),
        (water, json!({ "density_reset": "shepard", "density_reset_steps": 10 })),
        (elastic(), json!({ "shifting": 5 })),
    ] {
        let more = json!({ "materials": { "m": material }, "bodies": [body("b", "m", [0.0, 0.0], &motion)] });
        let mut options = sph.clone();
        options["integration"] = json!("velocity-verlet");
        let case = elastic_square(&more, &options);
        let mut whole = start_solver(&Sph, &case);
        advance_steps(&mut *whole, 10);
        // A stage that begins here recomputes the accelerations.
        let mut anew = start_solver(&Sph, &case);
        anew.restore(&mut whole.checkpoint_bytes().unwrap().as_slice()).unwrap();
        anew.begin_stage(0, whole.time()).unwrap();
        let dt = whole.limit().dt.min(anew.limit().dt);
        let velocities = [&mut whole, &mut anew].map(|solver| {
            solver.step(dt).unwrap();
            vectors(&solver.snapshot(), "velocity")
        });
        for (v, exact) in velocities[0].iter().zip(&velocities[1]) {
            assert!((0..2).all(|c| (v[c] - exact[c]).abs() < 1e-12), "{sph}: {v:?} {exact:?}");
        }
    }
}

#[test]
fn stress_smoothing_is_symmetric_across_periodic_boundaries() {
    for regularisation in ["shepard", "mls"] {
        let sph = json!({ "regularisation": regularisation, "regularisation_steps": 1 });
        let snapshot = wave(&elastic(), [0.0, 1e-5], &sph);
        let shear: Vec<f64> = stresses(&snapshot).iter().map(|stress| stress[3]).collect();
        let found = asymmetry(&snapshot, &shear);
        assert!(found < 1e-4, "{regularisation}: {found}");
    }
}

#[test]
fn density_reset_is_symmetric_across_periodic_boundaries() {
    let water = json!({ "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e6, "viscosity": 0.1,
                        "cavitation_strength": 1e9 });
    for form in ["shepard", "mls"] {
        let snapshot = wave(&water, [1e-5, 0.0], &json!({ "density_reset": form, "density_reset_steps": 1 }));
        let excess: Vec<f64> = scalars(&snapshot, "density").iter().map(|density| density - 1000.0).collect();
        let found = asymmetry(&snapshot, &excess);
        assert!(found < 1e-3, "{form}: {found}");
    }
}

/// A periodic layer that falls and is thrown along its floor: the result does not depend on the position along the period.
#[test]
fn interpolated_wall_stress_does_not_depend_on_the_periodic_boundary() {
    for wall_stress in ["interpolated", "extrapolated"] {
        let shape = json!({ "kind": "box", "min": [0, 0], "max": [1, 0.5] });
        let velocity = json!({ "kind": "uniform", "value": [0.3, -0.1] });
        let more = json!({
            "domain": { "min": [0, 0], "max": [1, 1], "periodic": ["x"] }, "gravity": [0, -10],
            "bodies": [{ "name": "b", "material": "m", "shape": shape, "velocity": velocity }],
            "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }]
        });
        let mut solver = start_solver(&Sph, &elastic_square(&more, &json!({ "wall_stress": wall_stress })));
        advance_steps(&mut *solver, 40);
        let snapshot = solver.snapshot();
        let all: Vec<_> = snapshot.positions.iter().zip(vectors(&snapshot, "velocity")).collect();
        for (x, v) in &all {
            let of_row = all.iter().filter(|(y, _)| (y[1] - x[1]).abs() < 0.01);
            for (_, other) in of_row {
                assert!(
                    (0..2).all(|c| (v[c] - other[c]).abs() < 1e-9),
                    "{wall_stress}: {x:?} {v:?} {other:?}"
                );
            }
        }
    }
}
