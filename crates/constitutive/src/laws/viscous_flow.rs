//! Common parts of laws whose pressure follows from density and whose shear stress is that of a flow
//! (sheet: constitutive §3.4, §3.7.9). `τ = √J2`, shear rate `γ̇ = √(2 D':D')`, both positive.
//!
//! [`ViscousFluid`]: `s = 2η(γ̇, p) dev D`; the viscosity must be finite at rest, so there is no static yield.
//! [`Viscoplastic`]: elastic (`G`) up to the yield stress, above it the plastic shear rate is that of
//! the flow curve `τ(γ̇ᵖ, p)`, by backward Euler: `τ + GΔt γ̇ᵖ(τ, p) = τᵗʳ`, with a radial return.

use crate::laws::equation_of_state::{Barotropic, FluidState};
use crate::laws::{Elasticity, check_initial};
use crate::{
    InitialCondition, Law, Mat3, MaterialError, Motion, Point, PointLaw, SmallStrain, StressUpdate,
    SymTensor, Tangent,
};

/// Output scalars of a flow: names and values.
pub trait FlowOutputs {
    /// Name of the model in a case file.
    const NAME: &'static str;
    /// Names of the scalars.
    const OUTPUTS: &'static [&'static str] = &["shear_rate", "effective_viscosity"];

    /// Scalars at shear rate `rate` (1/s), shear stress `shear` (Pa) and `pressure` (Pa). The effective
    /// viscosity is zero without flow.
    fn outputs(&self, rate: f64, shear: f64, _pressure: f64, out: &mut [f64]) {
        out[0] = rate;
        out[1] = if rate > 0.0 { shear / rate } else { 0.0 };
    }
}

/// Effective viscosity as a function of shear rate and pressure.
pub trait EffectiveViscosity: FlowOutputs + Send + Sync + 'static {
    /// Viscosity `η` (Pa s) at a shear rate (1/s) and pressure (Pa), finite at rest.
    fn viscosity(&self, rate: f64, pressure: f64) -> f64;
}

/// Flow curve with a yield stress.
pub trait FlowCurve: FlowOutputs + Send + Sync + 'static {
    /// Shear stress `τ` (Pa) of flow at the plastic shear rate `rate` (1/s); at zero the yield stress.
    fn strength(&self, rate: f64, pressure: f64) -> f64;

    /// Shear stress (Pa) after a trial above the yield stress: the root of
    /// `τ = strength((trial - τ)/stiffness, pressure)`, with `stiffness = G Δt` (Pa s).
    fn return_shear_stress(&self, trial: f64, pressure: f64, stiffness: f64) -> f64;

    /// Derivatives of [`FlowCurve::return_shear_stress`] with respect to trial stress and pressure.
    fn return_derivatives(&self, trial: f64, pressure: f64, stiffness: f64) -> (f64, f64);
}

/// Rejects a shear modulus in a viscous form, in which it has no effect; `form` is the form that uses it.
pub(super) fn without_shear_modulus(given: Option<f64>, form: &str) -> Result<(), MaterialError> {
    let rule = || format!("has no effect on a viscous form, only on {form}");
    given.map_or(Ok(()), |_| Err(MaterialError::incompatible_options("shear_modulus", rule())))
}

/// Fluid with an effective viscosity.
#[derive(Clone, Debug, PartialEq)]
pub struct ViscousFluid<V> {
    /// Viscosity law.
    pub rheology: V,
    /// Equation of state.
    pub pressure: Barotropic,
}

impl<V: EffectiveViscosity> Law for ViscousFluid<V> {
    fn name(&self) -> &'static str {
        V::NAME
    }

    fn is_time_dependent(&self) -> bool {
        true
    }

    fn output_names(&self) -> &[&'static str] {
        V::OUTPUTS
    }
}

impl<V: EffectiveViscosity> PointLaw for ViscousFluid<V> {
    type State = FluidState;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<FluidState>, MaterialError> {
        let pressure = initial.stress.pressure();
        if !(initial.stress.deviator().norm() <= 1e-9 * pressure.abs()) {
            let reason = "a viscous fluid at rest carries no shear stress".to_owned();
            return Err(MaterialError::Initial { model: V::NAME, reason });
        }
        let state = self.pressure.initial(V::NAME, initial)?;
        Ok(Point { stress: SymTensor::isotropic(-pressure), state })
    }

    fn wave_modulus(&self, point: &Point<FluidState>) -> f64 {
        self.pressure.modulus(point.state.ratio())
    }

    fn viscosity(&self, point: &Point<FluidState>) -> f64 {
        self.rheology.viscosity(point.state.shear_rate, point.stress.pressure())
    }

    fn stored_energy(&self, point: &Point<FluidState>) -> Option<f64> {
        Some(self.pressure.energy(point.state.ratio()))
    }

    fn outputs(&self, point: &Point<FluidState>, out: &mut [f64]) {
        let (shear, pressure) = (point.stress.j2().sqrt(), point.stress.pressure());
        self.rheology.outputs(point.state.shear_rate, shear, pressure, out);
    }
}

impl<V: EffectiveViscosity> StressUpdate for ViscousFluid<V> {
    #[inline]
    fn update(&self, motion: &Motion, old: &Point<FluidState>) -> Result<Point<FluidState>, MaterialError> {
        let mut state = self.pressure.step(V::NAME, motion, &old.state)?;
        let rate = motion.strain_increment().deviator() * (1.0 / motion.dt);
        state.shear_rate = (2.0 * rate.dot(&rate)).sqrt();
        if !state.shear_rate.is_finite() {
            return Err(MaterialError::Motion { model: V::NAME, reason: "the motion is not finite" });
        }
        let stress = match self.pressure.pressure(state.ratio()) {
            Some(pressure) => {
                let viscosity = self.rheology.viscosity(state.shear_rate, pressure);
                rate * (2.0 * viscosity) + SymTensor::isotropic(-pressure)
            }
            None => SymTensor::isotropic(self.pressure.tension),
        };
        if !stress.is_finite() {
            return Err(MaterialError::Motion { model: V::NAME, reason: "the stress is not finite" });
        }
        Ok(Point { stress, state })
    }

    fn dissipation(&self, motion: &Motion, _: &Point<FluidState>, new: &Point<FluidState>) -> Option<f64> {
        Some(new.stress.dot(&motion.strain_increment().deviator()))
    }
}

/// Material that is elastic in shear until it yields and flows. Wrap it in [`crate::Corotational`].
#[derive(Clone, Debug, PartialEq)]
pub struct Viscoplastic<R> {
    /// Flow curve.
    pub rheology: R,
    /// Equation of state.
    pub pressure: Barotropic,
    /// Shear modulus `G` (Pa).
    pub shear_modulus: f64,
}

/// Elastic trial: deviator and `√J2`.
struct ShearTrial {
    deviator: SymTensor,
    shear: f64,
}

impl<R: FlowCurve> Viscoplastic<R> {
    /// Elastic trial deviator of a strain increment and its shear stress `√J2` (Pa).
    #[inline]
    fn trial(&self, strain: &SymTensor, old: &SymTensor) -> ShearTrial {
        let deviator = old.deviator() + strain.deviator() * (2.0 * self.shear_modulus);
        let shear = (0.5 * deviator.dot(&deviator)).sqrt();
        ShearTrial { deviator, shear }
    }

    /// Whether a trial flows. Round-off of an earlier return does not count as flow.
    #[inline]
    fn flows(&self, shear: f64, pressure: f64) -> bool {
        let slack = 8.0 * f64::EPSILON * (shear + pressure.abs());
        shear > self.rheology.strength(0.0, pressure) + slack
    }
}

impl<R: FlowCurve> Law for Viscoplastic<R> {
    fn name(&self) -> &'static str {
        R::NAME
    }

    /// Whether the law depends on time: a stress above yield relaxes where the flow curve rises with the rate.
    fn is_time_dependent(&self) -> bool {
        let pressure = self.pressure.bulk_modulus;
        self.rheology.strength(1.0, pressure) > self.rheology.strength(0.0, pressure)
    }

    fn output_names(&self) -> &[&'static str] {
        R::OUTPUTS
    }
}

impl<R: FlowCurve> PointLaw for Viscoplastic<R> {
    type State = FluidState;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<FluidState>, MaterialError> {
        let state = self.pressure.initial(R::NAME, initial)?;
        let (stress, pressure) = (initial.stress, initial.stress.pressure());
        // Flowing material starts above the yield stress, at most at the strength that some shear rate gives.
        let (rest, largest) =
            (self.rheology.strength(0.0, pressure), self.rheology.strength(f64::MAX, pressure));
        let excess = stress.j2().sqrt() - largest.min(f64::MAX);
        check_initial(R::NAME, &stress, excess, rest.max(pressure.abs()))?;
        Ok(Point { stress, state })
    }

    fn wave_modulus(&self, point: &Point<FluidState>) -> f64 {
        self.pressure.modulus(point.state.ratio()) + 4.0 / 3.0 * self.shear_modulus
    }

    /// Yield value (Pa): shear stress minus that of the flow curve at the plastic shear rate of the last step.
    fn yield_value(&self, point: &Point<FluidState>) -> Option<f64> {
        let strength = self.rheology.strength(point.state.shear_rate, point.stress.pressure());
        Some(point.stress.j2().sqrt() - strength)
    }

    fn stored_energy(&self, point: &Point<FluidState>) -> Option<f64> {
        let shear = point.stress.j2() / (2.0 * self.shear_modulus);
        Some(self.pressure.energy(point.state.ratio()) + shear)
    }

    fn outputs(&self, point: &Point<FluidState>, out: &mut [f64]) {
        let (shear, pressure) = (point.stress.j2().sqrt(), point.stress.pressure());
        self.rheology.outputs(point.state.shear_rate, shear, pressure, out);
    }
}

impl<R: FlowCurve> SmallStrain for Viscoplastic<R> {
    #[inline]
    fn update(
        &self,
        strain: &SymTensor,
        motion: &Motion,
        old: &Point<FluidState>,
    ) -> Result<Point<FluidState>, MaterialError> {
        let mut state = self.pressure.step(R::NAME, motion, &old.state)?;
        let Some(pressure) = self.pressure.pressure(state.ratio()) else {
            return Ok(Point { stress: SymTensor::isotropic(self.pressure.tension), state });
        };
        let trial = self.trial(strain, &old.stress);
        if !trial.shear.is_finite() {
            return Err(MaterialError::Motion { model: R::NAME, reason: "the trial stress is not finite" });
        }
        let mean = SymTensor::isotropic(-pressure);
        if !self.flows(trial.shear, pressure) {
            let still = *strain == SymTensor::ZERO && motion.density == old.state.density;
            return Ok(Point { stress: if still { old.stress } else { trial.deviator + mean }, state });
        }
        let stiffness = self.shear_modulus * motion.dt;
        let shear = self.rheology.return_shear_stress(trial.shear, pressure, stiffness);
        state.shear_rate = (trial.shear - shear) / stiffness;
        Ok(Point { stress: trial.deviator * (shear / trial.shear) + mean, state })
    }

    fn max_strain_increment(&self) -> f64 {
        f64::INFINITY
    }

    /// Tangent by the implicit-function theorem (Pa), from `s = τ(τᵗʳ, p) m` with `m = sᵗʳ/τᵗʳ` and `dp = -ρ p'(ρ) H : dε`. `H = (1 -
    /// A²/4)⁻¹` is the change of `ln det f` with the mid-step gradient.
    fn tangent(&self, strain: &SymTensor, motion: &Motion, old: &Point<FluidState>) -> Option<Tangent> {
        let state = self.pressure.step(R::NAME, motion, &old.state).ok()?;
        let Some(pressure) = self.pressure.pressure(state.ratio()) else { return Some(Tangent::ZERO) };
        let modulus = self.pressure.modulus(state.ratio());
        let volume = (Mat3::IDENTITY - motion.velocity_gradient_dt * motion.velocity_gradient_dt * 0.25)
            .inverse()?
            .sym();
        let elasticity = Elasticity { bulk_modulus: modulus, shear_modulus: self.shear_modulus };
        let trial = self.trial(strain, &old.stress);
        let mut tangent;
        if self.flows(trial.shear, pressure) {
            let stiffness = self.shear_modulus * motion.dt;
            let share = self.rheology.return_shear_stress(trial.shear, pressure, stiffness) / trial.shear;
            let (by_trial, by_pressure) = self.rheology.return_derivatives(trial.shear, pressure, stiffness);
            let m = trial.deviator * (1.0 / trial.shear);
            tangent = elasticity.deviatoric_tangent(share);
            tangent.add_dyad(self.shear_modulus * (by_trial - share), &m, &m);
            tangent.add_dyad(-by_pressure * modulus, &m, &volume);
        } else {
            tangent = elasticity.deviatoric_tangent(1.0);
        }
        tangent.add_dyad(modulus, &SymTensor::IDENTITY, &volume);
        Some(tangent)
    }

    fn dissipation(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<FluidState>,
        new: &Point<FluidState>,
    ) -> Option<f64> {
        let lost = self.trial(strain, &old.stress).deviator - new.stress.deviator();
        Some(new.stress.deviator().dot(&lost) / (2.0 * self.shear_modulus))
    }
}

/// Ratio of shear to bulk modulus at a Poisson's ratio of 0.3.
const DEFAULT_SHEAR_RATIO: f64 = 6.0 / 13.0;

/// Shear modulus (Pa) of a yielding material: the given one, or a fixed fraction of the bulk modulus.
pub(super) fn shear_modulus(given: Option<f64>, bulk_modulus: f64) -> Result<f64, MaterialError> {
    let modulus = given.unwrap_or(DEFAULT_SHEAR_RATIO * bulk_modulus);
    crate::contract::parameter_checks::positive("shear_modulus", modulus, "Pa")?;
    Ok(modulus)
}
