//! Overlong files and functions.

use syn::spanned::Spanned;
use syn::visit::Visit;

use crate::tidy::RuleViolation;
use crate::tidy::source_tree::SourceTree;

/// Largest number of lines of a module.
const MAX_FILE_LINES: usize = 500;

/// Largest number of lines of a function, from its signature to its closing brace.
const MAX_FUNCTION_LINES: usize = 60;

/// Files of more than 500 lines.
pub fn long_files(tree: &SourceTree) -> Vec<RuleViolation> {
    let long = |lines: usize| format!("has {lines} lines, {MAX_FILE_LINES} are allowed: split it by concept");
    tree.sources()
        .map(|file| (file, file.text.lines().count()))
        .filter(|(_, lines)| *lines > MAX_FILE_LINES)
        .map(|(file, lines)| RuleViolation::new("file of more than 500 lines", &file.path, 0, long(lines)))
        .collect()
}

/// Functions of more than 60 lines, tests included.
///
/// # Errors
///
/// A source that is not Rust.
pub fn long_functions(tree: &SourceTree) -> Result<Vec<RuleViolation>, String> {
    let mut findings = Vec::new();
    for file in tree.sources() {
        let syntax = syn::parse_file(&file.text).map_err(|error| format!("{}: {error}", file.path))?;
        let mut visitor = FunctionVisitor { file: &file.path, findings: &mut findings };
        visitor.visit_file(&syntax);
    }
    Ok(findings)
}

/// Visitor of the functions of a file.
struct FunctionVisitor<'a> {
    file: &'a str,
    findings: &'a mut Vec<RuleViolation>,
}

impl FunctionVisitor<'_> {
    /// Reports a function of too many lines.
    fn check(&mut self, signature: &syn::Signature, block: &syn::Block) {
        let first = signature.span().start().line;
        let lines = block.span().end().line + 1 - first;
        if lines > MAX_FUNCTION_LINES {
            let message =
                format!("`{}` has {lines} lines, {MAX_FUNCTION_LINES} are allowed", signature.ident);
            self.findings.push(RuleViolation::new(
                "function of more than 60 lines",
                self.file,
                first,
                message,
            ));
        }
    }
}

impl<'ast> Visit<'ast> for FunctionVisitor<'_> {
    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        self.check(&function.sig, &function.block);
        syn::visit::visit_item_fn(self, function);
    }

    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        self.check(&function.sig, &function.block);
        syn::visit::visit_impl_item_fn(self, function);
    }

    fn visit_trait_item_fn(&mut self, function: &'ast syn::TraitItemFn) {
        if let Some(block) = &function.default {
            self.check(&function.sig, block);
        }
        syn::visit::visit_trait_item_fn(self, function);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_function_is_as_long_as_its_lines() {
        let body = "    let _ = 1;\n".repeat(59);
        let long = format!("/// Documented.\nfn long() {{\n{body}}}\n");
        let short = format!("struct S;\nimpl S {{\nfn short() {{\n{}}}\n}}\n", "    let _ = 1;\n".repeat(58));
        let tree =
            SourceTree::from_files(&[("crates/a/src/long.rs", &long), ("crates/a/src/short.rs", &short)]);
        let found = long_functions(&tree).unwrap();
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!((found[0].file.as_str(), found[0].line), ("crates/a/src/long.rs", 2));
    }

    #[test]
    fn a_file_may_have_five_hundred_lines() {
        let tree = SourceTree::from_files(&[
            ("crates/a/src/x.rs", &"\n".repeat(500)),
            ("crates/a/src/y.rs", &"\n".repeat(501)),
        ]);
        let found: Vec<_> = long_files(&tree).into_iter().map(|finding| finding.file).collect();
        assert_eq!(found, ["crates/a/src/y.rs"]);
    }
}
