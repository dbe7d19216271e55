//! Capabilities of MPM for the features of a case.

use colluvium_case::{Capabilities, Case, CaseError};

use crate::{LagrangianFormulation, MpmOptions, NodalMass, ObstacleCoupling, ShapeFunctions};

/// Features that MPM supports in addition to those of all point methods.
const SUPPORTED: [&str; 44] = [
    "space=axisymmetric",
    "domain.origin",
    "domain.periodic*",
    "bodies.remove_outside",
    "bodies.rigid",
    "bodies.pore_fluid*",
    "boundaries",
    "boundaries.name",
    "boundaries.side=*",
    "boundaries.group",
    "boundaries.position",
    "boundaries.separation",
    "boundaries.velocity",
    "boundaries.drained",
    "boundaries.wall=rough",
    "boundaries.wall=smooth",
    "boundaries.wall=frictional",
    "boundaries.wall.bilateral",
    "boundaries.wall=absorbing",
    "boundaries.wall.normal",
    "boundaries.wall.tangential",
    "boundaries.wall.spring_length",
    "obstacles",
    "obstacles.shape=*",
    "obstacles.shape.*",
    "obstacles.motion*",
    "obstacles.wall=rough",
    "obstacles.wall=smooth",
    "obstacles.wall=frictional",
    "obstacles.separation",
    "obstacles.regions*",
    "loads*",
    "patches",
    "patches.moves",
    "patches.drained",
    "patches.region*",
    "stages.damping",
    "stages.damping_axes",
    "stages.rayleigh_damping",
    "stages.motions*",
    "stages.excavate*",
    "measures=reaction",
    "measures=impact-pressure",
    "measures=dissipation",
];

/// Returns the capabilities of MPM with the options of the case.
pub fn capabilities(case: &Case) -> Result<Capabilities, CaseError> {
    let options = crate::setup::options(case)?;
    let mut honours = Capabilities::for_point_methods("mpm").supports(&SUPPORTED).rejects(
        "bodies.pore_fluid.excess_ratio",
        "is the initial state of the columns of depth-integrated flow: for mpm give the initial `pressure`, \
         as a formula",
    );
    honours = if options.obstacles == ObstacleCoupling::Points {
        honours.supports(&["obstacles.wall.adhesion"])
    } else {
        let problem = "mpm has no contact area for obstacles on nodes: use `methods.mpm.obstacles` `points`, \
                       or leave out the adhesion";
        honours
            .rejects("obstacles.wall.adhesion", problem)
            .rejects("obstacles.regions.wall.adhesion", problem)
    };
    if case.bodies.iter().any(|body| body.pore_fluid.is_some()) {
        let rigid = "mpm with a pore_fluid has no rigid bodies: take an obstacle, which may move (`obstacles.motion`), with \
                     `methods.mpm.obstacles` `points`";
        honours = without_rigid(honours, "mpm with a pore_fluid")
            .rejects("bodies.rigid", rigid)
            .rejects("stages.rayleigh_damping", "mpm with a pore_fluid has no Rayleigh damping")
            .rejects("measures=dissipation", "mpm with a pore_fluid does not count dissipation");
    }
    if options.formulation == LagrangianFormulation::TotalLagrangian {
        let name = "the total-Lagrangian formulation of mpm";
        honours = without_driven(honours, name)
            .rejects("bodies.remove_outside", format!("{name} has no sides through which points can leave"))
            .rejects(
                "obstacles",
                format!("{name} has its grid in the initial configuration, where obstacles cannot act"),
            );
    }
    if options.mesh.is_some() {
        let problem =
            "mpm does not shift the mesh of a file: give mesh and case the same coordinates near zero";
        honours = honours.rejects("domain.origin", problem);
    }
    if options.shape == ShapeFunctions::DualDomain {
        let problem = "is not available with shape dual-domain";
        honours = honours.rejects("domain.periodic", problem).rejects("bodies.pore_fluid", problem);
        honours = honours.rejects("obstacles", problem);
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
            "obstacles",
            format!("{name} needs methods.mpm.obstacles `points` for contact with obstacles"),
        )
        .rejects("domain.periodic", format!("{name} has no periodic image"))
        .rejects("bodies.pore_fluid", format!("{name} has no contact with pore fluid"));
    if matches!(options.shape, ShapeFunctions::Cpdi | ShapeFunctions::Cpdi2) {
        let problem = "the domains of cpdi do not rotate with a rigid body: use another shape";
        honours = honours.rejects("stages.motions.turns", problem);
    }
    honours
}

/// Rejects features that do not work with a consistent mass matrix, which couples all nodes.
fn restrict_consistent_mass(honours: Capabilities) -> Capabilities {
    without_driven(honours, "mpm with mass consistent")
        .rejects("domain.periodic", "with mass consistent a periodic domain is not available")
        .rejects("obstacles", "with mass consistent obstacles are not available")
        .rejects("bodies.pore_fluid", "with mass consistent a pore fluid is not available")
        .rejects(
            "stages.equilibrium",
            "with mass consistent equilibrium is not measured: use mass lumped for stages that end at rest",
        )
}

/// Capabilities without rigid bodies and without damping per axis.
fn without_rigid(honours: Capabilities, name: &str) -> Capabilities {
    honours
        .rejects("bodies.rigid", format!("{name} has no rigid bodies"))
        .rejects("stages.damping_axes", format!("{name} has the same damping along all axes"))
}

/// Capabilities without rigid bodies and without patches of prescribed velocity.
fn without_driven(honours: Capabilities, name: &str) -> Capabilities {
    without_rigid(honours, name).rejects("patches", format!("{name} cannot prescribe the motion of nodes"))
}
