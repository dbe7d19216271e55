//! Links of the documentation to existing targets, and entries of all pages in the table of contents.

use crate::tidy::RuleViolation;
use crate::tidy::source_tree::{SourceFile, SourceTree};

/// Violations by links to missing files, and to headings that their page does not have.
pub fn broken_links(tree: &SourceTree) -> Vec<RuleViolation> {
    let mut findings = Vec::new();
    // Texts in sources are parts of pages in another folder.
    for page in tree.pages().filter(|page| !page.path.contains("/src/")) {
        for (number, line) in page.text.lines().enumerate() {
            for target in
                targets(line).filter(|target| !target.contains("://") && !target.starts_with("mailto:"))
            {
                let (file, heading) = target.split_once('#').unwrap_or((target, ""));
                let path = if file.is_empty() { page.path.clone() } else { relative_path(&page.path, file) };
                if !target_exists(tree, &path, heading) {
                    let message = format!("the target of the link {target} does not exist");
                    findings.push(RuleViolation::new("dead link", &page.path, number + 1, message));
                }
            }
        }
    }
    findings
}

/// Pages under `docs/` that `docs/SUMMARY.md` does not list.
pub fn pages_without_entry(tree: &SourceTree) -> Vec<RuleViolation> {
    let listed: Vec<String> = tree
        .get("docs/SUMMARY.md")
        .map(|summary| targets(&summary.text).map(|target| relative_path(&summary.path, target)).collect())
        .unwrap_or_default();
    let pages = tree.pages().filter(|page| page.path.starts_with("docs/") && page.path != "docs/SUMMARY.md");
    pages
        .filter(|page| !listed.contains(&page.path))
        .map(|page| {
            RuleViolation::new("page without entry", &page.path, 0, "is not in docs/SUMMARY.md".to_owned())
        })
        .collect()
}

/// Link targets of `[text](target)`.
fn targets(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target)
}

/// Path of `file` relative to the folder of `page`.
fn relative_path(page: &str, file: &str) -> String {
    let mut parts: Vec<&str> = page.split('/').collect();
    parts.pop();
    for part in file.split('/') {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop();
            }
            name => parts.push(name),
        }
    }
    parts.join("/")
}

/// Whether the target of a link exists.
fn target_exists(tree: &SourceTree, path: &str, heading: &str) -> bool {
    match tree.get(path) {
        Some(page) => heading.is_empty() || has_heading(page, heading),
        // A folder, or a file that is not text.
        None => heading.is_empty() && crate::root().join(path).exists(),
    }
}

/// Anchor of a heading: lower case, dashes for spaces, no other punctuation.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().chars().filter(|c| c.is_alphanumeric() || "-_ ".contains(*c));
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}

/// Whether a page has a heading.
fn has_heading(page: &SourceFile, wanted: &str) -> bool {
    let mut headings = page.text.lines().filter(|line| line.starts_with('#'));
    headings.any(|line| anchor(line.trim_start_matches('#')) == wanted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dead_links_and_missing_headings_are_found() {
        let tree = SourceTree::from_files(&[
            ("README.md", "[a](docs/a.md) [none](docs/none.md) [far](https://example.org)"),
            (
                "docs/a.md",
                "# One thing, and more\n[b](sub/b.md#there) [b](sub/b.md#not-there) [self](#one-thing-and-more)",
            ),
            ("docs/sub/b.md", "## There\n[up](../a.md)"),
        ]);
        let found: Vec<_> =
            broken_links(&tree).into_iter().map(|finding| (finding.line, finding.message)).collect();
        let expected = [
            (1, "the target of the link docs/none.md does not exist"),
            (2, "the target of the link sub/b.md#not-there does not exist"),
        ];
        assert_eq!(found, expected.map(|(line, text)| (line, text.to_owned())));
    }

    #[test]
    fn pages_that_the_summary_does_not_list_are_found() {
        let tree = SourceTree::from_files(&[
            ("docs/SUMMARY.md", "[a](a.md)"),
            ("docs/a.md", ""),
            ("docs/sub/b.md", ""),
        ]);
        let found: Vec<_> = pages_without_entry(&tree).into_iter().map(|finding| finding.file).collect();
        assert_eq!(found, ["docs/sub/b.md"]);
    }
}
