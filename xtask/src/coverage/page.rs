//! Page of the checklist rows for the documentation and the report.

use std::fmt::Write;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::coverage::checklist::{ChecklistRow, ChecklistSheet, ChecklistState};

/// Text with the number of rows in each state.
pub fn summary_text(sheets: &[ChecklistSheet]) -> String {
    let all: usize = sheets.iter().map(|sheet| sheet.rows.len()).sum();
    let count = |state: ChecklistState| sheets.iter().map(|sheet| sheet.count(state)).sum::<usize>();
    let parts = ChecklistState::ALL.map(|state| format!("{} {}", count(state), state.name()));
    format!("{all} rows: {}", parts.join(", "))
}

/// Rows of a sheet, incomplete ones first.
fn incomplete_first(sheet: &ChecklistSheet) -> Vec<&ChecklistRow> {
    let mut rows: Vec<&ChecklistRow> = sheet.rows.iter().collect();
    let rank = |row: &&ChecklistRow| ChecklistState::ALL.iter().position(|state| *state == row.state);
    rows.sort_by_key(rank);
    rows
}

/// Page of the documentation as Markdown.
pub fn markdown(sheets: &[ChecklistSheet]) -> String {
    let mut text = format!(
        "# Coverage of specification sheets\n\nRows of the checklists of the [specification sheets](sheets/README.md) that are not done. \
         `cargo xtask coverage` writes this page from the records in `docs/sheets/coverage/`. All rows, with files, tests and benchmarks, \
         are in `coverage.html` of the [report](validation.md). A test fails when a row names one that does not exist.\n\n\
         - *Missing*: not implemented.\n- *In part*: the note describes the missing part.\n- *Not checked*: not compared with the code.\n\
         - *Done*: implemented, and verified by a test or a benchmark.\n- *Background*: nothing to compute, or left out by its sheet.\n\n\
         The entries follow from the comments at the head of files, and from names and sources of tests and benchmarks. Not every line \
         of these has been compared with its row.\n\n{}.\n\n| sheet |",
        summary_text(sheets)
    );
    // Writing to a string cannot fail.
    for state in ChecklistState::ALL {
        let _ = write!(text, " {} |", state.name());
    }
    let _ = writeln!(text, "\n|---|{}", "---|".repeat(ChecklistState::ALL.len()));
    for sheet in sheets {
        let _ = write!(text, "| [{0}](sheets/{0}.md) |", sheet.name);
        ChecklistState::ALL.iter().for_each(|state| {
            let _ = write!(text, " {} |", sheet.count(*state));
        });
        text.push('\n');
    }
    for sheet in sheets {
        let is_open =
            |row: &&&ChecklistRow| !matches!(row.state, ChecklistState::Done | ChecklistState::Background);
        let rows = incomplete_first(sheet);
        if !rows.iter().any(|row| is_open(&row)) {
            continue;
        }
        let _ = writeln!(text, "\n## {0}\n\n[The sheet](sheets/{0}.md).\n", sheet.name);
        text.push_str("| row | feature | state | note |\n|---|---|---|---|\n");
        for row in rows.iter().filter(is_open) {
            let _ = writeln!(text, "| {} | {} | {} | {} |", row.id, row.text, row.state.name(), row.note);
        }
    }
    text
}

/// Page of the report as HTML. `up` is the relative link to the root of the repository.
pub fn html(sheets: &[ChecklistSheet], style: &str, up: &str) -> Markup {
    let link = |file: &str, text: &str| html! { a href={ (up) (file) } { (text) } };
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "Colluvium: coverage of specification sheets" }
                style { (PreEscaped(style)) }
            }
            body { main {
                p class="soft" { a href="index.html" { "← all benchmarks" } }
                h1 { "Coverage of specification sheets" }
                p { (summary_text(sheets)) ". Incomplete rows come first. Rows not checked have not been compared with the code. The entries of the others follow from the comments at the head of "
                    "files, and from the names and sources of tests and benchmarks." }
                @for sheet in sheets {
                    h2 id=(sheet.name) { (link(&format!("docs/sheets/{}.md", sheet.name), sheet.name)) }
                    div class="card" { table class="rows" {
                        thead { tr { @for name in ["Row", "Feature", "State", "Files", "Tests and benchmarks", "Note"] { th { (name) } } } }
                        tbody { @for row in incomplete_first(sheet) {
                            tr {
                                td { (row.id) }
                                td { (row.text) }
                                td { span class={ "badge " (badge_class(row.state)) } { (row.state.name()) } }
                                td { @for file in &row.files { (link(file, file.trim_start_matches("crates/"))) br; } }
                                td {
                                    @for test in &row.tests {
                                        (link(test.split("::").next().unwrap_or_default(), test.trim_start_matches("crates/"))) br;
                                    }
                                    @for id in &row.benchmarks { a href={ "pages/" (id) ".html" } { (id) } br; }
                                }
                                td class="soft" { (row.note) }
                            }
                        } }
                    } }
                }
            } }
        }
    }
}

/// Badge class of a state.
fn badge_class(state: ChecklistState) -> &'static str {
    match state {
        ChecklistState::Missing => "fail",
        ChecklistState::Partial => "open",
        ChecklistState::Done => "pass",
        ChecklistState::NotChecked | ChecklistState::Background => "shown",
    }
}
