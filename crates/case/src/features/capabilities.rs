//! What a method says to the features of a case.

use std::borrow::Cow;

use crate::{Case, CaseError, RequestedFeature};

/// What a method needs of a case to have a problem at all.
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
    /// Bodies made of materials.
    fn default() -> Self {
        Self { bodies: true, materials: true, gravity: false }
    }
}

#[derive(Clone, Debug)]
enum Capability {
    Supported,
    IgnoredWithWarning(String),
    Rejected(String),
}

/// What a method says to features: it takes them, passes them over with a note, or refuses them with a reason. What it does
/// not name it refuses.
///
/// A pattern is the name of a feature, or the beginning of names with a `*` behind it: `bodies.shape*` is every shape with all
/// that it consists of. Of several patterns that fit, a whole name counts before a beginning, then the longest, then the last.
#[derive(Clone, Debug)]
pub struct Capabilities {
    method: Cow<'static, str>,
    needs: RequiredInput,
    rules: Vec<(Cow<'static, str>, Capability)>,
}

/// What the run loop sees to, whatever the method.
const HANDLED_BY_RUN: [&str; 2] = ["output*", "stages.equilibrium*"];

/// What holds of bodies and stages for every method that moves points.
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
    /// A method that takes what the run loop sees to, and nothing else.
    #[must_use]
    pub fn new(method: impl Into<Cow<'static, str>>) -> Self {
        Self { method: method.into(), needs: RequiredInput::default(), rules: Vec::new() }
            .supports(&HANDLED_BY_RUN)
            .rejects("output.rasters*", "rasters over the plan are those of depth-sph and snow-mpm")
            .rejects("output.contacts", "only grains (dem) have contacts to write")
    }

    /// A method that moves points of bodies in one, two and three dimensions: it takes shapes, points from files, initial
    /// fields, materials and their weakening, what stages remove and reset, and the measures of points.
    #[must_use]
    pub fn for_point_methods(method: impl Into<Cow<'static, str>>) -> Self {
        Self::new(method).supports(&HANDLED_BY_POINT_METHODS)
    }

    /// What it needs; bodies with materials when not said.
    #[must_use]
    pub fn requires(mut self, needs: RequiredInput) -> Self {
        self.needs = needs;
        self
    }

    /// Whether it computes stress by the laws of the materials.
    #[must_use]
    pub fn has_materials(&self) -> bool {
        self.needs.materials
    }

    /// Takes the features that fit the patterns.
    #[must_use]
    pub fn supports(mut self, patterns: &[&'static str]) -> Self {
        self.rules.extend(patterns.iter().map(|pattern| (Cow::Borrowed(*pattern), Capability::Supported)));
        self
    }

    /// Goes on without the features that fit, and says so in a warning: the note says what happens instead.
    #[must_use]
    pub fn ignores_with_warning(mut self, pattern: &'static str, note: impl Into<String>) -> Self {
        self.rules.push((Cow::Borrowed(pattern), Capability::IgnoredWithWarning(note.into())));
        self
    }

    /// Refuses the features that fit, for a reason that names what to do instead.
    #[must_use]
    pub fn rejects(mut self, pattern: &'static str, reason: impl Into<String>) -> Self {
        self.rules.push((Cow::Borrowed(pattern), Capability::Rejected(reason.into())));
        self
    }

    /// As [`Capabilities::rejects`], where `holds`.
    #[must_use]
    pub fn rejects_if(self, holds: bool, pattern: &'static str, reason: impl Into<String>) -> Self {
        if holds { self.rejects(pattern, reason) } else { self }
    }

    fn capability(&self, name: &str) -> Option<&Capability> {
        let found =
            self.rules.iter().filter_map(|(pattern, answer)| Some((match_pattern(pattern, name)?, answer)));
        // Of equals the last.
        found.max_by_key(|(fit, _)| *fit).map(|(_, answer)| answer)
    }

    /// Whether a rule speaks of the feature of that name, in whatever way.
    #[must_use]
    pub fn has_rule(&self, name: &str) -> bool {
        self.capability(name).is_some()
    }

    /// Holds the case against what the method honours; the notes of what it passes over.
    ///
    /// # Errors
    /// The first feature that it refuses, or what it needs and the case lacks, by JSON path.
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

    fn check_needs(&self, case: &Case) -> Result<(), CaseError> {
        let lacks = |path: &str, what: &str| {
            Err(CaseError::new(path, format!("{what}, and {} needs it", self.method)))
        };
        if self.needs.bodies && case.bodies.is_empty() {
            return lacks("bodies", "there is none");
        }
        if self.needs.materials && case.materials.is_empty() {
            return lacks("materials", "there is none");
        }
        if self.needs.gravity && case.gravity3() == [0.0; 3] {
            return lacks("gravity", "is zero");
        }
        Ok(())
    }
}

/// How closely a pattern fits a name: whether it is the whole of it, and how much of it it says; `None` where it does not fit.
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
    fn what_a_method_does_not_name_is_refused_with_its_place() {
        let error = Capabilities::for_point_methods("dem")
            .supports(&["stages.damping"])
            .check(&case(""))
            .unwrap_err();
        assert_eq!(error.to_string(), "stages[0].rayleigh_damping: is not available with dem");
        let error = Capabilities::new("dem").check(&case("")).unwrap_err();
        assert_eq!(error.to_string(), "bodies[0]: is not available with dem");
    }

    #[test]
    fn what_is_passed_over_is_told() {
        let honours = Capabilities::for_point_methods("dem")
            .ignores_with_warning("stages.*", "grains are not damped")
            .supports(&["stages.damping"]);
        let notes = honours.check(&case("")).unwrap();
        assert_eq!(notes, ["stages[0].rayleigh_damping: grains are not damped"]);
    }

    #[test]
    fn a_whole_name_counts_before_a_beginning_and_the_last_of_equals() {
        let all = || Capabilities::new("dem").supports(&["*"]);
        assert!(all().check(&case("")).unwrap().is_empty());
        let error = all().rejects("stages.damping", "none").supports(&["stages.damping*"]).check(&case(""));
        assert_eq!(error.unwrap_err().to_string(), "stages[0].damping: none");
        assert!(
            all().rejects("stages.damping", "none").supports(&["stages.damping"]).check(&case("")).is_ok()
        );
    }

    #[test]
    fn a_case_without_what_the_method_needs_is_refused() {
        let all = Capabilities::new("lbm").supports(&["*"]);
        let mut empty = case("");
        empty.bodies.clear();
        let error = all.clone().check(&empty).unwrap_err();
        assert_eq!(error.to_string(), "bodies: there is none, and lbm needs it");
        let none = RequiredInput { bodies: false, materials: false, gravity: false };
        assert!(all.clone().requires(none).check(&empty).is_ok());
        let error = all
            .requires(RequiredInput { gravity: true, ..RequiredInput::default() })
            .check(&case(""))
            .unwrap_err();
        assert_eq!(error.path, "gravity");
    }
}
