//! Equal results on any number of threads, and after a restart; lists against all pairs; energy of a gas.

use colluvium_case::Solver;
use colluvium_dem::{Dem, disks, spheres};
use colluvium_testkit::{advance_steps, assert_near, read_case, scalar_output, start_solver};
use serde_json::{Value, json};

/// Heap of polydisperse grains that falls on a floor.
pub fn heap(dimension: usize) -> Value {
    let (low, high) = (vec![0.0; dimension], vec![if dimension == 2 { 3.0 } else { 1.1 }; dimension]);
    let mut domain = (low.clone(), high.clone());
    domain.1[1] = 4.0;
    let mut gravity = vec![0.0; dimension];
    gravity[1] = -9.81;
    let side = |side: &str, kind: Value| json!({ "side": side, "wall": kind });
    let mut walls = vec![
        side("y-min", json!({ "kind": "rough" })),
        side("x-min", json!({ "kind": "frictional", "friction_coefficient": 0.3 })),
        side("x-max", json!({ "kind": "smooth" })),
    ];
    if dimension == 3 {
        walls
            .extend([side("z-min", json!({ "kind": "smooth" })), side("z-max", json!({ "kind": "smooth" }))]);
    }
    json!({
        "title": "heap", "space": if dimension == 2 { "plane-strain" } else { "3d" },
        "domain": { "min": domain.0, "max": domain.1 }, "gravity": gravity,
        "materials": { "sand": { "model": "linear-elastic", "density": 1600, "youngs_modulus": 1e7, "poissons_ratio": 0.3 } },
        "bodies": [{ "name": "heap", "material": "sand", "shape": { "kind": "box", "min": low, "max": high } }],
        "boundaries": walls,
        "stages": [{ "name": "fall", "duration": 1.0 }],
        "methods": { "dem": {
            "grains": { "sand": {
                "density": 2600,
                "diameter": { "distribution": "uniform", "min": 0.04, "max": 0.12 },
                "fill": { "kind": "random", "solid_fraction": if dimension == 2 { 0.6 } else { 0.4 } }
            } },
            "pairs": [{
                "between": ["sand", "sand"], "normal": { "law": "linear", "stiffness": 2e6, "restitution": 0.6 },
                "friction": { "coefficient": 0.5 }, "rolling": { "friction": 0.1 }
            }],
            "seed": 7
        } }
    })
}

fn begin(value: &Value) -> Box<dyn Solver> {
    start_solver(&Dem, &read_case(value))
}

#[test]
fn a_heap_is_bit_identical_on_any_threads() {
    for dimension in [2, 3] {
        let value = heap(dimension);
        let hashes = [1, 2, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut solver = begin(&value);
                advance_steps(&mut *solver, 500);
                solver.snapshot().hash()
            })
        });
        assert!(hashes[0] == hashes[1] && hashes[0] == hashes[2], "{dimension}: {hashes:?}");
    }
}

#[test]
fn a_restart_of_a_heap_is_bit_identical() {
    for dimension in [2, 3] {
        let value = heap(dimension);
        let mut solver = begin(&value);
        advance_steps(&mut *solver, 300);
        let saved = solver.checkpoint_bytes().unwrap();
        advance_steps(&mut *solver, 300);
        let mut again = begin(&value);
        again.restore(&mut &saved[..]).unwrap();
        again.begin_stage(0, 0.0).unwrap();
        advance_steps(&mut *again, 300);
        assert_eq!(solver.snapshot().hash(), again.snapshot().hash());
        assert_eq!(solver.checkpoint_bytes().unwrap(), again.checkpoint_bytes().unwrap());
        assert!(again.restore(&mut &saved[..saved.len() / 2]).is_err());
    }
}

#[test]
fn the_energy_balance_of_a_falling_heap_closes() {
    for dimension in [2, 3] {
        let mut solver = begin(&heap(dimension));
        while solver.time() < 0.25 {
            advance_steps(&mut *solver, 1);
        }
        assert!(scalar_output(&*solver, "contacts") > 100.0);
        assert!(scalar_output(&*solver, "dissipated.friction") > 0.0);
        assert_near(scalar_output(&*solver, "energy_error"), 0.0, 0.01);
    }
}

/// Dashpots share the load with springs in slip: the rest is dissipated by friction.
#[test]
fn the_energy_balance_closes_with_slip_and_tangential_dashpots() {
    let laws = [("linear", "clip"), ("linear", "spring"), ("hertz", "clip")];
    for (dimension, laws) in [(2, &laws[..]), (3, &laws[2..])] {
        for (law, reset) in laws {
            let mut case = heap(dimension);
            let pair = &mut case["methods"]["dem"]["pairs"][0];
            if *law == "hertz" {
                pair["normal"] = json!({ "law": "hertz", "youngs_modulus": 3e8, "poissons_ratio": 0.25, "restitution": 0.4 });
            }
            pair["tangential"] = json!({ "damping_ratio": 0.4, "reset": reset });
            pair["rolling"] = json!({ "friction": 0.1, "damping_ratio": 0.4 });
            case["methods"]["dem"]["step_fraction"] = json!(0.01);
            let mut solver = begin(&case);
            while solver.time() < 0.25 {
                advance_steps(&mut *solver, 1);
            }
            assert!(scalar_output(&*solver, "dissipated.friction") > 0.0);
            assert!(scalar_output(&*solver, "dissipated.rolling") > 0.0);
            assert_near(scalar_output(&*solver, "energy_error"), 0.0, 0.005);
        }
    }
}

/// Gas of elastic disks in a periodic box.
fn gas(spread: f64) -> Value {
    json!({
        "title": "gas", "space": "plane-strain",
        "domain": { "min": [0, 0], "max": [20, 20], "periodic": ["x", "y"] }, "gravity": [0, 0],
        "materials": { "disk": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
        "bodies": [{ "name": "gas", "material": "disk", "shape": { "kind": "box", "min": [0, 0], "max": [20, 20] } }],
        "stages": [{ "name": "all", "duration": 1000 }],
        "methods": { "dem": {
            "grains": { "disk": {
                "density": 4.0 / std::f64::consts::PI,
                "diameter": { "distribution": "uniform", "min": 1.0 / spread, "max": 1.0 * spread },
                "fill": { "kind": "random", "solid_fraction": 0.4 }
            } },
            "pairs": [{ "between": ["disk", "disk"], "normal": { "law": "linear", "stiffness": 1e4 } }],
            "stages": { "all": { "agitation": 1.0 } }
        } }
    })
}

#[test]
fn the_energy_of_an_elastic_gas_oscillates_without_drift() {
    let mut solver = begin(&gas(1.2));
    let dt = 0.1 / (2.0e4f64).sqrt();
    let mut start = None;
    let mut worst = 0.0f64;
    for _ in 0..40_000 {
        solver.step(dt).unwrap();
        let budget = solver.totals();
        let energy = budget.kinetic + budget.elastic;
        worst = worst.max((energy / *start.get_or_insert(energy) - 1.0).abs());
    }
    assert!(worst < 2.5e-3, "{worst}");
}

#[test]
fn lists_of_any_skin_give_equal_forces() {
    // A wide range of sizes; equal results with lists of a thin skin and of a thick one.
    let run = |skin: f64| {
        let mut value = gas(2.45);
        value["methods"]["dem"]["skin"] = json!(skin);
        let mut solver = begin(&value);
        for _ in 0..1000 {
            solver.step(5e-4).unwrap();
        }
        solver.snapshot()
    };
    let (thin, thick) = (run(0.02), run(0.8));
    for (a, b) in thin.positions.iter().zip(&thick.positions) {
        for c in 0..2 {
            let apart = a[c] - b[c];
            assert_near(apart - 20.0 * (apart / 20.0).round(), 0.0, 1e-9);
        }
    }
}

#[test]
fn simd_contact_forces_equal_scalar_contact_forces() {
    for dimension in [2, 3] {
        let hertz =
            json!({ "law": "hertz", "youngs_modulus": 5e9, "poissons_ratio": 0.25, "restitution": 0.5 });
        let linear = json!({ "law": "linear", "stiffness": 2e6, "restitution": 0.6 });
        let pulls = json!({ "law": "linear", "grain_modulus": 4e7, "damping_ratio": 0.2, "clamp": false });
        let rolls = json!({ "rolling": { "friction": 0.05, "damping_ratio": 0.1 }, "twisting": { "friction": 0.02 } });
        for (normal, across, resistance) in [
            (linear.clone(), json!({ "damping_ratio": 0.0 }), json!({})),
            (pulls, json!({ "stiffness_ratio": 0.3, "damping_ratio": 0.2, "reset": "spring" }), json!({})),
            (hertz.clone(), json!({}), json!({})),
            (linear, json!({ "damping_ratio": 0.0 }), rolls.clone()),
            (hertz, json!({}), rolls),
        ] {
            let mut case = heap(dimension);
            let mut pair = json!({ "between": ["sand", "sand"], "normal": normal, "tangential": across,
                                   "friction": { "coefficient": 0.3, "at_rest": 0.4 } });
            for name in ["rolling"].into_iter().chain((dimension == 3).then_some("twisting")) {
                if let Some(value) = resistance.get(name) {
                    pair[name] = value.clone();
                }
            }
            case["methods"]["dem"]["pairs"] = json!([pair]);
            case["bodies"][0]["velocity"] = json!({ "kind": "uniform", "value": vec![-1.0; dimension] });
            let case = read_case(&case);
            let (mut fast, mut single): (Box<dyn Solver>, Box<dyn Solver>) = if dimension == 2 {
                let mut single = disks(&case).unwrap();
                single.use_scalar_contacts();
                (Box::new(disks(&case).unwrap()), Box::new(single))
            } else {
                let mut single = spheres(&case).unwrap();
                single.use_scalar_contacts();
                (Box::new(spheres(&case).unwrap()), Box::new(single))
            };
            fast.begin_stage(0, 0.0).unwrap();
            single.begin_stage(0, 0.0).unwrap();
            for _ in 0..400 {
                let dt = fast.limit().dt;
                fast.step(dt).unwrap();
                single.step(dt).unwrap();
            }
            let (one, two) = (fast.snapshot(), single.snapshot());
            assert_eq!(one.positions, two.positions);
            assert_eq!(one.field("velocity"), two.field("velocity"));
            assert_eq!(one.field("spin"), two.field("spin"));
            assert!(scalar_output(&*fast, "sliding_contacts") > 3.0);
            for (own, other) in fast.scalar_outputs().into_iter().zip(single.scalar_outputs()) {
                // Sums in a different order.
                let size = own.2.abs().max(1e-6 * scalar_output(&*fast, "work.gravity").abs());
                assert!((own.2 - other.2).abs() <= 1e-9 * size || own.2.is_nan(), "{own:?} {other:?}");
            }
        }
    }
}

#[test]
fn size_classes_and_cells_of_one_width_give_equal_results() {
    for dimension in [2, 3] {
        let mut value = heap(dimension);
        value["methods"]["dem"]["grains"]["sand"]["diameter"] =
            json!({ "distribution": "uniform", "min": 0.02, "max": 0.2 });
        let case = read_case(&value);
        let run = |threads: usize, one_width: bool| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut solver: Box<dyn Solver> = if dimension == 2 {
                    let mut solver = disks(&case).unwrap();
                    if one_width {
                        solver.use_uniform_cells();
                    }
                    Box::new(solver)
                } else {
                    let mut solver = spheres(&case).unwrap();
                    if one_width {
                        solver.use_uniform_cells();
                    }
                    Box::new(solver)
                };
                solver.begin_stage(0, 0.0).unwrap();
                advance_steps(&mut *solver, 400);
                solver.snapshot().hash()
            })
        };
        let of_classes = run(1, false);
        assert_eq!(of_classes, run(1, true), "{dimension}");
        assert!([2, 3].iter().all(|threads| run(*threads, false) == of_classes), "{dimension}");
    }
}
