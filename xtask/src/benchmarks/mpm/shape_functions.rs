//! Shape functions of the background grid: partition of unity, cell crossing, conservation by the transfer (sheet: mpm S-04, S-05, A-01, A-02).

use colluvium::grid::{
    Basis, ContiguousGimpBasis, CubicSpline, GimpBasis, Grid, LinearBasis, NodalState, NodeSupport,
    QuadraticSpline, Stencil, Vector4,
};
use rand::{RngExt, SeedableRng};

use crate::analysis::MaxOrNan;
use crate::benchmarks::BenchmarkOutcome;

/// Largest deviation of shape functions from the partition of unity and from the reproduction of linear fields.
fn deviation<const S: usize, B: Basis<S>>(width: f64) -> f64 {
    /// Number of cells of the tested grid.
    const CELLS: usize = 12;
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let mut worst = 0f64;
    for _ in 0..10_000 {
        let x: f64 = random.random_range(3.0..9.0);
        let (first, weights, slopes) = B::evaluate(x, width, CELLS);
        let sums = (0..S).fold([0.0; 4], |[one, none, place, unit], k| {
            let node = B::coordinate(first + k, CELLS);
            [one + weights[k], none + slopes[k], place + weights[k] * node, unit + slopes[k] * node]
        });
        let errors = [sums[0] - 1.0, sums[1], sums[2] - x, sums[3] - 1.0];
        worst = errors.iter().fold(worst, |worst, error| worst.max(error.abs()));
    }
    worst
}

/// Checks that shape functions are a partition of unity and reproduce linear fields (S-05 and A-01).
pub fn shape_functions(outcome: &mut BenchmarkOutcome) {
    let table = [
        (0.0, 0.875, 0.0),
        (0.1, 0.855, -0.4),
        (0.25, 0.75, -1.0),
        (0.5, 0.5, -1.0),
        (0.75, 0.25, -1.0),
        (1.0, 0.0625, -0.5),
        (1.2, 0.0025, -0.1),
        (1.25, 0.0, 0.0),
    ];
    let mut worst = 0f64;
    for (x, value, slope) in table {
        for (found, of) in [gimp::<3, GimpBasis>(x, 0.5), gimp::<4, ContiguousGimpBasis>(x, 0.5)]
            .iter()
            .flat_map(|f| [(f.0, value), (f.1, slope)])
        {
            worst = worst.max((found - of).abs());
        }
    }
    outcome.assert_below(
        "S-05 GIMP functions: distance from the table, l_p = h/2",
        "0",
        worst,
        1e-12,
        "the sheet's 1e-12",
    );
    let families = [
        ("linear", deviation::<2, LinearBasis>(0.5)),
        ("GIMP", deviation::<3, GimpBasis>(0.5)),
        ("wide GIMP, l_p = 1.4h", deviation::<4, ContiguousGimpBasis>(1.4)),
        ("quadratic", deviation::<3, QuadraticSpline>(0.5)),
        ("cubic", deviation::<4, CubicSpline>(0.5)),
    ];
    for (name, error) in families {
        let name = format!("A-01 {name}: partition of unity and linear fields at 10⁴ points, worst");
        outcome.assert_below(name, "0", error, 1e-12, "the sheet's 1e-12");
    }
}

/// Value and slope of the shape function of node 6 at a distance `x` above it (cells).
fn gimp<const S: usize, B: Basis<S>>(x: f64, width: f64) -> (f64, f64) {
    let (first, weights, slopes) = B::evaluate(6.0 + x, width, 12);
    let of = (0..S).find(|k| B::coordinate(first + k, 12) == 6.0);
    of.map_or((0.0, 0.0), |k| (weights[k], slopes[k]))
}

/// Checks nodal forces when points cross cells: three cells with three, two and three points of equal volume under a uniform stress (S-04
/// and A-34).
pub fn cell_crossing(outcome: &mut BenchmarkOutcome) {
    let (stress, volume) = (2.0, 1.0 / 3.0);
    let places = [1.0 / 6.0, 0.5, 5.0 / 6.0, 1.25, 1.75, 2.0 + 1.0 / 6.0, 2.5, 2.0 + 5.0 / 6.0];
    let standard = inner_forces::<2, LinearBasis>(&places, &[volume; 8], stress);
    for (node, exact) in [(0, stress * volume), (1, -stress * volume)] {
        let name = format!("S-04 standard MPM: force at inner node {} (N)", node + 1);
        outcome.assert_close(name, exact, 1e-12, standard[node], "exact; ± σ Ω_p");
    }
    // Domains that fill the line: a third of a cell, and half of one in the middle cell.
    let widths = [volume, volume, volume, 0.5, 0.5, volume, volume, volume];
    let gimp = inner_forces::<3, GimpBasis>(&places, &widths, stress);
    let worst = gimp.iter().map(|force| force.abs()).max_or_nan();
    outcome.assert_below(
        "S-04 GIMP with domains that fill the line: force at inner nodes (N)",
        "0",
        worst,
        1e-12,
        "round-off",
    );
}

/// Internal forces `Σ Ω σ G` at the two inner nodes of three cells of 1 m. The points are as wide as their volumes.
fn inner_forces<const S: usize, B: Basis<S>>(places: &[f64], volumes: &[f64], stress: f64) -> [f64; 2] {
    let grid = Grid { origin: [0.0], cell: 1.0, cells: [3] };
    let mut nodes = vec![NodalState::default(); B::nodes(3)];
    for (place, volume) in places.iter().zip(volumes) {
        let stencil = Stencil::<1, S>::new::<B>(&grid, &[*place], &[*volume]);
        let column = [Vector4::new([volume * stress, 0.0, 0.0, 0.0])];
        stencil.p2g(&mut nodes, 0, &[1], Vector4::ZERO, &column, None);
    }
    [1.0, 2.0].map(|x| {
        let node = (0..nodes.len()).find(|i| B::coordinate(*i, 3) == x).unwrap_or(0);
        nodes[node].force.as_array()[0]
    })
}

/// Largest difference between sums of mass and momentum over nodes and over random points, over the sum of their sizes.
fn max_conservation_error<const S: usize, B: Basis<S>>() -> f64 {
    let grid = Grid { origin: [0.0; 2], cell: 0.1, cells: [6; 2] };
    let across = B::nodes(6);
    let mut nodes = vec![NodalState::default(); across * across];
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(2);
    let (mut sums, mut sizes) = ([0.0; 4], [0.0; 4]);
    for _ in 0..1000 {
        let mass: f64 = random.random_range(0.5..2.0);
        let [x, y, u, v]: [f64; 4] = std::array::from_fn(|_| random.random_range(-1.0..1.0));
        let place = [x, y].map(|c| 0.3 + 0.27 * c);
        let motion = [mass * u, mass * v, 0.0, mass];
        let stencil = Stencil::<2, S>::new::<B>(&grid, &place, &[0.05; 2]);
        stencil.p2g(&mut nodes, 0, &[across, 1], Vector4::new(motion), &[Vector4::ZERO; 2], None);
        for c in 0..4 {
            sums[c] += motion[c];
            sizes[c] += motion[c].abs();
        }
    }
    let on_nodes = |c: usize| nodes.iter().map(|node| node.momentum_and_mass.as_array()[c]).sum::<f64>();
    [0, 1, 3].iter().map(|&c| (on_nodes(c) - sums[c]).abs() / sizes[c]).max_or_nan()
}

/// Checks that transfers conserve mass and momentum.
pub fn transfers(outcome: &mut BenchmarkOutcome) {
    for (shape, lost) in [
        ("linear", max_conservation_error::<2, LinearBasis>()),
        ("GIMP", max_conservation_error::<3, GimpBasis>()),
        ("quadratic", max_conservation_error::<3, QuadraticSpline>()),
        ("cubic", max_conservation_error::<4, CubicSpline>()),
    ] {
        let name =
            format!("A-02 {shape}: mass and momentum of the nodes less those of 10³ points, over Σ m, Σ |p|");
        outcome.assert_below(name, "0", lost, 1e-12, "the sheet's 1e-12");
    }
}
