//! Mohr–Coulomb plasticity (sheet: constitutive §2.5, §3.7.2; region form of Clausen et al.).
//!
//! With `σ1 ≥ σ2 ≥ σ3`: `f = k σ1 - σ3 - 2 c √k ≤ 0`, `g = m σ1 - σ3`, with `k = (1 + sin φ)/(1 - sin φ)`
//! and `m` likewise from the dilatancy angle; elastic law linear. The return ends on the plane, on one
//! of the two edges or at the apex; the region is decided before the return. Cohesion and friction
//! may soften, dilatancy may decay with the accumulated deviatoric plastic strain. Limits: as in all
//! softening laws, no internal length.

mod parameters;
mod pyramid;
mod return_map;
mod softening;

use super::Elasticity;
use super::drucker_prager::{OUTPUTS, PlasticStrain, Softening};
use crate::adapters::hencky::{SimdBatch, small_strain_tangent};
use crate::contract::component_arrays::{ComponentArrays, Spectra};
use crate::{
    BLOCK_SIZE, InitialCondition, Law, MaterialError, Motion, Point, PointLaw, PrincipalReturn, SmallStrain,
    SymTensor, Tangent,
};

use pyramid::dot;
use return_map::PyramidReturn;

pub use parameters::MohrCoulombSpec;
pub use pyramid::{Pyramid, YieldRegion};

/// Value of the key `model` in case files.
const NAME: &str = "mohr-coulomb";

/// Number of points near yield in a batch from which all spectra are computed together.
const MIN_BATCH_POINTS: usize = 8;

/// Mohr–Coulomb law. See the module's head for source and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct MohrCoulomb {
    name: &'static str,
    elasticity: Elasticity,
    spec: MohrCoulombSpec,
    has_constant_pyramid: bool,
    peak_return: PyramidReturn,
}

impl MohrCoulomb {
    /// Returns the law under another name, for models that are a special case of it.
    pub(super) fn with_name(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// Returns the law with peak and residual cohesion multiplied by `share`.
    pub(super) fn scaled_cohesion(&self, share: f64) -> Self {
        let mut law = self.clone();
        law.spec.cohesion *= share;
        law.spec.softening = law.spec.softening.map(|s| s.scaled_cohesion(share));
        let strength = law.peak_return.pyramid.strength * share;
        law.peak_return = Pyramid { strength, ..law.peak_return.pyramid }.pyramid_return(&law.elasticity);
        law
    }

    /// Pyramid at plastic strain `kappa`.
    pub fn pyramid_at(&self, kappa: f64) -> Pyramid {
        if self.has_constant_pyramid {
            return self.peak_return.pyramid;
        }
        self.softened_pyramid(kappa)
    }

    /// Yield pyramid at equivalent plastic strain `κ`, with softened friction and cohesion, decayed dilatancy and the tension cut-off.
    #[inline(never)]
    fn softened_pyramid(&self, kappa: f64) -> Pyramid {
        let spec = &self.spec;
        let peak = (spec.friction_angle.to_radians(), spec.cohesion);
        let (friction, cohesion) = spec.softening.map_or(peak, |s| s.strength(peak, kappa));
        let dilatancy = spec.dilatancy_angle.to_radians() * (-spec.dilatancy_decay * kappa).exp();
        Pyramid::new(friction, cohesion, dilatancy).with_cut_off(spec.tensile_strength)
    }

    /// Deviatoric plastic strain of a return from `trial` to `stress`.
    fn plastic_increment(&self, trial: [f64; 3], stress: [f64; 3]) -> f64 {
        let change: [f64; 3] = std::array::from_fn(|i| trial[i] - stress[i]);
        let mean = (change[0] + change[1] + change[2]) / 3.0;
        let deviator = change.map(|c| c - mean);
        (2.0 / 3.0 * dot(deviator, deviator)).sqrt() / (2.0 * self.elasticity.shear_modulus)
    }

    /// Whether no principal stress can violate yield, from invariants alone.
    #[inline(always)]
    fn is_certainly_elastic(&self, trial: &SymTensor, pyramid: &Pyramid) -> bool {
        let mean = trial.trace() / 3.0;
        let s = trial.deviator();
        // |σ_i - mean| ≤ 2 √(J2/3)
        let radius = (2.0 / 3.0 * s.dot(&s)).sqrt();
        (pyramid.friction - 1.0) * mean + (pyramid.friction + 1.0) * radius <= pyramid.strength
            && mean + radius <= pyramid.cut_off
    }
}

impl Law for MohrCoulomb {
    fn name(&self) -> &'static str {
        self.name
    }

    fn output_names(&self) -> &[&'static str] {
        OUTPUTS
    }
}

impl PointLaw for MohrCoulomb {
    type State = PlasticStrain;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<PlasticStrain>, MaterialError> {
        if self.spec.return_initial_stress_to_yield && initial.stress.is_finite() {
            let spectrum = initial.stress.spectrum();
            let (principal, region) = self.peak_return.return_map(spectrum.values);
            let stress =
                if region == YieldRegion::Elastic { initial.stress } else { spectrum.compose(principal) };
            return Ok(Point { stress, state: PlasticStrain::default() });
        }
        let principal = initial.stress.principal_values();
        let peak = &self.peak_return.pyramid;
        let scale = peak.strength + peak.friction * principal[0].abs() + principal[2].abs();
        super::check_initial(self.name, &initial.stress, peak.yield_value(principal), scale)?;
        Ok(Point { stress: initial.stress, state: PlasticStrain::default() })
    }

    fn wave_modulus(&self, _point: &Point<PlasticStrain>) -> f64 {
        self.elasticity.p_wave_modulus()
    }

    fn yield_value(&self, point: &Point<PlasticStrain>) -> Option<f64> {
        Some(self.pyramid_at(point.state.deviatoric).yield_value(point.stress.spectrum().values))
    }

    fn linear_elasticity(&self) -> Option<&Elasticity> {
        Some(&self.elasticity)
    }

    fn outputs(&self, point: &Point<PlasticStrain>, out: &mut [f64]) {
        point.state.outputs(out);
    }
}

impl SmallStrain for MohrCoulomb {
    #[inline]
    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<PlasticStrain>,
    ) -> Result<Point<PlasticStrain>, MaterialError> {
        let trial = old.stress + self.elasticity.stress(strain);
        let pyramid = self.pyramid_at(old.state.deviatoric);
        if self.is_certainly_elastic(&trial, &pyramid) {
            return Ok(Point { stress: trial, state: old.state });
        }
        if !trial.is_finite() {
            return Err(MaterialError::Motion { model: self.name, reason: "the trial stress is not finite" });
        }
        let spectrum = trial.spectrum();
        let (principal, state) = self.return_principal(spectrum.values, &old.state)?;
        if principal == spectrum.values {
            return Ok(Point { stress: trial, state });
        }
        Ok(Point { stress: spectrum.compose(principal), state })
    }

    #[inline]
    fn update_component_arrays(&self, lanes: &mut ComponentArrays, states: &mut [PlasticStrain]) -> bool {
        if !self.has_constant_pyramid {
            return false;
        }
        let mut inside = [0.0; BLOCK_SIZE];
        lanes.for_each(&mut inside, |strain, stress| {
            let trial = *stress + self.elasticity.stress(strain);
            let elastic = self.is_certainly_elastic(&trial, &self.peak_return.pyramid);
            (trial, if elastic { 1.0 } else { 0.0 })
        });
        let outside = inside.iter().take(states.len()).filter(|inside| **inside == 0.0).count();
        let mut spectra = Spectra::EMPTY;
        if outside >= MIN_BATCH_POINTS {
            lanes.spectra(&mut spectra);
        }
        for (index, state) in states.iter_mut().enumerate() {
            if inside[index] == 1.0 {
                continue;
            }
            let spectrum = if outside >= MIN_BATCH_POINTS {
                spectra.spectrum(index)
            } else {
                lanes.stress_of(index).spectrum()
            };
            let (principal, region) = self.peak_return.return_map(spectrum.values);
            if region != YieldRegion::Elastic {
                state.deviatoric += self.plastic_increment(spectrum.values, principal);
                lanes.set_stress(index, &spectrum.compose(principal));
            }
        }
        true
    }

    /// Consistent tangent (sheet: constitutive §3.10).
    fn tangent(&self, strain: &SymTensor, _motion: &Motion, old: &Point<PlasticStrain>) -> Option<Tangent> {
        small_strain_tangent(self, &(old.stress + self.elasticity.stress(strain)), &old.state)
    }
}

impl PrincipalReturn for MohrCoulomb {
    fn elasticity(&self) -> &Elasticity {
        &self.elasticity
    }

    fn supports_batch(&self) -> bool {
        true
    }

    #[inline]
    fn return_batch<const N: usize>(&self, few: &mut SimdBatch<N>, states: &mut [PlasticStrain; N]) {
        let mut inside = [0.0; N];
        for i in 0..N {
            let pyramid = self.pyramid_at(states[i].deviatoric);
            inside[i] = if self.is_certainly_elastic(&few.stress_of(i), &pyramid) { 1.0 } else { 0.0 };
        }
        if inside == [1.0; N] {
            return;
        }
        let spectra = few.spectra();
        for i in (0..N).filter(|&i| inside[i] == 0.0) {
            let spectrum = spectra.spectrum(i);
            match self.return_principal(spectrum.values, &states[i]) {
                Ok((principal, _)) if principal == spectrum.values => {}
                Ok((principal, state)) => {
                    few.set_stress(i, &spectrum.compose(principal));
                    (few.is_yielding[i], states[i]) = (1.0, state);
                }
                Err(_) => few.fallback[i] = 1.0,
            }
        }
    }

    fn return_principal(
        &self,
        trial: [f64; 3],
        state: &PlasticStrain,
    ) -> Result<([f64; 3], PlasticStrain), MaterialError> {
        let kappa = state.deviatoric;
        let (mut stress, region) = if self.has_constant_pyramid {
            self.peak_return.return_map(trial)
        } else {
            self.softened_pyramid(kappa).return_map(&self.elasticity, trial)
        };
        if region == YieldRegion::Elastic {
            return Ok((trial, *state));
        }
        let mut increment = self.plastic_increment(trial, stress);
        if !self.has_constant_pyramid {
            (stress, increment) = self.softening_return(trial, kappa, increment)?;
        }
        Ok((stress, PlasticStrain { deviatoric: kappa + increment }))
    }

    fn principal_tangent(&self, trial: [f64; 3], state: &PlasticStrain) -> Option<[[f64; 3]; 3]> {
        let pyramid = self.pyramid_at(state.deviatoric);
        let (_, region) = pyramid.return_map(&self.elasticity, trial);
        if region == YieldRegion::Elastic || self.has_constant_pyramid {
            return Some(pyramid.tangent(&self.elasticity, region));
        }
        self.softening_tangent(trial, state)
    }
}
