//! Particle-steps per second of spheres that fall and come to rest (loose) and of spheres at rest (dense).

use std::path::Path;
use std::time::{Duration, Instant};

use colluvium_case::{Case, Solver};
use colluvium_dem::{DemSolver, spheres};
use criterion::{BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;

const DIAMETER: f64 = 0.01;

/// Centres (m) and the box around them (m).
type Specimen = (Vec<[f64; 3]>, [f64; 3]);

/// Column that can spread: a simple cubic lattice, gaps of a twentieth of the diameter, jitter.
fn loose([nx, ny, nz]: [usize; 3]) -> Specimen {
    let (pitch, mut random) = (1.05 * DIAMETER, ChaCha8Rng::seed_from_u64(1));
    let mut all = Vec::new();
    for i in 0..nx {
        for j in 0..ny {
            for k in 0..nz {
                all.push(
                    [i, j, k].map(|n| {
                        (n as f64 + 0.5) * pitch + DIAMETER * (0.04 * random.random::<f64>() - 0.02)
                    }),
                );
            }
        }
    }
    (all, [3.0 * nx as f64 * pitch, ny as f64 * pitch, 1.6 * nz as f64 * pitch])
}

/// Overlapping hexagonal layers: six contacts per inner sphere.
fn dense(n: usize) -> Specimen {
    let pitch = 0.999 * DIAMETER;
    let (root3, root6) = (3f64.sqrt(), 6f64.sqrt());
    let mut all = Vec::new();
    for k in 0..n {
        for j in 0..n {
            for i in 0..n {
                let layer = if k % 2 == 1 { root3 / 6.0 } else { 0.0 };
                let place = [
                    i as f64 + 0.5 * ((j + k) % 2) as f64,
                    0.5 * root3 * j as f64 + layer,
                    root6 / 3.0 * k as f64,
                ];
                all.push(place.map(|x| x * pitch + 0.5 * DIAMETER));
            }
        }
    }
    let most = |axis: usize| all.iter().map(|x: &[f64; 3]| x[axis]).fold(0.0, f64::max);
    let size = [most(0) + 0.5 * DIAMETER, most(1) + 0.5 * DIAMETER, most(2) + 2.0 * DIAMETER];
    (all, size)
}

/// Springs, dashpots and friction with all walls but the lid.
fn solver((places, size): &Specimen, folder: &Path) -> DemSolver<3, 3> {
    let volume = std::f64::consts::PI / 6.0 * DIAMETER.powi(3);
    let mut text = String::from("x,y,z,volume\n");
    for [x, y, z] in places {
        text.push_str(&format!("{x},{y},{z},{volume}\n"));
    }
    std::fs::write(folder.join("points.csv"), text).expect("a folder to write in");
    let wall =
        |side: &str| json!({ "side": side, "wall": { "kind": "frictional", "friction_coefficient": 0.5 } });
    let walls: Vec<_> = ["x-min", "x-max", "y-min", "y-max", "z-min"].map(wall).to_vec();
    let mass = 2500.0 * volume;
    // γ_n = 1000 m_eff and γ_t = 500 m_eff per second, for a pair.
    let ratio = 0.5 * 1000.0 * 0.5 * mass / (2e4 * 0.5 * mass).sqrt();
    let across = 0.5 * 500.0 * 0.5 * mass / (2e4 * 2.0 / 7.0 * 0.5 * mass).sqrt();
    let case = json!({
        "title": "spheres", "space": "3d",
        "domain": { "min": [0, 0, 0], "max": size },
        "gravity": [0, 0, -9.81],
        "materials": { "s": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
        "bodies": [{ "name": "b", "material": "s", "points": { "file": "points.csv" },
                     "shape": { "kind": "box", "min": [0, 0, 0], "max": size } }],
        "boundaries": walls,
        "stages": [{ "name": "fall", "duration": 1.0 }],
        "methods": { "dem": {
            "grains": { "s": { "density": 2500.0 } },
            "pairs": [{ "between": ["s", "s"],
                "normal": { "law": "linear", "stiffness": 2e4, "damping_ratio": ratio, "clamp": false },
                "tangential": { "stiffness_ratio": 2.0 / 7.0, "damping_ratio": across },
                "friction": { "coefficient": 0.5 } }],
            "skin": 0.1, "time_step": 2e-5
        } }
    });
    let case = Case::from_value(&case, folder).expect("a valid case");
    let mut solver = spheres(&case).expect("a solver");
    solver.begin_stage(0, 0.0).expect("a stage");
    solver
}

/// Processor time of this thread, or wall-clock time where the system does not report it.
fn now(start: Instant) -> Duration {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let own = text.and_then(|text| text.split(' ').next().and_then(|ns| ns.parse().ok()));
    own.map_or_else(|| start.elapsed(), Duration::from_nanos)
}

/// Measured case.
struct Setting {
    name: &'static str,
    specimen: Specimen,
    /// Steps before the window.
    after: u64,
    /// Steps of the window, and of an iteration.
    steps: [u64; 2],
}

/// Steps of one window, repeated from its start when it is over.
fn window(criterion: &mut Criterion, setting: &Setting, threads: usize) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    let folder = tempfile::tempdir().expect("a folder");
    let mut group = criterion.benchmark_group(format!("{threads} threads"));
    let grains = setting.specimen.0.len();
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    group.warm_up_time(Duration::from_millis(1)).measurement_time(Duration::from_millis(10));
    group.throughput(Throughput::Elements(grains as u64 * setting.steps[1]));
    let mut solver: Option<DemSolver<3, 3>> = None;
    let (mut contacts, mut total, mut least) = (0.0, Duration::ZERO, f64::INFINITY);
    group.bench_function(BenchmarkId::new(setting.name, grains), |bencher| {
        bencher.iter_custom(|iterations| {
            pool.install(|| {
                let start = Instant::now();
                let mut spent = Duration::ZERO;
                for _ in 0..iterations {
                    let end = setting.after + setting.steps[0];
                    let mut own = solver
                        .take()
                        .filter(|solver| solver.step_count() + setting.steps[1] <= end)
                        .unwrap_or_else(|| {
                            let mut new = self::solver(&setting.specimen, folder.path());
                            for _ in 0..setting.after {
                                new.step(1.0).expect("a stable step");
                            }
                            new
                        });
                    let clock = || if threads == 1 { now(start) } else { start.elapsed() };
                    let before = clock();
                    for _ in 0..setting.steps[1] / 2 {
                        let (before, met) = (Instant::now(), contacts);
                        for _ in 0..2 {
                            own.step(1.0).expect("a stable step");
                            contacts += own.contact_count() as f64;
                        }
                        least = least.min(1e9 * before.elapsed().as_secs_f64() / (contacts - met));
                    }
                    spent += clock().saturating_sub(before);
                    solver = Some(own);
                }
                total += spent;
                spent
            })
        });
    });
    group.finish();
    let mean = 1e9 * total.as_secs_f64() / contacts;
    println!("{mean:.2} ns per contact, {least:.2} in the fastest two steps");
}

fn all(criterion: &mut Criterion) {
    let settings = [
        Setting { name: "loose, steps 0-2000", specimen: loose([20, 20, 25]), after: 0, steps: [2000, 2000] },
        Setting {
            name: "loose, steps 2000-10000",
            specimen: loose([20, 20, 25]),
            after: 2000,
            steps: [8000, 800],
        },
        Setting { name: "dense, steps 500-2500", specimen: dense(22), after: 500, steps: [2000, 200] },
    ];
    for threads in [1, 2] {
        settings.iter().for_each(|setting| window(criterion, setting, threads));
    }
}

criterion_group!(benches, all);
criterion_main!(benches);
