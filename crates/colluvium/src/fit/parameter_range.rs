//! Ranges of fitted parameters: values from the unit cube and back, and the materials with these values.

use serde_json::Value;

use crate::case::{CaseError, CaseErrorKind, CaseErrors};
use crate::constitutive::MaterialSpec;
use crate::fit::{Fit, FitParameter};
use crate::sweep::ParameterScale;
use crate::sweep::json_path::{set_value, value_at};

impl FitParameter {
    /// Problem of the range.
    pub(super) fn range_problem(&self) -> Option<String> {
        let [low, high] = self.range;
        if !(low < high && low.is_finite() && high.is_finite()) {
            return Some(format!("{low} is not below {high}"));
        }
        let logarithmic = self.scale == ParameterScale::Logarithmic;
        (logarithmic && low <= 0.0)
            .then(|| format!("{low} is not above 0, which a logarithmic scale requires"))
    }

    /// Value at a share of the range, 0 to 1.
    pub(super) fn value(&self, share: f64) -> f64 {
        let [low, high] = self.range;
        let value = match self.scale {
            ParameterScale::Linear => low + share * (high - low),
            ParameterScale::Logarithmic => low * (high / low).powf(share),
        };
        value.clamp(low, high)
    }

    /// Share of the range, 0 to 1, at which a value is.
    pub(super) fn share(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        match self.scale {
            ParameterScale::Linear => (value - low) / (high - low),
            ParameterScale::Logarithmic => (value / low).ln() / (high / low).ln(),
        }
    }

    /// Change of the value per share of the range, at a value.
    pub(super) fn slope(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        match self.scale {
            ParameterScale::Linear => high - low,
            ParameterScale::Logarithmic => value * (high / low).ln(),
        }
    }
}

/// Fitted parameters of a material, in the order of their names.
pub(super) struct ParameterRanges {
    /// JSON paths of the parameters in the material.
    pub(super) names: Vec<String>,
    /// Ranges of the parameters.
    pub(super) ranges: Vec<FitParameter>,
    /// Values in the given material.
    pub(super) start: Vec<f64>,
    /// Units of the parameters; empty if none or unknown.
    pub(super) units: Vec<String>,
    /// Given material.
    material: Value,
}

impl ParameterRanges {
    /// Parameters of a fit whose file has the value `material`.
    ///
    /// # Errors
    /// Parameters that are no numbers of the material or outside their range.
    pub(super) fn new(fit: &Fit, material: &Value) -> Result<Self, CaseErrors> {
        let complete = serde_json::to_value(&fit.material).unwrap_or_default();
        let schema = schemars::schema_for!(MaterialSpec).to_value();
        let mut all = Self {
            names: fit.parameters.keys().cloned().collect(),
            ranges: fit.parameters.values().copied().collect(),
            start: Vec::new(),
            units: fit.parameters.keys().map(|name| unit(&schema, fit.material.name(), name)).collect(),
            material: material.clone(),
        };
        let mut errors = Vec::new();
        for (name, range) in &fit.parameters {
            match start_value(material, &complete, name) {
                Ok(value) if (range.range[0]..=range.range[1]).contains(&value) => all.start.push(value),
                Ok(value) => {
                    let [low, high] = range.range;
                    let rule = format!("is outside the range {low} to {high} in parameters.{name}");
                    errors.push(CaseError::new(
                        format!("material.{name}"),
                        CaseErrorKind::out_of_range(value, rule),
                    ));
                }
                Err(kind) => errors.push(CaseError::new(format!("parameters.{name}"), kind)),
            }
        }
        for (number, test) in fit.tests.iter().enumerate() {
            for name in test.material.keys() {
                if let Err(kind) = start_value(material, &complete, name) {
                    errors.push(CaseError::new(format!("tests[{number}].material.{name}"), kind));
                }
            }
        }
        if errors.is_empty() { Ok(all) } else { Err(CaseErrors(errors)) }
    }

    /// Values at a point of the unit cube; the start is met to the last bit.
    pub(super) fn values(&self, point: &[f64]) -> Vec<f64> {
        let start = self.start_point();
        let value =
            |k: usize| if point[k] == start[k] { self.start[k] } else { self.ranges[k].value(point[k]) };
        (0..point.len()).map(value).collect()
    }

    /// Point of the unit cube with given values.
    pub(super) fn point(&self, values: &[f64]) -> Vec<f64> {
        self.ranges.iter().zip(values).map(|(range, value)| range.share(*value).clamp(0.0, 1.0)).collect()
    }

    /// Point of the unit cube with the start values.
    pub(super) fn start_point(&self) -> Vec<f64> {
        self.point(&self.start)
    }

    /// JSON value of the material with values of the parameters, and with those of a test in `own`.
    pub(super) fn material_value<'a>(
        &'a self,
        values: &'a [f64],
        own: impl Iterator<Item = (&'a String, &'a f64)>,
    ) -> Value {
        let mut material = self.material.clone();
        for (name, value) in self.names.iter().zip(values).chain(own) {
            // The paths have been checked.
            let _ = set_value(&mut material, name, &(*value).into());
        }
        material
    }
}

/// Start value of a parameter: a number in the material of the file, or its default.
fn start_value(material: &Value, complete: &Value, name: &str) -> Result<f64, CaseErrorKind> {
    let found = value_at(material, name).or_else(|| value_at(complete, name));
    if let Some(value) = found.and_then(Value::as_f64) {
        let mut probe = material.clone();
        return match set_value(&mut probe, name, &value.into()) {
            Ok(()) => Ok(value),
            Err(_) => Err("has no value in the material: give its start value there".into()),
        };
    }
    if found.is_some_and(Value::is_null) {
        return Err("has no value in the material: give its start value there".into());
    }
    if let Some(other) = found {
        return Err(format!("{other} in the material is not a number").into());
    }
    let (folder, key) = name.rsplit_once('.').map_or((None, name), |(folder, key)| (Some(folder), key));
    let object = folder.map_or(Some(complete), |folder| value_at(complete, folder));
    let numbers = object.and_then(Value::as_object).into_iter().flatten();
    let keys: Vec<&str> =
        numbers.filter(|(_, value)| value.is_number()).map(|(key, _)| key.as_str()).collect();
    Err(CaseErrorKind::unknown_name(key, &keys, format!("a number of the material ({})", keys.join(", "))))
}

/// Unit in brackets in the description of a parameter of a model; empty if there is none.
fn unit(schema: &Value, model: &str, path: &str) -> String {
    let variants = schema["oneOf"].as_array().into_iter().flatten();
    let is_model = |variant: &&Value| variant["properties"]["model"]["const"] == model;
    let keys = || path.split('.').map(|part| part.split('[').next().unwrap_or(part));
    let found = variants
        .into_iter()
        .find(is_model)
        .and_then(|variant| keys().try_fold(variant, |place, key| property(schema, place, key)));
    let description = found.and_then(|property| property["description"].as_str()).unwrap_or_default();
    let bracket = description.split_once('(').and_then(|(_, rest)| rest.split_once(')'));
    let unit = bracket.map_or("", |(inside, _)| inside.split(',').next().unwrap_or_default());
    let known = ["Pa", "kg", "m", "s", "J", "N"]
        .iter()
        .any(|first| unit.strip_prefix(first).is_some_and(|rest| !rest.starts_with(char::is_alphabetic)));
    if known || unit == "degrees" { unit.to_owned() } else { String::new() }
}

/// Schema of the property `key` of a schema, behind references and alternatives.
fn property<'a>(root: &'a Value, schema: &'a Value, key: &str) -> Option<&'a Value> {
    if let Some(found) = schema["properties"].get(key) {
        return Some(found);
    }
    let target = schema["$ref"].as_str().and_then(|name| name.strip_prefix("#/$defs/"));
    if let Some(found) = target.and_then(|name| property(root, root["$defs"].get(name)?, key)) {
        return Some(found);
    }
    let alternatives = ["anyOf", "oneOf", "allOf"].iter().filter_map(|kind| schema[kind].as_array());
    alternatives.flatten().find_map(|alternative| property(root, alternative, key))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_and_values_are_inverse_and_the_slope_is_their_derivative() {
        for scale in [ParameterScale::Linear, ParameterScale::Logarithmic] {
            let range = FitParameter { range: [2.0, 50.0], scale };
            for share in [0.0, 0.3, 1.0] {
                let value = range.value(share);
                assert!((range.share(value) - share).abs() < 1e-12);
                let h = 1e-6;
                let slope = (range.value((share + h).min(1.0)) - range.value((share - h).max(0.0)))
                    / ((share + h).min(1.0) - (share - h).max(0.0));
                // The one-sided difference at an end has an error of the first order.
                assert!((range.slope(value) / slope - 1.0).abs() < 1e-5);
            }
        }
        let middle = FitParameter { range: [1e4, 1e8], scale: ParameterScale::Logarithmic }.value(0.5);
        assert!((middle / 1e6 - 1.0).abs() < 1e-12, "the geometric mean");
    }

    #[test]
    fn units_of_parameters_are_those_of_their_descriptions() {
        let schema = schemars::schema_for!(MaterialSpec).to_value();
        for (model, path, expected) in [
            ("mohr-coulomb", "youngs_modulus", "Pa"),
            ("mohr-coulomb", "friction_angle", "degrees"),
            ("mohr-coulomb", "poissons_ratio", ""),
            ("mohr-coulomb", "softening.residual_cohesion", "Pa"),
            ("modified-cam-clay", "preconsolidation_pressure", "Pa"),
        ] {
            assert_eq!(unit(&schema, model, path), expected, "{model} {path}");
        }
    }
}
