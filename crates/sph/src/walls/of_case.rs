//! From a case to the walls of a stage.

use colluvium_case::description::{Axis, ObstacleWall, Wall};
use colluvium_case::{Case, CaseError};

use super::image::Period;
use super::plane::{Contact, Plane};
use super::planes::{Planes, sites};
use crate::config::{RoughWall, SmoothWall, SphOptions};
use crate::setting::corner;

/// Walls of more particles than this are refused, as bodies are: they would not fit in memory.
const MOST_OF_WALLS: f64 = (1u64 << 28) as f64;

/// Whether a wall is made of mirror images, not of particles.
pub fn mirrors(wall: &Wall, options: &SphOptions) -> bool {
    match wall {
        Wall::Smooth => options.smooth_wall == SmoothWall::Mirror,
        Wall::Rough => options.rough_wall == RoughWall::Mirror,
        Wall::Absorbing { .. } | Wall::Frictional { .. } => false,
    }
}

/// The box that walls of particles cover (m), and how deep they are, for a kernel of the radius `reach` (m).
fn extent<const D: usize>(case: &Case, options: &SphOptions, reach: f64) -> (([f64; D], [f64; D]), f64) {
    let growth = if options.is_variable() { options.smoothing_growth } else { 1.0 };
    ((corner(&case.domain.min), corner(&case.domain.max)), reach * growth)
}

/// How many particles the walls of all stages have, for a kernel of the radius `reach` (m).
pub fn wall_sites<const D: usize>(case: &Case, options: &SphOptions, reach: f64) -> f64 {
    let (span, depth) = extent::<D>(case, options, reach);
    let of_particles = case.boundaries.iter().filter(|boundary| !mirrors(&boundary.wall, options));
    let sites = |axis| sites(axis, &span, options.spacing, depth).iter().product::<f64>();
    of_particles.map(|boundary| sites(boundary.side.axis())).sum()
}

/// Walls of particles along a large domain would not fit in memory.
pub fn check_walls<const D: usize>(case: &Case, options: &SphOptions, reach: f64) -> Result<(), CaseError> {
    let count = wall_sites::<D>(case, options, reach);
    if count <= MOST_OF_WALLS {
        return Ok(());
    }
    let problem = format!(
        "its walls would need about {count:.2e} particles, more than 2^28: make it smaller, or use a larger spacing"
    );
    Err(CaseError::new("domain", problem))
}

/// The walls of a stage, those of particles for a kernel of the radius `reach` (m).
pub fn planes<const D: usize>(case: &Case, stage: usize, options: &SphOptions, reach: f64) -> Planes<D> {
    let (mut mirrored, mut faces) = (Vec::new(), Vec::new());
    for (number, boundary) in case.active_boundaries(stage) {
        let contact = match boundary.wall {
            Wall::Smooth => Contact::FreeSlip,
            // Absorbing sides are refused.
            Wall::Rough | Wall::Absorbing { .. } => Contact::NoSlip,
            Wall::Frictional { friction_coefficient, .. } => Contact::Friction(friction_coefficient),
        };
        let history = options.wall_history.get(boundary.name()).cloned();
        let kind = if mirrors(&boundary.wall, options) { &mut mirrored } else { &mut faces };
        kind.push(Plane {
            boundary: number,
            axis: boundary.side.axis(),
            position: boundary.position(&case.domain),
            upper: boundary.side.is_max(),
            velocity: boundary.velocity.as_ref().map_or([0.0; D], |velocity| corner(velocity)),
            factor: history.as_ref().map_or(1.0, |history| history.at(0.0)),
            history,
            moved: 0.0,
            contact,
        });
    }
    let period = |axis: &Axis| {
        let axis = axis.number();
        Period { axis, low: case.domain.min[axis], high: case.domain.max[axis] }
    };
    let periods = case.domain.periodic.iter().map(period).collect();
    let (span, depth) = extent(case, options, reach);
    Planes::new(mirrored, faces, periods, span, options.spacing, depth)
}

/// Whether a wall of some stage or a part of an obstacle is frictional.
pub fn has_friction(case: &Case) -> bool {
    let of_part = |wall: &ObstacleWall| matches!(wall, ObstacleWall::Frictional { .. });
    case.boundaries.iter().any(|boundary| matches!(boundary.wall, Wall::Frictional { .. }))
        || case.obstacles.iter().any(|obstacle| {
            of_part(&obstacle.wall) || obstacle.regions.iter().any(|region| of_part(&region.wall))
        })
}
