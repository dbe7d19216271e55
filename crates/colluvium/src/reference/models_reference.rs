//! List of material models, made from their model information and schemas.

use std::collections::BTreeMap;

use constitutive::{MaterialSpec, ModelFamily};
use serde_json::Value;

use crate::constitutive;
use crate::reference::case_reference::{PageWriter, one_line, variant_tag};

/// Number of models that must have a parameter of the same description for it to be listed once for all.
const COMMON_TO_MODELS: usize = 4;

/// Adds the material models to the page of materials: a table of all, the parameters that several have, and those of each.
pub(crate) fn add_models(text: &mut String, writer: &PageWriter<'_>, definition: &Value) {
    let models: Vec<(&str, Vec<(&str, String)>)> = MaterialSpec::MODELS
        .iter()
        .map(|(name, _)| {
            let lines = model_schema(definition, name).map(|variant| writer.key_lines(variant));
            (*name, lines.unwrap_or_default())
        })
        .collect();
    text.push_str(
        "## `materials.NAME`\n\nEvery model works with all methods, in three dimensions, plane strain and axisymmetry, and in [element \
         tests](../element-tests.md). Equations, typical values and limits: [laws](../theory/constitutive.md).\n\n\
         | model | description | source | strain | tangent | restriction |\n|---|---|---|---|---|---|\n",
    );
    for (name, facts) in MaterialSpec::MODELS {
        let description =
            model_schema(definition, name).map_or_else(String::new, |v| one_line(&v["description"]));
        text.push_str(&format!(
            "| [`{name}`](#{name}) | {description} | {} | {} | {} | {} |\n",
            facts.source,
            facts.strain,
            facts.tangent,
            restriction(name, facts.kind)
        ));
    }
    text.push_str(
        "\nTangents called numerical are central differences of the update. Laws without finite strain (`rate`) are \
         integrated in a co-rotating frame.\n\n",
    );
    add_parameters(text, &models);
}

/// Adds the parameters that several models have, and a section with the others for each model.
fn add_parameters(text: &mut String, models: &[(&str, Vec<(&str, String)>)]) {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for (_, line) in models.iter().flat_map(|(_, lines)| lines) {
        *counts.entry(line).or_default() += 1;
    }
    let is_common = |line: &str| counts.get(line).is_some_and(|count| *count >= COMMON_TO_MODELS);
    text.push_str("### Common parameters\n\n");
    counts.keys().filter(|line| is_common(line)).for_each(|line| text.push_str(line));
    for (name, lines) in models {
        text.push_str(&format!("\n## {name}\n\n"));
        let (common, own): (Vec<_>, Vec<_>) = lines.iter().partition(|(_, line)| is_common(line));
        if !common.is_empty() {
            // A bold key is required in the list and here.
            let keys = common.iter().map(|(key, line)| {
                if line.starts_with("- **") { format!("**`{key}`**") } else { format!("`{key}`") }
            });
            let keys = keys.collect::<Vec<_>>().join(", ");
            text.push_str(&format!("- [Common](#common-parameters): {keys}\n"));
        }
        own.iter().for_each(|(_, line)| text.push_str(line));
    }
    text.push('\n');
}

/// Restrictions of a material model.
fn restriction(name: &str, kind: ModelFamily) -> &'static str {
    match (name, kind) {
        ("umat", _) => "option `--allow-library`; 3D stress only",
        ("hypoplastic", _) => "viscous mode `rate-material` in element tests only",
        ("saturation-softened", _) => "bodies with a `pore_fluid`; element tests",
        ("double-scale", _) => "a band is as long as a cell (with splines two), in SPH as two spacings",
        (_, ModelFamily::Solid) => "",
        (_, ModelFamily::Fluid) => "no shear stress at the start",
        (_, ModelFamily::Wrapper) => "those of the inner material",
    }
}

/// Schema of a model among those of the materials.
fn model_schema<'a>(definition: &'a Value, name: &str) -> Option<&'a Value> {
    let variants = definition["oneOf"].as_array()?;
    variants
        .iter()
        .find(|variant| variant_tag(variant).is_some_and(|(key, value)| key == "model" && value == name))
}
