//! Test that a step allocates no memory.

use colluvium_case::Case;
use colluvium_sph::Sph;
use colluvium_testkit::{CountingAllocator, assert_allocates_nothing};
use serde_json::{Value, json};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// Block that settles between a mirror and a rough floor.
fn block(space: &str, options: &Value) -> Case {
    let d = if space == "3d" { 3 } else { 2 };
    let all = |value: f64| vec![value; d];
    let (mut low, mut gravity) = (all(-0.5), all(0.0));
    (low[0], low[1], gravity[1]) = (0.0, 0.0, -1.0);
    let mut methods = json!({ "spacing": 0.1 });
    for (key, value) in options.as_object().unwrap() {
        methods[key] = value.clone();
    }
    let mut material = json!({ "model": "drucker-prager", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.3,
                               "friction_angle": 20, "cohesion": 100 });
    if methods["density_reset"].is_string() {
        material =
            json!({ "model": "newtonian-fluid", "density": 1000, "viscosity": 1, "bulk_modulus": 1e6 });
    }
    // Over the initial configuration no walls act.
    let total = methods["formulation"].is_string();
    let body = |name: &str, [bottom, top]: [f64; 2], speed: f64| {
        let (mut low, mut high, mut velocity) = (all(0.0), all(1.0), all(0.0));
        (low[1], high[1], velocity[1]) = (bottom, top, speed);
        json!({ "name": name, "material": "m", "shape": { "kind": "box", "min": low, "max": high },
                "velocity": { "kind": "uniform", "value": velocity } })
    };
    let mut bodies = vec![body("b", [0.0, 1.0], 0.0)];
    if methods["held"].is_array() {
        bodies.push(body("lid", [1.0, 1.3], -0.1));
    }
    let mut floor = json!([{ "side": "y-min", "wall": { "kind": "rough" } }, { "side": "x-min", "wall": { "kind": "smooth" } }]);
    if methods["wall_history"].is_object() {
        for wall in floor.as_array_mut().unwrap() {
            wall["velocity"] = json!(all(0.05));
        }
    }
    let text = json!({
        "title": "allocation", "space": space, "domain": { "min": low, "max": all(2.0) }, "gravity": gravity,
        "materials": { "m": material },
        "bodies": bodies,
        "boundaries": if total { json!([]) } else { floor },
        "stages": [{ "name": "s", "duration": 1, "damping": 0.1,
                     "equilibrium": { "unbalanced_force": 1e-6, "kinetic_energy": 1e-6 } }],
        "methods": { "sph": methods }
    });
    Case::from_json(&text.to_string()).unwrap()
}

// One test only, so that no other test allocates at the same time.
#[test]
fn a_step_allocates_nothing() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let tensile = json!({ "kind": "artificial-stress", "strength": 0.5, "exponent": 2.55 });
    pool.install(|| {
        for (space, options) in [
            ("plane-strain", json!({})),
            ("3d", json!({})),
            ("plane-strain", json!({ "wall_stress": "extrapolated", "tensile": tensile.clone() })),
            (
                "plane-strain",
                json!({ "integration": "velocity-verlet", "xsph": 0.5, "stress_diffusion": 0.1 }),
            ),
            ("plane-strain", json!({ "integration": "position-verlet", "velocity_gradient": "corrected" })),
            ("plane-strain", json!({ "integration": "leapfrog-rates" })),
            ("plane-strain", json!({ "integration": "predictor-corrector" })),
            ("plane-strain", json!({ "integration": "verlet" })),
            ("3d", json!({ "integration": "runge-kutta4" })),
            ("plane-strain", json!({ "shifting": 0.5 })),
            (
                "3d",
                json!({ "held": ["lid"], "smooth_bodies": ["lid"], "tensile": tensile,
                        "held_history": { "lid": { "times": [0.001, 0.01], "factors": [0, 1] } } }),
            ),
            (
                "plane-strain",
                json!({ "wall_history": { "x-min": { "times": [0.001, 0.01], "factors": [0, 1] },
                                          "y-min": { "times": [0.002], "factors": [0.5] } } }),
            ),
            ("3d", json!({ "formulation": "total-lagrangian" })),
            ("plane-strain", json!({ "smoothing_length": "rate" })),
            ("plane-strain", json!({ "momentum": "rho-rho", "confining": { "pressure": 100 } })),
            (
                "plane-strain",
                json!({ "regularisation": "mls", "regularisation_steps": 5, "kernel": "wendland-c2" }),
            ),
            (
                "plane-strain",
                json!({ "regularisation": "shepard", "regularisation_steps": 1, "hourglass_viscosity": 0.5 }),
            ),
            ("plane-strain", json!({ "smoothing_length": "density", "symmetrisation": "grad-h" })),
            (
                "plane-strain",
                json!({ "density_reset": "mls", "density_reset_steps": 2, "density_diffusion": 0.1 }),
            ),
        ] {
            assert_allocates_nothing(&Sph, &block(space, &options), 6, &format!("{space}, {options}"));
        }
    });
}
