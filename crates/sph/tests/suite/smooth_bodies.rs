//! Held bodies with free slip along their surface (sheet: sph §2.13).

use colluvium_case::{Case, Method, Snapshot};
use colluvium_constitutive::SymTensor;
use colluvium_sph::Sph;
use colluvium_sph::setup::rates_only::{PrescribedParticle, prepared_solver, rates};
use colluvium_testkit::{advance_steps, case_with, start_solver, stresses, vectors};
use serde_json::{Value, json};

/// Block on a held plate, both periodic along x unless `more` replaces this; `sph` adds options.
fn block_on_plate(sph: &Value, more: &Value) -> Case {
    let mut methods = json!({ "spacing": 0.05, "held": ["plate"], "smooth_bodies": ["plate"] });
    for (key, value) in sph.as_object().unwrap() {
        methods[key] = value.clone();
    }
    let body = |name: &str, material: &str, low: [f64; 2], high: [f64; 2]| json!({ "name": name, "material": material, "shape": { "kind": "box", "min": low, "max": high } });
    let elastic = |density: f64, modulus: f64| json!({ "model": "linear-elastic", "density": density, "youngs_modulus": modulus, "poissons_ratio": 0.25 });
    let text = json!({
        "title": "block", "space": "plane-strain", "gravity": [0, 0],
        "domain": { "min": [0, -1], "max": [0.5, 1], "periodic": ["x"] },
        "materials": { "soil": elastic(1000.0, 1e6), "steel": elastic(7800.0, 2e8) },
        "bodies": [body("plate", "steel", [0.0, -0.2], [0.5, 0.0]), body("block", "soil", [0.0, 0.0], [0.5, 0.4])],
        "stages": [{ "name": "s", "duration": 1 }],
        "methods": { "sph": methods }
    });
    case_with(text, more)
}

/// Velocities of the block.
fn of_block(snapshot: &Snapshot) -> Vec<[f64; 3]> {
    let all = snapshot.bodies.iter().zip(vectors(snapshot, "velocity"));
    all.filter(|(body, _)| **body == 1).map(|(_, v)| v).collect()
}

#[test]
fn a_smooth_plate_slides_under_a_pressed_block_without_drag() {
    let pressure = 2e4;
    let given = |_: u32, x: &[f64; 2]| PrescribedParticle {
        displacement: [0.0; 2],
        velocity: if x[1] < 0.0 { [1.0, 0.0] } else { [0.0; 2] },
        compression: 1.0,
        stress: if x[1] < 0.0 { SymTensor::ZERO } else { SymTensor::isotropic(-pressure) },
    };
    // Between the plate and a smooth wall, so that the pressure is constant.
    let pressed = |smooth: &[&str]| {
        let mut case = block_on_plate(
            &json!({ "smooth_bodies": smooth, "damping": 0.02 }),
            &json!({ "boundaries": [{ "side": "y-max", "position": 0.4, "wall": { "kind": "smooth" } }] }),
        );
        case.bodies[0].velocity =
            serde_json::from_value(json!({ "kind": "uniform", "value": [1, 0] })).unwrap();
        let mut solver = prepared_solver::<2>(&case, given).unwrap();
        let steps = 400;
        let start = solver.time();
        (0..steps).for_each(|_| {
            let dt = solver.limit().dt;
            solver.step(dt).unwrap();
        });
        let (snapshot, passed) = (solver.snapshot(), solver.time() - start);
        let along = of_block(&snapshot).iter().map(|v| v[0]).sum::<f64>() / 80.0;
        let bodies = snapshot.bodies.iter().zip(stresses(&snapshot));
        let normal = bodies.filter(|(body, _)| **body == 1).map(|(_, s)| s[1]).sum::<f64>() / 80.0;
        (along, passed, normal)
    };
    let (along, passed, normal) = pressed(&["plate"]);
    // The plate has moved by several spacings.
    assert!(passed > 0.15, "{passed} s");
    // Tangential momentum per area over the pressure: the mean friction coefficient.
    let friction = along * 1000.0 * 0.4 / (pressure * passed);
    // The lattice of the plate acts as a corrugated surface, 1.3e-4 on average.
    assert!(friction.abs() < 1e-3, "{friction:e}");
    assert!((normal / -pressure - 1.0).abs() < 0.01, "{normal} Pa");
    let (dragged, ..) = pressed(&[]);
    assert!(dragged > 0.3, "a rough plate drags: {dragged} m/s");
}

/// On the lattice of a wall of particles a plate acts as the wall, in compression and in tension.
#[test]
fn a_smooth_plate_carries_weight_as_a_smooth_wall_of_particles_does() {
    let far = [0.0, 0.75, 0.5, 0.95];
    let carried = |plate: [f64; 4], gravity: f64, sph: &Value, boundaries: &Value| {
        let more = json!({ "gravity": [0, gravity], "boundaries": boundaries });
        let mut case = block_on_plate(sph, &more);
        let shape = json!({ "kind": "box", "min": &plate[..2], "max": &plate[2..] });
        case.bodies[0].shape = serde_json::from_value(shape).unwrap();
        let mut solver = start_solver(&Sph, &case);
        (0..300).for_each(|_| {
            solver.step(2e-4).unwrap();
        });
        let snapshot = solver.snapshot();
        let all = snapshot.bodies.iter().zip(vectors(&snapshot, "displacement")).zip(stresses(&snapshot));
        all.filter(|((body, _), _)| **body == 1).map(|((_, u), s)| (u[1], s[1])).collect::<Vec<_>>()
    };
    let wall = json!([{ "side": "y-min", "position": 0, "wall": { "kind": "smooth" } }]);
    let layers = json!({ "smooth_wall": "particles" });
    for gravity in [-10.0, 10.0] {
        let on_plate = carried([0.0, -0.2, 0.5, 0.0], gravity, &json!({}), &json!([]));
        let on_wall = carried(far, gravity, &layers, &wall);
        let largest = on_wall.iter().map(|(u, _)| u.abs()).fold(0.0, f64::max);
        assert!(largest > 1e-4, "{largest} m");
        for (a, b) in on_plate.iter().zip(&on_wall) {
            assert!((a.0 - b.0).abs() < 1e-9 * largest && (a.1 - b.1).abs() < 1e-5, "{gravity}: {a:?} {b:?}");
        }
    }
}

/// A rotated problem has the rotated solution.
#[test]
fn blocks_on_rotated_smooth_plates_have_the_rotated_solution() {
    let case = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let turn = |v: [f64; 2]| [cos * v[0] - sin * v[1], sin * v[0] + cos * v[1]];
        let mut case = block_on_plate(
            &json!({ "tensile": { "kind": "artificial-stress", "strength": 0.5, "exponent": 2.55 } }),
            &json!({ "domain": { "min": [-1.5, -1.5], "max": [1.5, 1.5] }, "gravity": turn([4.0, -10.0]) }),
        );
        case.bodies[0].velocity =
            serde_json::from_value(json!({ "kind": "uniform", "value": turn([0.3, 0.1]) })).unwrap();
        let given = |_: u32, x: &[f64; 2]| {
            let place = turn(*x);
            let velocity = if x[1] < 0.0 { turn([0.3, 0.1]) } else { turn([0.5 - x[1], -0.2]) };
            let stress = if x[1] < 0.0 { SymTensor::ZERO } else { SymTensor::isotropic(-2e3) };
            PrescribedParticle {
                displacement: [place[0] - x[0], place[1] - x[1]],
                velocity,
                compression: 1.0,
                stress,
            }
        };
        let mut solver = prepared_solver::<2>(&case, given).unwrap();
        (0..300).for_each(|_| {
            solver.step(2e-4).unwrap();
        });
        let back = |v: [f64; 3]| [cos * v[0] + sin * v[1], cos * v[1] - sin * v[0]];
        of_block(&solver.snapshot()).into_iter().map(back).collect::<Vec<_>>()
    };
    let upright = case(0.0);
    let fastest = upright.iter().map(|v| v[0].hypot(v[1])).fold(0.0, f64::max);
    assert!(fastest > 0.3, "{fastest} m/s");
    for angle in [0.4, 1.9, -2.5] {
        for (a, b) in upright.iter().zip(case(angle)) {
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9 * fastest, "{angle}: {a:?} {b:?}");
        }
    }
}

/// The power of the forces is that of the stress on the contribution of the mirrored velocities to the velocity gradient.
#[test]
fn smooth_bodies_conserve_power_and_carry_no_tangential_force() {
    let case = block_on_plate(
        &json!({ "viscosity_linear": 0, "velocity_gradient": "compatible" }),
        &json!({ "domain": { "min": [-1, -1], "max": [1, 1] } }),
    );
    let noise = |id: u32, k: f64| 2.0 * (f64::from(id + 1) * k).fract() - 1.0;
    let given = |id: u32, x: &[f64; 2]| {
        let of = |k: f64| if x[1] < 0.0 { 0.0 } else { noise(id, k) };
        PrescribedParticle {
            displacement: [0.01 * of(0.618_034), 0.005 * of(0.754_878)],
            velocity: [of(0.569_840), of(0.671_044)],
            compression: 1.0 + 0.01 * of(0.819_173),
            stress: SymTensor([of(0.3), of(0.5), of(0.7), of(0.11), 0.0, 0.0]),
        }
    };
    let found = rates::<2>(&case, given).unwrap();
    let (mut power, mut size) = (0.0, 0.0);
    for p in found.iter().filter(|p| p.mass < 5.0) {
        let pushed: f64 = (0..2).map(|c| p.mass * p.acceleration[c] * p.velocity[c]).sum();
        let strained: f64 = (0..2)
            .flat_map(|a| (0..2).map(move |b| (a, b)))
            .map(|(a, b)| p.stress.component(a, b) * p.gradient[a][b])
            .sum();
        power += pushed + p.mass / p.density * strained;
        size += pushed.abs();
    }
    assert!(power.abs() < 1e-12 * size, "{power:e} of {size:e}");
    // No forces act on the plate.
    for p in found.iter().filter(|p| p.mass > 5.0) {
        assert_eq!((p.acceleration, p.gradient), ([0.0; 2], [[0.0; 2]; 2]));
    }
}

#[test]
fn mirrors_continue_smooth_bodies() {
    // A whole plate, and half of a plate beside a mirror.
    let half = |low: f64, boundaries: &Value| {
        let shapes = json!([
            { "name": "plate", "material": "steel", "shape": { "kind": "box", "min": [low, 0.0], "max": [0.2, 0.2] },
              "velocity": { "kind": "uniform", "value": [0, -0.5] } },
            { "name": "block", "material": "soil", "shape": { "kind": "box", "min": [2.5 * low, -0.4], "max": [0.5, 0.0] } }
        ]);
        let left = if low < 0.0 { -1.0 } else { 0.0 };
        let more = json!({ "domain": { "min": [left, -1], "max": [1, 1] }, "bodies": shapes, "boundaries": boundaries });
        let mut solver = start_solver(&Sph, &block_on_plate(&json!({}), &more));
        advance_steps(&mut *solver, 60);
        let snapshot = solver.snapshot();
        let mut found: Vec<([i64; 2], [f64; 3])> = snapshot
            .positions
            .iter()
            .zip(vectors(&snapshot, "displacement"))
            .filter(|(x, u)| x[0] - u[0] > 0.0)
            .map(|(x, u)| (std::array::from_fn(|c| ((x[c] - u[c]) * 1e4).round() as i64), u))
            .collect();
        found.sort_by_key(|(place, _)| *place);
        found
    };
    let whole = half(-0.2, &json!([]));
    let beside = half(0.0, &json!([{ "side": "x-min", "wall": { "kind": "smooth" } }]));
    assert_eq!(whole.len(), beside.len());
    let largest = whole.iter().map(|(_, u)| u[0].hypot(u[1])).fold(0.0, f64::max);
    assert!(largest > 1e-3, "{largest} m");
    for (a, b) in whole.iter().zip(&beside) {
        assert!((a.1[0] - b.1[0]).hypot(a.1[1] - b.1[1]) < 1e-9 * largest, "{a:?} {b:?}");
    }
}

#[test]
fn smooth_bodies_must_be_held_and_are_refused_in_total_lagrangian_form() {
    for (sph, path, word) in [
        (json!({ "smooth_bodies": ["block"] }), "methods.sph.smooth_bodies[0]", "held"),
        (json!({ "smooth_bodies": ["plate", "nobody"] }), "methods.sph.smooth_bodies[1]", "nobody"),
        (json!({ "formulation": "total-lagrangian" }), "methods.sph.smooth_bodies", "bonded"),
    ] {
        let aperiodic = json!({ "domain": { "min": [0, -1], "max": [1, 1] } });
        let error = Sph.plan(&block_on_plate(&sph, &aperiodic)).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{path}: ")) && error.contains(word), "{error}");
    }
}
