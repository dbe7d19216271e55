//! The laws, one file each.

mod acceleration_viscous;
pub mod cohesive_band;
pub mod cohesive_damage;
pub mod double_scale;
pub mod drucker_prager;
pub mod hypoplastic;
mod linear_elastic;
pub mod mohr_coulomb;
mod neo_hookean;
mod newtonian_fluid;
mod root;
mod substep;

pub use acceleration_viscous::{AccelerationViscosity, Viscous, ViscousMode, ViscousState};
pub use cohesive_band::{CohesiveBand, CohesiveBandSpec, CohesiveState};
pub use cohesive_damage::{CohesiveDamage, CohesiveDamageSpec, DamageState};
pub use double_scale::{BandSpec, BandedState, DoubleScale, DoubleScaleSpec, Onset};
pub use drucker_prager::{DruckerPrager, DruckerPragerSpec, Matching, PlasticStrain, Softening};
pub use hypoplastic::{Hypoplastic, HypoplasticParameters, HypoplasticSpec, VoidRatio};
pub use linear_elastic::{Elasticity, LinearElastic, LinearElasticSpec};
pub use mohr_coulomb::{MohrCoulomb, MohrCoulombSpec};
pub use neo_hookean::{LeftCauchyGreen, NeoHookean, NeoHookeanSpec};
pub use newtonian_fluid::{EquationOfState, FluidState, NewtonianFluid, NewtonianFluidSpec};

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
