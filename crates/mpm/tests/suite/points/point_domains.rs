//! Domains of points: their size, the axis, points that leave, and points that are compressed to nothing.

use colluvium_case::{Method, RunOptions, RunReport, run};
use colluvium_mpm::Mpm;
use colluvium_testkit::{read_case, solve, with_keys};
use serde_json::{Value, json};

use crate::solver::elastic_block;

#[test]
fn points_that_leave_a_body_with_remove_outside_are_removed() {
    // A dry block slides out of a smooth channel at 1 m/s: after 0.45 s half of it is beyond the end. On a mesh and with pore
    // fluid alike.
    let block = |mpm: Value, pore: Value| {
        elastic_block().with(with_keys(
            json!({
                "domain": { "min": [0, 0], "max": [1, 0.4] }, "gravity": [0, 0],
                "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.3, 0], "max": [0.8, 0.2] },
                             "velocity": { "kind": "uniform", "value": [1, 0] }, "remove_outside": true, "pore_fluid": pore }],
                "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }],
                "stages": [{ "name": "slide", "duration": 0.45 }]
            }),
            &json!({ "methods": { "mpm": mpm } }),
        )).build()
    };
    let pore = json!({ "porosity": 0.4, "intrinsic_permeability": 1e-9, "bulk_modulus": 1e5 });
    for (mpm, pore) in [
        (json!({ "cell_size": 0.1 }), Value::Null),
        (json!({ "cell_size": 0.1, "shape": "linear", "mesh": { "kind": "box" } }), Value::Null),
        (json!({ "cell_size": 0.1 }), pore),
    ] {
        let case = block(mpm.clone(), pore);
        let report = solve(&Mpm, &case);
        let left = report.end.mass / report.start.mass;
        assert!((left - 0.5).abs() < 0.11, "{mpm}: {left}");
        assert!(report.snapshot.positions.iter().all(|x| x[0] < 1.0), "{mpm}");
        // The other points are unaffected.
        assert!((report.end.momentum[0] / report.end.mass - 1.0).abs() < 1e-9, "{mpm}: {:?}", report.end);
        let mut stays = case;
        stays.bodies[0].remove_outside = false;
        let error = run(&stays, Mpm.build(&stays).unwrap(), &RunOptions::default()).unwrap_err().to_string();
        assert!(error.contains("left"), "{error}");
    }
}

#[test]
fn points_stay_half_of_their_width_off_the_axis() {
    for shape in ["linear", "ugimp", "cpgimp"] {
        let case = elastic_block().with(json!({
            "space": "axisymmetric", "domain": { "min": [0, 0], "max": [2, 3] }, "gravity": [0, 0],
            "materials": { "m": { "model": "mohr-coulomb", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.2,
                                  "friction_angle": 30 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 0.5] },
                         "velocity": { "kind": "uniform", "value": [-3, 0] } }],
            "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }, { "side": "y-min", "wall": { "kind": "smooth" } }],
            "stages": [{ "name": "meet", "duration": 0.15 }],
            "methods": { "mpm": { "cell_size": 0.1, "shape": shape } }
        })).build();
        let report = solve(&Mpm, &case);
        let points = report.snapshot.positions.iter().zip(&report.snapshot.extents);
        let nearest = points.map(|(x, extent)| x[0] / extent[0]).fold(f64::INFINITY, f64::min);
        assert!((0.495..0.75).contains(&nearest), "{shape}: {nearest} widths");
    }
}

#[test]
fn right_stretch_domains_keep_their_size_in_rotation_and_diagonal_ones_shrink() {
    // A disk that turns by a quarter in a second: the diagonal of a rotation falls to zero.
    let turn = |stretch: &str, duration: f64| {
        let spin = std::f64::consts::FRAC_PI_2;
        let case = elastic_block().with(json!({
            "domain": { "min": [-0.5, -0.5], "max": [0.5, 0.5] },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "ball", "centre": [0, 0], "radius": 0.3 },
                         "velocity": { "kind": "linear", "value": [0, 0], "origin": [0, 0], "gradient": [[0, -spin], [spin, 0]] } }],
            "stages": [{ "name": "turn", "duration": duration }],
            "methods": { "mpm": { "cell_size": 0.05, "shape": "cpgimp", "stress_update": "usl", "domain_stretch": stretch } }
        })).build();
        run(&case, Mpm.build(&case).unwrap(), &RunOptions::default())
    };
    let report = turn("right-stretch", 1.0).unwrap();
    for extent in &report.snapshot.extents {
        assert!((0..2).all(|c| (extent[c] / 0.025 - 1.0).abs() < 0.05), "{extent:?} m for 0.025 m");
    }
    // The diagonal of a rotation by 45° is cos 45°.
    let report = turn("diagonal", 0.5).unwrap();
    for extent in &report.snapshot.extents {
        let share = |c: usize| extent[c] / (0.025 * std::f64::consts::FRAC_1_SQRT_2);
        assert!((0..2).all(|c| (share(c) - 1.0).abs() < 0.05), "{extent:?} m for 0.025 m cos 45°");
    }
}

#[test]
fn a_point_leaving_the_domain_ends_the_run_with_its_id_and_step() {
    let thrown = elastic_block().with(json!({
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.7, 0.3], "max": [0.9, 0.7] },
                     "velocity": { "kind": "uniform", "value": [5, 0] } }]
    })).build();
    let error = run(&thrown, Mpm.build(&thrown).unwrap(), &RunOptions::default()).unwrap_err().to_string();
    assert!(
        error.contains("left the domain") && error.contains("point") && error.contains("step"),
        "{error}"
    );
}

#[test]
fn points_at_their_least_volume_are_counted_and_reported() {
    // 2 m of 2000 kg/m³ on a stiffness of 100 Pa: nothing holds the weight.
    let soft = |modulus: f64| {
        let case = read_case(&json!({
            "title": "soft", "space": "1d", "domain": { "min": [0], "max": [2] }, "gravity": [-10],
            "materials": { "m": { "model": "linear-elastic", "density": 2000, "youngs_modulus": modulus, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [2] } }],
            "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }],
            "stages": [{ "name": "s", "duration": 1 }], "output": { "measures": 0.01 },
            "methods": { "mpm": { "cell_size": 0.25, "points_per_cell": 2, "shape": "linear" } }
        }));
        // Stable steps are so long that the first one would turn points inside out.
        solve(&Mpm, &case)
    };
    let has_warning = |report: &RunReport, what: &str| {
        report.warnings_at_end.iter().any(|remark| remark.text.contains(what))
    };
    let stiff = soft(1e7);
    assert!(!has_warning(&stiff, "compressed"), "{:?}", stiff.warnings_at_end);
    let report = soft(100.0);
    let least = report.table.last("volume_ratio.min").unwrap();
    assert!(
        least == 0.1 && has_warning(&report, "of 16 points are compressed"),
        "{least} {:?}",
        report.warnings_at_end
    );
}
