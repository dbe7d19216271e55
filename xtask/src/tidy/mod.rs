//! What a machine can check of the house rules: lengths of files and functions, which crate may know which, circles between
//! modules, where modules are, words of comments and names, cases written in code, links of the documentation, and citations of the specification
//! sheets.
//!
//! A rule that the tree breaks today has a ratchet (`xtask/tidy-ratchet.json`): so many findings per crate are known, more are not
//! allowed, and `--lower` writes down the new number once there are fewer.

mod baseline;
mod lint_citations;
mod lint_crate_graph;
mod lint_inline_cases;
mod lint_lengths;
mod lint_links;
mod lint_module_cycles;
mod lint_module_files;
mod sheet_index;
mod source_tree;
mod words;

use std::path::Path;

use crate::tidy::baseline::Baseline;
use crate::tidy::source_tree::SourceTree;

/// Options of `tidy`.
#[derive(clap::Args)]
pub struct TidyArguments {
    /// Writes down the lower counts where rules are broken less often than the ratchet knows.
    #[arg(long)]
    lower: bool,
    /// Shows the known findings too.
    #[arg(long)]
    all: bool,
}

/// A place where a rule is broken.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct RuleViolation {
    /// The rule, as the ratchet names it.
    rule: &'static str,
    /// The file from the root of the repository, with `/`.
    file: String,
    /// The line, from one; zero where the finding is about the whole file.
    line: usize,
    /// What is wrong, and what would be right.
    message: String,
}

impl RuleViolation {
    fn new(rule: &'static str, file: &str, line: usize, message: String) -> Self {
        Self { rule, file: file.to_owned(), line, message }
    }

    /// The part of the tree that the ratchet counts in: `crates/<name>`, or the first folder.
    fn part(&self) -> String {
        let mut folders = self.file.split('/');
        match (folders.next(), folders.next()) {
            (Some("crates"), Some(name)) => format!("crates/{name}"),
            (Some(first), Some(_)) => first.to_owned(),
            _ => "root".to_owned(),
        }
    }
}

/// Checks the tree. Returns whether nothing is worse than the ratchet knows.
///
/// # Errors
///
/// What of the tree cannot be read, as text.
pub fn run(arguments: &TidyArguments) -> Result<bool, String> {
    let root = crate::root();
    let findings = all_violations(root)?;
    let path = root.join("xtask/tidy-ratchet.json");
    let mut ratchet = Baseline::read(&path)?;
    let verdict = ratchet.compare(&findings);
    for finding in &findings {
        if arguments.all || verdict.is_new(finding) {
            println!("{}:{}: {} ({})", finding.file, finding.line, finding.message, finding.rule);
        }
    }
    verdict.print();
    if arguments.lower {
        ratchet.lower(&findings);
        ratchet.write(&path)?;
        println!("wrote xtask/tidy-ratchet.json");
    }
    Ok(verdict.passes())
}

/// All findings, in the order of rule, file and line.
fn all_violations(root: &Path) -> Result<Vec<RuleViolation>, String> {
    let tree = SourceTree::read(root)?;
    let sheets = sheet_index::SheetIndex::of(&tree);
    let mut findings = lint_lengths::long_files(&tree);
    findings.extend(lint_lengths::long_functions(&tree)?);
    findings.extend(lint_module_cycles::module_cycles(&tree)?);
    findings.extend(lint_module_files::module_files(&tree));
    findings.extend(lint_inline_cases::inline_cases(&tree));
    findings.extend(words::openings(&tree));
    findings.extend(words::phrases(&tree));
    findings.extend(words::twins(&tree));
    findings.extend(words::files(&tree));
    findings.extend(lint_links::broken_links(&tree));
    findings.extend(lint_links::pages_without_entry(&tree));
    findings.extend(lint_citations::citations(&tree, &sheets));
    findings.extend(lint_crate_graph::crate_graph(root)?);
    findings.extend(lint_crate_graph::unneeded_dependencies(root)?);
    findings.sort();
    Ok(findings)
}
