//! Solver against closed forms and conservation laws, and its bitwise reproducibility.

use colluvium_case::{Case, Method, Solver};
use colluvium_sph::Sph;
use colluvium_testkit::{CaseBuilder, advance_steps, assert_same_on_threads, start_solver, vectors};
use serde_json::{Value, json};

/// Block of one material with the simplest options.
fn elastic_block() -> CaseBuilder {
    CaseBuilder::plane_strain([0.0, 0.0], [1.0, 1.0])
        .elastic("m", 1000.0, 1e6, 0.25)
        .box_body("b", "m", &[0.2, 0.3], &[0.6, 0.7])
        .stage("s", 0.05)
        .options("sph", json!({ "spacing": 0.05 }))
}

/// Block that slides on a rough floor against a smooth wall, with all particles in motion and at yield.
fn crash(options: &Value) -> Case {
    let mut methods = json!({ "spacing": 0.025 });
    for (key, value) in options.as_object().unwrap() {
        methods[key] = value.clone();
    }
    elastic_block().with(json!({
        "gravity": [0, -10],
        "materials": { "m": {
            "model": "drucker-prager", "density": 1000, "youngs_modulus": 1e5, "poissons_ratio": 0.3,
            "friction_angle": 20, "cohesion": 500, "matching": "plane-strain"
        } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.05, 0], "max": [0.3, 0.25] },
                     "velocity": { "kind": "uniform", "value": [-0.3, 0.0] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } },
                       { "side": "x-min", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "s", "duration": 0.1 }],
        "methods": { "sph": methods }
    })).build()
}

fn variants() -> Vec<Value> {
    vec![
        json!({}),
        json!({ "momentum": "rho-rho", "continuity": "volume", "velocity_gradient": "corrected",
                "regularisation": "mls", "tensile": { "kind": "artificial-stress", "strength": 0.5, "exponent": 2.55 } }),
        json!({ "kernel": "wendland-c2", "smoothing": 1.5, "wall_stress": "extrapolated", "regularisation": "shepard",
                "damping": 0.01, "sound_speed": "youngs-modulus" }),
        json!({ "smoothing_length": "density", "symmetrisation": "grad-h", "integration": "position-verlet", "xsph": 0.3 }),
        json!({ "smoothing_length": "density", "symmetrisation": "kernel", "integration": "velocity-verlet",
                "smooth_wall": "particles", "wall_velocity": "linear", "stress_diffusion": 0.1,
                "tensile": { "kind": "artificial-stress", "strength": 0.5, "exponent": 2.55 } }),
        json!({ "smoothing_length": "rate", "symmetrisation": "harmonic", "shifting": 0.5, "wall_guard": 0.01 }),
        json!({ "integration": "leapfrog-rates", "regularisation": "mls", "kernel": "quintic-spline" }),
        json!({ "integration": "predictor-corrector", "kernel": "gaussian" }),
        json!({ "integration": "verlet", "kernel": "wendland-c4" }),
        json!({ "integration": "runge-kutta4", "kernel": "wendland-c6", "smoothing": 1.5 }),
        json!({ "rough_wall": "mirror", "velocity_gradient": "corrected", "hourglass_viscosity": 0.5 }),
        json!({ "momentum": "rho-rho", "confining": { "pressure": 100 } }),
        json!({ "momentum": "corrected", "rough_wall": "mirror", "hourglass_viscosity": 0.1 }),
        json!({ "integration": "velocity-verlet", "regularisation": "mls", "shifting": 0.5 }),
        json!({ "shifting": 0.5, "wall_stress": "interpolated" }),
        json!({ "shifting": 0.5, "wall_stress": "extrapolated" }),
    ]
}

#[test]
fn results_are_the_same_on_one_and_two_threads() {
    let total = elastic_block().with(json!({
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "ball", "centre": [0.5, 0.5], "radius": 0.4 },
                     "velocity": { "kind": "sine", "amplitude": [0, 1], "wave_vector": [9, 0] } }],
        "methods": { "sph": { "spacing": 0.025, "formulation": "total-lagrangian", "velocity_gradient": "corrected" } }
    })).build();
    let cases = variants().into_iter().map(|options| (crash(&options), options.to_string()));
    for (case, name) in cases.chain([(total, "total-lagrangian".to_owned())]) {
        assert_same_on_threads(&Sph, &case, &name);
    }
}

#[test]
fn a_restored_solver_continues_bit_identically() {
    let advance = |solver: &mut dyn Solver, steps: usize| {
        for _ in 0..steps {
            let dt = solver.limit().dt;
            solver.step(dt).unwrap();
        }
    };
    for options in variants() {
        let case = crash(&options);
        let mut whole = start_solver(&Sph, &case);
        for cut in [1, 37, 64] {
            advance(&mut *whole, cut);
            let saved = whole.checkpoint_bytes().unwrap();
            let mut again = Sph.build(&case).unwrap();
            again.restore(&mut saved.as_slice()).unwrap();
            again.begin_stage(0, 0.0).unwrap();
            advance(&mut *again, 30);
            advance(&mut *whole, 30);
            assert_eq!(again.snapshot().hash(), whole.snapshot().hash(), "{options}, cut after {cut} steps");
        }
        let saved = whole.checkpoint_bytes().unwrap();
        assert!(whole.restore(&mut &saved[..saved.len() / 2]).is_err());
    }
}

/// Block with non-uniform stress and motion, without external forces.
fn swirl(options: &Value) -> Case {
    let mut methods = json!({ "spacing": 0.02, "viscosity_linear": 0 });
    for (key, value) in options.as_object().unwrap() {
        methods[key] = value.clone();
    }
    elastic_block().with(json!({
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "ball", "centre": [0.5, 0.5], "radius": 0.2 },
                     "velocity": { "kind": "sine", "amplitude": [0.3, -0.2], "wave_vector": [11, 17] },
                     "stress": { "kind": "uniform", "value": [3e3, -2e3, 1e3, 1.5e3, 0, 0] } }],
        "methods": { "sph": methods }
    })).build()
}

#[test]
fn v10_momentum_is_conserved() {
    for options in [
        json!({ "viscosity_linear": 1.0, "viscosity_quadratic": 1.0 }),
        json!({ "momentum": "rho-rho", "viscosity_linear": 0.1 }),
        json!({ "momentum": "corrected", "viscosity_linear": 0.1 }),
        json!({ "tensile": { "kind": "artificial-stress", "strength": 0.5, "exponent": 2.55 } }),
        json!({ "tensile": { "kind": "artificial-pressure", "strength": 0.9, "exponent": 4 }, "velocity_gradient": "corrected" }),
    ] {
        let case = swirl(&options);
        let mut solver = start_solver(&Sph, &case);
        let start = solver.totals().momentum;
        let mut size = 0.0f64;
        for _ in 0..50 {
            let dt = solver.limit().dt;
            solver.step(dt).unwrap();
            let budget = solver.totals();
            size = size.max((2.0 * budget.mass * budget.kinetic).sqrt());
        }
        let end = solver.totals().momentum;
        for c in 0..2 {
            assert!((end[c] - start[c]).abs() < 1e-12 * size, "{options}: {start:?} {end:?}");
        }
    }
    // Form that conserves neither momentum nor energy.
    let case = swirl(&json!({ "momentum": "difference" }));
    let mut solver = start_solver(&Sph, &case);
    let start = solver.totals().momentum;
    (0..50).for_each(|_| {
        let dt = solver.limit().dt;
        solver.step(dt).unwrap();
    });
    assert!((solver.totals().momentum[0] - start[0]).abs() > 1e-6);
}

/// Drift of kinetic plus stored energy over a run, relative to the energy.
fn energy_drift(options: &Value, step: f64) -> f64 {
    let case = swirl(options);
    let mut solver = start_solver(&Sph, &case);
    let energy = |solver: &dyn Solver| {
        let budget = solver.totals();
        budget.kinetic + budget.elastic
    };
    let start = energy(&*solver);
    while solver.time() < 0.01 {
        solver.step(step).unwrap();
    }
    (energy(&*solver) / start - 1.0).abs()
}

#[test]
fn compatible_pairs_conserve_energy_to_second_order_of_the_step() {
    for momentum in ["rho2", "rho-rho", "corrected"] {
        let coarse = energy_drift(&json!({ "momentum": momentum, "velocity_gradient": "compatible" }), 1e-4);
        let fine = energy_drift(&json!({ "momentum": momentum, "velocity_gradient": "compatible" }), 5e-5);
        assert!(coarse < 1e-2 && fine < 1e-2, "{momentum}: {coarse:e} {fine:e}");
    }
}

#[test]
fn v16_a_standing_wave_in_a_confined_strip_has_its_frequency() {
    let (length, spacing) = (1.0, 0.02);
    let case = elastic_block().with(json!({
        "domain": { "min": [0, 0], "max": [1, 0.2] },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 0.2] },
                     "velocity": { "kind": "sine", "amplitude": [1e-4, 0], "wave_vector": [std::f64::consts::PI / length, 0] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "y-max", "wall": { "kind": "smooth" } },
                       { "side": "x-min", "wall": { "kind": "smooth" } }, { "side": "x-max", "wall": { "kind": "smooth" } }],
        "methods": { "sph": { "spacing": spacing, "viscosity_linear": 0 } }
    })).build();
    let mut solver = start_solver(&Sph, &case);
    // Modulus of uniaxial strain: E (1 - ν) / ((1 + ν)(1 - 2ν)) = 1.2 MPa.
    let exact = 2.0 * length / (1.2e6f64 / 1000.0).sqrt();
    let amplitude = |solver: &dyn Solver| {
        let snapshot = solver.snapshot();
        let v = vectors(&snapshot, "velocity");
        snapshot.positions.iter().zip(v).map(|(x, v)| v[0] * (std::f64::consts::PI * x[0]).sin()).sum::<f64>()
    };
    // Three zeros of the amplitude: at one, three and five quarters of the period.
    let (mut zeros, mut before) = (Vec::new(), (0.0, amplitude(&*solver)));
    while zeros.len() < 3 {
        let dt = solver.limit().dt;
        solver.step(dt).unwrap();
        let now = (solver.time(), amplitude(&*solver));
        if before.1 * now.1 < 0.0 {
            zeros.push(before.0 + (now.0 - before.0) * before.1 / (before.1 - now.1));
        }
        before = now;
    }
    let period = zeros[2] - zeros[0];
    assert!((exact / period - 1.0).abs() < 0.015, "{period} instead of {exact}");
}

#[test]
fn keys_and_choices_that_do_not_exist_are_refused_by_name() {
    let choices = [
        "kernel",
        "smoothing_length",
        "symmetrisation",
        "integration",
        "momentum",
        "continuity",
        "velocity_gradient",
        "sound_speed",
        "regularisation",
        "density_reset",
        "formulation",
        "wall_stress",
        "wall_velocity",
        "rough_wall",
        "smooth_wall",
    ];
    for key in choices.into_iter().chain(["smothing"]) {
        let mut methods = json!({ "sph": { "spacing": 0.05 } });
        methods["sph"][key] = json!("nothing-of-the-kind");
        let error =
            Sph.plan(&elastic_block().with(json!({ "methods": methods })).build()).unwrap_err().to_string();
        assert!(error.starts_with(&format!("methods.sph.{key}: ")), "{error}");
    }
    for (key, value) in
        [("tensile", json!({ "kind": "x" })), ("confining", json!({ "on": "all" })), ("held", json!("b"))]
    {
        let mut methods = json!({ "sph": { "spacing": 0.05 } });
        methods["sph"][key] = value;
        let error =
            Sph.plan(&elastic_block().with(json!({ "methods": methods })).build()).unwrap_err().to_string();
        assert!(error.starts_with(&format!("methods.sph.{key}")), "{error}");
    }
}

/// Parts of a case that are not supported, with the path of the error.
fn unsupported_parts() -> Vec<(Value, &'static str)> {
    let wall = |more: Value| {
        let mut boundary = json!({ "side": "y-min", "wall": { "kind": "rough" } });
        for (key, value) in more.as_object().unwrap() {
            boundary[key] = value.clone();
        }
        json!({ "boundaries": [boundary] })
    };
    let large = |edge: f64| {
        json!({ "domain": { "min": [0, 0], "max": [edge, 1] },
                "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }] })
    };
    vec![
        (json!({ "space": "axisymmetric" }), "space"),
        (
            json!({ "loads": [{ "kind": "traction", "body": "b", "side": "y-max", "value": [0, -1], "applied_to": "nodes" }] }),
            "loads[0].applied_to",
        ),
        (json!({ "measures": { "lost": { "kind": "dissipation" } } }), "measures.lost"),
        (
            json!({ "stages": [{ "name": "s", "duration": 1, "rayleigh_damping": 1 }] }),
            "stages[0].rayleigh_damping",
        ),
        (wall(json!({ "separation": true })), "boundaries[0].separation"),
        (
            wall(json!({ "wall": { "kind": "frictional", "friction_coefficient": 1, "bilateral": true } })),
            "boundaries[0].wall.bilateral",
        ),
        (
            json!({ "boundaries": [{ "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": 0.3 } }],
                    "methods": { "sph": { "spacing": 0.05, "wall_stress": "interpolated" } } }),
            "boundaries[0].wall",
        ),
        (wall(json!({ "position": 0.5 })), "bodies[0].shape"),
        (json!({ "domain": { "min": [0, 0], "max": [1.03, 1], "periodic": ["x"] } }), "domain.periodic[0]"),
        (large(1e7), "domain"),
        (large(1e18), "domain"),
        (json!({ "methods": {} }), "methods.sph"),
        (json!({ "methods": { "sph": { "spacing": 0.05, "smoothing": 2.5 } } }), "methods.sph.smoothing"),
        (json!({ "methods": { "sph": { "spacing": 0.05, "time_step": 1 } } }), "methods.sph.time_step"),
    ]
}

/// Options out of range, with the name of the option in the error.
fn options_out_of_range() -> Vec<(Value, &'static str)> {
    vec![
        (json!({ "spacing": 0 }), "spacing"),
        (json!({ "smoothing": 0.5 }), "smoothing"),
        (json!({ "smoothing_growth": 0.5 }), "smoothing_growth"),
        (json!({ "viscosity_linear": -1 }), "viscosity_linear"),
        (json!({ "viscosity_quadratic": -1 }), "viscosity_quadratic"),
        (json!({ "damping": -0.1 }), "damping"),
        (json!({ "courant": 1.5 }), "courant"),
        (json!({ "courant": 0 }), "courant"),
        (
            json!({ "tensile": { "kind": "artificial-stress", "strength": 2, "exponent": 2.55 } }),
            "tensile.strength",
        ),
        (
            json!({ "tensile": { "kind": "artificial-pressure", "strength": 0.5, "exponent": 0 } }),
            "tensile.exponent",
        ),
        (json!({ "regularisation_steps": 0 }), "regularisation_steps"),
        (json!({ "stress_diffusion": 0.6 }), "stress_diffusion"),
        (json!({ "density_diffusion": 0.6 }), "density_diffusion"),
        (json!({ "density_diffusion": 0.1 }), "density_diffusion"),
        (json!({ "density_reset": "shepard" }), "density_reset"),
        (json!({ "density_reset_steps": 0 }), "density_reset_steps"),
        (json!({ "xsph": 1.5 }), "xsph"),
        (json!({ "hourglass_viscosity": 1.5 }), "hourglass_viscosity"),
        (json!({ "hourglass_viscosity": -0.1 }), "hourglass_viscosity"),
        (json!({ "wall_k0": -1 }), "wall_k0"),
        (json!({ "stress_diffusion_k0": -1 }), "stress_diffusion_k0"),
        (json!({ "confining": { "pressure": -1 } }), "confining.pressure"),
        (json!({ "confining": { "pressure": 1, "ramp": -1 } }), "confining.ramp"),
        (json!({ "confining": { "pressure": 1, "bodies": ["nobody"] } }), "confining.bodies[0]"),
        (json!({ "time_step": 0 }), "time_step"),
        (json!({ "shifting": -1 }), "shifting"),
        (json!({ "wall_guard": -1 }), "wall_guard"),
        (json!({ "continuity": "summation" }), "continuity"),
        (json!({ "symmetrisation": "grad-h" }), "symmetrisation"),
        (json!({ "held": ["nobody"] }), "held[0]"),
        (json!({ "ranks": 0 }), "ranks"),
        (json!({ "ranks": 5000 }), "ranks"),
        (json!({ "held": ["b"] }), "held"),
    ]
}

/// Options that exclude each other, with the name of the option in the error.
fn conflicting_options() -> Vec<(Value, &'static str)> {
    vec![
        (json!({ "kernel": "gaussian", "smoothing": 2.5 }), "smoothing"),
        (json!({ "smoothing": 1.6, "confining": { "pressure": 1 } }), "smoothing"),
        (json!({ "smoothing": 1.0, "confining": { "pressure": 1 } }), "smoothing"),
        (json!({ "smoothing_length": "density", "confining": { "pressure": 1 } }), "smoothing_length"),
        (json!({ "smoothing_length": "density", "continuity": "summation" }), "continuity"),
        (
            json!({ "smoothing_length": "density", "symmetrisation": "grad-h", "continuity": "volume" }),
            "continuity",
        ),
        (
            json!({ "smoothing_length": "density", "symmetrisation": "grad-h", "momentum": "rho-rho" }),
            "momentum",
        ),
        (json!({ "smoothing_length": "density", "wall_stress": "interpolated" }), "wall_stress"),
        (json!({ "continuity": "summation", "wall_stress": "interpolated" }), "wall_stress"),
        (json!({ "smoothing_length": "rate", "integration": "verlet" }), "smoothing_length"),
        (json!({ "momentum": "corrected", "velocity_gradient": "difference" }), "velocity_gradient"),
        (json!({ "momentum": "corrected", "wall_stress": "interpolated" }), "wall_stress"),
        (json!({ "ranks": 2, "integration": "verlet" }), "integration"),
        (json!({ "ranks": 2, "formulation": "total-lagrangian" }), "formulation"),
    ]
}

/// Options that the total-Lagrangian formulation excludes, with the name of the option in the error.
fn conflicts_with_total_lagrangian() -> Vec<(Value, &'static str)> {
    vec![
        (json!({ "integration": "verlet" }), "integration"),
        (json!({ "regularisation": "mls" }), "regularisation"),
        (json!({ "smoothing_length": "density" }), "smoothing_length"),
        (json!({ "confining": { "pressure": 1 } }), "confining"),
        (json!({ "momentum": "difference" }), "momentum"),
        (json!({ "velocity_gradient": "difference" }), "velocity_gradient"),
        (json!({ "continuity": "volume" }), "continuity"),
        (json!({ "symmetrisation": "min" }), "symmetrisation"),
        (json!({ "stress_diffusion": 0.1 }), "stress_diffusion"),
        (json!({ "xsph": 0.1 }), "xsph"),
        (json!({ "shifting": 0.1 }), "shifting"),
        (json!({ "hourglass_viscosity": 0.1 }), "hourglass_viscosity"),
        (json!({ "tensile": { "kind": "artificial-stress", "strength": 0.5, "exponent": 2.55 } }), "tensile"),
    ]
}

#[test]
fn unsupported_options_are_refused_by_path() {
    let with = |formulation: Option<&str>, sph: Value| {
        let mut methods = json!({ "spacing": 0.05 });
        if let Some(formulation) = formulation {
            methods["formulation"] = json!(formulation);
        }
        for (key, value) in sph.as_object().unwrap() {
            methods[key] = value.clone();
        }
        json!({ "methods": { "sph": methods } })
    };
    let plain = options_out_of_range().into_iter().chain(conflicting_options());
    let plain = plain.map(|(sph, name)| (with(None, sph), format!("methods.sph.{name}")));
    let total = conflicts_with_total_lagrangian().into_iter();
    let total = total.map(|(sph, name)| (with(Some("total-lagrangian"), sph), format!("methods.sph.{name}")));
    let parts = unsupported_parts().into_iter().map(|(more, path)| (more, path.to_owned()));
    for (more, path) in parts.chain(plain).chain(total) {
        let error = Sph.plan(&elastic_block().with(more).build()).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{path}: ")), "{error}");
    }
}

#[test]
fn the_total_lagrangian_form_refuses_a_density_reset() {
    let case = elastic_block().with(json!({
        "materials": { "m": { "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e5, "viscosity": 1 } },
        "methods": { "sph": { "spacing": 0.05, "formulation": "total-lagrangian", "density_reset": "shepard" } }
    })).build();
    let error = Sph.plan(&case).unwrap_err().to_string();
    assert!(
        error.starts_with("methods.sph.density_reset: ") && error.contains("total-Lagrangian"),
        "{error}"
    );
}

#[test]
fn density_by_summation_needs_full_supports_and_one_density() {
    let sides = ["x-min", "x-max", "y-min", "y-max"];
    let closed = |shapes: &[(&str, [f64; 2], [f64; 2])], sph: &Value| {
        let mut methods = json!({ "spacing": 0.05, "continuity": "summation" });
        for (key, value) in sph.as_object().unwrap() {
            methods[key] = value.clone();
        }
        let bodies = shapes.iter().enumerate().map(|(number, (material, low, high))| {
            json!({ "name": number.to_string(), "material": material,
                    "shape": { "kind": "box", "min": low, "max": high } })
        });
        let of = |density: f64| json!({ "model": "linear-elastic", "density": density, "youngs_modulus": 1e6, "poissons_ratio": 0.25 });
        let wall = |side: &str| json!({ "side": side, "wall": { "kind": if side == "y-min" { "rough" } else { "smooth" } } });
        elastic_block()
            .with(json!({
                "materials": { "m": of(1000.0), "light": of(900.0) }, "bodies": bodies.collect::<Vec<_>>(),
                "boundaries": sides.map(wall), "methods": { "sph": methods }
            }))
            .build()
    };
    let whole = [("m", [0.0, 0.0], [1.0, 1.0])];
    let half = [("m", [0.0, 0.0], [1.0, 0.5])];
    let two = [("m", [0.0, 0.0], [1.0, 0.5]), ("m", [0.0, 0.5], [1.0, 1.0])];
    let unlike = [("m", [0.0, 0.0], [1.0, 0.5]), ("light", [0.0, 0.5], [1.0, 1.0])];
    for bodies in [&whole[..], &two] {
        Sph.plan(&closed(bodies, &json!({}))).unwrap();
    }
    for bodies in [&half[..], &unlike] {
        let error = Sph.plan(&closed(bodies, &json!({}))).unwrap_err().to_string();
        assert!(error.starts_with("methods.sph.continuity: "), "{error}");
        Sph.plan(&closed(bodies, &json!({ "allow_summation": true }))).unwrap();
    }
    // The check changes nothing in the solver.
    let [checked, free] = [json!({}), json!({ "allow_summation": true })].map(|sph| {
        let mut solver = start_solver(&Sph, &closed(&whole, &sph));
        advance_steps(&mut *solver, 20);
        solver.snapshot().hash()
    });
    assert_eq!(checked, free);
}
