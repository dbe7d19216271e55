//! Densities of the flowing material, and resistance of the bed.

use colluvium_case::{Case, CaseError};
use colluvium_constitutive::basal::{BasalRheology, BasalSpec};

use super::option_error;
use crate::config::DepthOptions;
use crate::config::choices::Phases;
use crate::config::settings::Mixture;
use crate::laws::interphase_drag::MixtureDensities;
use crate::setup::bed::case_bed::BedFriction;
use crate::setup::pore_fluid;
use colluvium_case::CaseErrorKind;

/// Tolerance of the density of a material against that of the mixture.
const DENSITY_TOLERANCE: f64 = 0.01;

/// Densities and porosity, from the options or from the material.
pub fn mixture(case: &Case, options: &DepthOptions, gravity: f64) -> Result<Mixture, CaseError> {
    let Some(mixture) = &options.mixture else {
        if options.phases != Phases::One {
            return Err(option_error(
                "mixture",
                CaseErrorKind::coded("needs-other-key", "is missing: it gives the densities of the phases"),
            ));
        }
        return Ok(Mixture::single_phase(case.materials[&case.bodies[0].material].density(), gravity));
    };
    let densities = MixtureDensities { grain: mixture.grain_density, fluid: mixture.fluid_density, gravity };
    let layers = options.phases == Phases::Layers;
    let porosity = if layers { 0.0 } else { mixture.porosity };
    let whole = Mixture { densities, porosity, is_saturated: !layers };
    for body in case.bodies.iter().filter(|_| !layers) {
        let density = pore_fluid::density(case, body);
        let own = densities.mixture(mixture.porosity_of(&body.name));
        if (density / own - 1.0).abs() > DENSITY_TOLERANCE {
            let problem = format!(
                "{density} kg/m³ is not the density of methods.depth-sph.mixture in the body {:?}, (1 - \
                 porosity) grain_density + porosity fluid_density = {own:.1} kg/m³",
                body.name
            );
            return Err(CaseError::new(format!("materials.{}.density", body.material), problem));
        }
    }
    Ok(whole)
}

/// Basal law of a case: that of the options, else that of wall and material.
pub fn basal_law(
    case: &Case,
    options: &DepthOptions,
    hold: Option<BedFriction>,
) -> Result<Option<BasalRheology>, CaseError> {
    if let Some(spec) = &options.basal {
        return build_basal_law(options, spec, "basal").map(Some);
    }
    let Some(hold) = hold.filter(|hold| *hold != BedFriction::Smooth) else { return Ok(None) };
    let name = &case.bodies[0].material;
    let law = case.materials[name].basal().map_err(|error| {
        CaseError::new(
            format!("materials.{name}.model"),
            format!("{error}: give methods.depth-sph.basal, or make the wall below smooth"),
        )
    })?;
    let law = match hold {
        BedFriction::Frictional(coefficient) => law.with_max_friction(coefficient),
        BedFriction::Rough | BedFriction::Smooth => law,
    };
    require_two_phase_law(options, law, "basal").map(Some)
}

/// Basal law of the parameters under a key of the options.
pub fn build_basal_law(
    options: &DepthOptions,
    spec: &BasalSpec,
    key: &str,
) -> Result<BasalRheology, CaseError> {
    let law = spec.build().map_err(|error| option_error(key, error))?;
    require_two_phase_law(options, law, key)
}

/// Returns a basal law, or an error if the flow has two phases and the law is for one phase only.
fn require_two_phase_law(
    options: &DepthOptions,
    law: BasalRheology,
    key: &str,
) -> Result<BasalRheology, CaseError> {
    if options.phases == Phases::Two && !law.is_additive() {
        let problem = "a Bingham profile is available for one phase only: give another law, or leave \
                       `phases` out";
        return Err(option_error(key, CaseErrorKind::coded("conflicting-keys", problem)));
    }
    Ok(law)
}
