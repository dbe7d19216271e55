//! Column that settles under its weight (sheet: sph §5.3, V-32).

use colluvium::case::Snapshot;
use colluvium::plots::{LineChart, Series, Style};

use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, load_case, run_in_memory, set_method_option, stresses, vectors,
};

/// Benchmark of a column that settles under its weight.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/geostatic",
    title: "Geostatic column, SPH",
    source: "sheet: sph §5.3, V-32",
    short_seconds: Some(24),
    full_seconds: 72,
    run,
};

/// Height of the column (m).
const HEIGHT: f64 = 0.1;
/// Unit weight (N/m³).
const WEIGHT: f64 = 2040.0 * 9.81;
/// Lateral stress ratio of a confined column, `ν / (1 - ν)`.
const K0: f64 = 0.3 / 0.7;
/// Modulus of uniaxial strain (Pa).
const MODULUS: f64 = 5.84e6 * 0.7 / (1.3 * 0.4);

/// Checks stresses of a column that settles under its weight, with three kinds of walls.
fn run(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart =
        LineChart::new("Vertical stress of a column under its weight", "height (m)", "vertical stress (Pa)");
    let exact: Vec<(f64, f64)> = vec![(0.0, -WEIGHT * HEIGHT), (HEIGHT, 0.0)];
    chart.series.push(Series::new("closed form", exact, Style::Dashed));
    let walls = [
        ("extrapolated", 0.01, "V-32: 1 % with the weight carried into the wall; the sheet's code 0.54 %"),
        ("interpolated", 0.04, "V-32: 4 % without; the sheet's code 2.70 %"),
        ("pairwise", 0.04, "V-32: 4 % without; the sheet gives no value for this wall"),
    ];
    for &(wall, bound, reason) in if quick { &walls[..1] } else { &walls[..] } {
        let mut case = load_case("sph/geostatic")?;
        set_method_option(&mut case, "sph", "wall_stress", wall);
        let snapshot = run_in_memory("sph", &case)?.snapshot;
        judge(&mut outcome, wall, bound, reason, &snapshot);
        let column =
            snapshot.positions.iter().zip(stresses(&snapshot)).filter(|(x, _)| (x[0] - 0.1).abs() < 0.005);
        let points = column.map(|(x, s)| (x[1], s.component(1, 1))).collect();
        chart.series.push(Series::new(format!("{wall} wall"), points, Style::Markers));
    }
    outcome.svg("Stress of the particles in the middle of the column.", &chart)?;
    Ok(outcome)
}

/// Checks the errors of vertical and lateral stress with a kind of wall.
fn judge(outcome: &mut BenchmarkOutcome, wall: &str, bound: f64, reason: &str, snapshot: &Snapshot) {
    let errors = snapshot.positions.iter().zip(stresses(snapshot)).map(|(x, s)| {
        let vertical = -WEIGHT * (HEIGHT - x[1]);
        [s.component(1, 1) - vertical, s.component(0, 0) - K0 * vertical, s.component(2, 2) - K0 * vertical]
    });
    let errors: Vec<[f64; 3]> = errors.collect();
    let rms = |c: usize| {
        let sum: f64 = errors.iter().map(|e| e[c] * e[c]).sum();
        (sum / errors.len() as f64).sqrt() / (WEIGHT * HEIGHT)
    };
    let name = format!("{wall} wall: rms error of σ_yy over ρgH");
    outcome.assert_below(name, "0", rms(0), bound, reason);
    let lateral = rms(1).max(rms(2));
    let unjudged = "not judged: the sheet bounds σ_yy only";
    outcome.info(format!("{wall} wall: rms error of σ_xx, σ_zz over ρgH"), "0", lateral, unjudged);
    let top = snapshot.positions.iter().zip(vectors(snapshot, "displacement"));
    let top: Vec<f64> = top.filter(|(x, _)| x[1] > HEIGHT - 0.005).map(|(_, u)| -u[1]).collect();
    let settlement = top.iter().sum::<f64>() / top.len() as f64;
    let exact = WEIGHT * HEIGHT * HEIGHT / (2.0 * MODULUS);
    let reason = "the tolerance of V-32's stresses; the sheet's code has 1.3e-5";
    outcome.assert_close(
        format!("{wall} wall: settlement of the surface (m)"),
        exact,
        bound,
        settlement,
        reason,
    );
}
