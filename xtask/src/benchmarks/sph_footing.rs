//! Bearing capacity of a strip footing (SPH sheet V-39; B-07).

use std::collections::BTreeMap;

use colluvium::case::Snapshot;
use colluvium::case::plot::{LineChart, PointCloud, Series, Style};

use super::{Benchmark, Outcome, case, run_by, set_of, slope, starts, stresses};

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
/// Velocity of the footing (m/s).
const SPEED: f64 = 8.2e-3;

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

/// Angle of the side of the wedge (degrees) that goes down with the footing. In Prandtl's mechanism the soil within has the
/// velocity of the footing, and beside it half of that: of each column of particles under the footing the depth where
/// three quarters are passed between two frames, and a straight line through those.
fn wedge([first, last]: [&Snapshot; 2]) -> f64 {
    let way = SPEED * (last.time - first.time);
    let sinks = |p: usize| (first.positions[p][1] - last.positions[p][1]) / way;
    let starts = starts(first);
    let mut columns: BTreeMap<i64, Vec<(f64, f64)>> = BTreeMap::new();
    for (p, start) in
        starts.iter().enumerate().filter(|(p, start)| first.bodies[*p] == 0 && start[0] < 0.4 * WIDTH)
    {
        columns.entry((start[0] * 1e6).round() as i64).or_default().push((SOIL - start[1], sinks(p)));
    }
    let corner = |(x, mut column): (i64, Vec<(f64, f64)>)| -> Option<(f64, f64)> {
        column.sort_by(|a, b| a.0.total_cmp(&b.0));
        let pair = column.windows(2).find(|pair| pair[0].1 >= 0.75 && pair[1].1 < 0.75)?;
        let share = (pair[0].1 - 0.75) / (pair[0].1 - pair[1].1);
        Some((x as f64 * 1e-6, pair[0].0 + share * (pair[1].0 - pair[0].0)))
    };
    let line: Vec<(f64, f64)> = columns.into_iter().filter_map(corner).collect();
    (-slope(&line)).atan().to_degrees()
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
            .map(|frame| (SPEED * frame.time / WIDTH, pressure(frame, spacing)))
            .collect();
        let last = &curve[curve.len() * 4 / 5..];
        let plateau = last.iter().map(|(_, q)| q).sum::<f64>() / last.len() as f64;
        let reason =
            "V-39: 5.14 cohesions ± 10 % over the effective width, one spacing wider than the footing";
        outcome.near(format!("spacing {spacing} m: plateau over cohesion"), exact, 0.1, plateau, reason);
        let rise = last[last.len() - 1].1 / last[0].1 - 1.0;
        let unjudged = "not judged: how flat the plateau is";
        outcome.show(format!("spacing {spacing} m: rise over the last fifth"), "0", rise, unjudged);
        let frames = &report.frames[report.frames.len() * 4 / 5..];
        let angle = wedge([&frames[0], &frames[frames.len() - 1]]);
        let room = (spacing / (0.5 * WIDTH)).atan().to_degrees();
        outcome.within(
            format!("spacing {spacing} m: angle of the wedge under the footing (degrees)"),
            "45",
            angle,
            (45.0 - room, 45.0 + room),
            "V-39 names no tolerance: one spacing over half the width",
        );
        chart.series.push(Series::new(format!("spacing {spacing} m"), curve, Style::Line));
        if let Some(cloud) = PointCloud::of(&report.snapshot, "displacement", [0, 1]) {
            outcome.png(&format!("Displacement at the end, spacing {spacing} m."), &cloud)?;
        }
    }
    chart.series.push(Series::new("2 + π", vec![(0.0, exact), (0.05, exact)], Style::Dashed));
    outcome.svg("Pressure under the footing, from the vertical force in the soil below.", &chart)?;
    Ok(outcome)
}
