//! Comparison of the committed schema and case reference with the code.

use std::path::PathBuf;

/// Compares `docs/<name>` with the generated text. With `COLLUVIUM_WRITE_DOCS` set, writes it first.
fn assert_up_to_date(name: &str, made: &str) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(name);
    if std::env::var_os("COLLUVIUM_WRITE_DOCS").is_some() {
        std::fs::write(&path, made).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        committed == made,
        "docs/{name} is out of date; make it anew: COLLUVIUM_WRITE_DOCS=1 cargo test -p colluvium --test suite reference"
    );
}

#[test]
fn committed_schema_is_that_of_the_code() {
    let schema = serde_json::to_string_pretty(&colluvium::case_schema()).unwrap();
    assert_up_to_date("case.schema.json", &(schema + "\n"));
}

#[test]
fn committed_case_reference_is_that_of_the_code() {
    assert_up_to_date("case-file.md", &colluvium::case_reference());
}

#[test]
fn committed_list_of_models_is_that_of_the_code() {
    let made = colluvium::models_reference();
    for (name, _) in colluvium::constitutive::MaterialSpec::MODELS {
        let section = made.split(&format!("## {name}\n\n")).nth(1).unwrap_or_default();
        assert!(section.starts_with("| key | type |"), "{name} has no parameters");
    }
    assert_up_to_date("models.md", &made);
}
