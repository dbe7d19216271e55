//! Loads on surfaces against closed forms.

use std::f64::consts::PI;

use colluvium_case::{Case, Method};
use colluvium_sph::Sph;
use colluvium_testkit::{case_with, read_case, solve, stresses};
use serde_json::{Value, json};

const RADIUS: f64 = 0.5;

/// Stiff disk of 1000 kg/m³ that rotates at `spin` (1/s), under a load and without contacts.
fn disk(spin: f64, load: &Value, options: &Value) -> Case {
    let mut load = load.clone();
    (load["kind"], load["body"]) = (json!("surface"), json!("b"));
    let mut sph = json!({ "spacing": 0.05, "viscosity_linear": 0.1 });
    options.as_object().unwrap().iter().for_each(|(key, value)| sph[key] = value.clone());
    case_with(
        json!({
            "title": "disk", "space": "plane-strain",
            "domain": { "min": [-1, -1], "max": [1, 1] }, "gravity": [0, 0],
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.25 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "ball", "centre": [0, 0], "radius": RADIUS },
                "velocity": { "kind": "linear", "value": [0, 0], "origin": [0, 0], "gradient": [[0, -spin], [spin, 0]] } }],
            "stages": [{ "name": "s", "duration": 0.1 }],
            "methods": { "sph": sph }
        }),
        &json!({ "loads": [load] }),
    )
}

/// The resultant of a pressure on the right half is the pressure times the width, and rotates with the disk.
#[test]
fn a_pressure_on_a_part_of_a_surface_rotates_with_the_body() {
    let spin = 10.0;
    let right = json!({ "kind": "box", "min": [0, -1], "max": [1, 1] });
    for options in [json!({}), json!({ "formulation": "total-lagrangian" })] {
        let report = solve(&Sph, &disk(spin, &json!({ "pressure": 100, "within": right }), &options));
        let force = 100.0 * 2.0 * RADIUS;
        let angle: f64 = spin * 0.1;
        let exact = [-force / spin * angle.sin(), -force / spin * (1.0 - angle.cos())];
        for c in 0..2 {
            let found = report.end.momentum[c];
            assert!(
                (found - exact[c]).abs() < 0.02 * force * 0.1,
                "{options}: {:?} for {exact:?}",
                report.end.momentum
            );
        }
    }
}

/// A shear all around has no resultant, and a moment of 2 π R² τ; it acts up to half a spacing within the circle.
#[test]
fn shear_around_a_disk_gives_its_moment_and_no_resultant() {
    let report = solve(&Sph, &disk(0.0, &json!({ "shear": 100 }), &json!({})));
    let exact = 2.0 * PI * RADIUS * RADIUS * 100.0 * 0.1;
    let ratio = report.end.angular_momentum[2] / exact;
    assert!((0.93..1.0).contains(&ratio), "{ratio}");
    assert!(report.end.momentum.iter().all(|p| p.abs() < 1e-9), "{:?}", report.end.momentum);
}

/// Under a slowly increasing pressure all around, the internal stress is that pressure, in plane strain; the sums of the outermost
/// particles are too small, less so with smaller particles.
#[test]
fn uniform_pressure_on_all_sides_equals_the_internal_stress() {
    let error = |spacing: f64| {
        let load = json!({ "pressure": 1e4, "ramp": 0.06, "ramp_shape": "cosine" });
        let disk = disk(0.0, &load, &json!({ "spacing": spacing }));
        let mut text: Value = serde_json::from_str(&disk.to_json()).unwrap();
        text["stages"] = json!([{ "name": "s", "duration": 0.1, "damping": 0.3 }]);
        let snapshot = solve(&Sph, &read_case(&text)).snapshot;
        let within = |x: &[f64; 3]| x[0].hypot(x[1]) < 0.5 * RADIUS;
        let inner: Vec<[f64; 6]> = (snapshot.positions.iter().zip(stresses(&snapshot)))
            .filter_map(|(x, stress)| within(x).then_some(stress))
            .collect();
        let off = [(0, -1e4), (1, -1e4), (2, -5e3)].map(|(c, exact): (usize, f64)| {
            let mean = inner.iter().map(|stress| stress[c]).sum::<f64>() / inner.len() as f64;
            (mean / exact - 1.0).abs()
        });
        off.into_iter().fold(0.0, f64::max)
    };
    let [coarse, fine] = [0.05, 0.025].map(error);
    assert!(coarse < 0.08 && fine < 0.6 * coarse, "{coarse} and {fine}");
}

/// A traction on the side of a column of 1 m causes the same stress in the whole column.
#[test]
fn stress_in_a_column_equals_the_traction_on_its_top() {
    let case = case_with(
        json!({
            "title": "block", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 2] }, "gravity": [0, 0],
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] } }],
            "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "x-min", "wall": { "kind": "smooth" } },
                           { "side": "x-max", "wall": { "kind": "smooth" } }],
            "stages": [{ "name": "s", "duration": 0.4, "damping": 0.3 }],
            "methods": { "sph": { "spacing": 0.05 } }
        }),
        &json!({ "loads": [{ "kind": "traction", "body": "b", "side": "y-max", "value": [0, -1e3], "ramp": 0.2, "ramp_shape": "cosine" }] }),
    );
    let snapshot = solve(&Sph, &case).snapshot;
    for (x, stress) in
        snapshot.positions.iter().zip(stresses(&snapshot)).filter(|(x, _)| x[1] > 0.2 && x[1] < 0.8)
    {
        assert!((stress[1] / -1e3 - 1.0).abs() < 0.03, "{stress:?} at {x:?}");
    }
}

/// A load is refused where no particle is near the selected surface, and where no body can move.
#[test]
fn loads_without_particles_are_refused() {
    let far = json!({ "kind": "box", "min": [-0.1, -0.1], "max": [0.1, 0.1] });
    let error = Sph.build(&disk(0.0, &json!({ "pressure": 1, "within": far }), &json!({}))).err().unwrap();
    assert!(error.to_string().contains("loads[0].within"), "{error}");
    let mut text: Value =
        serde_json::from_str(&disk(0.0, &json!({ "pressure": 1 }), &json!({ "held": ["b"] })).to_json())
            .unwrap();
    let mut other = text["bodies"][0].clone();
    (other["name"], other["shape"]["centre"], other["shape"]["radius"]) =
        (json!("other"), json!([0.8, 0.8]), json!(0.1));
    text["bodies"] = json!([text["bodies"][0], other]);
    let error = Sph.build(&read_case(&text)).err().unwrap();
    assert!(error.to_string().contains("loads[0].body"), "{error}");
}
