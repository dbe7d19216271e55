//! Words of comments, messages and pages, names of types and files.

use std::collections::BTreeMap;

use super::RuleViolation;
use crate::tidy::source_tree::{SourceFile, SourceTree};

/// Forbidden first words of a doc comment: its first sentence names the item, noun first.
const OPENINGS: [&str; 3] = ["What ", "The same", "As it"];

/// Forbidden phrases, each with a replacement.
const PHRASES: [(&str, &str); 16] = [
    ("what is", "the noun that is meant"),
    ("the same,", "equal, or the noun again"),
    ("as it is", "current, initial, unchanged"),
    ("worth a word", "a warning"),
    ("goes by", "depends on"),
    ("go by", "depend on"),
    ("lets go", "separates, releases"),
    ("let go", "separated, released"),
    ("bears", "carries, supports"),
    ("borne", "carried, supported"),
    ("tells", "reports, records"),
    ("is told", "is reported"),
    ("sees", "detects, receives"),
    ("asks", "requests, requires"),
    ("stands still", "is at rest"),
    ("for good", "permanently"),
];

/// Names of files and folders at the root of a crate that need no entry in the glossary: parts of a program, not of the field.
const PROGRAM_TERMS: [&str; 46] = [
    "allocations",
    "analysis",
    "book",
    "animation",
    "benchmarks",
    "bodies",
    "channel",
    "charts",
    "checkpoint",
    "cli",
    "clock",
    "commands",
    "compare",
    "config",
    "context",
    "contract",
    "coverage",
    "description",
    "driver",
    "error",
    "features",
    "files",
    "fuzz",
    "lib",
    "loads",
    "main",
    "measure",
    "open_defects",
    "output",
    "pages",
    "pictures",
    "pool",
    "reference",
    "report",
    "run",
    "same_bits",
    "search",
    "setup",
    "solver",
    "speed",
    "struct_of_arrays",
    "tables",
    "tasks",
    "templates",
    "tidy",
    "validate",
];

/// Violations by doc comments that begin with one of [`OPENINGS`].
pub fn openings(tree: &SourceTree) -> Vec<RuleViolation> {
    let mut findings = Vec::new();
    for file in tree.sources() {
        let mut before = None;
        for (number, line) in file.text.lines().enumerate() {
            let comment = doc_comment(line);
            let starts = before.is_none();
            before = comment;
            let opening = comment
                .filter(|_| starts)
                .and_then(|text| OPENINGS.iter().find(|own| text.starts_with(**own)));
            if let Some(opening) = opening {
                let message = format!("the doc comment begins with {:?}", opening.trim());
                findings.push(RuleViolation::new(
                    "doc comment without a noun first",
                    &file.path,
                    number + 1,
                    message,
                ));
            }
        }
    }
    findings
}

/// Text of a doc comment; `None` for another line.
fn doc_comment(line: &str) -> Option<&str> {
    let line = line.trim_start();
    line.strip_prefix("///").or_else(|| line.strip_prefix("//!")).map(str::trim_start)
}

/// Violations by forbidden phrases in comments, messages and pages. Specification sheets and generated pages are left out.
pub fn phrases(tree: &SourceTree) -> Vec<RuleViolation> {
    let generated = ["docs/coverage.md", "docs/case-file.md"];
    let is_read = |file: &&SourceFile| {
        !file.path.starts_with("docs/sheets/") && !generated.contains(&file.path.as_str())
    };
    let own = |file: &&SourceFile| !file.path.ends_with("tidy/words.rs");
    let mut findings = Vec::new();
    for file in tree.sources().chain(tree.pages()).filter(is_read).filter(own) {
        for (number, line) in file.text.lines().enumerate() {
            let prose = if file.extension() == "rs" { prose(line) } else { line.to_owned() };
            let prose = prose.to_lowercase();
            for (phrase, other) in PHRASES.iter().filter(|(phrase, _)| has_words(&prose, phrase)) {
                let message = format!("{phrase:?}: {other}");
                findings.push(RuleViolation::new("phrase of no textbook", &file.path, number + 1, message));
            }
        }
    }
    findings
}

/// Comment and quoted texts of a line.
fn prose(line: &str) -> String {
    let (code, comment) = line.split_once("//").unwrap_or((line, ""));
    let quoted: Vec<&str> = code.split('"').skip(1).step_by(2).collect();
    format!("{} {comment}", quoted.join(" "))
}

/// Whether a text contains a phrase as whole words.
fn has_words(text: &str, phrase: &str) -> bool {
    let is_letter = |c: Option<char>| c.is_some_and(char::is_alphanumeric);
    let ends_in_letter = is_letter(phrase.chars().last());
    text.match_indices(phrase).any(|(start, _)| {
        let (before, after) =
            (text[..start].chars().next_back(), text[start + phrase.len()..].chars().next());
        !(is_letter(before) || ends_in_letter && is_letter(after))
    })
}

/// Violations by types with the name of another one in their crate.
pub fn duplicate_types(tree: &SourceTree) -> Vec<RuleViolation> {
    let mut known: BTreeMap<(String, String), String> = BTreeMap::new();
    let mut findings = Vec::new();
    for file in tree.sources().filter(|file| file.path.contains("/src/")) {
        for (number, line) in file.text.lines().enumerate() {
            let Some(name) = declared_type(line) else { continue };
            let finding =
                RuleViolation::new("type name twice in a crate", &file.path, number + 1, String::new());
            match known.get(&(finding.tree_part(), name.to_owned())) {
                Some(first) => {
                    findings.push(RuleViolation { message: format!("{name} is also in {first}"), ..finding });
                }
                None => drop(known.insert((finding.tree_part(), name.to_owned()), file.path.clone())),
            }
        }
    }
    findings
}

/// Name of the type that a line declares. Types within functions and implementations are left out.
fn declared_type(line: &str) -> Option<&str> {
    if line.starts_with(' ') {
        return None;
    }
    let line = line.strip_prefix("pub").map_or(line, |rest| {
        rest.strip_prefix("(super)").or_else(|| rest.strip_prefix("(crate)")).unwrap_or(rest).trim_start()
    });
    let rest =
        ["struct ", "enum ", "trait ", "type "].iter().find_map(|keyword| line.strip_prefix(keyword))?;
    rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().filter(|name| !name.is_empty())
}

/// Violations by files and folders at the root of a crate whose name is no term of the glossary.
pub fn files(tree: &SourceTree) -> Vec<RuleViolation> {
    let glossary = terms(tree.get("docs/glossary.md").map_or("", |page| &page.text));
    let mut roots: Vec<(String, String)> = tree.sources().filter_map(root_name).collect();
    roots.sort();
    roots.dedup_by(|a, b| a.0 == b.0);
    let is_known = |name: &str| PROGRAM_TERMS.contains(&name) || is_term(&glossary, name);
    let name = |path: &str| path.rsplit('/').next().unwrap_or_default().to_owned();
    let unknown = roots.into_iter().filter(|(path, _)| !is_known(&name(path)));
    unknown
        .map(|(path, file)| {
            let message = format!("{} is no term of docs/glossary.md", name(&path));
            RuleViolation::new("file without a term", &file, 0, message)
        })
        .collect()
}

/// First cells of the rows of the glossary.
fn terms(page: &str) -> String {
    let cells = page.lines().filter_map(|line| line.strip_prefix('|')?.split('|').next());
    cells.collect::<Vec<_>>().join("\n").to_lowercase()
}

/// Whether all words of a name are in terms of the glossary, in the singular or the plural.
fn is_term(glossary: &str, name: &str) -> bool {
    let words = name.split('_').collect::<Vec<_>>();
    words.iter().all(|word| {
        let stem = word.strip_suffix('s').unwrap_or(word);
        has_words(glossary, word) || has_words(glossary, stem) || has_words(glossary, &format!("{word}s"))
    })
}

/// Path of the file or folder below `src` that contains a file, without extension, and the file.
fn root_name(file: &SourceFile) -> Option<(String, String)> {
    let (crate_path, below) = file.path.split_once("/src/")?;
    let first = below.split('/').next()?.trim_end_matches(".rs");
    Some((format!("{crate_path}/src/{first}"), file.path.clone()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn messages(findings: Vec<RuleViolation>) -> Vec<(String, usize)> {
        findings.into_iter().map(|finding| (finding.file, finding.line)).collect()
    }

    #[test]
    fn only_the_first_line_of_a_doc_comment_counts() {
        let text =
            "/// Mass of a point (kg).\n/// What follows.\nlet a = 1;\n/// What a point gets.\n//! The same.";
        let found = messages(openings(&SourceTree::from_files(&[("crates/a/src/lib.rs", text)])));
        assert_eq!(found, [("crates/a/src/lib.rs".to_owned(), 4)]);
    }

    #[test]
    fn phrases_are_found_in_comments_and_messages_and_not_in_code() {
        let text = "let sees = 1;\n// the wall sees a point\nf(\"the wall bears it\");\n/// forbears\n";
        let found = messages(phrases(&SourceTree::from_files(&[
            ("crates/a/src/lib.rs", text),
            ("docs/a.md", "This is what is meant."),
        ])));
        let lines: Vec<usize> = found.iter().map(|(_, line)| *line).collect();
        assert_eq!(lines, [2, 3, 1]);
    }

    #[test]
    fn a_type_name_is_found_where_it_is_declared_again_in_its_crate() {
        let tree = SourceTree::from_files(&[
            ("crates/a/src/lib.rs", "pub struct Side;\nimpl A for B {\n    type Side = u8;\n}\n"),
            ("crates/a/src/b.rs", "pub(crate) enum Side {}\n"),
            ("crates/b/src/lib.rs", "pub struct Side<const D: usize>;\n"),
        ]);
        assert_eq!(messages(duplicate_types(&tree)), [("crates/a/src/b.rs".to_owned(), 1)]);
    }

    #[test]
    fn files_at_the_root_of_a_crate_are_terms() {
        let tree = SourceTree::from_files(&[
            ("crates/a/src/solver.rs", ""),
            ("crates/a/src/contact_forces.rs", ""),
            ("crates/a/src/rocks/mod.rs", ""),
            ("docs/glossary.md", "On rocks.\n| contact force | f | N | Force of a rock. |"),
        ]);
        assert_eq!(messages(files(&tree)), [("crates/a/src/rocks/mod.rs".to_owned(), 0)]);
    }
}
