//! Cycles between the modules of a crate: modules at its root that depend on each other, directly or through others.

use std::collections::{BTreeMap, BTreeSet};

use syn::visit::Visit;

use crate::tidy::RuleViolation;
use crate::tidy::source_tree::{SourceFile, SourceTree};

/// Modules at the root of a crate to which each module at the root refers.
type ModuleGraph = BTreeMap<String, BTreeSet<String>>;

/// Violations by modules that are part of a cycle.
///
/// # Errors
///
/// A source that is not Rust.
pub fn module_cycles(tree: &SourceTree) -> Result<Vec<RuleViolation>, String> {
    let mut crates: BTreeMap<&str, Vec<&SourceFile>> = BTreeMap::new();
    for file in tree.sources() {
        if let Some((krate, _)) = file.path.split_once("/src/") {
            crates.entry(krate).or_default().push(file);
        }
    }
    let mut findings = Vec::new();
    for (krate, files) in crates {
        let graph = graph(krate, &files)?;
        for module in graph.keys() {
            let circle = cycle(&graph, module);
            if circle.len() > 1 {
                let others: Vec<_> = circle.into_iter().filter(|other| other != module).collect();
                let message = format!("module {module} is in a dependency cycle with {}", others.join(", "));
                findings.push(RuleViolation::new(
                    "module in a circle",
                    &file_of(krate, module, &files),
                    0,
                    message,
                ));
            }
        }
    }
    Ok(findings)
}

/// Path of the file of a module at the root of a crate.
fn file_of(krate: &str, module: &str, files: &[&SourceFile]) -> String {
    let folder = format!("{krate}/src/{module}/mod.rs");
    if files.iter().any(|file| file.path == folder) { folder } else { format!("{krate}/src/{module}.rs") }
}

/// Modules that `module` depends on and that depend on it, including itself.
fn cycle(graph: &ModuleGraph, module: &str) -> Vec<String> {
    let needed = reachable_modules(graph, module);
    needed.iter().filter(|other| reachable_modules(graph, other).contains(module)).cloned().collect()
}

/// Modules that a module depends on, directly or through others.
fn reachable_modules(graph: &ModuleGraph, from: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut open = vec![from];
    while let Some(module) = open.pop() {
        for next in graph.get(module).into_iter().flatten() {
            if found.insert(next.clone()) {
                open.push(next);
            }
        }
    }
    found
}

/// Dependencies between the modules at the root of a crate.
fn graph(krate: &str, files: &[&SourceFile]) -> Result<ModuleGraph, String> {
    let prefix = format!("{krate}/src/");
    let inside = |file: &SourceFile| file.path[prefix.len()..].trim_end_matches(".rs").to_owned();
    let roots = ["lib", "main"];
    let is_module = |stem: &str| !roots.contains(&stem) && !stem.starts_with("bin/");
    let modules: BTreeSet<String> = files
        .iter()
        .map(|file| inside(file))
        .filter(|stem| is_module(stem))
        .map(|stem| stem.split('/').next().unwrap_or_default().to_owned())
        .collect();
    let mut exports = BTreeMap::new();
    for file in files.iter().filter(|file| roots.contains(&inside(file).as_str())) {
        exports.extend(root_exports(&parse(file)?, &modules));
    }
    let mut graph = ModuleGraph::new();
    for file in files {
        let stem = inside(file);
        if !is_module(&stem) || is_test_file(&stem) {
            continue;
        }
        let path: Vec<String> = stem.trim_end_matches("/mod").split('/').map(str::to_owned).collect();
        let mut names = ModuleReferences {
            path: path.clone(),
            modules: &modules,
            exports: &exports,
            found: BTreeSet::new(),
        };
        names.visit_file(&parse(file)?);
        names.found.remove(&path[0]);
        graph.entry(path[0].clone()).or_default().extend(names.found);
    }
    Ok(graph)
}

/// Parses a source file.
/// Whether a file by its path holds tests only: `tests.rs`, `…_tests.rs`, and files of a folder `tests`.
fn is_test_file(stem: &str) -> bool {
    stem.split('/').any(|part| part == "tests" || part.ends_with("_tests"))
}

fn parse(file: &SourceFile) -> Result<syn::File, String> {
    syn::parse_file(&file.text).map_err(|error| format!("{}: {error}", file.path))
}

/// Modules at the root that define the names that the root re-exports.
fn root_exports(root: &syn::File, modules: &BTreeSet<String>) -> BTreeMap<String, String> {
    let mut exports = BTreeMap::new();
    for item in &root.items {
        if let syn::Item::Use(item) = item {
            let mut paths = Vec::new();
            flatten(&item.tree, &mut Vec::new(), &mut paths);
            for path in paths {
                let path: Vec<_> =
                    path.into_iter().skip_while(|name| name == "crate" || name == "self").collect();
                if let (Some(first), Some(last)) = (path.first(), path.last())
                    && modules.contains(first)
                    && path.len() > 1
                {
                    exports.insert(last.clone(), first.clone());
                }
            }
        }
    }
    exports
}

/// Collects the paths of a use declaration. A renamed one ends with its new name.
fn flatten(tree: &syn::UseTree, above: &mut Vec<String>, paths: &mut Vec<Vec<String>>) {
    let with = |name: String| above.iter().cloned().chain([name]).collect();
    match tree {
        syn::UseTree::Path(path) => {
            above.push(path.ident.to_string());
            flatten(&path.tree, above, paths);
            above.pop();
        }
        syn::UseTree::Name(name) => paths.push(with(name.ident.to_string())),
        syn::UseTree::Rename(rename) => paths.push(with(rename.ident.to_string())),
        syn::UseTree::Glob(_) => paths.push(above.clone()),
        syn::UseTree::Group(group) => group.items.iter().for_each(|item| flatten(item, above, paths)),
    }
}

/// Modules at the root to which a file refers by `crate::…` or `super::…`. Tests may refer to all.
struct ModuleReferences<'a> {
    path: Vec<String>,
    modules: &'a BTreeSet<String>,
    exports: &'a BTreeMap<String, String>,
    found: BTreeSet<String>,
}

impl ModuleReferences<'_> {
    /// Adds the module to which a path refers.
    fn name(&mut self, path: &[String]) {
        let first = match path.first().map(String::as_str) {
            Some("crate") => path.get(1),
            Some("super") => {
                let up = path.iter().take_while(|name| *name == "super").count();
                if up < self.path.len() {
                    return;
                }
                path.get(up)
            }
            _ => return,
        };
        let Some(first) = first else { return };
        if self.modules.contains(first) {
            self.found.insert(first.clone());
        } else if let Some(module) = self.exports.get(first) {
            self.found.insert(module.clone());
        }
    }
}

/// Whether attributes make an item part of the tests.
fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && attribute.meta.require_list().is_ok_and(|list| list.tokens.to_string().contains("test"))
    })
}

impl<'ast> Visit<'ast> for ModuleReferences<'_> {
    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        let mut paths = Vec::new();
        flatten(&item.tree, &mut Vec::new(), &mut paths);
        for path in paths {
            self.name(&path);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        self.name(&names);
        syn::visit::visit_path(self, path);
    }

    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if module.content.is_none() || is_test(&module.attrs) {
            return;
        }
        self.path.push(module.ident.to_string());
        syn::visit::visit_item_mod(self, module);
        self.path.pop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn violations(files: &[(&str, &str)]) -> Vec<String> {
        let files: Vec<_> =
            files.iter().map(|(name, text)| (format!("crates/k/src/{name}"), *text)).collect();
        let files: Vec<_> = files.iter().map(|(path, text)| (path.as_str(), *text)).collect();
        module_cycles(&SourceTree::from_files(&files))
            .unwrap()
            .into_iter()
            .map(|finding| finding.message)
            .collect()
    }

    #[test]
    fn a_chain_of_modules_is_no_cycle() {
        let files = [
            ("lib.rs", "mod a; mod b; mod c;"),
            ("a.rs", "use crate::b::B;"),
            ("b.rs", "use crate::c::C;"),
            ("c.rs", ""),
        ];
        assert_eq!(violations(&files), [""; 0]);
    }

    #[test]
    fn dependency_cycles_are_found_through_uses_paths_folders_and_re_exports() {
        let files = [
            ("lib.rs", "mod a; mod b; mod c; pub use c::Deep;"),
            ("a.rs", "fn f() -> crate::b::B { todo!() }"),
            ("b/mod.rs", "use crate::Deep;"),
            ("c/mod.rs", "mod inner;"),
            ("c/inner.rs", "use crate::a::A;"),
        ];
        assert_eq!(
            violations(&files),
            [
                "module a is in a dependency cycle with b, c",
                "module b is in a dependency cycle with a, c",
                "module c is in a dependency cycle with a, b"
            ]
        );
    }

    #[test]
    fn files_of_tests_cause_no_cycle() {
        let files = [
            ("lib.rs", "mod a; mod b;"),
            ("a/mod.rs", "#[cfg(test)] mod tests; #[cfg(test)] mod shape_tests;"),
            ("a/tests.rs", "use crate::b::B;"),
            ("a/shape_tests.rs", "use crate::b::B;"),
            ("b.rs", "use crate::a::A;"),
        ];
        assert_eq!(violations(&files), [""; 0]);
    }

    #[test]
    fn tests_and_parent_modules_cause_no_cycle() {
        let files = [
            ("lib.rs", "mod a; mod b;"),
            ("a/mod.rs", "mod part; use crate::b::B;"),
            ("a/part.rs", "use super::Whole;"),
            ("b.rs", "#[cfg(test)] mod tests { use crate::a::A; }"),
        ];
        assert_eq!(violations(&files), [""; 0]);
    }
}
