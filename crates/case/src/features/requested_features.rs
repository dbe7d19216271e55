//! Features that a case requests, from its JSON Schema.

use serde_json::{Map, Value};

use crate::features::schema::{
    OPAQUE_KEY, SCHEMA, TAGS, alternatives, is_looked_at, is_required, names_of, resolved, variant_of,
};
use crate::{Case, Feature};

/// Feature that a case uses.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct RequestedFeature {
    /// Key or variant. A law of the program is [`Feature::MaterialsOther`].
    pub feature: Feature,
    /// JSON path of the feature in the case: `bodies[2].velocity`.
    pub path: String,
}

impl Case {
    /// Features of the case other than defaults and required keys, in the order of their paths in the file. Keys of shapes within shapes
    /// count as those of the outer shape.
    #[must_use]
    pub fn features(&self) -> Vec<RequestedFeature> {
        let value = serde_json::to_value(self).unwrap_or_default();
        let mut found = Vec::new();
        walk_value(&SCHEMA, &value, &FeaturePath::default(), &mut |place| found.extend(place.feature()));
        found
    }
}

/// Name and JSON path of a place in a case, while its features are collected.
#[derive(Clone, Default)]
struct FeaturePath {
    name: String,
    path: String,
    /// Definitions of the schema around the place, each with the name of its place.
    definitions: Vec<(String, String)>,
}

impl FeaturePath {
    /// Path of a key of the object at this path.
    fn child(&self, key: &str) -> Self {
        let join = |to: &str| if to.is_empty() { key.to_owned() } else { format!("{to}.{key}") };
        Self { name: join(&self.name), path: join(&self.path), definitions: self.definitions.clone() }
    }

    /// Path of an entry of the list at this path.
    fn item(&self, number: usize) -> Self {
        Self { path: format!("{}[{number}]", self.path), ..self.clone() }
    }

    /// Path of an entry of a table with names as keys.
    fn entry(&self, name: &str) -> Self {
        Self { path: format!("{}.{name}", self.path), ..self.clone() }
    }

    /// Path of a variant of the value at this path.
    fn variant(&self, variant: &str) -> Self {
        Self { name: format!("{}={variant}", self.name), ..self.clone() }
    }

    /// Path inside of a value of a definition of the schema. Within a value of the same definition it has the name of that value.
    fn inside(&self, definition: Option<&str>) -> Self {
        let mut inside = self.clone();
        let Some(definition) = definition else { return inside };
        match self.definitions.iter().find(|(outer, _)| outer == definition) {
            Some((_, name)) => inside.name.clone_from(name),
            None => inside.definitions.push((definition.to_owned(), self.name.clone())),
        }
        inside
    }

    /// Feature with the name and the JSON path of this path. A test ensures that the list of features has all names of the schema.
    fn feature(&self) -> Option<RequestedFeature> {
        let feature = Feature::named(&self.name);
        debug_assert!(feature.is_some(), "{} is missing in the list of features", self.name);
        Some(RequestedFeature { feature: feature?, path: self.path.clone() })
    }
}

/// Calls `found` for every feature in a value of a case, by the schema of the value.
fn walk_value(schema: &Value, value: &Value, place: &FeaturePath, found: &mut dyn FnMut(&FeaturePath)) {
    let inside = place.inside(schema["$ref"].as_str());
    let schema = resolved(schema);
    let alternatives = alternatives(schema);
    if !alternatives.is_empty() {
        return walk_alternative(alternatives, value, (place, &inside), found);
    }
    match value {
        Value::String(name) if names_of(schema).any(|known| known == name) => found(&place.variant(name)),
        Value::Array(items) => {
            for (number, item) in items.iter().enumerate() {
                walk_value(&schema["items"], item, &inside.item(number), found);
            }
        }
        Value::Object(object) if schema["properties"].is_object() => {
            walk_object(schema, object, &inside, found);
        }
        Value::Object(entries) => {
            for (name, entry) in entries {
                walk_value(&schema["additionalProperties"], entry, &inside.entry(name), found);
            }
        }
        _ => {}
    }
}

/// Calls `found` for the features in the alternative of `value`: its variant at a place, and its keys inside of it.
fn walk_alternative(
    alternatives: &[Value],
    value: &Value,
    (place, inside): (&FeaturePath, &FeaturePath),
    found: &mut dyn FnMut(&FeaturePath),
) {
    let object = value.as_object();
    let tag = object.and_then(|object| TAGS.iter().find_map(|tag| object.get(*tag)?.as_str()));
    let name = value.as_str().or(tag);
    let named = alternatives.iter().find(|schema| name.is_some() && variant_of(schema) == name);
    if let (Some(schema), Some(name)) = (named, name) {
        found(&place.variant(name));
        if let (Some(object), true) = (object, place.name != OPAQUE_KEY) {
            walk_object(schema, object, inside, found);
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
        walk_value(schema, value, inside, found);
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
        let Some(property) = properties.get(key).filter(|_| is_looked_at(&place.name, key)) else { continue };
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
        found.map(|feature| format!("{} at {}", feature.feature, feature.path)).collect()
    }

    #[test]
    fn features_of_a_minimal_case_are_its_space_shape_and_law() {
        let names: Vec<&str> = case(&[]).features().into_iter().map(|found| found.feature.name()).collect();
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
    fn keys_of_shapes_within_shapes_are_those_of_the_outer_shape() {
        use serde_json::json;
        let ball = json!({ "kind": "ball", "centre": [0.2, 0.2], "radius": 0.1 });
        let inner = json!({ "kind": "union", "shapes": [ball] });
        let cut = json!({ "kind": "union", "shapes": [inner] });
        let shape = json!({ "kind": "difference", "from": inner, "cut": cut });
        assert_eq!(
            requested(&[("/bodies/0/shape", shape)]),
            [
                "bodies.shape=difference at bodies[0].shape",
                "bodies.shape.cut=union at bodies[0].shape.cut",
                "bodies.shape.shapes=union at bodies[0].shape.cut.shapes[0]",
                "bodies.shape.shapes=ball at bodies[0].shape.cut.shapes[0].shapes[0]",
                "bodies.shape.from=union at bodies[0].shape.from",
                "bodies.shape.shapes=ball at bodies[0].shape.from.shapes[0]",
            ]
        );
    }
}
