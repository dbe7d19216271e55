//! Collision of two elastic disks (sheet: mpm A-12; Sulsky et al. 1994).

use colluvium::plots::{LineChart, PointCloud, Series, Style};

use crate::analysis::MaxOrNan;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, measure_series, run_mpm, set_mpm_option};

/// Benchmark of the collision of two elastic disks.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/two-disks",
    title: "Collision of two elastic disks",
    source: "Sulsky, Chen & Schreyer 1994; sheet: mpm A-12",
    short_seconds: Some(1),
    full_seconds: 1,
    run: benchmark,
};

/// Reason of the tolerances of the sheet.
const BAND: &str = "the sheet's band, from an independent prototype and the geometry of contact";

/// Checks energies of a collision of two elastic disks.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart = LineChart::new("Energies", "time (s)", "energy (J/m)");
    for scheme in ["musl", "usl"] {
        let mut case = load_case("mpm/two-disks")?;
        set_mpm_option(&mut case, "stress_update", scheme);
        let report = run_mpm(&case)?;
        let (kinetic, elastic) =
            (measure_series(&report, "kinetic_energy"), measure_series(&report, "elastic_energy"));
        let smallest = kinetic.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1)).ok_or("no rows")?;
        let start = kinetic[0].1;
        let end = report.end.kinetic + report.end.elastic;
        let name = |what: &str| format!("{scheme}: {what}");
        outcome.assert_within(
            name("time of least kinetic energy (s)"),
            "1.90 to 2.00 s",
            smallest.0,
            (1.90, 2.00),
            BAND,
        );
        let bound = if scheme == "musl" { 0.999 } else { 0.95 };
        let claim = if scheme == "musl" { "at least 0.999" } else { "at least 0.95" };
        outcome.assert_within(
            name("energy at the end over energy at the start"),
            claim,
            end / start,
            (bound, 1.0005),
            BAND,
        );
        let kept = report.end.kinetic / start;
        outcome.assert_within(
            name("kinetic energy at the end over that at the start"),
            "at least 0.90",
            kept,
            (0.90, 1.0),
            BAND,
        );
        let momentum = report.end.momentum.iter().map(|p| p.abs()).max_or_nan();
        let scale = 130.0 * 0.1 * 2f64.sqrt();
        outcome.assert_below(
            name("momentum over that of one disk"),
            "0",
            momentum / scale,
            1e-12,
            "round-off of a sum over points",
        );
        let total = kinetic.iter().zip(&elastic).map(|(k, e)| (k.0, k.1 + e.1)).collect();
        if scheme == "musl" {
            chart.series.push(Series::new("kinetic", kinetic, Style::Line));
            chart.series.push(Series::new("elastic", elastic, Style::Line));
            let middle = &report.frames[report.frames.len() / 2];
            let cloud = PointCloud::from_snapshot(middle, "pressure", [0, 1]).ok_or("no pressure")?;
            outcome.png("Pressure during the collision.", &cloud)?;
        }
        chart.series.push(Series::new(format!("total, {scheme}"), total, Style::Dashed));
    }
    outcome.svg("The kinetic energy goes into the disks and comes back.", &chart)?;
    Ok(outcome)
}
