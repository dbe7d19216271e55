//! Periodic domains.

use colluvium_case::Method;
use colluvium_snow_mpm::SnowMpm;
use colluvium_testkit::{
    advance_steps, advance_to, read_case, refusal, scalars, start_solver, vectors, with_keys,
};
use serde_json::{Value, json};

/// A block of 0.3 m that flies through the sides of a periodic domain of a metre, crushed by `shrink` (1/s) meanwhile; `seam` moves
/// all of it along x (m).
fn drifting(shrink: f64, seam: f64, options: &Value) -> Value {
    let block = |name: &str, low: f64, high: f64| {
        json!({
            "name": name, "material": "m", "shape": { "kind": "box", "min": [low, 0.35], "max": [high, 0.65] },
            "velocity": { "kind": "linear", "value": [3, -2], "gradient": [[-shrink, 0], [0, shrink]],
                "origin": [0.5 + seam - if low < 0.3 { 1.0 } else { 0.0 }, 0.5] }
        })
    };
    let bodies = match seam {
        0.0 => vec![block("whole", 0.35, 0.65)],
        _ => vec![block("left", 0.35 + seam, 1.0), block("right", 0.0, seam - 0.35)],
    };
    json!({
        "title": "block", "space": "plane-strain", "gravity": [0, 0],
        "domain": { "min": [0, 0], "max": [1, 1], "periodic": ["x", "y"] },
        "materials": { "m": { "model": "linear-elastic", "strain_measure": "hencky", "density": 400, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
        "bodies": bodies,
        "stages": [{ "name": "go", "duration": 1 }],
        "methods": { "snow-mpm": with_keys(json!({ "cell_size": 0.05 }), options) }
    })
}

#[test]
fn motion_through_periodic_sides_is_unchanged() {
    for (options, within) in [
        (json!({}), 1e-11),
        (json!({ "shape": "quadratic" }), 1e-11),
        (json!({ "transfer": "flip" }), 1e-11),
        // Gradients of linear functions jump: stresses of round-off push nodes that have hardly any mass, without a seam as well.
        (json!({ "transfer": "flip", "shape": "linear" }), 1e-8),
    ] {
        let mut solver = start_solver(&SnowMpm, &read_case(&drifting(0.0, 0.0, &options)));
        advance_to(&mut *solver, 0.7);
        let snapshot = solver.snapshot();
        let moves = vectors(&snapshot, "velocity").into_iter().zip(vectors(&snapshot, "displacement"));
        for ((v, u), x) in moves.zip(&snapshot.positions) {
            assert!((v[0] - 3.0).abs() < within && (v[1] + 2.0).abs() < within, "{options}: {v:?}");
            let far = [u[0] - 3.0 * snapshot.time, u[1] + 2.0 * snapshot.time];
            assert!(far[0].abs() < within && far[1].abs() < within && u[0] > 2.0, "{options}: {u:?}");
            assert!(x[..2].iter().all(|x| (0.0..=1.0).contains(x)), "{options}: {x:?}");
        }
        assert!(scalars(&snapshot, "deviatoric_stress").iter().all(|q| *q < 1e6 * within), "{options}");
    }
}

#[test]
fn results_do_not_depend_on_the_position_of_the_periodic_boundary() {
    for options in [json!({}), json!({ "transfer": "flip", "shape": "quadratic" })] {
        let ends = [0.0, 0.5].map(|seam| {
            let mut solver = start_solver(&SnowMpm, &read_case(&drifting(0.5, seam, &options)));
            advance_to(&mut *solver, 0.05);
            let readings = solver.scalar_outputs().into_iter().map(|(_, _, value)| value).collect::<Vec<_>>();
            (solver.totals(), readings)
        });
        let [(whole, own), (cut, other)] = ends;
        let scale = whole.kinetic;
        assert!((whole.kinetic - cut.kinetic).abs() < 1e-11 * scale, "{options}: {whole:?}, {cut:?}");
        assert!((whole.elastic - cut.elastic).abs() < 1e-11 * scale && whole.elastic > 0.0, "{options}");
        // Energies of the numerics too: a node that is two is counted once.
        for (own, other) in own.iter().zip(&other) {
            assert!((own - other).abs() < 1e-11 * scale, "{options}: {own}, {other}");
        }
    }
}

#[test]
fn periodic_runs_are_the_same_on_any_thread_and_after_a_restart() {
    let case = drifting(2.0, 0.5, &json!({}));
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver = start_solver(&SnowMpm, &read_case(&case));
            advance_steps(&mut *solver, 200);
            (solver.snapshot().hash(), solver.checkpoint_bytes().unwrap())
        })
    };
    let (hash, saved) = run(1);
    assert_eq!((hash, saved.clone()), run(3));
    let read = read_case(&case);
    let mut second = SnowMpm.build(&read).unwrap();
    second.restore(&mut saved.as_slice()).unwrap();
    second.begin_stage(0, 0.0).unwrap();
    let mut first = start_solver(&SnowMpm, &read_case(&case));
    advance_steps(&mut *first, 400);
    advance_steps(&mut *second, 200);
    assert_eq!(first.checkpoint_bytes().unwrap(), second.checkpoint_bytes().unwrap());
}

#[test]
fn a_layer_slides_through_periodic_sides_by_coulombs_law() {
    // Gravity tilted by 30°, a bed with a coefficient of 0.3, and no ends: each point has the motion of the whole layer.
    let (slope, friction, end) = (30f64.to_radians(), 0.3, 0.3);
    let gravity = [9.81 * slope.sin(), -9.81 * slope.cos()];
    let mut solver = start_solver(
        &SnowMpm,
        &read_case(&json!({
            "title": "layer", "space": "plane-strain", "gravity": gravity,
            "domain": { "min": [0, 0], "max": [0.6, 0.6], "periodic": ["x"] },
            "materials": { "m": { "model": "linear-elastic", "strain_measure": "hencky", "density": 400, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
            "bodies": [{ "name": "layer", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.6, 0.2] } }],
            "boundaries": [{ "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": friction } }],
            "stages": [{ "name": "go", "duration": end }],
            "methods": { "snow-mpm": { "cell_size": 0.05 } }
        })),
    );
    advance_to(&mut *solver, end);
    let snapshot = solver.snapshot();
    let exact = 0.5 * 9.81 * (slope.sin() - friction * slope.cos()) * end * end;
    let moved = vectors(&snapshot, "displacement");
    let mean = moved.iter().map(|u| u[0]).sum::<f64>() / moved.len() as f64;
    // The layer bounces on its bed: the mean normal force is its weight up to a part of an oscillation.
    assert!((mean / exact - 1.0).abs() < 0.03, "{mean} is not {exact}");
    for row in [0.0125, 0.1875] {
        let of_row = moved.iter().zip(&snapshot.positions).filter(|(u, x)| (x[1] - u[1] - row).abs() < 1e-6);
        let along: Vec<f64> = of_row.map(|(u, _)| u[0]).collect();
        let spread = along.iter().fold(0f64, |largest, u| largest.max((u - along[0]).abs()));
        assert!(along.len() == 24 && spread < 1e-9, "row {row}: {spread}");
    }
}

#[test]
fn options_without_support_in_periodic_domains_are_refused_by_key() {
    let narrow = refusal(&SnowMpm, &drifting(0.0, 0.0, &json!({ "cell_size": 0.1 })));
    assert!(narrow.starts_with("domain.periodic: needs 11 cells"), "{narrow}");
    let mut case = drifting(0.0, 0.0, &json!({}));
    case["obstacles"] = json!([{ "name": "rock", "wall": { "kind": "rough" },
        "shape": { "kind": "box", "min": [0, 0], "max": [0.2, 0.2] } }]);
    let error = refusal(&SnowMpm, &case);
    assert!(error.starts_with("obstacles") && error.contains("use boundaries"), "{error}");
    let mut case = drifting(0.0, 0.0, &json!({}));
    case["removal_shapes"] = json!([{ "name": "saw", "velocity": [1, 0], "shape": { "kind": "box", "min": [0, 0.4], "max": [0.1, 0.6] } }]);
    let error = refusal(&SnowMpm, &case);
    assert!(error.starts_with("removal_shapes"), "{error}");
    let mut case = drifting(0.0, 0.0, &json!({}));
    case["bodies"][0]["shape"]["max"][0] = json!(1.1);
    assert!(refusal(&SnowMpm, &case).contains("domain"), "a body beyond a periodic side");
}
