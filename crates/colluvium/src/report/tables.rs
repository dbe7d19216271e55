//! Tables of the results and of the progress of a run.

use maud::{Markup, html};
use serde_json::Value;

use super::{RunResults, parameters};
use crate::case::output::column_heading;
use crate::report::value_text::{five_digits, value_text};

/// Columns of the measures that are an energy or a mass, in the order of the table.
const BALANCE_COLUMNS: [&str; 9] = [
    "mass",
    "kinetic_energy",
    "elastic_energy",
    "potential_energy",
    "total_energy",
    "liquid_mass",
    "liquid_kinetic_energy",
    "liquid_elastic_energy",
    "liquid_potential_energy",
];

/// Table of the stages: times, longest duration, reason of the end.
pub(super) fn stage_table(results: &RunResults) -> Markup {
    let none = Vec::new();
    let begun = results.summary["stages"].as_array().unwrap_or(&none);
    let all = results.case["stages"].as_array().unwrap_or(&none);
    html! {
        h2 { "Stages" }
        div class="wide" { table {
            tr { th { "Stage" } th { "Begins (s)" } th { "Ends (s)" } th { "Longest (s)" } th { "Reason of the end" } }
            @for (number, stage) in all.iter().enumerate() {
                @let record = begun.get(number).unwrap_or(&Value::Null);
                tr {
                    td { (value_text(&stage["name"])) }
                    td class="number" { (value_text(&record["start"])) }
                    td class="number" { (value_text(&record["end"])) }
                    td class="number" { (value_text(&stage["duration"])) }
                    td {
                        @match (record.is_null(), record["ended"].as_str()) {
                            (_, Some(how)) => (how),
                            (false, None) => "not ended",
                            (true, None) => @if begun.is_empty() { "unknown" } @else { "not begun" },
                        }
                    }
                }
            }
        } }
    }
}

/// Table of the criteria that limited the time step.
pub(super) fn limit_table(summary: &Value) -> Markup {
    let Some(limits) = summary["time_step_limits"].as_array().filter(|limits| !limits.is_empty()) else {
        return html! {};
    };
    let place = |limit: &Value| match limit["position"].as_array() {
        Some(x) => {
            let x: Vec<String> = x.iter().map(value_text).collect();
            format!("point {} at ({}) m", limit["point"], x.join(", "))
        }
        None => "–".to_owned(),
    };
    html! {
        h2 { "Limits of the time step" }
        div class="wide" { table {
            tr { th { "Limit" } th { "Steps" } th { "Least (s)" } th { "At t (s)" } th { "Position" } }
            @for limit in limits {
                tr {
                    td { (value_text(&limit["limit"])) }
                    td class="number" { (value_text(&limit["steps"])) }
                    td class="number" { (value_text(&limit["least"])) }
                    td class="number" { (value_text(&limit["time"])) }
                    td { (place(limit)) }
                }
            }
        } }
    }
}

/// Difference `to - from`; zero where it is within rounding.
fn rounded_difference(from: f64, to: f64) -> f64 {
    let difference = to - from;
    if difference.abs() < 1e-12 * from.abs().max(to.abs()) { 0.0 } else { difference }
}

/// Table of mass and energy at the start and at the end.
pub(super) fn balance_table(results: &RunResults) -> Markup {
    let table = &results.measures;
    let (Some(first), Some(last)) = (table.rows.first(), table.rows.last()) else { return html! {} };
    let column = |name: &str| table.columns.iter().position(|(known, _)| known == name);
    let found = BALANCE_COLUMNS.iter().filter_map(|name| column(name));
    if found.clone().next().is_none() {
        return html! {
            h2 { "Mass and energy" }
            p class="soft" { "The method does not record totals of mass and energy." }
        };
    }
    // The total energy is a sum itself.
    let is_part = |k: &usize| table.columns[*k].1 == "J" && table.columns[*k].0 != "total_energy";
    let energies: Vec<usize> = found.clone().filter(is_part).collect();
    let sum = |row: &[f64]| energies.iter().map(|&k| row[k]).sum::<f64>();
    let line = |name: String, from: f64, to: f64| {
        html! {
            tr {
                td { (name.replace('_', " ")) }
                @for value in [from, to, rounded_difference(from, to)] { td class="number" { (five_digits(value)) } }
            }
        }
    };
    let end = if results.is_complete() { "At the end" } else { "In the last row" };
    html! {
        h2 { "Mass and energy" }
        div class="wide" { table {
            tr { th {} th { "At the start" } th { (end) } th { "Change" } }
            @for k in found {
                @let (name, unit) = &table.columns[k];
                (line(column_heading(name, unit), first[k], last[k]))
            }
            (line("sum of the energies (J)".to_owned(), sum(first), sum(last)))
        } }
        p class="soft" {
            "The sum changes by the work of walls, loads and motions, and by the dissipation of friction, plastic flow and damping. "
            "Values are per metre of thickness in plane strain and per radian in axisymmetry."
        }
    }
}

/// Table of first, smallest, largest and last values of the columns that the case requests; empty where it requests none.
pub(super) fn requested_measures(results: &RunResults) -> Markup {
    let columns = matching_columns(results, |name| results.is_requested(name));
    html! {
        @if !columns.is_empty() {
            h2 { "Measures of the case" }
            (range_table(results, &columns))
        }
    }
}

/// Table of first, smallest, largest and last values of all columns.
pub(super) fn measure_table(results: &RunResults) -> Markup {
    html! {
        h2 { "All measures" }
        p class="soft" { "Stress is tension-positive, pressure compression-positive. All rows are in measures.csv." }
        (range_table(results, &matching_columns(results, |_| true)))
    }
}

/// Numbers of the columns whose names satisfy `wanted`.
fn matching_columns(results: &RunResults, wanted: impl Fn(&str) -> bool) -> Vec<usize> {
    let columns = &results.measures.columns;
    (0..columns.len()).filter(|k| wanted(&columns[*k].0)).collect()
}

/// Table of first, smallest, largest and last values of measures.
fn range_table(results: &RunResults, columns: &[usize]) -> Markup {
    let table = &results.measures;
    let line = |k: usize| {
        let values = || table.rows.iter().map(|row| row[k]).filter(|value| value.is_finite());
        let (smallest, largest) = (values().fold(f64::NAN, f64::min), values().fold(f64::NAN, f64::max));
        let (first, last) = (values().next(), table.rows.last().map(|row| row[k]));
        let (name, unit) = &table.columns[k];
        html! {
            tr {
                td { (column_heading(name, unit)) }
                @for value in [first.unwrap_or(f64::NAN), smallest, largest, last.unwrap_or(f64::NAN)] {
                    td class="number" { (five_digits(value)) }
                }
            }
        }
    };
    html! {
        div class="wide" { table {
            tr { th { "Measure" } th { "First" } th { "Least" } th { "Largest" } th { "Last" } }
            @for &k in columns { (line(k)) }
        } }
    }
}

/// Table of all parameters of a case and the defaults of those that it does not set.
pub(super) fn parameter_table(results: &RunResults) -> Markup {
    let method = results.summary["method"].as_str().unwrap_or_default();
    html! {
        h2 { "Parameters" }
        details { summary { "All parameters of the case, and the defaults of parameters that it does not set" } table {
            tr { th { "Key" } th { "Value" } th {} }
            @for parameter in parameters::all_parameters(&results.case, method) {
                tr {
                    td { (parameter.path) }
                    td { (parameter.value) }
                    td class="soft" { @if parameter.default { "default" } }
                }
            }
        } }
    }
}
