//! Rejection of the bad input of `sheet: constitutive §7`, with the field named in the error. The materials are given in the
//! form of a case file. Further tests: the hypoplastic law in `hypoplasticity.rs`, bands in
//! `localisation/double_scale.rs`, the driver's control in `driver/control.rs`.

use colluvium_constitutive::basal::{BasalFlow, BasalSpec};
use colluvium_constitutive::laws::StrengthReduction;
use colluvium_constitutive::porous::Biot;
use colluvium_constitutive::{InitialCondition, Mat3, MaterialError, MaterialSpec, Motion, SymTensor};
use serde_json::{Value, json};

/// Valid parameters of each model, as in a case file.
const VALID_MATERIALS: &str = include_str!("valid_materials.json");

/// Material with valid parameters.
fn valid_material(model: &str) -> Value {
    let materials: Value = serde_json::from_str(VALID_MATERIALS).expect("the file is valid");
    materials.get(model).unwrap_or_else(|| panic!("{model} is not in the file")).clone()
}

fn spec(value: Value) -> MaterialSpec {
    serde_json::from_value(value).unwrap_or_else(|error| panic!("{error}"))
}

/// Valid material with `field` (a path with dots) set to `value`.
fn valid_material_with(model: &str, field: &str, value: f64) -> MaterialSpec {
    let mut material = valid_material(model);
    let place = format!("/{}", field.replace('.', "/"));
    match material.pointer_mut(&place) {
        Some(slot) => *slot = json!(value),
        // Key with a default.
        None => material[field] = json!(value),
    }
    spec(material)
}

/// Model, parameter, and values of it that are out of range.
const OUT_OF_RANGE: [(&str, &str, &[f64]); 64] = [
    ("mohr-coulomb", "tensile_strength", &[-1.0, 20e3]),
    ("tresca", "undrained_strength", &[0.0, -1.0]),
    ("von-mises", "cohesion", &[0.0]),
    ("von-mises", "residual_cohesion", &[30e3]),
    ("tension-cut", "tensile_strength", &[-1.0]),
    ("cfd-soil", "friction_angle", &[-1.0, 90.0]),
    ("cfd-soil", "cohesion", &[-1.0]),
    ("snow", "critical_compression", &[0.0, 1.0]),
    ("snow", "critical_stretch", &[0.0]),
    ("snow", "hardening_factor", &[-1.0]),
    ("cohesive-cam-clay", "critical_state_slope", &[0.0]),
    ("cohesive-cam-clay", "cohesion_ratio", &[-0.1]),
    ("cohesive-cam-clay", "compressive_strength", &[0.0]),
    ("cohesive-cam-clay", "hardening_factor", &[0.0]),
    ("cohesive-cam-clay", "hardening.softening_factor", &[0.0]),
    ("modified-cam-clay", "critical_state_slope", &[0.0]),
    ("modified-cam-clay", "compression_slope", &[0.05, 0.01]),
    ("modified-cam-clay", "swelling_slope", &[0.0]),
    ("modified-cam-clay", "void_ratio", &[0.0]),
    ("modified-cam-clay", "preconsolidation_pressure", &[0.0, -1.0]),
    ("original-cam-clay", "compression_slope", &[0.05]),
    ("original-cam-clay", "preconsolidation_pressure", &[0.0]),
    ("simsand", "void_ratio", &[0.0, 2.9]),
    ("simsand", "stiffness_constant", &[0.0]),
    ("simsand", "reference_void_ratio", &[0.0]),
    ("simsand", "critical_state_factor", &[0.0]),
    ("simsand", "critical_state_exponent", &[0.0]),
    ("simsand", "hardening_constant", &[0.0]),
    ("simsand", "poissons_ratio", &[0.5]),
    ("simsand", "critical_friction_angle", &[0.0, 90.0]),
    ("simsand", "atmospheric_pressure", &[0.0]),
    ("mu-i", "static_friction", &[0.0, 2.0]),
    ("mu-i", "limit_friction", &[0.3, 2.0]),
    ("mu-i", "reference_inertial_number", &[0.0]),
    ("mu-i", "grain_diameter", &[0.0]),
    ("mu-i", "grain_density", &[0.0]),
    ("mu-i", "bulk_modulus", &[0.0]),
    ("mu-i", "density", &[0.0]),
    ("mu-i", "form.max_viscosity", &[0.0]),
    ("newtonian-fluid", "viscosity", &[-1.0]),
    ("newtonian-fluid", "bulk_modulus", &[0.0]),
    ("newtonian-fluid", "cavitation_strength", &[-1.0]),
    ("bingham", "viscosity", &[-1.0]),
    ("bingham", "yield_stress", &[-1.0]),
    ("bingham", "cavitation_strength", &[-1.0]),
    ("bingham", "form.max_viscosity", &[0.5]),
    ("frictional-fluid", "friction_angle", &[-1.0, 90.0]),
    ("frictional-fluid", "cohesion", &[-1.0]),
    ("frictional-fluid", "viscosity", &[-1.0]),
    ("frictional-fluid", "cavitation_strength", &[-1.0]),
    ("pressure-dependent-elastic", "poissons_ratio", &[0.5]),
    ("pressure-dependent-elastic", "void_ratio", &[0.0]),
    ("pressure-dependent-elastic", "least_pressure", &[0.0]),
    ("pressure-dependent-elastic", "stiffness.shear_modulus", &[0.0]),
    ("pressure-dependent-elastic", "stiffness.reference_pressure", &[0.0]),
    ("pressure-dependent-elastic", "stiffness.exponent", &[-0.1, 1.1]),
    ("undrained", "fluid_bulk_modulus", &[0.0]),
    ("undrained", "porosity", &[0.0, 1.0]),
    ("undrained", "cavitation_strength", &[-1.0]),
    ("strength-reduced", "factor", &[0.0, -1.0]),
    ("strength-reduced", "material.youngs_modulus", &[0.0]),
    ("saturation-softened", "saturated_cohesion", &[-1.0, 11e3]),
    ("eigenstrain", "duration", &[0.0]),
    ("eigenstrain", "volumetric_strain", &[0.6]),
];

#[test]
fn parameters_out_of_range_are_refused_by_name() {
    let plastic = ["drucker-prager", "mohr-coulomb"];
    for model in plastic {
        spec(valid_material(model)).build().unwrap();
        for (field, values) in [
            ("friction_angle", vec![-1.0, 90.0]),
            ("dilatancy_angle", vec![31.0, -31.0, 95.0]),
            ("cohesion", vec![-1.0]),
            ("dilatancy_decay", vec![-1.0]),
            ("softening.residual_friction_angle", vec![31.0, -1.0]),
            ("softening.residual_cohesion", vec![11e3, -1.0]),
            ("softening.friction_rate", vec![-1.0]),
            ("softening.cohesion_rate", vec![-1.0]),
        ] {
            assert_refused(model, field, &values);
        }
    }
    let elastic =
        ["linear-elastic", "neo-hookean", "st-venant-kirchhoff", "fixed-corotated", "drucker-prager"];
    let solids =
        ["mohr-coulomb", "tresca", "von-mises", "tension-cut", "cfd-soil", "snow", "cohesive-cam-clay"];
    for model in elastic.into_iter().chain(solids) {
        assert_refused(model, "youngs_modulus", &[0.0, -1.0]);
        assert_refused(model, "poissons_ratio", &[-1.0, 0.5, 0.6]);
        assert_refused(model, "density", &[0.0, -1.0]);
    }
    for (model, field, values) in OUT_OF_RANGE {
        assert_refused(model, field, values);
    }
}

fn assert_refused(model: &str, field: &str, values: &[f64]) {
    spec(valid_material(model)).build().unwrap_or_else(|error| panic!("{model} itself: {error}"));
    for value in values {
        let error = valid_material_with(model, field, *value).build().err();
        let error = error.unwrap_or_else(|| panic!("{model} takes {field} = {value}")).to_string();
        let law = if field.starts_with("material.") { "mohr-coulomb" } else { model };
        let named = error.starts_with(&format!("{field}: {value}")) && error.ends_with(&format!(" ({law})"));
        assert!(named, "{model}, {field} = {value}: {error}");
    }
}

#[test]
fn parameters_without_effect_are_refused_by_name() {
    let build = |model: &str, keys: &[(&str, Value)]| {
        let mut material = valid_material(model);
        for (key, value) in keys {
            material[key] = value.clone();
        }
        spec(material).build().err().map(|error| error.to_string())
    };
    let capped = || ("form", json!({ "kind": "capped", "max_viscosity": 100.0 }));
    let modulus = || ("shear_modulus", json!(1e6));
    for model in ["bingham", "frictional-fluid"] {
        let rule = format!("shear_modulus: has no effect on a viscous form, only on viscoplastic ({model})");
        assert_eq!(build(model, &[capped(), modulus()]), Some(rule));
        assert_eq!(build(model, &[("form", json!({ "kind": "viscoplastic" })), modulus()]), None);
        assert_eq!(build(model, &[capped()]), None);
    }
    let smoothed = json!({ "kind": "smoothed", "shear_rate": 1e-3 });
    let exponential = json!({ "kind": "papanastasiou", "time": 100.0 });
    let rule = "shear_modulus: has no effect on a viscous form, only on elasto-viscoplastic (mu-i)";
    for form in [capped().1, smoothed, exponential] {
        assert_eq!(build("mu-i", &[("form", form.clone()), modulus()]), Some(rule.to_owned()));
        assert_eq!(build("mu-i", &[("form", form)]), None);
    }
    assert_eq!(build("mu-i", &[("form", json!({ "kind": "elasto-viscoplastic" })), modulus()]), None);

    let (residual, rate) = (("residual_cohesion", json!(5e3)), ("softening_rate", json!(5.0)));
    let never = "residual_cohesion: is never reached without a softening_rate (von-mises)";
    assert_eq!(build("von-mises", std::slice::from_ref(&residual)), Some(never.to_owned()));
    let nowhere = "softening_rate: needs a residual_cohesion as the end of softening (von-mises)";
    assert_eq!(build("von-mises", std::slice::from_ref(&rate)), Some(nowhere.to_owned()));
    assert_eq!(build("von-mises", &[residual, rate]), None);
}

#[test]
fn a_soil_without_strength_is_refused() {
    for model in ["drucker-prager", "mohr-coulomb", "cfd-soil"] {
        let mut value = json!({
            "model": model, "density": 2000.0, "youngs_modulus": 20e6, "poissons_ratio": 0.3, "friction_angle": 0.0
        });
        assert!(spec(value.clone()).build().err().unwrap().to_string().starts_with("cohesion: 0"), "{model}");
        value["cohesion"] = json!(1e3);
        spec(value).build().unwrap();
    }
}

#[test]
fn unusual_parameters_give_a_warning() {
    for (model, field, value) in [
        ("linear-elastic", "poissons_ratio", 0.499),
        ("mohr-coulomb", "friction_angle", 65.0),
        ("simsand", "void_ratio", 1.2),
        ("cohesive-cam-clay", "hardening.softening_factor", 3.0),
        // Sheet: snow-mpm §7.
        ("cohesive-cam-clay", "poissons_ratio", 0.46),
        ("cohesive-cam-clay", "poissons_ratio", -0.1),
        ("cohesive-cam-clay", "critical_state_slope", 3.1),
        ("cohesive-cam-clay", "cohesion_ratio", 1.1),
        ("cohesive-cam-clay", "compressive_strength", 3e6),
        ("cohesive-cam-clay", "hardening_factor", 20.0),
        ("snow", "critical_compression", 0.21),
        ("snow", "critical_stretch", 0.21),
        ("snow", "hardening_factor", 31.0),
    ] {
        assert!(
            spec(valid_material(model)).warnings().is_empty(),
            "{model}: {:?}",
            spec(valid_material(model)).warnings()
        );
        let warnings = valid_material_with(model, field, value).warnings();
        assert!(
            warnings.iter().any(|warning| warning.text.starts_with(field)),
            "{model}, {field}: {warnings:?}"
        );
    }
    let mut cone = valid_material("drucker-prager");
    cone["friction_angle"] = json!(40.0);
    assert!(spec(cone.clone()).warnings().iter().any(|warning| warning.text.starts_with("matching")));
    cone["friction_angle"] = json!(30.0);
    cone["matching"] = json!("plane-strain-associated");
    assert!(spec(cone.clone()).warnings().iter().any(|warning| warning.text.starts_with("matching")));
    let mut brittle = cone.clone();
    brittle["softening"] = json!({ "residual_friction_angle": 0.0, "residual_cohesion": 0.0, "friction_rate": 0.0, "cohesion_rate": 1e5 });
    let snaps =
        |warning: &colluvium_constitutive::Warning| warning.text.starts_with("softening.cohesion_rate");
    assert!(spec(brittle.clone()).warnings().iter().any(snaps));
    brittle["softening"]["cohesion_rate"] = json!(10.0);
    assert!(!spec(brittle).warnings().iter().any(snaps));
    assert!(spec(cone).assumes_plane_strain(), "a case in three dimensions refuses it");
    let mut dilating = valid_material("undrained");
    dilating["skeleton"] = valid_material("mohr-coulomb");
    let warnings = spec(dilating).warnings();
    assert!(warnings.iter().any(|w| w.text.starts_with("skeleton.dilatancy_angle")), "{warnings:?}");
}

#[test]
fn a_reduced_peak_below_the_residual_is_refused() {
    let soil = spec(valid_material("mohr-coulomb"));
    let reduction = StrengthReduction {
        scope: colluvium_constitutive::laws::ReductionScope::Peak,
        ..StrengthReduction::by_factor(50.0)
    };
    let error = soil.strength_reduced(&reduction).unwrap_err().to_string();
    assert!(error.starts_with("softening.residual"), "{error}");
    assert!(
        soil.strength_reduced(&StrengthReduction::by_factor(0.0))
            .unwrap_err()
            .to_string()
            .starts_with("factor: 0")
    );
}

#[test]
fn invalid_motions_are_refused() {
    let turn = Mat3::IDENTITY;
    let good = Motion::from_deformation(&turn, 1e-3, 2000.0, 0.1).unwrap();
    let scaled = |s: f64| Motion { deformation: Mat3::IDENTITY * s, ..good };
    let mut sheared = good;
    sheared.velocity_gradient_dt.0[0][1] = 3.0;
    let mut unknown = good;
    unknown.velocity_gradient_dt.0[0][0] = f64::NAN;
    let table = [
        (Motion { dt: 0.0, ..good }, "dt"),
        (Motion { dt: f64::NAN, ..good }, "dt"),
        (Motion { density: -1.0, ..good }, "density"),
        (scaled(-1.0), "inverts"),
        (scaled(f64::NAN), "inverts"),
        (scaled(1.3), "density changes"),
        (scaled(0.7), "density changes"),
    ];
    for spec in MaterialSpec::examples().into_iter().chain(MaterialSpec::wrapped_examples()) {
        let law = spec.build().unwrap();
        let start = InitialCondition { stress: SymTensor::isotropic(-50e3), density: spec.density() };
        let (stresses, states) = law.initial(&[start]).unwrap();
        let refusal = |motion: &Motion| {
            let (mut stresses, mut states) = (stresses.clone(), states.clone());
            let result = law.update(&[*motion], &mut stresses, &mut states.blocks_mut()[0]);
            result.err().map(|error| error.to_string())
        };
        for (motion, word) in &table {
            let error = refusal(motion).unwrap_or_else(|| panic!("{spec:?} takes a step without {word}"));
            assert!(error.contains(word), "{spec:?}: {error} instead of {word}");
        }
        let rate = spec.model_info().strain == "rate" && !spec.is_fluid();
        for motion in [&sheared, &unknown].into_iter().filter(|_| rate) {
            assert!(refusal(motion).is_some(), "{spec:?} takes {motion:?}");
        }
    }
}

#[test]
fn inadmissible_initial_stresses_are_refused_by_name() {
    for (model, stress) in [
        ("mohr-coulomb", SymTensor::diagonal(-50e3, -500e3, -50e3)),
        ("drucker-prager", SymTensor::isotropic(1e6)),
        ("tresca", SymTensor::diagonal(0.0, -100e3, 0.0)),
        ("tension-cut", SymTensor::isotropic(2e3)),
        ("modified-cam-clay", SymTensor::isotropic(10e3)),
        ("modified-cam-clay", SymTensor::isotropic(-130e3)),
        ("original-cam-clay", SymTensor::isotropic(-130e3)),
        ("simsand", SymTensor::isotropic(0.0)),
        ("mohr-coulomb", SymTensor::isotropic(f64::NAN)),
        ("linear-elastic", SymTensor::isotropic(f64::INFINITY)),
    ] {
        let law = spec(valid_material(model)).build().unwrap();
        let error = law.initial(&[InitialCondition { stress, density: 2000.0 }]).err();
        let error = error.unwrap_or_else(|| panic!("{model} starts from {stress:?}")).to_string();
        assert!(error.contains("initial state of") && error.contains("stress"), "{model}: {error}");
    }
}

#[test]
fn errors_of_basal_laws_and_porous_media_name_the_field() {
    for (value, field) in [
        (json!({ "model": "bingham", "yield_stress": 200.0, "viscosity": -1.0 }), "viscosity: -1"),
        (json!({ "model": "coulomb", "friction_angle": 90.0 }), "friction_angle: 90"),
        (json!({ "model": "voellmy", "friction_angle": 15.0, "turbulence": 0.0 }), "turbulence: 0"),
    ] {
        let law: BasalSpec = serde_json::from_value(value).unwrap();
        let error = law.build().err().unwrap().to_string();
        assert!(error.starts_with(field), "{error}");
    }
    let dry: BasalSpec =
        serde_json::from_value(json!({ "model": "voellmy", "friction_angle": 15.0, "turbulence": 600.0 }))
            .unwrap();
    let flow = BasalFlow { depth: 0.0, speed: 1.0, ..BasalFlow::default() };
    assert_eq!(dry.build().unwrap().shear_stress(&flow).unwrap(), 0.0, "a dry cell has no friction");
    for (result, field) in [
        (Biot::with_coefficient(1.1, 1e9, 1e9, 0.4), "biot_coefficient: 1.1"),
        (Biot::with_coefficient(1.0, 0.0, 1e9, 0.4), "grain_modulus: 0"),
        (Biot::with_coefficient(1.0, 1e9, 0.0, 0.4), "fluid_modulus: 0"),
        (Biot::with_coefficient(1.0, 1e9, 1e9, 1.0), "porosity: 1"),
    ] {
        let error = result.unwrap_err().to_string();
        assert!(error.starts_with(field), "{error}");
    }
}

/// Asserts that `result` rejects the parameter `name`.
pub fn assert_field<T>(result: Result<T, MaterialError>, name: &str) {
    match result {
        Err(MaterialError::Parameter { field, .. }) => assert_eq!(field, name),
        Err(error) => panic!("{name}: {error}"),
        Ok(_) => panic!("{name}: accepted"),
    }
}
