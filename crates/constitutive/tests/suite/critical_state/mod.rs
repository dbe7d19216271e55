//! Pressure-dependent elasticity, the Cam-clays and SIMSAND against `sheet: constitutive §2.2, §2.6, §2.7`,
//! §3.7.5, §3.7.8, V-11, V-12 and V-18. The sheet's numbers are in kPa.

mod cam_clay;
mod initial_stress;
mod original_cam_clay;
mod pressure_elastic;
mod simsand;

use colluvium_constitutive::driver::{ElementPath, ElementTest, LoadingPath, TestStage};
use colluvium_constitutive::laws::{CamClaySpec, PressureElasticSpec, PressureStiffness};
use colluvium_constitutive::{InitialCondition, Mat3, MaterialError, MaterialSpec, Motion, SymTensor};

fn still() -> Motion {
    Motion::from_deformation(&Mat3::IDENTITY, 1.0, 2000.0, 1.0).unwrap()
}

fn start(stress: SymTensor) -> InitialCondition {
    InitialCondition { stress, density: 2000.0 }
}

/// Clay of the sheet, `p_c` in kPa.
fn clay(preconsolidation: f64) -> CamClaySpec {
    CamClaySpec {
        density: 1800.0,
        critical_state_slope: 1.0,
        compression_slope: 0.2,
        swelling_slope: 0.05,
        poissons_ratio: Some(0.3),
        shear_modulus: None,
        void_ratio: 1.0,
        preconsolidation_pressure: Some(preconsolidation * 1e3),
        overconsolidation_ratio: None,
        return_initial_stress_to_yield: false,
    }
}

/// Element test from isotropic stress (kPa).
fn test(material: MaterialSpec, pressure: f64, stages: &[(LoadingPath, usize)]) -> ElementPath {
    let stage =
        |(path, steps): &(LoadingPath, usize)| TestStage { path: path.clone(), steps: *steps, duration: 1.0 };
    let p = -pressure * 1e3;
    ElementTest {
        title: String::new(),
        material,
        initial_stress: [p, p, p, 0.0, 0.0, 0.0],
        stages: stages.iter().map(stage).collect(),
    }
    .run()
    .unwrap()
}

/// Value (kPa) of the second column where the first passes `x` (kPa), linear between rows.
fn at(run: &ElementPath, column: &str, x: f64, other: &str) -> f64 {
    let (a, b) = (run.column(column).unwrap(), run.column(other).unwrap());
    let x = x * 1e3;
    let k = (1..a.len()).find(|k| (a[k - 1] - x) * (a[*k] - x) <= 0.0).unwrap();
    let share = (x - a[k - 1]) / (a[k] - a[k - 1]);
    (b[k - 1] + share * (b[k] - b[k - 1])) / 1e3
}

fn elastic(stiffness: PressureStiffness) -> PressureElasticSpec {
    PressureElasticSpec {
        density: 1800.0,
        stiffness,
        poissons_ratio: 0.2,
        void_ratio: 0.8,
        least_pressure: None,
    }
}

const SAND: PressureStiffness =
    PressureStiffness::Sand { shear_modulus: 30e6, reference_pressure: 100e3, exponent: 0.5 };

const CLAY: PressureStiffness = PressureStiffness::Clay { swelling_slope: 0.05 };

/// Change of the parameters of a law.
type Change<T> = fn(&mut T);

/// Parameter that an error names.
fn problem_field(error: &MaterialError) -> String {
    match error.parameter_problem() {
        Some((field, _)) => field.to_owned(),
        None => panic!("{error}"),
    }
}
