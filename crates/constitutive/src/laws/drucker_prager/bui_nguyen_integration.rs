//! Algorithms 1 and 2 of Bui & Nguyen 2021 (sheet: constitutive §3.6) and the correction of their drift (§2.4).
//!
//! Both evaluate the slope of the cone's strength at one point, and divide by the elastic resistance to flow less that
//! slope. Where softening is half of the resistance or more, the strength at the end of the step is poorly predicted
//! by that slope, and above the full resistance the multiplier would be negative: such a step uses the return map (§3.7.1), as does
//! one that would gain work.

use crate::laws::Elasticity;
use crate::laws::drucker_prager::{Cone, DruckerPrager, PlasticIntegration, PlasticStrain};
use crate::{MaterialError, Point, SymTensor};

/// Intersection of a step with the cone.
struct YieldIntersection {
    stress: SymTensor,
    /// Remaining strain increment.
    remaining_strain: SymTensor,
}

impl YieldIntersection {
    /// Whether the remaining step can reverse the deviator, so that the rate at its start does not predict its end.
    fn may_reverse_deviator(&self, elasticity: &Elasticity) -> bool {
        2.0 * elasticity.shear_modulus * self.remaining_strain.deviator().norm()
            > self.stress.deviator().norm()
    }
}

/// Lower bound of the plastic modulus with softening over the elastic resistance, in the algorithms of Bui & Nguyen 2021.
const MIN_PLASTIC_MODULUS_RATIO: f64 = 0.5;

/// Plastic modulus at a given `I1`: a plastic multiplier `Δλ` reduces the yield function `f` by `(elastic - softening) Δλ`.
struct PlasticModulus {
    cone: Cone,
    /// Elastic resistance to flow `G + 9 K α α_ψ` (Pa).
    elastic: f64,
    /// Softening `∂_κ f dκ/dΔλ` (Pa), subtracted from the elastic resistance; negative where the cone hardens.
    softening: f64,
}

impl PlasticModulus {
    /// Denominator of the plastic multiplier (Pa): elastic part minus softening.
    fn modulus(&self) -> f64 {
        self.elastic - self.softening
    }

    /// Whether a single slope is insufficient for the step. Written so that NaN counts as insufficient.
    fn is_unreliable(&self) -> bool {
        !(self.elastic > 0.0 && self.modulus() > MIN_PLASTIC_MODULUS_RATIO * self.elastic)
    }
}

impl DruckerPrager {
    /// Plastic modulus of the cone at a first invariant `I1` (Pa) and an equivalent plastic strain `κ`.
    fn plastic_modulus(&self, i1: f64, kappa: f64) -> PlasticModulus {
        let (k, g) = (self.elasticity.bulk_modulus, self.elasticity.shear_modulus);
        let (cone, rate) = (self.cone_at(kappa), self.cone_rate(kappa));
        PlasticModulus {
            cone,
            elastic: g + 9.0 * k * cone.friction * cone.dilatancy,
            softening: (rate.friction * i1 - rate.strength) / 3f64.sqrt(),
        }
    }

    /// Stress and multiplier of Algorithm 2 of Bui & Nguyen 2021 (sheet: constitutive §3.6) before its drift correction, by one correction
    /// with the derivatives at the trial stress. It is meaningless where softening is half of the elastic resistance to flow or more;
    /// [`SmallStrain::update`](crate::SmallStrain::update) uses the return map in such a step.
    pub fn semi_implicit_step(&self, trial: &SymTensor, kappa: f64) -> (SymTensor, f64) {
        self.corrector(trial, &self.plastic_modulus(trial.trace(), kappa))
    }

    /// Stress after one plastic correction of a trial stress (Pa), and its plastic multiplier.
    fn corrector(&self, trial: &SymTensor, resistance: &PlasticModulus) -> (SymTensor, f64) {
        let (k, g) = (self.elasticity.bulk_modulus, self.elasticity.shear_modulus);
        let cone = &resistance.cone;
        let (deviator, i1) = (trial.deviator(), trial.trace());
        let root_j2 = (0.5 * deviator.dot(&deviator)).sqrt();
        let multiplier = cone.yield_value(root_j2, i1).max(0.0) / resistance.modulus();
        let keep = if root_j2 > 0.0 { 1.0 - g * multiplier / root_j2 } else { 0.0 };
        let mean = i1 / 3.0 - 3.0 * k * cone.dilatancy * multiplier;
        (deviator * keep + SymTensor::isotropic(mean), multiplier)
    }

    /// Stress and multiplier of Algorithm 1 of Bui & Nguyen 2021 (sheet: constitutive §3.6) before its drift correction. The step is
    /// elastic up to the cone, and then follows the continuum elastoplastic stiffness (eq. 2.4). As for [`Self::semi_implicit_step`]
    /// softening must be below half of the resistance.
    pub fn explicit_step(&self, stress: &SymTensor, strain: &SymTensor, kappa: f64) -> (SymTensor, f64) {
        let trial = *stress + self.elasticity.stress(strain);
        let flown = self.yield_intersection(stress, strain, kappa).and_then(|meeting| {
            let resistance = self.plastic_modulus(meeting.stress.trace(), kappa);
            self.plastic_step(&meeting, &trial, &resistance)
        });
        flown.unwrap_or((trial, 0.0))
    }

    /// Last intersection of the elastic stress path of a step with the cone; `None` if the path stays inside.
    fn yield_intersection(
        &self,
        stress: &SymTensor,
        strain: &SymTensor,
        kappa: f64,
    ) -> Option<YieldIntersection> {
        let cone = self.cone_at(kappa);
        let value = |s: &SymTensor| cone.yield_value(s.j2().sqrt(), s.trace());
        let elastic = self.elasticity.stress(strain);
        if value(&(*stress + elastic)) <= 0.0 {
            return None;
        }
        // f is convex.
        let scale = 1e-12 * (cone.strength + stress.norm());
        let (mut low, mut high) = (0.0, 1.0);
        if value(stress) < -scale {
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if value(&(*stress + elastic * middle)) <= 0.0 { low = middle } else { high = middle }
            }
        }
        Some(YieldIntersection { stress: *stress + elastic * low, remaining_strain: *strain * (1.0 - low) })
    }

    /// Forward step with plastic flow from the intersection with the cone, and its multiplier; `None` if it starts with unloading.
    fn plastic_step(
        &self,
        from: &YieldIntersection,
        trial: &SymTensor,
        resistance: &PlasticModulus,
    ) -> Option<(SymTensor, f64)> {
        let (k, g) = (self.elasticity.bulk_modulus, self.elasticity.shear_modulus);
        let cone = &resistance.cone;
        let (deviator, root_j2) = (from.stress.deviator(), from.stress.j2().sqrt());
        let shear = if root_j2 > 0.0 { g / root_j2 * deviator.dot(&from.remaining_strain) } else { 0.0 };
        let loading = shear + 3.0 * k * cone.friction * from.remaining_strain.trace();
        if loading <= 0.0 {
            return None;
        }
        let multiplier = loading / resistance.modulus();
        let back = if root_j2 > 0.0 { deviator * (g * multiplier / root_j2) } else { SymTensor::ZERO };
        Some((*trial - back - SymTensor::isotropic(3.0 * k * cone.dilatancy * multiplier), multiplier))
    }

    /// Corrects a drift out of the cone (sheet: constitutive §2.4, Bui & Nguyen section 3.4). Tension cracking limits the mean stress to
    /// that of the apex, and stress scaling moves the deviator onto the cone.
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

    /// Updates a point by an algorithm of Bui & Nguyen 2021. Plastic strain follows the multiplier, at most that of the trial.
    pub(super) fn bui_nguyen_step(
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
        let source = match self.spec.integration {
            PlasticIntegration::Explicit => {
                let Some(meeting) = self.yield_intersection(&old.stress, strain, kappa) else {
                    return Ok(Point { stress: *trial, state: old.state });
                };
                let resistance = self.plastic_modulus(meeting.stress.trace(), kappa);
                let slope = !resistance.is_unreliable() && !meeting.may_reverse_deviator(&self.elasticity);
                slope.then(|| self.plastic_step(&meeting, trial, &resistance)).flatten()
            }
            _ => {
                let resistance = self.plastic_modulus(trial.trace(), kappa);
                (!resistance.is_unreliable()).then(|| self.corrector(trial, &resistance))
            }
        };
        let Some((stress, multiplier)) = source else { return self.closest_point(trial, old.state) };
        // Beyond the apex the deviator does not reverse.
        let largest = root_j2 / self.elasticity.shear_modulus;
        let flipped = stress.deviator().dot(&trial.deviator()) < 0.0;
        let stress = if flipped { SymTensor::isotropic(stress.trace() / 3.0) } else { stress };
        let state = PlasticStrain { deviatoric: kappa + multiplier.min(largest) / 3f64.sqrt() };
        let stress = self.without_drift(stress, state.deviatoric);
        // Strength lost within the step, where dilatancy is not.
        if self.elasticity.dissipation(trial, &stress) < 0.0 {
            return self.closest_point(trial, old.state);
        }
        Ok(Point { stress, state })
    }
}
