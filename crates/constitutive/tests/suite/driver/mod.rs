//! Element tests: paths, controlled quantities, limits, output.

mod control;
mod elastic_tangent;
mod incremental;
mod materials;
mod output;
mod refusal;

use colluvium_constitutive::MaterialSpec;
use colluvium_constitutive::driver::*;
use colluvium_constitutive::laws::{
    LinearElasticSpec, Matching, MohrCoulombSpec, NeoHookeanSpec, NewtonianFluidSpec, Softening,
    StrainMeasure, UndrainedSpec,
};

/// Set R1 of the sheet (Pa).
const YOUNG: f64 = 20e6;
const BULK: f64 = YOUNG / (3.0 * 0.4);
const SHEAR: f64 = YOUNG / 2.6;

fn elastic() -> MaterialSpec {
    MaterialSpec::LinearElastic(LinearElasticSpec {
        density: 2000.0,
        youngs_modulus: YOUNG,
        poissons_ratio: 0.3,
        strain_measure: StrainMeasure::Rate,
    })
}

fn drucker_prager(matching: Matching, dilatancy_angle: f64) -> MaterialSpec {
    MaterialSpec::DruckerPrager(crate::reference_materials::drucker_prager(1e3, matching, dilatancy_angle))
}

fn mohr_coulomb(dilatancy_angle: f64) -> MohrCoulombSpec {
    crate::reference_materials::mohr_coulomb(1e3, dilatancy_angle)
}

fn fluid() -> MaterialSpec {
    MaterialSpec::NewtonianFluid(NewtonianFluidSpec {
        density: 1000.0,
        bulk_modulus: 2e6,
        viscosity: 50.0,
        cavitation_strength: 0.0,
        equation_of_state: Default::default(),
    })
}

fn test(material: MaterialSpec, pressure: f64, paths: &[(LoadingPath, usize)]) -> ElementTest {
    let stage =
        |(path, steps): &(LoadingPath, usize)| TestStage { path: path.clone(), steps: *steps, duration: 1.0 };
    ElementTest {
        title: "test".into(),
        material,
        initial_stress: [-pressure, -pressure, -pressure, 0.0, 0.0, 0.0],
        stages: paths.iter().map(stage).collect(),
    }
}

fn general(stress: [[f64; 6]; 6], strain: [[f64; 6]; 6], total: [f64; 6]) -> LoadingPath {
    LoadingPath::General {
        stress,
        strain,
        total,
        amplitude: [0.0; 6],
        phase: [0.0; 6],
        spin: [0.0; 3],
        fluid_stiffness: None,
    }
}

/// Unit matrix times `value`.
fn unit(value: f64) -> [[f64; 6]; 6] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { value } else { 0.0 }))
}
