//! Supports of freely moving rigid bodies: walls and obstacles.

use colluvium_case::Case;
use colluvium_case::rigid::{RigidStep, SupportPoints, WallPlane};
use colluvium_case::spatial;

use crate::boundary::flat_wall::FlatWall;
use crate::obstacles::obstacle_faces::RigidObstacle;
use crate::walls::Walls;

impl<const D: usize> FlatWall<D> {
    /// Plane of the wall as a support of rigid bodies, in a case.
    fn wall_plane(&self, case: &Case) -> WallPlane {
        let friction = case.boundaries[self.boundary].wall.friction();
        let normal_sign = if self.is_upper { -1.0 } else { 1.0 };
        WallPlane {
            axis: self.axis,
            normal_sign,
            face: self.face(),
            velocity: spatial(&self.mean_velocity()),
            friction,
        }
    }
}

impl<const D: usize> Walls<D> {
    /// Solves the support of a rigid body by walls and obstacles in a step of `dt` (s). Its points are squares or cubes of a half width at
    /// positions (m). Returns whether the iteration converged, with the contact points in `planks`.
    pub fn support_rigid_body(
        &self,
        case: &Case,
        (body, dt): (&mut RigidStep, f64),
        points: (&[[f64; D]], f64),
        planks: &mut SupportPoints,
    ) -> bool {
        let sides = self.planes.faces.iter().chain(&self.planes.mirrors).map(|plane| plane.wall_plane(case));
        planks.list(
            (&*body, dt),
            points,
            sides,
            self.obstacles.solids.iter().map(RigidObstacle::rigid_contact),
        );
        planks.solve(body)
    }
}
