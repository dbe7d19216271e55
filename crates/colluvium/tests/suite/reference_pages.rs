//! Comparison of the committed schema and case reference with the code.

use std::path::PathBuf;

use colluvium::case::Case;
use serde_json::Value;

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
    for (file, text) in colluvium::case_reference() {
        assert_up_to_date(&format!("case/{file}"), &text);
    }
}

#[test]
fn every_model_has_its_parameters_in_the_case_reference() {
    let pages = colluvium::case_reference();
    let (_, materials) = pages.iter().find(|(file, _)| file == "materials.md").unwrap();
    for (name, _) in colluvium::constitutive::MaterialSpec::MODELS {
        let section = materials.split(&format!("## {name}\n\n")).nth(1).unwrap_or_default();
        let has_parameters = ["- `", "- **`", "- [Common]"].iter().any(|start| section.starts_with(start));
        assert!(has_parameters, "{name} has no parameters");
    }
}

/// Texts of the JSON blocks of a page.
fn json_blocks(page: &str) -> Vec<&str> {
    let blocks = page.split("```json\n").skip(1);
    blocks.map(|rest| rest.split("```").next().unwrap_or_default()).collect()
}

/// A snippet replaces the keys of the same name of a case of all sections.
#[test]
fn snippets_of_the_case_reference_are_parts_of_a_valid_case() {
    for (file, text) in colluvium::case_reference() {
        let mut case: Value = serde_json::from_str(colluvium::template("column-collapse").unwrap()).unwrap();
        case["methods"] = serde_json::json!({ "mpm": { "cell_size": 0.005 } });
        let snippet: Value = serde_json::from_str(&format!("{{{}}}", json_blocks(&text)[0]))
            .unwrap_or_else(|error| panic!("{file}: {error}"));
        for (key, value) in snippet.as_object().unwrap() {
            case[key] = value.clone();
        }
        let case = Case::from_json(&case.to_string()).unwrap_or_else(|errors| panic!("{file}: {errors}"));
        let method = colluvium::method(file.trim_end_matches(".md")).or(colluvium::method("mpm")).unwrap();
        method.plan(&case).unwrap_or_else(|error| panic!("{file}: {error}"));
    }
}

#[test]
fn the_case_of_the_page_of_cases_is_valid_for_its_methods() {
    let page =
        std::fs::read_to_string(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs/case-file.md"))
            .unwrap();
    let case = Case::from_json(json_blocks(&page)[0]).unwrap();
    for name in case.methods.keys() {
        let plan = colluvium::method(name).unwrap().plan(&case).unwrap();
        assert!(plan.points >= 400, "{name}: {} points", plan.points);
    }
}
