//! Types of the schema of a case, each with the page and the heading under which the reference describes it.

use std::collections::{BTreeMap, VecDeque};

use serde_json::Value;

/// Description of a type in the reference: its page, and its heading, the path of the first key of this type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TypeHeading {
    /// Name of the page without its extension.
    pub page: &'static str,
    /// Path of the key, such as `bodies[].shape`.
    pub path: String,
}

/// Headings of the types of a schema.
#[derive(Default)]
pub(crate) struct TypeHeadings(BTreeMap<String, TypeHeading>);

impl TypeHeadings {
    /// Heading of a type.
    pub fn get(&self, name: &str) -> Option<&TypeHeading> {
        self.0.get(name)
    }

    /// Gives a heading on `page` to all types that the keys of `root` reach and that have none yet. Returns their names, the nearest first.
    /// `path` is that of the keys.
    pub fn add_page(
        &mut self,
        (page, path): (&'static str, &str),
        root: &Value,
        definitions: &Value,
    ) -> Vec<String> {
        let (mut queue, mut names) = (VecDeque::new(), Vec::new());
        visit_keys(root, path, &mut queue);
        while let Some((name, path)) = queue.pop_front() {
            if self.0.contains_key(&name) {
                continue;
            }
            let definition = &definitions[&name];
            visit_keys(definition, &path, &mut queue);
            visit_type(&Value::Object(only_alternatives(definition)), &path, &mut queue);
            self.0.insert(name.clone(), TypeHeading { page, path });
            names.push(name);
        }
        names
    }

    /// Link from a page to the heading of a type.
    pub fn link(&self, name: &str, from: &str) -> Option<String> {
        let TypeHeading { page, path } = self.get(name)?;
        let file = if *page == from { String::new() } else { format!("{page}.md") };
        Some(format!("{file}#{}", anchor(path)))
    }
}

/// Types and paths that are still to be visited.
type TypeQueue = VecDeque<(String, String)>;

/// Alternatives of a definition that is no object.
fn only_alternatives(definition: &Value) -> serde_json::Map<String, Value> {
    definition.get("anyOf").map(|all| ("anyOf".to_owned(), all.clone())).into_iter().collect()
}

/// Adds the types of all keys of an object, and of its variants, to the queue.
fn visit_keys(schema: &Value, path: &str, queue: &mut TypeQueue) {
    for (name, key) in schema["properties"].as_object().into_iter().flatten() {
        let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        visit_type(key, &path, queue);
    }
    for variant in schema["oneOf"].as_array().into_iter().flatten() {
        visit_keys(variant, path, queue);
        queue.extend(referred_type(variant).map(|name| (name.to_owned(), path.to_owned())));
    }
}

/// Adds the types of a key to the queue.
fn visit_type(schema: &Value, path: &str, queue: &mut TypeQueue) {
    if let Some(name) = referred_type(schema) {
        queue.push_back((name.to_owned(), path.to_owned()));
    }
    for alternative in schema["anyOf"].as_array().into_iter().flatten() {
        visit_type(alternative, path, queue);
    }
    if schema["items"].is_object() {
        visit_type(&schema["items"], &format!("{path}[]"), queue);
    }
    if schema["additionalProperties"].is_object() {
        visit_type(&schema["additionalProperties"], &format!("{path}.NAME"), queue);
    }
}

/// Name of the type to which a schema refers.
pub(crate) fn referred_type(schema: &Value) -> Option<&str> {
    schema["$ref"].as_str()?.strip_prefix("#/$defs/")
}

/// Anchor of a heading on a page.
pub(crate) fn anchor(heading: &str) -> String {
    let kept = heading.replace(' ', "-");
    kept.chars()
        .filter(|c| c.is_alphanumeric() || matches!(c, '-' | '_'))
        .flat_map(char::to_lowercase)
        .collect()
}

/// Name of a type in words: `pore fluid` for `PoreFluid`.
pub(crate) fn type_words(name: &str) -> String {
    let mut words = String::new();
    for (index, letter) in name.char_indices() {
        if index > 0 && letter.is_uppercase() {
            words.push(' ');
        }
        words.extend(letter.to_lowercase());
    }
    words
}
