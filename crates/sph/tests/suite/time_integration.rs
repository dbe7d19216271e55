//! Time integration, damping, periodic domains, moving and frictional walls: closed forms.

use std::f64::consts::PI;

use colluvium_case::{Case, Method, Snapshot, Solver, StepLimit};
use colluvium_sph::Sph;
use colluvium_sph::kernel::{Kernel, Smoothing};
use colluvium_sph::setup::rates_only::unchecked_energy_history;
use colluvium_testkit::{advance_steps, read_case, scalars, start_solver, stresses, vectors};
use serde_json::{Value, json};

fn solver(text: &Value) -> Box<dyn Solver> {
    start_solver(&Sph, &read_case(text))
}

/// Bar between two mirrors that oscillates in its first mode.
fn bar(scheme: &str) -> Value {
    json!({
        "title": "bar", "space": "1d", "domain": { "min": [0], "max": [1] }, "gravity": [0],
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] },
                     "velocity": { "kind": "sine", "amplitude": [0.3], "wave_vector": [PI] } }],
        "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }, { "side": "x-max", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "s", "duration": 1 }],
        "methods": { "sph": { "spacing": 0.05, "integration": scheme, "viscosity_linear": 0 } }
    })
}

/// Positions after a fifth of a period in `steps` steps.
fn swung(scheme: &str, steps: u32) -> Vec<f64> {
    let mut solver = solver(&bar(scheme));
    let dt = 0.0125 / f64::from(steps);
    (0..steps).for_each(|_| {
        solver.step(dt).unwrap();
    });
    solver.snapshot().positions.iter().map(|x| x[0]).collect()
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

const SCHEMES: [&str; 7] = [
    "leapfrog",
    "leapfrog-rates",
    "predictor-corrector",
    "position-verlet",
    "velocity-verlet",
    "verlet",
    "runge-kutta4",
];

#[test]
fn schemes_converge_with_the_second_order_of_the_step() {
    let exact = swung("runge-kutta4", 640);
    for scheme in SCHEMES {
        let (coarse, fine) = (apart(&swung(scheme, 40), &exact), apart(&swung(scheme, 80), &exact));
        let order = (coarse / fine).log2();
        // Verlet makes a plain step of first order at the start and every forty steps: its error is that of this step.
        assert!(order > 1.85, "{scheme}: {coarse:e} {fine:e}, order {order}");
        assert!(coarse < 2e-4, "{scheme}: {coarse:e}");
    }
}

/// Block without external forces.
fn block(more: &Value, sph: &Value) -> Value {
    let mut text = json!({
        "title": "block", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1] }, "gravity": [0, 0],
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.3, 0.3], "max": [0.7, 0.7] },
                     "velocity": { "kind": "uniform", "value": [0.5, -0.25] } }],
        "stages": [{ "name": "s", "duration": 1 }],
        "methods": { "sph": { "spacing": 0.05 } }
    });
    for (key, value) in more.as_object().unwrap() {
        text[key] = value.clone();
    }
    for (key, value) in sph.as_object().unwrap() {
        text["methods"]["sph"][key] = value.clone();
    }
    text
}

#[test]
fn v18_damping_is_exact() {
    // Decay rate ξ c / h.
    let rate = 0.05 * (1.2e6f64 / 1000.0).sqrt() / 0.06;
    for scheme in SCHEMES {
        let mut solver = solver(&block(&json!({}), &json!({ "damping": 0.05, "integration": scheme })));
        advance_steps(&mut *solver, 45);
        let exact = 0.5 * (-rate * solver.time()).exp();
        for v in vectors(&solver.snapshot(), "velocity") {
            assert!((v[0] / exact - 1.0).abs() < 1e-12, "{scheme}: {} {exact}", v[0]);
        }
        // Angular momentum about the origin of a body without rotation.
        let (budget, snapshot) = (solver.totals(), solver.snapshot());
        let weighed = |c: usize| snapshot.positions.iter().map(|x| x[c]).sum::<f64>() / 64.0;
        let turn = budget.momentum[1] * weighed(0) - budget.momentum[0] * weighed(1);
        assert!((budget.angular_momentum[2] / turn - 1.0).abs() < 1e-12, "{scheme}: {budget:?}");
    }
}

#[test]
fn v17_free_fall_is_exact() {
    for scheme in SCHEMES {
        let more = json!({ "gravity": [1, -10] });
        let mut solver = solver(&block(&more, &json!({ "integration": scheme })));
        let start = solver.snapshot().positions;
        advance_steps(&mut *solver, 60);
        let found = solver.snapshot();
        let t = found.time;
        let velocity = [0.5 + t, -0.25 - 10.0 * t];
        let path = [0.5 * t + 0.5 * t * t, -0.25 * t - 5.0 * t * t];
        for v in vectors(&found, "velocity") {
            assert!((0..2).all(|c| (v[c] - velocity[c]).abs() < 1e-12), "{scheme}: {v:?} {velocity:?}");
        }
        for (x, start) in found.positions.iter().zip(start) {
            assert!((0..2).all(|c| (x[c] - start[c] - path[c]).abs() < 1e-12), "{scheme}: {x:?}");
        }
        for (density, stress) in scalars(&found, "density").iter().zip(stresses(&found)) {
            assert!((density / 1000.0 - 1.0).abs() < 1e-12, "{scheme}: {density}");
            // Relative to a modulus of 1.2 MPa.
            assert!(stress.iter().all(|s| s.abs() < 1e-6), "{scheme}: {stress:?}");
        }
    }
}

#[test]
fn a_body_translates_through_a_periodic_domain_unchanged() {
    let full = json!({ "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] },
                                    "velocity": { "kind": "uniform", "value": [3.0, -2.0] } }],
                       "domain": { "min": [0, 0], "max": [1, 1], "periodic": ["x", "y"] } });
    let mut solver = solver(&block(&full, &json!({ "spacing": 0.1 })));
    advance_steps(&mut *solver, 2000);
    let snapshot = solver.snapshot();
    assert!(snapshot.time * 3.0 > 2.0);
    for (x, u) in snapshot.positions.iter().zip(vectors(&snapshot, "displacement")) {
        assert!((u[0] - 3.0 * snapshot.time).abs() < 1e-9, "{u:?}");
        assert!((-0.2..1.2).contains(&x[0]) && (-0.2..1.2).contains(&x[1]), "{x:?}");
    }
    assert!(scalars(&snapshot, "density").iter().all(|d| (d - 1000.0).abs() < 1e-6));
}

/// Stress-free block with uniform expansion: it grows by 1e-4 in a step.
fn expanded(sph: &Value, steps: u32) -> Snapshot {
    let more = json!({
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e-3, "poissons_ratio": 0.25 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.3, 0.3], "max": [0.7, 0.7] },
                     "velocity": { "kind": "linear", "value": [0, 0], "origin": [0.5, 0.5], "gradient": [[1, 0], [0, 1]] } }]
    });
    let mut methods = json!({ "viscosity_linear": 0, "velocity_gradient": "corrected", "spacing": 0.025 });
    methods.as_object_mut().unwrap().extend(sph.as_object().unwrap().clone());
    let mut solver = solver(&block(&more, &methods));
    (0..steps).for_each(|_| {
        solver.step(1e-4).unwrap();
    });
    solver.snapshot()
}

#[test]
fn v28_the_smoothing_length_follows_the_density() {
    for (length, symmetrisation) in
        [("density", "arithmetic"), ("density", "grad-h"), ("density", "kernel"), ("rate", "arithmetic")]
    {
        let found = expanded(&json!({ "smoothing_length": length, "symmetrisation": symmetrisation }), 1000);
        for density in scalars(&found, "density") {
            assert!(
                (density / 1000.0 * 1.1f64.powi(2) - 1.0).abs() < 1e-6,
                "{length} {symmetrisation}: {density}"
            );
        }
        if length == "density" {
            for h in scalars(&found, "smoothing_length") {
                assert!((h / 0.03 / 1.1 - 1.0).abs() < 1e-6, "{symmetrisation}: {h}");
            }
        }
    }
}

/// Sum `Σ V W` of a square lattice of unit spacing, and its derivative by the smoothing length.
fn lattice_sum(h: f64) -> (f64, f64) {
    let kernel = Smoothing::<2>::new(Kernel::CubicSpline, h).unwrap();
    let places = (-5..=5i32).flat_map(|x| (-5..=5i32).map(move |y| f64::from(x).hypot(f64::from(y))));
    places.fold((0.0, 0.0), |(v, s), r| (v + kernel.value(r), s + kernel.length_derivative(r)))
}

/// The rate of AL1 36–37 keeps Σ m W - ρ constant. With the lattice sum S(h/Δx), that is `S(h/(a Δx)) - 1 = a² (S(h₀/Δx) - 1)`: only
/// approximately `h = a h₀`. It holds within the body, and initially: the effect of surfaces
/// propagates inwards.
#[test]
fn v28_the_rate_of_the_smoothing_length_keeps_the_error_of_the_summed_density() {
    let a = 1.01;
    let goal = 1.0 + a * a * (lattice_sum(1.2).0 - 1.0);
    let mut ratio = 1.2;
    for _ in 0..20 {
        let (sum, slope) = lattice_sum(ratio);
        ratio -= (sum - goal) / slope;
    }
    let exact = ratio * a * 0.025;
    assert!((exact / (a * 0.03) - 1.0).abs() < 5e-4, "{exact}");
    let found = expanded(&json!({ "smoothing_length": "rate" }), 100);
    let inner = found.positions.iter().zip(scalars(&found, "smoothing_length"));
    for (x, h) in inner.filter(|(x, _)| (0..2).all(|c| (x[c] - 0.5).abs() < 0.03)) {
        assert!((h / exact - 1.0).abs() < 1e-5, "{x:?}: {h} {exact}");
    }
}

/// Acceleration (m/s²) of a block on a frictional floor under gravity inclined by `angle` degrees.
fn slide(angle: f64, friction: f64) -> f64 {
    let (sin, cos) = angle.to_radians().sin_cos();
    let more = json!({
        "gravity": [10.0 * sin, -10.0 * cos],
        "domain": { "min": [0, 0], "max": [2, 1] },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.2, 0], "max": [0.8, 0.2] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": friction } }]
    });
    let mut solver = solver(&block(&more, &json!({ "spacing": 0.025 })));
    let mean = |solver: &dyn Solver| {
        let v = vectors(&solver.snapshot(), "velocity");
        v.iter().map(|v| v[0]).sum::<f64>() / v.len() as f64
    };
    let (start, mut begin) = (0.15, None);
    while solver.time() < 0.4 {
        advance_steps(&mut *solver, 1);
        if begin.is_none() && solver.time() >= start {
            begin = Some((solver.time(), mean(&*solver)));
        }
    }
    let (time, velocity) = begin.unwrap();
    (mean(&*solver) - velocity) / (solver.time() - time)
}

#[test]
fn sliding_and_sticking_on_a_frictional_wall_follow_coulomb_friction() {
    // Acceleration g (sin θ - μ cos θ).
    let sliding = slide(30.0, 0.3);
    let exact = 10.0 * (0.5 - 0.3 * 0.75f64.sqrt());
    assert!((sliding / exact - 1.0).abs() < 0.05, "{sliding} for {exact}");
    let sticking = slide(10.0, 0.5);
    assert!(sticking.abs() < 0.05, "{sticking}");
}

#[test]
fn friction_over_the_normal_force_is_the_coefficient_at_any_viscosity() {
    for viscosity in [0.0, 0.05, 0.1, 0.2] {
        let more = json!({
            "gravity": [0, -10],
            "domain": { "min": [0, 0], "max": [5, 1] },
            "bodies": [{ "name": "b", "material": "m", "velocity": { "kind": "uniform", "value": [4, 0] }, "shape": { "kind": "box", "min": [0.2, 0], "max": [0.8, 0.2] } }],
            "boundaries": [{ "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": 0.3 } }]
        });
        let mut solver = solver(&block(&more, &json!({ "spacing": 0.025, "viscosity_linear": viscosity })));
        let mut states = Vec::new();
        for time in [0.1, 0.9] {
            while solver.time() < time {
                advance_steps(&mut *solver, 1);
            }
            let totals = solver.totals();
            states.push((solver.time(), totals.mass, totals.momentum));
        }
        // Momentum from the floor, tangential and normal.
        let [(begin, mass, from), (end, _, to)] = states[..] else { panic!() };
        let normal = to[1] - from[1] + mass * 10.0 * (end - begin);
        let ratio = (from[0] - to[0]) / normal;
        assert!((ratio / 0.3 - 1.0).abs() < 2e-3, "viscosity {viscosity}: {ratio}");
        assert!(to[0] / mass > 1.0, "it still slides: {}", to[0] / mass);
    }
}

#[test]
fn a_moving_wall_pushes_the_block_and_a_moving_belt_drags_it() {
    for (smooth, pushed) in [("mirror", true), ("particles", true)] {
        let more = json!({
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0.3], "max": [0.4, 0.7] } }],
            "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" }, "velocity": [0.5, 0] }]
        });
        let mut solver = solver(&block(&more, &json!({ "smooth_wall": smooth })));
        while solver.time() < 0.2 {
            advance_steps(&mut *solver, 1);
        }
        let least = solver.snapshot().positions.iter().map(|x| x[0]).fold(f64::INFINITY, f64::min);
        assert!((least - 0.1 - 0.025).abs() < 0.015 && pushed, "{smooth}: {least}");
    }
    let more = json!({
        "gravity": [0, -10],
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.3, 0], "max": [0.7, 0.2] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" }, "velocity": [0.5, 0] }]
    });
    for wall in ["pairwise", "interpolated"] {
        let mut solver = solver(&block(&more, &json!({ "wall_stress": wall, "damping": 0.02 })));
        while solver.time() < 0.2 {
            advance_steps(&mut *solver, 1);
        }
        let budget = solver.totals();
        assert!(budget.momentum[0] / budget.mass > 0.02, "{wall}: {:?}", budget.momentum);
    }
}

#[test]
fn v19_the_leapfrog_is_stable_up_to_its_limit() {
    let full = json!({ "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] },
                                    "velocity": { "kind": "sine", "amplitude": [1e-6, 1e-6], "wave_vector": [37, 91] } }],
                       "domain": { "min": [0, 0], "max": [1, 1], "periodic": ["x", "y"] } });
    let kinetic = |courant: f64| {
        let case = block(&full, &json!({ "spacing": 0.1, "viscosity_linear": 0 }));
        let dt = courant * 0.12 / (1.2e6f64 / 1000.0).sqrt();
        let course = unchecked_energy_history(&read_case(&case), dt, 2000).unwrap();
        if course.len() == 2001 { course[2000] / course[0] } else { f64::INFINITY }
    };
    // Half of the energy is stored, and the waves of the lattice interfere.
    assert!(kinetic(1.7) < 20.0, "{}", kinetic(1.7));
    assert!(kinetic(2.0) > 1e3, "{}", kinetic(2.0));
}

/// Error of a block with a particle spacing of 0.05 m.
fn refusal(sph: &Value) -> String {
    let case = read_case(&block(&json!({}), sph));
    Sph.plan(&case).unwrap_err().to_string()
}

#[test]
fn a_fixed_step_keeps_to_each_limit() {
    let (h, c) = (0.06, (1.2e6f64 / 1000.0).sqrt());
    // Velocities are 0.56 m/s.
    let wave = 1.8 * h / (c + 0.3125f64.sqrt());
    for courant in [0.1, 0.4] {
        solver(&block(&json!({}), &json!({ "courant": courant, "time_step": 0.999 * wave })));
        let error = refusal(&json!({ "courant": courant, "time_step": 1.001 * wave }));
        assert!(
            error.starts_with("methods.sph.time_step: ") && error.contains("limited by: elastic wave"),
            "{error}"
        );
    }
    // Limit 0.2 / c_d with c_d = ξ c / h, a third of that of waves.
    let damping = 0.2 * h / (0.3 * c);
    solver(&block(&json!({}), &json!({ "damping": 0.3, "time_step": 0.999 * damping })));
    let error = refusal(&json!({ "damping": 0.3, "time_step": 1.001 * damping }));
    assert!(error.contains("limited by: damping"), "{error}");
}

#[test]
fn a_fixed_step_that_becomes_too_long_stops_the_run() {
    let step = 1.7 * 0.06 / (1.2e6f64 / 1000.0).sqrt();
    let mut solver = solver(&block(&json!({ "gravity": [0, -50] }), &json!({ "time_step": step })));
    let stopped = (0..30).find_map(|_| {
        let dt = solver.limit().dt;
        solver.step(dt).err()
    });
    let error = stopped.unwrap().to_string();
    assert!(
        error.contains("methods.sph.time_step: ") && error.contains("larger than the critical"),
        "{error}"
    );
}

#[test]
fn the_second_step_is_limited_by_the_acceleration() {
    let mut solver = solver(&block(&json!({ "gravity": [0, -1e6] }), &json!({})));
    assert_eq!(solver.limit().limit, StepLimit::ELASTIC_WAVE);
    solver.step(1e-6).unwrap();
    let limit = solver.limit();
    assert_eq!(limit.limit, StepLimit::ACCELERATION);
    assert!((limit.dt / (0.25 * (0.06f64 / 1e6).sqrt()) - 1.0).abs() < 1e-6, "{limit:?}");
}

#[test]
fn a_hard_impact_does_not_pass_a_guarded_floor() {
    let more = json!({
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "ball", "centre": [0.5, 0.3], "radius": 0.12 },
                     "velocity": { "kind": "uniform", "value": [0, -8] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }]
    });
    let mut solver = solver(&block(&more, &json!({ "wall_guard": 0.02, "spacing": 0.025 })));
    while solver.time() < 0.08 {
        advance_steps(&mut *solver, 1);
    }
    let lowest = solver.snapshot().positions.iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
    assert!(lowest > 0.0, "{lowest}");
}

/// Blocks without contact, one at rest, one oscillating and one held; `more` adds keys to the second stage.
fn three_blocks(integration: &str, more: &Value) -> Case {
    let body = |name: &str, low: f64, velocity: Value| {
        json!({ "name": name, "material": "m", "velocity": velocity,
                "shape": { "kind": "box", "min": [low, 0], "max": [low + 0.4, 0.4] } })
    };
    let ringing = json!({ "kind": "sine", "amplitude": [0.3, -0.2], "wave_vector": [11, 17] });
    let passing = json!({ "kind": "uniform", "value": [0.2, 0.1] });
    let mut second = json!({ "name": "two", "duration": 1 });
    for (key, value) in more.as_object().unwrap() {
        second[key] = value.clone();
    }
    let text = json!({
        "title": "blocks", "space": "plane-strain", "domain": { "min": [-1, -1], "max": [3, 2] }, "gravity": [0, 0],
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 } },
        "bodies": [body("first", 1.5, json!({ "kind": "uniform", "value": [0, 0] })), body("ringing", 0.0, ringing), body("held", 0.8, passing)],
        "stages": [{ "name": "one", "duration": 1, "reset": ["velocity"] }, second],
        "methods": { "sph": { "spacing": 0.05, "integration": integration, "held": ["held"], "hourglass_viscosity": 0.3 } }
    });
    read_case(&text)
}

/// Saved data of the previous step on the particles remain valid where other particles are removed.
#[test]
fn the_removal_of_a_body_far_away_changes_nothing() {
    for integration in ["leapfrog", "leapfrog-rates", "verlet"] {
        let run = |more: &Value| {
            let mut solver = start_solver(&Sph, &three_blocks(integration, more));
            (0..20).for_each(|_| {
                solver.step(2e-4).unwrap();
            });
            let time = solver.time();
            solver.begin_stage(1, time).unwrap();
            (0..3).for_each(|_| {
                solver.step(2e-4).unwrap();
            });
            let snapshot = solver.snapshot();
            let all = snapshot.bodies.iter().zip(vectors(&snapshot, "velocity"));
            all.filter(|(body, _)| **body == 1).map(|(_, v)| v).collect::<Vec<_>>()
        };
        let (kept, removed) = (run(&json!({})), run(&json!({ "remove_bodies": ["first"] })));
        assert_eq!(kept.len(), removed.len());
        for (a, b) in kept.iter().zip(&removed) {
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12, "{integration}: {a:?} {b:?}");
        }
    }
}

#[test]
fn held_bodies_keep_their_velocity_after_a_velocity_reset() {
    for integration in [
        "leapfrog",
        "leapfrog-rates",
        "predictor-corrector",
        "position-verlet",
        "velocity-verlet",
        "verlet",
        "runge-kutta4",
    ] {
        let case = three_blocks(integration, &json!({}));
        let mut solver = start_solver(&Sph, &case);
        (0..10).for_each(|_| {
            solver.step(2e-4).unwrap();
        });
        solver.end_stage(&case.stages[0]).unwrap();
        let time = solver.time();
        solver.begin_stage(1, time).unwrap();
        (0..10).for_each(|_| {
            solver.step(2e-4).unwrap();
        });
        let snapshot = solver.snapshot();
        for (body, u) in snapshot.bodies.iter().zip(vectors(&snapshot, "displacement")) {
            let off = (u[0] - 0.2 * snapshot.time).hypot(u[1] - 0.1 * snapshot.time);
            assert!(*body != 2 || off < 1e-14, "{integration}: {u:?} after {} s", snapshot.time);
        }
    }
}
