//! Mass, momentum and energy against closed forms.

use colluvium_mpm::Mpm;
use colluvium_testkit::{start_solver, stresses, vectors};
use serde_json::{Value, json};

use crate::solver::{SCHEMES, SHAPES, elastic_block};

#[test]
fn free_fall_is_exact() {
    for shape in SHAPES {
        for scheme in SCHEMES {
            let report = elastic_block()
                .with(json!({
                    "gravity": [0, -10],
                    "methods": { "mpm": { "cell_size": 0.1, "shape": shape, "stress_update": scheme } }
                }))
                .solve(&Mpm);
            for velocity in vectors(&report.snapshot, "velocity") {
                assert!(
                    (velocity[1] + 10.0 * 0.05).abs() < 1e-11 && velocity[0].abs() < 1e-11,
                    "{shape}, {scheme}"
                );
            }
            let stress = stresses(&report.snapshot).iter().flatten().fold(0.0, |a: f64, s| a.max(s.abs()));
            assert!(stress < 1e-6, "{shape}, {scheme}: stress {stress} Pa");
        }
    }
}

#[test]
fn mass_and_momentum_of_a_free_body_are_conserved() {
    for scheme in SCHEMES {
        let gradient = [[1.0, 0.4], [-0.8, -1.0]];
        let report = elastic_block().with(json!({
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "ball", "centre": [0.5, 0.5], "radius": 0.25 },
                         "velocity": { "kind": "linear", "value": [0.3, -0.2], "origin": [0.5, 0.5], "gradient": gradient } }],
            "methods": { "mpm": { "cell_size": 0.1, "stress_update": scheme } }
        })).solve(&Mpm);
        assert_eq!(report.end.mass, report.start.mass);
        for c in 0..2 {
            let change = report.end.momentum[c] - report.start.momentum[c];
            assert!(change.abs() < 1e-12 * report.start.mass, "{scheme}: {change}");
        }
    }
}

#[test]
fn the_momentum_gain_by_a_traction_is_its_impulse() {
    let report = elastic_block()
        .with(json!({
            "loads": [{ "kind": "traction", "body": "b", "side": "x-max", "value": [200, -50] }],
            "stages": [{ "name": "s", "duration": 0.02 }]
        }))
        .solve(&Mpm);
    // Area 0.4 m × 1 m, 0.02 s.
    assert!((report.end.momentum[0] - 200.0 * 0.4 * 0.02).abs() < 1e-10);
    assert!((report.end.momentum[1] + 50.0 * 0.4 * 0.02).abs() < 1e-10);
}

/// Two balls of a material thrown at each other; at the end kinetic, stored and dissipated energy over the kinetic energy at the
/// start.
fn thrown(material: &Value) -> [f64; 3] {
    let report = elastic_block().with(json!({
        "materials": { "m": material },
        "bodies": [{ "name": "a", "material": "m", "shape": { "kind": "ball", "centre": [0.25, 0.5], "radius": 0.15 },
                     "velocity": { "kind": "uniform", "value": [1, 0] } },
                   { "name": "b", "material": "m", "shape": { "kind": "ball", "centre": [0.75, 0.5], "radius": 0.15 },
                     "velocity": { "kind": "uniform", "value": [-1, 0] } }],
        "stages": [{ "name": "s", "duration": 0.2 }],
        "measures": { "lost": { "kind": "dissipation" } },
        "methods": { "mpm": { "cell_size": 0.05, "courant": 0.2 } }
    })).solve(&Mpm);
    let lost = report.table.last("lost").unwrap();
    assert_eq!(report.table.pairs("time", "lost").unwrap()[0].1, 0.0);
    [report.end.kinetic, report.end.elastic, lost].map(|energy| energy / report.start.kinetic)
}

#[test]
fn plastic_dissipation_closes_the_energy_balance() {
    let elastic =
        json!({ "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 });
    let [kinetic, stored, lost] = thrown(&elastic);
    assert!(lost.abs() < 5e-3 && (kinetic + stored + lost - 1.0).abs() < 0.03, "{kinetic}, {stored}, {lost}");
    let clay = json!({ "model": "tresca", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25,
                       "undrained_strength": 5e3 });
    let [kinetic, stored, lost] = thrown(&clay);
    assert!(lost > 0.3 && (kinetic + stored + lost - 1.0).abs() < 0.03, "{kinetic}, {stored}, {lost}");
}

#[test]
fn measures_have_energy_by_axis_work_volume_ratios_and_points_per_cell() {
    // A block of 4 × 4 cells of 2 × 2 points that flies and is stretched at a uniform rate.
    let thrown =
        json!({ "kind": "linear", "value": [3, 4], "origin": [0.4, 0.5], "gradient": [[0.1, 0], [0, -0.2]] });
    let report = elastic_block().with(json!({
        "gravity": [0, -10],
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.2, 0.3], "max": [0.6, 0.7] },
                     "velocity": thrown }],
        "stages": [{ "name": "s", "duration": 0.02 }],
        "output": { "measures": 1e-3 }
    })).solve(&Mpm);
    let column = |name: &str| report.table.column(name).unwrap();
    let (x, y, all) = (column("kinetic_energy.x"), column("kinetic_energy.y"), column("kinetic_energy"));
    assert!(report.table.column("kinetic_energy.z").is_none());
    for ((x, y), all) in x.iter().zip(&y).zip(&all) {
        assert!(((x + y) / all - 1.0).abs() < 1e-12);
    }
    // 160 kg, 0.4 m wide and high with eight points across: Σ ½ m v².
    let spread = |rate: f64| rate * rate * 0.4 * 0.4 / 12.0 * (1.0 - 1.0 / 64.0);
    assert!((x[0] / (80.0 * (9.0 + spread(0.1))) - 1.0).abs() < 1e-12, "{}", x[0]);
    assert!((y[0] / (80.0 * (16.0 + spread(0.2))) - 1.0).abs() < 1e-12, "{}", y[0]);
    assert_eq!((column("volume_ratio.min")[0], column("volume_ratio.max")[0]), (1.0, 1.0));
    let (smallest, largest) = (column("volume_ratio.min"), column("volume_ratio.max"));
    assert!(
        smallest
            .iter()
            .zip(&largest)
            .all(|(smallest, largest)| 0.99 < *smallest && smallest <= largest && *largest < 1.01)
    );
    assert!(smallest[20] < largest[20], "it does not deform evenly");
    assert_eq!((column("points_per_cell.min")[0], column("points_per_cell.mean")[0]), (4.0, 4.0));
    assert!(column("points_per_cell.min")[20] < 4.0, "it has left its cells");
    assert!(column("external_work").iter().all(|work| work.is_nan()), "no stage with equilibrium");
    assert!(column("time_step")[1..].iter().all(|dt| *dt > 0.0));
}

#[test]
fn external_work_is_recorded_in_stages_with_equilibrium() {
    // A block falls freely for 0.02 s from rest: its weight does m g² t² / 2.
    let case = elastic_block()
        .with(json!({
            "gravity": [0, -10],
            "stages": [{ "name": "rest", "duration": 0.03, "equilibrium": {} }]
        }))
        .build();
    let mut solver = start_solver(&Mpm, &case);
    while solver.time() < 0.02 - 1e-12 {
        let dt = solver.limit().dt.min(1e-4).min(0.02 - solver.time());
        solver.step(dt).unwrap();
    }
    let readings = solver.scalar_outputs();
    let work = readings.iter().find(|(name, ..)| name == "external_work").unwrap().2;
    assert!((work / (160.0 * 100.0 * 0.5 * 0.02 * 0.02) - 1.0).abs() < 0.01, "{work}");
}
