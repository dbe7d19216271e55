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
        "# Coverage of specification sheets\n\nEvery row of the checklists of the [specification sheets](sheets/README.md): its files, \
         tests and benchmarks. Made by `cargo xtask coverage` from their checklists and from the records of the rows in \
         `docs/sheets/coverage/`; a test fails when a row names a file, a test or a benchmark that does not exist.\n\n\
         *Missing*: not implemented. *In part*: the note describes the missing part. *Not checked*: the row has not been compared with the code, and may \
         or may not be implemented. *Done*: implemented, and verified by a test or a benchmark. *Background*: nothing to \
         compute, or left out by its sheet. The entries of rows follow from the comments at the head of files, and from names and sources of \
         tests and benchmarks; not every line of them has been compared with its row.\n\n{}.\n\n| sheet |",
        summary_text(sheets)
    );
    // Writing to a string cannot fail.
    for state in ChecklistState::ALL {
        let _ = write!(text, " {} |", state.name());
    }
    let _ = writeln!(text, "\n|---|{}", "---|".repeat(ChecklistState::ALL.len()));
    for sheet in sheets {
        let _ = write!(text, "| [{0}](#{0}) |", sheet.name);
        ChecklistState::ALL.iter().for_each(|state| {
            let _ = write!(text, " {} |", sheet.count(*state));
        });
        text.push('\n');
    }
    for sheet in sheets {
        let _ = writeln!(text, "\n## {0}\n\n[The sheet](sheets/{0}.md).\n", sheet.name);
        text.push_str(
            "| row | feature | state | files | tests and benchmarks | note |\n|---|---|---|---|---|---|\n",
        );
        for row in incomplete_first(sheet) {
            let code = |names: &mut dyn Iterator<Item = &String>| {
                names
                    .map(|name| format!("`{}`", name.trim_start_matches("crates/")))
                    .collect::<Vec<_>>()
                    .join(", ")
            };
            let files = code(&mut row.files.iter());
            let shown = code(&mut row.tests.iter().chain(&row.benchmarks));
            let state = row.state.name();
            let _ =
                writeln!(text, "| {} | {} | {state} | {files} | {shown} | {} |", row.id, row.text, row.note);
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
