//! Time to build a list of pairs of spheres, the largest ten times as wide as the smallest: by size classes, and in
//! uniform cells.

use colluvium_case::{Case, Solver};
use colluvium_dem::{DemSolver, spheres};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use serde_json::json;

/// Grains of 1 to 10 mm with equal mass in every interval of sizes, in a periodic cube with sides of this length (m).
fn specimen(side: f64) -> DemSolver<3, 3> {
    let cube = json!({ "kind": "box", "min": [0, 0, 0], "max": [side, side, side] });
    let case = json!({
        "title": "spheres", "space": "3d",
        "domain": { "min": [0, 0, 0], "max": [side, side, side], "periodic": ["x", "y", "z"] }, "gravity": [0, 0, 0],
        "materials": { "s": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
        "bodies": [{ "name": "b", "material": "s", "shape": cube }],
        "stages": [{ "name": "all", "duration": 1.0 }],
        "methods": { "dem": {
            "grains": { "s": { "density": 2500, "diameter": { "distribution": "equal-mass", "min": 0.001, "max": 0.01 },
                               "fill": { "kind": "random", "solid_fraction": 0.4 } } },
            "pairs": [{ "between": ["s", "s"], "normal": { "law": "linear", "stiffness": 2e4 } }]
        } }
    });
    let case = Case::from_json(&case.to_string()).expect("a valid case");
    spheres(&case).expect("a solver")
}

fn all(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("list of pairs, sizes 1 to 10");
    group.sample_size(10);
    for side in [0.04, 0.06] {
        for name in ["classes", "cells of one width"] {
            let mut solver = specimen(side);
            if name != "classes" {
                solver.use_uniform_cells();
            }
            let grains = solver.point_count();
            group.throughput(Throughput::Elements(grains as u64));
            group.bench_function(BenchmarkId::new(name, grains), |bencher| {
                // The beginning of a stage makes the lists invalid.
                bencher.iter(|| solver.begin_stage(0, 0.0).expect("a stage"));
            });
        }
    }
}

criterion_group!(benches, all);
criterion_main!(benches);
