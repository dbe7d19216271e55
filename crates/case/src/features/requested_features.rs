//! Features of a case, from its JSON Schema.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use serde_json::{Map, Value};

use crate::Case;

/// Feature that a case uses.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct RequestedFeature {
    /// Keys from the top, without names and numbers of entries, and the variant: `bodies.velocity=sine`.
    pub name: String,
    /// JSON path of the feature in the case: `bodies[2].velocity`.
    pub path: String,
}

/// Keys that no method needs to support: descriptions of the case, and options of methods, which the methods check themselves.
const METHOD_INDEPENDENT_KEYS: [&str; 4] = ["$schema", "title", "notes", "methods"];

/// Keys whose values name the variant of an object.
const TAGS: [&str; 2] = ["kind", "model"];

/// Key of the materials: the material law is the feature, and checks its parameters itself.
const OPAQUE_KEY: &str = "materials";

/// JSON Schema of a case file.
static SCHEMA: LazyLock<Value> = LazyLock::new(|| schemars::schema_for!(Case).to_value());

impl Case {
    /// Features of the case other than defaults and required keys, in the order of their paths in the file.
    #[must_use]
    pub fn features(&self) -> Vec<RequestedFeature> {
        let value = serde_json::to_value(self).unwrap_or_default();
        let mut found = Vec::new();
        walk_value(&SCHEMA, &value, &FeaturePath::default(), &mut |place| found.push(place.feature()));
        found
    }

    /// Names of all features that a case can have; shapes within shapes count once.
    #[must_use]
    pub fn known_features() -> BTreeSet<String> {
        let mut names = BTreeSet::new();
        walk_schema(&SCHEMA, &FeaturePath::default(), &mut Vec::new(), &mut names);
        names
    }
}

/// Name and JSON path of a place in a case, while its features are collected.
#[derive(Clone, Default)]
struct FeaturePath {
    name: String,
    path: String,
}

impl FeaturePath {
    /// Path of a key of the object at this path.
    fn child(&self, key: &str) -> Self {
        let join = |to: &str| if to.is_empty() { key.to_owned() } else { format!("{to}.{key}") };
        Self { name: join(&self.name), path: join(&self.path) }
    }

    /// Path of an entry of the list at this path.
    fn item(&self, number: usize) -> Self {
        Self { name: self.name.clone(), path: format!("{}[{number}]", self.path) }
    }

    /// Path of an entry of a table with names as keys.
    fn entry(&self, name: &str) -> Self {
        Self { name: self.name.clone(), path: format!("{}.{name}", self.path) }
    }

    /// Path of a variant of the value at this path.
    fn variant(&self, variant: &str) -> Self {
        Self { name: format!("{}={variant}", self.name), path: self.path.clone() }
    }

    /// Feature with the name and the JSON path of this path.
    fn feature(&self) -> RequestedFeature {
        RequestedFeature { name: self.name.clone(), path: self.path.clone() }
    }
}

/// Schema to which `schema` refers, or `schema` itself.
fn resolved(schema: &Value) -> &Value {
    match schema["$ref"].as_str().and_then(|to| to.strip_prefix("#/$defs/")) {
        Some(name) => &SCHEMA["$defs"][name],
        None => schema,
    }
}

/// Alternatives (`oneOf` or `anyOf`) of a JSON schema.
fn alternatives(schema: &Value) -> &[Value] {
    let list = ["oneOf", "anyOf"].iter().find_map(|key| schema[*key].as_array());
    list.map_or(&[], Vec::as_slice)
}

/// Name of one of the alternatives of a schema: its text, or the tag of the object.
fn variant_of(schema: &Value) -> Option<&str> {
    let tag = || TAGS.iter().find_map(|tag| schema["properties"][*tag]["const"].as_str());
    schema["const"].as_str().or_else(tag)
}

/// Names of a plain enumeration.
fn names_of(schema: &Value) -> impl Iterator<Item = &str> {
    schema["enum"].as_array().into_iter().flatten().filter_map(Value::as_str)
}

/// Calls `found` for every feature in a value of a case, by the schema of the value.
fn walk_value(schema: &Value, value: &Value, place: &FeaturePath, found: &mut dyn FnMut(&FeaturePath)) {
    let schema = resolved(schema);
    let alternatives = alternatives(schema);
    if !alternatives.is_empty() {
        return walk_alternative(alternatives, value, place, found);
    }
    match value {
        Value::String(name) if names_of(schema).any(|known| known == name) => found(&place.variant(name)),
        Value::Array(items) => {
            for (number, item) in items.iter().enumerate() {
                walk_value(&schema["items"], item, &place.item(number), found);
            }
        }
        Value::Object(object) if schema["properties"].is_object() => {
            walk_object(schema, object, place, found);
        }
        Value::Object(entries) => {
            for (name, entry) in entries {
                walk_value(&schema["additionalProperties"], entry, &place.entry(name), found);
            }
        }
        _ => {}
    }
}

/// Calls `found` for the features in the alternative of `value`.
fn walk_alternative(
    alternatives: &[Value],
    value: &Value,
    place: &FeaturePath,
    found: &mut dyn FnMut(&FeaturePath),
) {
    let object = value.as_object();
    let tag = object.and_then(|object| TAGS.iter().find_map(|tag| object.get(*tag)?.as_str()));
    let name = value.as_str().or(tag);
    let named = alternatives.iter().find(|schema| name.is_some() && variant_of(schema) == name);
    if let (Some(schema), Some(name)) = (named, name) {
        found(&place.variant(name));
        if let (Some(object), true) = (object, place.name != OPAQUE_KEY) {
            walk_object(schema, object, place, found);
        }
        return;
    }
    if name.is_some_and(|name| alternatives.iter().any(|schema| names_of(schema).any(|known| known == name)))
    {
        found(&place.variant(name.unwrap_or_default()));
        return;
    }
    if place.name == OPAQUE_KEY {
        return found(&place.variant("other"));
    }
    // An optional value, or a value without a name: anything except null.
    if !value.is_null()
        && let Some(schema) = alternatives.iter().find(|schema| schema["type"] != "null")
    {
        walk_value(schema, value, place, found);
    }
}

/// Calls `found` for every feature in an object of a case.
fn walk_object(
    schema: &Value,
    object: &Map<String, Value>,
    place: &FeaturePath,
    found: &mut dyn FnMut(&FeaturePath),
) {
    let Some(properties) = schema["properties"].as_object() else { return };
    for (key, value) in object {
        let Some(property) = properties.get(key).filter(|_| is_looked_at(place, key)) else { continue };
        let here = place.child(key);
        if !is_required(schema, key) {
            if is_default(property, value) {
                continue;
            }
            // The first item of a list of objects represents the feature.
            let first = value.as_array().and_then(|items| items.first()).is_some_and(Value::is_object);
            found(&if first { here.item(0) } else { here.clone() });
        }
        walk_value(property, value, &here, found);
    }
}

/// Whether a key is a feature that a method must support: tags and keys without effect on methods are not.
fn is_looked_at(place: &FeaturePath, key: &str) -> bool {
    !(TAGS.contains(&key) || place.name.is_empty() && METHOD_INDEPENDENT_KEYS.contains(&key))
}

/// Whether a schema requires a key.
fn is_required(schema: &Value, key: &str) -> bool {
    schema["required"].as_array().is_some_and(|required| required.iter().any(|name| name == key))
}

/// Whether a value is the default or empty.
fn is_default(property: &Value, value: &Value) -> bool {
    let empty = match value {
        Value::Null => true,
        Value::Array(items) => items.is_empty(),
        Value::Object(entries) => entries.is_empty(),
        _ => false,
    };
    empty || property.get("default").is_some_and(|default| default == value)
}

/// Adds the names of all features that a schema allows.
fn walk_schema<'a>(
    schema: &'a Value,
    place: &FeaturePath,
    above: &mut Vec<&'a str>,
    names: &mut BTreeSet<String>,
) {
    let name = schema["$ref"].as_str();
    let within = if name.is_some() { resolved(schema) } else { schema };
    if name.is_some_and(|name| above.contains(&name)) {
        // The kinds of a shape within a shape, once.
        let kinds = alternatives(within).iter().filter_map(variant_of);
        return names.extend(kinds.map(|kind| place.variant(kind).name));
    }
    above.extend(name);
    for alternative in alternatives(within) {
        match variant_of(alternative) {
            Some(variant) => {
                names.insert(place.variant(variant).name);
                if place.name != OPAQUE_KEY {
                    walk_properties(alternative, place, above, names);
                }
            }
            None if place.name == OPAQUE_KEY => {
                names.insert(place.variant("other").name);
            }
            None => walk_schema(alternative, place, above, names),
        }
    }
    names.extend(names_of(within).map(|variant| place.variant(variant).name));
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
    place: &FeaturePath,
    above: &mut Vec<&'a str>,
    names: &mut BTreeSet<String>,
) {
    for (key, property) in schema["properties"].as_object().into_iter().flatten() {
        if is_looked_at(place, key) {
            let here = place.child(key);
            if !is_required(schema, key) {
                names.insert(here.name.clone());
            }
            walk_schema(property, &here, above, names);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(changes: &[(&str, Value)]) -> Case {
        let mut value = serde_json::json!({
            "title": "t", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1] }, "gravity": [0, -9.81],
            "materials": { "soil": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
            "bodies": [{ "name": "b", "shape": { "kind": "box", "min": [0, 0], "max": [0.5, 0.5] }, "material": "soil" }],
            "stages": [{ "name": "s", "duration": 1 }]
        });
        for (pointer, change) in changes {
            let (above, key) = pointer.rsplit_once('/').unwrap();
            value.pointer_mut(above).unwrap()[key] = change.clone();
        }
        serde_json::from_value(value).unwrap()
    }

    fn requested(changes: &[(&str, Value)]) -> Vec<String> {
        let plain = case(&[]).features();
        let found = case(changes).features().into_iter().filter(|feature| !plain.contains(feature));
        found.map(|feature| format!("{} at {}", feature.name, feature.path)).collect()
    }

    #[test]
    fn features_of_a_minimal_case_are_its_space_shape_and_law() {
        let names: Vec<String> = case(&[]).features().into_iter().map(|feature| feature.name).collect();
        assert_eq!(
            names,
            [
                "bodies",
                "bodies.shape=box",
                "gravity",
                "materials",
                "materials=linear-elastic",
                "space=plane-strain"
            ]
        );
    }

    #[test]
    fn requested_features_are_keys_and_variants_with_their_paths() {
        use serde_json::json;
        assert_eq!(requested(&[("/bodies/0/rigid", json!(true))]), ["bodies.rigid at bodies[0].rigid"]);
        let wall = json!([{ "side": "x-min", "wall": { "kind": "frictional", "friction_coefficient": 0.3, "bilateral": true } }]);
        assert_eq!(
            requested(&[("/boundaries", wall)]),
            [
                "boundaries at boundaries[0]",
                "boundaries.side=x-min at boundaries[0].side",
                "boundaries.wall=frictional at boundaries[0].wall",
                "boundaries.wall.bilateral at boundaries[0].wall.bilateral",
            ]
        );
        let shape =
            json!({ "kind": "union", "shapes": [{ "kind": "ball", "centre": [0.2, 0.2], "radius": 0.1 }] });
        let found = requested(&[("/bodies/0/shape", shape)]);
        assert_eq!(found[0], "bodies.shape=union at bodies[0].shape", "{found:?}");
        let measures = json!({ "work": { "kind": "dissipation" } });
        assert_eq!(requested(&[("/measures", measures)])[1], "measures=dissipation at measures.work");
    }

    #[test]
    fn keys_with_default_values_are_no_requested_features() {
        use serde_json::json;
        let same = [
            ("/bodies/0/rigid", json!(false)),
            ("/bodies/0/velocity", json!({ "kind": "rest" })),
            ("/boundaries", json!([])),
            ("/stages/0/damping", json!(0)),
            ("/output", json!({ "checkpoint": 60 })),
            ("/methods", json!({ "sph": { "spacing": 0.1 } })),
            ("/notes", json!(["a"])),
        ];
        assert_eq!(requested(&same), [""; 0]);
    }

    #[test]
    fn features_requested_by_templates_are_known_features() {
        let known = Case::known_features();
        assert!(known.len() > 130, "{}", known.len());
        let templates = concat!(env!("CARGO_MANIFEST_DIR"), "/../colluvium/src/templates");
        let files = std::fs::read_dir(templates).unwrap().map(|file| file.unwrap().path());
        for file in files.filter(|file| file.extension().is_some_and(|ending| ending == "json")) {
            let case = Case::from_file(&file).unwrap();
            for RequestedFeature { name, .. } in case.features() {
                assert!(known.contains(&name), "{name} is asked for and not known");
            }
        }
    }
}
