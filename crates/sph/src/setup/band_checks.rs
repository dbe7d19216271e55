//! Checks of laws with localisation bands on particles (sheet: sph §0, fracture).

use colluvium_case::{Case, CaseError};
use colluvium_constitutive::MaterialSpec;

use crate::config::SphOptions;
use crate::kernel::Kernel;
use crate::stress::stress_update::band_length;
use colluvium_case::CaseErrorKind;
use colluvium_case::Warning;

/// Largest ratio of smoothing length to spacing for which a crack opens two rows of particles. With 1.5 a bar in tension dissipates 1.6 to
/// 2.9 times its fracture energy, with 2 up to 3.8 times.
const MAX_SMOOTHING_RATIO: f64 = 1.2;

/// Rejects kernels that spread a crack over more than two rows of particles, and particles whose bands show snap-back.
pub(super) fn check_bands<const D: usize>(case: &Case, options: &SphOptions) -> Result<(), CaseError> {
    for body in case.bodies.iter().filter(|body| !body.rigid) {
        let Some(law) = case.materials.get(&body.material).and_then(MaterialSpec::double_scale) else {
            continue;
        };
        if law.size.is_some() {
            continue;
        }
        let name = &body.material;
        if options.kernel != Kernel::CubicSpline {
            let problem = format!(
                "bands of the material {name:?} dissipate their fracture energy with cubic-spline only: use \
                 that kernel, or give the material the length of its bands (`size`)"
            );
            return Err(CaseError::new("methods.sph.kernel", problem));
        }
        if options.smoothing > MAX_SMOOTHING_RATIO * (1.0 + 1e-9) {
            let problem = format!(
                "{} spreads a crack of the material {name:?} over more than two rows of particles, and it \
                 dissipates up to four times its fracture energy: use at most {MAX_SMOOTHING_RATIO}, or give \
                 the material the length of its bands (`size`)",
                options.smoothing
            );
            return Err(CaseError::new("methods.sph.smoothing", problem));
        }
        let Some(largest) = law.largest_band() else { continue };
        if band_length::<D>(options.spacing.powi(D as i32)) >= largest {
            let problem = format!(
                "bands of the material {name:?} show snap-back from {:.4e} m on (half of E G/f_t², or of the \
                 same with the shear modulus if that is less): make it smaller, or set `allow_snapback` in \
                 the material",
                0.5 * largest
            );
            return Err(CaseError::new("methods.sph.spacing", CaseErrorKind::coded("snap-back", problem)));
        }
    }
    Ok(())
}

/// Warning that soil does not separate from rigid bodies, because these are its neighbours.
pub(super) fn rigid_sticking_warning(case: &Case) -> Option<Warning> {
    let soil = |material: &str| case.materials.get(material).is_some_and(|spec| !spec.is_fluid());
    let number = case.bodies.iter().position(|body| body.rigid)?;
    let stuck = case.bodies.iter().find(|body| !body.rigid && soil(&body.material))?;
    Some(Warning::new(
        "sticks-to-rigid-body",
        format!(
            "bodies[{number}].rigid: in sph {:?} sticks to the rigid body {:?}, in tension too, and neither \
         slides along it nor separates from it. Where that matters, use an obstacle, which may have a \
         prescribed motion (`obstacles.motion`), or mpm with `contacts`",
            stuck.name, case.bodies[number].name
        ),
    ))
}
