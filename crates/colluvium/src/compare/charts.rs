//! Charts with the curves of all methods.

use super::{CompletedRun, ReferenceProfiles};
use crate::case::Snapshot;
use crate::case::output::column_heading;
use crate::compare::key_figures::{CaseAxes, KeyFigures, ProfileColumns, five_digits};
use crate::output::run_pictures;
use crate::plots::{LineChart, Series, Style};

/// Columns of the measures that describe the progress of a run rather than its results.
const RUN_COLUMNS: [&str; 4] = ["time", "step", "time_step", "mass"];
/// Prefixes of the names of totals, in the order in which they are shown; measures of the case come first.
const TOTAL_PREFIXES: [&str; 6] =
    ["kinetic_energy", "elastic_energy", "potential_energy", "total_energy", "liquid_", "momentum"];

/// Runs by the names of their methods.
pub(super) type MethodRuns<'a> = [(&'static str, &'a CompletedRun)];

/// Frames at a time, of each run that has one then.
pub(super) fn frames_at<'a>(runs: &MethodRuns<'a>, time: f64) -> Vec<(&'static str, &'a Snapshot)> {
    let near = |frame: &&&Snapshot| (frame.time - time).abs() <= 1e-6 * time.abs().max(1e-9);
    let found = |(method, report): &(&'static str, &'a CompletedRun)| {
        let frames: Vec<&'a Snapshot> = report.frames.iter().collect();
        Some((*method, *frames.iter().find(near)?))
    };
    runs.iter().filter_map(found).collect()
}

/// Times (s) of the frames that every run has.
pub(super) fn common_times(runs: &MethodRuns<'_>) -> Vec<f64> {
    let times = runs.first().into_iter().flat_map(|(_, first)| first.frames.iter().map(|frame| frame.time));
    times.filter(|time| frames_at(runs, *time).len() == runs.len()).collect()
}

/// At most `wanted` times (s) of frames that every run has, the first and the last among them.
pub(super) fn sampled_times(runs: &MethodRuns<'_>, wanted: usize) -> Vec<f64> {
    let common = common_times(runs);
    crate::report::evenly_spaced_frames(common.len(), wanted).into_iter().map(|k| common[k]).collect()
}

/// Charts of surface profiles, one for each time, with those of all methods and of the reference.
pub(super) fn profile_charts(
    runs: &MethodRuns<'_>,
    axes: CaseAxes,
    wanted: usize,
    reference: &ReferenceProfiles,
) -> Vec<LineChart> {
    let common = common_times(runs);
    let mut times = [sampled_times(runs, wanted), reference.times(&common)].concat();
    times.sort_by(f64::total_cmp);
    times.dedup();
    // All profiles start from one shape.
    if times.len() > 2 {
        times.remove(0);
    }
    let name = |axis: usize| ["x", "y", "z"][axis];
    let chart = |time: f64| {
        let states = frames_at(runs, time);
        let snapshots: Vec<&Snapshot> = states.iter().map(|(_, snapshot)| *snapshot).collect();
        let columns = ProfileColumns::spanning(&snapshots, axes)?;
        let line = |(method, snapshot): &(&'static str, &Snapshot)| {
            Series::new(*method, trim_empty_columns(columns.profile(snapshot, axes)), Style::Line)
        };
        let measured = reference.nearest_profile(time, &common);
        let measured = measured.map(|curve| Series::new("reference", curve.clone(), Style::Markers));
        Some(LineChart {
            title: format!("t = {} s", five_digits(time)),
            x_label: format!("{} (m)", name(axes.spreading)),
            y_label: format!("height, {} (m)", name(axes.vertical)),
            log: false,
            series: states.iter().map(line).chain(measured).collect(),
        })
    };
    times.iter().filter_map(|time| chart(*time)).collect()
}

/// Part of a profile between the first and the last column with points.
fn trim_empty_columns(profile: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let filled = |(_, height): &(f64, f64)| height.is_finite();
    let Some(first) = profile.iter().position(filled) else { return profile };
    let last = profile.iter().rposition(filled).unwrap_or(first);
    profile[first..=last].to_vec()
}

/// Function that selects a key figure.
type KeyFigure = fn(&KeyFigures) -> f64;

/// Charts of front, top and speed over time, measured alike in all runs.
pub(super) fn key_figure_charts(runs: &MethodRuns<'_>, axes: CaseAxes) -> Vec<LineChart> {
    let name = |axis: usize| ["x", "y", "z"][axis];
    let kinds: [(String, KeyFigure); 4] = [
        (format!("front along {}, 99.9 % of the mass (m)", name(axes.spreading)), |f| f.front),
        (format!("top along {}, 99.9 % of the mass (m)", name(axes.vertical)), |f| f.top),
        (format!("centre of mass along {} (m)", name(axes.spreading)), |f| f.centre[0]),
        ("speed, 99.9 % of the mass (m/s)".to_owned(), |f| f.speed),
    ];
    let chart = |(label, value): &(String, KeyFigure)| {
        let line = |(method, report): &(&'static str, &CompletedRun)| {
            let states = report.frames.iter();
            let points = states.filter_map(|s| Some((s.time, value(&KeyFigures::of_snapshot(s, axes)?))));
            Series::new(*method, points.collect(), Style::Line)
        };
        time_chart(label, runs.iter().map(line).collect())
    };
    kinds.iter().filter_map(chart).collect()
}

/// Charts of the measures of the case and of totals over time, without those constant in all runs.
pub(super) fn measure_charts(runs: &MethodRuns<'_>) -> Vec<LineChart> {
    let mut columns: Vec<&(String, String)> = Vec::new();
    for column in runs.iter().flat_map(|(_, report)| &report.measures.columns) {
        if !RUN_COLUMNS.contains(&column.0.as_str()) && !columns.contains(&column) {
            columns.push(column);
        }
    }
    let rank =
        |name: &str| TOTAL_PREFIXES.iter().position(|total| name.starts_with(total)).map_or(0, |k| k + 1);
    columns.sort_by_key(|(name, _)| rank(name));
    let chart = |(name, unit): &(String, String)| {
        let line = |(method, report): &(&'static str, &CompletedRun)| {
            Some(Series::new(*method, report.measures.pairs("time", name)?, Style::Line))
        };
        time_chart(&column_heading(name, unit).replace('_', " "), runs.iter().filter_map(line).collect())
    };
    columns.into_iter().filter_map(chart).collect()
}

/// Charts of the energies of each method over time, on one scale of energy. Potential energy and the sum are shown as change since the
/// start.
pub(super) fn energy_charts(runs: &MethodRuns<'_>) -> Vec<LineChart> {
    let kinds = [
        ("kinetic_energy", "kinetic", false),
        ("elastic_energy", "elastic", false),
        ("potential_energy", "potential, change since the start", true),
        ("total_energy", "sum, change since the start", true),
    ];
    let chart = |(method, ran): &(&'static str, &CompletedRun)| {
        let line = |(column, name, since): &(&str, &str, bool)| {
            let points = ran.measures.pairs("time", column)?;
            let from = if *since { points.first().map_or(0.0, |p| p.1) } else { 0.0 };
            let points = points.into_iter().map(|(time, energy)| (time, energy - from)).collect();
            Some(Series::new(*name, points, Style::Line))
        };
        let chart = time_chart("energy (J)", kinds.iter().filter_map(line).collect())?;
        Some(LineChart { title: (*method).to_owned(), ..chart })
    };
    runs.iter().filter_map(chart).collect()
}

/// Chart over time; `None` where all series are constant.
fn time_chart(label: &str, series: Vec<Series>) -> Option<LineChart> {
    let changes = |series: &Series| run_pictures::is_changing(&series.points);
    let series: Vec<Series> =
        series.into_iter().filter(|series| series.points.iter().any(|p| p.1.is_finite())).collect();
    series.iter().any(changes).then(|| LineChart {
        x_label: "time (s)".to_owned(),
        y_label: label.to_owned(),
        series,
        ..LineChart::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constant_and_empty_series_give_no_chart() {
        let line = |values: [f64; 3]| {
            Series::new("a", values.iter().enumerate().map(|(k, v)| (k as f64, *v)).collect(), Style::Line)
        };
        assert!(time_chart("m", vec![line([2.0; 3])]).is_none());
        assert!(time_chart("m", vec![line([2.0, 2.0 + 1e-15, 2.0])]).is_none());
        assert!(time_chart("m", vec![line([f64::NAN; 3])]).is_none());
        let both = time_chart("m", vec![line([2.0; 3]), line([2.0, 3.0, 2.0]), line([f64::NAN; 3])]).unwrap();
        assert_eq!(both.series.len(), 2);
    }
}
