//! Reference of the case file, made from its schema: a page for each section of a case and for each method.

use serde_json::Value;

use crate::reference::models_reference::add_models;
use crate::reference::schema_types::{TypeHeadings, referred_type, type_words};
use crate::reference::sections::{SECTIONS, Section, SectionKeys};

/// Note at the head of a page.
const MADE_FROM_SCHEMA: &str =
    "<!-- Made from the schema by COLLUVIUM_WRITE_DOCS=1 cargo test; do not edit. -->";

/// Notation of the lists of keys.
const NOTATION: &str = "Bold keys are required; a key without a type is a number.";

/// Pages of the reference of the case file: name of each file, and its text as Markdown.
pub fn case_reference() -> Vec<(String, String)> {
    let schema = crate::case_schema();
    let definitions = &schema["$defs"];
    let mut headings = TypeHeadings::default();
    let described: Vec<(&Section, Value, Vec<String>)> = SECTIONS
        .iter()
        .map(|section| {
            let keys = section_keys(section, &schema);
            let names = headings.add_page((section.page, &section.path()), &keys, definitions);
            (section, keys, names)
        })
        .collect();
    let mut pages = Vec::new();
    for (section, keys, names) in &described {
        let writer = PageWriter { page: section.page, headings: &headings };
        let introduction = section.introduction.trim();
        let mut text =
            format!("# {}\n\n{MADE_FROM_SCHEMA}\n\n{introduction}\n\n{NOTATION}\n\n", section.title);
        writer.add_sorted_keys(&mut text, keys, section.common);
        for name in names {
            if name == "MaterialSpec" {
                add_models(&mut text, &writer, &definitions[name]);
            } else {
                writer.add_type(&mut text, name, &definitions[name]);
            }
        }
        pages.push((format!("{}.md", section.page), text.trim_end().to_owned() + "\n"));
    }
    pages
}

/// Keys of a section, as an object of the schema.
fn section_keys(section: &Section, schema: &Value) -> Value {
    match section.keys {
        SectionKeys::Method(name) => schema["properties"]["methods"]["properties"][name].clone(),
        SectionKeys::OfCase(keys) => {
            let properties: serde_json::Map<String, Value> =
                keys.iter().map(|key| ((*key).to_owned(), schema["properties"][key].clone())).collect();
            serde_json::json!({ "properties": properties, "required": schema["required"] })
        }
    }
}

/// Writer of a page.
pub(crate) struct PageWriter<'a> {
    /// Name of the page.
    pub page: &'a str,
    /// Headings of all types.
    pub headings: &'a TypeHeadings,
}

impl PageWriter<'_> {
    /// Adds the keys of an object: the common ones first, in their order, then all others.
    fn add_sorted_keys(&self, text: &mut String, schema: &Value, common: &[&str]) {
        let Some(properties) = schema["properties"].as_object() else { return };
        for key in common.iter().filter(|key| properties.contains_key(**key)) {
            self.add_key(text, key, schema);
        }
        let rare: Vec<&String> = properties.keys().filter(|key| !common.contains(&key.as_str())).collect();
        if !rare.is_empty() {
            text.push_str("\nRarely used:\n\n");
            rare.iter().for_each(|key| self.add_key(text, key, schema));
        }
        text.push('\n');
    }

    /// Adds the list of the keys of an object.
    fn add_keys(&self, text: &mut String, schema: &Value) {
        let lines = self.key_lines(schema);
        if !lines.is_empty() {
            lines.iter().for_each(|(_, line)| text.push_str(line));
            text.push('\n');
        }
    }

    /// Keys of an object with their lines, without its tag.
    pub fn key_lines<'s>(&self, schema: &'s Value) -> Vec<(&'s str, String)> {
        let properties = schema["properties"].as_object().into_iter().flatten();
        let shown = properties.filter(|(_, key)| key["const"].is_null());
        shown.map(|(name, _)| (name.as_str(), self.key_line(name, schema))).collect()
    }

    /// Adds the line of a key.
    fn add_key(&self, text: &mut String, name: &str, object: &Value) {
        text.push_str(&self.key_line(name, object));
    }

    /// Line of a key: bold where it is required, with its type (none for a number), its default and its description.
    fn key_line(&self, name: &str, object: &Value) -> String {
        let schema = &object["properties"][name];
        let required = object["required"].as_array().is_some_and(|all| all.iter().any(|key| key == name));
        let kind = Some(self.type_text(schema)).filter(|text| !text.is_empty() && text != "number");
        let default = Some(&schema["default"]).filter(|value| !required && !value.is_null());
        let facts: Vec<String> =
            kind.into_iter().chain(default.map(|value| format!("default `{value}`"))).collect();
        let facts = if facts.is_empty() { String::new() } else { format!(" ({})", facts.join(", ")) };
        let emphasis = if required { "**" } else { "" };
        format!("- {emphasis}`{name}`{emphasis}{facts}: {}\n", indented(&schema["description"]))
    }

    /// Adds the section of a type.
    fn add_type(&self, text: &mut String, name: &str, schema: &Value) {
        let Some(heading) = self.headings.get(name) else { return };
        text.push_str(&format!("## `{}`\n\n", heading.path));
        if let Some(about) = schema["description"].as_str() {
            text.push_str(&format!("{about}\n\n"));
        }
        let Some(variants) = schema["oneOf"].as_array() else {
            return self.add_keys(text, schema);
        };
        if variants.iter().all(|variant| variant["properties"].is_null() && variant["$ref"].is_null()) {
            for variant in variants {
                let value = variant["const"].as_str().unwrap_or_default();
                text.push_str(&format!("- `{value}`: {}\n", indented(&variant["description"])));
            }
            text.push('\n');
            return;
        }
        variants.iter().for_each(|variant| self.add_variant(text, variant));
    }

    /// Adds a variant with its tag and its keys.
    fn add_variant(&self, text: &mut String, variant: &Value) {
        let tag = variant_tag(variant).map(|(key, value)| format!("\"{key}\": \"{value}\""));
        // The value is under the name of its variant.
        let name = || variant["required"].as_array()?.first()?.as_str();
        let tag = tag.or_else(|| name().map(|name| format!("\"{name}\": …"))).unwrap_or_default();
        text.push_str(&format!("**`{tag}`**: {}\n\n", variant["description"].as_str().unwrap_or_default()));
        if let Some((target, link)) = referred_type(variant).zip(self.link_of(variant)) {
            text.push_str(&format!("Keys of [{}]({link}).\n\n", type_words(target)));
        }
        self.add_keys(text, variant);
    }

    /// Link to the type to which a schema refers.
    fn link_of(&self, schema: &Value) -> Option<String> {
        self.headings.link(referred_type(schema)?, self.page)
    }

    /// Text of the type of a key, with links to other types.
    fn type_text(&self, schema: &Value) -> String {
        if let Some(name) = referred_type(schema) {
            let words = type_words(name);
            return self.link_of(schema).map_or(words.clone(), |link| format!("[{words}]({link})"));
        }
        if let Some(alternatives) = schema["anyOf"].as_array() {
            let kinds: Vec<String> = alternatives.iter().map(|own| self.type_text(own)).collect();
            return kinds.into_iter().filter(|kind| kind != "null").collect::<Vec<_>>().join(" or ");
        }
        let types: Vec<&str> = match &schema["type"] {
            Value::String(name) => vec![name],
            Value::Array(names) => {
                names.iter().filter_map(Value::as_str).filter(|name| *name != "null").collect()
            }
            _ => vec![],
        };
        match types.as_slice() {
            ["array"] => format!("list of {}", self.type_text(&schema["items"])),
            ["object"] if schema["additionalProperties"].is_object() => {
                format!("{} by name", self.type_text(&schema["additionalProperties"]))
            }
            _ => types.join(" or "),
        }
    }
}

/// Tag of a variant: its key and its value.
pub(crate) fn variant_tag(variant: &Value) -> Option<(&str, &str)> {
    let (key, schema) = variant["properties"].as_object()?.iter().find(|(_, s)| s["const"].is_string())?;
    Some((key, schema["const"].as_str()?))
}

/// Description in an entry of a list, whose further lines are indented.
fn indented(description: &Value) -> String {
    description.as_str().unwrap_or_default().replace('\n', "\n  ")
}

/// Description on one line of a Markdown table.
pub(crate) fn one_line(description: &Value) -> String {
    description.as_str().unwrap_or_default().replace('\n', " ").replace('|', "\\|")
}
