//! Bodies of different density and stress side by side, and held bodies: smoothing, diffusion and advection
//! act within each body (sheet: sph §2.10, §2.12, §2.13).

use colluvium_case::{Case, Method};
use colluvium_constitutive::SymTensor;
use colluvium_sph::Sph;
use colluvium_sph::kernel::{Kernel, Smoothing};
use colluvium_sph::setup::rates_only::{PrescribedParticle, prepared_solver, rates};
use colluvium_testkit::{advance_steps, case_with, read_case, scalars, start_solver, stresses, vectors};
use serde_json::{Value, json};

/// Two materials that each fill half of a periodic domain; `sph` adds options.
fn halves(materials: &[Value; 2], sph: &Value) -> Case {
    let mut methods = json!({ "spacing": 0.05, "viscosity_linear": 0, "continuity": "volume" });
    for (key, value) in sph.as_object().unwrap() {
        methods[key] = value.clone();
    }
    let half = |name: &str, low: f64| {
        json!({ "name": name, "material": name,
                "shape": { "kind": "box", "min": [low, 0], "max": [low + 0.5, 0.5] } })
    };
    case_with(
        json!({
            "title": "test", "space": "plane-strain", "gravity": [0, 0],
            "domain": { "min": [0, 0], "max": [1, 0.5], "periodic": ["x", "y"] },
            "materials": { "left": materials[0], "right": materials[1] },
            "bodies": [half("left", 0.0), half("right", 0.5)],
            "stages": [{ "name": "s", "duration": 1 }]
        }),
        &json!({ "methods": { "sph": methods } }),
    )
}

fn fluid(density: f64) -> Value {
    json!({ "model": "newtonian-fluid", "density": density, "bulk_modulus": 1e5, "viscosity": 1 })
}

fn solid(density: f64) -> Value {
    json!({ "model": "linear-elastic", "density": density, "youngs_modulus": 1e6, "poissons_ratio": 0.25 })
}

const STILL: PrescribedParticle<2> = PrescribedParticle {
    displacement: [0.0; 2],
    velocity: [0.0; 2],
    compression: 1.0,
    stress: SymTensor::ZERO,
};

/// Pseudo-random number between -1 and 1 for each particle and component.
fn noise(id: u32, component: u32) -> f64 {
    2.0 * (f64::from(3 * id + component + 1) * 0.618_033_988_749_894_9).fract() - 1.0
}

#[test]
fn densities_diffuse_within_each_body_of_fluid_only() {
    let diffuses = json!({ "density_diffusion": 0.1 });
    let found = rates::<2>(&halves(&[fluid(1000.0), fluid(2000.0)], &diffuses), |_, _| STILL).unwrap();
    assert!(found.iter().all(|particle| particle.divergence == 0.0));

    let uneven =
        |id: u32, _: &[f64; 2]| PrescribedParticle { compression: 1.0 + 0.01 * noise(id, 0), ..STILL };
    let found = rates::<2>(&halves(&[fluid(1000.0), solid(1000.0)], &diffuses), uneven).unwrap();
    let (left, right): (Vec<_>, Vec<_>) = found.iter().partition(|particle| particle.position[0] < 0.5);
    assert!(right.iter().all(|particle| particle.divergence == 0.0));
    assert!(left.iter().all(|particle| particle.divergence != 0.0));
    // Σ V ρ̇ / c of pairs within the body vanishes, and c √ρ is the same everywhere.
    let rates: Vec<f64> = left.iter().map(|p| p.mass * p.divergence * p.density.sqrt()).collect();
    let (sum, size) = rates.iter().fold((0.0, 0.0), |(sum, size), rate| (sum + rate, size + rate.abs()));
    assert!(f64::abs(sum) < 1e-12 * size, "{sum:e} of {size:e}");
}

/// Between soils of 1000 and 2000 kg/m³ with the same stretching.
#[test]
fn divergence_at_a_density_jump_is_exact_with_volume_continuity_only() {
    let stretched = |_: u32, x: &[f64; 2]| PrescribedParticle { velocity: [x[0], 0.0], ..STILL };
    let of = |continuity: &str| {
        let case = halves(&[solid(1000.0), solid(2000.0)], &json!({ "continuity": continuity }));
        rates::<2>(&case, stretched).unwrap()
    };
    // M of the lattice (sheet: sph §2.2). Half of it comes from the other side, which counts double from the left and half from
    // the right in the form for masses.
    let m = 0.990_793_06;
    for (continuity, left, right) in [("volume", m, m), ("mass", 1.5 * m, 0.75 * m)] {
        for particle in of(continuity).iter().filter(|p| (p.position[0] - 0.5).abs() < 0.05) {
            let exact = if particle.position[0] < 0.5 { left } else { right };
            assert!((particle.divergence - exact).abs() < 1e-8, "{continuity}: {}", particle.divergence);
        }
    }
}

/// `v_a = v_w - min(½, d_a/d_b) (v_b - v_w)` (sheet: sph §2.13 c).
#[test]
fn linear_velocity_walls_extrapolate_by_the_ratio_of_distances() {
    let (spacing, wall, own) = (0.05, 0.3, 1.0);
    let text = serde_json::to_value(halves(&[solid(1000.0), solid(1000.0)], &json!({}))).unwrap();
    let more = json!({
        "domain": { "min": [0, 0], "max": [1, 1] },
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" }, "velocity": [wall, 0] }],
        "methods": { "sph": { "spacing": spacing, "wall_velocity": "linear", "velocity_gradient": "difference" } }
    });
    let kernel = Smoothing::<2>::new(Kernel::CubicSpline, 1.2 * spacing).unwrap();
    let sheared = |from_face: f64| -> f64 {
        let of_site = |x: i32, layer: i32| {
            let behind = (f64::from(layer) + 0.5) * spacing;
            let apart = [f64::from(x) * spacing, -(from_face + behind)];
            let opposed = (behind / from_face).min(0.5);
            let relative = (wall - opposed * (own - wall)) - own;
            spacing * spacing * kernel.gradient_factor(apart[0].hypot(apart[1])) * relative * apart[1]
        };
        (-3..=3).flat_map(|x| (0..3).map(move |layer| of_site(x, layer))).sum()
    };
    let moving = |_: u32, _: &[f64; 2]| PrescribedParticle { velocity: [own, 0.0], ..STILL };
    let found = rates::<2>(&case_with(text, &more), moving).unwrap();
    for particle in found.iter().filter(|p| (p.position[0] - 0.5).abs() < 0.2 && p.position[1] < 0.1) {
        let exact = sheared(particle.position[1]);
        assert!(exact > 0.1 && (particle.gradient[0][1] / exact - 1.0).abs() < 1e-9, "{exact} {particle:?}");
    }
}

/// State with different stresses on the left and on the right.
fn stressed(_: u32, x: &[f64; 2]) -> PrescribedParticle<2> {
    let pressure = if x[0] < 0.5 { -1e3 } else { -5e3 };
    PrescribedParticle { stress: SymTensor::isotropic(pressure), ..STILL }
}

#[test]
fn stress_does_not_diffuse_from_body_to_body() {
    let case = halves(&[solid(1000.0), solid(1000.0)], &json!({ "stress_diffusion": 0.1 }));
    let mut solver = prepared_solver::<2>(&case, stressed).unwrap();
    // Waves change stress by the square of the Courant number, diffusion by the number itself.
    let dt = 1e-6 * solver.limit().dt;
    let before = stresses(&solver.snapshot());
    solver.step(dt).unwrap();
    for (old, new) in before.iter().zip(stresses(&solver.snapshot())) {
        assert!((old[0] - new[0]).abs() < 1e-7, "{old:?} {new:?}");
    }
}

#[test]
fn shifting_carries_neither_density_nor_stress_from_body_to_body() {
    let case = halves(&[solid(1000.0), solid(2000.0)], &json!({ "shifting": 1 }));
    let given = |id: u32, x: &[f64; 2]| PrescribedParticle {
        displacement: [0.005 * noise(id, 0), 0.005 * noise(id, 1)],
        velocity: [30.0, 0.0],
        ..stressed(id, x)
    };
    let mut solver = prepared_solver::<2>(&case, given).unwrap();
    let dt = 1e-6 * solver.limit().dt;
    let before = solver.snapshot();
    (0..5).for_each(|_| {
        solver.step(dt).unwrap();
    });
    let after = solver.snapshot();
    let moved = vectors(&after, "displacement").iter().map(|u| u[1].abs()).fold(0.0, f64::max);
    assert!(moved > 1e-3 * 30.0 * dt, "{moved:e} m");
    for (old, new) in scalars(&before, "density").iter().zip(scalars(&after, "density")) {
        assert!((old - new).abs() < 1e-9 * old, "{old} {new}");
    }
    for (old, new) in stresses(&before).iter().zip(stresses(&after)) {
        assert!((old[0] - new[0]).abs() < 1e-7, "{old:?} {new:?}");
    }
}

/// Layer of 1000 kg/m³ on one of 2000 kg/m³ on a rough floor, in either order of the bodies.
fn layers(wall_stress: &str, upper_first: bool) -> Case {
    let layer = |name: &str, low: f64| {
        json!({ "name": name, "material": name,
                "shape": { "kind": "box", "min": [0, low], "max": [0.5, low + 0.5] } })
    };
    let mut bodies = vec![layer("left", 0.5), layer("right", 0.0)];
    if !upper_first {
        bodies.reverse();
    }
    let sph = json!({ "wall_stress": wall_stress });
    case_with(
        serde_json::to_value(halves(&[solid(1000.0), solid(2000.0)], &sph)).unwrap(),
        &json!({
            "domain": { "min": [0, 0], "max": [0.5, 1.5], "periodic": ["x"] }, "gravity": [0, -10], "bodies": bodies,
            "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }]
        }),
    )
}

#[test]
fn wall_particles_have_the_density_of_the_adjacent_soil() {
    let rest = |_: u32, x: &[f64; 2]| {
        let vertical = if x[1] > 0.5 { -1e4 * (1.0 - x[1]) } else { -5e3 - 2e4 * (0.5 - x[1]) };
        PrescribedParticle { stress: SymTensor::diagonal(0.5 * vertical, vertical, 0.5 * vertical), ..STILL }
    };
    for wall_stress in ["interpolated", "extrapolated"] {
        let mut found = [true, false].map(|upper_first| {
            let mut solver = prepared_solver::<2>(&layers(wall_stress, upper_first), rest).unwrap();
            let dt = 0.5 * solver.limit().dt;
            solver.step(dt).unwrap();
            let snapshot = solver.snapshot();
            let start = vectors(&snapshot, "velocity");
            let lowest = |x: &[f64; 3]| x[1] < 0.06;
            let fall = snapshot.positions.iter().zip(&start).filter(|(x, _)| lowest(x));
            let fall = fall.map(|(_, v)| v[1].abs() / (10.0 * dt)).fold(0.0, f64::max);
            // Share of gravity; the error of the lattice itself is 2 %.
            assert!(wall_stress == "interpolated" || fall < 0.05, "{fall} g");
            (0..100).for_each(|_| {
                solver.step(dt).unwrap();
            });
            let snapshot = solver.snapshot();
            let both = snapshot.positions.iter().zip(stresses(&snapshot));
            both.map(|(x, stress)| (x.map(|c| (c * 1e6).round() as i64), stress[1])).collect::<Vec<_>>()
        });
        found.iter_mut().for_each(|all| all.sort_by_key(|(place, _)| *place));
        for (a, b) in found[0].iter().zip(&found[1]) {
            assert!((a.1 - b.1).abs() < 1e-6 * a.1.abs(), "{wall_stress}: {a:?} {b:?}");
        }
    }
}

#[test]
fn held_bodies_keep_their_path_with_xsph() {
    for integration in ["leapfrog", "predictor-corrector", "velocity-verlet", "verlet", "runge-kutta4"] {
        let sph = json!({ "xsph": 0.5, "held": ["right"], "integration": integration });
        let mut text = serde_json::to_value(halves(&[solid(1000.0), solid(1000.0)], &sph)).unwrap();
        text["bodies"][1]["velocity"] = json!({ "kind": "uniform", "value": [0.3, 0.2] });
        let mut solver = start_solver(&Sph, &read_case(&text));
        advance_steps(&mut *solver, 20);
        let snapshot = solver.snapshot();
        for (body, u) in snapshot.bodies.iter().zip(vectors(&snapshot, "displacement")) {
            let off = (u[0] - 0.3 * snapshot.time).hypot(u[1] - 0.2 * snapshot.time);
            assert!(*body == 0 || off < 1e-12, "{integration}: {u:?} after {} s", snapshot.time);
        }
    }
}

/// Factor that rises, falls and becomes negative, with corners within steps.
#[test]
fn held_bodies_follow_their_velocity_history_and_are_bit_identical_after_a_restart() {
    let schemes =
        ["leapfrog", "leapfrog-rates", "predictor-corrector", "position-verlet", "velocity-verlet", "verlet"];
    for integration in schemes.into_iter().chain(["runge-kutta4"]) {
        let sph = json!({
            "held": ["right"], "smooth_bodies": ["right"], "integration": integration,
            "held_history": { "right": { "times": [0.001, 0.0035, 0.009], "factors": [0, 2, -1] } }
        });
        let mut text = serde_json::to_value(halves(&[solid(1000.0), solid(1000.0)], &sph)).unwrap();
        text["bodies"][1]["velocity"] = json!({ "kind": "uniform", "value": [0.3, 0.2] });
        let case = read_case(&text);
        let mut solver = start_solver(&Sph, &case);
        let mut restarted = start_solver(&Sph, &case);
        for passed in [0.005, 0.012] {
            while solver.time() < passed * (1.0 - 1e-12) {
                let left = passed - solver.time();
                solver.step(left).unwrap();
            }
            // Integral of the factor: 2.5e-3 to the first corner, a triangle of 11/3e-3 s and one down, then -1.
            let (t, slope) = (solver.time(), 3.0 / 5.5e-3);
            let exact = match t {
                t if t < 0.009 => 2.5e-3 + 2.0 * (t - 3.5e-3) - 0.5 * slope * (t - 3.5e-3).powi(2),
                t => 2.5e-3 + 0.5 * 5.5e-3 - (t - 9e-3),
            };
            let snapshot = solver.snapshot();
            for (body, u) in snapshot.bodies.iter().zip(vectors(&snapshot, "displacement")) {
                let off = (u[0] - 0.3 * exact).hypot(u[1] - 0.2 * exact);
                assert!(*body == 0 || off < 1e-15, "{integration}: {u:?} at {t} s, not {exact}");
            }
            restarted.restore(&mut solver.checkpoint_bytes().unwrap().as_slice()).unwrap();
            restarted.begin_stage(0, 0.0).unwrap();
        }
        for solver in [&mut solver, &mut restarted] {
            (0..5).for_each(|_| {
                solver.step(3e-4).unwrap();
            });
        }
        assert_eq!(solver.snapshot().hash(), restarted.snapshot().hash(), "{integration}");
    }
}

#[test]
fn histories_require_held_bodies_and_valid_functions_of_time() {
    let history = |times: &[f64]| json!({ "times": times, "factors": [1, 0] });
    for (name, times, path) in [
        ("left", [0.0, 1.0], "methods.sph.held_history.left"),
        ("nobody", [0.0, 1.0], "methods.sph.held_history.nobody"),
        ("right", [1.0, 1.0], "methods.sph.held_history.right.times[1]"),
    ] {
        let sph = json!({ "held": ["right"], "held_history": { name: history(&times) } });
        let error = Sph.plan(&halves(&[solid(1e3), solid(1e3)], &sph)).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{path}: ")), "{error}");
    }
}

#[test]
fn the_displacement_limit_per_step_includes_the_xsph_correction() {
    let case = halves(&[solid(1000.0), solid(1000.0)], &json!({ "xsph": 1 }));
    let dt = 1e-4;
    // A quarter of a smoothing length in the step, but the mean of alternating neighbours is almost zero.
    let alternating = |_: u32, x: &[f64; 2]| {
        let even = x.iter().map(|c| (c / 0.05).floor() as i64).sum::<i64>() % 2 == 0;
        PrescribedParticle { velocity: [0.25 * 0.06 / dt * if even { 1.0 } else { -1.0 }, 0.0], ..STILL }
    };
    let mut solver = prepared_solver::<2>(&case, alternating).unwrap();
    solver.step(dt).unwrap();
    for u in vectors(&solver.snapshot(), "displacement") {
        assert!(u[0].abs() < 0.1 * 0.06, "{u:?}");
    }
}

/// Solids of 1000 and 4000 kg/m³ that fill the domain under one stress.
#[test]
fn a_uniform_stress_rests_at_a_jump_of_density_with_rho_rho() {
    let stress = SymTensor([-1e4, -2e4, -1e4, 3e3, 0.0, 0.0]);
    let fastest = |momentum: &str| {
        let case = halves(&[solid(1000.0), solid(4000.0)], &json!({ "momentum": momentum }));
        let found = rates::<2>(&case, |_, _| PrescribedParticle { stress, ..STILL }).unwrap();
        found.iter().flat_map(|p| p.acceleration).fold(0.0, |largest: f64, a| largest.max(a.abs()))
    };
    // Relative to the stress over the lighter density and the spacing, 400 m/s².
    assert!(fastest("rho-rho") < 1e-9, "{}", fastest("rho-rho"));
    assert!(fastest("rho2") > 10.0, "{}", fastest("rho2"));
}

/// Periodic bars of two densities under one stress, in one dimension and in two, without options.
#[test]
fn a_bar_of_two_densities_at_rest_gains_no_energy() {
    let line = |ratio: f64, sph: &Value| {
        let mut text = serde_json::to_value(halves(&[solid(1000.0), solid(1000.0 * ratio)], sph)).unwrap();
        text["space"] = json!("1d");
        text["gravity"] = json!([0]);
        text["domain"] = json!({ "min": [0], "max": [1], "periodic": ["x"] });
        for (number, low) in [0.0, 0.5].into_iter().enumerate() {
            text["bodies"][number]["shape"] = json!({ "kind": "box", "min": [low], "max": [low + 0.5] });
        }
        read_case(&text)
    };
    fn share<const D: usize>(case: &Case) -> f64 {
        let stress = SymTensor::diagonal(-1e4, -1e4, -1e4);
        let given = |_: u32, _: &[f64; D]| PrescribedParticle {
            displacement: [0.0; D],
            velocity: [0.0; D],
            compression: 1.0,
            stress,
        };
        let mut solver = prepared_solver::<D>(case, given).unwrap();
        advance_steps(&mut *solver, 300);
        let budget = solver.totals();
        budget.kinetic / budget.elastic
    }
    for ratio in [2.0, 4.0] {
        let of = |sph: Value| {
            let plane = halves(&[solid(1000.0), solid(1000.0 * ratio)], &sph);
            [share::<1>(&line(ratio, &sph)), share::<2>(&plane)]
        };
        let (own, rho2) = (of(json!({})), of(json!({ "momentum": "rho2" })));
        assert!(
            own.iter().all(|share| *share < 1e-20) && rho2.iter().all(|share| *share > 1e-4),
            "{own:?} {rho2:?}"
        );
    }
}

#[test]
fn unsuitable_forms_at_a_density_jump_cause_a_warning_with_a_remedy() {
    let warnings = |densities: [f64; 2], sph: &Value| {
        let mut options = json!({ "continuity": "trace" });
        options.as_object_mut().unwrap().extend(sph.as_object().unwrap().clone());
        colluvium_testkit::lines(&Sph.plan(&halves(&densities.map(solid), &options)).unwrap().warnings)
    };
    let momentum = "methods.sph.momentum: where bodies of 1000 and 2000 kg/m³";
    let text = warnings([1000.0, 2000.0], &json!({ "momentum": "rho2" }));
    assert!(text.contains(momentum) && !text.contains("weights by mass"), "{text}");
    // The recommended option gives no warning, and the default is the recommended one.
    assert!(!warnings([1000.0, 2000.0], &json!({ "momentum": "rho-rho" })).contains("are in contact"));
    assert!(!warnings([1000.0, 2000.0], &json!({})).contains("are in contact"));
    assert!(!warnings([1000.0, 1000.0], &json!({ "momentum": "rho2" })).contains("are in contact"));
    for (key, given, cure) in
        [("continuity", "mass", "volume"), ("velocity_gradient", "density-difference", "difference")]
    {
        let with = |value: &str| warnings([1000.0, 2000.0], &json!({ "momentum": "rho-rho", key: value }));
        assert!(with(given).contains(&format!("methods.sph.{key}: where bodies of")), "{}", with(given));
        assert!(!with(cure).contains("are in contact"), "{}", with(cure));
    }
}

#[test]
fn elastic_bodies_without_a_tensile_correction_cause_a_warning() {
    let warnings = |solid: Value, sph: &Value| {
        colluvium_testkit::lines(&Sph.plan(&halves(&[solid, fluid(1000.0)], sph)).unwrap().warnings)
    };
    let of = "methods.sph.tensile: the body left is elastic";
    assert!(warnings(solid(1000.0), &json!({})).contains(of));
    let cured = json!({ "tensile": { "kind": "artificial-stress", "strength": 0.5, "exponent": 4 } });
    assert!(!warnings(solid(1000.0), &cured).contains(of));
    assert!(!warnings(fluid(1000.0), &json!({})).contains(of));
    assert!(!warnings(solid(1000.0), &json!({ "held": ["left"] })).contains(of));
    let mut rigid = halves(&[solid(1000.0), fluid(1000.0)], &json!({}));
    rigid.domain.periodic.clear();
    rigid.bodies[0].rigid = true;
    assert!(!colluvium_testkit::lines(&Sph.plan(&rigid).unwrap().warnings).contains(of));
}

/// Floor of particles that are held at rest and strain by their law, a dynamic boundary (sheet: sph §2.13 e): a column on it reaches the
/// geostatic stress, and does not penetrate. Within two supports of the floor its pressure is too high, as the sheet states.
#[test]
fn a_floor_that_is_held_carries_a_column() {
    let column = json!({ "name": "column", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.2, 0.5] } });
    let floor = json!({ "name": "floor", "material": "m", "shape": { "kind": "box", "min": [0, -0.2], "max": [0.2, 0] } });
    let wall = |side: &str| json!({ "side": side, "wall": { "kind": "smooth" } });
    let text = json!({
        "title": "column", "space": "plane-strain", "gravity": [0, -10],
        "domain": { "min": [0, -0.3], "max": [0.2, 0.6] }, "materials": { "m": solid(2000.0) },
        "bodies": [column, floor], "boundaries": [wall("x-min"), wall("x-max")],
        "stages": [{ "name": "s", "duration": 0.5 }],
        "methods": { "sph": { "spacing": 0.025, "held": ["floor"], "damping": 0.05 } }
    });
    let mut solver = start_solver(&Sph, &read_case(&text));
    while solver.time() < 0.5 {
        advance_steps(&mut *solver, 1);
    }
    let snapshot = solver.snapshot();
    let (weight, ways) = (2000.0 * 10.0 * 0.5, vectors(&snapshot, "displacement"));
    let rows = snapshot.positions.iter().zip(&ways).zip(stresses(&snapshot)).zip(&snapshot.bodies);
    for (((x, u), s), _) in rows.filter(|(_, body)| **body == 0) {
        let depth = 0.5 - (x[1] - u[1]);
        // A support is 0.06 m.
        let near = if depth > 0.5 - 0.12 { 0.1 } else { 0.03 };
        assert!((s[1] + 2000.0 * 10.0 * depth).abs() < near * weight, "{} Pa at {depth} m", s[1]);
        // Settlement ρ g (H² - d²)/(2 M) with M = 1.2 MPa, and of the upper layer of the floor.
        let settled = 2e4 * (0.25 - depth * depth) / 2.4e6;
        assert!((-u[1] - settled).abs() < 0.1 * 0.025, "{} m for {settled} at {depth}", -u[1]);
    }
}
