//! What stands on the page.

use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::Value;

use super::{Figure, Results, parameters};
use crate::case::output::heading;

const STYLE: &str = "
body { font: 15px/1.5 system-ui, sans-serif; color: #1d2733; max-width: 1000px; margin: 0 auto; padding: 28px 20px 60px; }
h1 { margin: 0 0 6px; font-size: 27px; } h2 { margin: 34px 0 8px; font-size: 19px; }
table { border-collapse: collapse; font-size: 13.5px; } td, th { text-align: left; padding: 4px 18px 4px 0; vertical-align: top; }
th { color: #5c6b7a; border-bottom: 2px solid #dde3e9; } td { border-bottom: 1px solid #dde3e9; overflow-wrap: anywhere; }
td.number { font-variant-numeric: tabular-nums; white-space: nowrap; }
.incomplete { border: 2px solid #c0392b; border-radius: 6px; padding: 10px 16px; color: #c0392b; }
.soft { color: #5c6b7a; } figure { margin: 16px 0; } figure svg, figure img { max-width: 100%; height: auto; }
figcaption { color: #5c6b7a; font-size: 13.5px; }
";

/// Columns of the measures that are an energy or a mass, in the order of the table.
const BUDGET: [&str; 8] = [
    "mass",
    "kinetic_energy",
    "elastic_energy",
    "potential_energy",
    "liquid_mass",
    "liquid_kinetic_energy",
    "liquid_elastic_energy",
    "liquid_potential_energy",
];

pub(super) fn page(results: &Results, maps: &[Figure], points: &[Figure], charts: &[Figure]) -> Markup {
    let title = text(&results.case["title"]);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (title) }
                (state(results))
                (facts(results))
                (stages(results))
                (limits(&results.summary))
                (remarks(&results.summary))
                (safety(&results.summary))
                (budget(results))
                (figures("Maps", maps))
                (figures("Points", points))
                (figures("In time, and profiles", charts))
                (measures(results))
                (all_parameters(results))
            }
        }
    }
}

fn text(value: &Value) -> String {
    match value {
        Value::Null => "–".to_owned(),
        Value::String(text) => text.clone(),
        Value::Number(number) => number.as_f64().map_or_else(|| number.to_string(), short),
        other => other.to_string(),
    }
}

/// A number to seven digits, plain where that is short.
fn short(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() {
        return "–".to_owned();
    }
    if size != 0.0 && !(1e-4..1e9).contains(&size) {
        return format!("{value:.6e}");
    }
    let digits = if size >= 1.0 { 6 - (size.log10() as usize).min(6) } else { 9 };
    let plain = format!("{value:.digits$}");
    if plain.contains('.') { plain.trim_end_matches('0').trim_end_matches('.').to_owned() } else { plain }
}

/// Says so, where the run is not complete.
fn state(results: &Results) -> Markup {
    if results.complete() {
        return html! { p class="soft" { "Completed." } };
    }
    let summary = &results.summary;
    let what = match summary["status"].as_str() {
        Some("failed") => "The run failed.",
        Some("interrupted") => "The run was interrupted; it can be resumed.",
        _ => "The run goes on, or was killed before its end.",
    };
    let reached = results.table.last("time").map(short);
    html! {
        div class="incomplete" {
            strong { "Incomplete. " (what) }
            @if let Some(reason) = summary["reason"].as_str() { " " (reason) }
            @if let Some(time) = reached { " The measures reach to t = " (time) " s." }
            " What stands below is not the end of the case."
        }
    }
}

fn facts(results: &Results) -> Markup {
    let summary = &results.summary;
    let name = text(&summary["method"]);
    let about = crate::method(&name).map(|method| format!(": {}", method.summary()));
    let duration =
        |value: &Value| value.as_f64().map_or("–".to_owned(), |seconds| format!("{seconds:.1} s"));
    let rows = [
        ("Method", format!("{name}{}", about.unwrap_or_default())),
        ("Space", text(&results.case["space"])),
        ("Version", text(&summary["version"])),
        ("Commit", text(&summary["commit"])),
        ("Points", text(&summary["points"])),
        ("Steps", text(&summary["steps"])),
        (
            "Time in the case",
            summary["time"].as_f64().map_or("–".to_owned(), |time| format!("{} s", short(time))),
        ),
        ("Wall time", duration(&summary["wall_time"])),
        ("Hash of the final state", text(&summary["snapshot_hash"])),
    ];
    html! { table { @for (what, value) in &rows { tr { td class="soft" { (what) } td { (value) } } } } }
}

fn stages(results: &Results) -> Markup {
    let none = Vec::new();
    let begun = results.summary["stages"].as_array().unwrap_or(&none);
    let all = results.case["stages"].as_array().unwrap_or(&none);
    html! {
        h2 { "Stages" }
        table {
            tr { th { "Stage" } th { "Begins (s)" } th { "Ends (s)" } th { "Longest (s)" } th { "How it ended" } }
            @for (number, stage) in all.iter().enumerate() {
                @let record = begun.get(number).unwrap_or(&Value::Null);
                tr {
                    td { (text(&stage["name"])) }
                    td class="number" { (text(&record["start"])) }
                    td class="number" { (text(&record["end"])) }
                    td class="number" { (text(&stage["duration"])) }
                    td {
                        @match (record.is_null(), record["ended"].as_str()) {
                            (_, Some(how)) => (how),
                            (false, None) => "not ended",
                            (true, None) => @if begun.is_empty() { "not known" } @else { "not begun" },
                        }
                    }
                }
            }
        }
    }
}

fn limits(summary: &Value) -> Markup {
    let Some(limits) = summary["time_step_limits"].as_array().filter(|limits| !limits.is_empty()) else {
        return html! {};
    };
    let place = |limit: &Value| match limit["position"].as_array() {
        Some(x) => {
            let x: Vec<String> = x.iter().map(text).collect();
            format!("point {} at ({}) m", limit["point"], x.join(", "))
        }
        None => "–".to_owned(),
    };
    html! {
        h2 { "What limited the time step" }
        table {
            tr { th { "Limit" } th { "Steps" } th { "Least (s)" } th { "At t (s)" } th { "Where" } }
            @for limit in limits {
                tr {
                    td { (text(&limit["limit"])) }
                    td class="number" { (text(&limit["steps"])) }
                    td class="number" { (text(&limit["least"])) }
                    td class="number" { (text(&limit["time"])) }
                    td { (place(limit)) }
                }
            }
        }
    }
}

fn remarks(summary: &Value) -> Markup {
    let list = |key: &str| summary[key].as_array().cloned().unwrap_or_default();
    let parts =
        [("of the case, before the run", list("warnings")), ("of the state at the end", list("remarks"))];
    html! {
        h2 { "Warnings" }
        @for (of, list) in &parts {
            @for warning in list { p { span class="soft" { (of) ": " } (text(warning)) } }
        }
        @if parts.iter().all(|(_, list)| list.is_empty()) { p class="soft" { "None." } }
    }
}

fn safety(summary: &Value) -> Markup {
    let Some(found) = summary["factors_of_safety"].as_object() else { return html! {} };
    html! {
        h2 { "Factors of safety" }
        table {
            tr { th { "Measure" } th { "Factor" } th { "Stable at" } th { "Failed at" } }
            @for (name, safety) in found {
                tr {
                    td { (name) }
                    td class="number" { (text(&safety["factor"])) }
                    td class="number" { (text(&safety["stable"])) }
                    td class="number" { (text(&safety["failed"])) }
                }
            }
        }
    }
}

fn budget(results: &Results) -> Markup {
    let table = &results.table;
    let (Some(first), Some(last)) = (table.rows.first(), table.rows.last()) else { return html! {} };
    let column = |name: &str| table.columns.iter().position(|(known, _)| known == name);
    let found = BUDGET.iter().filter_map(|name| column(name));
    let energies: Vec<usize> = found.clone().filter(|&k| table.columns[k].1 == "J").collect();
    let sum = |row: &[f64]| energies.iter().map(|&k| row[k]).sum::<f64>();
    let line = |name: String, from: f64, to: f64| {
        html! {
            tr {
                td { (name.replace('_', " ")) }
                @for value in [from, to, to - from] { td class="number" { (short(value)) } }
            }
        }
    };
    let end = if results.complete() { "At the end" } else { "In the last row" };
    html! {
        h2 { "Mass and energy" }
        table {
            tr { th {} th { "At the start" } th { (end) } th { "Change" } }
            @for k in found {
                @let (name, unit) = &table.columns[k];
                (line(heading(name, unit), first[k], last[k]))
            }
            (line("sum of the energies (J)".to_owned(), sum(first), sum(last)))
        }
        p class="soft" {
            "The sum changes by the work of walls, loads and motions, and by what friction, plastic flow and damping take. "
            "Per metre of thickness in plane strain, per radian in axisymmetry."
        }
    }
}

fn figures(title: &str, figures: &[Figure]) -> Markup {
    html! {
        h2 { (title) }
        @for figure in figures {
            figure { (PreEscaped(&figure.element)) figcaption { (figure.caption) } }
        }
        @if figures.is_empty() { p class="soft" { "Nothing yet." } }
    }
}

/// First, least, largest and last value of each column.
fn measures(results: &Results) -> Markup {
    let table = &results.table;
    let line = |k: usize| {
        let values = || table.rows.iter().map(|row| row[k]).filter(|value| value.is_finite());
        let (least, most) = (values().fold(f64::NAN, f64::min), values().fold(f64::NAN, f64::max));
        let (first, last) = (values().next(), table.rows.last().map(|row| row[k]));
        let (name, unit) = &table.columns[k];
        html! {
            tr {
                td { (heading(name, unit)) }
                @for value in [first.unwrap_or(f64::NAN), least, most, last.unwrap_or(f64::NAN)] {
                    td class="number" { (short(value)) }
                }
            }
        }
    };
    html! {
        h2 { "Measures" }
        p class="soft" { "Stress is tension-positive, pressure compression-positive. All rows are in measures.csv." }
        table {
            tr { th { "Measure" } th { "First" } th { "Least" } th { "Largest" } th { "Last" } }
            @for k in 0..table.columns.len() { (line(k)) }
        }
    }
}

fn all_parameters(results: &Results) -> Markup {
    let method = results.summary["method"].as_str().unwrap_or_default();
    html! {
        h2 { "Parameters" }
        table {
            tr { th { "Key" } th { "Value" } th {} }
            @for parameter in parameters::all(&results.case, method) {
                tr {
                    td { (parameter.path) }
                    td { (parameter.value) }
                    td class="soft" { @if parameter.default { "default" } }
                }
            }
        }
    }
}
