//! Obstacles, on the nodes or on the points (sheet: mpm §2.11; docs/theory/mpm.md, obstacles).
//!
//! Surfaces with their motion, contact laws and reactions; penalty forces on points, and the limit of their penetration. The module reads
//! points and changes their contact states and nodal velocities. It does not know the contact between bodies; `contact`, `boundary` and the
//! modules above may know it.

pub mod node_obstacles;
pub(crate) mod obstacle_penalty;
mod penalty_law;
pub mod penetration_constraints;
pub(crate) mod penetration_limit;
pub mod point_springs;
pub mod reaction;
pub mod state;

use colluvium_case::description::ObstacleShape;
use colluvium_case::{Case, CaseError, PlacedObstacle, constraining_obstacles};
use colluvium_grid::{NodeFace, NodeFaces};

use crate::background_grid::BackgroundGrid;
use crate::{LagrangianFormulation, MpmOptions, NodalMass, ObstacleCoupling, WallFriction};

/// Rejects options that do not work with obstacles.
pub fn check_supported(case: &Case, options: &MpmOptions) -> Result<(), CaseError> {
    if options.obstacles == ObstacleCoupling::Points {
        return check_point_obstacles(case, options);
    }
    if case.obstacles.is_empty() {
        return Ok(());
    }
    check_node_reactions(case, options)?;
    if case.bodies.iter().any(|body| body.pore_fluid.is_some())
        && let Some(number) = case
            .obstacles
            .iter()
            .position(|obstacle| !lies_on_nodes(case, &obstacle.shape, options.cell_size))
    {
        let problem = "with a pore fluid, an obstacle on nodes must be a plane on a grid line: in cells that \
                       its surface cuts, the pore pressure oscillates or leaks away. Use \
                       `methods.mpm.obstacles` `points`";
        return Err(CaseError::new(format!("obstacles[{number}].shape"), problem));
    }
    if options.mesh.is_some() {
        return Err(rejection(
            "mesh",
            "obstacles do not act on the nodes of a mesh: use walls on groups of the mesh",
        ));
    }
    if options.filters_velocities() {
        return Err(rejection(
            if options.residual_time.is_some() { "residual_time" } else { "transfer" },
            "the filter of the velocities works axis by axis, but obstacles on nodes constrain velocities in \
             any direction",
        ));
    }
    if options.wall_friction == WallFriction::Acceleration {
        return Err(rejection(
            "wall_friction",
            "acceleration is for walls only: the friction of obstacles follows from impulses",
        ));
    }
    Ok(())
}

/// Error of an option that does not work with obstacles.
fn rejection(key: &str, problem: &str) -> CaseError {
    CaseError::new(format!("methods.mpm.{key}"), problem)
}

/// Rejects options that do not work with obstacles that act on points.
fn check_point_obstacles(case: &Case, options: &MpmOptions) -> Result<(), CaseError> {
    if case.obstacles.is_empty() {
        return Err(rejection("obstacles", "points needs an obstacle in the case"));
    }
    if options.formulation != LagrangianFormulation::UpdatedLagrangian {
        return Err(rejection(
            "obstacles",
            "points needs formulation updated-lagrangian, in which points move in space",
        ));
    }
    Ok(())
}

/// Rejects measured reactions and moving obstacles with options that do not support them for obstacles on nodes.
fn check_node_reactions(case: &Case, options: &MpmOptions) -> Result<(), CaseError> {
    for (name, measure) in &case.measures {
        if let Some(target) = measure.reaction_target()
            && case.obstacles.iter().any(|obstacle| obstacle.name == target)
            && let Some(reason) = why_not_recorded(options)
        {
            let problem = format!(
                "with {reason} mpm records the reaction of an obstacle with `methods.mpm.obstacles` `points` \
                 only"
            );
            return Err(CaseError::new(format!("measures.{name}.target"), problem));
        }
    }
    if let Some(number) = case.obstacles.iter().position(|obstacle| obstacle.motion.is_some())
        && let Some(reason) = reason_for_rest(case, options)
    {
        let problem =
            format!("with {reason} an obstacle of mpm can move with `methods.mpm.obstacles` `points` only");
        return Err(CaseError::new(format!("obstacles[{number}].motion"), problem));
    }
    Ok(())
}

/// Whether saturated bodies have contact on points with obstacles that nodes could represent exactly.
pub fn could_act_on_nodes(case: &Case, options: &MpmOptions) -> bool {
    let wet = case.bodies.iter().any(|body| body.pore_fluid.is_some());
    let on_nodes = |shape: &ObstacleShape| lies_on_nodes(case, shape, options.cell_size);
    let are_fixed_planes =
        case.obstacles.iter().all(|obstacle| on_nodes(&obstacle.shape) && obstacle.motion.is_none());
    let free = options.mesh.is_none() && !options.filters_velocities();
    wet && are_fixed_planes && free && options.obstacles == ObstacleCoupling::Points
}

/// Whether the surface of a shape is a plane through grid nodes.
fn lies_on_nodes(case: &Case, shape: &ObstacleShape, cell: f64) -> bool {
    let ObstacleShape::Plane { point, normal } = shape else { return false };
    let mut across = (0..normal.len()).filter(|axis| normal[*axis] != 0.0);
    let (Some(axis), None) = (across.next(), across.next()) else { return false };
    let cells = (point[axis] - case.domain.min[axis]) / cell;
    (cells - cells.round()).abs() < 1e-6
}

/// Reason for which reactions of obstacles on nodes are not recorded; `None` if they are.
pub fn why_not_recorded(options: &MpmOptions) -> Option<&'static str> {
    if options.mass == NodalMass::Consistent {
        Some("a consistent mass")
    } else if !options.contacts.is_empty() {
        Some("contacts")
    } else {
        None
    }
}

/// Reason for which obstacles on nodes cannot move; `None` if they can.
fn reason_for_rest(case: &Case, options: &MpmOptions) -> Option<&'static str> {
    let wet = case.bodies.iter().any(|body| body.pore_fluid.is_some());
    why_not_recorded(options).or(wet.then_some("a pore fluid"))
}

/// Faces of obstacles for the nodes of the pore fluid. The fluid slips along them without penetration, and separates if the skeleton may.
pub fn pore_fluid_faces<const D: usize>(
    placed: &[PlacedObstacle<'_, D>],
    background: &BackgroundGrid<D>,
) -> NodeFaces {
    let BackgroundGrid { grid, layout, basis_1d: axis, .. } = background;
    if placed.is_empty() {
        return NodeFaces::default();
    }
    NodeFaces::from_positions(grid, layout, axis, |place, found| {
        let constraining = constraining_obstacles(placed, place, grid.cell);
        found.extend(
            constraining.map(|(_, law, normal)| NodeFace::at_rest(normal, 0.0, law.allows_separation())),
        );
    })
}
