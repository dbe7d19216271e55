//! Liquid in a square cavity with a moving lid (Ghia, Ghia & Shin 1982).

use colluvium::case::{Case, Snapshot};
use colluvium::plots::{LineChart, PointCloud, Series, Style};

use crate::analysis::MaxOrNan;
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, load_case, reference_curve, reference_table, run_in_memory, set_material,
    set_method_option, vectors,
};

/// Benchmark of a liquid in a cavity with a moving lid.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/cavity",
    title: "Lid-driven cavity, SPH",
    source: "Ghia, Ghia & Shin 1982, Tables I and II",
    short_seconds: Some(30),
    full_seconds: 1500,
    run: cavities,
};

/// Position of the misprinted value of v at a Reynolds number of 400.
const MISPRINT: f64 = 0.9063;

/// Reynolds number and the time until the flow is steady (s).
const FLOWS: [(u32, f64); 2] = [(100, 15.0), (400, 40.0)];

/// Case of a cavity with a Reynolds number.
fn cavity(reynolds: u32, duration: f64, spacing: f64) -> Result<Case, String> {
    let mut case = load_case("sph/cavity")?;
    set_method_option(&mut case, "sph", "spacing", spacing);
    set_material(&mut case, "m", &[("viscosity", (1000.0 / f64::from(reynolds)).into())])?;
    case.stages[0].duration = duration;
    Ok(case)
}

/// Velocity at a position from the best-fit linear field of the particles within three spacings, weighted by distance.
fn velocity_at(snapshot: &Snapshot, place: [f64; 2], spacing: f64) -> [f64; 2] {
    let reach = 3.0 * spacing;
    let (mut moments, mut sums) = ([[0.0; 3]; 3], [[0.0; 3]; 2]);
    for (x, v) in snapshot.positions.iter().zip(vectors(snapshot, "velocity")) {
        let (a, b) = ((x[0] - place[0]) / reach, (x[1] - place[1]) / reach);
        let weight = (1.0 - a * a - b * b).max(0.0).powi(2);
        let basis = [1.0, a, b];
        for i in 0..3 {
            (0..3).for_each(|j| moments[i][j] += weight * basis[i] * basis[j]);
            (0..2).for_each(|c| sums[c][i] += weight * basis[i] * v[c]);
        }
    }
    // First unknown of each system, by Cramer's rule.
    let determinant = |m: &[[f64; 3]; 3]| {
        let minor = |a: usize, b: usize| m[1][a] * m[2][b] - m[1][b] * m[2][a];
        m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1)
    };
    let whole = determinant(&moments);
    sums.map(|sum| {
        let mut replaced = moments;
        (0..3).for_each(|i| replaced[i][0] = sum[i]);
        determinant(&replaced) / whole
    })
}

/// Checks velocities in a cavity with a moving lid against published tables.
fn cavities(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let table = reference_table("sph/cavity/reference.csv")?;
    // The bound applies to 100 particles; the short form only tests that the benchmark runs.
    let (spacing, flows, bound) = if quick { (0.025, &FLOWS[..1], 0.06) } else { (0.01, &FLOWS[..], 0.03) };
    for &(reynolds, duration) in flows {
        let report = run_in_memory("sph", &cavity(reynolds, duration, spacing)?)?;
        let count = (1.0 / spacing).round();
        let mut chart = LineChart::new(
            format!("Cavity at a Reynolds number of {reynolds}"),
            "place along the line through the middle",
            "velocity across it over that of the lid",
        );
        for (component, place, name) in [(0, "place", "u"), (1, "across", "v")] {
            let published = reference_curve(&table, place, &format!("{name}_{reynolds}"))?;
            let on_line = |s: f64| if component == 0 { [0.5, s] } else { [s, 0.5] };
            let found = |s: f64| velocity_at(&report.snapshot, on_line(s), spacing)[component];
            let judged = published.iter().filter(|(s, _)| (reynolds, name) != (400, "v") || *s != MISPRINT);
            let worst = judged.map(|(s, exact)| (found(*s) - exact).abs()).max_or_nan();
            outcome.assert_below(
                format!("Re {reynolds}, {name}, largest difference over the speed of the lid"),
                "0",
                worst,
                bound,
                &format!("{bound} with {count} particles along a side"),
            );
            let line = (1..100).map(|k| f64::from(k) / 100.0).map(|s| (s, found(s))).collect();
            chart.series.push(Series::new(format!("{name}, SPH"), line, Style::Line));
            chart.series.push(Series::new(format!("{name}, Ghia et al."), published, Style::Markers));
        }
        outcome.svg("Velocities on the lines through the middle.", &chart)?;
        if let Some(cloud) = PointCloud::from_snapshot(&report.snapshot, "velocity", [0, 1]) {
            outcome.png(&format!("Speed at a Reynolds number of {reynolds}."), &cloud)?;
        }
    }
    Ok(outcome)
}
