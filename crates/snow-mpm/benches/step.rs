//! Point-updates per second of one step on one thread, with APIC: an elastic block, and a block of snow that gives way; and of the law
//! of this snow alone. The share of points that yield in a step is printed for each. Time is that of the processor where the system
//! reports it (Linux), so that what runs beside the bench counts for less.
//!
//! `cargo bench -p colluvium-snow-mpm -- 10000 points` measures what has this in its name; a million points take some minutes.

use std::time::{Duration, Instant};

use colluvium_case::{Case, Method, Snapshot, Solver};
use colluvium_constitutive::{
    BLOCK_SIZE, InitialCondition, Mat3, Material, MaterialSpec, Motion, MotionBlock, States, SymTensor,
};
use colluvium_snow_mpm::SnowMpm;
use criterion::{Bencher, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use serde_json::{Value, json};

/// Size of the block in a number of dimensions.
struct Size {
    dimension: usize,
    /// Cells along an edge of the block.
    cells: usize,
    /// Points, about.
    points: &'static str,
    /// Rate at which the block is pressed on the floor at the start (1/s).
    squeeze: f64,
    /// Steps before the clock starts: until the snow gives way.
    before: usize,
}

const SIZES: [Size; 6] = [
    Size { dimension: 2, cells: 50, points: "10000 points", squeeze: 0.0, before: 300 },
    Size { dimension: 3, cells: 11, points: "10000 points", squeeze: 0.0, before: 300 },
    Size { dimension: 2, cells: 158, points: "100000 points", squeeze: 5.0, before: 50 },
    Size { dimension: 3, cells: 23, points: "100000 points", squeeze: 5.0, before: 50 },
    Size { dimension: 2, cells: 500, points: "1000000 points", squeeze: 5.0, before: 50 },
    Size { dimension: 3, cells: 50, points: "1000000 points", squeeze: 5.0, before: 50 },
];

/// A block of 1 m on a rough floor, with two points per cell and direction.
fn block(size: &Size, shape: &str, material: &Value) -> Case {
    let (dimension, cell) = (size.dimension, 1.0 / size.cells as f64);
    let all = |value: f64| vec![value; dimension];
    let (mut gravity, mut floor) = (all(0.0), all(-1.0));
    (gravity[1], floor[1]) = (-9.81, 0.0);
    let mut pressed = vec![all(0.0); dimension];
    pressed[1][1] = -size.squeeze;
    let text = json!({
        "title": "step",
        "space": if dimension == 2 { "plane-strain" } else { "3d" },
        "domain": { "min": floor, "max": all(2.0) },
        "gravity": gravity,
        "materials": { "snow": material },
        "bodies": [{ "name": "block", "material": "snow", "remove_outside": true,
            "shape": { "kind": "box", "min": all(0.0), "max": all(1.0) },
            "velocity": { "kind": "linear", "value": all(0.0), "origin": all(0.0), "gradient": pressed } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "fall", "duration": 100.0 }],
        "methods": { "snow-mpm": { "cell_size": cell, "shape": shape } }
    });
    Case::from_json(&text.to_string()).expect("a valid case")
}

fn snow() -> Value {
    json!({ "model": "cohesive-cam-clay", "density": 250, "youngs_modulus": 3e6, "poissons_ratio": 0.3,
        "critical_state_slope": 0.8, "cohesion_ratio": 0.3, "hardening_factor": 1, "compressive_strength": 1000 })
}

fn materials() -> [(&'static str, Value); 2] {
    let elastic = json!({ "model": "linear-elastic", "strain_measure": "hencky", "density": 250, "youngs_modulus": 3e6,
        "poissons_ratio": 0.3 });
    [("elastic", elastic), ("cohesive Cam clay", snow())]
}

/// Time that the processor has spent on the threads of this program.
fn processor_time() -> Option<Duration> {
    let mut sum = 0;
    for task in std::fs::read_dir("/proc/self/task").ok()? {
        let text = std::fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        sum += text.split_whitespace().next()?.parse::<u64>().ok()?;
    }
    Some(Duration::from_nanos(sum))
}

/// Measures `count` runs at once, by the processor's time where there is one.
fn measure(bencher: &mut Bencher<'_>, mut run: impl FnMut()) {
    bencher.iter_custom(|count| {
        let (began, from) = (Instant::now(), processor_time());
        (0..count).for_each(|_| run());
        match (from, processor_time()) {
            (Some(from), Some(to)) => to - from,
            _ => began.elapsed(),
        }
    });
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
    changed as f64 / solver.point_count().max(1) as f64
}

/// A solver with the case under way.
fn started(case: &Case, before: usize) -> Box<dyn Solver> {
    let mut solver = SnowMpm.build(case).expect("a solver");
    solver.begin_stage(0, 0.0).expect("a stage");
    steps(&mut *solver, before);
    solver
}

fn step(criterion: &mut Criterion, size: &Size) {
    let mut group = criterion.benchmark_group(format!("{}d, {}", size.dimension, size.points));
    group.sample_size(10);
    let count = (2 * size.cells).pow(size.dimension as u32) as u64;
    for shape in ["quadratic", "cubic"] {
        for (name, material) in materials() {
            let case = block(size, shape, &material);
            group.throughput(Throughput::Elements(count));
            let mut solver = None;
            group.bench_function(BenchmarkId::new(shape, name), |bencher| {
                let solver = solver.get_or_insert_with(|| {
                    let mut solver = started(&case, size.before);
                    let (points, share) = (solver.point_count(), 100.0 * yielding(&mut *solver));
                    println!("{}d {shape} {name}: {points} points, {share:.0} % yield", size.dimension);
                    solver
                });
                measure(bencher, || steps(&mut **solver, 1));
            });
        }
    }
    group.finish();
}

/// Points of the law alone: what they hold fits the second-level cache.
const POINTS: usize = 16 * BLOCK_SIZE;

/// Points that are led on by the law alone.
#[derive(Clone)]
struct Led {
    motions: Vec<MotionBlock>,
    stresses: Vec<SymTensor>,
    states: States,
}

impl Led {
    /// Points without stress, each sheared and pressed in a way of its own by about `strain` a step, in the plane or in
    /// space.
    fn of(law: &dyn Material, planar: bool, strain: f64) -> Self {
        let free = InitialCondition { stress: SymTensor::ZERO, density: 250.0 };
        let (stresses, states) = law.initial(&[free; POINTS]).expect("no stress is admissible");
        let motion = |i: usize| {
            let turn = Mat3::rotation_z(i as f64);
            let mut f = Mat3::IDENTITY + Mat3([[1.0, 0.5, 0.2], [0.0, -1.5, 0.1], [0.3, 0.0, 0.1]]) * strain;
            if planar {
                (f.0[0][2], f.0[1][2], f.0[2]) = (0.0, 0.0, [0.0, 0.0, 1.0]);
            }
            let f = turn * f * turn.transpose();
            Motion::from_deformation(&f, 1e-4, 250.0, 0.1).expect("a step of this size is regular")
        };
        let block = |number: usize| {
            let mut block = MotionBlock::at_rest(1e-4, 0.1, planar);
            (0..BLOCK_SIZE).for_each(|i| block.set(i, &motion(number * BLOCK_SIZE + i)));
            block
        };
        Self { motions: (0..POINTS / BLOCK_SIZE).map(block).collect(), stresses, states }
    }

    fn step(&mut self, law: &dyn Material) {
        let parts = self.stresses.chunks_mut(BLOCK_SIZE).zip(&self.motions);
        for (block, (stresses, motions)) in self.states.blocks_mut().iter_mut().zip(parts) {
            law.update_block(motions, stresses, block).expect("an admissible step");
        }
    }

    /// Share of the points on the yield surface.
    fn yielding(&self, law: &dyn Material) -> f64 {
        let mut count = 0;
        for (block, stresses) in self.states.blocks().iter().zip(self.stresses.chunks(BLOCK_SIZE)) {
            let mut values = [0.0; BLOCK_SIZE];
            law.yield_values(stresses, block, &mut values);
            count += values.iter().zip(stresses).filter(|(y, stress)| **y > -1e-6 * stress.norm()).count();
        }
        count as f64 / POINTS as f64
    }
}

/// Updates per second of cohesive Cam clay, in blocks as a solver updates them.
fn law(criterion: &mut Criterion) {
    let spec: MaterialSpec = serde_json::from_value(snow()).expect("a material");
    let law = spec.build().expect("a law");
    let mut group = criterion.benchmark_group("cohesive Cam clay alone");
    group.throughput(Throughput::Elements((10 * POINTS) as u64));
    for (space, planar) in [("plane", true), ("space", false)] {
        for (name, strain, before) in [("elastic", 1e-6, 5), ("plastic", 1e-5, 300)] {
            let mut start = Led::of(&*law, planar, strain);
            (0..before).for_each(|_| start.step(&*law));
            let mut points = start.clone();
            (0..10).for_each(|_| points.step(&*law));
            println!("{space} {name}: {:.0} % yield", 100.0 * points.yielding(&*law));
            group.bench_function(BenchmarkId::new(space, name), |bencher| {
                measure(bencher, || {
                    // Every lap goes on from the same state.
                    points.stresses.clone_from(&start.stresses);
                    let states = points.states.blocks_mut().iter_mut().zip(start.states.blocks());
                    states.for_each(|(to, from)| to.clone_from(from));
                    (0..10).for_each(|_| points.step(&*law));
                });
            });
        }
    }
    group.finish();
}

fn all(criterion: &mut Criterion) {
    // Rayon would use all cores.
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first and only pool");
    law(criterion);
    SIZES.iter().for_each(|size| step(criterion, size));
}

criterion_group!(benches, all);
criterion_main!(benches);
