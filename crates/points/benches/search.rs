//! Points per second of the cell list and of the neighbour lists.

use std::hint::black_box;

use colluvium_points::{CellList, HalfNeighbourList, NeighbourList, Shape, poisson_disk, random};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

/// About `count` random points in a box, and the radius (m) for about `neighbours` points within it.
fn points<const D: usize>(count: usize, neighbours: f64) -> (Vec<[f64; D]>, f64) {
    let shape = Shape::Box { min: vec![0.0; D], max: vec![1.0; D] };
    let samples = random::<D>(&shape, count, 1).expect("a box has a measure");
    let ball = if D == 2 { std::f64::consts::PI } else { 4.0 / 3.0 * std::f64::consts::PI };
    let radius = (neighbours / (ball * count as f64)).powf(1.0 / D as f64);
    (samples.into_iter().map(|sample| sample.position).collect(), radius)
}

fn search<const D: usize>(criterion: &mut Criterion, neighbours: f64) {
    let mut group = criterion.benchmark_group(format!("{D}d, {neighbours} neighbours"));
    group.sample_size(10);
    for count in [10_000, 100_000] {
        let (positions, radius) = points::<D>(count, neighbours);
        group.throughput(Throughput::Elements(count as u64));
        let mut cells = CellList::new();
        group.bench_function(BenchmarkId::new("cell list", count), |bencher| {
            bencher.iter(|| cells.build(black_box(&positions), radius).expect("finite points"));
        });
        let mut full = NeighbourList::new();
        group.bench_function(BenchmarkId::new("full list", count), |bencher| {
            bencher.iter(|| full.build(black_box(&positions), radius).expect("finite points"));
        });
        let mut half = HalfNeighbourList::new();
        group.bench_function(BenchmarkId::new("half list", count), |bencher| {
            bencher.iter(|| half.build(black_box(&positions), radius).expect("finite points"));
        });
    }
    group.finish();
}

fn sampling(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("poisson disk");
    group.sample_size(10);
    let disk = Shape::Ball { centre: vec![0.0, 0.0], radius: 1.0 };
    let ball = Shape::Ball { centre: vec![0.0; 3], radius: 1.0 };
    let flat = || poisson_disk::<2>(&disk, 0.01, 1).expect("a distance");
    let solid = || poisson_disk::<3>(&ball, 0.06, 1).expect("a distance");
    group.throughput(Throughput::Elements(flat().len() as u64));
    group.bench_function("2d", |bencher| bencher.iter(flat));
    group.throughput(Throughput::Elements(solid().len() as u64));
    group.bench_function("3d", |bencher| bencher.iter(solid));
    group.finish();
}

fn all(criterion: &mut Criterion) {
    search::<2>(criterion, 20.0);
    search::<3>(criterion, 50.0);
    sampling(criterion);
}

criterion_group!(benches, all);
criterion_main!(benches);
