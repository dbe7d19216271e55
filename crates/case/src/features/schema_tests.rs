//! Names of all features that the JSON Schema of a case allows, and the list of features made from them.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;

use crate::Feature;
use crate::features::schema::{
    OPAQUE_KEY, SCHEMA, alternatives, is_looked_at, is_required, names_of, resolved, variant_of,
};

/// Head of the list of features.
const HEAD: &str = "\
//! List of the features of a case, in the order of their names.
//!
//! Made from the JSON Schema: `COLLUVIUM_WRITE_DOCS=1 cargo test -p colluvium-case list_of_features`.

use crate::feature_list::feature_enum;

feature_enum! {
";

/// Names of all features that a case can have, and of the required keys above them. Shapes within shapes count once.
fn schema_names() -> BTreeSet<String> {
    // A law of the program has no name in the schema.
    let mut names = BTreeSet::from([format!("{OPAQUE_KEY}=other")]);
    walk_schema(&SCHEMA, "", &mut Vec::new(), &mut names);
    let required: Vec<String> = names.iter().flat_map(|name| names_above(name)).map(str::to_owned).collect();
    names.extend(required);
    names
}

/// Names of the keys above a feature: `bodies.shape` and `bodies` of `bodies.shape=ball`.
fn names_above(name: &str) -> impl Iterator<Item = &str> {
    std::iter::successors(Some(name), |name| name.rfind(['.', '=']).map(|end| &name[..end])).skip(1)
}

/// Variant of [`Feature`] with a name: `SpaceThreeD` of `space=3d`. The word `Key` distinguishes a key from a variant of that name beside it:
/// `LoadsPressureKey` of `loads.pressure` from `LoadsPressure` of `loads=pressure`.
fn variant_name(name: &str, names: &BTreeSet<String>) -> String {
    let words = name.split(|c: char| !c.is_alphanumeric());
    let word = |word: &str| match word {
        "1d" => "OneD".to_owned(),
        "3d" => "ThreeD".to_owned(),
        _ => word[..1].to_uppercase() + &word[1..],
    };
    let beside = name.rsplit_once('.').map(|(above, key)| format!("{above}={key}"));
    let is_variant = beside.is_some_and(|variant| names.contains(&variant));
    words.map(word).chain(is_variant.then(|| "Key".to_owned())).collect()
}

/// Source of the list of features, in lines of at most 110 characters.
fn list_of_features() -> String {
    let mut text = HEAD.to_owned();
    let mut line = String::new();
    let names = schema_names();
    for name in &names {
        let entry = format!(" {} = {name:?},", variant_name(name, &names));
        if line.len() + entry.len() > 107 {
            writeln!(text, "   {line}").unwrap();
            line.clear();
        }
        line += &entry;
    }
    writeln!(text, "   {line}\n}}").unwrap();
    text
}

/// Adds the names of all features that a schema allows.
fn walk_schema<'a>(schema: &'a Value, place: &str, above: &mut Vec<&'a str>, names: &mut BTreeSet<String>) {
    let name = schema["$ref"].as_str();
    let within = if name.is_some() { resolved(schema) } else { schema };
    if name.is_some_and(|name| above.contains(&name)) {
        // The kinds of a shape within a shape, once.
        let kinds = alternatives(within).iter().filter_map(variant_of);
        return names.extend(kinds.map(|kind| format!("{place}={kind}")));
    }
    above.extend(name);
    for alternative in alternatives(within) {
        match variant_of(alternative) {
            Some(variant) => {
                names.insert(format!("{place}={variant}"));
                if place != OPAQUE_KEY {
                    walk_properties(alternative, place, above, names);
                }
            }
            None => walk_schema(alternative, place, above, names),
        }
    }
    names.extend(names_of(within).map(|variant| format!("{place}={variant}")));
    walk_properties(within, place, above, names);
    for inner in ["items", "additionalProperties"] {
        if within[inner].is_object() {
            walk_schema(&within[inner], place, above, names);
        }
    }
    if name.is_some() {
        above.pop();
    }
}

/// Adds the names of all features that the properties of an object schema allow.
fn walk_properties<'a>(
    schema: &'a Value,
    place: &str,
    above: &mut Vec<&'a str>,
    names: &mut BTreeSet<String>,
) {
    for (key, property) in schema["properties"].as_object().into_iter().flatten() {
        if is_looked_at(place, key) {
            let here = if place.is_empty() { key.clone() } else { format!("{place}.{key}") };
            if !is_required(schema, key) {
                names.insert(here.clone());
            }
            walk_schema(property, &here, above, names);
        }
    }
}

#[test]
fn committed_list_of_features_is_that_of_the_schema() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/feature_list/names.rs");
    if std::env::var_os("COLLUVIUM_WRITE_DOCS").is_some() {
        std::fs::write(&path, list_of_features()).unwrap();
    }
    assert!(
        std::fs::read_to_string(&path).unwrap() == list_of_features(),
        "the list of features is out of date; make it anew: COLLUVIUM_WRITE_DOCS=1 cargo test -p colluvium-case list_of_features"
    );
}

#[test]
fn features_are_the_names_of_the_schema_in_their_order() {
    let names: Vec<String> = schema_names().into_iter().collect();
    assert!(names.len() > 500, "{}", names.len());
    let listed: Vec<&str> = Feature::ALL.iter().map(|feature| feature.name()).collect();
    assert_eq!(listed, names);
    assert!(Feature::ALL.iter().all(|feature| Feature::named(feature.name()) == Some(*feature)));
}
