//! Factors of safety: results of the searches, displacement over factor, and the slip surface.

use std::path::Path;

use maud::{Markup, PreEscaped, html};
use serde_json::Value;

use crate::case::output::{Table, named_file, read_frame};
use crate::plots::{LineChart, Picture, PointCloud, Series, Style};
use crate::report::value_text::value_text;
use crate::report::{ReportError, ReportFigure, RunResults, png};

/// Section on the results of the searches for factors of safety, with their pictures.
pub(super) fn safety_section(summary: &Value, figures: &[ReportFigure]) -> Markup {
    let Some(found) = summary["factors_of_safety"].as_object() else { return html! {} };
    html! {
        h2 { "Factors of safety" }
        div class="wide" { table {
            tr { th { "Measure" } th { "Outcome" } th { "Factor" } th { "Stable at" } th { "Failed at" } th { "Trials" } }
            @for (name, safety) in found {
                tr {
                    td { (name) }
                    td { (value_text(&safety["outcome"])) }
                    td class="number" { (value_text(&safety["factor"])) }
                    td class="number" { (value_text(&safety["stable"])) }
                    td class="number" { (value_text(&safety["failed"])) }
                    td class="number" { (value_text(&safety["trials"])) }
                }
            }
        } }
        @for (name, safety) in found {
            @if let Some(message) = safety["told"].as_str() { p class="soft" { (name) ": " (message) "." } }
        }
        div class="charts" {
            @for figure in figures {
                figure { (PreEscaped(&figure.element)) figcaption { (figure.caption) } }
            }
        }
    }
}

/// Figures of each search: displacement over the strength reduction factor, and the points at the end of the last failing trial.
pub(super) fn safety_figures(
    folder: &Path,
    results: &RunResults,
    plane: [usize; 2],
) -> Result<Vec<ReportFigure>, ReportError> {
    let mut figures = Vec::new();
    for (name, measure) in results.case["measures"].as_object().into_iter().flatten() {
        if measure["kind"] != "factor-of-safety" {
            continue;
        }
        let trials = named_file(folder, &format!("trials-{name}"), "csv")?;
        if trials.exists() {
            let fail = |problem| ReportError::Picture { subject: name.clone(), problem };
            let chart = chart(&Table::read(&trials)?);
            let caption = format!("{name}: displacement that 1 % of the points exceed, for each trial");
            figures.push(ReportFigure { element: chart.to_svg().map_err(fail)?, caption });
        }
        let failing = named_file(folder, &format!("failing-{name}"), "vtu")?;
        if !failing.exists() {
            continue;
        }
        let points = read_frame(&failing, 0.0)?;
        if let Some(cloud) = PointCloud::from_snapshot(&points, "trial_displacement", plane) {
            let cloud = PointCloud { title: format!("{name}: last failing trial"), ..cloud };
            let caption = format!(
                "{name}: displacement in the last failing trial; the slip surface is the edge of the displaced mass"
            );
            figures.push(ReportFigure { element: png(&cloud, &caption)?, caption });
        }
    }
    Ok(figures)
}

/// Chart of displacement over the strength reduction factor. Displacements are dimensionless where the materials have a Young's modulus.
/// Axes are logarithmic: failed trials have moved a hundred times as far as stable ones, which would hide the bend.
fn chart(trials: &Table) -> LineChart {
    let scaled = trials.pairs("factor", "dimensionless_displacement").unwrap_or_default();
    let known = scaled.iter().any(|(_, value)| value.is_finite());
    let points = if known { scaled } else { trials.pairs("factor", "displacement").unwrap_or_default() };
    let [failed, open] = ["failed", "undecided"].map(|name| trials.column(name).unwrap_or_default());
    let is = |column: &[f64], k: usize| column.get(k).is_some_and(|value| *value != 0.0);
    let mut sorted = points.clone();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut series = vec![Series::new("", sorted, Style::Dashed)];
    for (label, kind) in [("stable", [false, false]), ("failed", [true, false]), ("undecided", [false, true])]
    {
        let own = points.iter().enumerate().filter(|(k, _)| [is(&failed, *k), is(&open, *k)] == kind);
        let own: Vec<(f64, f64)> = own.map(|(_, point)| *point).collect();
        if !own.is_empty() {
            series.push(Series::new(label, own, Style::Markers));
        }
    }
    LineChart {
        x_label: "strength reduction factor".to_owned(),
        y_label: if known { "E u / (γ H²)" } else { "displacement (m)" }.to_owned(),
        log: true,
        series,
        ..LineChart::default()
    }
}
