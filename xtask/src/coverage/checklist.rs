//! Rows of the checklists, and their recorded states.

use std::path::Path;

use colluvium::case::output::OutputError;

use crate::benchmarks::all_benchmarks;

/// Sheets whose checklists are numbered tables, in the order of the page.
const SHEETS: [&str; 6] = ["depth-sph", "dem", "snow-mpm", "mpm", "sph", "constitutive"];

/// State of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChecklistState {
    /// Not implemented.
    Missing,
    /// Implemented in part, or without a test or benchmark.
    Partial,
    /// Nobody has looked.
    NotChecked,
    /// Implemented, with a test or a benchmark that shows it.
    Done,
    /// Theory without anything to compute, or that its sheet leaves out.
    Background,
}

impl ChecklistState {
    /// All states, in the order of the page.
    pub const ALL: [Self; 5] = [Self::Missing, Self::Partial, Self::NotChecked, Self::Done, Self::Background];

    /// Name of the state.
    pub fn name(self) -> &'static str {
        match self {
            Self::Missing => "missing",
            Self::Partial => "in part",
            Self::NotChecked => "not checked",
            Self::Done => "done",
            Self::Background => "background",
        }
    }
}

/// Row of a checklist.
#[derive(Clone, Debug)]
pub struct ChecklistRow {
    /// Number or label of the row.
    pub id: String,
    /// Requirement that the row states.
    pub text: String,
    /// Recorded state of the row.
    pub state: ChecklistState,
    /// Files that implement it.
    pub files: Vec<String>,
    /// Tests, as `file::name`.
    pub tests: Vec<String>,
    /// Names of benchmarks.
    pub benchmarks: Vec<String>,
    /// Missing parts, or the place where they are implemented.
    pub note: String,
}

/// Sheet with its checklist rows.
#[derive(Clone, Debug)]
pub struct ChecklistSheet {
    /// Name.
    pub name: &'static str,
    /// Rows, in their order.
    pub rows: Vec<ChecklistRow>,
    /// Lines of the data that belong to no row or cannot be read.
    unassigned_lines: Vec<String>,
}

/// Reads all sheets, with the recorded states of their rows.
pub fn load_sheets() -> Result<Vec<ChecklistSheet>, String> {
    SHEETS.iter().map(|name| sheet(name)).collect()
}

/// Reads the checklist of a sheet with its recorded states.
fn sheet(name: &'static str) -> Result<ChecklistSheet, String> {
    let read = |file: &Path| {
        std::fs::read_to_string(file).map_err(|error| OutputError::new(file, error).to_string())
    };
    let folder = crate::root().join("docs/sheets");
    let mut sheet = ChecklistSheet {
        name,
        rows: checklist(&read(&folder.join(format!("{name}.md")))?),
        unassigned_lines: Vec::new(),
    };
    let data = folder.join("coverage").join(format!("{name}.csv"));
    if data.exists() {
        sheet.read_records(&read(&data)?);
    }
    Ok(sheet)
}

/// Rows of the table below the heading “Feature checklist”.
fn checklist(text: &str) -> Vec<ChecklistRow> {
    let table = text.split_once("## 4. Feature checklist").map_or("", |(_, after)| after);
    let table = table.split("\n## ").next().unwrap_or_default();
    let row = |line: &str| {
        let mut cells = line.trim().strip_prefix('|')?.split('|').map(str::trim);
        let (id, text) = (cells.next()?, cells.next()?);
        let numbered = id.trim_start_matches(|c: char| c.is_ascii_uppercase());
        let named = numbered.starts_with(|c: char| c.is_ascii_digit()) && !text.is_empty();
        named.then(|| ChecklistRow {
            id: id.to_owned(),
            text: text.to_owned(),
            state: ChecklistState::NotChecked,
            files: Vec::new(),
            tests: Vec::new(),
            benchmarks: Vec::new(),
            note: String::new(),
        })
    };
    table.lines().filter_map(row).collect()
}

impl ChecklistSheet {
    /// Reads the recorded states: lines `row;state;files;tests;benchmarks;note`, with names separated by spaces.
    fn read_records(&mut self, data: &str) {
        for (number, line) in data.lines().enumerate() {
            if line.starts_with('#') || line.trim().is_empty() || number == 0 {
                continue;
            }
            let cells: Vec<&str> = line.splitn(6, ';').map(str::trim).collect();
            let state = cells
                .get(1)
                .and_then(|name| ChecklistState::ALL.into_iter().find(|state| state.name() == *name));
            let row = self.rows.iter_mut().find(|row| Some(&row.id.as_str()) == cells.first());
            let (Some(row), Some(state), 6) = (row, state, cells.len()) else {
                self.unassigned_lines.push(format!("{}, line {}: {line}", self.file(), number + 1));
                continue;
            };
            let names = |k: usize| cells[k].split_whitespace().map(str::to_owned).collect();
            (row.state, row.files, row.tests, row.benchmarks) = (state, names(2), names(3), names(4));
            row.note = cells[5].to_owned();
        }
    }

    /// Path of the file of recorded states.
    pub fn file(&self) -> String {
        format!("docs/sheets/coverage/{}.csv", self.name)
    }

    /// Number of rows in a state.
    pub fn count(&self, state: ChecklistState) -> usize {
        self.rows.iter().filter(|row| row.state == state).count()
    }

    /// Errors of the records: unknown names, and states that lack the entries that they need.
    pub fn record_errors(&self) -> Vec<String> {
        let of = |row: &ChecklistRow| {
            let message = |what: String| format!("{}, row {}: {what}", self.file(), row.id);
            row.record_errors().into_iter().map(message).collect::<Vec<_>>()
        };
        self.unassigned_lines
            .iter()
            .map(|line| format!("{line}: is not a row with a state"))
            .chain(self.rows.iter().flat_map(of))
            .collect()
    }
}

impl ChecklistRow {
    /// Errors of the record of a row: files and tests that do not exist.
    fn record_errors(&self) -> Vec<String> {
        let mut wrong = Vec::new();
        let there = |file: &str| crate::root().join(file).is_file();
        wrong.extend(
            self.files.iter().filter(|file| !there(file)).map(|file| format!("there is no file {file}")),
        );
        for test in &self.tests {
            let (file, name) = test.split_once("::").unwrap_or((test, ""));
            let text = std::fs::read_to_string(crate::root().join(file)).unwrap_or_default();
            if name.is_empty() || !text.contains(&format!("fn {name}(")) {
                wrong.push(format!("there is no test {test}"));
            }
        }
        let known = |id: &String| all_benchmarks().any(|benchmark| benchmark.id == id);
        wrong.extend(
            self.benchmarks.iter().filter(|id| !known(id)).map(|id| format!("there is no benchmark {id}")),
        );
        let shown = !self.tests.is_empty() || !self.benchmarks.is_empty();
        if self.state == ChecklistState::Done && (self.files.is_empty() || !shown) {
            wrong.push("is done, but has no file, or no test or benchmark".to_owned());
        }
        if matches!(self.state, ChecklistState::Missing | ChecklistState::Partial) && self.note.is_empty() {
            wrong.push(format!("is {}, but has no note on the missing part", self.state.name()));
        }
        wrong
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "## 4. Feature checklist\n\n| # | feature | source |\n|---|---|---|\n| 1 | drag | (2) |\n\
                        | F2 | shear | (3) |\n\n## 5. Benchmarks\n| 3 | no row | |\n";

    fn test_sheet(data: &str) -> ChecklistSheet {
        let mut sheet = ChecklistSheet { name: "dem", rows: checklist(TEXT), unassigned_lines: Vec::new() };
        sheet.read_records(&format!("row;state;files;tests;benchmarks;note\n{data}"));
        sheet
    }

    #[test]
    fn rows_are_those_of_the_checklist_and_unknown_ones_are_not_checked() {
        let sheet = test_sheet("");
        let rows: Vec<(&str, &str)> =
            sheet.rows.iter().map(|row| (row.id.as_str(), row.text.as_str())).collect();
        assert_eq!(rows, [("1", "drag"), ("F2", "shear")]);
        assert_eq!((sheet.count(ChecklistState::NotChecked), sheet.record_errors()), (2, vec![]));
        let counts =
            load_sheets().unwrap().iter().map(|sheet| (sheet.name, sheet.rows.len())).collect::<Vec<_>>();
        assert_eq!(counts[..3], [("depth-sph", 64), ("dem", 52), ("snow-mpm", 56)]);
        assert!(counts.iter().all(|(_, rows)| *rows > 20), "{counts:?}");
    }

    #[test]
    fn missing_names_in_the_checklist_are_reported() {
        let file = "xtask/src/coverage/checklist.rs";
        let test = format!("{file}::missing_names_in_the_checklist_are_reported");
        assert!(test_sheet(&format!("1;done;{file};{test};dem/gas;")).record_errors().is_empty());
        for (data, words) in [
            ("1;done;crates/none.rs;;dem/gas;".to_owned(), "no file crates/none.rs"),
            (format!("1;done;{file};{file}::no_such_test;;"), "no test"),
            (format!("1;done;{file};;dem/none;"), "no benchmark dem/none"),
            (format!("1;done;{file};;;"), "has no file, or no test"),
            (format!("F2;in part;{file};;;"), "has no note on the missing part"),
            ("9;done;;;;".to_owned(), "is not a row with a state"),
            ("1;well;;;;".to_owned(), "is not a row with a state"),
        ] {
            let wrong = test_sheet(&data).record_errors().join("\n");
            assert!(wrong.contains(words), "{data}: {wrong}");
        }
    }
}
