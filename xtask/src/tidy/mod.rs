//! Machine-checked house rules: lengths of files and functions, dependencies of crates, cycles between modules, placement of modules, words
//! of comments and names, inline cases, links of the documentation, and citations of the specification sheets.
//!
//! A rule that the tree breaks today has a baseline (`xtask/tidy-ratchet.json`): the known number of violations per crate. More are not
//! allowed; `--lower` writes the new number once there are fewer.

mod baseline;
mod lint_citations;
mod lint_crate_graph;
mod lint_inline_cases;
mod lint_lengths;
mod lint_module_cycles;
mod lint_module_files;
mod pages;
mod sheet_index;
mod source_tree;
mod words;

use std::path::Path;

use crate::tidy::baseline::Baseline;
use crate::tidy::source_tree::SourceTree;

/// Options of `tidy`.
#[derive(clap::Args)]
pub struct TidyArguments {
    /// Record lower counts in the baseline where there are fewer violations than it has.
    #[arg(long)]
    lower: bool,
    /// Show also the known findings.
    #[arg(long)]
    all: bool,
}

/// Violation of a rule.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct RuleViolation {
    /// Name of the rule, as in the baseline.
    rule_name: &'static str,
    /// Path of the file from the root of the repository, with `/`.
    file: String,
    /// Line number, from one; zero where the violation concerns the whole file.
    line: usize,
    /// Description of the violation and its remedy.
    message: String,
}

impl RuleViolation {
    fn new(rule_name: &'static str, file: &str, line: usize, message: String) -> Self {
        Self { rule_name, file: file.to_owned(), line, message }
    }

    /// Part of the tree in which the baseline counts violations: `crates/<name>`, or the first folder.
    fn tree_part(&self) -> String {
        let mut folders = self.file.split('/');
        match (folders.next(), folders.next()) {
            (Some("crates"), Some(name)) => format!("crates/{name}"),
            (Some(first), Some(_)) => first.to_owned(),
            _ => "root".to_owned(),
        }
    }
}

/// Checks all rules on the tree, and returns whether it passes. Returns whether no count is above the baseline.
///
/// # Errors
///
/// The file that cannot be read, as text.
pub fn run(arguments: &TidyArguments) -> Result<bool, String> {
    let root = crate::root();
    let findings = all_violations(root)?;
    let path = root.join("xtask/tidy-ratchet.json");
    let mut ratchet = Baseline::read(&path)?;
    let verdict = ratchet.compare(&findings);
    for finding in &findings {
        if arguments.all || verdict.is_new(finding) {
            println!("{}:{}: {} ({})", finding.file, finding.line, finding.message, finding.rule_name);
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

/// All violations, in the order of rule, file and line.
fn all_violations(root: &Path) -> Result<Vec<RuleViolation>, String> {
    let tree = SourceTree::read(root)?;
    let sheets = sheet_index::SheetIndex::from_tree(&tree);
    let mut findings = lint_lengths::long_files(&tree);
    findings.extend(lint_lengths::long_functions(&tree)?);
    findings.extend(lint_module_cycles::module_cycles(&tree)?);
    findings.extend(lint_module_files::module_files(&tree));
    findings.extend(lint_inline_cases::inline_cases(&tree));
    findings.extend(words::openings(&tree));
    findings.extend(words::phrases(&tree));
    findings.extend(words::duplicate_types(&tree));
    findings.extend(words::files(&tree));
    findings.extend(pages::links::broken_links(&tree));
    findings.extend(pages::links::pages_without_entry(&tree));
    findings.extend(pages::sentences::long_sentences(&tree));
    findings.extend(lint_citations::citations(&tree, &sheets));
    findings.extend(lint_crate_graph::crate_graph(root)?);
    findings.extend(lint_crate_graph::unneeded_dependencies(root)?);
    findings.sort();
    Ok(findings)
}
