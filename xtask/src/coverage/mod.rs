//! `cargo xtask coverage`: every row of the checklists of specification sheets, with its implementation, tests and benchmarks.
//!
//! Rows are in their sheets, their states in `docs/sheets/coverage/<sheet>.csv`. A row without an entry there is not checked.

mod checklist;
mod page;

use clap::Args;

use crate::coverage::checklist::ChecklistSheet;
pub use crate::coverage::checklist::load_sheets;
use crate::open_defects;
pub use page::{html, summary_text};

#[derive(Args)]
pub struct CoverageArguments {}

/// Path of the page of the documentation that is generated from the rows.
pub const PAGE_FILE: &str = "docs/coverage.md";

/// Writes the page and the table of open defects; returns whether every name in the rows exists.
pub fn run(_: &CoverageArguments) -> Result<bool, String> {
    let sheets = load_sheets()?;
    let wrong: Vec<String> = sheets.iter().flat_map(ChecklistSheet::record_errors).collect();
    wrong.iter().for_each(|line| eprintln!("{line}"));
    let pages =
        [(PAGE_FILE, page::markdown(&sheets)), (open_defects::PAGE_FILE, open_defects::page_with_table()?)];
    for (file, text) in pages {
        std::fs::write(crate::root().join(file), text).map_err(|error| format!("{file}: {error}"))?;
        println!("wrote {file}");
    }
    println!("{}", summary_text(&sheets));
    Ok(wrong.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_names_tests_files_and_benchmarks_that_are_there() {
        let wrong: Vec<String> =
            load_sheets().unwrap().iter().flat_map(ChecklistSheet::record_errors).collect();
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }

    #[test]
    fn the_page_is_that_of_the_rows() {
        let written = std::fs::read_to_string(crate::root().join(PAGE_FILE)).unwrap_or_default();
        assert!(written == page::markdown(&load_sheets().unwrap()), "write it anew: cargo xtask coverage");
    }
}
