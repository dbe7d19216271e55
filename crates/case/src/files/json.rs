//! JSON reader with paths in its errors: a text is checked against the JSON Schema of the type it is read into, and all errors are reported
//! with their paths.

use std::path::Path;

use schemars::JsonSchema;
use serde::de::{DeserializeOwned, DeserializeSeed, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

pub use crate::error::closest;
use crate::files::finite_numbers::NON_FINITE_MARK;
use crate::files::terrain_files;
use crate::{CaseError, CaseErrorKind, CaseErrors};

/// Keys of earlier versions and their present names. A case with an old key is refused with the new name.
const RENAMED_KEYS: [(&str, &str); 7] = [
    ("at_most", "max"),
    ("carrier", "applied_to"),
    ("cuts", "removal_shapes"),
    ("drop_outside", "remove_outside"),
    ("of", "obstacle"),
    ("of", "target"),
    ("project", "return_initial_stress_to_yield"),
];

/// Choices of earlier versions and their present names.
const RENAMED_CHOICES: [(&str, &str); 1] = [("other", "external")];

/// Reads a value of type `T` from JSON text.
///
/// # Errors
/// All deviations from the type's schema: syntax (with line and column), duplicate and unknown keys (with the likely intended one), missing
/// keys, wrong types, unknown variants.
pub fn read<T: DeserializeOwned + JsonSchema>(text: &str) -> Result<T, CaseErrors> {
    let value = parse(text).map_err(CaseErrors::from_error)?;
    from_value(&value, "")
}

/// Reads a value of type `T` from a JSON file of a user.
///
/// # Errors
/// See [`read`], syntax with the file as well; when the file cannot be read.
pub fn read_file<T: DeserializeOwned + JsonSchema>(file: &Path) -> Result<T, CaseErrors> {
    from_value(&value(file)?, "")
}

/// Reads a value of type `T` from a JSON value with the path `path` in its file.
///
/// # Errors
/// See [`read`], except for syntax.
pub fn from_value<T: DeserializeOwned + JsonSchema>(value: &Value, path: &str) -> Result<T, CaseErrors> {
    let schema = schemars::schema_for!(T).to_value();
    let mut checker = Checker { root: &schema, errors: Vec::new() };
    checker.check(&schema, value, path);
    if !checker.errors.is_empty() {
        return Err(CaseErrors(checker.errors));
    }
    serde_path_to_error::deserialize(value).map_err(|error| {
        let inner = error.path().to_string();
        CaseErrors::from_error(CaseError::new(join(path, &inner), error.inner().to_string()))
    })
}

/// Path extended by a key, after a point, or by an index.
fn join(path: &str, key: &str) -> String {
    match (path.is_empty(), key.is_empty() || key == ".") {
        (true, _) => key.to_owned(),
        (false, true) => path.to_owned(),
        (false, false) if key.starts_with('[') => format!("{path}{key}"),
        (false, false) => format!("{path}.{key}"),
    }
}

/// Text of a file of a user.
///
/// # Errors
/// When it cannot be read; the path is that of the file.
pub fn text(file: &Path) -> Result<String, CaseErrors> {
    let unreadable = |problem: String| {
        let kind = CaseErrorKind::Unreadable { file: file.to_owned(), problem };
        CaseErrors::from_error(CaseError::new(file.display().to_string(), kind))
    };
    let bytes = std::fs::read(file).map_err(|error| unreadable(format!("cannot be read: {error}")))?;
    // UTF-16 with its byte order mark, as some editors write it.
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return terrain_files::read_text(file).map_err(|error| unreadable(error.problem));
    }
    String::from_utf8(bytes)
        .map_err(|_| unreadable("cannot be read: it is not text in UTF-8 or UTF-16".to_owned()))
}

/// JSON value in a file of a user.
///
/// # Errors
/// When it cannot be read; syntax and duplicate keys, with file, line and column.
pub fn value(file: &Path) -> Result<Value, CaseErrors> {
    parse(&text(file)?).map_err(|error| CaseErrors::from_error(error).with_file_name(file))
}

/// Parses JSON text; a byte order mark at the beginning is skipped.
///
/// # Errors
/// Syntax and duplicate keys, with line and column.
pub fn parse(text: &str) -> Result<Value, CaseError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut deserializer = serde_json::Deserializer::from_str(text);
    let value =
        StrictJson.deserialize(&mut deserializer).and_then(|value| deserializer.end().map(|()| value));
    value.map_err(|error| {
        let place = format!("line {}, column {}", error.line(), error.column());
        let message = error.to_string();
        let problem = message.split(" at line ").next().unwrap_or(&message).to_owned();
        CaseError::new(place, CaseErrorKind::Syntax { line: error.line(), column: error.column(), problem })
    })
}

/// JSON reader that rejects an object with a repeated key.
struct StrictJson;

impl<'de> DeserializeSeed<'de> for StrictJson {
    type Value = Value;

    fn deserialize<D: serde::Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for StrictJson {
    type Value = Value;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a JSON value")
    }
    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }
    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }
    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }
    fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
        Ok(value.into())
    }
    fn visit_str<E>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }
    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut access: A) -> Result<Value, A::Error> {
        let mut items = Vec::new();
        while let Some(item) = access.next_element_seed(StrictJson)? {
            items.push(item);
        }
        Ok(Value::Array(items))
    }
    fn visit_map<A: MapAccess<'de>>(self, mut access: A) -> Result<Value, A::Error> {
        let mut map = Map::new();
        while let Some(key) = access.next_key::<String>()? {
            let value = access.next_value_seed(StrictJson)?;
            if map.contains_key(&key) {
                return Err(serde::de::Error::custom(format!("the key {key:?} appears twice in one object")));
            }
            map.insert(key, value);
        }
        Ok(Value::Object(map))
    }
}

/// Recursive check of a value against a schema.
struct Checker<'a> {
    root: &'a Value,
    errors: Vec<CaseError>,
}

/// Keys of an object schema, with references and variants resolved.
struct ObjectKeys<'a> {
    properties: Vec<(&'a str, &'a Value)>,
    required_keys: Vec<&'a str>,
    /// Schema of keys that are not listed; `None` where they are errors.
    additional: Option<&'a Value>,
}

impl<'a> Checker<'a> {
    fn report(&mut self, path: &str, kind: CaseErrorKind) {
        let path = if path.is_empty() { "case file" } else { path };
        self.errors.push(CaseError::new(path, kind));
    }

    /// Reports a value of a wrong type; the rule follows the value in the message.
    fn wrong_type(&mut self, path: &str, value: &Value, rule: impl Into<String>) {
        let (found, rule) = (type_name(value), rule.into());
        let kind = if *value == NON_FINITE_MARK {
            CaseErrorKind::NotFinite("is not a finite number".to_owned())
        } else {
            CaseErrorKind::WrongType { found, rule }
        };
        self.report(path, kind);
    }

    /// Definition to which a schema refers by `$ref`.
    fn resolve(&self, schema: &'a Value) -> Option<&'a Value> {
        let name = schema.get("$ref")?.as_str()?.strip_prefix("#/$defs/")?;
        self.root.get("$defs")?.get(name)
    }
    fn check(&mut self, schema: &'a Value, value: &Value, path: &str) {
        let variants = schema.get("oneOf").or_else(|| schema.get("anyOf")).and_then(Value::as_array);
        if let Some(variants) = variants {
            self.check_variants(variants, value, path);
            return;
        }
        if schema.get("properties").is_none()
            && let Some(target) = self.resolve(schema)
        {
            self.check(target, value, path);
            return;
        }
        if let Some(choices) = schema.get("enum").and_then(Value::as_array) {
            self.check_choice(choices, value, path);
            return;
        }
        if let Some(constant) = schema.get("const") {
            self.check_choice(std::slice::from_ref(constant), value, path);
            return;
        }
        if !self.check_type(schema, value, path) {
            return;
        }
        match value {
            Value::Object(map) => self.check_object(schema, map, path),
            Value::Array(items) => self.check_array(schema, items, path),
            _ => {}
        }
    }

    /// Checks a value against alternative schemas (`oneOf`, `anyOf`).
    fn check_variants(&mut self, variants: &'a [Value], value: &Value, path: &str) {
        // An optional value: the schema, or null.
        let is_null = |v: &&Value| v.get("type").and_then(Value::as_str) == Some("null");
        if variants.iter().any(|v| is_null(&v)) {
            if !value.is_null() {
                variants.iter().filter(|v| !is_null(v)).for_each(|v| self.check(v, value, path));
            }
            return;
        }
        if let Some(tag) = variants.iter().find_map(tag_of) {
            self.check_tagged(tag, variants, value, path);
            return;
        }
        let named: Vec<(&str, &Value)> = variants.iter().filter_map(named_variant).collect();
        if !named.is_empty() && named.len() == variants.len() {
            self.check_named(&named, value, path);
            return;
        }
        let any_text = |v: &Value| {
            let text = v.get("type").and_then(Value::as_str) == Some("string");
            text && v.get("enum").is_none() && v.get("const").is_none()
        };
        if variants.iter().any(any_text) {
            let object = variants.iter().map(|variant| self.resolve(variant).unwrap_or(variant));
            let object = object.into_iter().find(|variant| variant.get("properties").is_some());
            match (value, object) {
                (Value::Number(_) | Value::String(_), _) => {}
                (Value::Object(map), Some(schema)) => self.check_object(schema, map, path),
                _ => self.wrong_type(path, value, "is neither a number nor a text"),
            }
            return;
        }
        let (mut words, mut number) = (Vec::new(), false);
        variants.iter().for_each(|variant| self.collect_untagged(variant, &mut words, &mut number));
        if !number {
            self.check_choice(&words, value, path);
        } else if !value.is_number() && !words.contains(value) {
            let words = names_of(&words).join(", ");
            self.wrong_type(path, value, format!("is neither a number nor one of {words}"));
        }
    }

    /// Possible texts of a value without a tag, and whether it may be a number.
    fn collect_untagged(&self, schema: &'a Value, words: &mut Vec<Value>, number: &mut bool) {
        let schema = self.resolve(schema).unwrap_or(schema);
        *number |= schema.get("type").and_then(Value::as_str) == Some("number");
        words.extend(schema.get("const").cloned());
        words.extend(schema.get("enum").and_then(Value::as_array).into_iter().flatten().cloned());
        let variants = schema.get("oneOf").or_else(|| schema.get("anyOf")).and_then(Value::as_array);
        variants.into_iter().flatten().for_each(|variant| self.collect_untagged(variant, words, number));
    }

    /// Checks an object against the alternative whose constant the value of the key `tag` is.
    fn check_tagged(&mut self, tag: &str, variants: &'a [Value], value: &Value, path: &str) {
        let Value::Object(map) = value else {
            return self.wrong_type(path, value, format!("is not an object with a key {tag:?}"));
        };
        let constant = |variant: &'a Value| variant.get("properties")?.get(tag)?.get("const");
        let choices: Vec<Value> = variants.iter().filter_map(constant).cloned().collect();
        let Some(found) = map.get(tag) else {
            let kind = CaseErrorKind::MissingKey { key: tag.to_owned(), choices: names_of(&choices) };
            return self.report(path, kind);
        };
        match variants.iter().find(|variant| constant(variant) == Some(found)) {
            Some(variant) => self.check_object(variant, map, path),
            None => self.check_choice(&choices, found, &join(path, tag)),
        }
    }

    /// Checks a value under the name of its variant, `{ "calibration": { … } }`.
    fn check_named(&mut self, variants: &[(&str, &'a Value)], value: &Value, path: &str) {
        let names: Vec<Value> = variants.iter().map(|(name, _)| Value::from(*name)).collect();
        let keys = value.as_object().filter(|map| map.len() == 1);
        let Some((key, inner)) = keys.and_then(|map| map.iter().next()) else {
            let names = names_of(&names).join(", ");
            return self.wrong_type(path, value, format!("is not an object with one key of {names}"));
        };
        match variants.iter().find(|(name, _)| name == key) {
            Some((_, schema)) => self.check(schema, inner, &join(path, key)),
            None => self.check_choice(&names, &Value::from(key.as_str()), path),
        }
    }
    fn check_choice(&mut self, choices: &[Value], value: &Value, path: &str) {
        if choices.contains(value) {
            return;
        }
        let names: Vec<&str> = choices.iter().filter_map(Value::as_str).collect();
        let renamed = |found| RENAMED_CHOICES.iter().find(|(old, new)| *old == found && names.contains(new));
        if let Some((old, new)) = value.as_str().and_then(renamed) {
            let kind = CaseErrorKind::RenamedChoice { old: (*old).to_owned(), new: (*new).to_owned() };
            return self.report(path, kind);
        }
        let suggestion = value.as_str().and_then(|found| closest(found, &names)).map(str::to_owned);
        let (found, choices) = (type_name(value), names_of(choices));
        self.report(path, CaseErrorKind::UnknownChoice { found, choices, suggestion });
    }

    /// Whether a value has a type that its schema allows; reports it otherwise.
    fn check_type(&mut self, schema: &Value, value: &Value, path: &str) -> bool {
        let types: Vec<&str> = match schema.get("type") {
            Some(Value::String(name)) => vec![name],
            Some(Value::Array(names)) => names.iter().filter_map(Value::as_str).collect(),
            _ => return true,
        };
        let fits = |name: &&str| match *name {
            "object" => value.is_object(),
            "array" => value.is_array(),
            "string" => value.is_string(),
            "boolean" => value.is_boolean(),
            "null" => value.is_null(),
            "integer" => value.is_u64() || value.is_i64(),
            "number" => value.is_number(),
            _ => true,
        };
        if !types.iter().any(fits) {
            let wanted: Vec<&str> = types.into_iter().filter(|name| *name != "null").collect();
            self.wrong_type(path, value, format!("is not of type {}", wanted.join(" or ")));
            return false;
        }
        if let (Some(number), Some(smallest)) =
            (value.as_f64(), schema.get("minimum").and_then(Value::as_f64))
            && number < smallest
        {
            self.report(path, CaseErrorKind::out_of_range(number, format!("is below {smallest}")));
            return false;
        }
        true
    }
    fn check_array(&mut self, schema: &'a Value, items: &[Value], path: &str) {
        let bound = |key: &str| schema.get(key).and_then(Value::as_u64).map(|n| n as usize);
        let (smallest, largest) = (bound("minItems").unwrap_or(0), bound("maxItems").unwrap_or(usize::MAX));
        if items.len() < smallest || items.len() > largest {
            let wanted =
                if smallest == largest { format!("{smallest}") } else { format!("{smallest} or more") };
            let rule = format!("{wanted} are needed");
            return self.report(path, CaseErrorKind::WrongLength { length: items.len(), rule });
        }
        if let Some(of_items) = schema.get("items") {
            for (number, item) in items.iter().enumerate() {
                self.check(of_items, item, &format!("{path}[{number}]"));
            }
        }
    }
    fn keys(&self, schema: &'a Value) -> ObjectKeys<'a> {
        let mut keys = ObjectKeys { properties: Vec::new(), required_keys: Vec::new(), additional: None };
        let mut closed = false;
        for part in [Some(schema), self.resolve(schema)].into_iter().flatten() {
            let properties = part.get("properties").and_then(Value::as_object);
            keys.properties.extend(properties.into_iter().flatten().map(|(k, v)| (k.as_str(), v)));
            let required = part.get("required").and_then(Value::as_array);
            keys.required_keys.extend(required.into_iter().flatten().filter_map(Value::as_str));
            match part.get("additionalProperties") {
                Some(Value::Bool(false)) => closed = true,
                Some(others) => keys.additional = Some(others),
                None => {}
            }
        }
        if closed {
            keys.additional = None;
        } else if keys.additional.is_none() {
            keys.additional = Some(&Value::Bool(true));
        }
        keys
    }

    /// Reports missing and unknown keys of an object, and checks the values of the others.
    fn check_object(&mut self, schema: &'a Value, map: &Map<String, Value>, path: &str) {
        let keys = self.keys(schema);
        for key in &keys.required_keys {
            if !map.contains_key(*key) {
                let kind = CaseErrorKind::MissingKey { key: (*key).to_owned(), choices: Vec::new() };
                self.report(path, kind);
            }
        }
        for (key, value) in map {
            let child = join(path, key);
            match keys.properties.iter().find(|(name, _)| name == key) {
                Some((_, schema)) => self.check(schema, value, &child),
                None => match keys.additional {
                    Some(schema) if schema.is_object() => self.check(schema, value, &child),
                    Some(_) => {}
                    None => self.unknown_key(key, &keys, &child),
                },
            }
        }
    }

    /// Reports an unknown key, with its new name where it was renamed and otherwise with the nearest known key.
    fn unknown_key(&mut self, key: &str, keys: &ObjectKeys<'_>, path: &str) {
        let names: Vec<&str> = keys.properties.iter().map(|(name, _)| *name).collect();
        let renamed = RENAMED_KEYS.iter().find(|(old, new)| *old == key && names.contains(new));
        if let Some((_, new)) = renamed {
            return self.report(path, CaseErrorKind::RenamedKey { new: (*new).to_owned() });
        }
        let suggestion = closest(key, &names).map(str::to_owned);
        let allowed = names.into_iter().map(str::to_owned).collect();
        self.report(path, CaseErrorKind::UnknownKey { suggestion, allowed });
    }
}

/// Key of the tag of an internally tagged variant.
fn tag_of(variant: &Value) -> Option<&str> {
    let properties = variant.get("properties")?.as_object()?;
    properties.iter().find(|(_, schema)| schema.get("const").is_some()).map(|(key, _)| key.as_str())
}

/// Name and schema of a variant that is an object with one required key and no tag.
fn named_variant(variant: &Value) -> Option<(&str, &Value)> {
    let properties = variant.get("properties")?.as_object().filter(|map| map.len() == 1)?;
    let (name, schema) = properties.iter().next()?;
    let required = variant.get("required")?.as_array()?;
    (required.len() == 1 && schema.get("const").is_none()).then_some((name.as_str(), schema))
}

/// Choices as texts.
fn names_of(choices: &[Value]) -> Vec<String> {
    choices.iter().map(|c| c.as_str().map_or(c.to_string(), str::to_owned)).collect()
}

fn type_name(value: &Value) -> String {
    let text = value.to_string();
    let short: String = text.chars().take(40).collect();
    if short.len() < text.len() { format!("{short}…") } else { short }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_index_follows_its_path_without_a_dot() {
        let value = serde_json::json!([1, 300]);
        let errors = from_value::<Vec<u8>>(&value, "methods.mpm.layers").unwrap_err();
        assert_eq!(errors.first().path, "methods.mpm.layers[1]");
        assert_eq!(join("a", "b"), "a.b");
        assert_eq!(join("", "[0].b"), "[0].b");
        assert_eq!(join("a", "."), "a");
    }

    #[test]
    fn a_leading_byte_order_mark_is_accepted() {
        assert_eq!(parse("\u{feff}{ \"a\": 1 }").unwrap(), serde_json::json!({ "a": 1 }));
        assert!(parse("{ \u{feff}\"a\": 1 }").is_err());
    }

    #[test]
    fn enum_variants_may_be_written_as_a_key() {
        #[derive(Debug, PartialEq, serde::Deserialize, JsonSchema)]
        #[serde(rename_all = "kebab-case")]
        enum Shape {
            Circle(f64),
            Box { width: f64 },
        }
        let read = |value: Value| from_value::<Shape>(&value, "shape");
        assert_eq!(read(serde_json::json!({ "circle": 2.0 })).unwrap(), Shape::Circle(2.0));
        assert_eq!(read(serde_json::json!({ "box": { "width": 1.0 } })).unwrap(), Shape::Box { width: 1.0 });
        let problem = |value| read(value).unwrap_err().to_string();
        assert!(problem(serde_json::json!({ "box": {} })).starts_with("shape.box: "));
        assert!(problem(serde_json::json!({ "circel": 1.0 })).contains("circle"));
        assert!(problem(serde_json::json!({ "circle": 1.0, "box": {} })).contains("one key"));
    }
}
