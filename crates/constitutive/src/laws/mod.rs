//! The laws, one file each.

pub mod cam_clay;
pub mod drucker_prager;
mod linear_elastic;
pub mod mohr_coulomb;
mod neo_hookean;
mod newtonian_fluid;
pub mod original_cam_clay;
pub mod pressure_elastic;
mod radial;
mod root;
pub mod simsand;
mod substep;

pub use cam_clay::{CamClay, CamClayReturn, CamClaySpec, CamClayState};
pub use drucker_prager::{DruckerPrager, DruckerPragerSpec, Matching, PlasticStrain, Softening};
pub use linear_elastic::{Elasticity, LinearElastic, LinearElasticSpec};
pub use mohr_coulomb::{MohrCoulomb, MohrCoulombSpec};
pub use neo_hookean::{LeftCauchyGreen, NeoHookean, NeoHookeanSpec};
pub use newtonian_fluid::{EquationOfState, FluidState, NewtonianFluid, NewtonianFluidSpec};
pub use original_cam_clay::{OriginalCamClay, OriginalCamClaySpec};
pub use pressure_elastic::{PressureElastic, PressureElasticSpec, PressureStiffness, VoidRatio};
pub use simsand::{Simsand, SimsandSpec, SimsandState};

pub use crate::model::StrainMeasure;
use crate::model::check;
use crate::{MaterialError, SymTensor};

/// Ranges of friction and dilatancy angle (degrees), constitutive sheet §7.
fn check_angles(friction: f64, dilatancy: f64) -> Result<(), MaterialError> {
    check(
        "friction_angle",
        friction,
        (0.0..90.0).contains(&friction),
        "is not in 0..90 degrees (90 excluded)",
    )?;
    let rule = format!("is not between minus and plus the friction angle, {friction} degrees");
    check("dilatancy_angle", dilatancy, (-friction..=friction).contains(&dilatancy), &rule)
}

fn angle_warnings(friction: f64, dilatancy: f64) -> Vec<String> {
    let mut warnings = Vec::new();
    if friction > 60.0 {
        warnings.push(format!("friction_angle: {friction} degrees is more than any soil has"));
    }
    if dilatancy < 0.0 {
        warnings.push(format!("dilatancy_angle: {dilatancy} degrees contracts without end"));
    }
    warnings
}

/// Refuses an initial stress outside the yield surface (relative tolerance 10⁻⁶).
fn check_initial(
    model: &'static str,
    stress: &SymTensor,
    excess: f64,
    scale: f64,
) -> Result<(), MaterialError> {
    if stress.is_finite() && excess <= 1e-6 * scale {
        return Ok(());
    }
    let reason =
        format!("the stress lies outside the yield surface by {excess:.4e} Pa (stress {:?} Pa)", stress.0);
    Err(MaterialError::Initial { model, reason })
}

/// Refuses an initial stress without compressive mean.
fn check_compressive(model: &'static str, stress: &SymTensor) -> Result<(), MaterialError> {
    if stress.is_finite() && stress.pressure() > 0.0 {
        return Ok(());
    }
    let reason = format!("the mean stress must be compressive (stress {:?} Pa)", stress.0);
    Err(MaterialError::Initial { model, reason })
}
