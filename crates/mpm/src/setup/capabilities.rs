//! Capabilities of MPM for the features of a case.

use colluvium_case::{Capabilities, Case, CaseError, Feature};

use crate::{LagrangianFormulation, MpmOptions, NodalMass, ObstacleCoupling, ShapeFunctions};

/// Features that MPM supports in addition to those of all point methods.
const SUPPORTED: &[Feature] = &[
    Feature::SpaceAxisymmetric,
    Feature::DomainOrigin,
    Feature::BodiesRemoveOutside,
    Feature::BodiesRigid,
    Feature::Boundaries,
    Feature::BoundariesName,
    Feature::BoundariesGroup,
    Feature::BoundariesPosition,
    Feature::BoundariesSeparation,
    Feature::BoundariesVelocity,
    Feature::BoundariesDrained,
    Feature::BoundariesWallRough,
    Feature::BoundariesWallSmooth,
    Feature::BoundariesWallFrictional,
    Feature::BoundariesWallBilateral,
    Feature::BoundariesWallAbsorbing,
    Feature::BoundariesWallNormal,
    Feature::BoundariesWallTangential,
    Feature::BoundariesWallSpringLength,
    Feature::Obstacles,
    Feature::ObstaclesWallRough,
    Feature::ObstaclesWallSmooth,
    Feature::ObstaclesWallFrictional,
    Feature::ObstaclesSeparation,
    Feature::Patches,
    Feature::PatchesMoves,
    Feature::PatchesDrained,
    Feature::StagesDamping,
    Feature::StagesDampingAxes,
    Feature::StagesRayleighDamping,
    Feature::MeasuresReaction,
    Feature::MeasuresImpactPressure,
    Feature::MeasuresDissipation,
];

/// Features that MPM supports with all their variants and keys, in addition to those of all point methods.
const SUPPORTED_WHOLLY: &[Feature] = &[
    Feature::DomainPeriodic,
    Feature::BodiesPoreFluid,
    Feature::BoundariesSide,
    Feature::ObstaclesShape,
    Feature::ObstaclesMotion,
    Feature::ObstaclesRegions,
    Feature::Loads,
    Feature::PatchesRegion,
    Feature::StagesMotions,
    Feature::StagesExcavate,
];

/// Returns the capabilities of MPM with the options of the case.
pub fn capabilities(case: &Case) -> Result<Capabilities, CaseError> {
    let options = crate::setup::options(case)?;
    let mut honours = Capabilities::for_point_methods("mpm").supports(SUPPORTED).supports_all_of(SUPPORTED_WHOLLY).rejects(
        Feature::BodiesPoreFluidExcessRatio,
        "is the initial state of the columns of depth-integrated flow: for mpm give the initial `pressure`, \
         as a formula",
    );
    honours = if options.obstacles == ObstacleCoupling::Points {
        honours.supports(&[Feature::ObstaclesWallAdhesion])
    } else {
        let problem = "mpm has no contact area for obstacles on nodes: use `methods.mpm.obstacles` `points`, \
                       or leave out the adhesion";
        honours
            .rejects(Feature::ObstaclesWallAdhesion, problem)
            .rejects(Feature::ObstaclesRegionsWallAdhesion, problem)
    };
    if case.bodies.iter().any(|body| body.pore_fluid.is_some()) {
        let rigid = "mpm with a pore_fluid has no rigid bodies: take an obstacle, which may move (`obstacles.motion`), with \
                     `methods.mpm.obstacles` `points`";
        honours = without_rigid(honours, "mpm with a pore_fluid")
            .rejects(Feature::BodiesRigid, rigid)
            .rejects(Feature::StagesRayleighDamping, "mpm with a pore_fluid has no Rayleigh damping")
            .rejects(Feature::MeasuresDissipation, "mpm with a pore_fluid does not count dissipation");
    }
    if options.formulation == LagrangianFormulation::TotalLagrangian {
        let name = "the total-Lagrangian formulation of mpm";
        honours = without_driven(honours, name)
            .rejects(
                Feature::BodiesRemoveOutside,
                format!("{name} has no sides through which points can leave"),
            )
            .rejects(
                Feature::Obstacles,
                format!("{name} has its grid in the initial configuration, where obstacles cannot act"),
            );
    }
    if options.mesh.is_some() {
        let problem =
            "mpm does not shift the mesh of a file: give mesh and case the same coordinates near zero";
        honours = honours.rejects(Feature::DomainOrigin, problem);
    }
    if options.shape == ShapeFunctions::DualDomain {
        let problem = "is not available with shape dual-domain";
        honours =
            honours.rejects(Feature::DomainPeriodic, problem).rejects(Feature::BodiesPoreFluid, problem);
        honours = honours.rejects(Feature::Obstacles, problem);
    }
    if case.bodies.iter().any(|body| body.rigid && case.moves_freely(&body.name)) {
        honours = restrict_free_rigid(honours, &options);
    }
    if options.mass == NodalMass::Consistent {
        honours = restrict_consistent_mass(honours);
    }
    Ok(honours)
}

/// Rejects features and options that do not work with free rigid bodies.
fn restrict_free_rigid(honours: Capabilities, options: &MpmOptions) -> Capabilities {
    let name = "a rigid body that moves freely (a null in the velocity of its motion, or `turns`)";
    let on_nodes = options.obstacles == ObstacleCoupling::Nodes;
    let mut honours = honours
        .rejects_if(
            on_nodes,
            Feature::Obstacles,
            format!("{name} needs methods.mpm.obstacles `points` for contact with obstacles"),
        )
        .rejects(Feature::DomainPeriodic, format!("{name} has no periodic image"))
        .rejects(Feature::BodiesPoreFluid, format!("{name} has no contact with pore fluid"));
    if matches!(options.shape, ShapeFunctions::Cpdi | ShapeFunctions::Cpdi2) {
        let problem = "the domains of cpdi do not rotate with a rigid body: use another shape";
        honours = honours.rejects(Feature::StagesMotionsTurns, problem);
    }
    honours
}

/// Rejects features that do not work with a consistent mass matrix, which couples all nodes.
fn restrict_consistent_mass(honours: Capabilities) -> Capabilities {
    without_driven(honours, "mpm with mass consistent")
        .rejects(Feature::DomainPeriodic, "with mass consistent a periodic domain is not available")
        .rejects(Feature::Obstacles, "with mass consistent obstacles are not available")
        .rejects(Feature::BodiesPoreFluid, "with mass consistent a pore fluid is not available")
        .rejects(
            Feature::StagesEquilibrium,
            "with mass consistent equilibrium is not measured: use mass lumped for stages that end at rest",
        )
}

/// Capabilities without rigid bodies and without damping per axis.
fn without_rigid(honours: Capabilities, name: &str) -> Capabilities {
    honours
        .rejects(Feature::BodiesRigid, format!("{name} has no rigid bodies"))
        .rejects(Feature::StagesDampingAxes, format!("{name} has the same damping along all axes"))
}

/// Capabilities without rigid bodies and without patches of prescribed velocity.
fn without_driven(honours: Capabilities, name: &str) -> Capabilities {
    without_rigid(honours, name)
        .rejects(Feature::Patches, format!("{name} cannot prescribe the motion of nodes"))
}
