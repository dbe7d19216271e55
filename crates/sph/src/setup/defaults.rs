//! Defaults that depend on the case. Options given in the case file are kept.

use colluvium_case::Case;
use colluvium_constitutive::MaterialSpec;

use crate::config::{
    ContinuityEquation, LagrangianFormulation, MomentumEquation, SphOptions, Symmetrisation,
    VelocityGradientOperator,
};
use crate::kernel::Kernel;

/// Ratio of the densities of two bodies from which the form of the momentum equation matters.
const NOTABLE_JUMP: f64 = 1.01;

/// Least and largest density of a body (kg/m³).
pub(super) fn densities(case: &Case) -> (f64, f64) {
    let all = case.bodies.iter().filter_map(|b| case.materials.get(&b.material)).map(MaterialSpec::density);
    all.fold((f64::INFINITY, 0.0f64), |(low, high), density| (low.min(density), high.max(density)))
}

/// Whether bodies differ so much in density that a uniform stress causes motion with `rho2`.
pub(super) fn has_jump(case: &Case) -> bool {
    let (low, high) = densities(case);
    high >= NOTABLE_JUMP * low
}

/// Largest cell Reynolds number `U Δx/ν` at which liquid viscosity smooths the velocities between particles. `U` is a tenth of the speed of
/// sound, the limit of weak compressibility.
const MAX_CELL_REYNOLDS: f64 = 10.0;

/// Whether all moving bodies are liquids with enough viscosity to replace the artificial one.
fn is_viscous(case: &Case, spacing: f64) -> bool {
    let holds = |material: &MaterialSpec| {
        let MaterialSpec::NewtonianFluid(liquid) = material else { return false };
        let sound = (liquid.bulk_modulus / liquid.density).sqrt();
        MAX_CELL_REYNOLDS * liquid.viscosity >= liquid.density * 0.1 * sound * spacing
    };
    let mut moving = case.bodies.iter().filter(|body| !body.rigid).peekable();
    moving.peek().is_some() && moving.all(|body| case.materials.get(&body.material).is_some_and(holds))
}

/// Smoothing length of liquids over spacing, with a Wendland kernel.
const SMOOTHING_OF_LIQUIDS: f64 = 1.5;
/// Shifting factor of liquids, in smoothing lengths per length moved. With it vortices at a Reynolds number of 100 on 50 particles conserve
/// their energy within 2 %.
const SHIFTING_OF_LIQUIDS: f64 = 10.0;

/// Fraction of the domain filled by bodies above which there is no free surface.
const FULL_DOMAIN_FRACTION: f64 = 0.99;

/// Whether the bodies fill the domain.
fn fills_domain(case: &Case, spacing: f64) -> bool {
    let edges = case.domain.min.iter().zip(&case.domain.max).map(|(min, max)| (max - min) / spacing);
    spacing > 0.0
        && case.point_counts(spacing).iter().sum::<f64>() >= FULL_DOMAIN_FRACTION * edges.product::<f64>()
}

/// Whether all bodies that move by themselves are Newtonian liquids.
fn is_liquid(case: &Case, held: &[String]) -> bool {
    let newtonian = |name: &String| matches!(case.materials.get(name), Some(MaterialSpec::NewtonianFluid(_)));
    let mut moving = case.bodies.iter().filter(|body| !body.rigid && !held.contains(&body.name)).peekable();
    moving.peek().is_some() && moving.all(|body| newtonian(&body.material))
}

/// Sets kernel and shifting of liquids, if the case does not give them.
fn set_liquid_defaults(case: &Case, options: &mut SphOptions, given: &dyn Fn(&str) -> bool) {
    if !given("kernel") {
        options.kernel = Kernel::WendlandC2;
    }
    if !given("smoothing") && options.kernel == Kernel::WendlandC2 {
        options.smoothing = SMOOTHING_OF_LIQUIDS;
    }
    let summed = options.continuity == ContinuityEquation::Summation;
    if !given("shifting") && !summed && case.obstacles.is_empty() && fills_domain(case, options.spacing) {
        options.shifting = SHIFTING_OF_LIQUIDS;
    }
}

/// Sets the defaults of options that depend on the bodies of the case.
pub(super) fn set_case_defaults(case: &Case, options: &mut SphOptions) {
    let given = |key: &str| case.methods.get("sph").is_some_and(|sph| sph.get(key).is_some());
    if options.formulation == LagrangianFormulation::Updated && is_liquid(case, &options.held) {
        set_liquid_defaults(case, options, &given);
    }
    let free = options.symmetrisation != Symmetrisation::GradH
        && options.formulation == LagrangianFormulation::Updated;
    if !given("momentum") && free && has_jump(case) {
        options.momentum = MomentumEquation::RhoRho;
    }
    if !given("viscosity_linear") && is_viscous(case, options.spacing) {
        options.viscosity_linear = 0.0;
    }
    let solid = options.formulation == LagrangianFormulation::Updated && !is_liquid(case, &options.held);
    if !given("velocity_gradient") && solid {
        options.velocity_gradient = VelocityGradientOperator::Corotated;
    }
}

#[cfg(test)]
mod tests {
    use colluvium_case::Case;
    use serde_json::{Value, json};

    use super::super::options;
    use crate::config::VelocityGradientOperator;
    use crate::kernel::Kernel;

    fn case(model: &Value, top: f64, sph: &Value) -> Case {
        let text = json!({
            "title": "defaults", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1], "periodic": ["x", "y"] },
            "gravity": [0, 0], "materials": { "m": model },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, top] } }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "sph": sph }
        });
        Case::from_json(&text.to_string()).unwrap()
    }

    #[test]
    fn the_default_velocity_gradient_of_solids_is_corotated() {
        let soil = json!({ "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.3 });
        let gradient =
            |model: &Value, sph: Value| options(&case(model, 0.5, &sph)).unwrap().velocity_gradient;
        assert_eq!(gradient(&soil, json!({ "spacing": 0.02 })), VelocityGradientOperator::Corotated);
        assert_eq!(gradient(&water(), json!({ "spacing": 0.02 })), VelocityGradientOperator::Compatible);
        let given = json!({ "spacing": 0.02, "velocity_gradient": "compatible" });
        assert_eq!(gradient(&soil, given), VelocityGradientOperator::Compatible);
    }

    fn water() -> Value {
        json!({ "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e5, "viscosity": 10 })
    }

    #[test]
    fn options_left_out_follow_the_material_of_liquids() {
        let found = options(&case(&water(), 1.0, &json!({ "spacing": 0.02 }))).unwrap();
        assert_eq!((found.kernel, found.smoothing, found.shifting), (Kernel::WendlandC2, 1.5, 10.0));
        // Below a free surface particles are not shifted.
        let found = options(&case(&water(), 0.5, &json!({ "spacing": 0.02 }))).unwrap();
        assert_eq!((found.kernel, found.smoothing, found.shifting), (Kernel::WendlandC2, 1.5, 0.0));
        let soil = json!({ "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.3 });
        let found = options(&case(&soil, 1.0, &json!({ "spacing": 0.02 }))).unwrap();
        assert_eq!((found.kernel, found.smoothing, found.shifting), (Kernel::CubicSpline, 1.2, 0.0));
    }

    #[test]
    fn given_options_of_liquids_override_defaults() {
        let given = json!({ "spacing": 0.02, "kernel": "cubic-spline", "shifting": 0 });
        let found = options(&case(&water(), 1.0, &given)).unwrap();
        assert_eq!((found.kernel, found.smoothing, found.shifting), (Kernel::CubicSpline, 1.2, 0.0));
    }
}
