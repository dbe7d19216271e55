//! Algorithms 1 and 2 of Bui & Nguyen 2021 (sheet §3.6) and the correction of their drift (§2.4).

use super::{DruckerPrager, Integration, PlasticStrain};
use crate::{MaterialError, Point, SymTensor};

impl DruckerPrager {
    /// Algorithm 2 of Bui & Nguyen 2021 (sheet §3.6) before its drift is taken back: the stress after one
    /// corrector with the slopes at the trial, and the multiplier.
    pub fn corrected(&self, trial: &SymTensor, kappa: f64) -> (SymTensor, f64) {
        let (k, g) = (self.elasticity.bulk_modulus, self.elasticity.shear_modulus);
        let (cone, rate) = (self.cone_at(kappa), self.cone_rate(kappa));
        let (deviator, i1) = (trial.deviator(), trial.trace());
        let root_j2 = (0.5 * deviator.dot(&deviator)).sqrt();
        let hardening = (rate.friction * i1 - rate.strength) / 3f64.sqrt();
        let modulus = g + 9.0 * k * cone.friction * cone.dilatancy - hardening;
        let multiplier = cone.yield_value(root_j2, i1).max(0.0) / modulus;
        let keep = if root_j2 > 0.0 { 1.0 - g * multiplier / root_j2 } else { 0.0 };
        let mean = i1 / 3.0 - 3.0 * k * cone.dilatancy * multiplier;
        (deviator * keep + SymTensor::isotropic(mean), multiplier)
    }

    /// Algorithm 1 of Bui & Nguyen 2021 (sheet §3.6) before its drift is taken back: from `stress` inside
    /// or on the cone by the strain increment `strain`, elastic up to the cone, then with the continuum
    /// elastoplastic stiffness (eq. 2.4) there. Returns the stress and the multiplier.
    pub fn forward(&self, stress: &SymTensor, strain: &SymTensor, kappa: f64) -> (SymTensor, f64) {
        let (k, g) = (self.elasticity.bulk_modulus, self.elasticity.shear_modulus);
        let (cone, rate) = (self.cone_at(kappa), self.cone_rate(kappa));
        let value = |s: &SymTensor| cone.yield_value(s.j2().sqrt(), s.trace());
        let elastic = self.elasticity.stress(strain);
        let trial = *stress + elastic;
        if value(&trial) <= 0.0 {
            return (trial, 0.0);
        }
        // The share of the step up to the cone, where the trial leaves it for good: f is convex.
        let scale = 1e-12 * (cone.strength + stress.norm());
        let (mut low, mut high) = (0.0, 1.0);
        if value(stress) < -scale {
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if value(&(*stress + elastic * middle)) <= 0.0 { low = middle } else { high = middle }
            }
        }
        let meeting = *stress + elastic * low;
        let (deviator, root_j2) = (meeting.deviator(), meeting.j2().sqrt());
        let rest = *strain * (1.0 - low);
        let shear = if root_j2 > 0.0 { g / root_j2 * deviator.dot(&rest) } else { 0.0 };
        let loading = shear + 3.0 * k * cone.friction * rest.trace();
        if loading <= 0.0 {
            return (trial, 0.0);
        }
        let hardening = (rate.friction * meeting.trace() - rate.strength) / 3f64.sqrt();
        let multiplier = loading / (g + 9.0 * k * cone.friction * cone.dilatancy - hardening);
        let back = if root_j2 > 0.0 { deviator * (g * multiplier / root_j2) } else { SymTensor::ZERO };
        (trial - back - SymTensor::isotropic(3.0 * k * cone.dilatancy * multiplier), multiplier)
    }

    /// Takes back drift out of the cone (sheet §2.4, Bui & Nguyen section 3.4): tension cracking moves the
    /// mean stress to the apex at most, stress scaling the deviator onto the cone.
    pub fn without_drift(&self, stress: SymTensor, kappa: f64) -> SymTensor {
        let cone = self.cone_at(kappa);
        let (deviator, mut i1) = (stress.deviator(), stress.trace());
        if cone.friction > 0.0 {
            i1 = i1.min(cone.strength / cone.friction);
        }
        let (root_j2, limit) =
            ((0.5 * deviator.dot(&deviator)).sqrt(), (cone.strength - cone.friction * i1).max(0.0));
        let keep = if root_j2 > limit { limit / root_j2 } else { 1.0 };
        deviator * keep + SymTensor::isotropic(i1 / 3.0)
    }

    /// One step by an algorithm of the source. Plastic strain follows the multiplier, at most what the
    /// trial has to give.
    pub(super) fn step_of_source(
        &self,
        strain: &SymTensor,
        trial: &SymTensor,
        old: &Point<PlasticStrain>,
    ) -> Result<Point<PlasticStrain>, MaterialError> {
        let kappa = old.state.deviatoric;
        let root_j2 = trial.j2().sqrt();
        if !root_j2.is_finite() {
            return Err(MaterialError::Motion { model: self.name, reason: "the trial stress is not finite" });
        }
        let (stress, multiplier) = match self.spec.integration {
            Integration::Explicit => self.forward(&old.stress, strain, kappa),
            _ => self.corrected(trial, kappa),
        };
        // Past the apex the deviator does not turn over.
        let most = root_j2 / self.elasticity.shear_modulus;
        let flipped = stress.deviator().dot(&trial.deviator()) < 0.0;
        let stress = if flipped { SymTensor::isotropic(stress.trace() / 3.0) } else { stress };
        let state = PlasticStrain { deviatoric: kappa + multiplier.min(most) / 3f64.sqrt() };
        Ok(Point { stress: self.without_drift(stress, state.deviatoric), state })
    }
}
