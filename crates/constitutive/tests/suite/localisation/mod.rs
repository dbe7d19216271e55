//! Cohesive bands and the double-scale point: reference values of `sheet: constitutive §2.16, V-22, V-23`,
//! and bad input of §7.

mod double_scale;
mod finite_band;
mod interface_laws;
mod local_solve;

use colluvium_constitutive::laws::{BandSpec, CohesiveBandSpec, DoubleScaleSpec, Elasticity, Onset};
use colluvium_constitutive::{Motion, SymTensor, Tangent};

/// Band with `c = 4.5`, `f_t = 3` MPa, `μ = 0.6`; stiffness high enough to be negligible.
const BAND: CohesiveBandSpec = CohesiveBandSpec {
    cohesion: 4.5e6,
    tensile_strength: 3e6,
    friction_coefficient: 0.6,
    dilatancy_coefficient: 0.0,
    opening_energy: 100.0,
    sliding_energy: 1000.0,
    normal_stiffness: 1e18,
    shear_stiffness: 1e18,
};

fn spec(band: CohesiveBandSpec) -> DoubleScaleSpec {
    DoubleScaleSpec {
        density: 2400.0,
        youngs_modulus: 30e9,
        poissons_ratio: 0.0,
        outside: None,
        band: BandSpec::CohesiveFriction(band),
        onset: Onset::BandYield,
        local_solve: None,
        size: None,
        intact_reset: false,
        allow_snapback: false,
    }
}

fn stiffness(youngs_modulus: f64, poissons_ratio: f64) -> Tangent {
    Elasticity::new(youngs_modulus, poissons_ratio).unwrap().tangent()
}

fn motion(gradient: &SymTensor, size: f64) -> Motion {
    Motion::from_velocity_gradient(&gradient.to_matrix(), 1.0, 2400.0, size).unwrap()
}

const NORMAL: [f64; 3] = [0.866_025_403_784_438_6, 0.5, 0.0];
