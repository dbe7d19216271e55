//! Walls whose velocities vary in time, and rough mirrors (SPH sheet §2.13).

use colluvium_case::Method;
use colluvium_sph::Sph;
use serde_json::{Value, json};

use crate::common::{begin, changed, solve, stresses, vectors};

/// Up, on, and back beyond rest.
const TIMES: [f64; 4] = [0.005, 0.02, 0.03, 0.05];
const FACTORS: [f64; 4] = [0.0, 1.0, 1.0, -0.5];

/// The factor, and the area under it.
fn factor(time: f64) -> (f64, f64) {
    let (mut area, mut last) = (0.0, (0.0, 0.0));
    for corner in TIMES.into_iter().zip(FACTORS).chain([(f64::INFINITY, -0.5)]) {
        if time < corner.0 {
            let slope = if corner.0.is_finite() { (corner.1 - last.1) / (corner.0 - last.0) } else { 0.0 };
            let value = last.1 + slope * (time - last.0);
            return (value, area + 0.5 * (time - last.0) * (last.1 + value));
        }
        area += 0.5 * (corner.0 - last.0) * (last.1 + corner.1);
        last = corner;
    }
    (last.1, area)
}

/// A bar of length 1 m and wave speed 10 m/s before a piston of 2 mm/s.
fn bar(spacing: f64, sph: &Value) -> colluvium_case::Case {
    let mut methods = json!({
        "spacing": spacing, "viscosity_linear": 0, "hourglass_viscosity": 0.1, "momentum": "corrected",
        "wall_history": { "piston": { "times": TIMES, "factors": FACTORS } }
    });
    for (key, value) in sph.as_object().unwrap() {
        methods[key] = value.clone();
    }
    let text = json!({
        "title": "piston", "space": "1d", "domain": { "min": [0], "max": [1.1] }, "gravity": [0],
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e5, "poissons_ratio": 0 } },
        "bodies": [{ "name": "bar", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] } }],
        "boundaries": [{ "name": "piston", "side": "x-min", "wall": { "kind": "smooth" }, "velocity": [0.002] }],
        "stages": [{ "name": "s", "duration": 1 }],
        "methods": { "sph": methods }
    });
    changed(text, &json!({}))
}

/// d'Alembert: `v(x, t) = v_p(t - x/c)`, `σ = -ρ c v`, `u` the integral of `v`.
#[test]
fn a_piston_of_varying_velocity_sends_the_wave_of_dalembert_into_a_bar() {
    let largest_errors = |spacing: f64, sph: &Value| {
        let mut solver = begin(&bar(spacing, sph));
        let (end, dt) = (0.08, 0.1 * spacing / 10.0);
        for _ in 0..(end / dt).round() as usize {
            solver.step(dt).unwrap();
        }
        let snapshot = solver.snapshot();
        let (v, u, s) =
            (vectors(&snapshot, "velocity"), vectors(&snapshot, "displacement"), stresses(&snapshot));
        let mut errors = [0.0f64; 3];
        for i in 0..u.len() {
            let (value, area) = factor(snapshot.time - (snapshot.positions[i][0] - u[i][0]) / 10.0);
            let own =
                [v[i][0] / 0.002 - value, u[i][0] / (0.002 * 0.015) - area / 0.015, -s[i][0] / 20.0 - value];
            (0..3).for_each(|k| errors[k] = errors[k].max(own[k].abs()));
        }
        errors
    };
    for sph in [json!({}), json!({ "smooth_wall": "particles" }), json!({ "integration": "velocity-verlet" })]
    {
        let (coarse, fine) = (largest_errors(0.01, &sph), largest_errors(0.0025, &sph));
        // Corners of the wave are round over a smoothing length: its largest error falls as the spacing does, or faster
        // where it is integrated.
        for k in [0, 2] {
            assert!(fine[k] < 0.4 * coarse[k] && fine[k] < 0.03, "{sph}: {coarse:?} {fine:?}");
        }
        assert!(fine[1] < 0.25 * coarse[1] && fine[1] < 0.003, "{sph}: {coarse:?} {fine:?}");
    }
}

#[test]
fn histories_are_of_walls_that_move_and_functions_of_time() {
    let history = |times: [f64; 2]| json!({ "times": times, "factors": [1, 0] });
    let mut case = bar(0.01, &json!({}));
    for (name, times, path) in [
        ("nobody", [0.0, 1.0], "methods.sph.wall_history.nobody"),
        ("piston", [1.0, 1.0], "methods.sph.wall_history.piston.times[1]"),
        ("x-max", [0.0, 1.0], "methods.sph.wall_history.x-max"),
    ] {
        let at_rest = json!({ "side": "x-max", "wall": { "kind": "smooth" } });
        if case.boundaries.len() == 1 {
            case.boundaries.push(serde_json::from_value(at_rest).unwrap());
        }
        case.methods.get_mut("sph").unwrap()["wall_history"] = json!({ name: history(times) });
        let error = Sph.plan(&case).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{path}: ")), "{error}");
    }
}

/// Sheet, set S, at a spacing of 1 cm. What is close to a mirror hardly sees its own image, and nothing keeps its
/// velocity to that of the field: cohesionless material sinks onto the face, and there nothing holds it.
#[test]
fn a_collapsing_column_on_a_rough_mirror_needs_the_hourglass_viscosity() {
    let front = |sph: &Value| {
        let mut methods = json!({ "spacing": 0.01 });
        for (key, value) in sph.as_object().unwrap() {
            methods[key] = value.clone();
        }
        let text = json!({
            "title": "column", "space": "plane-strain", "domain": { "min": [0, 0], "max": [0.8, 0.15] }, "gravity": [0, -9.81],
            "materials": { "bars": { "model": "drucker-prager", "density": 2040, "youngs_modulus": 5.84e6, "poissons_ratio": 0.3,
                                     "friction_angle": 21.9, "matching": "plane-strain-associated" } },
            "bodies": [{ "name": "column", "material": "bars", "shape": { "kind": "box", "min": [0, 0], "max": [0.2, 0.1] } }],
            "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }, { "side": "y-min", "wall": { "kind": "rough" } }],
            "stages": [{ "name": "s", "duration": 0.4 }],
            "methods": { "sph": methods }
        });
        let snapshot = solve(&changed(text, &json!({}))).snapshot;
        snapshot.positions.iter().map(|x| x[0]).fold(0.0, f64::max)
    };
    let (layers, mirror) =
        (front(&json!({})), front(&json!({ "rough_wall": "mirror", "hourglass_viscosity": 0.1 })));
    assert!((mirror / layers - 1.0).abs() < 0.05, "{mirror} m, {layers} m");
    let slipping = front(&json!({ "rough_wall": "mirror" }));
    assert!(slipping > 1.15 * layers, "{slipping} m, {layers} m");
}
