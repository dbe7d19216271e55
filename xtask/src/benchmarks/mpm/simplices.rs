//! Triangles and tetrahedra against closed forms: a column under its own weight, and its first axial mode.

use std::f64::consts::PI;

use colluvium::case::description::{Space, Velocity};
use colluvium::case::{Case, Snapshot};
use colluvium::plots::{LineChart, Series, Style};

use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, load_case, measure_series, run_mpm, set_mpm_option, stresses, vectors,
};

/// Benchmark of a column of triangles and of tetrahedra: self-weight and first mode.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/simplices",
    title: "Column in triangles and tetrahedra: own weight and first mode",
    source: "sheet: mpm §2.5b; closed forms of an oedometric column",
    short_seconds: Some(5),
    full_seconds: 5,
    run: benchmark,
};

/// Height of the column (m).
const HEIGHT: f64 = 1.0;
/// Density of the column (kg/m³).
const DENSITY: f64 = 1000.0;
/// Unit weight (N/m³).
const WEIGHT: f64 = 1e4;
/// Oedometric modulus (Pa).
const MODULUS: f64 = 1e7 * 0.75 / (1.25 * 0.5);

/// Checks stress and vibration of columns of triangles and of tetrahedra.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart = LineChart {
        series: vec![Series::new("closed form", vec![(0.0, -WEIGHT * HEIGHT), (HEIGHT, 0.0)], Style::Dashed)],
        ..LineChart::new("Vertical stress, cells of 0.1 m", "height (m)", "stress (Pa)")
    };
    for (space, name, cells) in
        [(Space::PlaneStrain, "triangles", [0.1, 0.05]), (Space::ThreeD, "tetrahedra", [0.2, 0.1])]
    {
        let mut errors = Vec::new();
        for cell in cells {
            let report = run_mpm(&column(space, cell)?)?;
            let (error, settlement) = at_rest(&report.snapshot);
            errors.push(error);
            if cell == cells[1] {
                let exact = WEIGHT * HEIGHT * HEIGHT / (2.0 * MODULUS);
                let reason = "the layer of elements that is the surface: an element over the height, and as much again";
                outcome.assert_close(
                    format!("{name}, cells of {cell} m: settlement (m)"),
                    exact,
                    2.0 * cell / HEIGHT,
                    settlement,
                    reason,
                );
                chart.series.push(Series::new(name, profile(&report.snapshot), Style::Markers));
            }
        }
        let reason = "constant stress in an element: first order, 2, with room for 1.6";
        outcome.assert_within(
            format!("{name}: mean error of stress, coarse over fine"),
            "2 (first order)",
            errors[0] / errors[1],
            (1.6, f64::INFINITY),
            reason,
        );
        let found = mode(space, cells[1])?;
        let exact = PI / 2.0 * (MODULUS / DENSITY).sqrt() / HEIGHT;
        let reason = "2 %: lumped mass and the average over points slow the wave by (πh/2L)²/6 and less, 0.4 %, and points cross no facet";
        outcome.assert_close(
            format!("{name}, cells of {} m: first frequency (rad/s)", cells[1]),
            exact,
            0.02,
            found,
            reason,
        );
    }
    outcome.svg("A column under its own weight.", &chart)?;
    Ok(outcome)
}

/// Case of the column in a space, on cells divided into triangles or tetrahedra.
fn column(space: Space, cell: f64) -> Result<Case, String> {
    let mut case = load_case(if space == Space::ThreeD { "mpm/simplices-3d" } else { "mpm/simplices" })?;
    set_mpm_option(&mut case, "cell_size", cell);
    Ok(case)
}

/// Mean error of vertical stress over that at the base, and settlement of the highest points (m).
fn at_rest(snapshot: &Snapshot) -> (f64, f64) {
    let displacement = vectors(snapshot, "displacement");
    let start: Vec<f64> = snapshot.positions.iter().zip(&displacement).map(|(x, u)| x[1] - u[1]).collect();
    let errors = start.iter().zip(stresses(snapshot)).map(|(y, s)| (s[1] + WEIGHT * (HEIGHT - y)).abs());
    let highest = start.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let top = start.iter().zip(&displacement).find(|(y, _)| **y == highest).map_or(f64::NAN, |(_, u)| -u[1]);
    (errors.sum::<f64>() / (start.len() as f64 * WEIGHT * HEIGHT), top)
}

/// Height (m) and vertical stress (Pa) of the points.
fn profile(snapshot: &Snapshot) -> Vec<(f64, f64)> {
    snapshot.positions.iter().zip(stresses(snapshot)).map(|(x, s)| (x[1], s[1])).collect()
}

/// Frequency of the first axial mode (rad/s), without gravity.
fn mode(space: Space, cell: f64) -> Result<f64, String> {
    let mut case = column(space, cell)?;
    case.gravity.fill(0.0);
    case.stages[0].damping = 0.0;
    case.stages[0].duration = 0.2;
    case.output.measures = Some(5e-4);
    let dimension = case.gravity.len();
    let along_y = |value: f64| (0..dimension).map(|c| if c == 1 { value } else { 0.0 }).collect();
    case.bodies[0].velocity =
        Velocity::Sine { amplitude: along_y(1e-3), wave_vector: along_y(PI / (2.0 * HEIGHT)), phase: 0.0 };
    let report = run_mpm(&case)?;
    let momentum = measure_series(&report, "momentum.y");
    let zero = |w: &[(f64, f64)]| {
        (w[0].1 * w[1].1 < 0.0).then(|| w[0].0 + (w[1].0 - w[0].0) * w[0].1 / (w[0].1 - w[1].1))
    };
    let zeros: Vec<f64> = momentum.windows(2).filter_map(zero).collect();
    let (Some(first), Some(last)) = (zeros.first(), zeros.last()) else { return Ok(f64::NAN) };
    Ok(PI * (zeros.len() - 1) as f64 / (last - first))
}
