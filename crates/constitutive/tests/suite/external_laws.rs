//! External laws registered by programs.

use std::sync::Arc;

use colluvium_constitutive::{
    InitialCondition, Material, MaterialError, MaterialFactory, MaterialSpec, SymTensor, register_material,
};
use serde_json::{Map, Value};

struct Doubled;

impl MaterialFactory for Doubled {
    fn name(&self) -> &'static str {
        "doubled"
    }
    fn build(
        &self,
        density: f64,
        parameters: &Map<String, Value>,
    ) -> Result<Arc<dyn Material>, MaterialError> {
        let modulus = parameters.get("modulus").and_then(Value::as_f64).unwrap_or(0.0);
        let spec = serde_json::json!({
            "model": "linear-elastic", "density": density, "youngs_modulus": 2.0 * modulus, "poissons_ratio": 0.0
        });
        serde_json::from_value::<MaterialSpec>(spec).unwrap().build()
    }
}

#[test]
fn external_laws_are_found_by_name_and_inside_wrappers() {
    register_material(&Doubled);
    let read = |text: &str| serde_json::from_str::<MaterialSpec>(text).unwrap().build();
    let other = r#"{"model": "external", "law": "doubled", "density": 2000, "parameters": {"modulus": 5e6}}"#;
    let law = read(other).unwrap();
    let start = InitialCondition { stress: SymTensor::ZERO, density: 2000.0 };
    let (stress, states) = law.initial(&[start]).unwrap();
    let mut modulus = [0.0];
    law.wave_moduli(&stress, &states.blocks()[0], &mut modulus);
    assert!((modulus[0] / 10e6 - 1.0).abs() < 1e-12);
    let nested = format!(
        r#"{{"model": "eigenstrain", "material": {other}, "volumetric_strain": 0.1, "duration": 1}}"#
    );
    assert_eq!(read(&nested).unwrap().name(), "eigenstrain");
    let wrong = read(&other.replace("doubled\"", "tripled\"")).map(|_| ()).unwrap_err().to_string();
    assert!(wrong.starts_with("law: the law \"tripled\" is not available here; there is "), "{wrong}");
    assert!(wrong.contains("doubled"), "{wrong}");
    let wrong = read(&other.replace("5e6", "-1")).map(|_| ()).unwrap_err().to_string();
    assert!(wrong.starts_with("parameters.youngs_modulus: -2"), "{wrong}");
}
