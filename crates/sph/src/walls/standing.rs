//! Rigid bodies that move freely stand on walls and obstacles.

use colluvium_case::rigid::{Planks, RigidStep, Rock, Side};
use colluvium_case::spatial;

use super::Walls;
use super::plane::{Contact, Plane};

impl<const D: usize> Plane<D> {
    /// As what rigid bodies stand on.
    fn side(&self) -> Side {
        let friction = match self.contact {
            Contact::NoSlip => f64::INFINITY,
            Contact::FreeSlip => 0.0,
            Contact::Friction(coefficient) => coefficient,
        };
        let off = if self.upper { -1.0 } else { 1.0 };
        Side { axis: self.axis, off, face: self.face(), velocity: spatial(&self.pace()), friction }
    }
}

impl<const D: usize> Walls<D> {
    /// Lets walls and obstacles bear a rigid body in a step of `dt` (s), whose points are squares or cubes of some half width (m) at
    /// places (m); where they do, and whether that has been found to the last digit.
    pub fn bear(&self, body: &mut RigidStep, dt: f64, points: (&[[f64; D]], f64)) -> (Planks, bool) {
        let sides: Vec<Side> =
            self.planes.faces.iter().chain(&self.planes.mirrors).map(Plane::side).collect();
        let rocks: Vec<Rock<'_, D>> = self.obstacles.solids.iter().map(|own| own.ground()).collect();
        let mut planks = Planks::default();
        planks.list((body, dt), points, &sides, &rocks);
        let done = planks.bear(body);
        (planks, done)
    }
}
