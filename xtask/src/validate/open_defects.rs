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
            assert!(!defect.found.is_empty() && !defect.checks.is_empty(), "{}", defect.benchmark);
        }
    }

    #[test]
    fn checks_are_identified_by_the_prefix_of_their_name() {
        let defect = DefectRecord {
            benchmark: "mpm/bar".into(),
            checks: vec!["order".into()],
            criterion: Criterion::Missed,
            found: "half".into(),
        };
        assert_eq!(find_defect(&[defect], "mpm/bar", "order of GIMP").unwrap().observation, "half");
        let defect = DefectRecord {
            benchmark: "mpm/bar".into(),
            checks: vec![],
            criterion: Criterion::Met,
            found: String::new(),
        };
        assert!(find_defect(&[defect], "mpm/bar", "order of GIMP").is_none());
    }
}
