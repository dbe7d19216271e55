//! Bodies filled in layers and by dropping, and the reports on them (sheet: dem §3.8).

use colluvium_case::{Method, RunOptions, Solver, run_method};
use colluvium_dem::{Dem, Specimen, disks};
use colluvium_testkit::{assert_near, read_case, refusal};
use serde_json::{Value, json};

use crate::single_grains::{Scene, linear};

/// Box of 1 m by 0.6 m with this fill of grains of 18 to 30 mm.
fn filled(fill: &Value) -> Value {
    let mut value = Scene::new(linear(1e6, 0.3, 0.5, 0.5)).disk([0.0; 2], 0.5, [0.0; 2], 0.0).json();
    value["domain"] = json!({ "min": [0, 0], "max": [1, 1] });
    value["gravity"] = json!([0, -9.81]);
    value["bodies"] = json!([{ "name": "sand", "material": "grain", "shape": { "kind": "box", "min": [0, 0], "max": [1, 0.6] } }]);
    value["boundaries"] = json!([{ "side": "y-min", "wall": { "kind": "rough" } }]);
    value["methods"]["dem"]["bodies"] = json!({});
    value["methods"]["dem"]["grains"] = json!({ "grain": { "density": 2500, "fill": fill,
        "diameter": { "distribution": "uniform", "min": 0.018, "max": 0.03 } } });
    value["stages"][0]["duration"] = json!(1e-3);
    value
}

fn only(value: &Value) -> Specimen {
    let solver = disks(&read_case(value)).unwrap();
    let [specimen] = solver.specimens() else { panic!("{:?}", solver.specimens()) };
    specimen.clone()
}

#[test]
fn layered_specimens_have_the_requested_porosity_and_are_homogeneous() {
    let layers = |first: f64| json!({ "kind": "layers", "solid_fraction": 0.78, "layers": 5, "first_solid_fraction": first });
    let value = filled(&layers(0.7));
    let specimen = only(&value);
    assert_near(specimen.porosity, 0.22, 1e-9);
    assert_eq!(specimen.requested_porosity, Some(1.0 - 0.78));
    assert!(specimen.coordination > 0.5 && specimen.coordination < 4.5, "{specimen}");
    let solver = disks(&read_case(&value)).unwrap();
    // Sheet: dem §3.8: uniform below 0.05.
    let even = solver.void_ratio_bands([0.0, 1.0], [0.03, 0.57], 9).unwrap();
    assert!(even.variance < 0.05, "{even:?}");
    let again = disks(&read_case(&value)).unwrap();
    assert_eq!(solver.snapshot().hash(), again.snapshot().hash());
    let mut other = value.clone();
    other["methods"]["dem"]["seed"] = json!(5);
    assert_ne!(solver.snapshot().hash(), disks(&read_case(&other)).unwrap().snapshot().hash());
    for (fill, path) in [
        (
            layers(0.8),
            "methods.dem.grains.grain.fill.first_solid_fraction: 0.8 must not be above solid_fraction, 0.78",
        ),
        (layers(0.0), "methods.dem.grains.grain.fill.first_solid_fraction: 0 is not in 0..1"),
        (
            json!({ "kind": "layers", "solid_fraction": 0.78, "layers": 0, "first_solid_fraction": 0.7 }),
            "methods.dem.grains.grain.fill.layers: 0 is not in 1..=100",
        ),
        (
            json!({ "kind": "layers", "solid_fraction": 0.78, "layers": 60, "first_solid_fraction": 0.7 }),
            "bodies[0].shape: layer 1: ",
        ),
    ] {
        let error = refusal(&Dem, &filled(&fill));
        assert!(error.starts_with(path), "{error}");
    }
}

#[test]
fn dropped_grains_rest_on_two_others_each_and_fill_the_shape() {
    let mut value = filled(&json!({ "kind": "drop-and-roll" }));
    let specimen = only(&value);
    // Two supports each, of which some are the sides and the floor.
    assert!(specimen.coordination > 3.3 && specimen.coordination <= 4.0, "{specimen}");
    assert!((0.17..0.28).contains(&specimen.porosity) && specimen.requested_porosity.is_none(), "{specimen}");
    // Cut to another shape, the grains are those inside it.
    value["bodies"][0]["shape"] = json!({ "kind": "ball", "centre": [0.5, 0.5], "radius": 0.3 });
    let cut = disks(&read_case(&value)).unwrap();
    let snapshot = cut.snapshot();
    let radii = snapshot.scalars("radius").unwrap();
    for (x, r) in snapshot.positions.iter().zip(radii) {
        assert!((x[0] - 0.5).hypot(x[1] - 0.5) + r < 0.3 + 0.01, "{x:?}");
    }
}

#[test]
fn round_bodies_are_filled_to_their_wall() {
    let mut value = filled(&json!({ "kind": "random", "solid_fraction": 0.7 }));
    value["bodies"][0]["shape"] = json!({ "kind": "ball", "centre": [0.5, 0.4], "radius": 0.2 });
    let specimen = only(&value);
    assert!((specimen.porosity - 0.3).abs() < 1e-9, "{specimen}");
    value["space"] = json!("3d");
    value["domain"] = json!({ "min": [0, 0, 0], "max": [1, 1, 1] });
    value["gravity"] = json!([0, 0, -9.81]);
    value["boundaries"] = json!([]);
    value["methods"]["dem"]["grains"]["grain"]["diameter"] =
        json!({ "distribution": "uniform", "min": 0.05, "max": 0.07 });
    let [base, radius, height] = [0.2, 0.3, 0.5];
    for (kind, first) in [("random", 0.0), ("layers", 0.45)] {
        value["bodies"][0]["shape"] = json!({ "kind": "cylinder", "base": [0.5, 0.4, base], "axis": 2, "radius": radius, "height": height });
        let mut fill = json!({ "kind": kind, "solid_fraction": 0.5 });
        if kind == "layers" {
            (fill["layers"], fill["first_solid_fraction"]) = (json!(2), json!(first));
        }
        value["methods"]["dem"]["grains"]["grain"]["fill"] = fill;
        let solver = colluvium_dem::spheres(&read_case(&value)).unwrap();
        let specimen = &solver.specimens()[0];
        assert!((specimen.porosity - 0.5).abs() < 1e-9, "{kind}: {specimen}");
        let snapshot = solver.snapshot();
        let radii = snapshot.scalars("radius").unwrap();
        let mut rim = 0;
        for (x, r) in snapshot.positions.iter().zip(radii) {
            let out = (x[0] - 0.5).hypot(x[1] - 0.4) + r - radius;
            assert!(out < 1e-9 && x[2] - r > base - 1e-9 && x[2] + r < base + height + 1e-9, "{kind}: {x:?}");
            rim += usize::from(out > -0.02 * r);
        }
        // About as many as there are beside a wall.
        assert!(rim > radii.len() / 10, "{kind}: {rim} of {} grains at the wall", radii.len());
    }
}

#[test]
fn dropped_spheres_rest_on_three_others_each() {
    let mut value = filled(&json!({ "kind": "drop-and-roll" }));
    value["space"] = json!("3d");
    value["domain"] = json!({ "min": [0, 0, 0], "max": [1, 1, 1] });
    value["gravity"] = json!([0, 0, -9.81]);
    value["boundaries"] = json!([]);
    value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [0, 0, 0], "max": [0.8, 0.8, 0.8] });
    let sizes = |largest: f64| json!({ "distribution": "uniform", "min": 0.8 * largest, "max": largest });
    value["methods"]["dem"]["grains"]["grain"]["diameter"] = sizes(0.1);
    let solver = colluvium_dem::spheres(&read_case(&value)).unwrap();
    let specimen = &solver.specimens()[0];
    // Three supports each, of which some are the sides and the floor; 0.582 without sides (Visscher and Bolsterli 1972).
    assert!(specimen.coordination > 4.0 && specimen.coordination <= 6.0, "{specimen}");
    assert!((0.42..0.56).contains(&specimen.porosity) && specimen.requested_porosity.is_none(), "{specimen}");
    value["methods"]["dem"]["grains"]["grain"]["diameter"] = sizes(0.14);
    let error = colluvium_dem::spheres(&read_case(&value)).err().unwrap().to_string();
    assert!(error.starts_with("bodies[0].shape: is 0.8 m wide along x, less than six"), "{error}");
}

#[test]
fn a_run_notes_porosity_and_coordination_and_a_plan_warns_of_deviations() {
    let mut value = filled(&json!({ "kind": "random", "solid_fraction": 0.7 }));
    let plan = Dem.plan(&read_case(&value)).unwrap();
    assert!(!plan.warnings.iter().any(|note| note.text.contains("requested")), "{:?}", plan.warnings);
    let options = RunOptions { method: "dem".into(), ..RunOptions::default() };
    let report = run_method(&Dem, &read_case(&value), &options).unwrap();
    let note = report.notes.iter().find(|note| note.text.contains("porosity")).unwrap();
    assert!(
        note.text.starts_with("at the start, body \"sand\": ")
            && note.text.contains("porosity 0.3000 (0.3000 requested), "),
        "{note}"
    );
    // Grains that would protrude from a triangle are left out: it is looser than requested.
    value["bodies"][0]["shape"] =
        json!({ "kind": "polygon", "vertices": [[0.4, 0.1], [0.6, 0.1], [0.5, 0.3]] });
    let plan = Dem.plan(&read_case(&value)).unwrap();
    let off = plan.warnings.iter().find(|note| note.text.contains("(0.3000 requested)")).unwrap();
    assert!(off.text.contains("are left out"), "{off}");
}

#[test]
fn mass_of_a_plan_is_that_of_the_grains_without_a_warning_for_voids() {
    let case = read_case(&filled(&json!({ "kind": "random", "solid_fraction": 0.7 })));
    let plan = Dem.plan(&case).unwrap();
    // The material has a density of 1 kg/m³, the grains 2500 kg/m³ on 0.7 of 0.6 m².
    assert_near(plan.masses(&case)[0], 2500.0 * 0.7 * 0.6, 1e-9);
    let warnings = plan.all_warnings(&case);
    assert!(!warnings.iter().any(|said| said.text.contains("% of its volume")), "{warnings:?}");
}

#[test]
fn grains_with_large_overlap_under_their_weight_cause_a_warning() {
    let warning = |pair: &Value| {
        let mut value = filled(&json!({ "kind": "random", "solid_fraction": 0.7 }));
        value["methods"]["dem"]["pairs"][0]["normal"] = pair.clone();
        let warnings = Dem.plan(&read_case(&value)).unwrap().warnings;
        warnings.into_iter().find(|said| said.text.starts_with("methods.dem.pairs: the weight of the body"))
    };
    let spring = |stiffness: f64| json!({ "law": "linear", "stiffness": stiffness, "damping_ratio": 0.3 });
    // 2500 kg/m³ on 0.7 of 0.6 m weigh 10.3 kPa: that over the stiffness is the share.
    let soft = warning(&spring(1e5)).unwrap();
    assert!(
        soft.text.contains("of about 10.") && soft.text.contains("for overlaps of 0.1 %, make contacts "),
        "{soft}"
    );
    assert_eq!(warning(&spring(2e6)), None);
    // 10.3 kPa times 24 mm on disks with E* of 55 MPa and 6 mm: (0.75 · 247 / (55e6 · 0.0775))^(2/3) = 1.24 mm.
    let ball = |modulus: f64| json!({ "law": "hertz", "youngs_modulus": modulus, "poissons_ratio": 0.3, "restitution": 0.5 });
    let soft = warning(&ball(1e8)).unwrap();
    // 51 times smaller overlaps: 51^(3/2) times the modulus.
    assert!(soft.text.contains("of about 5.1 %") && soft.text.contains("make contacts 36"), "{soft}");
    assert_eq!(warning(&ball(1e10)), None);
}
