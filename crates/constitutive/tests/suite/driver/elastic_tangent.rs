//! Law that returns its elastic stiffness in place of its tangent, as foreign libraries often do.

use std::sync::Arc;

use colluvium_constitutive::driver::{ElementTest, LoadingPath, TestStage};
use colluvium_constitutive::{
    Corotational, Elasticity, InitialCondition, Law, MaterialError, Motion, Point, PointLaw, SmallStrain,
    StressUpdate, SymTensor, Tangent,
};
use colluvium_testkit::assert_close;

/// Bound of the stress ratio `q/p`.
const STRESS_RATIO: f64 = 0.9;

/// Sand without cohesion and dilatancy, `q ≤ M p`.
struct Sand(Elasticity);

impl Law for Sand {
    fn name(&self) -> &'static str {
        "sand"
    }
}

impl PointLaw for Sand {
    type State = ();

    fn initial(&self, initial: &InitialCondition) -> Result<Point<()>, MaterialError> {
        Ok(Point { stress: initial.stress, state: () })
    }

    fn wave_modulus(&self, _: &Point<()>) -> f64 {
        self.0.p_wave_modulus()
    }
}

impl SmallStrain for Sand {
    fn update(&self, strain: &SymTensor, _: &Motion, old: &Point<()>) -> Result<Point<()>, MaterialError> {
        let trial = old.stress + self.0.stress(strain);
        let (pressure, q) = (trial.pressure().max(0.0), trial.q());
        let share = if q > STRESS_RATIO * pressure { STRESS_RATIO * pressure / q } else { 1.0 };
        Ok(Point { stress: trial.deviator() * share - SymTensor::IDENTITY * pressure, state: () })
    }
}

/// [`Sand`] with its elastic stiffness as tangent.
struct ElasticTangent(Corotational<Sand>);

impl Law for ElasticTangent {
    fn name(&self) -> &'static str {
        "elastic-tangent"
    }
}

impl PointLaw for ElasticTangent {
    type State = ();

    fn initial(&self, initial: &InitialCondition) -> Result<Point<()>, MaterialError> {
        self.0.initial(initial)
    }

    fn wave_modulus(&self, point: &Point<()>) -> f64 {
        self.0.wave_modulus(point)
    }
}

impl StressUpdate for ElasticTangent {
    fn update(&self, motion: &Motion, old: &Point<()>) -> Result<Point<()>, MaterialError> {
        self.0.update(motion, old)
    }

    fn tangent(&self, _: &Motion, _: &Point<()>) -> Result<Tangent, MaterialError> {
        Ok(self.0.0.0.tangent())
    }
}

/// Without dilatancy the stress out of the plane is the mean of the others, so that `q = √3/2 (σ₁ - σ₃)` and `p = (σ₁ + σ₃)/2`: the
/// pressure of failure is `σ₃ (1 + M/√3) / (1 - M/√3)`.
#[test]
fn a_law_with_an_elastic_tangent_fails_at_its_strength_and_not_before() {
    let law = ElasticTangent(Corotational(Sand(Elasticity::new(2e7, 0.23).unwrap())));
    let mut test = ElementTest::of_law("elastic-tangent", 1925.0, Arc::new(law)).stage(TestStage {
        steps: 200,
        ..TestStage::new(LoadingPath::BiaxialPlaneStrain { axial_compression: 0.2 })
    });
    test.initial_stress = [-100e3, -100e3, -100e3, 0.0, 0.0, 0.0];
    let trace = test.trace().unwrap();
    assert!(trace.stop_reason.is_none(), "{:?}", trace.stop_reason);
    let ratio = STRESS_RATIO / 3f64.sqrt();
    let stress = trace.path.last_stress();
    assert_close(stress[0], -100e3, 1e-9);
    assert_close(stress[1], -100e3 * (1.0 + ratio) / (1.0 - ratio), 1e-3);
}
