//! Snowballs of different snow on a sticky floor (sheet: snow-mpm A1): scattering and compaction.

use colluvium::plots::{LineChart, Series, Style};
use serde_json::{Value, json};

use super::{case_with_options, run_snow_case};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, scalars, set_material};

/// Benchmark of snowballs of different strength, stiffness and brittleness that hit a floor.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "snow-mpm/snowball",
    title: "Snowballs on a floor: strength, stiffness and brittleness of the snow",
    source: "Stomakhin et al. 2013 as in Gaume et al. 2020, Fig. 4; sheet: snow-mpm A1",
    short_seconds: None,
    full_seconds: 60,
    run: benchmark,
};

/// Number of times in the chart of scatter.
const TIMES: usize = 20;

/// Scatter and compaction of an impact.
struct ImpactResult {
    /// 90 % quantile of the distance from the axis (m).
    scatter: f64,
    /// Least plastic volume.
    min_plastic_volume: f64,
    /// Mean plastic volume of the lowest tenth of the points.
    contact: f64,
}

/// Quantile of values.
fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values
        .get(((values.len() as f64 * share) as usize).min(values.len().saturating_sub(1)))
        .copied()
        .unwrap_or(f64::NAN)
}

/// Changed keys of the material.
type MaterialChanges<'a> = &'a [(&'a str, Value)];

/// Impact of a ball of changed snow: scatter and compaction.
fn impact(keys: MaterialChanges<'_>, chart: &mut LineChart, name: &str) -> Result<ImpactResult, String> {
    let mut case = case_with_options("snowball", &json!({}))?;
    set_material(&mut case, "snow", keys)?;
    case.output.frames = Some(case.end_time() / TIMES as f64);
    let report = run_snow_case(&case)?;
    let scatter = |frame: &colluvium::case::Snapshot| {
        quantile(frame.positions.iter().map(|x| x[0].abs()).collect(), 0.9)
    };
    let over_time = report.frames.iter().map(|frame| (frame.time, scatter(frame))).collect();
    chart.series.push(Series::new(name, over_time, Style::Line));
    // Contact zone: the lowest points soon after the impact.
    let early = report.frames.get(TIMES / 8).ok_or("too few frames")?;
    let low = quantile(early.positions.iter().map(|x| x[1]).collect(), 0.1);
    let packed: Vec<f64> = early
        .positions
        .iter()
        .zip(scalars(early, "plastic_volume"))
        .filter_map(|(x, volume)| (x[1] <= low).then_some(volume))
        .collect();
    Ok(ImpactResult {
        scatter: scatter(&report.snapshot),
        min_plastic_volume: scalars(&report.snapshot, "plastic_volume")
            .into_iter()
            .fold(f64::INFINITY, f64::min),
        contact: packed.iter().sum::<f64>() / packed.len() as f64,
    })
}

/// Checks how scatter and compaction of a snowball depend on the snow.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart =
        LineChart::new("Scatter of the ball", "time (s)", "90 % quantile of the distance from the axis (m)");
    let hardening = ("hardening_factor", json!(5));
    let modulus = ("youngs_modulus", json!(4.8e4));
    let compression = ("critical_compression", json!(0.019));
    let stretch = ("critical_stretch", json!(0.005));
    let variants: [(&str, MaterialChanges<'_>, f64, f64); 5] = [
        ("default", &[], 0.353, 0.575),
        ("hardening 5", &[hardening], 0.262, 0.422),
        ("E = 48 kPa", &[modulus], 0.257, 0.517),
        ("critical compression 0.019", std::slice::from_ref(&compression), 0.178, 0.558),
        ("critical stretch 0.005", std::slice::from_ref(&stretch), 0.524, 0.588),
    ];
    let mut found = Vec::new();
    for (name, keys, scatter, smallest) in variants {
        let ball = impact(keys, &mut chart, name)?;
        let reason = "fragments are chaotic: the sheet judges trends";
        outcome.info(
            format!("A1 {name}: scatter (m)"),
            &format!("{scatter} (sheet's prototype)"),
            ball.scatter,
            reason,
        );
        outcome.info(
            format!("A1 {name}: least plastic volume"),
            &format!("{smallest} (sheet's prototype)"),
            ball.min_plastic_volume,
            reason,
        );
        found.push(ball);
    }
    check_relations(&mut outcome, &found)?;
    outcome.svg("Snow that tears easily scatters widely; snow that crushes early sticks.", &chart)?;
    Ok(outcome)
}

/// Checks how the results of the balls relate to each other.
fn check_relations(outcome: &mut BenchmarkOutcome, found: &[ImpactResult]) -> Result<(), String> {
    let [default, softer, weaker, brittle, tearing] = found else {
        return Err("five balls were to fall".to_owned());
    };
    let trend = "the sheet's criterion";
    let more = (1.0, f64::INFINITY);
    let ratio = tearing.scatter / default.scatter;
    outcome.assert_within(
        "A1: scatter with a lower critical stretch over default",
        "above 1",
        ratio,
        more,
        trend,
    );
    let others =
        [default, softer, weaker, tearing].map(|ball| ball.scatter).into_iter().fold(f64::INFINITY, f64::min);
    let name = "A1: least scatter of the others over that with a lower critical compression";
    outcome.assert_within(name, "above 1", others / brittle.scatter, more, trend);
    for (name, ball) in [("less hardening", softer), ("a lower modulus", weaker)] {
        outcome.assert_within(
            format!("A1: scatter, default over {name}"),
            "above 1",
            default.scatter / ball.scatter,
            more,
            trend,
        );
        let name = format!("A1: least plastic volume, default over {name}");
        outcome.assert_within(
            name,
            "above 1",
            default.min_plastic_volume / ball.min_plastic_volume,
            more,
            trend,
        );
    }
    outcome.assert_within(
        "A1: plastic volume of the lowest tenth after 0.04 s",
        "below 1",
        default.contact,
        (0.0, 1.0),
        trend,
    );
    Ok(())
}
