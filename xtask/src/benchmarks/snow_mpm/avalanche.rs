//! Avalanches on a track of slope, arc and flat: run-out of the fronts of four kinds of snow (sheet: snow-mpm A6).

use colluvium::plots::{LineChart, PointCloud, Series, Style};
use serde_json::{Value, json};

use super::{case_with_options, run_snow_case};
use crate::analysis::mass_quantile_position;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, measure_series, scalars, set_material};
use colluvium::case::measure::fragments;
use colluvium::case::{Field, FieldData, RunReport, Snapshot};

/// Benchmark of avalanches of four kinds of snow on a slope with a run-out.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "snow-mpm/avalanche",
    title: "Four flow regimes of snow on a slope with a run-out",
    source: "Gaume et al. 2020, section 5.3, Figs. 9 and 10; Coulomb's law; sheet: snow-mpm A6",
    short_seconds: Some(25),
    full_seconds: 300,
    run: benchmark,
};

/// Kind of snow, with the fronts that the sheet's prototype reaches (m).
struct AvalancheRegime {
    name: &'static str,
    law: [f64; 4],
    sheet: [f64; 2],
    quantile: f64,
}

/// Kinds of snow of the sheet, the one with the farthest front first.
const REGIMES: [AvalancheRegime; 4] = [
    AvalancheRegime { name: "cold dense", law: [0.5, 0.0, 1.0, 3e3], sheet: [-1.85, 37.7], quantile: 35.8 },
    AvalancheRegime { name: "warm shear", law: [0.8, 0.3, 1.0, 3e3], sheet: [-7.74, 23.9], quantile: 21.9 },
    AvalancheRegime { name: "warm plug", law: [1.2, 0.3, 0.1, 8e3], sheet: [-16.11, 15.53], quantile: 15.47 },
    AvalancheRegime {
        name: "sliding slab",
        law: [1.5, 1.0, 10.0, 3e4],
        sheet: [-16.14, 15.18],
        quantile: 15.11,
    },
];

impl AvalancheRegime {
    /// Runs the avalanche of this kind of snow for a duration (s).
    fn run(&self, duration: f64) -> Result<RunReport, String> {
        let mut case = case_with_options("avalanche", &json!({}))?;
        let keys = ["critical_state_slope", "cohesion_ratio", "hardening_factor", "compressive_strength"];
        let keys: Vec<(&str, Value)> = keys.into_iter().zip(self.law.map(|value| json!(value))).collect();
        set_material(&mut case, "snow", &keys)?;
        case.stages[0].duration = duration;
        run_snow_case(&case)
    }
}

/// Front at a time (m).
fn front(report: &RunReport, time: f64) -> f64 {
    let fronts = measure_series(report, "front");
    let at = fronts.iter().find(|(t, _)| *t >= time - 1e-9).or(fronts.last());
    at.map_or(f64::NAN, |(_, front)| *front)
}

/// Displacement of a block by Coulomb's law (m).
fn coulomb(time: f64) -> f64 {
    let angle = 40f64.to_radians();
    0.5 * 9.81 * (angle.sin() - 0.4 * angle.cos()) * time * time
}

/// Checks fronts, forms and energies of avalanches of four kinds of snow.
fn benchmark(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let duration = if quick { 1.0 } else { 10.0 };
    let mut chart = LineChart::new("Fronts of four kinds of snow", "time (s)", "front along the track (m)");
    let mut reports = Vec::new();
    for regime in REGIMES.iter().filter(|regime| !quick || ["cold dense", "warm plug"].contains(&regime.name))
    {
        let report = regime.run(duration)?;
        chart.series.push(Series::new(regime.name, measure_series(&report, "front"), Style::Line));
        if let Some(mut cloud) = PointCloud::from_snapshot(&report.snapshot, "velocity", [0, 1]) {
            cloud.title = format!("{} after {duration} s", regime.name);
            outcome.png(&format!("A6: {}, speed.", regime.name), &cloud)?;
        }
        reports.push((regime, report));
    }
    for (regime, report) in &reports {
        block_law(&mut outcome, regime, report, if quick { &[1.0] } else { &[1.0, 2.0, 3.0] });
    }
    order(&mut outcome, &reports, if quick { 1.0 } else { 3.0 });
    if !quick {
        at_rest(&mut outcome, &reports, duration);
        forms(&mut outcome, &reports)?;
        reports.iter().for_each(|(regime, report)| energy(&mut outcome, regime, report));
    }
    outcome.svg("A6.", &chart)?;
    Ok(outcome)
}

/// Checks that cohesive snow slides as a rigid block on the slope.
fn block_law(outcome: &mut BenchmarkOutcome, regime: &AvalancheRegime, report: &RunReport, times: &[f64]) {
    if regime.law[0] < 1.0 {
        return;
    }
    for time in times {
        let travel = front(report, *time) - front(report, 0.0);
        let name = format!("A6 {}: way of the front after {time} s (m)", regime.name);
        outcome.assert_close(name, coulomb(*time), 0.01, travel, "the sheet's criterion");
    }
}

/// Checks that the front is farther for softer snow.
fn order(outcome: &mut BenchmarkOutcome, reports: &[(&AvalancheRegime, RunReport)], time: f64) {
    for pair in reports.windows(2) {
        let [(ahead, first), (behind, second)] = pair else { continue };
        let name = format!("A6: front of {} before that of {} after {time} s (m)", ahead.name, behind.name);
        let lead = front(first, time) - front(second, time);
        outcome.assert_within(name, "above 0", lead, (0.0, f64::INFINITY), "the order of the source");
    }
}

/// Checks the numerical dissipation of a run.
fn energy(outcome: &mut BenchmarkOutcome, regime: &AvalancheRegime, report: &RunReport) {
    let last = |name: &str| report.table.last(name).unwrap_or(f64::NAN);
    let dissipated = last("energy_plastic") + last("obstacles.friction");
    let name =
        format!("A6 {}: energy taken by the numerics over that dissipated by snow and bed", regime.name);
    outcome.assert_below(name, "0.01", last("energy_numerical") / dissipated, 0.01, "sheet: snow-mpm §0");
    let name =
        format!("A6 {}: energy that the transfers filter over that dissipated by snow and bed", regime.name);
    outcome.info(name, "not given", last("energy_filtered") / dissipated, "part of what the numerics take");
}

/// Checks the forms of the deposits and the flows against the descriptions of the source.
fn forms(outcome: &mut BenchmarkOutcome, reports: &[(&AvalancheRegime, RunReport)]) -> Result<(), String> {
    let track =
        case_with_options("avalanche", &json!({}))?.ground_line("track").ok_or("the case has no track")?;
    let along = |x: &[f64; 3]| track.arc_length(&[x[0], x[1]]).unwrap_or(f64::NAN);
    let thickness = |frame: &Snapshot| {
        let length = mass_quantile_position(frame, 0.99, along) - mass_quantile_position(frame, 0.01, along);
        scalars(frame, "volume").iter().sum::<f64>() / length
    };
    let deposits: Vec<f64> = reports.iter().map(|(_, report)| thickness(&report.snapshot)).collect();
    outcome.assert_within(
        "A6: mean thickness of the deposit, warm plug over cold dense",
        "above 1",
        deposits[2] / deposits[0],
        (1.0, f64::INFINITY),
        "the sheet's criterion",
    );
    let mut strains = scalars(&reports[1].1.snapshot, "plastic_strain");
    strains.sort_by(f64::total_cmp);
    outcome.assert_within(
        "A6 warm shear: median deviatoric plastic strain",
        "above 1; 2.4 (sheet's prototype)",
        strains[strains.len() / 2],
        (1.0, f64::INFINITY),
        "the sheet's criterion",
    );
    for (regime, report) in reports {
        let frame = report.frames.iter().find(|frame| frame.time >= 3.0 - 1e-9).unwrap_or(&report.snapshot);
        let ends = [0.05, 0.95].map(|share| mass_quantile_position(frame, share, along));
        let height = |x: &[f64; 3]| {
            track.gap(&[x[0], x[1]], f64::INFINITY).map_or(f64::NAN, |nearest| nearest.distance)
        };
        let surface = surface(frame.positions.iter().map(|x| [along(x), height(x)]), ends);
        let name = format!("A6 {}: roughness of the surface after 3 s", regime.name);
        let reason = "the source has pictures only; where a flow is thin, single points count";
        outcome.info(name, "not given", roughness(&surface), reason);
        let name = format!("A6 {}: waves of the surface after 3 s", regime.name);
        outcome.info(name, "not given", crests(&surface, CELL).len() as f64, reason);
        granules(outcome, regime, frame);
    }
    Ok(())
}

/// Edge of a cell (m).
const CELL: f64 = 0.1;
/// Density of the snow (kg/m³).
const DENSITY: f64 = 250.0;

/// Checks the sizes of connected pieces with strength, which are the granules beside the largest piece (sheet: snow-mpm F56).
fn granules(outcome: &mut BenchmarkOutcome, regime: &AvalancheRegime, frame: &Snapshot) {
    let strong: Vec<usize> = scalars(frame, "compressive_strength")
        .iter()
        .enumerate()
        .filter_map(|(i, strength)| (*strength > 0.0).then_some(i))
        .collect();
    let mass = scalars(frame, "mass");
    let data = FieldData::Scalar(strong.iter().map(|&i| mass[i]).collect());
    let whole = Snapshot {
        positions: strong.iter().map(|&i| frame.positions[i]).collect(),
        bodies: vec![0; strong.len()],
        fields: vec![Field { name: "mass".to_owned(), unit: "kg", data }],
        ..Snapshot::default()
    };
    // Sheet: snow-mpm §3.11: points within a cell, 20 or more.
    let (pieces, _) = fragments(&whole, CELL, 20).unwrap_or_default();
    let beside = pieces.get(1..).unwrap_or_default();
    let reason = "the source has pictures only; a piece of 20 points is 0.25 m across, five points";
    let name = format!("A6 {}: granules beside the largest piece after 3 s", regime.name);
    outcome.info(name, "not given", beside.len() as f64, reason);
    if let Some(median) = beside.get(beside.len() / 2) {
        let name = format!("A6 {}: diameter of the median granule after 3 s (m)", regime.name);
        outcome.info(name, "not given", (4.0 * median / (DENSITY * std::f64::consts::PI)).sqrt(), reason);
    }
}

/// Indices of the bins of a surface that have the crest of a wave. The height has risen by `rise` (m) since the trough before, and falls by
/// it before it rises further. Beyond both ends the height is zero, so that a body without waves has one crest.
fn crests(heights: &[f64], rise: f64) -> Vec<usize> {
    let mut crests = Vec::new();
    // The lowest height since the last crest; the highest since then.
    let (mut low, mut top) = (0.0, None);
    for (bin, height) in heights.iter().copied().chain([0.0]).enumerate() {
        match top {
            Some((_, highest)) if height > highest => top = Some((bin, height)),
            Some((crest, highest)) if height <= highest - rise => {
                crests.push(crest);
                (low, top) = (height, None);
            }
            Some(_) => {}
            None if height >= low + rise => top = Some((bin, height)),
            None => low = low.min(height),
        }
    }
    crests
}

/// Edge of the bins of a surface, two cells (m).
const BIN: f64 = 0.2;

/// Heights above the bed of the highest points (m), in bins between two positions `ends`. The points are given by their position along the
/// bed and above it; zero in a gap.
fn surface(points: impl Iterator<Item = [f64; 2]>, ends: [f64; 2]) -> Vec<f64> {
    let mut heights = vec![0f64; ((ends[1] - ends[0]) / BIN).ceil().max(1.0) as usize];
    for [along, above] in points.filter(|[along, _]| *along >= ends[0] && *along < ends[1]) {
        let bin = &mut heights[((along - ends[0]) / BIN) as usize];
        *bin = bin.max(above);
    }
    heights
}

/// Root mean square difference of a height from the mean of its neighbours, over the mean height.
fn roughness(heights: &[f64]) -> f64 {
    let off = heights.windows(3).map(|h| (h[1] - 0.5 * (h[0] + h[2])).powi(2));
    let mean = heights.iter().sum::<f64>() / heights.len() as f64;
    (off.sum::<f64>() / heights.len().saturating_sub(2).max(1) as f64).sqrt() / mean
}

/// Shows the fronts at the end, and checks their order and the number of pieces of slab and plug.
fn at_rest(outcome: &mut BenchmarkOutcome, reports: &[(&AvalancheRegime, RunReport)], time: f64) {
    order(outcome, reports, time);
    for (regime, report) in reports {
        for (at, sheet) in [(3.0, regime.sheet[0]), (time, regime.sheet[1])] {
            let claim = format!("{sheet} (sheet's prototype)");
            let name = format!("A6 {}: front after {at} s (m)", regime.name);
            outcome.info(
                name,
                &claim,
                front(report, at),
                "the sheet proposes the snow, and judges the order",
            );
        }
        let claim = format!("{} (sheet's prototype)", regime.quantile);
        let quantile = report.table.last("front_99").unwrap_or(f64::NAN);
        let name = format!("A6 {}: front of 99 % of the mass at the end (m)", regime.name);
        outcome.info(name, &claim, quantile, "the sheet proposes the snow, and judges the order");
        let pieces = report.table.last("pieces.count").unwrap_or(f64::NAN);
        let range = match regime.name {
            "sliding slab" => Some(("2 or more", (2.0, f64::INFINITY))),
            "warm plug" => Some(("1", (1.0, 1.0))),
            _ => None,
        };
        let touching = report.table.last("touching.count").unwrap_or(f64::NAN);
        let name =
            format!("A6 {}: pieces of 20 points and more, with what crumbles between them", regime.name);
        outcome.info(
            name,
            "not given",
            touching,
            "points without strength fill the cracks and touch both sides",
        );
        let name = format!("A6 {}: pieces of 20 points and more", regime.name);
        match range {
            Some((claim, range)) => {
                outcome.assert_within(name, claim, pieces, range, "the sheet's criterion");
            }
            None => outcome.info(name, "many", pieces, "the sheet judges slab and plug"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crests_are_maxima_of_at_least_a_cell_of_prominence() {
        assert_eq!(crests(&[0.5, 0.55, 0.52, 0.5], 0.1), [1], "a block");
        assert_eq!(crests(&[0.3, 0.5, 0.35, 0.45, 0.36, 0.2], 0.1), [1, 3]);
        assert_eq!(crests(&[0.3, 0.5, 0.42, 0.5, 0.6], 0.1), [4], "what falls by less is no trough");
        assert!(crests(&[0.05, 0.0, 0.08], 0.1).is_empty(), "thinner than a cell");
    }
}
