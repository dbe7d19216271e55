//! Point-updates per second of one step on one thread, with APIC: an elastic block, and a column of snow that gives way under its
//! weight. The share of points that yield in a step is told for each.

use colluvium_case::{Case, Method, Snapshot, Solver};
use colluvium_snow_mpm::SnowMpm;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use serde_json::{Value, json};

/// Steps before the clock starts: until the column gives way.
const BEFORE: usize = 300;

/// A block of 1 m on a rough floor, with two points per cell and direction.
fn block(dimension: usize, cells: usize, shape: &str, material: &Value) -> Case {
    let cell = 1.0 / cells as f64;
    let all = |value: f64| vec![value; dimension];
    let (mut gravity, mut floor) = (all(0.0), all(-1.0));
    (gravity[1], floor[1]) = (-9.81, 0.0);
    let text = json!({
        "title": "step",
        "space": if dimension == 2 { "plane-strain" } else { "3d" },
        "domain": { "min": floor, "max": all(2.0) },
        "gravity": gravity,
        "materials": { "snow": material },
        "bodies": [{ "name": "block", "material": "snow", "drop_outside": true,
            "shape": { "kind": "box", "min": all(0.0), "max": all(1.0) } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "fall", "duration": 100.0 }],
        "methods": { "snow-mpm": { "cell_size": cell, "shape": shape } }
    });
    Case::from_json(&text.to_string()).expect("a valid case")
}

fn materials() -> [(&'static str, Value); 2] {
    let elastic = json!({ "model": "linear-elastic", "strain_measure": "hencky", "density": 250, "youngs_modulus": 3e6,
        "poissons_ratio": 0.3 });
    let snow = json!({ "model": "cohesive-cam-clay", "density": 250, "youngs_modulus": 3e6, "poissons_ratio": 0.3,
        "critical_state_slope": 0.8, "cohesion_ratio": 0.3, "hardening_factor": 1, "compressive_strength": 1000 });
    [("elastic", elastic), ("cohesive Cam clay", snow)]
}

fn steps(solver: &mut dyn Solver, count: usize) {
    for _ in 0..count {
        let dt = solver.limit().dt;
        solver.step(dt).expect("a stable step");
    }
}

/// Share of the points whose plastic strain changes in a step.
fn yielding(solver: &mut dyn Solver) -> f64 {
    let strains = |snapshot: &Snapshot| -> Vec<f64> {
        let of = |name: &str| snapshot.scalars(name).unwrap_or_default().to_vec();
        of("plastic_volumetric_strain").into_iter().chain(of("plastic_strain")).collect()
    };
    let before = strains(&solver.snapshot());
    steps(solver, 1);
    let after = strains(&solver.snapshot());
    let half = before.len() / 2;
    let changed = (0..half).filter(|&i| before[i] != after[i] || before[half + i] != after[half + i]).count();
    changed as f64 / solver.points().max(1) as f64
}

fn step(criterion: &mut Criterion, dimension: usize, cells: usize) {
    let mut group = criterion.benchmark_group(format!("{dimension}d step"));
    group.sample_size(10);
    for shape in ["quadratic", "cubic"] {
        for (name, material) in materials() {
            let case = block(dimension, cells, shape, &material);
            let mut solver = SnowMpm.build(&case).expect("a solver");
            solver.begin_stage(0, 0.0).expect("a stage");
            steps(&mut *solver, BEFORE);
            println!(
                "{dimension}d {shape} {name}: {} points, {:.0} % yield",
                solver.points(),
                100.0 * yielding(&mut *solver)
            );
            group.throughput(Throughput::Elements(solver.points() as u64));
            group.bench_function(BenchmarkId::new(shape, name), |bencher| {
                bencher.iter(|| steps(&mut *solver, 1));
            });
        }
    }
    group.finish();
}

fn all(criterion: &mut Criterion) {
    // Rayon would use all cores.
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first and only pool");
    step(criterion, 2, 50);
    step(criterion, 3, 11);
}

criterion_group!(benches, all);
criterion_main!(benches);
