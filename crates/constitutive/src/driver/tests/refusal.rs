//! A law that fails on the way is told from a stress that cannot be reached.

use super::*;
use crate::laws::Elasticity;
use crate::{Corotational, Law, Point, Pointwise, SmallStrain};

/// Linear elastic, without a solution beyond 1 % of stretch in y.
struct Stubborn(Elasticity);

impl Law for Stubborn {
    fn name(&self) -> &'static str {
        "stubborn"
    }
}

impl Pointwise for Stubborn {
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

    fn tangent(&self, _: &SymTensor, _: &Motion, _: &Point<f64>) -> Option<crate::Tangent> {
        Some(self.0.tangent())
    }
}

/// Why the path stops, and the stretch in y it reaches.
fn stopped(path: Path, steps: usize) -> (DriverError, f64) {
    let material: std::sync::Arc<dyn Material> =
        std::sync::Arc::new(Corotational(Stubborn(Elasticity::new(YOUNG, 0.3).unwrap())));
    let start = [InitialCondition { stress: SymTensor::ZERO, density: 2000.0 }];
    let (stresses, states) = material.initial(&start).unwrap();
    let mut specimen = Specimen { material, stress: stresses[0], states, density: 2000.0 };
    let mut record = Record::new(&specimen);
    let program = path.program(&specimen.stress, 1.0, None).unwrap();
    let stage = TestStage { path, steps, duration: 1.0 };
    let place = solve::Place { number: 0, stage: &stage };
    let error = solve::stage(&mut specimen, &mut record, &place, &program).unwrap_err();
    (error, record.finish(&[]).last("strain_yy"))
}

#[test]
fn a_law_that_fails_on_prescribed_strains_is_no_limit_load() {
    let strain = Path::Strain { increment: [-0.02, 0.04, 0.0, 0.0, 0.0, 0.0] };
    let shear = Path::General {
        stress: [[0.0; 6]; 6],
        strain: std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 })),
        total: [0.0, 0.02, 0.0, 0.01, 0.0, 0.0],
        amplitude: [0.0; 6],
        phase: [0.0; 6],
        spin: [0.0; 3],
        fluid_stiffness: Some(1e7),
    };
    // Stress is prescribed as well; beyond the last step that the law takes it takes no shorter one.
    let stretched = Path::Direct {
        control: [
            Controlled::Stress,
            Controlled::Strain,
            Controlled::Stress,
            Controlled::Strain,
            Controlled::Strain,
            Controlled::Strain,
        ],
        increments: vec![[0.0, 0.02, 0.0, 0.0, 0.0, 0.0]],
        spins: vec![],
    };
    for path in [strain, shear, stretched] {
        for steps in [3, 7, 10] {
            let said = format!("{path:?} in {steps}");
            let (error, reached) = stopped(path.clone(), steps);
            let DriverError::Law { source: MaterialError::Unsolved(unsolved), .. } = &error else {
                panic!("{said}: {error}");
            };
            assert_eq!((unsolved.model, unsolved.reason), ("stubborn", "too long"), "{said}");
            assert!((reached - 0.01).abs() < 1e-4, "{said}: {reached}");
        }
    }
}
