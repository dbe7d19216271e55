//! List of material models, made from their model information and schemas.

use constitutive::{MaterialSpec, ModelFamily};
use serde_json::Value;

use crate::constitutive;
use crate::reference::case_reference::{PageWriter, one_line, variant_tag};

/// Models that the sources name without a law that could be verified: candidates for extensions.
const UNVERIFIED_MODELS: &[&str] = &[
    "partial fluidisation with an order parameter (Aranson & Tsimring)",
    "volume-fraction model of dense flow (Josserand et al.)",
    "rigid–plastic Coulomb material at the limit state",
    "non-coaxial plasticity (Yu & Yuan)",
    "advanced elastoplastic models with partial or critical states",
    "viscoplastic model for strain localisation",
    "two-surface SANISAND, the parent of `simsand`",
    "kinetic theory of granular gases",
    "nonlocal and gradient plasticity",
    "other hypoplastic laws (von Wolffersdorff; Herle & Kolymbas; Wang et al.; those in the SPH of Peng et al.)",
    "double-scale bands whose thickness evolves, and several bands in one point",
    "cells of grains as skeleton or interface: `granular_cell` has their averages; the grains are those of a discrete method",
    "snow regimes (cold dense, warm shear, warm plug, sliding slab): `cohesive-cam-clay` with parameters that the sources do not print",
];

/// Adds the material models to the page of materials: a table of all, the parameters of each, and the unverified models.
pub(crate) fn add_models(text: &mut String, writer: &PageWriter<'_>, definition: &Value) {
    text.push_str(
        "## `materials.NAME`\n\nEvery model works in three dimensions, plane strain and axisymmetry, and in [element \
         tests](../element-tests.md). Equations, typical values and limits: [laws](../theory/constitutive.md).\n\n\
         | model | description | source | strain | tangent | methods |\n|---|---|---|---|---|---|\n",
    );
    for (name, facts) in MaterialSpec::MODELS {
        let description =
            model_schema(definition, name).map_or_else(String::new, |v| one_line(&v["description"]));
        text.push_str(&format!(
            "| [`{name}`](#{name}) | {description} | {} | {} | {} | {} |\n",
            facts.source,
            facts.strain,
            facts.tangent,
            methods_of_model(name, facts.kind)
        ));
    }
    text.push_str(
        "\nTangents called numerical are central differences of the update. Laws without finite strain (`rate`) are \
         integrated in a co-rotating frame.\n\n",
    );
    for (name, _) in MaterialSpec::MODELS {
        text.push_str(&format!("## {name}\n\n"));
        if let Some(variant) = model_schema(definition, name) {
            writer.add_keys(text, variant);
        }
    }
    text.push_str(
        "## Models without implementation\n\nThe sources mention these models; the traits of \
         [the contract](../theory/constitutive.md#the-contract) support their implementation.\n\n",
    );
    for extension in UNVERIFIED_MODELS {
        text.push_str(&format!("- {extension}\n"));
    }
    text.push('\n');
}

/// Methods and restrictions of a material model.
fn methods_of_model(name: &str, kind: ModelFamily) -> &'static str {
    match (name, kind) {
        ("umat", _) => "all methods, with the option `--allow-library`; 3D stress only",
        ("hypoplastic", _) => "all methods; viscous mode `rate-material` in element tests only",
        ("saturation-softened", _) => "bodies with a `pore_fluid`; element tests",
        ("double-scale", _) => {
            "all methods; a band is as long as a cell (with splines two), in SPH as two spacings"
        }
        (_, ModelFamily::Solid) => "all methods",
        (_, ModelFamily::Fluid) => "all methods; no shear stress at the start",
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
