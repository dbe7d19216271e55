//! Reference of the case file, made from its schema.

use serde_json::Value;

/// Reference of the case file as Markdown: every object with its keys, types, defaults and descriptions.
pub fn case_reference() -> String {
    let schema = crate::case_schema();
    let mut text = String::from(
        "# Case file\n\nMade from the schema by `colluvium schema --markdown`; do not edit.\n\nA case is a JSON file. \
         All quantities are in SI units, angles in degrees; stress and strain are tension-positive, pressure is \
         compression-positive. Unknown keys are errors. An editor that knows JSON Schema completes and checks a case \
         with `docs/case.schema.json`.\n\n",
    );
    object_section(&mut text, "Case", &schema);
    if let Some(methods) = schema["properties"]["methods"]["properties"].as_object() {
        for (name, options) in methods {
            object_section(&mut text, &format!("methods.{name}"), options);
        }
    }
    if let Some(definitions) = schema["$defs"].as_object() {
        for (name, definition) in definitions {
            object_section(&mut text, name, definition);
        }
    }
    text.trim_end().to_owned() + "\n"
}

/// Adds the section of a type to the case reference.
fn object_section(text: &mut String, name: &str, schema: &Value) {
    text.push_str(&format!("## {name}\n\n"));
    if let Some(about) = schema["description"].as_str() {
        text.push_str(&format!("{about}\n\n"));
    }
    match schema["oneOf"].as_array() {
        Some(variants) if variants.iter().all(|v| v["properties"].is_null()) => {
            for variant in variants {
                let value = variant["const"].as_str().unwrap_or_default();
                text.push_str(&format!("- `{value}`: {}\n", one_line(&variant["description"])));
            }
            text.push('\n');
        }
        Some(variants) => {
            for variant in variants {
                let tag = variant_tag(variant).map(|(key, value)| format!("\"{key}\": \"{value}\""));
                // The value is under the name of its variant.
                let name = || variant["required"].as_array()?.first()?.as_str();
                let tag = tag.or_else(|| name().map(|name| format!("\"{name}\": …"))).unwrap_or_default();
                text.push_str(&format!("**`{tag}`** — {}\n\n", one_line(&variant["description"])));
                if let Some(target) = schema_reference(variant) {
                    text.push_str(&format!("Keys of [{target}](#{}).\n\n", target.to_lowercase()));
                }
                key_table(text, variant);
            }
        }
        None => key_table(text, schema),
    }
}

/// Tag of a variant: its key and its value.
pub(crate) fn variant_tag(variant: &Value) -> Option<(&str, &str)> {
    let (key, schema) = variant["properties"].as_object()?.iter().find(|(_, s)| s["const"].is_string())?;
    Some((key, schema["const"].as_str()?))
}

/// Table of the keys of an object.
pub(crate) fn key_table(text: &mut String, schema: &Value) {
    let Some(properties) = schema["properties"].as_object() else { return };
    let shown: Vec<_> = properties.iter().filter(|(_, s)| s["const"].is_null()).collect();
    if shown.is_empty() {
        return;
    }
    let required: Vec<&str> =
        schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    text.push_str("| key | type | default | meaning |\n|---|---|---|---|\n");
    for (name, schema) in shown {
        let default = match (&schema["default"], required.contains(&name.as_str())) {
            (_, true) => "required".to_owned(),
            (Value::Null, false) => String::new(),
            (value, false) => format!("`{value}`"),
        };
        text.push_str(&format!(
            "| `{name}` | {} | {default} | {} |\n",
            type_text(schema),
            one_line(&schema["description"])
        ));
    }
    text.push('\n');
}

/// Name of the definition to which a schema refers.
fn schema_reference(schema: &Value) -> Option<&str> {
    schema["$ref"].as_str()?.strip_prefix("#/$defs/")
}

/// Text of the type of a key, with links to the sections of other types.
fn type_text(schema: &Value) -> String {
    if let Some(target) = schema_reference(schema) {
        return format!("[{target}](#{})", target.to_lowercase());
    }
    if let Some(variants) = schema["anyOf"].as_array() {
        let kinds: Vec<String> = variants.iter().map(type_text).filter(|k| k != "null").collect();
        return kinds.join(" or ");
    }
    let types: Vec<&str> = match &schema["type"] {
        Value::String(name) => vec![name],
        Value::Array(names) => names.iter().filter_map(Value::as_str).filter(|n| *n != "null").collect(),
        _ => vec![],
    };
    let of = |types: Vec<&str>| types.join(" or ");
    match types.as_slice() {
        ["array"] => format!("list of {}", type_text(&schema["items"])),
        ["object"] if schema["additionalProperties"].is_object() => {
            format!("object of {}", type_text(&schema["additionalProperties"]))
        }
        _ => of(types),
    }
}

/// Description on one line of a Markdown table.
pub(crate) fn one_line(description: &Value) -> String {
    description.as_str().unwrap_or_default().replace('\n', " ").replace('|', "\\|")
}
