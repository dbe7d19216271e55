//! Drucker–Prager plasticity (sheet: constitutive §2.4, §3.7.1; Bui & Nguyen 2021, eqs. 74–80).
//!
//! `f = √J2 + α I1 - k ≤ 0`, `g = √J2 + α_ψ I1`; elastic law linear. Cohesion and friction angle
//! may soften exponentially with the accumulated deviatoric plastic strain `κ`, the dilatancy angle
//! may decay with it. The return is fully implicit, on the smooth cone or to its apex; without
//! cohesion the apex is the stress-free state. The strength depends on the matching of the cone to
//! Mohr–Coulomb: see [`Matching`]. Limits: softening has no internal length (mesh-dependent bands).

mod bui_nguyen_integration;
mod cone;
mod parameters;
mod return_map;
mod softening;
mod tangent;

use serde::{Deserialize, Serialize};

use super::Elasticity;
use crate::adapters::hencky::SimdBatch;
use crate::contract::component_arrays::ComponentArrays;
use crate::{
    BLOCK_SIZE, InitialCondition, Law, MaterialError, Motion, Point, PointLaw, PrincipalReturn, SmallStrain,
    SymTensor, Tangent,
};

use return_map::{ConeReturn, StressInvariantValues};

pub use cone::Cone;
pub use parameters::{DruckerPragerSpec, Matching, PlasticIntegration};
pub use softening::Softening;

/// Value of the key `model` in case files.
const NAME: &str = "drucker-prager";

/// Drucker–Prager law. See the module's head for source and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct DruckerPrager {
    name: &'static str,
    elasticity: Elasticity,
    spec: DruckerPragerSpec,
    has_constant_cone: bool,
    peak: Cone,
    /// Inverse plastic modulus `1/(G + 9 K α α_ψ)` of the peak (1/Pa).
    inverse_plastic_modulus: f64,
}

/// Internal variable: accumulated deviatoric plastic strain `κ`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlasticStrain {
    /// Deviatoric plastic strain `κ = ∫ √(2/3 dε^p : dε^p)`.
    pub deviatoric: f64,
}

/// Names of the output scalars of laws whose state is a [`PlasticStrain`].
pub(in crate::laws) const OUTPUTS: &[&str] = &["plastic_strain"];

impl PlasticStrain {
    /// Writes the equivalent plastic strain to `out`.
    pub(in crate::laws) fn outputs(self, out: &mut [f64]) {
        out[0] = self.deviatoric;
    }
}

impl DruckerPrager {
    /// Returns the law under another name, for models that are a special case of it.
    pub(in crate::laws) fn with_name(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// Returns the law with peak and residual cohesion multiplied by `share`.
    pub(super) fn scaled_cohesion(&self, share: f64) -> Self {
        let mut law = self.clone();
        law.spec.cohesion *= share;
        law.spec.softening = law.spec.softening.map(|s| s.scaled_cohesion(share));
        law.peak = law.softened_cone(0.0);
        law
    }

    /// Returns the trial stresses of a batch by a law with softening or hardening.
    #[inline(never)]
    fn return_batch_to_changing_cone<const N: usize>(
        &self,
        few: &mut SimdBatch<N>,
        states: &mut [PlasticStrain; N],
    ) {
        for i in 0..N {
            let trial = few.stress_of(i);
            match self.closest_point(&trial, states[i]) {
                Ok(Point { stress, .. }) if stress == trial => {}
                Ok(Point { stress, state }) => {
                    few.set_stress(i, &stress);
                    (few.is_yielding[i], states[i]) = (1.0, state);
                }
                Err(_) => few.fallback[i] = 1.0,
            }
        }
    }

    /// Updates a point of a law with softening or hardening, or by an algorithm of Bui & Nguyen 2021.
    #[inline(never)]
    fn step_with_changing_cone(
        &self,
        strain: &SymTensor,
        trial: &SymTensor,
        old: &Point<PlasticStrain>,
    ) -> Result<Point<PlasticStrain>, MaterialError> {
        if self.spec.integration != PlasticIntegration::ClosestPoint {
            return self.bui_nguyen_step(strain, trial, old);
        }
        self.closest_point(trial, old.state)
    }
}

impl Law for DruckerPrager {
    fn name(&self) -> &'static str {
        self.name
    }

    fn output_names(&self) -> &[&'static str] {
        OUTPUTS
    }
}

impl PointLaw for DruckerPrager {
    type State = PlasticStrain;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<PlasticStrain>, MaterialError> {
        let stress = initial.stress;
        if self.spec.return_initial_stress_to_yield && stress.is_finite() {
            let invariants = StressInvariantValues::from_stress(&stress);
            let end = self.peak_return(&invariants)?;
            let stress = self.state_after_return(&stress, &invariants, &end, PlasticStrain::default()).stress;
            return Ok(Point { stress, state: PlasticStrain::default() });
        }
        let excess = self.peak.yield_value(stress.j2().sqrt(), stress.trace());
        let scale = self.peak.strength + self.peak.friction * stress.trace().abs();
        super::check_initial(self.name, &stress, excess, scale)?;
        Ok(Point { stress, state: PlasticStrain::default() })
    }

    fn wave_modulus(&self, _point: &Point<PlasticStrain>) -> f64 {
        self.elasticity.p_wave_modulus()
    }

    fn yield_value(&self, point: &Point<PlasticStrain>) -> Option<f64> {
        let cone = self.cone_at(point.state.deviatoric);
        Some(cone.yield_value(point.stress.j2().sqrt(), point.stress.trace()))
    }

    fn linear_elasticity(&self) -> Option<&Elasticity> {
        Some(&self.elasticity)
    }

    fn outputs(&self, point: &Point<PlasticStrain>, out: &mut [f64]) {
        point.state.outputs(out);
    }
}

impl SmallStrain for DruckerPrager {
    #[inline]
    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<PlasticStrain>,
    ) -> Result<Point<PlasticStrain>, MaterialError> {
        if self.has_constant_cone && self.spec.integration == PlasticIntegration::ClosestPoint {
            let (stress, plastic) = self.peak_step(strain, &old.stress);
            return Ok(Point { stress, state: PlasticStrain { deviatoric: old.state.deviatoric + plastic } });
        }
        self.step_with_changing_cone(strain, &(old.stress + self.elasticity.stress(strain)), old)
    }

    #[inline]
    fn update_component_arrays(&self, lanes: &mut ComponentArrays, states: &mut [PlasticStrain]) -> bool {
        if !self.has_constant_cone || self.spec.integration != PlasticIntegration::ClosestPoint {
            return false;
        }
        let mut plastic = [0.0; BLOCK_SIZE];
        lanes.for_each(&mut plastic, |strain, stress| self.peak_step(strain, stress));
        for (state, increment) in states.iter_mut().zip(plastic) {
            state.deviatoric += increment;
        }
        true
    }

    /// Largest strain increment of a sub-step: half the yield strain, within 1e-4 and 1e-2, for the explicit algorithm, else 1e-2.
    fn max_strain_increment(&self) -> f64 {
        match self.spec.integration {
            PlasticIntegration::Explicit => {
                (0.5 * self.peak.strength / self.elasticity.shear_modulus).clamp(1e-4, 1e-2)
            }
            _ => 1e-2,
        }
    }

    /// Consistent tangent (sheet: constitutive §3.10).
    fn tangent(&self, strain: &SymTensor, _motion: &Motion, old: &Point<PlasticStrain>) -> Option<Tangent> {
        if self.spec.integration != PlasticIntegration::ClosestPoint {
            return None;
        }
        let kappa = old.state.deviatoric;
        let trial = old.stress + self.elasticity.stress(strain);
        let trial = StressInvariantValues::from_stress(&trial);
        let StressInvariantValues { deviator, root_j2, i1 } = trial;
        match self.return_map(&trial, kappa).ok()? {
            ConeReturn::Elastic => Some(self.elasticity.tangent()),
            ConeReturn::Apex { plastic, .. } => Some(self.apex_tangent(&deviator, root_j2, kappa + plastic)),
            ConeReturn::Cone { multiplier, .. } => {
                Some(self.cone_tangent(&deviator, root_j2, i1, multiplier, kappa))
            }
        }
    }
}

impl PrincipalReturn for DruckerPrager {
    fn elasticity(&self) -> &Elasticity {
        &self.elasticity
    }

    fn supports_batch(&self) -> bool {
        self.spec.integration == PlasticIntegration::ClosestPoint
    }

    #[inline]
    fn return_batch<const N: usize>(&self, few: &mut SimdBatch<N>, states: &mut [PlasticStrain; N]) {
        if !self.has_constant_cone {
            return self.return_batch_to_changing_cone(few, states);
        }
        for i in 0..N {
            let trial = few.stress_of(i);
            let (stress, plastic) = self.peak_step(&SymTensor::ZERO, &trial);
            few.set_stress(i, &stress);
            // An isotropic trial beyond the apex yields without plastic shear.
            few.is_yielding[i] = if (plastic != 0.0) | (stress[0] != trial[0]) { 1.0 } else { 0.0 };
            states[i].deviatoric += plastic;
        }
    }

    fn return_principal(
        &self,
        trial: [f64; 3],
        state: &PlasticStrain,
    ) -> Result<([f64; 3], PlasticStrain), MaterialError> {
        let [a, b, c] = trial;
        let old = Point { stress: SymTensor::diagonal(a, b, c), state: *state };
        let new = self.update(&SymTensor::ZERO, &Motion::AT_REST, &old)?;
        Ok(([new.stress[0], new.stress[1], new.stress[2]], new.state))
    }
    fn principal_tangent(&self, trial: [f64; 3], state: &PlasticStrain) -> Option<[[f64; 3]; 3]> {
        let [a, b, c] = trial;
        let old = Point { stress: SymTensor::diagonal(a, b, c), state: *state };
        let Tangent(full) = self.tangent(&SymTensor::ZERO, &Motion::AT_REST, &old)?;
        Some(std::array::from_fn(|a| std::array::from_fn(|b| full[a][b])))
    }
}
