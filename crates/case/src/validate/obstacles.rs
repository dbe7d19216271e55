//! Rules of obstacles.

use std::collections::HashSet;

use super::Findings;
use crate::description::{Boundary, Obstacle, ObstacleShape, ObstacleWall};

impl Findings<'_> {
    pub(super) fn obstacles(&mut self) {
        let case = self.case;
        let mut names: HashSet<&str> = case.bodies.iter().map(|body| body.name.as_str()).collect();
        names.extend(case.patches.iter().map(|patch| patch.name.as_str()));
        names.extend(case.boundaries.iter().map(Boundary::name));
        for (number, obstacle) in case.obstacles.iter().enumerate() {
            let path = format!("obstacles[{number}]");
            if !names.insert(&obstacle.name) {
                let problem =
                    format!("{:?} names a body, a boundary, a patch or another obstacle too", obstacle.name);
                self.report(format!("{path}.name"), problem);
            }
            if let ObstacleWall::Frictional { friction_coefficient, adhesion } = obstacle.wall {
                self.not_negative(format!("{path}.wall.friction_coefficient"), friction_coefficient, "");
                self.not_negative(format!("{path}.wall.adhesion"), adhesion, " (Pa)");
            }
            self.obstacle_shape(&path, obstacle);
        }
    }

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
                let problem = "give either points or a file";
                self.require(points.is_empty() != file.is_none(), format!("{path}.points"), problem);
            }
            ObstacleShape::Raster { spacing: Some(spacing), .. } => {
                self.positive(format!("{path}.spacing"), *spacing, "m");
            }
            _ => {}
        }
        // What stands in files is looked at when the surface is needed: they are found after this.
        if self.errors.is_empty()
            && !obstacle.shape.has_file()
            && let Err(error) = obstacle.shape.check(self.case.dimension(), &path)
        {
            self.errors.push(error);
        }
    }
}
