//! Index of a report: a row for each benchmark.

use std::collections::BTreeSet;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::benchmarks::CheckVerdict;
use crate::report::value_text::{STYLE, duration_text, open_defect_text, status_badge};
use crate::report::{BenchmarkEntry, BenchmarkStatus, COVERAGE, PAGES, Provenance, ReportScope, form_text};

/// Index page of the report: a row for each benchmark.
pub fn page(entries: &[BenchmarkEntry], about: &Provenance, scope: &ReportScope) -> Markup {
    let worst =
        [BenchmarkStatus::Fail, BenchmarkStatus::Open].into_iter().find(|status| count(entries, *status) > 0);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "Colluvium: validation" }
                style { (PreEscaped(STYLE)) }
            }
            body { main {
                h1 { "Validation " (status_badge(worst.unwrap_or(BenchmarkStatus::Pass))) }
                (head(entries, about, scope))
                (filter_section(entries))
                div class="card" { table class="rows" {
                    thead { tr { @for name in HEADS { th { (name) } } } }
                    tbody { @for entry in entries { (row(entry)) } }
                } }
                @if !scope.skipped_benchmarks.is_empty() {
                    p class="soft" { "Left out (--long runs them): " (scope.skipped_benchmarks.join(", ")) "." }
                }
                script { (PreEscaped(include_str!("index.js"))) }
            } }
        }
    }
}

/// Headings of the table of benchmarks.
const HEADS: [&str; 6] = ["State", "Benchmark", "Source", "Checks", "Form", "Run time"];

/// Number of benchmarks with a status.
fn count(entries: &[BenchmarkEntry], status: BenchmarkStatus) -> usize {
    entries.iter().filter(|entry| entry.status() == status).count()
}

/// Head of the page: scope, counts, provenance.
fn head(entries: &[BenchmarkEntry], about: &Provenance, scope: &ReportScope) -> Markup {
    let checks: usize = entries.iter().map(BenchmarkEntry::judged_checks).sum();
    let shown: usize = entries.iter().map(|entry| entry.count(CheckVerdict::Unbounded)).sum();
    let time: f64 = entries.iter().map(|entry| entry.seconds).sum();
    html! {
        p {
            strong { (scope.text()) } ". "
            @for status in [BenchmarkStatus::Pass, BenchmarkStatus::Open, BenchmarkStatus::Fail] {
                (status_badge(status)) " " (count(entries, status)) " "
            }
        }
        p class="soft" {
            (checks) " checks; " (open_defect_text(entries)) "; " (shown) " values shown without bounds; "
            (duration_text(time)) " of runs. Pass: every check is within its bounds. Open: all failing checks are recorded defects, with the reason on the page of the "
            "benchmark. Fail: a check fails and is not a recorded defect, or the benchmark did not finish. "
            a href=(COVERAGE) { "Coverage of specification sheets" } "." br;
            "Commit " (about.commit) ", " (about.date) ", " (about.machine) ", " (about.rustc)
        }
        @if count(entries, BenchmarkStatus::Fail) > 0 {
            p class="problem" {
                strong { "Failures: " }
                @for entry in entries.iter().filter(|entry| entry.status() == BenchmarkStatus::Fail) {
                    a href={ "#" (entry.benchmark.id) } { (entry.benchmark.id) } " "
                }
            }
        }
    }
}

/// Section with the search and the filters; hidden without scripts.
fn filter_section(entries: &[BenchmarkEntry]) -> Markup {
    let methods: BTreeSet<&str> = entries.iter().map(BenchmarkEntry::method).collect();
    let all: BTreeSet<String> = entries.iter().flat_map(|entry| sources(entry.benchmark.source)).collect();
    let states = [BenchmarkStatus::Pass, BenchmarkStatus::Open, BenchmarkStatus::Fail];
    html! {
        div class="tools" hidden {
            input id="search" type="search" placeholder="search name, title, source" aria-label="search";
            select id="method" aria-label="method" {
                option value="" { "all methods" }
                @for method in methods { option value=(method) { (method) } }
            }
            select id="source" aria-label="source" {
                option value="" { "all sources" }
                @for source in all { option value=(source) { (source) } }
            }
            select id="status" aria-label="state" {
                option value="" { "all states" }
                @for state in states { option value=(state.name()) { (state.name()) } }
            }
            @for state in [BenchmarkStatus::Fail, BenchmarkStatus::Open] {
                @if count(entries, state) > 0 {
                    button type="button" id={ "next-" (state.name()) } { "next " (state.name()) }
                }
            }
            span class="soft" id="count" {}
        }
    }
}

/// Row of a benchmark.
fn row(entry: &BenchmarkEntry) -> Markup {
    let benchmark = entry.benchmark;
    let status = entry.status();
    let mut checks = vec![format!("{} pass", entry.count(CheckVerdict::Pass))];
    for (verdict, word) in [(CheckVerdict::Open, "open"), (CheckVerdict::Fail, "fail")] {
        let number = entry.count(verdict);
        checks.extend((number > 0).then(|| format!("{number} {word}")));
    }
    checks.extend(entry.error.is_some().then(|| "did not finish".to_owned()));
    html! {
        tr id=(benchmark.id) class=(status.name()) data-status=(status.name()) data-method=(entry.method())
            data-sources=(sources(benchmark.source).join("|")) {
            td { (status_badge(status)) }
            td { a href={ (PAGES) "/" (benchmark.id) ".html" } { (benchmark.id) } br; (benchmark.title) }
            td class="soft" data-head="Source:" { (benchmark.source) }
            td data-head="Checks:" { (checks.join(", ")) }
            td data-head="Form:" { (form_text(entry)) }
            td class="number" data-head="Run time:" { (duration_text(entry.seconds)) }
        }
    }
}

/// Works that a benchmark names as its source, without numbers of figures and rows.
pub fn sources(text: &str) -> Vec<String> {
    let work = |part: &str| -> Option<String> {
        let part = part.trim();
        if let Some(sheet) = part.strip_prefix("sheet: ") {
            let name = sheet.split([' ', ',']).next()?;
            return Some(format!("sheet: {name}"));
        }
        // A name with its year; the rest locates the figure or row.
        let words: Vec<&str> = part.split([' ', ',']).collect();
        let digits = |word: &&str| word.len() == 4 && word.chars().all(|c| c.is_ascii_digit());
        let year = words.iter().position(digits)?;
        Some(words[..=year].join(" ").replace("  ", " ").replace(" & ", " and "))
    };
    let mut found: BTreeSet<String> = text.split([';', '`']).filter_map(work).collect();
    if found.is_empty() {
        // Closed forms, and agreement of methods.
        found.insert(text.split(';').next().unwrap_or(text).trim().to_owned());
    }
    found.into_iter().collect()
}
