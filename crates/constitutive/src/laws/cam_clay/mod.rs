//! Modified Cam-clay (sheet: constitutive §2.6, §3.7.5; Roscoe & Burland 1968).
//!
//! `f = q²/M² + p (p - p_c) ≤ 0`, associated; `ṗ_c = v/(λ-κ) p_c ε̇ᵖ_v`, `K = v p/κ`, with `p` and the
//! plastic volume compression compression-positive and `v = 1 + e`. The shear modulus follows `K` at
//! constant Poisson's ratio, or is given. The return is implicit in `p`, `p_c` and the multiplier with
//! `v` frozen over the step: for a multiplier the volume part has one root, so that one falling
//! function of the multiplier remains. Steps above 1 % strain are divided. Limits: no tension, pressure does
//! not fall below 1 Pa; no elastic energy exists at constant Poisson's ratio.

mod common;
mod parameters;
mod return_map;

use crate::{InitialCondition, Law, MaterialError, Motion, Point, PointLaw, SmallStrain, SymTensor, Tangent};

pub use crate::laws::cam_clay::common::CamClayState;
pub(super) use crate::laws::cam_clay::common::{CamClayConstants, CamClayTrial, OUTPUTS};
pub use parameters::CamClaySpec;
pub use return_map::CamClayReturn;

/// Value of the key `model` in case files.
const NAME: &str = "modified-cam-clay";

/// Modified Cam-clay law. See the module's head for source and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CamClay {
    constants: CamClayConstants,
}

impl Law for CamClay {
    fn name(&self) -> &'static str {
        NAME
    }

    fn output_names(&self) -> &[&'static str] {
        OUTPUTS
    }
}

impl PointLaw for CamClay {
    type State = CamClayState;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<CamClayState>, MaterialError> {
        let m2 = self.constants.critical.powi(2);
        self.constants.initial(NAME, &initial.stress, |p, q| p + q * q / (m2 * p))
    }

    fn wave_modulus(&self, point: &Point<CamClayState>) -> f64 {
        self.constants.wave_modulus(point)
    }

    /// Yield function `f/p_c` (Pa), scaled to a stress.
    fn yield_value(&self, point: &Point<CamClayState>) -> Option<f64> {
        let size = point.state.preconsolidation_pressure;
        Some(self.yield_function(point.stress.pressure(), point.stress.q(), size) / size)
    }

    fn outputs(&self, point: &Point<CamClayState>, out: &mut [f64]) {
        point.state.outputs(out);
    }
}

impl SmallStrain for CamClay {
    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<CamClayState>,
    ) -> Result<Point<CamClayState>, MaterialError> {
        self.step(strain, old).map(|advance| advance.point)
    }

    fn tangent(&self, strain: &SymTensor, _motion: &Motion, old: &Point<CamClayState>) -> Option<Tangent> {
        self.step_tangent(strain, old)
    }

    fn dissipation(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<CamClayState>,
        _new: &Point<CamClayState>,
    ) -> Option<f64> {
        self.step(strain, old).ok().map(|advance| advance.dissipated_work)
    }
}
