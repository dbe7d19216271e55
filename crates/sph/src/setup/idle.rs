//! Options that have no effect, because another one that they belong to is not given.

use colluvium_case::{Case, CaseError};

use crate::config::{DensityReset, Regularisation, SphOptions};

/// Refuses options of the case that would change nothing.
pub(super) fn check(case: &Case, options: &SphOptions) -> Result<(), CaseError> {
    let given = |key: &str| case.methods.get("sph").is_some_and(|own| own.get(key).is_some());
    for (key, acts, cure) in [
        ("density_reset_steps", options.density_reset != DensityReset::None, "give density_reset"),
        ("regularisation_steps", options.regularisation != Regularisation::None, "give regularisation"),
        ("stress_diffusion_k0", options.stress_diffusion > 0.0, "give stress_diffusion"),
        ("smoothing_growth", options.is_variable(), "give smoothing_length"),
    ] {
        if given(key) && !acts {
            return Err(CaseError::new(
                format!("methods.sph.{key}"),
                format!("has no effect here: {cure}, or leave it out"),
            ));
        }
    }
    Ok(())
}
