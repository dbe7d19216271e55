//! Parameters built in Rust are those of a case file with the required keys.

use colluvium_constitutive::laws::{BandSpec, HypoplasticParameters, PressureStiffness};
use colluvium_constitutive::{
    BinghamSpec, CamClaySpec, CfdSoilSpec, CohesiveCamClaySpec, DoubleScaleSpec, DruckerPragerSpec,
    EigenstrainSpec, ExternalSpec, FixedCorotatedSpec, FrictionalFluidSpec, HypoplasticSpec,
    LinearElasticSpec, MaterialSpec, MohrCoulombSpec, MuISpec, NeoHookeanSpec, NewtonianFluidSpec,
    OriginalCamClaySpec, PressureElasticSpec, SandSpec, SaturationSoftenedSpec, SimsandSpec, SnowSpec,
    StVenantKirchhoffSpec, StrengthReducedSpec, TensionCutSpec, TrescaSpec, UmatSpec, UndrainedSpec,
    VonMisesSpec,
};
use serde_json::{Value, json};

/// Parts of parameters that have no numbers only: a band, the constants of a hypoplastic sand, and a stiffness.
fn parts() -> (BandSpec, HypoplasticParameters, PressureStiffness) {
    let example = |model: &str| {
        let found = MaterialSpec::examples().into_iter().find(|spec| spec.name() == model).unwrap();
        serde_json::to_value(found).unwrap()
    };
    let part = |model: &str, key: &str| example(model)[key].clone();
    (
        serde_json::from_value(part("double-scale", "band")).unwrap(),
        serde_json::from_value(part("hypoplastic", "parameters")).unwrap(),
        serde_json::from_value(part("pressure-dependent-elastic", "stiffness")).unwrap(),
    )
}

/// Each model from its constructor, with the numbers 1, 2, … in the order of the arguments.
fn constructed() -> Vec<MaterialSpec> {
    let elastic = || LinearElasticSpec::new(1.0, 2.0, 3.0);
    let (band, sand, stiffness) = parts();
    vec![
        elastic().into(),
        NeoHookeanSpec::new(1.0, 2.0, 3.0).into(),
        StVenantKirchhoffSpec::new(1.0, 2.0, 3.0).into(),
        FixedCorotatedSpec::new(1.0, 2.0, 3.0).into(),
        DruckerPragerSpec::new(1.0, 2.0, 3.0, 4.0).into(),
        SandSpec::new(1.0, 2.0, 3.0, 4.0).into(),
        MohrCoulombSpec::new(1.0, 2.0, 3.0, 4.0).into(),
        TrescaSpec::new(1.0, 2.0, 3.0, 4.0).into(),
        VonMisesSpec::new(1.0, 2.0, 3.0, 4.0).into(),
        PressureElasticSpec::new(1.0, stiffness, 2.0).into(),
        CamClaySpec::new(1.0, 2.0, 3.0, 4.0, 5.0).into(),
        OriginalCamClaySpec::new(1.0, 2.0, 3.0, 4.0, 5.0).into(),
        SnowSpec::new(1.0, 2.0, 3.0).into(),
        CohesiveCamClaySpec::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0).into(),
        TensionCutSpec::new(1.0, 2.0, 3.0, 4.0).into(),
        UndrainedSpec::new(1.0, 2.0, elastic()).into(),
        EigenstrainSpec::new(1.0, 2.0, elastic()).into(),
        StrengthReducedSpec::new(1.0, elastic()).into(),
        SaturationSoftenedSpec::new(1.0, elastic()).into(),
        HypoplasticSpec::new(1.0, 2.0, sand).into(),
        SimsandSpec::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0).into(),
        UmatSpec::new(1.0, "umat.so").into(),
        DoubleScaleSpec::new(1.0, 2.0, 3.0, band).into(),
        NewtonianFluidSpec::new(1.0, 2.0).into(),
        BinghamSpec::new(1.0, 2.0, 3.0, 4.0).into(),
        FrictionalFluidSpec::new(1.0, 2.0, 3.0).into(),
        MuISpec::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0).into(),
        CfdSoilSpec::new(1.0, 2.0, 3.0, 4.0).into(),
        ExternalSpec::new(1.0, "own").into(),
    ]
}

/// Whether a file without the key `key` is the same material.
fn is_default(value: &Value, key: &str, spec: &MaterialSpec) -> bool {
    let mut without = value.clone();
    without.as_object_mut().unwrap().remove(key);
    serde_json::from_value::<MaterialSpec>(without).is_ok_and(|read| read == *spec)
}

/// All models have a constructor. A key is either required by a file, or at the default of a file.
#[test]
fn constructors_set_the_required_keys_and_the_defaults_of_a_file() {
    let all = constructed();
    let mut names: Vec<&str> = all.iter().map(MaterialSpec::name).collect();
    let mut known: Vec<&str> = MaterialSpec::MODELS.iter().map(|(name, _)| *name).collect();
    names.sort_unstable();
    known.sort_unstable();
    assert_eq!(names, known);
    for spec in &all {
        let value = serde_json::to_value(spec).unwrap();
        assert_eq!(serde_json::from_value::<MaterialSpec>(value.clone()).unwrap(), *spec);
        for key in value.as_object().unwrap().keys().filter(|key| *key != "model") {
            let mut without = value.clone();
            without.as_object_mut().unwrap().remove(key);
            let required = serde_json::from_value::<MaterialSpec>(without).is_err();
            assert!(required || is_default(&value, key, spec), "{}: {key}", spec.name());
        }
    }
}

#[test]
fn arguments_are_in_the_order_of_the_keys() {
    let simsand = SimsandSpec::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0);
    assert_eq!((simsand.poissons_ratio, simsand.hardening_constant), (5.0, 13.0));
    let granular = MuISpec::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0);
    assert_eq!((granular.static_friction, granular.reference_inertial_number), (5.0, 7.0));
    let value = serde_json::to_value(MohrCoulombSpec::new(1925.0, 1.98e6, 0.23, 31.0)).unwrap();
    assert_eq!(value["friction_angle"], json!(31.0));
}
