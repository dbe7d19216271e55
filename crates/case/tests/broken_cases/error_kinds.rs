//! Kinds of errors with their data, in cases from JSON and in cases of a program.

use std::path::Path;

use colluvium_case::description::{Body, Domain, Obstacle, ObstacleShape, ObstacleWall, Space, Stage};
use colluvium_case::{Capabilities, Case, CaseError, CaseErrorKind, Feature};
use colluvium_constitutive::{LinearElasticSpec, MaterialError, MaterialSpec};
use serde_json::{Value, json};

use super::{sound, sound_with};

/// First error of the valid case with a value at a JSON pointer.
fn error_of(pointer: &str, value: &Value) -> CaseError {
    Case::from_json(&sound_with(pointer, value).to_string()).unwrap_err().0.remove(0)
}

/// First error of a check of a case of a program.
fn error_in(case: Case) -> CaseError {
    case.checked(Path::new("")).unwrap_err().0.remove(0)
}

/// Valid case of a program.
fn program() -> Case {
    Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [1.0, 1.0]))
        .material("soil", LinearElasticSpec::new(1600.0, 1e7, 0.3))
        .body(Body::block("a", "soil", [0.0, 0.0], [0.4, 0.4]))
        .stage(Stage::new("settle", 1.0))
}

#[test]
fn unknown_keys_and_choices_have_suggestions_and_the_known_ones() {
    let CaseErrorKind::UnknownKey { suggestion, allowed } = error_of("/titel", &json!("x")).kind else {
        panic!("another kind")
    };
    assert_eq!(suggestion.as_deref(), Some("title"));
    assert!(allowed.iter().any(|key| key == "bodies"), "{allowed:?}");
    let CaseErrorKind::UnknownChoice { found, choices, suggestion } =
        error_of("/space", &json!("plane-strian")).kind
    else {
        panic!("another kind")
    };
    assert_eq!((found.as_str(), suggestion.as_deref()), ("\"plane-strian\"", Some("plane-strain")));
    assert_eq!(choices.len(), 4);
}

#[test]
fn unknown_names_have_their_suggestion_in_files_and_programs() {
    let of_file = error_of("/stages/1/remove_boundaries", &json!(["y-mim"]));
    let name = |name: &str, suggestion: Option<&str>, expected: &str| CaseErrorKind::UnknownName {
        name: name.to_owned(),
        expected: expected.to_owned(),
        suggestion: suggestion.map(str::to_owned),
    };
    assert_eq!(of_file.kind, name("y-mim", Some("y-min"), "the name of a boundary"));
    let stage = Stage { remove_bodies: vec!["c".to_owned()], ..Stage::new("go", 1.0) };
    let of_program = error_in(program().stage(stage));
    assert_eq!(of_program.path, "stages[1].remove_bodies[0]");
    assert!(matches!(of_program.kind, CaseErrorKind::UnknownName { ref name, .. } if name == "c"));
}

#[test]
fn names_of_earlier_versions_have_their_present_ones() {
    let key = error_of("/cuts", &json!([])).kind;
    assert_eq!(key, CaseErrorKind::RenamedKey { new: "removal_shapes".to_owned() });
    let choice = error_of("/materials/sand/model", &json!("other")).kind;
    let (old, new) = ("other".to_owned(), "external".to_owned());
    assert_eq!(choice, CaseErrorKind::RenamedChoice { old, new });
}

#[test]
fn missing_keys_are_named() {
    let missing = error_of("/title", &Value::Null).kind;
    assert_eq!(missing, CaseErrorKind::MissingKey { key: "title".to_owned(), choices: Vec::new() });
    let CaseErrorKind::MissingKey { key, choices } = error_of("/materials/sand/model", &Value::Null).kind
    else {
        panic!("another kind")
    };
    assert!(key == "model" && choices.iter().any(|model| model == "sand"), "{choices:?}");
}

#[test]
fn numbers_out_of_range_have_value_and_rule() {
    let of_file = error_of("/materials/sand/friction_angle", &json!(95)).kind;
    let CaseErrorKind::OutOfRange { value, rule } = of_file else { panic!("{of_file:?}") };
    assert!(value == 95.0 && rule.contains("(mohr-coulomb)"), "{rule}");
    let of_program = error_in(program().stage(Stage { damping: -0.5, ..Stage::new("go", 1.0) }));
    assert_eq!(of_program.to_string(), "stages[1].damping: -0.5 is not in 0..1 (1 excluded)");
    let rule = "is not in 0..1 (1 excluded)".to_owned();
    assert_eq!(of_program.kind, CaseErrorKind::OutOfRange { value: -0.5, rule });
}

#[test]
fn numbers_that_are_not_finite_have_a_kind_of_their_own() {
    let soil = MaterialSpec::from(LinearElasticSpec::new(1600.0, f64::NAN, 0.3));
    let of_law = error_in(program().material("soil", soil));
    assert_eq!(of_law.path, "materials.soil.youngs_modulus");
    assert!(matches!(of_law.kind, CaseErrorKind::NotFinite(_)), "{of_law:?}");
    let of_stage = error_in(program().stage(Stage::new("go", f64::INFINITY)));
    assert!(matches!(of_stage.kind, CaseErrorKind::NotFinite(_)), "{of_stage:?}");
}

#[test]
fn wrong_types_lengths_and_syntax_have_their_place() {
    let kind = error_of("/title", &json!(7)).kind;
    let (found, rule) = ("7".to_owned(), "is not of type string".to_owned());
    assert_eq!(kind, CaseErrorKind::WrongType { found, rule });
    let kind = error_of("/gravity", &json!([0, 0, -9.81])).kind;
    assert!(matches!(kind, CaseErrorKind::WrongLength { length: 3, .. }), "{kind:?}");
    let kind = Case::from_json("{\n  \"title\" }").unwrap_err().0.remove(0).kind;
    assert!(matches!(kind, CaseErrorKind::Syntax { line: 2, column: 11, .. }), "{kind:?}");
}

#[test]
fn features_that_a_method_does_not_support_are_named_with_the_method() {
    let of_file = Case::from_json(&sound().to_string()).unwrap();
    let rules = || Capabilities::for_point_methods("lbm").supports_all_of(&[Feature::Boundaries]);
    let error = rules().rejects(Feature::Loads, "lbm has no loads").check(&of_file).unwrap_err();
    let (feature, method) = (Feature::Loads, "lbm".to_owned());
    let reason = Some("lbm has no loads".to_owned());
    assert_eq!(error.kind, CaseErrorKind::NotSupported { feature, method, reason });
    let rigid = Body { rigid: true, ..Body::block("b", "soil", [0.6, 0.0], [0.8, 0.2]) };
    let of_program = program().body(rigid).checked(Path::new("")).unwrap();
    let error = rules().check(&of_program).unwrap_err();
    assert_eq!(error.to_string(), "bodies[1].rigid: is not available with lbm");
    let CaseErrorKind::NotSupported { feature: Feature::BodiesRigid, reason: None, .. } = error.kind else {
        panic!("{error:?}")
    };
}

#[test]
fn input_that_a_method_requires_is_missing_with_its_name() {
    let empty = Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [1.0, 1.0]));
    let error = Capabilities::new("lbm").check(&empty).unwrap_err();
    assert!(matches!(error.kind, CaseErrorKind::MissingInput { ref method, .. } if method == "lbm"));
}

#[test]
fn files_that_cannot_be_read_are_named() {
    let kind = Case::from_file(Path::new("none.json")).unwrap_err().0.remove(0).kind;
    assert!(matches!(kind, CaseErrorKind::Unreadable { ref file, .. } if file == Path::new("none.json")));
    let shape = ObstacleShape::Mesh { file: "none.stl".to_owned() };
    let case = program().obstacle(Obstacle::new("rock", shape, ObstacleWall::Rough));
    let error = case.placed_obstacles::<3>().map(|_| ()).unwrap_err();
    assert_eq!(error.path, "obstacles[0].shape.file");
    assert!(matches!(error.kind, CaseErrorKind::File { ref file, .. } if file == Path::new("none.stl")));
}

#[test]
fn other_errors_are_texts_and_errors_of_laws_remain_whole() {
    let twice = error_in(program().stage(Stage::new("settle", 1.0)));
    assert!(matches!(twice.kind, CaseErrorKind::Invalid { code: "duplicate-name", .. }), "{twice:?}");
    let refused = MaterialError::update("soil", "is too soft");
    let error = CaseError::of_material("materials.soil", refused.clone());
    assert_eq!(error.to_string(), "materials.soil: soil: is too soft");
    assert_eq!(error.kind, CaseErrorKind::Material(refused));
}
