//! Saturated bodies in triangles and tetrahedra against closed forms (sheet: mpm ).

use std::f64::consts::PI;

use colluvium_case::Case;
use colluvium_mpm::Mpm;
use colluvium_testkit::{advance_steps, case_with, scalars, solve, start_solver, vectors};
use serde_json::{Value, json};

/// The spaces of the two meshes, and how many axes they have.
const SPACES: [(&str, usize); 2] = [("plane-strain", 2), ("3d", 3)];

/// A vector along the last axis.
fn up(dimension: usize, value: f64) -> Vec<f64> {
    (0..dimension).map(|c| if c + 1 == dimension { value } else { 0.0 }).collect()
}

/// Smooth walls on all sides but that above, "y-max" or "z-max".
fn tub(dimension: usize) -> Vec<Value> {
    let sides = ["x-min", "x-max", "y-min", "y-max", "z-min"];
    sides[..2 * dimension - 1]
        .iter()
        .map(|side| json!({ "side": side, "wall": { "kind": "smooth" } }))
        .collect()
}

/// A saturated column, `width` wide and 1 m high, that fills its domain: grains 2650, porosity 0.4, k = 1e-3 m/s, elements
/// cut from cells of `cell`; `more` replaces or adds keys.
#[allow(clippy::needless_pass_by_value, reason = "`column(…, json!(…))` reads well")]
fn column((space, dimension): (&str, usize), width: f64, cell: f64, more: Value) -> Case {
    let high: Vec<f64> = up(dimension, 1.0).iter().map(|c| if *c == 0.0 { width } else { *c }).collect();
    let low = vec![0.0; dimension];
    case_with(
        json!({
            "title": "test", "space": space, "domain": { "min": low, "max": high }, "gravity": low,
            "materials": { "m": { "model": "linear-elastic", "density": 1590, "youngs_modulus": 1e7, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": low, "max": high },
                         "pore_fluid": { "porosity": 0.4, "intrinsic_permeability": 1.019367991845056e-10 } }],
            "stages": [{ "name": "s", "duration": 1.0 }],
            "methods": { "mpm": { "cell_size": cell, "shape": "linear", "mesh": { "kind": "box" } } }
        }),
        &more,
    )
}

/// The body of a case with other keys.
fn body(case: &Case, more: &Value) -> Value {
    let mut text: Value = serde_json::from_str(&case.to_json()).unwrap();
    let body = &mut text["bodies"][0];
    more.as_object().unwrap().iter().for_each(|(key, value)| body[key] = value.clone());
    json!({ "bodies": [body] })
}

fn again(case: &Case, more: &Value) -> Case {
    case_with(serde_json::from_str(&case.to_json()).unwrap(), more)
}

#[test]
fn drag_equalises_the_phase_velocities_and_conserves_momentum() {
    // w decays as (1 - a dt)^N; momentum stays.
    let rate = 0.4 * 1990.0 * 9.81 / (1590.0 * 1e-3);
    for space in SPACES {
        let block = column(space, 1.0, 0.25, json!({}));
        let shape = json!({ "kind": "box", "min": vec![0.25; space.1], "max": vec![0.75; space.1] });
        let fluid = json!({ "porosity": 0.4, "intrinsic_permeability": 1.019367991845056e-10,
                            "velocity": { "kind": "uniform", "value": &[0.02, -0.01, 0.03][..space.1] } });
        let block = again(&block, &body(&block, &json!({ "shape": shape, "pore_fluid": fluid })));
        let mut solver = start_solver(&Mpm, &block);
        let (start, dt) = (solver.totals(), 1e-5);
        (0..40).for_each(|_| {
            solver.step(dt).unwrap();
        });
        let (snapshot, end) = (solver.snapshot(), solver.totals());
        let keep = (1.0 - rate * dt).powi(40);
        for (v, w) in vectors(&snapshot, "velocity").iter().zip(vectors(&snapshot, "liquid_velocity")) {
            for c in 0..space.1 {
                let exact = [0.02, -0.01, 0.03][c] * keep;
                assert!((w[c] - v[c] - exact).abs() < 1e-12, "{space:?}: {v:?}, {w:?}");
            }
        }
        for c in 0..3 {
            assert!((end.momentum[c] - start.momentum[c]).abs() < 1e-12 * start.mass, "{space:?}");
        }
    }
}

#[test]
fn water_seeps_through_a_held_skeleton_at_the_rate_of_darcy() {
    // a wall over the whole column holds the grains and is permeable to water; the walls on the sides are impermeable.
    for space in SPACES {
        let held = ["y-min", "z-min"][space.1 - 2];
        let mut walls: Vec<Value> = tub(space.1).into_iter().filter(|wall| wall["side"] != held).collect();
        walls.push(json!({ "side": held, "position": 1.0, "wall": { "kind": "rough" }, "drained": true }));
        let fluid = json!({ "porosity": 0.4, "permeability": 1e-3 });
        let more = json!({ "gravity": up(space.1, -9.81), "boundaries": walls, "stages": [{ "name": "s", "duration": 5e-3 }] });
        let case = column(space, 0.25, 0.25, more);
        let case = again(&case, &body(&case, &json!({ "pore_fluid": fluid })));
        let report = solve(&Mpm, &case);
        for (v, w) in
            vectors(&report.snapshot, "velocity").iter().zip(vectors(&report.snapshot, "liquid_velocity"))
        {
            assert_eq!(v[space.1 - 1], 0.0);
            // The sheet's 0.1 % of the flux n v_L = k i.
            assert!((w[space.1 - 1] / (-1e-3 / 0.4) - 1.0).abs() < 1e-3, "{space:?}: {w:?}");
        }
    }
}

#[test]
fn undrained_compression_on_meshes_splits_stress_by_the_stiffness_of_the_phases() {
    // one cell between impermeable walls, the upper one moving in; all its nodes are held.
    for space in SPACES {
        for (scheme, volumetric) in [("musl", "point"), ("usl", "nodal"), ("musl", "cell-average")] {
            let mut walls = tub(space.1);
            let upper = ["y-max", "z-max"][space.1 - 2];
            walls
                .push(json!({ "side": upper, "wall": { "kind": "smooth" }, "velocity": up(space.1, -1e-3) }));
            let mpm = json!({ "cell_size": 1, "shape": "linear", "mesh": { "kind": "box" }, "stress_update": scheme,
                              "volumetric_strain": volumetric });
            let case = column(space, 1.0, 1.0, json!({ "boundaries": walls, "methods": { "mpm": mpm } }));
            let mut solver = start_solver(&Mpm, &case);
            (0..10).for_each(|_| {
                solver.step(1e-6).unwrap();
            });
            let (snapshot, strain) = (solver.snapshot(), -1e-3 * 1e-5);
            for pressure in scalars(&snapshot, "pore_pressure") {
                let exact = -2.15e9 / 0.4 * strain;
                assert!(
                    (pressure / exact - 1.0).abs() < 1e-6,
                    "{space:?}, {scheme}, {volumetric}: {pressure}"
                );
            }
            for total in snapshot.tensors("total_stress").unwrap() {
                let exact = (1e7 + 2.15e9 / 0.4) * strain;
                assert!((total.0[space.1 - 1] / exact - 1.0).abs() < 1e-6, "{space:?}, {scheme}: {total:?}");
            }
        }
    }
}

#[test]
fn a_column_consolidates_by_terzaghis_solution() {
    // A-19 on few elements, to T = 0.2: the benchmark has finer ones.
    let rate = 1e-3 / (9810.0 * (1e-7 + 0.4 / 2.15e9));
    let share = (2.15e9 / 0.4) / (1e7 + 2.15e9 / 0.4);
    let modes: Vec<f64> = (0..100).map(|m| PI / 2.0 * f64::from(2 * m + 1)).collect();
    for space in SPACES {
        let load = ["y-max", "z-max"][space.1 - 2];
        let mut stress = [0.0; 6];
        stress[space.1 - 1] = -1e4 * (1.0 - share);
        let more = json!({
            "boundaries": tub(space.1), "loads": [{ "kind": "traction", "body": "b", "side": load, "value": up(space.1, -1e4) }],
            "stages": [{ "name": "s", "duration": 0.2 / rate }]
        });
        let case = column(space, 0.1, 0.1, more);
        let pressed = json!({
            "stress": { "kind": "uniform", "value": stress },
            "pore_fluid": { "porosity": 0.4, "intrinsic_permeability": 1.019367991845056e-10,
                            "pressure": { "kind": "uniform", "value": 1e4 * share } }
        });
        let case = again(&case, &body(&case, &pressed));
        let report = solve(&Mpm, &case);
        let ratios: Vec<f64> =
            scalars(&report.snapshot, "pore_pressure").iter().map(|p| p / (1e4 * share)).collect();
        let factor = report.snapshot.time * rate;
        let exact =
            |z: f64| modes.iter().map(|a| 2.0 / a * (a * z).sin() * (-a * a * factor).exp()).sum::<f64>();
        let depth = report.snapshot.positions.iter().map(|x| 1.0 - x[space.1 - 1]);
        let square: f64 = depth.zip(&ratios).map(|(z, p)| (p - exact(z)).powi(2)).sum();
        let rms = (square / ratios.len() as f64).sqrt();
        // The sheet's bound, which is of 40 cells.
        assert!(rms < 0.03, "{space:?}: {rms}");
    }
}

/// A soaked block under its weight in a tub, its bottom shut.
fn soaked(space: (&str, usize), permeability: f64, options: &Value) -> Case {
    let mut mpm = json!({ "cell_size": 0.25, "shape": "linear", "mesh": { "kind": "box" } });
    options.as_object().unwrap().iter().for_each(|(key, value)| mpm[key] = value.clone());
    let case = column(
        space,
        0.5,
        0.25,
        json!({ "gravity": up(space.1, -1.0), "boundaries": tub(space.1), "methods": { "mpm": mpm },
                "materials": { "m": { "model": "linear-elastic", "density": 1590, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } } }),
    );
    let mut high = vec![0.5; space.1];
    high[space.1 - 1] = 0.75;
    let shape = json!({ "kind": "box", "min": vec![0.0; space.1], "max": high });
    let fluid = json!({ "porosity": 0.4, "permeability": permeability, "bulk_modulus": 1e7 });
    again(&case, &body(&case, &json!({ "shape": shape, "pore_fluid": fluid })))
}

#[test]
fn the_default_step_is_stable_in_triangles_and_tetrahedra() {
    for space in SPACES {
        for permeability in [1e-5, 1e-2, 10.0] {
            for (points, scheme, volumetric) in [
                (1, "musl", "point"),
                (2, "musl", "point"),
                (3, "musl", "point"),
                (2, "musl", "nodal"),
                (2, "usl", "point"),
            ] {
                let options = json!({ "points_per_cell": points, "stress_update": scheme, "volumetric_strain": volumetric });
                let mut solver = start_solver(&Mpm, &soaked(space, permeability, &options));
                let start = solver.totals();
                advance_steps(&mut *solver, if space.1 == 3 { 300 } else { 1000 });
                // It oscillates under its weight, and gains nothing: the fall of 0.75 m bounds it by far.
                let end = solver.totals();
                assert!(
                    end.kinetic < 0.01 * start.mass,
                    "{space:?}, {points} points, {scheme}, {volumetric}, k = {permeability}: {}",
                    end.kinetic
                );
            }
        }
    }
}

#[test]
fn results_are_bit_identical_on_two_threads_and_after_a_restart() {
    for space in SPACES {
        let case = soaked(space, 1e-3, &json!({ "volumetric_strain": "nodal" }));
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut solver = start_solver(&Mpm, &case);
                advance_steps(&mut *solver, 120);
                solver.snapshot().hash()
            })
        };
        assert_eq!(on(1), on(2), "{space:?}");
        let mut whole = start_solver(&Mpm, &case);
        advance_steps(&mut *whole, 50);
        let mut rest = start_solver(&Mpm, &case);
        rest.restore(&mut whole.checkpoint_bytes().unwrap().as_slice()).unwrap();
        rest.begin_stage(0, 0.0).unwrap();
        advance_steps(&mut *rest, 70);
        assert_eq!(rest.snapshot().hash(), on(1), "{space:?}");
    }
}
