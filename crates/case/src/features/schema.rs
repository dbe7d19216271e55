//! JSON Schema of a case, and the parts of it that give the names of features.

use std::sync::LazyLock;

use serde_json::Value;

use crate::Case;

/// Keys that no method needs to support: descriptions of the case, and options of methods, which the methods check themselves.
const METHOD_INDEPENDENT_KEYS: [&str; 4] = ["$schema", "title", "notes", "methods"];

/// Keys whose values name the variant of an object.
pub(super) const TAGS: [&str; 2] = ["kind", "model"];

/// Key of the materials: the material law is the feature, and checks its parameters itself.
pub(super) const OPAQUE_KEY: &str = "materials";

/// JSON Schema of a case file.
pub(super) static SCHEMA: LazyLock<Value> = LazyLock::new(|| schemars::schema_for!(Case).to_value());

/// Schema to which `schema` refers, or `schema` itself.
pub(super) fn resolved(schema: &Value) -> &Value {
    match schema["$ref"].as_str().and_then(|to| to.strip_prefix("#/$defs/")) {
        Some(name) => &SCHEMA["$defs"][name],
        None => schema,
    }
}

/// Alternatives (`oneOf` or `anyOf`) of a JSON schema.
pub(super) fn alternatives(schema: &Value) -> &[Value] {
    let list = ["oneOf", "anyOf"].iter().find_map(|key| schema[*key].as_array());
    list.map_or(&[], Vec::as_slice)
}

/// Name of one of the alternatives of a schema: its text, or the tag of the object.
pub(super) fn variant_of(schema: &Value) -> Option<&str> {
    let tag = || TAGS.iter().find_map(|tag| schema["properties"][*tag]["const"].as_str());
    schema["const"].as_str().or_else(tag)
}

/// Names of a plain enumeration.
pub(super) fn names_of(schema: &Value) -> impl Iterator<Item = &str> {
    schema["enum"].as_array().into_iter().flatten().filter_map(Value::as_str)
}

/// Whether a key is a feature that a method must support: tags and keys without effect on methods are not.
pub(super) fn is_looked_at(place: &str, key: &str) -> bool {
    !(TAGS.contains(&key) || place.is_empty() && METHOD_INDEPENDENT_KEYS.contains(&key))
}

/// Whether a schema requires a key.
pub(super) fn is_required(schema: &Value, key: &str) -> bool {
    schema["required"].as_array().is_some_and(|required| required.iter().any(|name| name == key))
}
