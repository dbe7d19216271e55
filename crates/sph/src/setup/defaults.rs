//! Defaults that depend on the case. What the case file gives stands.

use colluvium_case::Case;
use colluvium_constitutive::MaterialSpec;

use crate::config::{Formulation, Momentum, SphOptions, Symmetrisation};

/// Ratio of the densities of two bodies from which the form of the momentum equation matters.
const NOTABLE_JUMP: f64 = 1.01;

/// The least and the largest density of a body (kg/m³).
pub(super) fn densities(case: &Case) -> (f64, f64) {
    let all = case.bodies.iter().filter_map(|b| case.materials.get(&b.material)).map(MaterialSpec::density);
    all.fold((f64::INFINITY, 0.0f64), |(low, high), density| (low.min(density), high.max(density)))
}

/// Whether bodies differ so much in density that `rho2` sets a uniform stress in motion.
pub(super) fn has_jump(case: &Case) -> bool {
    let (low, high) = densities(case);
    high >= NOTABLE_JUMP * low
}

/// Largest cell Reynolds number `U Δx/ν`, at the tenth of the speed of sound that is the most a weakly compressible liquid may
/// flow with, at which the liquid's own viscosity holds velocities between particles together.
const MOST_OWN: f64 = 10.0;

/// Whether all that moves are liquids whose own viscosity does what the artificial one is for.
fn is_viscous(case: &Case, spacing: f64) -> bool {
    let holds = |material: &MaterialSpec| {
        let MaterialSpec::NewtonianFluid(liquid) = material else { return false };
        let sound = (liquid.bulk_modulus / liquid.density).sqrt();
        MOST_OWN * liquid.viscosity >= liquid.density * 0.1 * sound * spacing
    };
    let mut moving = case.bodies.iter().filter(|body| !body.rigid).peekable();
    moving.peek().is_some() && moving.all(|body| case.materials.get(&body.material).is_some_and(holds))
}

/// Gives the options that the case leaves out what fits its bodies.
pub(super) fn fit(case: &Case, options: &mut SphOptions) {
    let given = |key: &str| case.methods.get("sph").is_some_and(|sph| sph.get(key).is_some());
    let free = options.symmetrisation != Symmetrisation::GradH && options.formulation == Formulation::Updated;
    if !given("momentum") && free && has_jump(case) {
        options.momentum = Momentum::RhoRho;
    }
    if !given("viscosity_linear") && is_viscous(case, options.spacing) {
        options.viscosity_linear = 0.0;
    }
}
