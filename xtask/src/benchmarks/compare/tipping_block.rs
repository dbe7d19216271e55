//! Tall rigid block that tips over its lower corner, falls flat and comes to rest, by MPM and SPH: in both the same corners of the block
//! are in contact.

use std::f64::consts::FRAC_PI_2;

use colluvium::case::RunReport;
use colluvium::plots::{LineChart, Series, Style};

use super::MethodComparison;
use crate::analysis::MaxOrNan;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, run_in_memory};

/// Benchmark of a tall rigid block that tips over, computed by MPM and SPH.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "compare/tipping-block",
    title: "A tall rigid block tips on a slope, falls flat and rests: MPM and SPH",
    source: "closed form",
    short_seconds: Some(8),
    full_seconds: 8,
    run: benchmark,
};

/// Width and height of the block (m).
const SIZE: [f64; 2] = [0.2, 0.6];
/// Mass of the block (kg/m).
const MASS: f64 = 240.0;
/// Gravitational acceleration along and normal to the slope of 30° (m/s²).
const GRAVITY: [f64; 2] = [5.0, -8.66];
/// Time until which the corner does not slip (s).
const NO_SLIP_END: f64 = 0.4;

/// Time (s) and value of a scalar quantity.
type TimeSeries = [(f64, f64)];

/// Angle (rad) over time (s) of a block that rotates about its lower corner under its weight.
fn pendulum() -> Vec<(f64, f64)> {
    let [width, height] = SIZE;
    let inertia = (width * width + height * height) / 3.0;
    let (mut angle, mut spin, per_row, dt) = (0.0, 0.0, 1000, 1e-5);
    let mut rows = vec![(0.0, 0.0)];
    while rows.len() as f64 * 0.01 <= NO_SLIP_END + 1e-9 {
        for _ in 0..per_row {
            // From the corner to the centre of mass.
            let (sin, cos) = f64::sin_cos(angle);
            let (x, y) = (-0.5 * width * cos + 0.5 * height * sin, 0.5 * width * sin + 0.5 * height * cos);
            spin += dt * (GRAVITY[0] * y - GRAVITY[1] * x) / inertia;
            angle += dt * spin;
        }
        rows.push((rows.len() as f64 * 0.01, angle));
    }
    rows
}

/// Checks the rotation of a tipping block against the equation of a physical pendulum, and that it comes to rest on its side.
fn benchmark(_: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let case = load_case("compare/tipping-block")?;
    let exact = pendulum();
    let mut picture = LineChart::new("Turn of a block on a slope of 30°", "time (s)", "angle (degrees)");
    let degrees = |rows: &[(f64, f64)]| -> Vec<(f64, f64)> {
        rows.iter().map(|row| (row.0, row.1.to_degrees())).collect()
    };
    let mut together = MethodComparison::default();
    let mut both = Vec::new();
    for method in ["mpm", "sph"] {
        let report = run_in_memory(method, &case)?;
        let turned: Vec<(f64, f64)> =
            pairs(&report, "block.angle")?.into_iter().map(|(time, angle)| (time, -angle)).collect();
        judge(&mut outcome, method, &report, (&turned, &exact))?;
        picture.series.push(Series::new(method, degrees(&turned), Style::Line));
        together.add_run(method, &report);
        both.push(turned);
    }
    let apart = both[0].iter().zip(&both[1]).map(|(mpm, sph)| (mpm.1 - sph.1).abs()).max_or_nan();
    outcome.assert_below(
        "largest difference of the angle between mpm and sph (rad)",
        "the same mechanics",
        apart,
        2e-3,
        "about a thousandth of a quarter turn",
    );
    picture.series.push(Series::new("closed form, corner held", degrees(&exact), Style::Dashed));
    outcome.svg("Angle by which the block has turned.", &picture)?;
    together.write_sections(&mut outcome, &case, "compare/tipping-block")?;
    Ok(outcome)
}

/// Checks the angle (rad) over time (s) of a run against the closed form.
fn judge(
    outcome: &mut BenchmarkOutcome,
    method: &str,
    report: &RunReport,
    (turned, exact): (&TimeSeries, &TimeSeries),
) -> Result<(), String> {
    let apart = turned.iter().zip(exact).map(|(own, exact)| (own.1 - exact.1).abs()).max_or_nan();
    outcome.assert_below(
        format!("{method}: largest error of the angle in {NO_SLIP_END} s over the angle then"),
        "a block that turns about its lower corner",
        apart / exact[exact.len() - 1].1,
        5e-3,
        "0.5 %",
    );
    outcome.assert_below(
        format!("{method}: angle at the end less a quarter turn (rad)"),
        "flat on its side",
        (turned[turned.len() - 1].1 - FRAC_PI_2).abs(),
        1e-3,
        "a thousandth",
    );
    let total = pairs(report, "total_energy")?;
    let rise = total.windows(2).map(|pair| pair[1].1 - pair[0].1).max_or_nan();
    outcome.assert_below(
        format!("{method}: largest rise of the total energy from row to row over what the blow takes"),
        "no blow gives energy",
        rise.max(0.0) / (total[0].1 - total[total.len() - 1].1),
        1e-3,
        "a thousandth",
    );
    let reactions = pairs(report, "bearing.y")?;
    outcome.assert_below(
        format!("{method}: force on the ground at the end over the weight across it, less one"),
        "its weight",
        (reactions[reactions.len() - 1].1 / (MASS * GRAVITY[1]) - 1.0).abs(),
        1e-3,
        "a thousandth",
    );
    Ok(())
}

/// Pairs of time (s) and value of a column of measures.
fn pairs(report: &RunReport, column: &str) -> Result<Vec<(f64, f64)>, String> {
    report.table.pairs("time", column).ok_or_else(|| format!("no column {column}"))
}
