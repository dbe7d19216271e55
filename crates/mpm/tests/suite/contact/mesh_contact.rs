//! Contact of bodies in triangles and tetrahedra (sheet: mpm §2.12, A-13, A-14).

use colluvium_case::{Case, Method, RunReport};
use colluvium_mpm::Mpm;
use colluvium_testkit::{read_case, solve, start_solver, vectors};
use serde_json::{Value, json};

/// Mean of a component of a field over a body.
fn mean(report: &RunReport, field: &str, body: u32, component: usize) -> f64 {
    let values = vectors(&report.snapshot, field);
    let of_body = values.iter().zip(&report.snapshot.bodies).filter(|(_, b)| **b == body);
    let (sum, count) = of_body.fold((0.0, 0.0), |(sum, count), (v, _)| (sum + v[component], count + 1.0));
    sum / count
}

/// Two blocks that meet askew, in the plane or in space.
fn blocks(dimension: usize) -> Case {
    let vector = |values: [f64; 3]| values[..dimension].to_vec();
    let block = |name: &str, min: [f64; 3], max: [f64; 3], velocity: [f64; 3]| {
        json!({ "name": name, "material": "m", "shape": { "kind": "box", "min": vector(min), "max": vector(max) },
                "velocity": { "kind": "uniform", "value": vector(velocity) } })
    };
    let text = json!({
        "title": "blocks", "space": if dimension == 2 { "plane-strain" } else { "3d" },
        "domain": { "min": vector([0.0; 3]), "max": vector([2.0, 1.0, 1.0]) }, "gravity": vector([0.0; 3]),
        "materials": { "m": { "model": "neo-hookean", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 } },
        "bodies": [block("a", [0.5, 0.3, 0.3], [0.9, 0.7, 0.7], [2.0, 0.3, -0.2]),
                   block("b", [1.0, 0.4, 0.2], [1.4, 0.8, 0.6], [-1.0, 0.0, 0.1])],
        "stages": [{ "name": "s", "duration": 0.1 }],
        "methods": { "mpm": { "cell_size": 0.1, "shape": "linear", "mesh": { "kind": "box" },
                              "contacts": [{ "bodies": ["a", "b"], "friction_coefficient": 0.3 }] } }
    });
    read_case(&text)
}

#[test]
fn contact_conserves_momentum_and_is_bit_identical_on_any_threads() {
    for dimension in [2, 3] {
        let case = blocks(dimension);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| solve(&Mpm, &case))
        };
        let report = on(1);
        assert_eq!(report.snapshot.hash(), on(2).snapshot.hash());
        for c in 0..3 {
            let change = report.end.momentum[c] - report.start.momentum[c];
            assert!(change.abs() < 1e-12 * report.start.mass, "{dimension}: {change}");
        }
        // They have met, and parted.
        let speed = |body| mean(&report, "velocity", body, 0);
        assert!(speed(0) < 0.5 && speed(1) > 0.5, "{dimension}: {} and {}", speed(0), speed(1));
    }
}

#[test]
fn a_restored_solver_continues_bit_identically() {
    let case = blocks(2);
    let whole = {
        let mut solver = start_solver(&Mpm, &case);
        (0..150).for_each(|_| {
            solver.step(2e-4).unwrap();
        });
        solver
    };
    let mut rest = {
        let mut solver = start_solver(&Mpm, &case);
        (0..60).for_each(|_| {
            solver.step(2e-4).unwrap();
        });
        let mut other = start_solver(&Mpm, &case);
        other.restore(&mut solver.checkpoint_bytes().unwrap().as_slice()).unwrap();
        other.begin_stage(0, 0.0).unwrap();
        other
    };
    (0..90).for_each(|_| {
        rest.step(2e-4).unwrap();
    });
    assert_eq!(whole.snapshot().hash(), rest.snapshot().hash());
}

/// A block on a base under a weight that leans by 30 degrees, coefficient of friction `friction`.
fn incline(friction: f64) -> Case {
    let contact = json!({ "bodies": ["base", "block"], "friction_coefficient": friction, "normal": [0, 1] });
    let text = json!({
        "title": "incline", "space": "plane-strain", "domain": { "min": [0, 0], "max": [3, 1.2] },
        "gravity": [4.905, -8.495709211125343],
        "materials": { "rock": { "model": "linear-elastic", "density": 1500, "youngs_modulus": 1e7, "poissons_ratio": 0 } },
        "bodies": [{ "name": "base", "material": "rock", "shape": { "kind": "box", "min": [0, 0], "max": [3, 0.4] } },
                   { "name": "block", "material": "rock", "shape": { "kind": "box", "min": [1, 0.4], "max": [2, 0.8] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } },
                       { "side": "x-min", "wall": { "kind": "smooth" } },
                       { "name": "end", "side": "x-max", "wall": { "kind": "smooth" } },
                       { "name": "stop", "side": "x-max", "position": 2.0, "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "settle", "duration": 0.5, "damping": 0.5, "gravity_ramp": 0.2, "reset": ["velocity", "displacement"] },
                   { "name": "slide", "duration": 0.3, "damping": 0.1, "damping_axes": [1], "remove_boundaries": ["stop"] }],
        "methods": { "mpm": { "cell_size": 0.1, "shape": "linear", "courant": 0.4, "mesh": { "kind": "box" }, "contacts": [contact] } }
    });
    read_case(&text)
}

#[test]
fn sliding_and_sticking_on_an_incline_follow_coulomb_friction() {
    // A-14, with the normal of the interface given, as in the sheet: 3 % of g sin θ, and 5 mm where it sticks.
    for friction in [0.2, 0.7] {
        let report = solve(&Mpm, &incline(friction));
        let exact = (4.905 - friction * 8.495_709_211_125_343f64).max(0.0);
        if exact > 0.0 {
            let rate = mean(&report, "velocity", 1, 0) / 0.3;
            assert!((rate - exact).abs() < 0.03 * 4.905, "{friction}: {rate} for {exact}");
        } else {
            let displacement = mean(&report, "displacement", 1, 0);
            assert!(displacement.abs() < 5e-3, "{friction}: {displacement}");
        }
    }
}

#[test]
fn contact_gap_options_on_meshes_are_refused_by_name() {
    let mut text: Value = serde_json::from_str(&blocks(2).to_json()).unwrap();
    text["methods"]["mpm"]["contacts"][0]["test"] = json!("gap");
    let error = Mpm.plan(&read_case(&text)).unwrap_err().to_string();
    assert!(error.starts_with("methods.mpm.contacts[0].test: gap needs a structured grid"), "{error}");
}
