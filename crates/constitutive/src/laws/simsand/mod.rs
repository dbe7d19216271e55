//! Critical-state sand, "SIMSAND" (sheet: constitutive §2.7, §3.7.8; Bui & Nguyen 2021, section 3.2.4, after
//! Jin et al. 2017).
//!
//! Compression positive, `η = q/p`, void ratio `e`:
//! `K = K₀ p_at (2.97-e)²/(1+e) (p/p_at)^ζ`, `G = 3(1-2ν)/(2(1+ν)) K`, `e_c = e_ref - λ (p/p_at)^ξ`,
//! `f = η - M_p ε_q/(k_p + ε_q) ≤ 0`, `dε_v/dε_q = A_d (M_pt - η)`,
//! `tan φ_p = (e_c/e)^n_p tan φ_c`, `tan φ_pt = (e_c/e)^(-n_d) tan φ_c`, `M_x = 6 sin φ_x/(3 - sin φ_x)`, with
//! the accumulated plastic shear `ε_q`. The return is implicit with the moduli of the start of the (sub)step:
//! for a plastic shear the pressure is the root of a rising function, and the yield condition remains.
//! Steps above 1 % strain are divided. Where pressure would fall below 1 Pa the stress of the point is zero
//! and the point is flagged liquefied until it is compressed again. Limits: no plastic flow at constant stress
//! ratio, reversals are elastic, stiffness is frozen over a substep.

mod critical_state;
mod parameters;
mod return_map;

use serde::{Deserialize, Serialize};

use crate::{InitialCondition, Law, MaterialError, Motion, Point, PointLaw, SmallStrain, SymTensor, Tangent};

use critical_state::lode_cosine;

pub use critical_state::StressRatio;
pub use parameters::SimsandSpec;

/// Value of the key `model` in case files.
const NAME: &str = "simsand";

/// Initial plastic shear of each point, above zero so that the yield surface has a finite slope at zero stress ratio.
const INITIAL_PLASTIC_SHEAR: f64 = 1e-9;

/// Plastic shear strain at which the strength is regarded as fully mobilised, for initial stresses above the strength. The strength itself
/// is reached only at infinite strain.
const FULL_MOBILISATION_SHEAR: f64 = 1.0;

/// Limits of void ratios and critical void ratios in stiffness and friction.
const VOID_RANGE: (f64, f64) = (0.01, 2.9);

/// Internal variables of the SIMSAND law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SimsandState {
    /// Void ratio: volume of voids over volume of grains.
    pub void_ratio: f64,
    /// Accumulated plastic shear strain `ε_q`.
    pub plastic_strain: f64,
    /// Whether the point has lost its effective pressure and its stress is zero.
    pub liquefied: bool,
}

/// SIMSAND law. See the module's head for source and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Simsand {
    spec: SimsandSpec,
    shear_ratio: f64,
    tangent_critical: f64,
}

impl Simsand {
    /// State at the start, after a plastic shear.
    fn start(&self, plastic_strain: f64) -> SimsandState {
        SimsandState { void_ratio: self.spec.void_ratio, plastic_strain, liquefied: false }
    }
}

impl Law for Simsand {
    fn name(&self) -> &'static str {
        NAME
    }

    fn output_names(&self) -> &[&'static str] {
        &["void_ratio", "plastic_strain", "liquefied"]
    }
}

impl PointLaw for Simsand {
    type State = SimsandState;

    /// Initial point: the plastic shear at the start puts the yield surface through the initial stress.
    fn initial(&self, initial: &InitialCondition) -> Result<Point<SimsandState>, MaterialError> {
        let stress = initial.stress;
        super::check_compressive(NAME, &stress)?;
        let (p, q) = (stress.pressure(), stress.q());
        let lode = lode_cosine(&stress.deviator());
        let [peak, _] = self.slopes(p, self.spec.void_ratio, lode);
        let largest = p * peak.value * self.mobilised_share(FULL_MOBILISATION_SHEAR).0;
        if self.spec.return_initial_stress_to_yield && q > largest {
            let stress = stress.deviator() * (largest / q) - SymTensor::isotropic(p);
            return Ok(Point { stress, state: self.start(FULL_MOBILISATION_SHEAR) });
        }
        if q >= p * peak.value {
            let reason = format!(
                "the stress ratio q/p = {:.4} is not below the strength {:.4} (stress {:?} Pa)",
                q / p,
                peak.value,
                stress.0
            );
            return Err(MaterialError::Initial { model: NAME, reason });
        }
        let through = self.spec.hardening_constant * q / (p * peak.value - q);
        Ok(Point { stress, state: self.start(through.max(INITIAL_PLASTIC_SHEAR)) })
    }

    fn wave_modulus(&self, point: &Point<SimsandState>) -> f64 {
        let bulk = self.bulk_modulus(point.stress.pressure(), point.state.void_ratio);
        1.1 * bulk * (1.0 + 4.0 / 3.0 * self.shear_ratio)
    }

    /// Yield function `f p` (Pa), scaled to a stress.
    fn yield_value(&self, point: &Point<SimsandState>) -> Option<f64> {
        let p = point.stress.pressure();
        if !(p > 0.0) {
            return Some(0.0);
        }
        let lode = lode_cosine(&point.stress.deviator());
        let [peak, _] = self.slopes(p, point.state.void_ratio, lode);
        Some(point.stress.q() - p * peak.value * self.mobilised_share(point.state.plastic_strain).0)
    }

    fn outputs(&self, point: &Point<SimsandState>, out: &mut [f64]) {
        let SimsandState { void_ratio, plastic_strain, liquefied } = point.state;
        out.copy_from_slice(&[void_ratio, plastic_strain, f64::from(u8::from(liquefied))]);
    }
}

impl SmallStrain for Simsand {
    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<SimsandState>,
    ) -> Result<Point<SimsandState>, MaterialError> {
        if *strain == SymTensor::ZERO {
            return Ok(*old);
        }
        self.step(strain, old).map(|advance| advance.point)
    }

    fn tangent(&self, strain: &SymTensor, _motion: &Motion, old: &Point<SimsandState>) -> Option<Tangent> {
        self.step_tangent(strain, old)
    }

    fn dissipation(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<SimsandState>,
        _new: &Point<SimsandState>,
    ) -> Option<f64> {
        self.step(strain, old).ok().map(|advance| advance.dissipated_work)
    }
}
