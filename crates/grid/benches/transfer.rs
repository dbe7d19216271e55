//! Benchmark of the transfers (points per second) for every family of shape functions, on one thread.

use std::hint::black_box;

use colluvium_grid::{
    Basis, ContiguousGimpBasis, CubicSpline, GimpBasis, Grid, Layout, LinearBasis, NodalState, NodeSupport,
    QuadraticSpline, Stencil, Vector4, sort_by_cell,
};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

/// Positions of two points per cell and direction in the middle half of a box, sorted by cell.
fn points<const D: usize>(grid: &Grid<D>) -> Vec<[f64; D]> {
    let per_axis = grid.cells[0];
    let place = |number: usize| {
        let mut rest = number;
        std::array::from_fn(|_| {
            let index = rest % per_axis;
            rest /= per_axis;
            0.25 + 0.5 * (index as f64 + 0.5) / per_axis as f64
        })
    };
    let points: Vec<[f64; D]> = (0..per_axis.pow(D as u32)).map(place).collect();
    sort_by_cell(grid, &points).into_iter().map(|i| points[i as usize]).collect()
}

fn transfer<const D: usize, const S: usize, B: Basis<S>>(criterion: &mut Criterion, cells: usize) {
    let grid = Grid::new([0.0; D], [1.0; D], 1.0 / cells as f64).expect("a whole number of cells");
    let points = points(&grid);
    let extent = [0.5 * grid.cell; D];
    let mut layout = Layout::new::<S, B>(&grid);
    let bounds = layout.add_points(&points);
    let strides = layout.strides();
    let mut nodes = vec![NodalState::default(); layout.len()];
    let mut group = criterion.benchmark_group(format!("{D}d"));
    group.sample_size(20).throughput(Throughput::Elements(points.len() as u64));
    let motion = Vector4::new([1.0, 2.0, 3.0, 1.0]);
    group.bench_function(BenchmarkId::new("scatter", B::NAME), |bencher| {
        bencher.iter(|| {
            layout.reset(&mut nodes);
            layout.for_each_slab(&mut nodes, |slab, window, offset| {
                for x in &points[bounds[slab]..bounds[slab + 1]] {
                    let stencil = Stencil::<D, S>::new::<B>(&grid, x, &extent);
                    stencil.p2g(window, offset, &strides, motion, &[motion; D], None);
                }
            });
        });
    });
    group.bench_function(BenchmarkId::new("gather", B::NAME), |bencher| {
        bencher.iter(|| {
            for x in &points {
                let stencil = Stencil::<D, S>::new::<B>(&grid, x, &extent);
                black_box(stencil.g2p(&nodes, &strides));
            }
        });
    });
    group.finish();
}

fn all(criterion: &mut Criterion) {
    // Rayon would use all cores.
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first and only pool");
    transfer::<2, 2, LinearBasis>(criterion, 128);
    transfer::<2, 3, GimpBasis>(criterion, 128);
    transfer::<2, 4, ContiguousGimpBasis>(criterion, 128);
    transfer::<2, 3, QuadraticSpline>(criterion, 128);
    transfer::<2, 4, CubicSpline>(criterion, 128);
    transfer::<3, 2, LinearBasis>(criterion, 32);
    transfer::<3, 3, GimpBasis>(criterion, 32);
    transfer::<3, 4, ContiguousGimpBasis>(criterion, 32);
    transfer::<3, 3, QuadraticSpline>(criterion, 32);
    transfer::<3, 4, CubicSpline>(criterion, 32);
}

criterion_group!(benches, all);
criterion_main!(benches);
