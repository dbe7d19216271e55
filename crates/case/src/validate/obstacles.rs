//! Rules of obstacles.

use std::collections::HashSet;

use crate::CaseErrorKind;
use crate::description::{Boundary, Obstacle, ObstacleMotion, ObstacleRegion, ObstacleShape, ObstacleWall};
use crate::error_collector::ErrorCollector;

impl ErrorCollector<'_> {
    /// Checks the obstacles.
    pub(super) fn obstacles(&mut self) {
        let case = self.case;
        let mut names: HashSet<&str> = case.bodies.iter().map(|body| body.name.as_str()).collect();
        names.extend(case.patches.iter().map(|patch| patch.name.as_str()));
        names.extend(case.boundaries.iter().map(Boundary::name));
        for (number, obstacle) in case.obstacles.iter().enumerate() {
            let path = format!("obstacles[{number}]");
            if !names.insert(&obstacle.name) {
                let problem = format!(
                    "{:?} is also the name of a body, a boundary, a patch or another obstacle",
                    obstacle.name
                );
                self.report(format!("{path}.name"), CaseErrorKind::coded("duplicate-name", problem));
            }
            self.obstacle_wall(&format!("{path}.wall"), obstacle.wall);
            self.obstacle_regions(&path, obstacle);
            if let Some(motion) = &obstacle.motion {
                self.obstacle_motion(&format!("{path}.motion"), motion);
            }
            self.obstacle_shape(&path, obstacle);
        }
    }

    /// Checks friction and adhesion of an obstacle.
    fn obstacle_wall(&mut self, path: &str, wall: ObstacleWall) {
        if let ObstacleWall::Frictional { friction_coefficient, adhesion } = wall {
            self.not_negative(format!("{path}.friction_coefficient"), friction_coefficient, "");
            self.not_negative(format!("{path}.adhesion"), adhesion, " (Pa)");
        }
    }

    /// Checks the regions of an obstacle with a friction of their own.
    fn obstacle_regions(&mut self, path: &str, obstacle: &Obstacle) {
        let case = self.case;
        if obstacle.regions.is_empty() {
            return;
        }
        let path = format!("{path}.regions");
        self.require(
            case.dimension() > 1,
            path.clone(),
            CaseErrorKind::coded("wrong-dimension", "one dimension has no plan"),
        );
        let problem = "are fixed in plan, but the obstacle moves: give each part as a separate obstacle";
        self.require(obstacle.motion.is_none(), path.clone(), problem);
        for (number, region) in obstacle.regions.iter().enumerate() {
            self.obstacle_wall(&format!("{path}[{number}].wall"), region.wall);
            // Surfaces from files are checked when they are read.
            let ObstacleRegion { shape, outline, raster, .. } = region;
            let of_file = shape.is_none() && (outline.is_some() != raster.is_some());
            if case.dimension() > 1
                && (!of_file || case.dimension() < 3)
                && let Err((key, problem)) =
                    case.plan_region(shape.clone(), outline.as_deref(), raster.as_ref())
            {
                self.report(format!("{path}[{number}].{key}"), problem);
            }
        }
    }

    /// Checks the motion of an obstacle.
    fn obstacle_motion(&mut self, path: &str, motion: &ObstacleMotion) {
        let dimension = self.case.dimension();
        if !motion.velocity.is_empty() {
            self.vector(&format!("{path}.velocity"), &motion.velocity);
        }
        self.finite(format!("{path}.rotation"), motion.rotation);
        self.not_negative(format!("{path}.start"), motion.start, " (s)");
        self.not_negative(format!("{path}.ramp"), motion.ramp, " (s)");
        if motion.rotation == 0.0 {
            return;
        }
        let problem = CaseErrorKind::coded("wrong-dimension", "one dimension has no rotation");
        self.require(dimension > 1, format!("{path}.rotation"), problem);
        self.vector(&format!("{path}.centre"), &motion.centre);
        if dimension == 3 {
            self.vector(&format!("{path}.axis"), &motion.axis);
            let problem = "must not be zero with a rotation";
            self.require(motion.axis.iter().any(|c| *c != 0.0), format!("{path}.axis"), problem);
        } else {
            let problem = "applies to 3d only: in two dimensions an obstacle rotates in the plane";
            self.require(
                motion.axis.is_empty(),
                format!("{path}.axis"),
                CaseErrorKind::coded("needs-other-key", problem),
            );
        }
    }

    /// Checks the shape of an obstacle.
    fn obstacle_shape(&mut self, path: &str, obstacle: &Obstacle) {
        let path = format!("{path}.shape");
        match &obstacle.shape {
            ObstacleShape::Plane { point, normal } => {
                self.vector(&format!("{path}.point"), point);
                self.vector(&format!("{path}.normal"), normal);
            }
            ObstacleShape::Box { min, max } => {
                self.vector(&format!("{path}.min"), min);
                self.vector(&format!("{path}.max"), max);
            }
            ObstacleShape::Ball { centre, .. } => self.vector(&format!("{path}.centre"), centre),
            ObstacleShape::GroundLine { points, file } => {
                let problem = CaseErrorKind::coded("conflicting-keys", "give either points or a file");
                self.require(points.is_empty() != file.is_none(), format!("{path}.points"), problem);
            }
            ObstacleShape::Raster { spacing: Some(spacing), .. } => {
                self.positive(format!("{path}.spacing"), *spacing, "m");
            }
            _ => {}
        }
        // Surfaces from files are checked when they are read: the files are located after this check.
        if self.errors.is_empty()
            && !obstacle.shape.has_file()
            && let Err(error) = obstacle.shape.check(self.case.dimension(), &path)
        {
            self.errors.push(error);
        }
    }
}
