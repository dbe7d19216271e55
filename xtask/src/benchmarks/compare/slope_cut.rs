//! Factor of safety of a homogeneous slope, by MPM and SPH (sheet: sph §3.5).

use colluvium::plots::{LineChart, Series, Style};

use super::draw_failure;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, run_in_memory};

/// Benchmark of the factor of safety of a homogeneous cut slope.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "compare/slope-cut",
    title: "Factor of safety of a cut slope of 2:1, MPM and SPH",
    source: "Griffiths & Lane 1999, example 1; Bishop & Morgenstern 1960; Davis 1968",
    short_seconds: None,
    full_seconds: 240,
    run: benchmark,
};

/// Factor of safety by the charts of Bishop & Morgenstern (1960).
const CHARTS: f64 = 1.38;

/// Factor of safety with the strength of soil without dilatancy on a slip line (Davis 1968).
fn without_dilatancy() -> f64 {
    CHARTS * (20f64.to_radians().tan() / CHARTS).atan().cos()
}

/// Checks the factor of safety of a cut slope of 2:1 by two methods.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let case = load_case("compare/slope-cut")?;
    let mut picture = LineChart::new(
        "Displacement of trials at rest and in failure",
        "factor",
        "E u / (γ H²), no more than 3",
    );
    for method in ["mpm", "sph"] {
        let report = run_in_memory(method, &case)?;
        let found = report.safety.get("safety").ok_or("no factor of safety")?;
        outcome.assert_within(
            format!("{method}: factor of safety"),
            "1.38 by charts, 1.4 by finite elements",
            found.factor().unwrap_or(f64::NAN),
            (CHARTS - 0.05, CHARTS + 0.05),
            "± 0.05 on 20 cells over the height, without dilatancy",
        );
        outcome.assert_within(
            format!("{method}: largest factor with which it stands"),
            "at most the factor of the charts",
            found.stable_factor,
            (0.0, CHARTS),
            "an upper end of what soil without dilatancy can have",
        );
        outcome.assert_within(
            format!("{method}: least factor with which it fails"),
            &format!("at least {:.3}, by Davis's strength", without_dilatancy()),
            found.failing_factor,
            (without_dilatancy(), f64::INFINITY),
            "the lower end",
        );
        let mut points: Vec<(f64, f64)> =
            found.trials.iter().map(|trial| (trial.factor, trial.dimensionless_displacement)).collect();
        points.retain(|(_, displacement)| *displacement <= 3.0);
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        picture.series.push(Series::new(method, points, Style::Line));
        draw_failure(&mut outcome, method, &report)?;
    }
    outcome.svg("Displacement that a hundredth of the points exceed, over the factor.", &picture)?;
    Ok(outcome)
}
