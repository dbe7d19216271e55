//! Capabilities of SPH: refused features of a case, by path, and warnings.

use colluvium_case::description::{Body, ObstacleShape, Wall};
use colluvium_case::{Capabilities, Case, CaseError, CaseErrorKind, Feature};
use colluvium_constitutive::{MaterialSpec, ModelFamily};

use crate::config::{
    ConfiningPressureTarget, ContinuityEquation, DensityReset, LagrangianFormulation, MomentumEquation,
    Regularisation, RoughWall, SmoothWall, SphOptions, Symmetrisation, Tensile, TimeIntegration,
    VelocityGradientOperator, WallStress, WallVelocity,
};
use crate::points::particles::ParticleGroup;
use crate::setup::band_checks::rigid_sticking_warning;
use crate::setup::defaults::{densities, has_jump};
use crate::stress::total_lagrangian;
use crate::walls::is_mirror;
use colluvium_case::Warning;

/// Relative difference of the width of listed particles from `spacing` above which there is a warning.
const LISTED_SLACK: f64 = 0.1;

/// Features that SPH supports in addition to those of all point methods.
const SUPPORTED: &[Feature] = &[
    Feature::DomainOrigin,
    Feature::Boundaries,
    Feature::BoundariesName,
    Feature::BoundariesPosition,
    Feature::BoundariesVelocity,
    Feature::BoundariesWallRough,
    Feature::BoundariesWallSmooth,
    Feature::BoundariesWallFrictional,
    Feature::StagesDamping,
    Feature::BodiesRigid,
    Feature::MeasuresReaction,
    Feature::MeasuresImpactPressure,
    Feature::Obstacles,
    Feature::ObstaclesWallRough,
    Feature::ObstaclesWallSmooth,
    Feature::ObstaclesWallFrictional,
    Feature::ObstaclesWallAdhesion,
    Feature::ObstaclesSeparation,
];

/// Features that SPH supports with all their variants and keys, in addition to those of all point methods.
const SUPPORTED_WHOLLY: &[Feature] = &[
    Feature::DomainPeriodic,
    Feature::BoundariesSide,
    Feature::StagesMotions,
    Feature::Loads,
    Feature::ObstaclesShape,
    Feature::ObstaclesRegions,
    Feature::ObstaclesMotion,
];

/// Capabilities of SPH for the features of a case.
pub(crate) fn capabilities(options: &SphOptions) -> Capabilities {
    let total = options.formulation == LagrangianFormulation::TotalLagrangian;
    let in_total = |problem: &str| format!("{problem}, in the total-Lagrangian form");
    Capabilities::for_point_methods("sph")
        .supports(SUPPORTED)
        .supports_all_of(SUPPORTED_WHOLLY)
        .rejects(Feature::SpaceAxisymmetric, "sph has no axisymmetric form: use plane-strain or 3d")
        .rejects_if(total, Feature::BodiesRigid, in_total("bodies are deformable or held"))
        .rejects_if(
            options.ranks > 1,
            Feature::BodiesRigid,
            "a rigid body cannot be distributed over ranks: use one rank",
        )
        .rejects(Feature::BodiesRemoveOutside, "sph has no sides through which points can leave")
        .rejects(
            Feature::BodiesPoreFluid,
            "sph has one phase: where no fluid flows out, use the material undrained",
        )
        .rejects(Feature::BoundariesGroup, "sph has no mesh with groups of nodes")
        .rejects(Feature::BoundariesWallAbsorbing, "sph has no absorbing boundaries")
        .rejects(Feature::BoundariesSeparation, "material cannot lift off the rough and smooth walls of sph")
        .rejects(Feature::BoundariesWallBilateral, "material can always lift off the frictional walls of sph")
        .rejects(Feature::LoadsPorePressure, "sph has one phase: give a total pressure as a `pressure`")
        .rejects(Feature::LoadsAppliedTo, "sph has no nodes: loads act on its particles")
        .rejects(Feature::Patches, "sph has no nodes with a prescribed motion")
        .rejects(Feature::StagesDampingAxes, "sph has the same damping along all axes")
        .rejects(Feature::StagesRayleighDamping, "sph has no Rayleigh damping")
        .rejects(Feature::StagesExcavate, "sph removes whole bodies only: use remove_bodies")
        .rejects(Feature::MeasuresDissipation, "sph does not count dissipation")
        .rejects_if(
            total,
            Feature::Obstacles,
            in_total("obstacles have no effect: use a held body as a clamp"),
        )
        .rejects_if(total, Feature::Boundaries, in_total("walls have no effect: use a held body as a clamp"))
        .rejects_if(total, Feature::StagesRemoveBodies, in_total("bodies cannot be removed"))
        .rejects_if(total, Feature::DomainPeriodic, in_total("a periodic domain is not available"))
}

/// Refuses features that SPH does not support (yet), by name.
pub(super) fn check_supported(case: &Case, options: &SphOptions) -> Result<(), CaseError> {
    check_walls(case, options)?;
    check_obstacles(case, options)?;
    check_obstacle_periods(case)?;
    check_periods(case, options)?;
    check_names(case, options)?;
    check_rigid(case, options)?;
    if options.formulation == LagrangianFormulation::TotalLagrangian {
        total_lagrangian::check_supported(options)?;
    }
    check_density_forms(case, options)
}

/// Checks walls against the options, and motions of walls that do not exist.
fn check_walls(case: &Case, options: &SphOptions) -> Result<(), CaseError> {
    for (number, boundary) in case.boundaries.iter().enumerate() {
        let path = |key: &str| format!("boundaries[{number}].{key}");
        let frictional = matches!(boundary.wall, Wall::Frictional { .. });
        if frictional && options.wall_stress != WallStress::Pairwise {
            return Err(CaseError::new(
                path("wall"),
                "frictional walls act pairwise: set wall_stress to pairwise",
            ));
        }
    }
    for (name, history) in &options.wall_history {
        let path = format!("methods.sph.wall_history.{name}");
        match case.boundaries.iter().find(|boundary| boundary.name() == name) {
            None => {
                return Err(CaseError::new(path, CaseErrorKind::other_name(name, "the name of a wall")));
            }
            Some(wall) if wall.velocity.is_none() => {
                return Err(CaseError::new(
                    path,
                    format!("the wall {name:?} has no velocity, to which the history could apply"),
                ));
            }
            Some(_) => {}
        }
        history.validate().map_err(|(key, problem)| CaseError::new(format!("{path}.{key}"), problem))?;
    }
    Ok(())
}

/// Checks options whose sums need wall particles, which obstacles do not have.
fn check_obstacles(case: &Case, options: &SphOptions) -> Result<(), CaseError> {
    if case.obstacles.is_empty() {
        return Ok(());
    }
    let grad_h = options.is_variable() && options.symmetrisation == Symmetrisation::GradH;
    let surface =
        options.confining.as_ref().is_some_and(|confining| confining.on == ConfiningPressureTarget::Surface);
    for (key, on, cure) in [
        ("wall_stress", options.wall_stress != WallStress::Pairwise, "set pairwise"),
        ("continuity", options.continuity == ContinuityEquation::Summation, "take trace, mass or volume"),
        ("momentum", options.momentum == MomentumEquation::Corrected, "take rho2 or rho-rho"),
        ("symmetrisation", grad_h, "take another, or a constant smoothing length"),
        ("shifting", options.shifting > 0.0, "leave it out"),
        ("confining.on", surface, "take another form"),
    ] {
        if on {
            let problem = format!("is not available with obstacles, which have no particles: {cure}");
            return Err(CaseError::new(format!("methods.sph.{key}"), problem));
        }
    }
    Ok(())
}

/// Refuses motions of obstacles in periodic domains that would need periodic copies: rotations, and motion across a period.
fn check_obstacle_periods(case: &Case) -> Result<(), CaseError> {
    for (number, obstacle) in case.obstacles.iter().enumerate() {
        let Some(motion) = &obstacle.motion else { continue };
        for axis in case.domain.periodic.iter().map(|axis| axis.number()) {
            let along = motion.velocity.get(axis).is_some_and(|v| *v != 0.0);
            let same = matches!(&obstacle.shape, ObstacleShape::Plane { normal, .. } if normal[axis] == 0.0);
            let path = |key: &str| format!("obstacles[{number}].motion.{key}");
            if motion.rotation != 0.0 {
                let problem = "in a periodic domain an obstacle of sph cannot rotate, because it has no \
                               periodic image";
                return Err(CaseError::new(path("rotation"), problem));
            }
            if along && !same {
                let problem = "moves the obstacle across the end of a period, and it does not return on the \
                               other side: along a periodic axis, sph can move only planes parallel to that \
                               axis";
                return Err(CaseError::new(path("velocity"), problem));
            }
        }
    }
    Ok(())
}

/// Checks features that rigid bodies exclude.
fn check_rigid(case: &Case, options: &SphOptions) -> Result<(), CaseError> {
    let Some(number) = case.bodies.iter().position(|body| body.rigid) else { return Ok(()) };
    let problem = |problem: &str| Err(CaseError::new(format!("bodies[{number}].rigid"), problem));
    if options.held.contains(&case.bodies[number].name) {
        return problem(
            "the body is either held (`held`), or rigid with the motion of the `motions`: choose one",
        );
    }
    if options.integration != TimeIntegration::Leapfrog {
        return problem("rigid bodies need methods.sph.integration leapfrog");
    }
    if !case.domain.periodic.is_empty() {
        return problem("in a periodic domain sph has no rigid bodies");
    }
    Ok(())
}

/// Checks the body names in the options.
fn check_names(case: &Case, options: &SphOptions) -> Result<(), CaseError> {
    for (number, name) in options.held.iter().enumerate() {
        if !case.bodies.iter().any(|body| body.name == *name) {
            let problem = CaseErrorKind::other_name(name, "the name of a body");
            return Err(CaseError::new(format!("methods.sph.held[{number}]"), problem));
        }
    }
    for (number, name) in options.smooth_bodies.iter().enumerate() {
        if !options.held.contains(name) {
            let problem = CaseErrorKind::other_name(name, "among the held bodies: only these can be smooth");
            return Err(CaseError::new(format!("methods.sph.smooth_bodies[{number}]"), problem));
        }
    }
    for (name, history) in &options.held_history {
        let path = format!("methods.sph.held_history.{name}");
        if !options.held.contains(name) {
            let problem = CaseErrorKind::other_name(name, "among the held bodies");
            return Err(CaseError::new(path, problem));
        }
        history.validate().map_err(|(key, problem)| CaseError::new(format!("{path}.{key}"), problem))?;
    }
    if case.bodies.iter().all(|body| options.held.contains(&body.name)) {
        return Err(CaseError::new(
            "methods.sph.held",
            CaseErrorKind::coded("nothing-moves", "at least one body must be free to move"),
        ));
    }
    for (number, name) in options.confining.iter().flat_map(|c| c.bodies.iter().flatten()).enumerate() {
        if !case.bodies.iter().any(|body| body.name == *name) {
            let problem = CaseErrorKind::other_name(name, "the name of a body");
            return Err(CaseError::new(format!("methods.sph.confining.bodies[{number}]"), problem));
        }
    }
    Ok(())
}

/// Checks that periodic axes are longer than the kernel range, and a whole number of spacings.
fn check_periods(case: &Case, options: &SphOptions) -> Result<(), CaseError> {
    // Extrapolated walls extend beyond the ends by one reach, and use the soil one reach further out.
    let layers = if options.wall_stress == WallStress::Pairwise { 1.0 } else { 2.0 };
    let reach = options.kernel.support()
        * options.smoothing_length_value()
        * options.smoothing_growth.max(1.2).max(layers);
    for (number, axis) in case.domain.periodic.iter().enumerate() {
        let path = format!("domain.periodic[{number}]");
        let axis = axis.number();
        let length = case.domain.max[axis] - case.domain.min[axis];
        if length < reach {
            let problem =
                format!("the domain is {length} m long, less than the support of a particle, {reach} m");
            return Err(CaseError::new(path, problem));
        }
        let count = length / options.spacing;
        if (count - count.round()).abs() > 1e-6 {
            let problem = format!(
                "the length of the domain is {count} times methods.sph.spacing: a whole number is needed"
            );
            return Err(CaseError::new(path, problem));
        }
    }
    Ok(())
}

/// Checks density by summation across jumps, and options for fluids only.
fn check_density_forms(case: &Case, options: &SphOptions) -> Result<(), CaseError> {
    let (low, high) = densities(case);
    if options.continuity == ContinuityEquation::Summation && low < high && !options.allow_summation {
        let problem = format!(
            "summation smooths the jump between bodies of {low} and {high} kg/m³: use volume, or set \
             allow_summation"
        );
        return Err(CaseError::new("methods.sph.continuity", problem));
    }
    let fluid = case.bodies.iter().any(|body| {
        case.materials.get(&body.material).is_some_and(|spec| spec.model_info().kind == ModelFamily::Fluid)
    });
    for (name, on) in [
        ("density_diffusion", options.density_diffusion > 0.0),
        ("density_reset", options.density_reset != DensityReset::None),
    ] {
        if on && !fluid {
            return Err(CaseError::new(
                format!("methods.sph.{name}"),
                CaseErrorKind::coded("incompatible-options", "is for fluids, but no body is a fluid"),
            ));
        }
    }
    Ok(())
}

/// Checks options that smooth stresses for laws that are not in rate form, where they would have no effect.
pub(super) fn check_stress_forms(groups: &[ParticleGroup], options: &SphOptions) -> Result<(), CaseError> {
    if groups.iter().any(|group| group.material.is_hypoelastic()) {
        return Ok(());
    }
    for (name, on) in [
        ("regularisation", options.regularisation != Regularisation::None),
        ("stress_diffusion", options.stress_diffusion > 0.0),
    ] {
        if on {
            let problem =
                "is for laws in rate form, but no body has one: other laws compute their stress anew";
            return Err(CaseError::new(
                format!("methods.sph.{name}"),
                CaseErrorKind::coded("incompatible-options", problem),
            ));
        }
    }
    Ok(())
}

/// Warnings about the forms of the sums with bodies of different densities.
fn jump_warnings(case: &Case, options: &SphOptions) -> Vec<Warning> {
    let (low, high) = densities(case);
    let mut warnings = Vec::new();
    if options.formulation == LagrangianFormulation::TotalLagrangian {
        return warnings;
    }
    if options.momentum == MomentumEquation::Rho2 && has_jump(case) {
        warnings.push(Warning::new("density-jump", format!(
            "methods.sph.momentum: where bodies of {low} and {high} kg/m³ are in contact, rho2 causes motion \
             even under uniform stress and reflects waves too strongly: use rho-rho"
        )));
    }
    // A gradient that follows the form of the momentum equation is corrected with it.
    let wrong = match (options.continuity, options.velocity_gradient) {
        (ContinuityEquation::Mass, _) => Some(("continuity", "density", "volume")),
        (_, VelocityGradientOperator::DensityDifference) => {
            Some(("velocity_gradient", "strain", "difference"))
        }
        _ => None,
    };
    if let Some((key, what, cure)) = wrong.filter(|_| high >= 2.0 * low) {
        warnings.push(Warning::new("density-jump", format!(
            "methods.sph.{key}: where bodies of {low} and {high} kg/m³ are in contact, weights by mass give a \
             wrong {what}: use {cure}"
        )));
    }
    warnings
}

/// Warning about elastic bodies: they carry tension permanently, under which particles that change neighbours clump.
fn tension_warning(case: &Case, options: &SphOptions) -> Option<Warning> {
    if options.formulation == LagrangianFormulation::TotalLagrangian || options.tensile != Tensile::None {
        return None;
    }
    let elastic = |name: &str| {
        case.materials.get(name).is_some_and(|spec| {
            matches!(
                spec,
                MaterialSpec::LinearElastic(_)
                    | MaterialSpec::NeoHookean(_)
                    | MaterialSpec::StVenantKirchhoff(_)
                    | MaterialSpec::FixedCorotated(_)
            )
        })
    };
    let bears = |b: &&Body| elastic(&b.material) && !b.rigid && !options.held.contains(&b.name);
    let body = case.bodies.iter().find(bears)?;
    Some(Warning::new(
        "tensile-instability",
        format!(
            "methods.sph.tensile: the body {} is elastic. Under tension its particles clump and it breaks up: use \
         artificial-stress, or the formulation total-lagrangian where its particles keep their neighbours",
            body.name
        ),
    ))
}

/// Warning for round boundaries on a lattice, whose steps cause errors of the kernel sums.
fn stepped_edge_warning(case: &Case, options: &SphOptions) -> Option<Warning> {
    if options.formulation != LagrangianFormulation::TotalLagrangian || case.dimension() != 2 {
        return None;
    }
    let stepped = |b: &Body| b.points.is_none() && b.sampling.is_lattice() && b.shape.has_round_edges();
    let number = case.bodies.iter().position(|b| stepped(b) && !options.held.contains(&b.name))?;
    Some(Warning::new(
        "stepped-boundary",
        format!(
            "bodies[{number}].sampling: on a lattice the round sides of {:?} are stepped, and the stress next to \
         them is 10 to 20 % too small at ten particles to a radius: use \"fitted\"",
            case.bodies[number].name
        ),
    ))
}

/// Warnings about the case and its options together.
pub(super) fn warnings(case: &Case, options: &SphOptions) -> Vec<Warning> {
    let mut warnings = case.warnings();
    warnings.extend(options.warnings());
    warnings.extend(stepped_edge_warning(case, options));
    for number in 0..case.bodies.len() {
        let Ok(Some(list)) = case.point_list(number) else { continue };
        let spacing = list.spacing(case.dimension());
        if (spacing / options.spacing - 1.0).abs() > LISTED_SLACK {
            warnings.push(Warning::new("spacing-mismatch", format!(
                "bodies[{number}].points: their mean width is {spacing:.4e} m, but methods.sph.spacing is \
                 {} m, and the smoothing length follows from that. Set it to the mean width",
                options.spacing
            )));
        }
    }
    warnings.extend(jump_warnings(case, options));
    warnings.extend(tension_warning(case, options));
    warnings.extend(rigid_sticking_warning(case));
    let any = |of: &dyn Fn(&Wall) -> bool| case.boundaries.iter().any(|boundary| of(&boundary.wall));
    let of_particles = any(&|wall| !is_mirror(wall, options));
    let (rough, smooth) = (any(&|wall| *wall == Wall::Rough), any(&|wall| *wall == Wall::Smooth));
    let opposes = rough && options.rough_wall != RoughWall::Mirror;
    for (name, is_set, has_effect, none) in [
        ("wall_stress", options.wall_stress != WallStress::default(), of_particles, "is made of particles"),
        ("wall_guard", options.wall_guard != 0.0, of_particles, "is made of particles"),
        ("wall_velocity", options.wall_velocity != WallVelocity::default(), opposes, "of particles is rough"),
        ("rough_wall", options.rough_wall != RoughWall::default(), rough, "is rough"),
        ("smooth_wall", options.smooth_wall != SmoothWall::default(), smooth, "is smooth"),
    ] {
        if is_set && !has_effect {
            warnings.push(Warning::new(
                "option-without-effect",
                format!(
                    "methods.sph.{name}: has no effect, no wall {none}. Leave it out, or change \
                               the wall"
                ),
            ));
        }
    }
    warnings
}
