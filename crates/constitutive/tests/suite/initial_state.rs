//! Initial stresses outside the yield surface, returned to it where `return_initial_stress_to_yield` is set
//! (sheet: constitutive §3.11, §7).

use std::sync::Arc;

use colluvium_constitutive::laws::{Simsand, SimsandSpec};
use colluvium_constitutive::{InitialCondition, Mat3, Material, MaterialSpec, Motion, States, SymTensor};
use proptest::prelude::*;
use serde_json::{Value, json};

/// Set R1 of the sheet in kPa, with the return of the initial stress.
fn projecting(extra: &Value) -> MaterialSpec {
    let mut value = json!({ "density": 2.0, "youngs_modulus": 20e3, "poissons_ratio": 0.3, "return_initial_stress_to_yield": true });
    value.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
    serde_json::from_value(value).unwrap_or_else(|error| panic!("{error}"))
}

fn drucker_prager() -> Value {
    json!({ "model": "drucker-prager", "friction_angle": 30.0, "cohesion": 10.0, "dilatancy_angle": 10.0 })
}

fn mohr_coulomb() -> Value {
    json!({ "model": "mohr-coulomb", "friction_angle": 30.0, "cohesion": 10.0, "dilatancy_angle": 10.0 })
}

/// Text with one more key.
fn with_key(mut value: Value, key: &str, entry: Value) -> Value {
    value[key] = entry;
    value
}

fn softening() -> Value {
    json!({
        "residual_friction_angle": 20.0, "residual_cohesion": 2.0, "friction_rate": 3.0, "cohesion_rate": 5.0
    })
}

fn sand(lode_dependence: bool) -> SimsandSpec {
    SimsandSpec { lode_dependence, return_initial_stress_to_yield: true, ..SimsandSpec::bui_nguyen(0.81) }
}

/// All materials with the return of the initial stress.
fn all() -> Vec<MaterialSpec> {
    let mut all = Vec::new();
    for measure in ["rate", "hencky"] {
        let models = [
            drucker_prager(),
            with_key(drucker_prager(), "softening", softening()),
            mohr_coulomb(),
            with_key(mohr_coulomb(), "softening", softening()),
            with_key(mohr_coulomb(), "tensile_strength", json!(2.0)),
            json!({ "model": "tresca", "undrained_strength": 20.0 }),
            json!({ "model": "von-mises", "cohesion": 20.0 }),
            json!({ "model": "tension-cut", "tensile_strength": 5.0 }),
        ];
        all.extend(models.map(|model| projecting(&with_key(model, "strain_measure", json!(measure)))));
    }
    all.extend([false, true].map(|lode| MaterialSpec::Simsand(sand(lode))));
    all
}

fn start(law: &dyn Material, stress: SymTensor) -> Result<(SymTensor, States), String> {
    let (stresses, states) =
        law.initial(&[InitialCondition { stress, density: 2.0 }]).map_err(|error| error.to_string())?;
    Ok((stresses[0], states))
}

fn yield_value(law: &dyn Material, stress: SymTensor, states: &States) -> f64 {
    let mut out = [0.0];
    law.yield_values(&[stress], &states.blocks()[0], &mut out);
    out[0]
}

fn build(spec: &MaterialSpec) -> Arc<dyn Material> {
    spec.build().unwrap()
}

#[test]
fn projection_is_the_return_of_the_initial_stress() {
    // Returns of §3.7.1 to §3.7.4.
    let shear = [-100.0, -350.0, -120.0, 120.0, 40.0, 0.0];
    let tresca = json!({ "model": "tresca", "undrained_strength": 20.0 });
    let table = [
        (drucker_prager(), shear, [-131.526_843, -336.906_431, -147.957_210, 98.582_202, 32.860_734, 0.0]),
        (
            drucker_prager(),
            [60.0, 50.0, 40.0, 5.0, 0.0, 0.0],
            [17.320_508_08, 17.320_508_08, 17.320_508_08, 0.0, 0.0, 0.0],
        ),
        (
            mohr_coulomb(),
            shear,
            [-150.214_594, -337.741_476, -133.800_010, 88.636_360, 30.979_353, -8.603_396],
        ),
        (
            with_key(mohr_coulomb(), "tensile_strength", json!(2.0)),
            [20.0, -15.0, -20.0, 0.0, 0.0, 0.0],
            [2.0, -22.714_286, -27.714_286, 0.0, 0.0, 0.0],
        ),
        (tresca, [50.0, 45.0, -100.0, 0.0, 0.0, 0.0], [11.666_667, 11.666_667, -28.333_333, 0.0, 0.0, 0.0]),
    ];
    for (model, stress, exact) in table {
        for softens in [false, true] {
            // The surface at the start is that of the peak; the return of the initial stress gives no plastic strain.
            let model = match model["model"].as_str() {
                Some("tresca") => model.clone(),
                _ if softens => with_key(model.clone(), "softening", softening()),
                _ => model.clone(),
            };
            let law = build(&projecting(&model));
            let (found, states) = start(&*law, SymTensor(stress)).unwrap();
            for (found, exact) in found.0.into_iter().zip(exact) {
                assert!((found - exact).abs() < 1e-6, "{model}: {found} for {exact}");
            }
            let mut plastic = [1.0];
            law.outputs(&[found], &states.blocks()[0], &mut plastic);
            assert_eq!(plastic, [0.0], "{model}");
            let refusing =
                projecting(&with_key(model.clone(), "return_initial_stress_to_yield", json!(false)));
            let error = start(&*build(&refusing), SymTensor(stress)).unwrap_err();
            assert!(error.contains("outside the yield surface"), "{error}");
        }
    }
}

#[test]
fn a_sand_keeps_its_pressure_and_the_direction_of_its_deviator() {
    for lode in [false, true] {
        let spec = sand(lode);
        let law: Simsand = spec.law().unwrap();
        let stress = SymTensor([-50e3, -400e3, -90e3, 60e3, 0.0, 20e3]);
        let (found, states) = start(&*build(&MaterialSpec::Simsand(spec.clone())), stress).unwrap();
        let pressure = stress.pressure();
        assert!((found.pressure() - pressure).abs() < 1e-9 * pressure);
        let share = found.q() / stress.q();
        assert!(share < 1.0 && (found.deviator() - stress.deviator() * share).norm() < 1e-12 * stress.norm());
        // After a plastic shear of 1 the mobilised share is 1/(1 + k_p).
        let cosine = (3.0 * stress.lode_angle()).cos();
        let [peak, _] = law.slopes(pressure, spec.void_ratio, if lode { cosine } else { -1.0 });
        let exact = pressure * peak.value / (1.0 + spec.hardening_constant);
        assert!((found.q() - exact).abs() < 1e-9 * exact, "{} for {exact}", found.q());
        let law = build(&MaterialSpec::Simsand(spec.clone()));
        assert!(yield_value(&*law, found, &states).abs() < 1e-9 * pressure);
        let refusing = MaterialSpec::Simsand(SimsandSpec { return_initial_stress_to_yield: false, ..spec });
        assert!(start(&*build(&refusing), stress).unwrap_err().contains("not below the strength"));
        assert!(start(&*law, SymTensor::isotropic(1e3)).unwrap_err().contains("compressive"));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn projected_stress_lies_on_the_yield_surface_and_remains_in_the_first_step(
        normal in proptest::array::uniform3(-300.0..40.0f64),
        shear in proptest::array::uniform3(-150.0..150.0f64),
    ) {
        let stress = SymTensor([normal[0], normal[1], normal[2], shear[0], shear[1], shear[2]]);
        for spec in all() {
            let law = build(&spec);
            let sand = spec.name() == "simsand";
            if sand && stress.pressure() <= 1.0 {
                continue;
            }
            let stress = if sand { stress * 1e3 } else { stress };
            let (found, mut states) = start(&*law, stress).unwrap();
            let scale = stress.norm() + 1.0;
            let excess = yield_value(&*law, found, &states);
            prop_assert!(excess <= 1e-9 * scale, "{spec:?}: f = {excess}");
            if excess < -1e-6 * scale {
                prop_assert_eq!(found, stress, "an admissible stress is left alone: {:?}", spec);
            }
            let still = Motion::from_deformation(&Mat3::IDENTITY, 1e-3, 2.0, 0.1).unwrap();
            let mut after = [found];
            law.update(&[still], &mut after, &mut states.blocks_mut()[0]).unwrap();
            prop_assert!((after[0] - found).norm() <= 1e-12 * scale, "{:?}: {:?} to {:?}", spec, found, after[0]);
        }
    }
}
