//! Remote triggering of a slab avalanche: a snowman on the flat below a slope (sheet: snow-mpm A3).

use colluvium::case::{RunReport, Snapshot};
use colluvium::plots::{LineChart, PointCloud, Series, Style};
use serde_json::json;

use crate::benchmarks::snow_mpm::{case_with_options, run_snow_case};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, initial_positions, scalars, vectors};

/// Benchmark of the remote triggering of a slab avalanche.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "snow-mpm/remote",
    title: "Remote triggering of a slab avalanche",
    source: "Gaume et al. 2020, section 4.2 and Fig. 6; sheet: snow-mpm A3, on 40° as amended",
    short_seconds: None,
    full_seconds: 1500,
    run: benchmark,
};

/// Position at which the flat begins (m).
const SLOPE_TOE: f64 = 13.049_259;
/// Centre of the snowman (m).
const SNOWMAN: f64 = SLOPE_TOE + 2.0;
/// Position at which the arc begins (m).
const FOOT: f64 = 9.192_533;
/// Centre of the arc at the crest (m).
const CREST: [f64; 2] = [-23.377_607, 24.817_105];
/// Radius of the arc at the crest (m).
const RADIUS: f64 = 3.0;
/// Index of the weak layer among the bodies.
const WEAK_LAYER: u32 = 0;
/// Index of the slab among the bodies.
const SLAB: u32 = 1;

/// Checks that a snowman on the flat triggers a slab avalanche on the slope, and that the slope is stable without it.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut case = case_with_options("remote", &json!({}))?;
    let mut alone = case.clone();
    alone.bodies.retain(|body| body.name != "snowman");
    alone.stages[1].duration = 0.6;
    let alone = run_snow_case(&alone)?;
    let failed = collapsed_points(&alone.snapshot).iter().filter(|(_, failed)| *failed).count();
    let reason = "the sheet's criterion (i)";
    outcome.assert_within(
        "A3: points of the weak layer that collapse without a snowman",
        "0",
        failed as f64,
        (0.0, 0.0),
        reason,
    );
    case.output.fields = None;
    let report = run_snow_case(&case)?;
    crack(&mut outcome, &report)?;
    release(&mut outcome, &report);
    for time in [0.4, 0.8, 1.5, 3.2] {
        let frame = report.frames.iter().find(|frame| frame.time >= time - 1e-9);
        if let Some(mut cloud) = frame.and_then(|frame| PointCloud::from_snapshot(frame, "velocity", [0, 1]))
        {
            cloud.title = format!("after {time} s");
            outcome.png("A3: speed.", &cloud)?;
        }
    }
    Ok(outcome)
}

/// Initial position along x (m) of the points of the weak layer, and whether they have collapsed.
fn collapsed_points(frame: &Snapshot) -> Vec<(f64, bool)> {
    let (flags, start) = (scalars(frame, "collapsed"), initial_positions(frame));
    let weak = (0..flags.len()).filter(|&i| frame.bodies[i] == WEAK_LAYER);
    weak.map(|i| (start[i][0], flags[i] > 0.5)).collect()
}

/// Checks that the crack starts below the snowman and propagates up the slope.
fn crack(outcome: &mut BenchmarkOutcome, report: &RunReport) -> Result<(), String> {
    let fronts = |frame: &Snapshot| {
        let all = collapsed_points(frame).into_iter().filter(|(_, failed)| *failed).map(|(x, _)| x);
        all.fold(None, |ends: Option<[f64; 2]>, x| {
            Some(ends.map_or([x; 2], |[low, high]| [low.min(x), high.max(x)]))
        })
    };
    let first = report.frames.iter().find_map(fronts);
    let off = first.map_or(f64::NAN, |[low, high]| (0.5 * (low + high) - SNOWMAN).abs());
    outcome.assert_below(
        "A3: where the weak layer fails first, from the middle of the snowman (m)",
        "0.6",
        off,
        0.6,
        "the sheet's criterion (ii): it is 0.8 m wide",
    );
    let last = collapsed_points(&report.snapshot);
    let share = |on: &dyn Fn(f64) -> bool| {
        let all: Vec<bool> = last.iter().filter(|(x, _)| on(*x)).map(|(_, failed)| *failed).collect();
        all.iter().filter(|failed| **failed).count() as f64 / all.len() as f64
    };
    for (name, value) in [
        ("flat", share(&|x| x > SLOPE_TOE && x < SLOPE_TOE + 5.5)),
        ("slope", share(&|x| x > CREST[0] + 2.5 && x < FOOT)),
    ] {
        let name = format!("A3: share of the weak layer on the {name} that has collapsed");
        outcome.assert_within(name, "above 0.9", value, (0.9, 1.0), "the sheet's criterion (iii)");
    }
    let ends: Vec<(f64, [f64; 2])> =
        report.frames.iter().filter_map(|frame| Some((frame.time, fronts(frame)?))).collect();
    let line = |k: usize| ends.iter().map(|(time, ends)| (*time, ends[k])).collect();
    let chart = LineChart {
        series: vec![
            Series::new("up the slope", line(0), Style::Line),
            Series::new("along the flat", line(1), Style::Line),
        ],
        ..LineChart::new("Ends of what has collapsed", "time (s)", "x at the start (m)")
    };
    outcome.svg("A3: the crack runs both ways.", &chart)
}

/// Checks that the slab breaks and slides on the slope, and remains on the flat.
fn release(outcome: &mut BenchmarkOutcome, report: &RunReport) {
    let last = &report.snapshot;
    let (start, moved) = (initial_positions(last), vectors(last, "displacement"));
    let strength = scalars(last, "compressive_strength");
    let slab: Vec<usize> = (0..start.len()).filter(|&i| last.bodies[i] == SLAB).collect();
    // Parts of the crest and the slope 0.2 m long, in which every fifth of the thickness has a point without strength.
    let mut parts = vec![[false; 5]; 220];
    for &i in slab.iter().filter(|&&i| start[i][0] < FOOT && strength[i] == 0.0) {
        let [along, across] = on_the_track(start[i]);
        let part = ((along / 0.2).max(0.0) as usize).min(219);
        parts[part][(((across - 0.3) / 0.1).max(0.0) as usize).min(4)] = true;
    }
    let broken = parts.iter().filter(|part| part.iter().all(|fifth| *fifth)).count();
    outcome.assert_within(
        "A3: parts of 0.2 m of the slab on the slope that are broken through",
        "1 or more",
        broken as f64,
        (1.0, f64::INFINITY),
        "the sheet's criterion (iv): a tensile crack through the thickness",
    );
    let mean = |on: &dyn Fn(f64) -> bool| {
        let displacements: Vec<f64> =
            slab.iter().filter(|&&i| on(start[i][0])).map(|&i| moved[i][0].hypot(moved[i][1])).collect();
        displacements.iter().sum::<f64>() / displacements.len() as f64
    };
    outcome.assert_within(
        "A3: mean way of the slab on the slope (m)",
        "above 1",
        mean(&|x| x > CREST[0] + 2.0 && x < FOOT),
        (1.0, f64::INFINITY),
        "the sheet's criterion (iv)",
    );
    let low = mean(&|x| x > 0.0 && x < FOOT);
    let reason = "the slab on the flat, which stays, supports it";
    outcome.info("A3: mean way of the slab on its lowest 12 m (m)", "not given", low, reason);
    outcome.assert_below(
        "A3: mean way of the slab on the flat beyond the snowman (m)",
        "0.3",
        mean(&|x| x > SNOWMAN + 1.5),
        0.3,
        "the sheet's criterion (v): it settles by less than the weak layer is thick, and stays",
    );
    let pieces = report.table.last("pieces.count").unwrap_or(f64::NAN);
    outcome.info("A3: pieces of the slab", "not given", pieces, "the sheet judges the crack");
}

/// Length along the ground from the beginning of the arc at the crest, and height above the ground along its normal (m), down to the foot.
fn on_the_track([x, y]: [f64; 2]) -> [f64; 2] {
    let (sine, cosine) = 40f64.to_radians().sin_cos();
    let right = [x - CREST[0], y - CREST[1]];
    let turn = right[0].atan2(right[1]);
    if turn <= 40f64.to_radians() {
        [RADIUS * turn.max(0.0), right[0].max(0.0).hypot(right[1]) - RADIUS]
    } else {
        let along = right[0] * cosine - right[1] * sine;
        [RADIUS * 40f64.to_radians() + along, right[0] * sine + right[1] * cosine - RADIUS]
    }
}
