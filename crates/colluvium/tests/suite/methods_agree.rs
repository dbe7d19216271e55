//! Agreement of methods on common cases.

use colluvium::case::{Case, Method, RunOptions, Snapshot, run};
use colluvium::depth_sph::DepthSph;
use colluvium::mpm::Mpm;
use colluvium::snow_mpm::SnowMpm;
use colluvium::sph::Sph;
use colluvium_testkit::with_keys;
use serde_json::{Value, json};

/// Snapshot of a ball of snow that turns, stretches and flies, after 120 steps with cubic functions and stress last.
fn flown(method: &dyn Method, snow: &Value, mpm: &Value) -> Snapshot {
    let common = json!({
        "title": "flight", "space": "plane-strain", "domain": { "min": [0, 0], "max": [2, 2] }, "gravity": [0.5, -9.81],
        "materials": { "snow": {
            "model": "cohesive-cam-clay", "density": 400, "youngs_modulus": 3e6, "poissons_ratio": 0.3,
            "critical_state_slope": 1.2, "cohesion_ratio": 1, "hardening_factor": 1, "compressive_strength": 8000 } },
        "bodies": [{ "name": "ball", "material": "snow", "shape": { "kind": "ball", "centre": [1, 1], "radius": 0.3 },
            "velocity": { "kind": "linear", "value": [0.3, 0.1], "origin": [1, 1], "gradient": [[-0.8, -4], [4, -0.5]] } }],
        "stages": [{ "name": "fly", "duration": 1 }],
        "methods": {
            "snow-mpm": with_keys(json!({ "cell_size": 0.1, "time_step": 2e-4 }), snow),
            "mpm": with_keys(json!({ "cell_size": 0.1, "time_step": 2e-4, "shape": "cubic", "stress_update": "usl",
                "node_mass_cutoff": 1e-14, "volume_cap": 1e9 }), mpm)
        }
    });
    let mut solver = method.build(&Case::from_json(&common.to_string()).unwrap()).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    for _ in 0..120 {
        solver.step(2e-4).unwrap();
    }
    solver.snapshot()
}

#[test]
fn mpm_and_snow_mpm_agree_to_round_off() {
    for (snow, mpm) in [
        (json!({ "transfer": "apic" }), json!({ "transfer": "apic" })),
        (json!({ "transfer": "flip", "flip_ratio": 0.98 }), json!({ "transfer": "flip", "flip": 0.98 })),
    ] {
        let (ours, theirs) = (flown(&SnowMpm, &snow, &mpm), flown(&Mpm, &snow, &mpm));
        assert_eq!(ours.ids, theirs.ids);
        let gap = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let places = gap(ours.positions.as_flattened(), theirs.positions.as_flattened());
        let (own, other) = (ours.vectors("velocity").unwrap(), theirs.vectors("velocity").unwrap());
        let speeds = gap(own.as_flattened(), other.as_flattened());
        let stresses = |snapshot: &Snapshot| -> Vec<[f64; 6]> {
            snapshot.tensors("stress").unwrap().iter().map(|s| s.0).collect()
        };
        let (own, other) = (stresses(&ours), stresses(&theirs));
        let largest = other.as_flattened().iter().fold(0.0f64, |largest, s| largest.max(s.abs()));
        let stress_gap = gap(own.as_flattened(), other.as_flattened()) / largest;
        assert!(largest > 1000.0, "there is something to compare: {largest} Pa");
        assert!(
            places < 1e-12 && speeds < 1e-12 && stress_gap < 1e-12,
            "{snow}: {places} m {speeds} m/s {stress_gap}"
        );
    }
}

/// One file with a pore fluid over a drained base: a two-phase model in depth and a depth-integrated flow have equal weight, and both move.
#[test]
fn a_case_with_pore_fluid_runs_in_depth_and_over_the_depth() {
    let value = json!({
        "title": "saturated column", "space": "plane-strain", "gravity": [0, -9.81],
        "domain": { "min": [0, 0], "max": [12, 3] },
        "materials": { "sand": {
            "model": "mohr-coulomb", "density": 1590, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "column", "material": "sand", "shape": { "kind": "box", "min": [0, 0], "max": [4, 2] },
            "stress": { "kind": "k0", "surface": 2, "coefficient": 0.5 },
            "pore_fluid": { "porosity": 0.4, "permeability": 1e-3, "bulk_modulus": 2e7,
                "pressure": { "kind": "hydrostatic", "surface": 2 } } }],
        "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }, { "side": "y-min", "drained": true, "wall": { "kind": "rough" } }],
        "stages": [{ "name": "release", "duration": 0.1 }],
        "methods": { "mpm": { "cell_size": 0.25 }, "depth-sph": { "spacing": 0.1, "phases": "two", "column": {} } }
    });
    let case = Case::from_json(&value.to_string()).unwrap();
    let notes = DepthSph.plan(&case).unwrap().warnings;
    assert!(
        notes
            .iter()
            .any(|note| note.text.contains("bulk_modulus: is ignored, because the pore fluid of depth-sph")),
        "{notes:?}"
    );
    for method in [&Mpm as &dyn Method, &DepthSph] {
        let mut solver = method.build(&case).unwrap();
        solver.begin_stage(0, 0.0).unwrap();
        let (name, mass) = (method.name(), solver.totals().mass);
        assert!((mass / (8.0 * 1990.0) - 1.0).abs() < 1e-9, "{name}: {mass} kg");
        while solver.time() < 0.1 {
            solver.step(0.1 - solver.time()).unwrap();
        }
        let totals = solver.totals();
        assert!(totals.kinetic > 0.0 && totals.momentum[0] > 0.0, "{name}: it spreads");
    }
}

/// Columns of the motion at the end of a rigid box of 0.24 m × 0.16 m × 0.08 m in space that spins, or lies on a floor under gravity along
/// a slope.
fn tumbled(method: &dyn Method, more: &Value) -> Vec<f64> {
    let case = with_keys(
        json!({
            "title": "tumble", "space": "3d", "domain": { "min": [-0.4, -0.4, -0.04], "max": [0.8, 0.4, 0.76] }, "gravity": [0, 0, 0],
            "materials": { "rock": { "model": "linear-elastic", "density": 2000, "youngs_modulus": 1e6, "poissons_ratio": 0.2 } },
            "bodies": [{ "name": "box", "material": "rock", "rigid": true,
                         "shape": { "kind": "box", "min": [-0.12, -0.08, -0.04], "max": [0.12, 0.08, 0.04] } }],
            "stages": [{ "name": "s", "duration": 0.2, "motions": [{ "target": "box", "velocity": [null, null, null], "turns": true }] }],
            "output": { "measures": 0.01 },
            "methods": { "sph": { "spacing": 0.02, "time_step": 2e-4 }, "mpm": { "cell_size": 0.04, "time_step": 2e-4 } }
        }),
        more,
    );
    let case = Case::from_json(&case.to_string()).unwrap();
    let report = run(&case, method.build(&case).unwrap(), &RunOptions::default()).unwrap();
    let columns = ["velocity.x", "velocity.y", "velocity.z", "spin.x", "spin.y", "spin.z"];
    columns.map(|name| *report.table.column(&format!("box.{name}")).unwrap().last().unwrap()).to_vec()
}

#[test]
fn rigid_boxes_of_sph_and_mpm_have_equal_motion_in_space() {
    let gradient = [[0, -6, 3], [6, 0, -5], [-3, 5, 0]];
    let spinning = json!({ "name": "box", "material": "rock", "rigid": true,
        "velocity": { "kind": "linear", "value": [0.3, 0.2, 0.8], "origin": [0, 0, 0.2], "gradient": gradient },
        "shape": { "kind": "box", "min": [-0.12, -0.08, 0.16], "max": [0.12, 0.08, 0.24] } });
    let flight = json!({ "gravity": [0.5, 0, -1], "bodies": [spinning] });
    let both = [&Sph as &dyn Method, &Mpm].map(|method| tumbled(method, &flight));
    for (sph, mpm) in both[0].iter().zip(&both[1]) {
        // Each method is of second order in the step of 2e-4 s.
        assert!((sph - mpm).abs() < 1e-5, "{both:?}");
    }
    let turned = [5.0, 3.0, 6.0].iter().zip(&both[0][3..]).map(|(start, end)| (start - end).abs());
    assert!(turned.fold(0.0, f64::max) > 0.5, "its spin wanders: {both:?}");
    for friction in [0.0, 0.3] {
        let wall = if friction > 0.0 {
            json!({ "kind": "frictional", "friction_coefficient": friction })
        } else {
            json!({ "kind": "smooth" })
        };
        let motion = json!({ "target": "box", "velocity": [null, null, null], "turns": true });
        let stage = json!({ "name": "s", "duration": 0.3, "gravity_ramp": 0.05, "motions": [motion] });
        let slope = json!({ "gravity": [4, 0, -8], "boundaries": [{ "side": "z-min", "wall": wall }], "stages": [stage] });
        let exact = (4.0 - 8.0 * friction) * (0.3 - 0.5 * 0.05);
        for method in [&Sph as &dyn Method, &Mpm] {
            let motion = tumbled(method, &slope);
            assert!((motion[0] / exact - 1.0).abs() < 0.02, "{} {motion:?} {exact}", method.name());
            assert!(motion[3..].iter().all(|spin| spin.abs() < 0.05), "{} {motion:?}", method.name());
        }
    }
}
