//! Diagnostics of the sums over neighbours, and equilibrium under a confining pressure (sheet: sph §2.2, §2.13 g).

use colluvium_case::{Case, Method};
use colluvium_constitutive::SymTensor;
use colluvium_sph::Sph;
use colluvium_sph::setup::rates_only::{PrescribedParticle, rates};
use colluvium_testkit::{case_with, scalar_output, solve, start_solver, vectors};
use serde_json::{Value, json};

/// Elastic block of 20 x 20 particles on a rough floor.
fn block(more: &Value, sph: &Value) -> Case {
    let mut methods = json!({ "spacing": 0.05 });
    methods.as_object_mut().unwrap().extend(sph.as_object().unwrap().clone());
    let text = json!({
        "title": "test", "space": "plane-strain", "domain": { "min": [-1, 0], "max": [2, 2] }, "gravity": [0, 0],
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "s", "duration": 0.01 }],
        "methods": { "sph": methods }
    });
    case_with(text, more)
}

#[test]
fn kernel_sums_are_exact_within_and_deficient_at_surfaces() {
    let sph = json!({ "diagnostics": true, "regularisation": "mls", "momentum": "corrected" });
    let solver = start_solver(&Sph, &block(&json!({}), &sph));
    let snapshot = solver.snapshot();
    let (constant, position) =
        (vectors(&snapshot, "gradient_of_constant"), snapshot.tensors("gradient_of_position").unwrap());
    for ((x, constant), position) in snapshot.positions.iter().zip(&constant).zip(position) {
        let inside = (0.15..0.85).contains(&x[0]) && x[1] < 0.85;
        let size = constant.iter().fold(0.0, |largest: f64, c| largest.max(c.abs()));
        if inside {
            // Particles of the floor count as those of the block.
            assert!(size < 1e-12, "{x:?}: {constant:?}");
            assert!(
                (position.component(0, 0) - 1.0).abs() < 0.02 && position.component(0, 1).abs() < 1e-12,
                "{position:?}"
            );
        } else if x[0] < 0.05 && (0.15..0.85).contains(&x[1]) {
            // From the surface into the body.
            assert!(constant[0] > 0.3 && constant[1].abs() < 1e-12, "{x:?}: {constant:?}");
            assert!(position.component(0, 0) < 0.7, "{position:?}");
        }
    }
    for name in ["coincident_pairs", "uncorrected_gradients", "averages_by_shepard"] {
        assert_eq!(scalar_output(&*solver, name), 0.0, "{name}");
    }
}

#[test]
fn gradients_and_averages_without_correction_are_counted() {
    // A line of particles has no neighbours across it: no gradient can be corrected, no average be linear.
    let line = json!({ "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 1], "max": [1, 1.05] } }] });
    let sph = json!({ "diagnostics": true, "regularisation": "mls", "velocity_gradient": "corrected" });
    let solver = start_solver(&Sph, &block(&line, &sph));
    assert_eq!(solver.point_count(), 20);
    assert_eq!(scalar_output(&*solver, "uncorrected_gradients"), 20.0);
    assert_eq!(scalar_output(&*solver, "averages_by_shepard"), 20.0);
}

#[test]
fn diagnostics_change_nothing_else() {
    let thrown = json!({ "gravity": [0, -10] });
    let [plain, with_diagnostics] = [false, true].map(|diagnostics| {
        solve(&Sph, &block(&thrown, &json!({ "diagnostics": diagnostics }))).snapshot.positions
    });
    assert_eq!(plain, with_diagnostics);
    let total = block(
        &json!({ "boundaries": [] }),
        &json!({ "formulation": "total-lagrangian", "diagnostics": true }),
    );
    let problem = Sph.plan(&total).unwrap_err().to_string();
    assert!(problem.starts_with("methods.sph.diagnostics"), "{problem}");
}

#[test]
fn a_confined_block_comes_to_rest_under_the_full_pressure() {
    // Only the pressure acts, and it increases for longer than the block takes to reach equilibrium.
    let more = json!({
        "boundaries": [],
        "stages": [{ "name": "s", "duration": 4, "damping": 0.5,
                     "equilibrium": { "unbalanced_force": 1e-2, "kinetic_energy": 1e-3 } }]
    });
    let sph = json!({ "momentum": "rho-rho", "confining": { "pressure": 1000, "ramp": 0.5 } });
    let report = solve(&Sph, &block(&more, &sph));
    assert!((0.5..3.0).contains(&report.snapshot.time), "{}", report.snapshot.time);
    let pressures = report.snapshot.tensors("stress").unwrap().iter().map(|s| -0.5 * (s[0] + s[1]));
    let mean = pressures.sum::<f64>() / 400.0;
    assert!((mean / 1000.0 - 1.0).abs() < 0.1, "{mean}");
}

/// For any position of the surface and the layer beside it relative to the periodic boundary.
#[test]
fn accelerations_of_a_confined_disc_do_not_depend_on_the_periodic_boundary() {
    let more = json!({
        "domain": { "min": [0, 0], "max": [1, 1], "periodic": ["x"] }, "boundaries": [],
        "bodies": [{ "name": "b", "material": "m",
                     "shape": { "kind": "ball", "centre": [0.5, 0.5], "radius": 0.3 } }]
    });
    let case = block(&more, &json!({ "momentum": "rho-rho", "confining": { "pressure": 1000 } }));
    let accelerations = |columns: i32| {
        let given = |id: u32, _: &[f64; 2]| PrescribedParticle {
            displacement: [0.05 * f64::from(columns), 0.0],
            velocity: [0.0; 2],
            compression: 1.0,
            // Out-of-plane stress that only identifies the particles.
            stress: SymTensor([0.0, 0.0, f64::from(id), 0.0, 0.0, 0.0]),
        };
        let mut all = rates::<2>(&case, given).unwrap();
        all.sort_by(|a, b| a.stress.0[2].total_cmp(&b.stress.0[2]));
        all.iter().map(|p| p.acceleration).collect::<Vec<_>>()
    };
    let expected = accelerations(0);
    for columns in 1..20 {
        for (found, expected) in accelerations(columns).iter().zip(&expected) {
            // Sums over the neighbours in another order; the largest are 22 m/s².
            let near = (0..2).all(|c| (found[c] - expected[c]).abs() < 1e-10);
            assert!(near, "{columns} columns on: {found:?} for {expected:?}");
        }
    }
}

fn warnings(sph: &Value) -> String {
    colluvium_testkit::lines(&Sph.plan(&block(&json!({}), sph)).unwrap().warnings)
}

#[test]
fn unsuitable_options_cause_warnings_that_name_them() {
    for kernel in ["wendland-c2", "wendland-c4", "wendland-c6"] {
        let warned = |smoothing: f64| warnings(&json!({ "kernel": kernel, "smoothing": smoothing }));
        assert!(
            warned(1.1).contains("methods.sph.smoothing: ") && !warned(1.2).contains("methods.sph.smoothing")
        );
    }
    for momentum in ["rho2", "rho-rho", "corrected"] {
        let text = warnings(&json!({ "momentum": momentum, "confining": { "pressure": 1 } }));
        assert_eq!(text.contains("methods.sph.momentum: only rho-rho"), momentum != "rho-rho", "{text}");
    }
}

#[test]
fn zero_step_intervals_are_refused_with_the_option_that_disables_them() {
    for off in ["regularisation", "density_reset"] {
        let name = format!("{off}_steps");
        let case = block(&json!({}), &json!({ name.as_str(): 0 }));
        let error = Sph.plan(&case).unwrap_err().to_string();
        assert_eq!(
            error,
            format!("methods.sph.{name}: 0 must be at least 1; to turn it off, set {off} to none")
        );
    }
}

#[test]
fn options_without_effect_cause_warnings() {
    for (name, value) in [
        ("regularisation_steps", json!(3)),
        ("density_reset_steps", json!(3)),
        ("stress_diffusion_k0", json!(0.4)),
        ("wall_k0", json!(0.4)),
        ("smoothing_growth", json!(1.2)),
        ("symmetrisation", json!("harmonic")),
        ("smooth_wall", json!("particles")),
    ] {
        let text = warnings(&json!({ name: value }));
        assert!(text.contains(&format!("methods.sph.{name}: has no effect")), "{text}");
    }
    for (name, value) in [
        ("wall_stress", json!("interpolated")),
        ("wall_velocity", json!("linear")),
        ("wall_guard", json!(0.1)),
    ] {
        let text = warnings(&json!({ "rough_wall": "mirror", name: value }));
        assert!(text.contains(&format!("methods.sph.{name}: has no effect")), "{text}");
        assert!(!warnings(&json!({ name: value })).contains("no effect"));
    }
    assert!(!warnings(&json!({})).contains("no effect"));
}
