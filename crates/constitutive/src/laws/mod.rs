//! Constitutive laws, one file or folder each.

mod acceleration_viscous;
pub mod bingham;
pub mod cam_clay;
pub mod cfd_soil;
pub mod cohesive_band;
pub mod cohesive_cam_clay;
pub mod cohesive_damage;
pub mod double_scale;
pub mod drucker_prager;
mod eigenstrain;
pub mod equation_of_state;
mod external;
pub mod finite_elastic;
mod fixed_corotated;
pub mod granular_cell;
pub mod granular_flow;
pub mod hypoplastic;
mod linear_elastic;
pub(crate) mod model;
pub mod mohr_coulomb;
pub mod mu_i;
pub mod multi_surface;
mod neo_hookean;
pub mod newtonian_fluid;
pub mod original_cam_clay;
pub mod pressure_elastic;
mod sand;
mod saturation_softened;
pub mod simsand;
mod snow;
pub(crate) mod spec;
mod st_venant_kirchhoff;
pub mod strength_reduced;
mod tension_cut;
mod tresca;
mod umat;
mod undrained;
pub mod viscous_flow;
mod von_mises;

pub use crate::contract::elasticity::Elasticity;
pub use crate::laws::external::{ExternalSpec, MaterialFactory, register_material};
#[cfg(feature = "umat")]
pub use crate::laws::umat::shared_library::allow_libraries;
pub use acceleration_viscous::{AccelerationViscosity, AccelerationViscous, ViscousMode, ViscousState};
pub use bingham::{BinghamSpec, FrictionalFluidSpec, YieldForm};
pub use cam_clay::{CamClay, CamClayReturn, CamClaySpec, CamClayState};
pub use cfd_soil::{CfdSoilSpec, ShearNorm};
pub use cohesive_band::{CohesiveBand, CohesiveBandSpec, CohesiveState};
pub use cohesive_cam_clay::{
    CamClayHardening, CamClayIntegration, CohesiveCamClay, CohesiveCamClaySpec, CohesiveCamClayState,
};
pub use cohesive_damage::{CohesiveDamage, CohesiveDamageSpec, DamageState};
pub use double_scale::{
    BandSpec, BandedState, DoubleScale, DoubleScaleSpec, LocalSolve, Onset, OutsideStrength,
};
pub use drucker_prager::{
    DruckerPrager, DruckerPragerSpec, Matching, PlasticIntegration, PlasticStrain, Softening,
};
pub use eigenstrain::EigenstrainSpec;
pub use equation_of_state::{Barotropic, EquationOfState, FluidState};
pub use finite_elastic::LeftCauchyGreen;
pub use fixed_corotated::{FixedCorotated, FixedCorotatedSpec};
pub use hypoplastic::{Hypoplastic, HypoplasticParameters, HypoplasticSpec};
pub use linear_elastic::{LinearElastic, LinearElasticSpec};
pub use mohr_coulomb::{MohrCoulomb, MohrCoulombSpec};
pub use mu_i::{MuIForm, MuISpec};
pub use neo_hookean::{NeoHookean, NeoHookeanSpec, VolumetricLaw};
pub use newtonian_fluid::{NewtonianFluid, NewtonianFluidSpec};
pub use original_cam_clay::{OriginalCamClay, OriginalCamClaySpec};
pub use pressure_elastic::{PressureElastic, PressureElasticSpec, PressureStiffness, VoidRatio};
pub use sand::{Sand, SandHardening, SandSpec, SandState};
pub use saturation_softened::SaturationSoftenedSpec;
pub use simsand::{Simsand, SimsandSpec, SimsandState};
pub use snow::{Snow, SnowElasticity, SnowSpec, SnowState};
pub use st_venant_kirchhoff::{StVenantKirchhoff, StVenantKirchhoffSpec};
pub use strength_reduced::{ReductionScope, StrengthReducedSpec, StrengthReduction};
pub use tension_cut::{TensionCut, TensionCutSpec};
pub use tresca::TrescaSpec;
pub use umat::UmatSpec;
pub use undrained::UndrainedSpec;
pub use von_mises::{ExactIn, VonMisesSpec};

use crate::Warning;
pub use crate::adapters::hencky::StressInvariants;
use crate::contract::parameter_checks::check;
pub use crate::laws::model::StrainMeasure;
use crate::{MaterialError, SymTensor};

/// Checks the ranges of friction and dilatancy angle (degrees), sheet: constitutive §7.
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

/// Warnings for friction angles above 60 degrees and for negative dilatancy angles (degrees).
fn angle_warnings(friction: f64, dilatancy: f64) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if friction > 60.0 {
        warnings.push(Warning::new(
            "large-friction-angle",
            format!(
                "friction_angle: {friction} degrees is more than that of any soil (60 \
                               degrees). Check the value and its unit"
            ),
        ));
    }
    if dilatancy < 0.0 {
        warnings.push(Warning::new(
            "unlimited-contraction",
            format!(
                "dilatancy_angle: {dilatancy} degrees gives contraction without limit. Give \
                               a dilatancy_decay, or use a law with a critical state"
            ),
        ));
    }
    warnings
}

/// Rejects an initial stress outside the yield surface (relative tolerance 10⁻⁶).
fn check_initial(
    model: &'static str,
    stress: &SymTensor,
    excess: f64,
    scale: f64,
) -> Result<(), MaterialError> {
    if stress.is_finite() && excess <= 1e-6 * scale {
        return Ok(());
    }
    let reason = if excess.is_finite() {
        format!("the stress lies outside the yield surface by {excess:.4e} Pa (stress {:?} Pa)", stress.0)
    } else {
        format!("numbers of this size exceed double precision (stress {:?} Pa)", stress.0)
    };
    Err(MaterialError::Initial { model, reason })
}

/// Rejects an initial stress without compressive mean.
fn check_compressive(model: &'static str, stress: &SymTensor) -> Result<(), MaterialError> {
    if stress.is_finite() && stress.pressure() > 0.0 {
        return Ok(());
    }
    let reason = format!("the mean stress must be compressive (stress {:?} Pa)", stress.0);
    Err(MaterialError::Initial { model, reason })
}
