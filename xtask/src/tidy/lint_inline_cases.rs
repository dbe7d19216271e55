//! Inline cases: the case of a benchmark is a file that `colluvium run` takes; code may change it, but not write it.

use crate::tidy::RuleViolation;
use crate::tidy::source_tree::SourceTree;

/// Violations by whole cases in the sources of benchmarks: JSON objects with a title and a space.
pub fn inline_cases(tree: &SourceTree) -> Vec<RuleViolation> {
    let benchmarks = tree.sources().filter(|file| file.path.starts_with("xtask/src/benchmarks/"));
    benchmarks
        .flat_map(|file| {
            let lines: Vec<&str> = file.text.lines().collect();
            let is_case = |k: &usize| {
                lines[*k].contains("\"title\":")
                    && lines[*k..lines.len().min(k + 3)].iter().any(|line| line.contains("\"space\":"))
            };
            let found: Vec<RuleViolation> = (0..lines.len())
                .filter(is_case)
                .map(|k| {
                    let message =
                        "a case is written in code; move it to validation/<method>/<name>/case.json";
                    RuleViolation::new("case in code", &file.path, k + 1, message.to_owned())
                })
                .collect();
            found
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whole_case_is_found_and_a_change_of_one_is_not() {
        let tree = SourceTree::from_files(&[
            ("xtask/src/benchmarks/a.rs", "json!({\n    \"title\": \"bar\",\n    \"space\": \"1d\"\n})\n"),
            ("xtask/src/benchmarks/b.rs", "json!({ \"space\": \"3d\" })\n"),
            ("xtask/src/speed/mpm.rs", "json!({ \"title\": \"throughput\", \"space\": \"3d\" })\n"),
        ]);
        let found: Vec<_> = inline_cases(&tree).into_iter().map(|f| (f.file, f.line)).collect();
        assert_eq!(found, [("xtask/src/benchmarks/a.rs".to_owned(), 2)]);
    }
}
