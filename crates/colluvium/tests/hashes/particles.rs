//! Runs of smoothed particles.

use serde_json::{Value, json};

use crate::{Runs, block, crash, elastic, merged, soil, water};

/// Adds them.
pub fn add(runs: &mut Runs) {
    let mut run = |name: &str, more: Value, options: Value| {
        let mut case = merged(crash("plane-strain"), &more);
        case["methods"] = json!({ "sph": merged(json!({ "spacing": 0.025 }), &options) });
        runs.insert(format!("sph {name}"), case);
    };
    run("plain", json!({}), json!({}));
    let materials = [("soil", soil()), ("elastic", elastic()), ("water", water())];
    for (name, material) in &materials {
        for scheme in [
            "leapfrog",
            "leapfrog-rates",
            "predictor-corrector",
            "position-verlet",
            "velocity-verlet",
            "verlet",
        ] {
            run(
                &format!("{name} {scheme}"),
                json!({ "materials": { "m": material } }),
                json!({ "integration": scheme }),
            );
        }
        for continuity in ["trace", "mass", "volume"] {
            run(
                &format!("{name} {continuity}"),
                json!({ "materials": { "m": material } }),
                json!({ "continuity": continuity }),
            );
        }
    }
    for kind in ["rho-rho", "corrected", "difference"] {
        run(&format!("momentum {kind}"), json!({}), json!({ "momentum": kind }));
    }
    for kind in ["compatible", "difference", "density-difference", "corrected"] {
        run(&format!("gradient {kind}"), json!({}), json!({ "velocity_gradient": kind }));
    }
    for kind in ["shepard", "mls"] {
        run(
            &format!("regularised {kind}"),
            json!({}),
            json!({ "regularisation": kind, "regularisation_steps": 5 }),
        );
        run(
            &format!("density reset {kind}"),
            json!({ "materials": { "m": water() } }),
            json!({ "continuity": "mass", "density_reset": kind, "density_reset_steps": 5 }),
        );
    }
    for kind in ["artificial-stress", "artificial-pressure"] {
        run(
            kind,
            json!({ "materials": { "m": elastic() } }),
            json!({ "tensile": { "kind": kind, "strength": 0.3, "exponent": 4 } }),
        );
    }
    for kind in ["pairwise", "interpolated", "extrapolated"] {
        for wall in ["rough", "smooth", "frictional"] {
            let mut walls = json!([{ "side": "y-min", "wall": { "kind": wall } }]);
            if wall == "frictional" {
                walls[0]["wall"]["friction_coefficient"] = json!(0.4);
            }
            run(
                &format!("wall {kind} {wall}"),
                json!({ "boundaries": walls }),
                json!({ "wall_stress": kind }),
            );
        }
    }
    let rough = json!({ "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }] });
    run("rough mirror", rough.clone(), json!({ "rough_wall": "mirror" }));
    run("wall velocity linear", rough, json!({ "wall_velocity": "linear" }));
    let smooth = json!({ "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }] });
    run("smooth particles", smooth, json!({ "smooth_wall": "particles" }));
    for kind in ["density", "rate"] {
        run(&format!("smoothing {kind}"), json!({}), json!({ "smoothing_length": kind }));
    }
    for kind in ["arithmetic", "harmonic", "geometric", "max", "min", "kernel"] {
        run(
            &format!("pairs {kind}"),
            json!({}),
            json!({ "smoothing_length": "density", "symmetrisation": kind }),
        );
    }
    run(
        "total",
        json!({ "materials": { "m": elastic() }, "gravity": [0, 0], "bodies": [block("b", &[0.1, 0.1], &[0.25, 0.2], &[0.4, -1.0])], "boundaries": [] }),
        json!({ "formulation": "total-lagrangian" }),
    );
    run("confined", json!({}), json!({ "confining": { "pressure": 100 } }));
    run(
        "extras",
        json!({ "materials": { "m": water() } }),
        json!({ "xsph": 0.3, "density_diffusion": 0.1, "continuity": "mass", "shifting": 0.1 }),
    );
    run(
        "stress diffusion",
        json!({}),
        json!({ "stress_diffusion": 0.1, "hourglass_viscosity": 0.1, "damping": 0.5 }),
    );
    run(
        "periodic",
        json!({ "domain": { "periodic": ["x"] }, "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }] }),
        json!({}),
    );
    for (name, motion) in [
        ("still", json!(null)),
        ("moving", json!({ "velocity": [0.1, 0.2], "rotation": 40, "centre": [0.2, 0] })),
    ] {
        let mut obstacle = json!({ "name": "o", "wall": { "kind": "frictional", "friction_coefficient": 0.3 },
            "shape": { "kind": "ground-line", "points": [[-1, 0.0], [0.2, -0.03], [2, 0.2]] } });
        if !motion.is_null() {
            obstacle["motion"] = motion;
        }
        run(
            &format!("obstacle {name}"),
            json!({ "domain": { "min": [0, -0.2] }, "boundaries": [], "obstacles": [obstacle] }),
            json!({}),
        );
    }
    run("ring", json!({ "space": "axisymmetric" }), json!({}));
    for space in ["1d", "3d"] {
        let mut case = crash(space);
        case["methods"] = json!({ "sph": { "spacing": 0.025 } });
        runs.insert(format!("sph {space}"), case);
    }
    for kernel in ["cubic-spline", "quintic-spline", "wendland-c2", "wendland-c4", "gaussian"] {
        let mut case = crash("plane-strain");
        case["methods"] = json!({ "sph": { "spacing": 0.025, "kernel": kernel } });
        runs.insert(format!("sph kernel {kernel}"), case);
    }
}
