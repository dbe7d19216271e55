//! The codes of messages in the sources against those of `docs/messages.md`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::in_folder;

/// Calls whose first text is a code.
const CALLS: [&str; 10] = [
    "Warning::new(",
    "::coded(",
    "::coded_file(",
    "Error::message(",
    "Error::usage(",
    "Self::message(",
    "Self::usage(",
    "checkpoint_error(",
    "Err(folder(",
    "Failed { code: ",
];

/// Beginnings of functions that return codes: each text in them is one.
const FUNCTIONS: [&str; 2] = ["fn code(", "fn note_code("];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Whether a word has the form of a code.
fn is_code(word: &str) -> bool {
    let is_part = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_lowercase());
    word.split('-').all(is_part)
}

/// Sources of a folder, without tests.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        if path.is_dir() && name != "tests" {
            sources(&path, found);
        } else if name.ends_with(".rs") && name != "tests.rs" {
            found.push(path);
        }
    }
}

/// Code that begins the arguments of a call, after at most one other argument without quotation marks.
fn code_of_call(arguments: &str) -> Option<&str> {
    let (before, rest) = arguments.split_once('"')?;
    let is_short = before.len() < 80 && before.matches(',').count() <= 1 && !before.contains([';', '!', '|']);
    let word = rest.split_once('"')?.0;
    (is_short && is_code(word)).then_some(word)
}

/// Codes in a source: those of calls, and all texts of functions that return codes.
fn codes_of_source(text: &str) -> BTreeSet<String> {
    let text = text.split("#[cfg(test)]").next().unwrap();
    let mut codes = BTreeSet::new();
    for call in CALLS {
        codes.extend(text.split(call).skip(1).filter_map(code_of_call).map(str::to_owned));
    }
    for start in FUNCTIONS {
        for body in text.split(start).skip(1) {
            let body = body.split("\n    }\n").next().unwrap();
            codes.extend(body.split('"').skip(1).step_by(2).filter(|word| is_code(word)).map(str::to_owned));
        }
    }
    codes
}

/// Codes of the page with the number of their rows and sections.
fn codes_of_page() -> BTreeMap<String, usize> {
    let page = fs::read_to_string(root().join("docs/messages.md")).unwrap();
    let mut codes = BTreeMap::new();
    let mut is_listing = false;
    for line in page.lines() {
        is_listing = line.starts_with("| code ") || (is_listing && line.starts_with('|'));
        let names: Vec<&str> = match line.strip_prefix("### ") {
            Some(name) if is_code(name) => vec![name],
            None if is_listing => {
                let first = line.split('|').nth(1).unwrap();
                first.split('`').skip(1).step_by(2).collect()
            }
            _ => Vec::new(),
        };
        for name in names {
            *codes.entry(name.to_owned()).or_insert(0) += 1;
        }
    }
    codes
}

#[test]
fn each_code_of_the_sources_is_on_the_page_once_and_each_code_of_the_page_is_in_the_sources() {
    let mut files = Vec::new();
    for entry in fs::read_dir(root().join("crates")).unwrap() {
        sources(&entry.unwrap().path().join("src"), &mut files);
    }
    let of_sources: BTreeSet<String> =
        files.iter().flat_map(|file| codes_of_source(&fs::read_to_string(file).unwrap())).collect();
    let of_page = codes_of_page();
    let missing: Vec<_> = of_sources.iter().filter(|code| !of_page.contains_key(*code)).collect();
    let unused: Vec<_> = of_page.keys().filter(|code| !of_sources.contains(*code)).collect();
    let repeated: Vec<_> = of_page.iter().filter(|(_, count)| **count > 1).collect();
    assert!(missing.is_empty(), "codes without a row in docs/messages.md: {missing:?}");
    assert!(unused.is_empty(), "rows of docs/messages.md without a message: {unused:?}");
    assert!(repeated.is_empty(), "codes with several rows in docs/messages.md: {repeated:?}");
    assert!(of_page.len() > 200, "{}", of_page.len());
}

#[test]
fn the_program_has_the_page_of_the_codes() {
    let page = fs::read_to_string(root().join("docs/messages.md")).unwrap();
    let copy = root().join("crates/colluvium/src/cli/messages.txt");
    if std::env::var_os("COLLUVIUM_WRITE_DOCS").is_some() {
        fs::write(&copy, &page).unwrap();
    }
    let again = "run the test with COLLUVIUM_WRITE_DOCS=1";
    assert!(fs::read_to_string(&copy).unwrap() == page, "{}: {again}", copy.display());
}

#[test]
fn explain_prints_sections_and_rows() {
    let folder = tempfile::tempdir().unwrap();
    let (code, text, _) = in_folder(folder.path(), &["explain", "unknown-key"]);
    assert!(code == 0 && text.contains("permitted keys") && !text.contains("]("), "{text}");
    let (code, text, _) = in_folder(folder.path(), &["explain", "unused-material"]);
    assert_eq!(
        (code, text.as_str()),
        (0, "unused-material\n\nmeaning: no body has the material\nlook at: names\nchange: remove it\n")
    );
    let (code, _, errors) = in_folder(folder.path(), &["explain", "no-such-code"]);
    assert!(code == 2 && errors.starts_with("error[wrong-usage]: \"no-such-code\""), "{errors}");
}

#[test]
fn codes_are_found_in_calls_and_functions() {
    let text = r#"
        warnings.push(Warning::new(
            "thin-body", format!("bodies[{number}]")));
        OutputError::coded(&path, "table-changed", "was changed");
        CaseErrorKind::coded(error.code(), format!("no-code"));
    fn code(&self) -> &'static str {
        match self { Self::A => "first-code", Self::B => "second" }
    }
    fn other() { "no-code" }
    "#;
    let codes: Vec<String> = codes_of_source(text).into_iter().collect();
    assert_eq!(codes, ["first-code", "second", "table-changed", "thin-body"]);
    assert!(
        is_code("not-supported") && !is_code("not_supported") && !is_code("Not-supported") && !is_code("")
    );
}
