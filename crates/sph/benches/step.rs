//! Benchmark of one step (particle updates per second), on one thread.

use colluvium_case::{Case, Method};
use colluvium_sph::Sph;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use serde_json::json;

/// Block that settles on a rough floor under reduced gravity.
fn block(dimension: usize, edge: usize, model: &str) -> Case {
    let spacing = 1.0 / edge as f64;
    let all = |value: f64| vec![value; dimension];
    let (mut gravity, mut floor) = (all(0.0), all(-4.0 * spacing));
    gravity[1] = -0.1;
    floor[1] = 0.0;
    let mut material =
        json!({ "model": model, "density": 2000.0, "youngs_modulus": 1e6, "poissons_ratio": 0.3 });
    if model != "linear-elastic" {
        material["friction_angle"] = json!(20.0);
        material["cohesion"] = json!(10.0);
    }
    let text = json!({
        "title": "step",
        "space": if dimension == 2 { "plane-strain" } else { "3d" },
        "domain": { "min": floor, "max": all(1.0 + 4.0 * spacing) },
        "gravity": gravity,
        "materials": { "soil": material },
        "bodies": [{ "name": "block", "material": "soil", "shape": { "kind": "box", "min": all(0.0), "max": all(1.0) } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "settle", "duration": 1.0 }],
        "methods": { "sph": { "spacing": spacing } }
    });
    Case::from_json(&text.to_string()).expect("a valid case")
}

fn step(criterion: &mut Criterion, dimension: usize, edge: usize) {
    let mut group = criterion.benchmark_group(format!("{dimension}d step"));
    group.sample_size(10);
    for model in ["linear-elastic", "drucker-prager"] {
        let mut solver = Sph.build(&block(dimension, edge, model)).expect("a solver");
        solver.begin_stage(0, 0.0).expect("a stage");
        group.throughput(Throughput::Elements(solver.point_count() as u64));
        group.bench_function(BenchmarkId::new("cubic spline", model), |bencher| {
            bencher.iter(|| {
                let dt = solver.limit().dt;
                solver.step(dt).expect("a stable step");
            });
        });
    }
    group.finish();
}

fn all(criterion: &mut Criterion) {
    // Rayon would use all cores.
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first and only pool");
    step(criterion, 2, 100);
    step(criterion, 3, 22);
}

criterion_group!(benches, all);
criterion_main!(benches);
