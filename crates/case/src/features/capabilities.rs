//! Capabilities of a method: the features of a case that it supports, ignores with a warning, or rejects.

use std::borrow::Cow;

use crate::{Case, CaseError, RequestedFeature};

/// Inputs that a method requires of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RequiredInput {
    /// At least one body.
    pub bodies: bool,
    /// A material for each body.
    pub materials: bool,
    /// Gravity that is not zero.
    pub gravity: bool,
}

impl Default for RequiredInput {
    /// Default inputs of a method: bodies made of materials.
    fn default() -> Self {
        Self { bodies: true, materials: true, gravity: false }
    }
}

/// Answer of a method to a feature of a case.
#[derive(Clone, Debug)]
enum Capability {
    /// The method applies the feature.
    Supported,
    /// The method ignores the feature with this warning.
    IgnoredWithWarning(String),
    /// The method rejects a case with the feature, for this reason.
    Rejected(String),
}

/// Answers of a method to the features of cases: it supports a feature, ignores it with a warning, or rejects it with a reason. Features
/// without a rule are rejected.
///
/// A pattern is the name of a feature, or the start of names followed by `*`: `bodies.shape*` matches every shape with all its keys. Of
/// several matching patterns a whole name has priority over a start, then the longest pattern, then the last one.
#[derive(Clone, Debug)]
pub struct Capabilities {
    method: Cow<'static, str>,
    required_input: RequiredInput,
    rules: Vec<(Cow<'static, str>, Capability)>,
}

/// Features that the run loop handles for every method.
const HANDLED_BY_RUN: [&str; 2] = ["output*", "stages.equilibrium*"];

/// Features of bodies and stages that every method with moving points supports.
const HANDLED_BY_POINT_METHODS: [&str; 27] = [
    "bodies",
    "materials",
    "gravity",
    "space=1d",
    "space=plane-strain",
    "space=3d",
    "materials=*",
    "bodies.shape*",
    "bodies.points*",
    "bodies.sampling*",
    "bodies.velocity*",
    "bodies.stress*",
    "stages.gravity_ramp",
    "stages.reset*",
    "stages.remove_boundaries",
    "stages.remove_bodies",
    "stages.weakening*",
    "measures",
    "measures.*",
    "measures=front",
    "measures=run-out",
    "measures=profile",
    "measures=probe",
    "measures=arc-front",
    "measures=crack-tip",
    "measures=fragments",
    "measures=factor-of-safety",
];

impl Capabilities {
    /// Capabilities of a method that supports the features of the run loop only.
    #[must_use]
    pub fn new(method: impl Into<Cow<'static, str>>) -> Self {
        Self { method: method.into(), required_input: RequiredInput::default(), rules: Vec::new() }
            .supports(&HANDLED_BY_RUN)
            .rejects(
                "output.rasters*",
                "rasters over the plan are available with depth-sph and snow-mpm only",
            )
            .rejects("output.contacts", "contacts of grains are available with dem only")
    }

    /// Capabilities common to methods with moving points in one, two and three dimensions. They include shapes, points from files, initial
    /// fields, materials, removal and reset in stages, and measures of points.
    #[must_use]
    pub fn for_point_methods(method: impl Into<Cow<'static, str>>) -> Self {
        Self::new(method).supports(&HANDLED_BY_POINT_METHODS)
    }

    /// Sets the required inputs; the default is bodies with materials.
    #[must_use]
    pub fn requires(mut self, needs: RequiredInput) -> Self {
        self.required_input = needs;
        self
    }

    /// Whether the method computes stress by the laws of the materials.
    #[must_use]
    pub fn has_materials(&self) -> bool {
        self.required_input.materials
    }

    /// Adds the features that match the patterns.
    #[must_use]
    pub fn supports(mut self, patterns: &[&'static str]) -> Self {
        self.rules.extend(patterns.iter().map(|pattern| (Cow::Borrowed(*pattern), Capability::Supported)));
        self
    }

    /// Adds a rule by which matching features are ignored with a warning. `note` describes the behaviour of the method instead.
    #[must_use]
    pub fn ignores_with_warning(mut self, pattern: &'static str, note: impl Into<String>) -> Self {
        self.rules.push((Cow::Borrowed(pattern), Capability::IgnoredWithWarning(note.into())));
        self
    }

    /// Adds a rule by which matching features are rejected. `reason` names an alternative.
    #[must_use]
    pub fn rejects(mut self, pattern: &'static str, reason: impl Into<String>) -> Self {
        self.rules.push((Cow::Borrowed(pattern), Capability::Rejected(reason.into())));
        self
    }

    /// Adds the rule of [`Capabilities::rejects`] if `holds`.
    #[must_use]
    pub fn rejects_if(self, holds: bool, pattern: &'static str, reason: impl Into<String>) -> Self {
        if holds { self.rejects(pattern, reason) } else { self }
    }

    /// Returns the answer of the most specific rule that matches a feature; of equally specific rules the last one.
    fn capability(&self, name: &str) -> Option<&Capability> {
        let found =
            self.rules.iter().filter_map(|(pattern, answer)| Some((match_pattern(pattern, name)?, answer)));
        // Of equal matches the last one.
        found.max_by_key(|(fit, _)| *fit).map(|(_, answer)| answer)
    }

    /// Whether a rule matches the feature of that name.
    #[must_use]
    pub fn has_rule(&self, name: &str) -> bool {
        self.capability(name).is_some()
    }

    /// Checks the case against the capabilities of the method; returns the notes about ignored features.
    ///
    /// # Errors
    /// The first rejected feature, or the required input that the case lacks, by JSON path.
    pub fn check(&self, case: &Case) -> Result<Vec<String>, CaseError> {
        self.check_needs(case)?;
        let mut notes: Vec<String> = Vec::new();
        for RequestedFeature { name, path } in case.features() {
            match self.capability(&name) {
                Some(Capability::Supported) => {}
                Some(Capability::IgnoredWithWarning(note)) => {
                    let note = format!("{path}: {note}");
                    if !notes.contains(&note) {
                        notes.push(note);
                    }
                }
                Some(Capability::Rejected(reason)) => return Err(CaseError::new(path, reason.clone())),
                None => {
                    let what = match name.rsplit_once('=') {
                        Some((_, variant)) => format!("{variant:?} is"),
                        None => "is".to_owned(),
                    };
                    return Err(CaseError::new(path, format!("{what} not available with {}", self.method)));
                }
            }
        }
        Ok(notes)
    }

    /// Reports an error where the case lacks an input that the method requires: bodies, materials or gravity.
    fn check_needs(&self, case: &Case) -> Result<(), CaseError> {
        let lacks = |path: &str, what: &str| {
            Err(CaseError::new(path, format!("{what}, but {} needs it", self.method)))
        };
        if self.required_input.bodies && case.bodies.is_empty() {
            return lacks("bodies", "there is none");
        }
        if self.required_input.materials && case.materials.is_empty() {
            return lacks("materials", "there is none");
        }
        if self.required_input.gravity && case.gravity3() == [0.0; 3] {
            return lacks("gravity", "is zero");
        }
        Ok(())
    }
}

/// Quality of the match of a pattern with a name: whether the pattern is the whole name, and the length of the pattern. `None` without a
/// match.
fn match_pattern(pattern: &str, name: &str) -> Option<(bool, usize)> {
    match pattern.strip_suffix('*') {
        Some(beginning) => name.starts_with(beginning).then_some((false, beginning.len())),
        None => (name == pattern).then_some((true, pattern.len())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(extra: &str) -> Case {
        let text = format!(
            r#"{{ "title": "t", "space": "plane-strain", "domain": {{ "min": [0, 0], "max": [1, 1] }}, "gravity": [0, 0],
            "materials": {{ "soil": {{ "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.3 }} }},
            "bodies": [{{ "name": "b", "shape": {{ "kind": "box", "min": [0, 0], "max": [0.5, 0.5] }}, "material": "soil" }}],
            "stages": [{{ "name": "s", "duration": 1, "damping": 0.5, "rayleigh_damping": 2 }}]{extra} }}"#
        );
        serde_json::from_str(&text).unwrap()
    }

    #[test]
    fn features_that_a_method_does_not_name_are_refused_with_their_path() {
        let error = Capabilities::for_point_methods("dem")
            .supports(&["stages.damping"])
            .check(&case(""))
            .unwrap_err();
        assert_eq!(error.to_string(), "stages[0].rayleigh_damping: is not available with dem");
        let error = Capabilities::new("dem").check(&case("")).unwrap_err();
        assert_eq!(error.to_string(), "bodies[0]: is not available with dem");
    }

    #[test]
    fn ignored_features_are_listed_in_notes_with_their_path() {
        let honours = Capabilities::for_point_methods("dem")
            .ignores_with_warning("stages.*", "grains are not damped")
            .supports(&["stages.damping"]);
        let notes = honours.check(&case("")).unwrap();
        assert_eq!(notes, ["stages[0].rayleigh_damping: grains are not damped"]);
    }

    #[test]
    fn exact_feature_names_override_prefixes_and_later_entries_override_earlier_ones() {
        let all = || Capabilities::new("dem").supports(&["*"]);
        assert!(all().check(&case("")).unwrap().is_empty());
        let error = all().rejects("stages.damping", "none").supports(&["stages.damping*"]).check(&case(""));
        assert_eq!(error.unwrap_err().to_string(), "stages[0].damping: none");
        assert!(
            all().rejects("stages.damping", "none").supports(&["stages.damping"]).check(&case("")).is_ok()
        );
    }

    #[test]
    fn cases_without_required_input_of_the_method_are_refused() {
        let all = Capabilities::new("lbm").supports(&["*"]);
        let mut empty = case("");
        empty.bodies.clear();
        let error = all.clone().check(&empty).unwrap_err();
        assert_eq!(error.to_string(), "bodies: there is none, but lbm needs it");
        let none = RequiredInput { bodies: false, materials: false, gravity: false };
        assert!(all.clone().requires(none).check(&empty).is_ok());
        let error = all
            .requires(RequiredInput { gravity: true, ..RequiredInput::default() })
            .check(&case(""))
            .unwrap_err();
        assert_eq!(error.path, "gravity");
    }
}
