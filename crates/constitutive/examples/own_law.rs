//! Law of the program's own: the von Mises criterion with linear hardening, in the element driver, against its closed form.

use std::sync::Arc;

use colluvium_constitutive::driver::{ElementTest, LoadingPath, TestStage};
use colluvium_constitutive::{
    Corotational, Elasticity, InitialCondition, Law, MaterialError, Motion, Point, PointLaw, SmallStrain,
    SymTensor,
};

/// Elasticity, yield stress (Pa) and hardening modulus (Pa); the state is the equivalent plastic strain.
struct HardeningMetal {
    elasticity: Elasticity,
    yield_stress: f64,
    hardening: f64,
}

impl Law for HardeningMetal {
    fn name(&self) -> &'static str {
        "hardening-metal"
    }
}

impl PointLaw for HardeningMetal {
    type State = f64;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<f64>, MaterialError> {
        Ok(Point { stress: initial.stress, state: 0.0 })
    }

    fn wave_modulus(&self, _point: &Point<f64>) -> f64 {
        self.elasticity.p_wave_modulus()
    }
}

impl SmallStrain for HardeningMetal {
    fn update(&self, strain: &SymTensor, _: &Motion, old: &Point<f64>) -> Result<Point<f64>, MaterialError> {
        let trial = old.stress + self.elasticity.stress(strain);
        let (q, shear) = (trial.q(), self.elasticity.shear_modulus);
        let excess = q - self.yield_stress - self.hardening * old.state;
        if excess <= 0.0 {
            return Ok(Point { stress: trial, state: old.state });
        }
        // Radial return: the deviator shrinks by 3 G Δκ, and the yield stress grows by H Δκ.
        let plastic = excess / (3.0 * shear + self.hardening);
        Ok(Point {
            stress: trial - trial.deviator() * (3.0 * shear * plastic / q),
            state: old.state + plastic,
        })
    }
}

/// Compresses a point without lateral strain, and compares the axial stress with `K ε + ⅔ q`.
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (strain, yield_stress, hardening) = (0.02, 1e5, 1e6);
    let elasticity = Elasticity::new(1e7, 0.3)?;
    let (bulk, shear) = (elasticity.bulk_modulus, elasticity.shear_modulus);
    let law = Arc::new(Corotational(HardeningMetal { elasticity, yield_stress, hardening }));
    let test = ElementTest::of_law("hardening-metal", 2000.0, law)
        .stage(TestStage::new(LoadingPath::Oedometer { axial_compression: strain }));
    let axial = -test.run()?.last_stress()[2];
    // q = 2 G ε - 3 G κ = σ_y + H κ.
    let kappa = (2.0 * shear * strain - yield_stress) / (3.0 * shear + hardening);
    let exact = bulk * strain + 2.0 / 3.0 * (yield_stress + hardening * kappa);
    println!("axial stress {axial:.0} Pa, closed form {exact:.0} Pa");
    Ok(())
}
