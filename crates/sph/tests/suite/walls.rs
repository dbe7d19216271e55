//! Walls with time-dependent velocities, and rough mirrors (sheet: sph §2.13).

use colluvium_case::{Case, Method, SolverError};
use colluvium_sph::Sph;
use colluvium_testkit::{read_case, solve, start_solver, stresses, vectors};
use serde_json::{Value, json};

/// Times of a factor that rises, is constant, and falls below zero.
const TIMES: [f64; 4] = [0.005, 0.02, 0.03, 0.05];
const FACTORS: [f64; 4] = [0.0, 1.0, 1.0, -0.5];

/// Factor, and its integral.
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

/// Bar of length 1 m and wave speed 10 m/s in front of a piston of 2 mm/s.
fn bar(spacing: f64, sph: &Value) -> Case {
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
    read_case(&text)
}

/// Solution of d'Alembert: `v(x, t) = v_p(t - x/c)`, `σ = -ρ c v`, `u` the integral of `v`.
#[test]
fn a_piston_of_varying_velocity_sends_the_wave_of_dalembert_into_a_bar() {
    let largest_errors = |spacing: f64, sph: &Value| {
        let mut solver = start_solver(&Sph, &bar(spacing, sph));
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
        // Corners of the wave are rounded over a smoothing length: its largest error decreases as the spacing does, or faster
        // where it is integrated.
        for k in [0, 2] {
            assert!(fine[k] < 0.4 * coarse[k] && fine[k] < 0.03, "{sph}: {coarse:?} {fine:?}");
        }
        assert!(fine[1] < 0.25 * coarse[1] && fine[1] < 0.003, "{sph}: {coarse:?} {fine:?}");
    }
}

#[test]
fn histories_require_moving_walls_and_valid_functions_of_time() {
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

#[test]
fn walls_of_particles_are_counted_before_they_are_made() {
    let rough = json!([{ "side": "y-min", "wall": { "kind": "rough" } }]);
    let mut case = chip(&json!({ "kind": "rough" }), 0.0, &json!({}));
    case.boundaries = serde_json::from_value(rough).unwrap();
    let size = Sph.problem_size(&case).unwrap();
    let mut without = case.clone();
    without.boundaries.clear();
    assert!(size.points > Sph.problem_size(&without).unwrap().points);
    // Ten kilometres of wall and one particle.
    case.domain.max[0] = 1e4;
    let error = Sph.problem_size(&case).unwrap().check_memory(1e7).unwrap_err().to_string();
    assert!(error.starts_with("domain: ") && error.contains("wall particles"), "{error}");
}

/// Column of `sheet: sph §5.4 set S` at a spacing of 1 cm. A particle close to a mirror hardly interacts with its own image, and its
/// velocity is not coupled to the field: cohesionless material sinks onto the face, without resistance there.
#[test]
fn a_collapsing_column_on_a_rough_mirror_needs_the_hourglass_viscosity() {
    let front = |sph: &Value| {
        let mut methods = json!({ "spacing": 0.01, "velocity_gradient": "compatible" });
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
        let snapshot = solve(&Sph, &read_case(&text)).snapshot;
        snapshot.positions.iter().map(|x| x[0]).fold(0.0, f64::max)
    };
    let (layers, mirror) =
        (front(&json!({})), front(&json!({ "rough_wall": "mirror", "hourglass_viscosity": 0.1 })));
    assert!((mirror / layers - 1.0).abs() < 0.05, "{mirror} m, {layers} m");
    let slipping = front(&json!({ "rough_wall": "mirror" }));
    assert!(slipping > 1.15 * layers, "{slipping} m, {layers} m");
}

/// End of a run: the particle's position, the time and the reason.
fn end_of(case: &Case) -> ([f64; 3], f64, String) {
    let mut solver = start_solver(&Sph, case);
    loop {
        let dt = solver.limit().dt;
        match solver.step(dt) {
            Ok(_) => {}
            Err(SolverError::Point { position, time, reason, .. }) => {
                return (position, time + dt, reason.to_string());
            }
            Err(error) => panic!("{error}"),
        }
    }
}

/// Chip, too soft to be repelled, that flies downwards, 0.5 m above a wall within the domain.
fn chip(wall: &Value, speed: f64, sph: &Value) -> Case {
    let mut methods = json!({ "spacing": 0.1, "courant": 0.05 });
    methods.as_object_mut().unwrap().extend(sph.as_object().unwrap().clone());
    let text = json!({
        "title": "chip", "space": "plane-strain", "domain": { "min": [-2, -2], "max": [2, 2] }, "gravity": [0, 0],
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 100, "poissons_ratio": 0 } },
        "bodies": [{ "name": "chip", "material": "m", "shape": { "kind": "box", "min": [0, 0.5], "max": [0.1, 0.6] },
                     "velocity": { "kind": "uniform", "value": [0, -10] } },
                   { "name": "frame", "material": "m", "shape": { "kind": "box", "min": [1.8, 1.8], "max": [1.9, 1.9] } }],
        "boundaries": [{ "name": "ram", "side": "y-min", "position": 0, "wall": wall, "velocity": [0, speed] }],
        "stages": [{ "name": "s", "duration": 1 }],
        "methods": { "sph": methods }
    });
    read_case(&text)
}

#[test]
fn a_particle_that_passes_a_moved_wall_ends_the_run() {
    let (rough, smooth) = (json!({ "kind": "rough" }), json!({ "kind": "smooth" }));
    let frictional = json!({ "kind": "frictional", "friction_coefficient": 0.3 });
    for (wall, speed, sph) in [
        (&rough, 0.0, json!({})),
        (&rough, 5.0, json!({ "integration": "velocity-verlet" })),
        (&rough, 5.0, json!({ "ranks": 2 })),
        (&frictional, 0.0, json!({})),
        (&frictional, 5.0, json!({})),
        // Held bodies keep their motion.
        (&smooth, 5.0, json!({ "held": ["chip"] })),
        (
            &smooth,
            5.0,
            json!({ "held": ["chip"], "wall_history": { "ram": { "times": [0, 1], "factors": [0, 1] } } }),
        ),
    ] {
        let (x, time, reason) = end_of(&chip(wall, speed, &sph));
        let position_text = reason.strip_prefix("it passed the wall \"ram\", whose face is at y = ");
        let face: f64 = position_text
            .and_then(|position_text| position_text.split(' ').next()?.parse().ok())
            .expect(&reason);
        let course = if sph.get("wall_history").is_some() { 0.5 * time * time } else { time };
        assert!((face - speed * course).abs() < 1e-12, "{reason}, at {time} s");
        // The run stops once the particle is half a spacing behind the face.
        assert!((0.05..0.06).contains(&(face - x[1])), "{wall} {sph}: {reason}, at {x:?} m");
    }
}

#[test]
fn the_error_of_a_lost_particle_names_the_wall_or_the_domain() {
    let at_side = |wall: Value| {
        let mut case = chip(&json!({ "kind": "rough" }), 0.0, &json!({}));
        case.boundaries = serde_json::from_value(wall).unwrap();
        case
    };
    let (x, _, reason) = end_of(&at_side(json!([{ "side": "y-min", "wall": { "kind": "rough" } }])));
    assert!(reason.starts_with("it passed the wall \"y-min\", whose face is at y = -2 m"), "{reason}");
    assert!((-2.06..-2.05).contains(&x[1]), "{x:?}");
    let (x, _, reason) = end_of(&at_side(json!([])));
    assert!(reason.starts_with("it left the domain"), "{reason}");
    assert!((-2.06..-2.05).contains(&x[1]), "{x:?}");
}
