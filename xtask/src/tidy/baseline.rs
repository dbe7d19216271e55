//! Known number of violations of each rule in each part of the tree: a number that may only fall.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::tidy::RuleViolation;

/// Known numbers of violations by rule and part of the tree.
pub struct Baseline {
    known_counts: ViolationCounts,
}

/// Number of violations by rule and part of the tree.
type ViolationCounts = BTreeMap<String, BTreeMap<String, usize>>;

/// Result of a comparison of violations with the baseline.
pub struct BaselineComparison {
    /// Rule, part, known count and count found, where more are found than are known.
    increased: Vec<(String, String, usize, usize)>,
    /// Rule, part, known count and count found, where fewer are found than are known.
    decreased: Vec<(String, String, usize, usize)>,
    known_total: usize,
}

/// Counts violations by rule and part of the tree.
fn count(findings: &[RuleViolation]) -> ViolationCounts {
    let mut counts = ViolationCounts::new();
    for finding in findings {
        *counts.entry(finding.rule_name.to_owned()).or_default().entry(finding.tree_part()).or_default() += 1;
    }
    counts
}

/// Number of violations of a rule in a part of the tree.
fn number(counts: &ViolationCounts, rule: &str, part: &str) -> usize {
    counts.get(rule).and_then(|parts| parts.get(part)).copied().unwrap_or(0)
}

impl Baseline {
    /// Reads the baseline; a missing file is an empty one.
    ///
    /// # Errors
    ///
    /// A file that is not a baseline.
    pub fn read(path: &Path) -> Result<Self, String> {
        let Ok(text) = fs::read_to_string(path) else {
            return Ok(Self { known_counts: ViolationCounts::new() });
        };
        let known_counts =
            serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Self { known_counts })
    }

    /// Writes the baseline.
    ///
    /// # Errors
    ///
    /// The error of the file system.
    pub fn write(&self, path: &Path) -> Result<(), String> {
        let text = serde_json::to_string_pretty(&self.known_counts).map_err(|error| error.to_string())?;
        fs::write(path, text + "\n").map_err(|error| format!("{}: {error}", path.display()))
    }

    /// Compares the violations found with the known ones.
    pub fn compare(&self, findings: &[RuleViolation]) -> BaselineComparison {
        let found = count(findings);
        let mut verdict = BaselineComparison { increased: Vec::new(), decreased: Vec::new(), known_total: 0 };
        for counts in [&found, &self.known_counts] {
            for (rule, parts) in counts {
                for part in parts.keys() {
                    let row = (
                        rule.clone(),
                        part.clone(),
                        number(&self.known_counts, rule, part),
                        number(&found, rule, part),
                    );
                    if row.3 > row.2 && !verdict.increased.contains(&row) {
                        verdict.increased.push(row);
                    } else if row.3 < row.2 && !verdict.decreased.contains(&row) {
                        verdict.decreased.push(row);
                    }
                }
            }
        }
        verdict.known_total = findings.iter().filter(|finding| !verdict.is_new(finding)).count();
        verdict
    }

    /// Lowers the known counts to those found. Counts that have risen stay unchanged.
    pub fn lower(&mut self, findings: &[RuleViolation]) {
        let found = count(findings);
        for (rule, parts) in &mut self.known_counts {
            for (part, known) in &mut *parts {
                *known = (*known).min(number(&found, rule, part));
            }
            parts.retain(|_, known| *known > 0);
        }
        self.known_counts.retain(|_, parts| !parts.is_empty());
    }
}

impl BaselineComparison {
    /// Whether `finding` is of a rule and part with more violations than are known.
    pub fn is_new(&self, finding: &RuleViolation) -> bool {
        let part = finding.tree_part();
        self.increased.iter().any(|(rule, of, ..)| *rule == finding.rule_name && *of == part)
    }

    /// Whether no count is above the known one.
    pub fn passes(&self) -> bool {
        self.increased.is_empty()
    }

    /// Prints the comparison.
    pub fn print(&self) {
        for (rule, part, known, found) in &self.increased {
            println!("{part}: {found} × {rule}, where {known} are known: correct the new ones above");
        }
        for (rule, part, known, found) in &self.decreased {
            println!("{part}: {found} × {rule}, where {known} were known");
        }
        if !self.decreased.is_empty() {
            println!("record the lower counts: cargo xtask tidy --lower");
        }
        let end = if self.passes() { "tidy" } else { "not tidy" };
        println!("{end}; {} known findings (cargo xtask tidy --all)", self.known_total);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(rule: &'static str, file: &str) -> RuleViolation {
        RuleViolation::new(rule, file, 1, String::new())
    }

    fn ratchet(rule: &str, part: &str, known: usize) -> Baseline {
        Baseline {
            known_counts: ViolationCounts::from([(
                rule.to_owned(),
                BTreeMap::from([(part.to_owned(), known)]),
            )]),
        }
    }

    #[test]
    fn more_findings_than_the_baseline_fail_and_fewer_pass() {
        let two = [finding("long", "crates/a/src/x.rs"), finding("long", "crates/a/src/y.rs")];
        assert!(!ratchet("long", "crates/a", 1).compare(&two).passes());
        assert!(ratchet("long", "crates/a", 2).compare(&two).passes());
        assert!(ratchet("long", "crates/a", 3).compare(&two).passes());
        assert!(
            !ratchet("long", "crates/b", 3).compare(&two).passes(),
            "another crate's findings are not known"
        );
    }

    #[test]
    fn a_ratchet_falls_and_never_rises() {
        let two = [finding("long", "crates/a/src/x.rs"), finding("long", "crates/a/src/y.rs")];
        let mut loose = ratchet("long", "crates/a", 5);
        loose.lower(&two);
        assert_eq!(number(&loose.known_counts, "long", "crates/a"), 2);
        let mut tight = ratchet("long", "crates/a", 1);
        tight.lower(&two);
        assert_eq!(number(&tight.known_counts, "long", "crates/a"), 1);
        tight.lower(&[]);
        assert!(tight.known_counts.is_empty());
    }
}
