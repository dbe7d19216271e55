//! Obstacles of a case as surfaces, for all methods.

mod height_checks;
mod moving_obstacle;
mod node_constraints;
mod obstacle_laws;
mod surface_builder;

use std::sync::Arc;

pub use crate::obstacle::moving_obstacle::{MovingObstacle, ProgramMotion, limit_step_by_obstacles};
pub use crate::obstacle::node_constraints::{MovingObstacles, constraining_obstacles, normal_inside};
pub use crate::obstacle::obstacle_laws::{ObstacleLaw, ObstacleLaws};

use colluvium_points::{Raster, Surface};

use crate::description::{Obstacle, ObstacleRegion, ObstacleShape};
use crate::{Case, CaseError, CaseErrorKind};
use colluvium_constitutive::Warning;

/// Obstacle of a case with its surface.
#[derive(Clone, Debug)]
pub struct PlacedObstacle<'a, const D: usize> {
    /// Number in the obstacles of the case.
    pub number: usize,
    /// Obstacle in the case.
    pub obstacle: &'a Obstacle,
    /// Surface of the obstacle.
    pub surface: Arc<dyn Surface<D>>,
    /// Boundary laws of the obstacle.
    pub laws: ObstacleLaws,
}

/// Tolerance of the initial overlap of points with an obstacle and of the height of nodes on its surface, over the cell size.
pub const OVERLAP_TOLERANCE: f64 = 1e-9;

/// Overlap of an obstacle and one of the queried positions, which is inside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObstacleOverlap {
    /// Number of the obstacle.
    pub obstacle: usize,
    /// Number of the position in the query.
    pub point_index: usize,
    /// Depth below the surface (m).
    pub depth: f64,
}

impl Case {
    /// Obstacles with their surfaces; reads their files.
    ///
    /// # Errors
    /// A shape that is invalid in this space, or a file that cannot be read or contains none, with its path; errors of regions.
    pub fn placed_obstacles<const D: usize>(&self) -> Result<Vec<PlacedObstacle<'_, D>>, CaseError> {
        let mut standing = Vec::with_capacity(self.obstacles.len());
        for (number, obstacle) in self.obstacles.iter().enumerate() {
            let surface = surface_builder::surface(
                &obstacle.shape,
                &format!("obstacles[{number}].shape"),
                &self.origin(),
            )?;
            let regions = obstacle.regions.iter().enumerate().map(|(part, region)| {
                let ObstacleRegion { shape, outline, raster, .. } = region;
                let made = self.plan_region(shape.clone(), outline.as_deref(), raster.as_ref());
                made.map_err(|(key, problem)| {
                    CaseError::new(format!("obstacles[{number}].regions[{part}].{key}"), problem)
                })
            });
            let laws = ObstacleLaws::new(obstacle, regions.collect::<Result<_, _>>()?);
            standing.push(PlacedObstacle { number, obstacle, surface, laws });
        }
        Ok(standing)
    }

    /// Ground line of the obstacle with a name; `None` where the obstacle has no ground line in the plane.
    pub fn ground_line(&self, name: &str) -> Option<Arc<dyn Surface<2>>> {
        let number = self.obstacles.iter().position(|obstacle| obstacle.name == name)?;
        let shape = &self.obstacles[number].shape;
        let is_line = matches!(shape, ObstacleShape::Profile { .. } | ObstacleShape::GroundLine { .. });
        surface_builder::surface(shape, "", &self.origin()).ok().filter(|_| is_line)
    }

    /// Heights (m, from `domain.origin`) of obstacle `number`, where its shape is a raster; reads its file.
    ///
    /// # Errors
    /// A file that cannot be read or contains no raster, with its path.
    pub fn heights(&self, number: usize) -> Result<Option<Raster>, CaseError> {
        let path = format!("obstacles[{number}].shape");
        surface_builder::raster_of(&self.obstacles[number].shape, &path, &self.origin())
    }

    /// Reports an error where points of a body lie deeper than `slack` (m) in an obstacle.
    ///
    /// # Errors
    /// The deepest point.
    pub fn reject_overlapping_points<const D: usize>(
        &self,
        standing: &[PlacedObstacle<'_, D>],
        body: usize,
        places: &[[f64; D]],
        slack: f64,
    ) -> Result<(), CaseError> {
        let Some(deepest) = deepest_overlap(standing, places, slack) else { return Ok(()) };
        let problem = format!(
            "the point at {:.6?} m lies {:.3e} m inside the obstacle {:?}: a body must not overlap an \
             obstacle at the start",
            self.map_position(&places[deepest.point_index]),
            deepest.depth,
            self.obstacles[deepest.obstacle].name
        );
        Err(CaseError::new(format!("bodies[{body}].shape"), CaseErrorKind::coded("outside-domain", problem)))
    }

    /// Checks the velocity (m/s) that a program gives an obstacle, by its name; returns the number of the obstacle among those with a motion.
    ///
    /// # Errors
    /// A name that no obstacle has, an obstacle without a motion in the case, and a velocity that is not finite.
    pub fn check_obstacle_velocity(&self, name: &str, velocity: &[f64]) -> Result<usize, CaseError> {
        let Some(number) = self.obstacles.iter().position(|obstacle| obstacle.name == name) else {
            let known: Vec<&str> = self.obstacles.iter().map(|obstacle| obstacle.name.as_str()).collect();
            let kind = CaseErrorKind::unknown_name(name, &known, "the name of an obstacle");
            return Err(CaseError::new("obstacles", kind));
        };
        let path = format!("obstacles[{number}].motion");
        if self.obstacles[number].motion.is_none() {
            let problem =
                "is missing: a program can move an obstacle with a motion in the case, which may be zero";
            return Err(CaseError::new(path, CaseErrorKind::coded("needs-other-key", problem)));
        }
        if !velocity.iter().all(|v| v.is_finite()) {
            return Err(CaseError::new(
                format!("{path}.velocity"),
                CaseErrorKind::coded("program-request", format!("{velocity:?} must be finite (m/s)")),
            ));
        }
        Ok(self.obstacles[..number].iter().filter(|obstacle| obstacle.motion.is_some()).count())
    }

    /// Checks the velocity (m/s) that a program gives a body or patch of prescribed motion; `is_prescribed` says whether the method has such
    /// a body or patch of this name, and `required` describes it.
    ///
    /// # Errors
    /// A name that no body and no patch has, a body whose motion is not prescribed, and a velocity that is not finite.
    pub fn check_body_velocity(
        &self,
        name: &str,
        velocity: &[f64],
        is_prescribed: bool,
        required: &str,
    ) -> Result<(), CaseError> {
        let body = self.bodies.iter().position(|body| body.name == name);
        let patch = self.patches.iter().position(|patch| patch.name == name);
        let path = match (body, patch) {
            (Some(number), _) => format!("bodies[{number}]"),
            (_, Some(number)) => format!("patches[{number}]"),
            _ => {
                let known: Vec<&str> = self.bodies.iter().map(|body| body.name.as_str()).collect();
                let kind = CaseErrorKind::unknown_name(name, &known, "the name of a body");
                return Err(CaseError::new("bodies", kind));
            }
        };
        if !is_prescribed {
            return Err(CaseError::new(path, format!("{name:?} moves by itself: {required}")));
        }
        if velocity.iter().all(|v| v.is_finite()) {
            return Ok(());
        }
        Err(CaseError::new(
            format!("{path}.velocity"),
            CaseErrorKind::coded("program-request", format!("{velocity:?} must be finite (m/s)")),
        ))
    }

    /// Reports an error where points that a program adds lie deeper than `slack` (m) in an obstacle without a motion.
    ///
    /// # Errors
    /// The deepest point.
    pub fn reject_added_in_obstacles<const D: usize>(
        &self,
        places: &[[f64; D]],
        slack: f64,
    ) -> Result<(), CaseError> {
        let mut at_rest: Vec<PlacedObstacle<'_, D>> = self.placed_obstacles()?;
        at_rest.retain(|placed| placed.obstacle.motion.is_none());
        let Some(deepest) = deepest_overlap(&at_rest, places, slack) else { return Ok(()) };
        let problem = format!(
            "lies {:.3e} m inside the obstacle {:?}",
            deepest.depth, self.obstacles[deepest.obstacle].name
        );
        Err(CaseError::new(
            format!("points.positions[{}]", deepest.point_index),
            CaseErrorKind::coded("outside-domain", problem),
        ))
    }
}

impl Case {
    /// Warning about points that lie deeper than `slack` (m) in an obstacle at rest at the end of a run, with the largest depth.
    pub fn overlap_warning<const D: usize>(
        &self,
        places: &[[f64; D]],
        slack: f64,
        reason: &str,
    ) -> Option<Warning> {
        let mut standing = self.placed_obstacles::<D>().ok()?;
        standing.retain(|standing| standing.obstacle.motion.is_none());
        let ObstacleOverlap { obstacle, point_index, depth } = deepest_overlap(&standing, places, slack)?;
        let name = &self.obstacles[obstacle].name;
        Some(Warning::new(
            "obstacle-penetration",
            format!(
                "a point at {:.4?} m lies {depth:.3e} m under the surface of the obstacle {name:?}: {reason}",
                self.map_position(&places[point_index])
            ),
        ))
    }
}

/// Position that lies deepest in an obstacle, if it lies deeper than `slack` (m).
fn deepest_overlap<const D: usize>(
    standing: &[PlacedObstacle<'_, D>],
    places: &[[f64; D]],
    slack: f64,
) -> Option<ObstacleOverlap> {
    let mut worst: Option<ObstacleOverlap> = None;
    for PlacedObstacle { number, surface, .. } in standing {
        for (point_index, x) in places.iter().enumerate().filter(|(_, x)| surface.contains(x)) {
            let depth = surface.gap(x, f64::INFINITY).map_or(0.0, |gap| -gap.distance);
            if depth > slack && worst.is_none_or(|worst| depth > worst.depth) {
                worst = Some(ObstacleOverlap { obstacle: *number, point_index, depth });
            }
        }
    }
    worst
}

impl ObstacleShape {
    /// Checks that the shape, without its file, has a surface in a space of `dimension` coordinates; `path` is its path.
    pub(crate) fn check(&self, dimension: usize, path: &str) -> Result<(), CaseError> {
        match dimension {
            1 => surface_builder::surface::<1>(self, path, &[0.0; 3]).map(|_| ()),
            2 => surface_builder::surface::<2>(self, path, &[0.0; 3]).map(|_| ()),
            _ => surface_builder::surface::<3>(self, path, &[0.0; 3]).map(|_| ()),
        }
    }
}
