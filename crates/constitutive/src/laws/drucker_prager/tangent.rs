//! Consistent tangents of the return (sheet: constitutive §3.10).

use super::DruckerPrager;
use crate::{SymTensor, Tangent};

impl DruckerPrager {
    /// Consistent tangent of a return to the smooth part of the cone (Pa), softening and decay of dilatancy included.
    pub(super) fn cone_tangent(
        &self,
        deviator: &SymTensor,
        root_j2: f64,
        i1: f64,
        multiplier: f64,
        kappa: f64,
    ) -> Tangent {
        let (k, g) = (self.elasticity.bulk_modulus, self.elasticity.shear_modulus);
        let kappa = kappa + multiplier / 3f64.sqrt();
        let (cone, rate) = (self.cone_at(kappa), self.cone_rate(kappa));
        let alpha = cone.friction;
        // Flow of the mean stress with the multiplier, the decay of dilatancy included.
        let psi = cone.dilatancy + rate.dilatancy * multiplier / 3f64.sqrt();
        let hardening =
            (rate.friction * (i1 - 9.0 * k * cone.dilatancy * multiplier) - rate.strength) / 3f64.sqrt();
        let modulus = g + 9.0 * k * alpha * psi - hardening;
        let theta = 1.0 - g * multiplier / root_j2;
        let n = *deviator * (1.0 / (root_j2 * 2f64.sqrt()));
        let unit = SymTensor::IDENTITY;
        let mut tangent = self.elasticity.deviatoric_tangent(theta);
        tangent.add_dyad(2.0 * g * g * (multiplier / root_j2 - 1.0 / modulus), &n, &n);
        tangent.add_dyad(-3.0 * 2f64.sqrt() * k * g * alpha / modulus, &n, &unit);
        tangent.add_dyad(-3.0 * 2f64.sqrt() * k * g * psi / modulus, &unit, &n);
        tangent.add_dyad(k * (1.0 - 9.0 * k * alpha * psi / modulus), &unit, &unit);
        tangent
    }

    /// Tangent at the apex, where only softening changes the stress.
    pub(super) fn apex_tangent(&self, deviator: &SymTensor, root_j2: f64, kappa: f64) -> Tangent {
        let mut tangent = Tangent::ZERO;
        if !self.has_constant_cone && root_j2 > 0.0 {
            let (cone, rate) = (self.cone_at(kappa), self.cone_rate(kappa));
            let slope =
                (rate.strength - cone.strength / cone.friction * rate.friction) / (3.0 * cone.friction);
            let n = *deviator * (1.0 / (root_j2 * 2f64.sqrt()));
            tangent.add_dyad(slope * (2.0 / 3.0f64).sqrt(), &SymTensor::IDENTITY, &n);
        }
        tangent
    }
}
