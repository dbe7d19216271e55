//! Elastic bar in its first mode, by MPM, SPH and snow MPM.

use std::f64::consts::PI;

use colluvium::plots::{LineChart, Series, Style};

use super::MethodComparison;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, run_in_memory};

/// Benchmark of an elastic bar that vibrates in its first mode, computed by MPM, SPH and snow MPM.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "compare/elastic-bar",
    title: "Elastic bar in its first mode, MPM, SPH and snow MPM",
    source: "closed form",
    short_seconds: Some(6),
    full_seconds: 6,
    run: benchmark,
};

/// Wave speed of the bar (m/s).
fn speed() -> f64 {
    let (modulus, ratio, density) = (1e6, 0.3, 400.0);
    f64::sqrt(modulus * (1.0 - ratio) / ((1.0 + ratio) * (1.0 - 2.0 * ratio)) / density)
}

/// Times at which a curve changes its sign.
fn crossings(curve: &[(f64, f64)]) -> Vec<f64> {
    let pairs = curve.windows(2).filter(|pair| pair[0].1 * pair[1].1 < 0.0);
    pairs.map(|pair| pair[0].0 + (pair[1].0 - pair[0].0) * pair[0].1 / (pair[0].1 - pair[1].1)).collect()
}

/// Checks the period and the energy of a longitudinally vibrating bar by three methods.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let case = load_case("compare/elastic-bar")?;
    let period = 4.0 / speed();
    let mut picture = LineChart::new(
        "Momentum of an elastic bar in its first mode",
        "time (s)",
        "momentum over that at the start",
    );
    let mut together = MethodComparison::default();
    for method in ["mpm", "sph", "snow-mpm"] {
        let report = run_in_memory(method, &case)?;
        together.add_run(method, &report);
        let momentum = report.table.pairs("time", "momentum.x").ok_or("no momentum")?;
        let first = momentum.first().map_or(f64::NAN, |(_, momentum)| *momentum);
        outcome.assert_close(
            format!("{method}: momentum at the start (kg m/s)"),
            80.0 * 0.058 * 2.0 / PI,
            1e-3,
            first,
            "midpoints of the points",
        );
        // A quarter of the period and every half period after it.
        let crossings = crossings(&momentum);
        outcome.assert_within(
            format!("{method}: period over that of the closed form"),
            "1",
            crossings.get(3).map_or(f64::NAN, |time| time / (1.75 * period)),
            (0.98, 1.02),
            "2 %: the free end lies within a spacing, 1 % of the length, of the last points",
        );
        let energy = |name: &str| report.table.last(name).unwrap_or(f64::NAN);
        let kinetic = report.table.column("kinetic_energy").and_then(|values| values.first().copied());
        outcome.assert_within(
            format!("{method}: kinetic and elastic energy after two periods over those at the start"),
            "1",
            (energy("kinetic_energy") + energy("elastic_energy")) / kinetic.unwrap_or(f64::NAN),
            (0.98, 1.01),
            "2 % lost, none gained but for half a step between velocity and stress",
        );
        let line = momentum.into_iter().map(|(time, momentum)| (time, momentum / first)).collect();
        picture.series.push(Series::new(method, line, Style::Line));
    }
    let exact = (0..=200).map(|k| 0.14 * f64::from(k) / 200.0);
    let line = exact.map(|time| (time, (2.0 * PI * time / period).cos())).collect();
    picture.series.push(Series::new("closed form", line, Style::Dashed));
    outcome.svg("Two periods.", &picture)?;
    together.write_sections(&mut outcome, &case, "compare/elastic-bar")?;
    Ok(outcome)
}
