//! Laguerre cells of disks (sheet: dem §5, B17.6).

use std::f64::consts::PI;

use colluvium::dem::boundary::periodic_cell::PeriodicCell;
use colluvium::dem::output::laguerre_tessellation::tessellate;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::analysis::max_or_nan;
use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of the Laguerre cells of disks.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/cells",
    title: "Cells of disks: lattices, a periodic packing, a contact, DEM",
    source: "sheet: dem §5, B17.6",
    short_seconds: Some(1),
    full_seconds: 1,
    run: |_| cells(),
};

/// Number of rows of a lattice, and of disks in each row.
const ROWS: i32 = 12;

/// Largest difference between the solid fractions of the Laguerre cells of a lattice of touching disks and `exact`.
fn lattice(rise: f64, shift: f64, exact: f64) -> f64 {
    let number = f64::from(ROWS);
    let places: Vec<[f64; 2]> = (0..ROWS * ROWS)
        .map(|k| {
            let row = f64::from(k / ROWS);
            [f64::from(k % ROWS) + 0.25 + shift * (row % 2.0), rise * (row + 0.5)]
        })
        .collect();
    let cell = PeriodicCell::new([0.0; 2], [number, number * rise], [true; 2]);
    let found = tessellate(&places, &vec![0.5; places.len()], &cell, &[]);
    found.area.iter().map(|area| (0.25 * PI / area - exact).abs()).fold(0.0, max_or_nan)
}

/// Checks Laguerre cells of lattices and of a periodic packing.
fn cells() -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let reason = "B17.6; round-off";
    let hexagonal = PI * 3f64.sqrt() / 6.0;
    outcome.assert_below(
        "square lattice: error of π/4 of each cell",
        "0",
        lattice(1.0, 0.0, PI / 4.0),
        1e-12,
        reason,
    );
    let error = lattice(0.75f64.sqrt(), 0.5, hexagonal);
    outcome.assert_below("hexagonal lattice: error of π √3/6 of each cell", "0", error, 1e-12, reason);
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let places: Vec<[f64; 2]> =
        (0..90).map(|_| [10.0 * random.random::<f64>(), 10.0 * random.random::<f64>()]).collect();
    let radii: Vec<f64> = (0..90).map(|_| 0.2 + 0.4 * random.random::<f64>()).collect();
    let all: f64 = tessellate(&places, &radii, &PeriodicCell::new([0.0; 2], [10.0; 2], [true; 2]), &[])
        .area
        .iter()
        .sum();
    outcome.assert_close(
        "90 disks in a period of 100 m²: sum of the cells (m²)",
        100.0,
        1e-10,
        all,
        "B17.6: 1e-10",
    );
    let ends = [([-1.0, 0.0], 1.0), ([1.0, 0.0], 2.0), ([0.0, -1.0], 1.0), ([0.0, 1.0], 1.0)];
    let cell = PeriodicCell::new([-1.0, -1.0], [2.0, 1.0], [false; 2]);
    let pair = tessellate(&[[0.0; 2], [1.5, 0.0]], &[1.0, 0.5], &cell, &ends);
    let contact = pair.area[0] / 2.0 - 1.0;
    let reason = "B17.6: both have the tangent at their contact; round-off";
    outcome.assert_close(
        "disks of 1 m and 0.5 m that touch: place of the edge (m)",
        1.0,
        1e-12,
        contact,
        reason,
    );
    Ok(outcome)
}
