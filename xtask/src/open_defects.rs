//! Checks that are known to fail: `validation/open-defects.json`.

use serde::Deserialize;

use crate::benchmarks::{Criterion, OpenDefect, all_benchmarks};

/// Record of the checks that fail for one known cause.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DefectRecord {
    /// Name of the benchmark.
    benchmark: String,
    /// Prefixes of the names of the checks.
    checks: Vec<String>,
    /// Criterion: relation of the failure to the requirement of the source.
    criterion: Criterion,
    /// Observation that explains the failure.
    found: String,
    /// Rows of the table of the documentation.
    rows: Vec<DefectRow>,
}

/// Row of the table of open defects: short texts.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DefectRow {
    /// Check or group of checks.
    check: String,
    /// Measured values.
    measured: String,
    /// Required values.
    required: String,
}

/// Page with the table of open defects.
pub const PAGE_FILE: &str = "docs/validation.md";

/// Lines before and after the table on its page.
const TABLE_MARKS: [&str; 2] = ["<!-- open defects -->\n\n", "\n<!-- end of open defects -->"];

/// The page with its table made anew from the records.
///
/// # Errors
/// The page cannot be read or has no place for the table.
pub fn page_with_table() -> Result<String, String> {
    let page = std::fs::read_to_string(crate::root().join(PAGE_FILE))
        .map_err(|error| format!("{PAGE_FILE}: {error}"))?;
    let parts = page.split_once(TABLE_MARKS[0]).and_then(|(before, rest)| {
        let (_, after) = rest.split_once(TABLE_MARKS[1])?;
        Some((before, after))
    });
    let (before, after) = parts.ok_or_else(|| format!("{PAGE_FILE} lacks the marks of the table"))?;
    Ok(format!("{before}{}{}{}{after}", TABLE_MARKS[0], table(&read_all()?), TABLE_MARKS[1]))
}

/// Table of open defects as Markdown.
fn table(defects: &[DefectRecord]) -> String {
    let mut text =
        "| benchmark | check | measured | required | verdict |\n|---|---|---|---|---|\n".to_owned();
    for defect in defects {
        for DefectRow { check, measured, required } in &defect.rows {
            let (benchmark, verdict) = (&defect.benchmark, defect.criterion.name());
            text.push_str(&format!("| `{benchmark}` | {check} | {measured} | {required} | {verdict} |\n"));
        }
    }
    text
}

/// Reads the open defects; an unknown benchmark is an error.
pub fn read_all() -> Result<Vec<DefectRecord>, String> {
    let path = crate::root().join("validation/open-defects.json");
    let wrong = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let text = std::fs::read_to_string(&path).map_err(|error| wrong(&error))?;
    let defects: Vec<DefectRecord> = serde_json::from_str(&text).map_err(|error| wrong(&error))?;
    match defects.iter().find(|defect| all_benchmarks().all(|benchmark| benchmark.id != defect.benchmark)) {
        Some(stray) => Err(wrong(&format!("there is no benchmark {:?}", stray.benchmark))),
        None => Ok(defects),
    }
}

/// Open defect of a check; `None` where none is recorded.
pub fn find_defect(defects: &[DefectRecord], benchmark: &str, check: &str) -> Option<OpenDefect> {
    let of_check = |defect: &&DefectRecord| {
        defect.benchmark == benchmark && defect.checks.iter().any(|begin| check.starts_with(begin))
    };
    defects
        .iter()
        .find(of_check)
        .map(|defect| OpenDefect { criterion: defect.criterion, observation: defect.found.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_open_defect_names_its_checks_and_finding() {
        for defect in read_all().unwrap() {
            let is_complete =
                !defect.found.is_empty() && !defect.checks.is_empty() && !defect.rows.is_empty();
            assert!(is_complete, "{}", defect.benchmark);
        }
    }

    #[test]
    fn the_table_of_the_documentation_is_that_of_the_records() {
        let page = std::fs::read_to_string(crate::root().join(PAGE_FILE)).unwrap();
        assert!(page == page_with_table().unwrap(), "write it anew: cargo xtask coverage");
    }

    #[test]
    fn checks_are_identified_by_the_prefix_of_their_name() {
        let defect = DefectRecord {
            benchmark: "mpm/bar".into(),
            checks: vec!["order".into()],
            criterion: Criterion::Missed,
            found: "half".into(),
            rows: vec![],
        };
        assert_eq!(find_defect(&[defect], "mpm/bar", "order of GIMP").unwrap().observation, "half");
        let defect = DefectRecord {
            benchmark: "mpm/bar".into(),
            checks: vec![],
            criterion: Criterion::Met,
            found: String::new(),
            rows: vec![],
        };
        assert!(find_defect(&[defect], "mpm/bar", "order of GIMP").is_none());
    }
}
