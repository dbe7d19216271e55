//! Radial return, common to the laws that scale the trial deviator: `σ = -p 1 + k s_tr` with
//! `s_tr = s_n + 2 G dev Δε`, where `p`, `k` and `G` are functions of the strain increment.

use crate::{SymTensor, Tangent};

/// Trial deviator of a step. Slopes are with respect to the volume compression `Δ = -tr Δε`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RadialTrial {
    /// Trial deviator `s_tr` (Pa).
    pub deviator: SymTensor,
    /// Deviatoric strain increment `dev Δε`.
    strain: SymTensor,
    /// Shear modulus `G` of the step (Pa).
    shear: f64,
    /// Slope `dG/dΔ` (Pa).
    shear_slope: f64,
}

impl RadialTrial {
    /// Trial deviator of a strain increment with the shear modulus `shear` (Pa) and its slope with the volumetric strain.
    pub(crate) fn new(stress: &SymTensor, strain: &SymTensor, shear: f64, shear_slope: f64) -> Self {
        let strain = strain.deviator();
        Self { deviator: stress.deviator() + strain * (2.0 * shear), strain, shear, shear_slope }
    }

    /// Deviatoric stress `q` of the trial (Pa).
    pub(crate) fn q(&self) -> f64 {
        (1.5 * self.deviator.dot(&self.deviator)).sqrt()
    }

    /// Derivative by the strain, of a function whose derivative by the trial deviator is `slope` (a deviator).
    pub(crate) fn slope(&self, slope: &SymTensor) -> SymTensor {
        *slope * (2.0 * self.shear) + SymTensor::isotropic(-2.0 * self.shear_slope * slope.dot(&self.strain))
    }

    /// Stress `-p 1 + keep s_tr` (Pa), where `keep` is the factor on the trial deviator.
    pub(crate) fn stress(&self, pressure: f64, keep: f64) -> SymTensor {
        self.deviator * keep + SymTensor::isotropic(-pressure)
    }

    /// Consistent tangent (Pa), from the factor `keep` on the trial deviator and the strain derivatives of pressure and `keep`.
    pub(crate) fn tangent(&self, keep: f64, pressure_slope: &SymTensor, keep_slope: &SymTensor) -> Tangent {
        let unit = SymTensor::IDENTITY;
        let mut tangent = Tangent::ZERO;
        let two_g = 2.0 * self.shear * keep;
        for i in 0..3 {
            tangent.0[i][i] = two_g;
            tangent.0[i + 3][i + 3] = 0.5 * two_g;
        }
        tangent.add_dyad(-two_g / 3.0, &unit, &unit);
        tangent.add_dyad(-2.0 * self.shear_slope * keep, &self.strain, &unit);
        tangent.add_dyad(-1.0, &unit, pressure_slope);
        tangent.add_dyad(1.0, &self.deviator, keep_slope);
        tangent
    }
}
