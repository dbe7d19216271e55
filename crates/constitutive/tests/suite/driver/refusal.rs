//! Distinction of a law that fails during a path from a stress that cannot be reached.

use std::sync::Arc;

use super::*;
use colluvium_constitutive::laws::Elasticity;
use colluvium_constitutive::{
    Corotational, InitialCondition, Law, Material, MaterialError, MaterialFactory, Motion, Point, PointLaw,
    SmallStrain, SymTensor, Tangent, register_material,
};
use serde_json::{Map, Value, json};

/// Linear elastic law without a solution beyond 1 % of stretch in y, with the names of its outputs.
struct Stubborn(Elasticity, &'static [&'static str]);

impl Law for Stubborn {
    fn name(&self) -> &'static str {
        "stubborn"
    }

    fn output_names(&self) -> &[&'static str] {
        self.1
    }
}

impl PointLaw for Stubborn {
    type State = f64;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<f64>, MaterialError> {
        Ok(Point { stress: initial.stress, state: 0.0 })
    }

    fn wave_modulus(&self, _: &Point<f64>) -> f64 {
        self.0.p_wave_modulus()
    }
}

impl SmallStrain for Stubborn {
    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<f64>,
    ) -> Result<Point<f64>, MaterialError> {
        let stretch = old.state + strain[1];
        if stretch > 0.01 {
            return Err(MaterialError::NotConverged { model: self.name(), reason: "too long" });
        }
        Ok(Point { stress: old.stress + self.0.stress(strain), state: stretch })
    }

    fn tangent(&self, _: &SymTensor, _: &Motion, _: &Point<f64>) -> Option<Tangent> {
        Some(self.0.tangent())
    }
}

struct StubbornLaw;

impl MaterialFactory for StubbornLaw {
    fn name(&self) -> &'static str {
        "stubborn"
    }

    fn build(&self, _: f64, _: &Map<String, Value>) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(Arc::new(Corotational(Stubborn(Elasticity::new(YOUNG, 0.3)?, &[]))))
    }
}

/// Reason of the stop, and the stretch in y reached.
fn stopped(path: LoadingPath, steps: usize) -> (DriverError, f64) {
    register_material(&StubbornLaw);
    let law = json!({ "model": "external", "law": "stubborn", "density": 2000, "parameters": {} });
    let trace = test(serde_json::from_value(law).unwrap(), 0.0, &[(path, steps)]).trace().unwrap();
    (trace.stop_reason.unwrap(), trace.path.last("strain_yy"))
}

#[test]
fn a_law_that_fails_on_prescribed_strains_is_no_limit_load() {
    let strain = LoadingPath::Strain { increment: [-0.02, 0.04, 0.0, 0.0, 0.0, 0.0] };
    let shear = LoadingPath::General {
        stress: [[0.0; 6]; 6],
        strain: std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 })),
        total: [0.0, 0.02, 0.0, 0.01, 0.0, 0.0],
        amplitude: [0.0; 6],
        phase: [0.0; 6],
        spin: [0.0; 3],
        fluid_stiffness: None,
    };
    // Stress is prescribed as well; beyond the last step accepted by the law no shorter one is accepted.
    let stretched = LoadingPath::Direct {
        control: [
            ControlledQuantity::Stress,
            ControlledQuantity::Strain,
            ControlledQuantity::Stress,
            ControlledQuantity::Strain,
            ControlledQuantity::Strain,
            ControlledQuantity::Strain,
        ],
        increments: vec![[0.0, 0.02, 0.0, 0.0, 0.0, 0.0]],
        spins: vec![],
    };
    for path in [strain, shear, stretched] {
        for steps in [3, 7, 10] {
            let said = format!("{path:?} in {steps}");
            let (error, reached) = stopped(path.clone(), steps);
            let DriverError::Law { source: MaterialError::UnconvergedStep(unsolved), .. } = &error else {
                panic!("{said}: {error}");
            };
            assert_eq!((unsolved.model, unsolved.reason), ("stubborn", "too long"), "{said}");
            assert!((reached - 0.01).abs() < 1e-4, "{said}: {reached}");
        }
    }
}

#[test]
fn an_output_with_the_name_of_a_column_is_refused() {
    let run = |outputs: &'static [&'static str]| {
        let law = Stubborn(Elasticity::new(YOUNG, 0.3).unwrap(), outputs);
        let test = ElementTest::of_law("stubborn", 2000.0, Arc::new(Corotational(law)));
        let path = LoadingPath::Oedometer { axial_compression: 1e-3 };
        test.stage(TestStage::new(path)).run().map(|path| path.columns.len())
    };
    assert_eq!(run(&["stretch"]), Ok(run(&[]).unwrap() + 1));
    let refused = run(&["stretch", "work"]).unwrap_err().to_string();
    assert!(refused.contains("\"work\"") && refused.contains("rename"), "{refused}");
}
