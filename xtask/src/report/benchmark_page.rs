//! Page of a benchmark.

use colluvium::compare::SECTIONS_STYLE;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::benchmarks::{Check, CheckVerdict};
use crate::report::value_text::{
    STYLE, bounds_text, duration_text, number_text, status_badge, verdict_badge,
};
use crate::report::{BenchmarkEntry, Provenance, form_text};

/// File name of a picture, which is in the folder of the page.
pub fn picture(entry: &BenchmarkEntry, number: usize) -> String {
    let name = entry.benchmark.id.rsplit('/').next().unwrap_or_default();
    format!("{name}-{}.{}", number + 1, entry.outcome.figures[number].extension)
}

/// Page of a benchmark. `up` is the relative link to the root of the repository.
pub fn page(entry: &BenchmarkEntry, about: &Provenance, up: &str) -> Markup {
    let benchmark = entry.benchmark;
    // A page lies as deep below the folder of the report as its name has parts.
    let index = format!("{}index.html#{}", "../".repeat(1 + benchmark.id.matches('/').count()), benchmark.id);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (benchmark.id) ": " (benchmark.title) }
                style { (PreEscaped(STYLE)) (PreEscaped(SECTIONS_STYLE)) }
            }
            body { main {
                p class="soft" { a href=(index) { "← all benchmarks" } }
                h1 { (benchmark.title) " " (status_badge(entry.status())) }
                p class="soft" { (benchmark.id) ", in its " (form_text(entry)) " form; run time " (duration_text(entry.seconds))
                    @if entry.cached { ", from an earlier run: program and files are unchanged since" }
                }
                p { strong { "Source: " } (benchmark.source) }
                @if let Some(error) = &entry.error {
                    p class="problem" { strong { "Could not finish: " } (error) }
                }
                (open_defects_section(entry))
                (animation_section(entry))
                (figures(entry))
                (checks(entry))
                @if let Some(comparison) = &entry.outcome.comparison { (PreEscaped(comparison)) }
                (reproduction_section(entry, up))
                p class="soft" { "Commit " (about.commit) ", " (about.date) ", " (about.machine) ", " (about.rustc) }
            } }
        }
    }
}

/// Section of the checks that are known to fail, with the observations.
fn open_defects_section(entry: &BenchmarkEntry) -> Markup {
    let known = entry.outcome.checks.iter().filter(|check| check.verdict() == CheckVerdict::Open);
    let mut causes: Vec<(&str, &str, Vec<&str>)> = Vec::new();
    for check in known {
        let Some(defect) = &check.defect else { continue };
        match causes.iter_mut().find(|(_, found, _)| *found == defect.observation) {
            Some((.., names)) => names.push(&check.name),
            None => causes.push((defect.criterion.text(), &defect.observation, vec![&check.name])),
        }
    }
    html! {
        @if !causes.is_empty() { h2 { "Open" } }
        @for (criterion, found, names) in &causes {
            div class="card" {
                p { (status_badge(crate::report::BenchmarkStatus::Open)) " " (names.join("; ")) }
                p { em { "A check " (criterion) ". " } "Found: " (found) "." }
            }
        }
    }
}

/// Section of animations of runs.
fn animation_section(entry: &BenchmarkEntry) -> Markup {
    let films = &entry.outcome.animations;
    html! {
        @if !films.is_empty() {
            h2 { "Animation" }
            p class="soft" { "The first runs of the benchmark that have frames." }
            @for film in films { (PreEscaped(&film.element)) p class="soft" { (film.caption) } }
            (PreEscaped(colluvium::output::animation::scripts()))
        }
    }
}

/// Pictures of a benchmark with their captions.
fn figures(entry: &BenchmarkEntry) -> Markup {
    html! {
        @if !entry.outcome.figures.is_empty() { h2 { "Pictures" } }
        @for (number, figure) in entry.outcome.figures.iter().enumerate() {
            figure class="card" {
                img src=(picture(entry, number)) alt=(figure.caption) loading="lazy";
                figcaption { (figure.caption) }
            }
        }
    }
}

/// Table of the checks of a benchmark.
fn checks(entry: &BenchmarkEntry) -> Markup {
    let row = |check: &Check| {
        let state = match check.verdict() {
            CheckVerdict::Fail => "fail",
            CheckVerdict::Open => "open",
            CheckVerdict::Pass | CheckVerdict::Unbounded => "",
        };
        html! {
            tr class=(state) {
                td { (verdict_badge(check)) }
                td { (check.name) }
                td data-head="Source:" { (check.claim) }
                td class="number" data-head="Found:" { (number_text(check.measured)) }
                td class="number" data-head="Bounds:" { (bounds_text(check.range)) }
                td class="soft" data-head="Reason:" { (check.reason) }
            }
        }
    };
    html! {
        h2 { "Numbers" }
        div class="card" { table class="rows" {
            thead { tr {
                th { "State" } th { "Quantity" } th { "Source" } th { "Found" } th { "Bounds" } th { "Reason for the bounds" }
            } }
            tbody { @for check in &entry.outcome.checks { (row(check)) } }
        } }
    }
}

/// Section with case files, commands, theory and sheets.
fn reproduction_section(entry: &BenchmarkEntry, up: &str) -> Markup {
    let id = entry.benchmark.id;
    let form = if entry.is_short { " --quick" } else { " --long" };
    let link = |file: &str| html! { a href={ (up) (file) } { (file) } };
    let case = |file: &&String| file.ends_with("case.json");
    html! {
        h2 { "Run it again" }
        p { code { "cargo xtask validate " (id) (form) } }
        @if entry.files.is_empty() {
            p class="soft" { "The benchmark reads no case file: its input is in its source code." }
        } @else {
            p { "The benchmark reads" }
            ul { @for file in &entry.files { li { (link(file)) } } }
            @if entry.files.iter().any(|file| case(&file)) {
                p class="soft" { "Command for the unmodified case, without the variations of the benchmark:" }
                @for file in entry.files.iter().filter(case) {
                    p { code {
                        @if entry.method() == "compare" { "colluvium compare " (file) }
                        @else { "colluvium run " (file) " --method " (entry.method()) }
                    } }
                }
            }
        }
        p {
            "Program: " (link(&source(id))) "; theory: " (link(&theory(entry.method())))
            @for sheet in sheets(entry.benchmark.source) { "; sheet: " (link(&format!("docs/sheets/{sheet}.md"))) }
        }
    }
}

/// Path of the folder with the module of a benchmark.
fn source(id: &str) -> String {
    format!("xtask/src/benchmarks/{}", id.split('/').next().unwrap_or_default().replace('-', "_"))
}

/// Page on the theory of a method.
pub fn theory(method: &str) -> String {
    match method {
        "element" => "docs/theory/constitutive.md".to_owned(),
        "compare" => "docs/cli.md".to_owned(),
        method => format!("docs/theory/{method}.md"),
    }
}

/// Sheets that a source cites.
pub fn sheets(source: &str) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for after in source.split("sheet: ").skip(1) {
        let name = after.split([' ', ',', ';', '`']).next().unwrap_or_default();
        if !name.is_empty() && !names.contains(&name) {
            names.push(name);
        }
    }
    names
}
