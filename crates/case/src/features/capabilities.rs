//! Capabilities of a method: the features of a case that it supports, ignores with a warning, or rejects.

use std::borrow::Cow;

use crate::{Case, CaseError, CaseErrorKind, Feature, RequestedFeature};
use colluvium_constitutive::Warning;

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

/// Features to which a rule applies.
#[derive(Clone, Copy, Debug)]
enum RuleScope {
    /// One feature.
    One(Feature),
    /// A feature with its variants, and all keys below it with theirs.
    AllOf(Feature),
    /// All keys below a feature, with their variants.
    KeysOf(Feature),
}

impl RuleScope {
    /// Precedence over other rules for a feature: whether the rule is for this feature alone, and the length of the name of its feature.
    /// `None` for a feature to which the rule does not apply.
    fn precedence(self, feature: Feature) -> Option<(bool, usize)> {
        match self {
            Self::One(one) => (one == feature).then(|| (true, one.name().len())),
            Self::AllOf(root) => root.contains(feature).then(|| (false, root.name().len())),
            Self::KeysOf(root) => root.has_key(feature).then(|| (false, root.name().len() + 1)),
        }
    }
}

/// Answers of a method to the features of cases: it supports a feature, ignores it with a warning, or rejects it with a reason. Features
/// without a rule are rejected.
///
/// Of several rules for a feature, one for this feature alone has priority over one for all variants and keys of a feature above it
/// (`…_all_of`), then the one with the longest name, then the last one.
#[derive(Clone, Debug)]
pub struct Capabilities {
    method: Cow<'static, str>,
    required_input: RequiredInput,
    rules: Vec<(RuleScope, Capability)>,
}

/// Features of bodies, stages and measures that every method with moving points supports.
const HANDLED_BY_POINT_METHODS: &[Feature] = &[
    Feature::Bodies,
    Feature::BodiesSamplingSeed,
    Feature::Gravity,
    Feature::SpaceOneD,
    Feature::SpacePlaneStrain,
    Feature::SpaceThreeD,
    Feature::StagesGravityRamp,
    Feature::StagesRemoveBoundaries,
    Feature::StagesRemoveBodies,
    Feature::Measures,
    Feature::MeasuresFront,
    Feature::MeasuresRunOut,
    Feature::MeasuresProfile,
    Feature::MeasuresProbe,
    Feature::MeasuresArcFront,
    Feature::MeasuresCrackTip,
    Feature::MeasuresFragments,
    Feature::MeasuresFactorOfSafety,
];

/// Features of bodies and stages that every method with moving points supports with all their variants and keys.
const HANDLED_WHOLLY_BY_POINT_METHODS: &[Feature] = &[
    Feature::Materials,
    Feature::BodiesShape,
    Feature::BodiesPoints,
    Feature::BodiesSampling,
    Feature::BodiesVelocity,
    Feature::BodiesStress,
    Feature::StagesReset,
    Feature::StagesWeakening,
];

impl Capabilities {
    /// Capabilities of a method that supports the features of the run loop only.
    #[must_use]
    pub fn new(method: impl Into<Cow<'static, str>>) -> Self {
        Self { method: method.into(), required_input: RequiredInput::default(), rules: Vec::new() }
            .supports_all_of(&[Feature::Output, Feature::StagesEquilibrium])
            .rejects_all_of(
                Feature::OutputRasters,
                "rasters over the plan are available with depth-sph and snow-mpm only",
            )
            .rejects(Feature::OutputContacts, "contacts of grains are available with dem only")
    }

    /// Capabilities common to methods with moving points in one, two and three dimensions. They include shapes, points from files, initial
    /// fields, materials, removal and reset in stages, and measures of points.
    #[must_use]
    pub fn for_point_methods(method: impl Into<Cow<'static, str>>) -> Self {
        Self::new(method)
            .supports(HANDLED_BY_POINT_METHODS)
            .supports_all_of(HANDLED_WHOLLY_BY_POINT_METHODS)
            .supports_keys_of(&[Feature::Measures])
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

    /// Adds a rule for each of several scopes by which their features are supported.
    fn with_support(mut self, scopes: impl Iterator<Item = RuleScope>) -> Self {
        self.rules.extend(scopes.map(|scope| (scope, Capability::Supported)));
        self
    }

    /// Adds a rule.
    fn with_rule(mut self, scope: RuleScope, answer: Capability) -> Self {
        self.rules.push((scope, answer));
        self
    }

    /// Adds supported features.
    #[must_use]
    pub fn supports(self, features: &[Feature]) -> Self {
        self.with_support(features.iter().copied().map(RuleScope::One))
    }

    /// Adds features that are supported with all their variants, and with all keys below them.
    #[must_use]
    pub fn supports_all_of(self, features: &[Feature]) -> Self {
        self.with_support(features.iter().copied().map(RuleScope::AllOf))
    }

    /// Adds features of which all keys are supported, but not each of their variants: a measure of a supported kind, for example, has
    /// supported keys only.
    #[must_use]
    pub fn supports_keys_of(self, features: &[Feature]) -> Self {
        self.with_support(features.iter().copied().map(RuleScope::KeysOf))
    }

    /// Adds a rule by which a feature is ignored with a warning. `note` describes the behaviour of the method instead.
    #[must_use]
    pub fn ignores_with_warning(self, feature: Feature, note: impl Into<String>) -> Self {
        self.with_rule(RuleScope::One(feature), Capability::IgnoredWithWarning(note.into()))
    }

    /// Adds the rule of [`Capabilities::ignores_with_warning`] for a feature with all its variants and all keys below it.
    #[must_use]
    pub fn ignores_all_of_with_warning(self, feature: Feature, note: impl Into<String>) -> Self {
        self.with_rule(RuleScope::AllOf(feature), Capability::IgnoredWithWarning(note.into()))
    }

    /// Adds a rule by which a feature is rejected. `reason` names an alternative.
    #[must_use]
    pub fn rejects(self, feature: Feature, reason: impl Into<String>) -> Self {
        self.with_rule(RuleScope::One(feature), Capability::Rejected(reason.into()))
    }

    /// Adds the rule of [`Capabilities::rejects`] for a feature with all its variants and all keys below it.
    #[must_use]
    pub fn rejects_all_of(self, feature: Feature, reason: impl Into<String>) -> Self {
        self.with_rule(RuleScope::AllOf(feature), Capability::Rejected(reason.into()))
    }

    /// Adds the rule of [`Capabilities::rejects`] if `holds`.
    #[must_use]
    pub fn rejects_if(self, holds: bool, feature: Feature, reason: impl Into<String>) -> Self {
        if holds { self.rejects(feature, reason) } else { self }
    }

    /// Returns the answer of the most specific rule for a feature; of equally specific rules the last one.
    fn capability(&self, feature: Feature) -> Option<&Capability> {
        let found =
            self.rules.iter().filter_map(|(scope, answer)| Some((scope.precedence(feature)?, answer)));
        // Of equal matches the last one.
        found.max_by_key(|(precedence, _)| *precedence).map(|(_, answer)| answer)
    }

    /// Whether a rule applies to a feature.
    #[must_use]
    pub fn has_rule(&self, feature: Feature) -> bool {
        self.capability(feature).is_some()
    }

    /// Checks the case against the capabilities of the method; returns the notes about ignored features.
    ///
    /// # Errors
    /// The first rejected feature, or the required input that the case lacks, by JSON path.
    pub fn check(&self, case: &Case) -> Result<Vec<Warning>, CaseError> {
        self.check_needs(case)?;
        let mut notes: Vec<Warning> = Vec::new();
        for RequestedFeature { feature, path } in case.features() {
            match self.capability(feature) {
                Some(Capability::Supported) => {}
                Some(Capability::IgnoredWithWarning(note)) => {
                    let note = Warning::new("ignored-feature", format!("{path}: {note}"));
                    if !notes.contains(&note) {
                        notes.push(note);
                    }
                }
                Some(Capability::Rejected(reason)) => {
                    return Err(self.rejection(feature, path, Some(reason.clone())));
                }
                None => return Err(self.rejection(feature, path, None)),
            }
        }
        Ok(notes)
    }

    /// Error of a feature at `path` that the method does not support, for a reason if it has a rule.
    fn rejection(&self, feature: Feature, path: String, reason: Option<String>) -> CaseError {
        let method = self.method.clone().into_owned();
        CaseError::new(path, CaseErrorKind::NotSupported { feature, method, reason })
    }

    /// Reports an error where the case lacks an input that the method requires: bodies, materials or gravity.
    fn check_needs(&self, case: &Case) -> Result<(), CaseError> {
        let lacks = |path: &str, what: &str| {
            let problem = format!("{what}, but {} needs it", self.method);
            Err(CaseError::new(path, CaseErrorKind::missing_input(&*self.method, problem)))
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
            .supports(&[Feature::StagesDamping])
            .check(&case(""))
            .unwrap_err();
        assert_eq!(error.to_string(), "stages[0].rayleigh_damping: is not available with dem");
        let error = Capabilities::new("dem").check(&case("")).unwrap_err();
        assert_eq!(error.to_string(), "bodies[0]: is not available with dem");
    }

    #[test]
    fn variants_that_a_method_does_not_name_are_refused_by_their_name() {
        let measures = r#", "measures": { "m": { "kind": "dissipation" } }"#;
        let error = damped().check(&case(measures)).unwrap_err();
        assert_eq!(error.to_string(), "measures.m: \"dissipation\" is not available with dem");
    }

    #[test]
    fn ignored_features_are_listed_in_notes_with_their_path() {
        let honours = Capabilities::for_point_methods("dem")
            .ignores_all_of_with_warning(Feature::Stages, "grains are not damped")
            .supports(&[Feature::StagesDamping]);
        let notes = honours.check(&case("")).unwrap();
        assert_eq!(
            notes,
            [Warning::new("ignored-feature", "stages[0].rayleigh_damping: grains are not damped")]
        );
    }

    #[test]
    fn rules_of_one_feature_override_those_of_all_keys_and_later_rules_override_earlier_ones() {
        assert!(damped().check(&case("")).unwrap().is_empty());
        let error = damped()
            .rejects(Feature::StagesDamping, "none")
            .supports_all_of(&[Feature::Stages, Feature::StagesDamping])
            .check(&case(""));
        assert_eq!(error.unwrap_err().to_string(), "stages[0].damping: none");
        let later = damped().rejects(Feature::StagesDamping, "none").supports(&[Feature::StagesDamping]);
        assert!(later.check(&case("")).is_ok());
    }

    #[test]
    fn rules_of_a_key_override_those_of_the_keys_above_it() {
        let rules = Capabilities::new("dem")
            .rejects_all_of(Feature::ObstaclesWall, "no walls")
            .supports_all_of(&[Feature::Obstacles])
            .supports_keys_of(&[Feature::ObstaclesWall]);
        assert!(matches!(rules.capability(Feature::ObstaclesWallRough), Some(Capability::Rejected(_))));
        assert!(matches!(rules.capability(Feature::ObstaclesWallAdhesion), Some(Capability::Supported)));
        assert!(matches!(rules.capability(Feature::ObstaclesMotion), Some(Capability::Supported)));
        assert!(!rules.has_rule(Feature::LoadsTraction));
    }

    #[test]
    fn cases_without_required_input_of_the_method_are_refused() {
        let all = damped();
        let mut empty = case("");
        empty.bodies.clear();
        let error = all.clone().check(&empty).unwrap_err();
        assert_eq!(error.to_string(), "bodies: there is none, but dem needs it");
        let none = RequiredInput { bodies: false, materials: false, gravity: false };
        assert!(all.clone().requires(none).check(&empty).is_ok());
        let error = all
            .requires(RequiredInput { gravity: true, ..RequiredInput::default() })
            .check(&case(""))
            .unwrap_err();
        assert_eq!(error.path, "gravity");
    }

    /// Capabilities of a method of points with damping in stages.
    fn damped() -> Capabilities {
        Capabilities::for_point_methods("dem")
            .supports(&[Feature::StagesDamping, Feature::StagesRayleighDamping])
    }
}
