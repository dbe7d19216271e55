//! Capabilities of depth-integrated SPH: rejected features of a case, by path, and warnings.

use colluvium_case::description::{Body, Boundary, Velocity, Wall};
use colluvium_case::{Capabilities, Case, CaseError, CaseErrorKind, Feature, RequiredInput};

use crate::boundary::stages::is_equilibration_stage;
use crate::config::DepthOptions;
use crate::config::choices::{Phases, SearchOrientation};
use crate::setup::bed::case_bed::{is_smooth, lowest};
use crate::setup::{NAME, pore_fluid};
use colluvium_case::Warning;

/// Numbers of nodes of a profile and of a flow in plan below which the resolution is too coarse (sheet: depth-sph §0).
const MIN_NODES: [usize; 2] = [10, 30];

/// Note on the sampling of a body.
const LATTICE: &str = "is ignored, because depth-sph nodes lie on a lattice";

/// Message for spaces in which the method does not compute.
const SPACES: &str = "depth-sph computes flow along a profile (plane-strain, gravity along y) or over \
                      terrain (3d, gravity along z)";

/// Features that depth-integrated SPH supports in addition to those of all point methods.
const SUPPORTED: &[Feature] = &[
    Feature::DomainOrigin,
    Feature::Obstacles,
    Feature::MeasuresGauge,
    Feature::MeasuresDischarge,
    Feature::Boundaries,
    Feature::BoundariesName,
    Feature::BoundariesPosition,
    Feature::BoundariesSeparation,
    Feature::BoundariesVelocity,
    Feature::BoundariesDrained,
    Feature::BoundariesWallRough,
    Feature::BoundariesWallSmooth,
    Feature::BoundariesWallFrictional,
    Feature::BoundariesWallAbsorbing,
    Feature::StagesDamping,
];

/// Features that depth-integrated SPH supports with all their variants and keys, in addition to those of all point methods.
const SUPPORTED_WHOLLY: &[Feature] = &[
    Feature::DomainPeriodic,
    Feature::ObstaclesShape,
    Feature::ObstaclesWall,
    Feature::ObstaclesRegions,
    Feature::OutputRasters,
    Feature::BodiesPoreFluid,
    Feature::BoundariesSide,
];

/// Capabilities of the method for the features of a case.
pub(crate) fn capabilities() -> Capabilities {
    Capabilities::for_point_methods(NAME)
        .supports(SUPPORTED)
        .supports_all_of(SUPPORTED_WHOLLY)
        .requires(RequiredInput { gravity: true, ..RequiredInput::default() })
        .rejects(Feature::SpaceOneD, SPACES)
        .rejects(Feature::SpaceAxisymmetric, SPACES)
        .rejects(Feature::BodiesRigid, "depth-sph has no rigid bodies")
        .ignores_with_warning(
            Feature::BodiesPoreFluidBulkModulus,
            "is ignored, because the pore fluid of depth-sph is incompressible",
        )
        .rejects(
            Feature::BodiesRemoveOutside,
            "nodes that leave the terrain are removed: see methods.depth-sph.leaving_is_an_error",
        )
        .ignores_with_warning(
            Feature::ObstaclesSeparation,
            "is ignored, because depth-sph flows stay on the bed",
        )
        .ignores_all_of_with_warning(Feature::BodiesSampling, LATTICE)
        .ignores_with_warning(Feature::BodiesSamplingSeed, LATTICE)
        .ignores_with_warning(
            Feature::BodiesShapeRowsTerrain,
            "is ignored, because depth-sph has columns and no rows of points",
        )
        .rejects(Feature::ObstaclesWallAdhesion, "give the resistance of the bed in methods.depth-sph.basal")
        .rejects(
            Feature::ObstaclesRegionsWallAdhesion,
            "give the resistance of parts of the bed in methods.depth-sph.regions",
        )
        .rejects(Feature::BoundariesGroup, "depth-sph has no mesh with groups of nodes")
        .rejects(Feature::Loads, "depth-sph cannot apply tractions")
        .rejects(Feature::Patches, "depth-sph cannot prescribe the motion of patches")
        .rejects(Feature::StagesExcavate, "depth-sph removes whole bodies only: use remove_bodies")
        .rejects_all_of(
            Feature::StagesWeakening,
            "depth-sph cannot change the strength of the bed in a stage",
        )
        .rejects(Feature::MeasuresFactorOfSafety, "depth-sph cannot reduce the strength of a slope")
        .rejects(
            Feature::MeasuresDissipation,
            "use the columns energy_friction and energy_viscosity of depth-sph",
        )
}

/// Rejects by name the features that the method does not support.
pub(super) fn check_supported(case: &Case, options: &DepthOptions) -> Result<(), CaseError> {
    let last = case.dimension() - 1;
    if !(case.gravity[last] < 0.0) {
        let problem =
            format!("{} must be negative: depth is measured opposite to gravity", case.gravity[last]);
        return Err(CaseError::new(format!("gravity[{last}]"), problem));
    }
    let first = options.smoothing_ratio(last) * options.spacing;
    if let Some(shortest) = options.shortest_smoothing.filter(|shortest| *shortest > first) {
        let problem = format!("{shortest} m is longer than the initial smoothing length, {first} m");
        return Err(crate::setup::option_error("shortest_smoothing", problem));
    }
    if options.search == SearchOrientation::Turned && last == 1 {
        return Err(crate::setup::option_error(
            "search",
            CaseErrorKind::coded("conflicting-keys", "a profile has one axis: leave this out"),
        ));
    }
    check_walls(case)?;
    check_open_boundaries(case, options)?;
    pore_fluid::check_supported(case, options)?;
    check_bodies(case, options)
}

/// Rejects walls above the flow and walls that move.
fn check_walls(case: &Case) -> Result<(), CaseError> {
    let up = case.dimension() - 1;
    for (number, boundary) in case.boundaries.iter().enumerate() {
        let path = |key: &str| format!("boundaries[{number}].{key}");
        if boundary.side.axis() == up && boundary.side != lowest(case) {
            return Err(CaseError::new(
                path("side"),
                CaseErrorKind::coded(
                    "incompatible-options",
                    "a flow of depth-sph has a free surface: a wall above it is not available",
                ),
            ));
        }
        if boundary.velocity.as_ref().is_some_and(|velocity| velocity.iter().any(|v| *v != 0.0)) {
            return Err(CaseError::new(path("velocity"), "must be 0: the walls of depth-sph do not move"));
        }
    }
    Ok(())
}

/// Rejects an absorbing layer without an open boundary, or without space for it.
fn check_absorbing_layer(case: &Case, length: f64) -> Result<(), CaseError> {
    let mut absorbing =
        case.boundaries.iter().filter(|side| matches!(side.wall, Wall::Absorbing { .. })).peekable();
    if absorbing.peek().is_none() {
        return Err(crate::setup::option_error(
            "absorbing_layer",
            CaseErrorKind::coded("conflicting-keys", "no side is absorbing: leave this out"),
        ));
    }
    let room = |side: &Boundary| case.domain.max[side.side.axis()] - case.domain.min[side.side.axis()];
    match absorbing.find(|side| 2.0 * length > room(side)) {
        Some(side) => {
            let problem = format!(
                "{length} m is more than half of the length of the domain normal to the side {:?}",
                side.name()
            );
            Err(crate::setup::option_error("absorbing_layer", problem))
        }
        None => Ok(()),
    }
}

/// Checks that the phases of the flow support open boundaries: one phase, grains and fluid, or two layers.
fn check_open_boundaries(case: &Case, options: &DepthOptions) -> Result<(), CaseError> {
    let up = case.dimension() - 1;
    if let Some(length) = options.absorbing_layer {
        if options.phases == Phases::Layers && up > 1 {
            let problem = "is not available for two layers in 3d, because its reflection of their waves is \
                           known for profiles only: leave it out, absorbing sides transmit the waves of \
                           two layers without it";
            return Err(crate::setup::option_error(
                "absorbing_layer",
                CaseErrorKind::coded("conflicting-keys", problem),
            ));
        }
        check_absorbing_layer(case, length)?;
    }
    for (number, boundary) in case.boundaries.iter().enumerate() {
        if !matches!(boundary.wall, Wall::Absorbing { .. }) {
            continue;
        }
        let wrong = |problem: &str| Err(CaseError::new(format!("boundaries[{number}].wall"), problem));
        if boundary.side.axis() == up {
            return wrong("the bed cannot be absorbing: only a side can");
        }
        let others = || case.boundaries.iter().enumerate().filter(|(other, _)| *other != number);
        if others().any(|(_, other)| other.side == boundary.side) {
            return wrong("the side has another wall: leave one of them out");
        }
        if case.stages.iter().any(|stage| stage.remove_boundaries.iter().any(|name| name == boundary.name()))
        {
            return wrong("is removed by a stage, but depth-sph cannot remove an absorbing side");
        }
    }
    Ok(())
}

/// Rejects an initial velocity that is not along the bed.
pub(super) fn check_velocity_along_bed(velocity: &Velocity, path: &str, up: usize) -> Result<(), CaseError> {
    match velocity {
        Velocity::Uniform { value } if value[up] != 0.0 => {
            let problem = "must be 0: the initial velocity of a flow of depth-sph is along the bed";
            Err(CaseError::new(format!("{path}.value[{up}]"), problem))
        }
        _ => Ok(()),
    }
}

/// Rejects velocities across the bed and combinations of bodies with different materials that the method cannot compute.
fn check_bodies(case: &Case, options: &DepthOptions) -> Result<(), CaseError> {
    let up = case.dimension() - 1;
    for (number, body) in case.bodies.iter().enumerate() {
        let path = |key: &str| format!("bodies[{number}].{key}");
        check_velocity_along_bed(&body.velocity, &path("velocity"), up)?;
        let upper =
            |name: &String| options.mixture.as_ref().is_some_and(|mixture| mixture.upper.contains(name));
        // Bodies of porosities of their own differ by density; the law of the bed must be given for all of them, or the bed is smooth.
        let one_law = options.basal.is_some() || is_smooth(case);
        let mixed = |name: &String| {
            one_law && options.mixture.as_ref().is_some_and(|mixture| mixture.porosities.contains_key(name))
        };
        let is_other = |other: &&Body| {
            other.material != body.material
                && upper(&other.name) == upper(&body.name)
                && !(mixed(&other.name) || mixed(&body.name))
        };
        let other = case.bodies[..number].iter().find(is_other);
        if let Some(other) = other {
            let problem = format!(
                "{:?} is not the material of the body {:?}, {:?}: a flow of depth-sph has one material, \
                 unless the bodies differ by mixture.porosities and methods.depth-sph.basal gives the law \
                 of the bed",
                body.material, other.name, other.material
            );
            return Err(CaseError::new(path("material"), problem));
        }
    }
    let named = |key: &str, name: &String| {
        let known = case.bodies.iter().any(|body| body.name == *name);
        let problem =
            || crate::setup::option_error(key, CaseErrorKind::other_name(name, "the name of a body"));
        if known { Ok(()) } else { Err(problem()) }
    };
    let Some(mixture) = &options.mixture else { return Ok(()) };
    mixture.upper.iter().try_for_each(|name| named("mixture.upper", name))?;
    mixture.porosities.keys().try_for_each(|name| named("mixture.porosities", name))
}

/// Warnings about inputs that are allowed.
pub(super) fn warnings(case: &Case, nodes: usize) -> Vec<Warning> {
    let mut warnings = case.warnings();
    let needed = MIN_NODES[usize::from(case.dimension() > 2)];
    if nodes < needed {
        warnings.push(Warning::new(
            "few-nodes",
            format!(
                "methods.{NAME}.spacing: {nodes} nodes are too few to resolve a flow ({needed} are needed): make it \
                 smaller"
            ),
        ));
    }
    for (number, stage) in case.stages.iter().enumerate() {
        if is_equilibration_stage(stage) {
            warnings.push(Warning::new(
                "idle-stage",
                format!(
                    "stages[{number}]: the flow does not move in this stage, which equilibrates the initial \
                 stress: depth-integrated flow does not need it. Leave it out"
                ),
            ));
        }
    }
    let sticks = |boundary: &&Boundary| {
        boundary.side.axis() + 1 < case.dimension()
            && !matches!(boundary.wall, Wall::Smooth | Wall::Absorbing { .. })
    };
    if let Some(boundary) = case.boundaries.iter().find(sticks) {
        warnings.push(Warning::new(
            "side-wall-friction-ignored",
            format!(
                "boundaries: the side wall {:?} acts as a smooth wall; its friction is ignored. Make it \
             `smooth`",
                boundary.name()
            ),
        ));
    }
    if case.bodies.iter().any(|body| body.stress != colluvium_case::description::InitialStress::None) {
        warnings.push(Warning::new(
            "stress-ignored",
            "bodies: the given initial stress is ignored: the stress of depth-integrated flow follows from \
             the weight over the depth. Leave `stress` out",
        ));
    }
    warnings
}
