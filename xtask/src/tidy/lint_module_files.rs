//! Placement of modules: a module with files of its own is in its folder, `name/mod.rs`, not `name.rs` beside `name/`.

use crate::tidy::RuleViolation;
use crate::tidy::source_tree::SourceTree;

/// Violations by modules whose file is beside their folder.
pub fn module_files(tree: &SourceTree) -> Vec<RuleViolation> {
    let beside = |path: &str| path.strip_suffix(".rs").is_some_and(|stem| has_modules(tree, stem));
    tree.sources()
        .filter(|file| file.path.contains("/src/") && beside(&file.path))
        .map(|file| {
            let stem = file.path.trim_end_matches(".rs");
            RuleViolation::new("module beside its folder", &file.path, 0, format!("belongs in {stem}/mod.rs"))
        })
        .collect()
}

/// Whether a folder has modules.
fn has_modules(tree: &SourceTree, folder: &str) -> bool {
    let folder = format!("{folder}/");
    tree.sources().any(|file| file.path.starts_with(&folder))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_module_beside_a_folder_of_modules_is_found() {
        let tree = SourceTree::from_files(&[
            ("crates/a/src/lib.rs", ""),
            ("crates/a/src/good/mod.rs", ""),
            ("crates/a/src/good/part.rs", ""),
            ("crates/a/src/bad.rs", ""),
            ("crates/a/src/bad/part.rs", ""),
            ("crates/a/src/bad_too.rs", ""),
        ]);
        let found: Vec<_> = module_files(&tree).into_iter().map(|finding| finding.file).collect();
        assert_eq!(found, ["crates/a/src/bad.rs"]);
    }
}
