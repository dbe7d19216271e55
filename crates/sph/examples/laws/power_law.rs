//! Law of a program: a shear-thinning liquid.

use colluvium_constitutive::{
    InitialCondition, Law, MaterialError, Motion, Point, PointLaw, StressUpdate, SymTensor,
};

/// Liquid whose shear stress is a constant (Pa √s) times the root of the shear rate (1/s).
pub struct PowerLaw(pub f64);

impl Law for PowerLaw {
    fn name(&self) -> &'static str {
        "power-law"
    }
}

impl PointLaw for PowerLaw {
    /// Viscosity (Pa s) in the last step.
    type State = f64;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<f64>, MaterialError> {
        Ok(Point { stress: initial.stress, state: 0.0 })
    }

    fn wave_modulus(&self, _: &Point<f64>) -> f64 {
        1e4
    }

    fn viscosity(&self, point: &Point<f64>) -> f64 {
        point.state
    }
}

impl StressUpdate for PowerLaw {
    fn update(&self, motion: &Motion, _: &Point<f64>) -> Result<Point<f64>, MaterialError> {
        let rate = (motion.strain_increment() * (1.0 / motion.dt)).deviator();
        let viscosity = self.0 / (rate.norm() * 2f64.sqrt()).max(0.1).sqrt();
        let pressure = 1e4 * (motion.density / 1000.0 - 1.0);
        Ok(Point { stress: rate * (2.0 * viscosity) - SymTensor::isotropic(pressure), state: viscosity })
    }
}
