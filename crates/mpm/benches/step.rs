//! Point-updates per second of one step of an elastic block, on one thread.

use colluvium_case::{Case, Method};
use colluvium_mpm::Mpm;
use criterion::{BenchmarkId, Criterion, Throughput};
use serde_json::json;

/// A block that settles on a rough floor under a little gravity: two points per cell and direction.
fn block(dimension: usize, cells: usize, shape: &str, scheme: &str, saturated: bool) -> Case {
    let cell = 1.0 / cells as f64;
    let all = |value: f64| vec![value; dimension];
    let (mut gravity, mut floor) = (all(0.0), all(-4.0 * cell));
    gravity[1] = -0.1;
    floor[1] = 0.0;
    let mut text = json!({
        "title": "step",
        "space": if dimension == 2 { "plane-strain" } else { "3d" },
        "domain": { "min": floor, "max": all(1.0 + 4.0 * cell) },
        "gravity": gravity,
        "materials": { "soil": { "model": "linear-elastic", "density": 2000.0, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
        "bodies": [{ "name": "block", "material": "soil", "shape": { "kind": "box", "min": all(0.0), "max": all(1.0) } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "settle", "duration": 1.0 }],
        "methods": { "mpm": { "cell_size": cell, "shape": shape, "stress_update": scheme } }
    });
    if saturated {
        text["bodies"][0]["pore_fluid"] =
            json!({ "porosity": 0.4, "permeability": 1e-3, "bulk_modulus": 1e7 });
    }
    Case::from_json(&text.to_string()).expect("a valid case")
}

fn step(criterion: &mut Criterion, dimension: usize, cells: usize) {
    let mut group = criterion.benchmark_group(format!("{dimension}d step"));
    group.sample_size(10);
    for shape in ["linear", "ugimp", "cpgimp", "quadratic", "cubic"] {
        for (name, scheme, saturated) in [
            ("usl", "usl", false),
            ("musl", "musl", false),
            ("usl, two phases", "usl", true),
            ("musl, two phases", "musl", true),
        ] {
            let mut solver = Mpm.build(&block(dimension, cells, shape, scheme, saturated)).expect("a solver");
            solver.begin_stage(0, 0.0).expect("a stage");
            group.throughput(Throughput::Elements(solver.point_count() as u64));
            group.bench_function(BenchmarkId::new(shape, name), |bencher| {
                bencher.iter(|| {
                    let dt = solver.limit().dt;
                    solver.step(dt).expect("a stable step");
                });
            });
        }
    }
    group.finish();
}

/// Within the pool, as runs are: from outside each loop of a step would hand over to its thread and wait for it.
fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool of one thread");
    pool.install(|| {
        let mut criterion = Criterion::default().configure_from_args();
        step(&mut criterion, 2, 50);
        step(&mut criterion, 3, 11);
        criterion.final_summary();
    });
}
