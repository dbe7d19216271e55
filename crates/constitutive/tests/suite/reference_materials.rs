//! Materials of the reference values.

use colluvium_constitutive::laws::{DruckerPragerSpec, Elasticity, Matching, MohrCoulombSpec, StrainMeasure};

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
