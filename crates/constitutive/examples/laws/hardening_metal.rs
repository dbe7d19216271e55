//! Law of a program: the von Mises criterion with linear hardening, and its closed form in compression without lateral strain.

use colluvium_constitutive::{
    Elasticity, InitialCondition, Law, MaterialError, Motion, Point, PointLaw, SmallStrain, SymTensor,
};

/// Metal with isotropic hardening; the state is the equivalent plastic strain.
#[derive(Clone, Copy)]
pub struct HardeningMetal {
    /// Elastic constants.
    pub elasticity: Elasticity,
    /// Initial yield stress (Pa).
    pub yield_stress: f64,
    /// Hardening modulus (Pa).
    pub hardening: f64,
}

impl HardeningMetal {
    /// Axial stress (Pa) at a strain beyond yield, both compression-positive: `K ε + ⅔ q` with `q = 2 G ε - 3 G κ = σ_y + H κ`.
    pub fn axial_stress(&self, strain: f64) -> f64 {
        let (bulk, shear) = (self.elasticity.bulk_modulus, self.elasticity.shear_modulus);
        let plastic = (2.0 * shear * strain - self.yield_stress) / (3.0 * shear + self.hardening);
        bulk * strain + 2.0 / 3.0 * (self.yield_stress + self.hardening * plastic)
    }
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
        let stress = trial - trial.deviator() * (3.0 * shear * plastic / q);
        Ok(Point { stress, state: old.state + plastic })
    }
}
