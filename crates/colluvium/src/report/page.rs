//! Page of a report.

use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::Value;

use super::{ReportFigure, ReportPictures, RunResults, tables};
use crate::case::Warning;
use crate::case::run::recorded_warnings;
use crate::report::safety_factors;
use crate::report::value_text::{duration_text, five_digits, value_text};

/// Style sheet of the page.
const STYLE: &str = include_str!("report.css");

/// Page of a report: first the requested results, then other results, the progress of the run, and every parameter.
pub(super) fn page(results: &RunResults, pictures: &ReportPictures) -> Markup {
    let title = value_text(&results.case["title"]);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (title) }
                (incomplete_notice(results))
                (run_summary(results))
                @if let Some(notes) = results.case["notes"].as_array().filter(|notes| !notes.is_empty()) {
                    p class="notes" { @for note in notes { (value_text(note)) " " } }
                }
                (warnings(&results.summary, &results.missing_files))
                (safety_factors::safety_section(&results.summary, &pictures.safety))
                (tables::requested_measures(results))
                @if !pictures.requested_charts.is_empty() { (charts(&pictures.requested_charts)) }
                @if !pictures.maps.is_empty() { (figures("Maps", "", &pictures.maps)) }
                @if let Some(player) = &pictures.animation {
                    h2 { "Animation" }
                    (PreEscaped(player))
                }
                (figures("Other measures over time", "charts", &pictures.charts))
                (tables::measure_table(results))
                (figures("Points", "", &pictures.points))
                (tables::balance_table(results))
                (tables::stage_table(results))
                (tables::limit_table(&results.summary))
                (provenance(results))
                (tables::parameter_table(results))
            }
        }
    }
}

/// Notice where the run is not complete.
fn incomplete_notice(results: &RunResults) -> Markup {
    if results.is_complete() {
        return html! {};
    }
    let summary = &results.summary;
    let what = match summary["status"].as_str() {
        Some("failed") => "The run failed.",
        Some("interrupted") => "The run was interrupted; it can be resumed.",
        _ => "The run is still in progress, or it was killed before its end.",
    };
    let reached = results.measures.last("time").map(five_digits);
    html! {
        div class="incomplete" {
            strong { "Incomplete. " (coded(&Warning::new("incomplete-run", what))) }
            @if let Some(reason) = summary["reason"].as_str() { " " (reason) }
            @if let Some(time) = reached { " The measures end at t = " (time) " s." }
            " The results below are not those at the end of the case."
        }
    }
}

/// Summary of a run in a line: method with its options in the case, size and wall-clock time.
fn run_summary(results: &RunResults) -> Markup {
    let summary = &results.summary;
    let name = value_text(&summary["method"]);
    let options = results.case["methods"][&name].as_object();
    let chosen = |(key, value): (&String, &Value)| match value {
        Value::Object(_) | Value::Array(_) | Value::Null => None,
        value => Some(format!("{} {}", key.replace('_', " "), value_text(value))),
    };
    let chosen: Vec<String> = options.into_iter().flatten().filter_map(chosen).collect();
    html! {
        p class="soft" {
            strong { (name) }
            @if !chosen.is_empty() { " (" (chosen.join(", ")) ")" }
            ", " (value_text(&results.case["space"]))
            @if let Some(points) = summary["points"].as_u64() { ", " (points) " points" }
            @if let Some(time) = summary["time"].as_f64() { ", to t = " (five_digits(time)) " s" }
            @if let Some(wall) = summary["wall_time"].as_f64() { "; run time " (duration_text(wall)) }
            "." @if results.is_complete() { " Completed." }
        }
    }
}

/// Warnings of the program about the case, about the run, and about its folder.
fn warnings(summary: &Value, missing: &[Warning]) -> Markup {
    let list = |key: &str| recorded_warnings(&summary[key]);
    let parts = [
        ("of the case, before the run", list("warnings")),
        ("of the state at the end", list("remarks")),
        ("of the folder", missing.to_vec()),
    ];
    html! {
        @if parts.iter().any(|(_, list)| !list.is_empty()) {
            div class="warnings" {
                strong { "Warnings" }
                @for (of, list) in &parts {
                    @for warning in list { p class="notes" { span class="soft" { (of) ": " } (coded(warning)) } }
                }
            }
        }
    }
}

/// Text of a warning, and its code. A folder of an earlier version has no codes.
pub(crate) fn coded(Warning { code, text }: &Warning) -> Markup {
    html! { (text) @if !code.is_empty() { " " code title={ "colluvium explain " (code) } { (code) } } }
}

/// Provenance of the run.
fn provenance(results: &RunResults) -> Markup {
    let summary = &results.summary;
    let rows = [
        ("Version", value_text(&summary["version"])),
        ("Commit", value_text(&summary["commit"])),
        ("Steps", value_text(&summary["steps"])),
        ("Wall time", summary["wall_time"].as_f64().map_or("–".to_owned(), duration_text)),
        ("Hash of the final state", value_text(&summary["snapshot_hash"])),
    ];
    html! {
        h2 { "Provenance" }
        div class="wide" { table {
            @for (what, value) in &rows { tr { td class="soft" { (what) } td { (value) } } }
        } }
        @for fact in recorded_warnings(&summary["facts"]) { p class="notes" { (coded(&fact)) } }
        @if summary["warnings"].as_array().is_none_or(Vec::is_empty) && summary["remarks"].as_array().is_none_or(Vec::is_empty) {
            p class="soft" { "No warnings." }
        }
    }
}

/// Section of figures under a heading.
fn figures(title: &str, class: &str, figures: &[ReportFigure]) -> Markup {
    html! {
        h2 { (title) }
        div class=(class) { (figure_list(figures)) }
        @if figures.is_empty() { p class="soft" { "No results yet." } }
    }
}

/// Section of charts.
fn charts(figures: &[ReportFigure]) -> Markup {
    html! { div class="charts" { (figure_list(figures)) } }
}

/// Figures with their captions.
fn figure_list(figures: &[ReportFigure]) -> Markup {
    html! {
        @for figure in figures {
            figure { (PreEscaped(&figure.element)) figcaption { (figure.caption) } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::output::Table;
    use serde_json::json;

    #[test]
    fn a_report_begins_with_the_requested_measures() {
        let columns = ["time", "kinetic_energy", "front", "front.speed", "frontal"];
        let results = RunResults {
            summary: json!({ "status": "completed", "method": "mpm", "factors_of_safety": { "slope": {} } }),
            case: json!({ "title": "A case", "measures": { "front": {} }, "methods": {} }),
            measures: Table {
                columns: columns.map(|name| (name.to_owned(), "m".to_owned())).to_vec(),
                rows: vec![vec![0.0, 1.0, 2.0, 3.0, 4.0], vec![1.0, 2.0, 3.0, 4.0, 5.0]],
            },
            frames: Vec::new(),
            missing_files: Vec::new(),
            profiles: Vec::new(),
        };
        assert_eq!(columns.map(|name| results.is_requested(name)), [false, false, true, true, false]);
        let figure = |name: &str| vec![ReportFigure { element: String::new(), caption: name.to_owned() }];
        let pictures = ReportPictures {
            animation: Some("the player".to_owned()),
            points: figure("the points"),
            requested_charts: figure("the front"),
            charts: figure("the energy"),
            maps: figure("the map"),
            safety: Vec::new(),
        };
        let page = page(&results, &pictures).into_string();
        let order = [
            "Factors of safety",
            "Measures of the case",
            "the front",
            "the map",
            "the player",
            "the energy",
            "All measures",
        ];
        let places: Vec<usize> = order.iter().map(|text| page.find(text).unwrap()).collect();
        assert!(places.is_sorted(), "{places:?}");
        let requested_section = &page[places[1]..places[2]];
        assert!(
            requested_section.contains("front.speed") && !requested_section.contains("frontal"),
            "{requested_section}"
        );
    }
}
