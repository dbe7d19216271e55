//! Common parts of the tests.

use colluvium_constitutive::MaterialError;
use colluvium_constitutive::laws::{DruckerPragerSpec, Elasticity, Matching, MohrCoulombSpec, StrainMeasure};

pub use colluvium_testkit::{assert_close, assert_near};

/// Set R1 of the constitutive sheet, in kPa.
pub fn r1() -> Elasticity {
    Elasticity::new(20_000.0, 0.3).unwrap()
}

/// Drucker–Prager cone with set R1 and a cohesion of 10 kPa, in kPa times `unit`.
pub fn drucker_prager(unit: f64, matching: Matching, dilatancy_angle: f64) -> DruckerPragerSpec {
    DruckerPragerSpec {
        density: 2.0 * unit,
        youngs_modulus: 20_000.0 * unit,
        poissons_ratio: 0.3,
        friction_angle: 30.0,
        cohesion: 10.0 * unit,
        dilatancy_angle,
        matching,
        softening: None,
        dilatancy_decay: 0.0,
        integration: Default::default(),
        strain_measure: StrainMeasure::Rate,
        return_initial_stress_to_yield: false,
    }
}

/// Mohr–Coulomb pyramid with set R1 and a cohesion of 10 kPa, in kPa times `unit`.
pub fn mohr_coulomb(unit: f64, dilatancy_angle: f64) -> MohrCoulombSpec {
    MohrCoulombSpec {
        density: 2.0 * unit,
        youngs_modulus: 20_000.0 * unit,
        poissons_ratio: 0.3,
        friction_angle: 30.0,
        cohesion: 10.0 * unit,
        dilatancy_angle,
        softening: None,
        dilatancy_decay: 0.0,
        tensile_strength: None,
        strain_measure: StrainMeasure::Rate,
        return_initial_stress_to_yield: false,
    }
}

/// Asserts that `found` agrees with `exact` to `digits` significant digits as printed: half a unit of the last one.
pub fn digits(found: f64, exact: f64, digits: i32) {
    let unit = 10f64.powi(exact.abs().log10().floor() as i32 + 1 - digits);
    assert!((found - exact).abs() <= 0.5 * unit * (1.0 + 1e-9), "{found} for {exact}");
}

/// Asserts that `result` rejects the parameter `name`.
pub fn assert_field<T>(result: Result<T, MaterialError>, name: &str) {
    match result {
        Err(MaterialError::Parameter { field, .. }) => assert_eq!(field, name),
        Err(error) => panic!("{name}: {error}"),
        Ok(_) => panic!("{name}: accepted"),
    }
}
