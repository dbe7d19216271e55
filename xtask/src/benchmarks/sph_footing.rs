//! Bearing capacity of a strip footing (SPH sheet V-39; B-07).

use colluvium::case::Snapshot;
use colluvium::case::plot::{LineChart, PointCloud, Series, Style};

use super::{Benchmark, Outcome, case, run_by, set_of, stresses};

/// The benchmark.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/footing",
    title: "Strip footing: Prandtl's bearing capacity, SPH",
    source: "Prandtl 1921; Bui & Nguyen 2021, Fig. 24; SPH sheet V-39",
    run,
};

const COHESION: f64 = 10e3;
const WIDTH: f64 = 1.0;
/// Depths between which the vertical force is taken (m): it is the same at all of them.
const DEPTHS: std::ops::Range<f64> = 1.0..2.0;
const SOIL: f64 = 4.0;

/// Mean vertical force over the depths, over the effective width of half the footing, in cohesions.
fn pressure(snapshot: &Snapshot, spacing: f64) -> f64 {
    let stress = stresses(snapshot);
    let force: f64 = snapshot
        .positions
        .iter()
        .zip(&stress)
        .zip(&snapshot.extents)
        .filter(|((x, _), _)| DEPTHS.contains(&(SOIL - x[1])))
        .map(|((_, s), e)| -s.at(1, 1) * e[0] * e[1])
        .sum();
    let depth = DEPTHS.end - DEPTHS.start;
    force / depth / (0.5 * (WIDTH + spacing)) / COHESION
}

fn run(quick: bool) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    let mut chart = LineChart {
        title: "Strip footing on clay".into(),
        x_label: "settlement over width".into(),
        y_label: "pressure over cohesion".into(),
        ..LineChart::default()
    };
    let exact = 2.0 + std::f64::consts::PI;
    let spacings: &[f64] = if quick { &[0.1] } else { &[0.1, 0.05] };
    for &spacing in spacings {
        let mut case = case("sph/footing")?;
        set_of(&mut case, "sph", "spacing", spacing);
        let report = run_by("sph", &case)?;
        let curve: Vec<(f64, f64)> = report
            .frames
            .iter()
            .map(|frame| (8.2e-3 * frame.time / WIDTH, pressure(frame, spacing)))
            .collect();
        let last = &curve[curve.len() * 4 / 5..];
        let plateau = last.iter().map(|(_, q)| q).sum::<f64>() / last.len() as f64;
        let reason =
            "V-39: 5.14 cohesions ± 10 % over the effective width, one spacing wider than the footing";
        outcome.near(format!("spacing {spacing} m: plateau over cohesion"), exact, 0.1, plateau, reason);
        let rise = last[last.len() - 1].1 / last[0].1 - 1.0;
        let unjudged = "not judged: how flat the plateau is";
        outcome.show(format!("spacing {spacing} m: rise over the last fifth"), "0", rise, unjudged);
        chart.series.push(Series::new(format!("spacing {spacing} m"), curve, Style::Line));
        if let Some(cloud) = PointCloud::of(&report.snapshot, "displacement", [0, 1]) {
            outcome.png(&format!("Displacement at the end, spacing {spacing} m."), &cloud)?;
        }
    }
    chart.series.push(Series::new("2 + π", vec![(0.0, exact), (0.05, exact)], Style::Dashed));
    outcome.svg("Pressure under the footing, from the vertical force in the soil below.", &chart)?;
    Ok(outcome)
}
