//! Points in batches.

use colluvium_constitutive::laws::{Elasticity, LinearElastic, LinearElasticSpec, StrainMeasure};
use colluvium_constitutive::{
    Corotational, InitialCondition, Mat3, MaterialSpec, Motion, Point, StressUpdate, SymTensor,
};
use proptest::prelude::*;

proptest! {
    #[test]
    fn batched_stress_rotation_equals_that_of_a_single_point(entries in proptest::array::uniform9(-0.3..0.3f64)) {
        let law = LinearElastic { elasticity: Elasticity::new(1e6, 0.3).unwrap() };
        let gradient = Mat3(*entries.as_chunks::<3>().0.first_chunk::<3>().unwrap());
        let motion = Motion::from_velocity_gradient(&gradient, 1.0, 1.0, 1.0).unwrap();
        let stress = SymTensor([-3.0, 2.0, 0.5, 1.0, -1.5, 0.1]);
        let alone = StressUpdate::update(&Corotational(law), &motion, &Point { stress, state: () });
        let spec = MaterialSpec::LinearElastic(LinearElasticSpec {
            density: 1.0,
            youngs_modulus: 1e6,
            poissons_ratio: 0.3,
            strain_measure: StrainMeasure::Rate,
        });
        let built = spec.build().unwrap();
        let start = InitialCondition { stress, density: 1.0 };
        let (mut stresses, mut states) = built.initial(&[start]).unwrap();
        if let Ok(alone) = alone && (0.5..2.0).contains(&motion.deformation.determinant()) {
            built.update(&[motion], &mut stresses, &mut states.blocks_mut()[0]).unwrap();
            prop_assert_eq!(alone.stress, stresses[0]);
        }
    }
}
