//! Construction of the walls of a stage from a case.

use colluvium_case::description::{Axis, ObstacleWall, Wall};
use colluvium_case::{Case, CaseError};

use crate::boundary::flat_wall::{FlatWall, WallContact};
use crate::boundary::flat_walls::{FlatWalls, particle_counts};
use crate::boundary::image_particle::PeriodicAxis;
use crate::config::{RoughWall, SmoothWall, SphOptions};
use crate::context::leading_components;
use colluvium_case::CaseErrorKind;

/// Largest number of wall particles; a case with more is rejected, because they would not fit in memory.
const MAX_WALL_PARTICLES: f64 = (1u64 << 28) as f64;

/// Whether a wall consists of mirror images instead of particles.
pub fn is_mirror(wall: &Wall, options: &SphOptions) -> bool {
    match wall {
        Wall::Smooth => options.smooth_wall == SmoothWall::Mirror,
        Wall::Rough => options.rough_wall == RoughWall::Mirror,
        Wall::Absorbing { .. } | Wall::Frictional { .. } => false,
    }
}

/// Lower and upper corner of the box around which walls have particles (m), and the depth of the walls (m) for a kernel radius (m).
fn extent<const D: usize>(case: &Case, options: &SphOptions, reach: f64) -> (([f64; D], [f64; D]), f64) {
    let growth = if options.is_variable() { options.smoothing_growth } else { 1.0 };
    ((leading_components(&case.domain.min), leading_components(&case.domain.max)), reach * growth)
}

/// Number of wall particles over all stages, for a kernel radius (m).
pub fn wall_particle_count<const D: usize>(case: &Case, options: &SphOptions, reach: f64) -> f64 {
    let (span, depth) = extent::<D>(case, options, reach);
    let of_particles = case.boundaries.iter().filter(|boundary| !is_mirror(&boundary.wall, options));
    let sites = |axis| particle_counts(axis, &span, options.spacing, depth).iter().product::<f64>();
    of_particles.map(|boundary| sites(boundary.side.axis())).sum()
}

/// Rejects walls whose particles would not fit in memory.
pub fn check_walls<const D: usize>(case: &Case, options: &SphOptions, reach: f64) -> Result<(), CaseError> {
    let count = wall_particle_count::<D>(case, options, reach);
    if count <= MAX_WALL_PARTICLES {
        return Ok(());
    }
    let problem = format!(
        "its walls would need about {count:.2e} particles, more than 2^28: make it smaller, or use a larger spacing"
    );
    Err(CaseError::new("domain", CaseErrorKind::coded("too-many-points", problem)))
}

/// Flat walls of a stage; those with particles have layers for a kernel radius `reach` (m).
pub fn flat_walls<const D: usize>(
    case: &Case,
    stage: usize,
    options: &SphOptions,
    reach: f64,
) -> FlatWalls<D> {
    let (mut mirrored, mut faces) = (Vec::new(), Vec::new());
    for (number, boundary) in case.active_boundaries(stage) {
        let contact = match boundary.wall {
            Wall::Smooth => WallContact::FreeSlip,
            // Absorbing boundaries are refused.
            Wall::Rough | Wall::Absorbing { .. } => WallContact::NoSlip,
            Wall::Frictional { friction_coefficient, .. } => WallContact::Friction(friction_coefficient),
        };
        let history = options.wall_history.get(boundary.name()).cloned();
        let kind = if is_mirror(&boundary.wall, options) { &mut mirrored } else { &mut faces };
        kind.push(FlatWall {
            boundary: number,
            axis: boundary.side.axis(),
            position: boundary.wall_coordinate(&case.domain),
            is_upper: boundary.side.is_max(),
            velocity: boundary.velocity.as_ref().map_or([0.0; D], |velocity| leading_components(velocity)),
            factor: history.as_ref().map_or(1.0, |history| history.factor_at(0.0)),
            history,
            displacement: 0.0,
            contact,
        });
    }
    let period = |axis: &Axis| {
        let axis = axis.number();
        PeriodicAxis { axis, low: case.domain.min[axis], high: case.domain.max[axis] }
    };
    let periods = case.domain.periodic.iter().map(period).collect();
    let (span, depth) = extent(case, options, reach);
    FlatWalls::new(mirrored, faces, periods, span, options.spacing, depth)
}

/// Whether a wall of some stage or a region of an obstacle has friction.
pub fn has_friction(case: &Case) -> bool {
    let of_part = |wall: &ObstacleWall| matches!(wall, ObstacleWall::Frictional { .. });
    case.boundaries.iter().any(|boundary| matches!(boundary.wall, Wall::Frictional { .. }))
        || case.obstacles.iter().any(|obstacle| {
            of_part(&obstacle.wall) || obstacle.regions.iter().any(|region| of_part(&region.wall))
        })
}
