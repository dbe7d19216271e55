//! Boundary conditions: walls, obstacles and membranes.

use std::collections::BTreeMap;
use std::sync::Arc;

use colluvium_case::measure::ScalarOutput;
use colluvium_case::{MovingObstacle, ObstacleLaws};
use colluvium_points::Surface;

use crate::boundary::body_force::ProgramForce;
use crate::boundary::membranes::Membranes;
use crate::boundary::periodic_cell::PeriodicCell;
use crate::boundary::walls::RigidWall;
use crate::clock::Clock;
use crate::config::WallServo;
use crate::points::grains::Grains;

/// Walls, obstacles and membranes, and the actions of a program on the grains.
pub struct BoundaryConditions<const D: usize> {
    /// Walls and obstacles of the present stage.
    pub walls: Vec<RigidWall<D>>,
    /// Surfaces of the obstacles of the case, and their laws.
    pub obstacles: Vec<(Arc<dyn Surface<D>>, ObstacleLaws)>,
    /// Grains of membranes.
    pub membranes: Membranes,
    /// Body force of a program.
    pub body_force: ProgramForce<D>,
    /// Velocities of bodies that a program prescribes (m/s), by the index of the body.
    pub body_velocities: BTreeMap<u32, [f64; D]>,
}

impl<const D: usize> BoundaryConditions<D> {
    /// Moves the walls and obstacles by a step of `dt` (s) from `time` (s); returns their largest displacement (m).
    pub fn advance(&mut self, time: f64, dt: f64) -> f64 {
        let mut fastest = 0.0f64;
        for wall in &mut self.walls {
            let speed = wall.velocity[wall.axis];
            wall.position += speed * dt;
            fastest = fastest.max(speed.abs());
        }
        let mut displacement = fastest * dt;
        for moving in self.moving_obstacles_mut() {
            displacement = displacement.max(moving.max_displacement(time, time + dt));
            moving.move_to(time + dt);
            moving.set_mean_velocity(time + dt, dt);
        }
        displacement
    }

    /// Moving obstacles.
    pub fn moving_obstacles_mut(&mut self) -> impl Iterator<Item = &mut MovingObstacle<D>> {
        self.walls.iter_mut().filter_map(|wall| wall.motion.as_mut())
    }

    /// Area on which the stress of a servo-controlled wall acts (m²; a length in the plane, m).
    pub fn servo_area<const R: usize>(
        &self,
        clock: &Clock,
        cell: &PeriodicCell<D>,
        grains: &Grains<D, R>,
        servo: &WallServo,
        axis: usize,
    ) -> f64 {
        let sleeve =
            || servo.sleeve.as_ref().and_then(|name| self.membranes.enclosed_area(clock, grains, name, axis));
        servo.area.or_else(sleeve).unwrap_or_else(|| self.wall_area(clock, cell, axis))
    }

    /// Area of walls across an axis (m², a length in the plane).
    pub fn wall_area(&self, clock: &Clock, cell: &PeriodicCell<D>, axis: usize) -> f64 {
        (0..D).filter(|other| *other != axis).map(|other| self.extent(clock, cell, other)).product()
    }

    /// Extent of the specimen along an axis (m): between the current positions of the walls, or the width of the domain.
    pub fn extent(&self, clock: &Clock, cell: &PeriodicCell<D>, axis: usize) -> f64 {
        let domain = &clock.case.domain;
        if cell.periodic[axis] {
            return cell.h[axis][axis];
        }
        let position = |upper: bool| {
            let of_axis =
                |wall: &&RigidWall<D>| wall.surface.is_none() && wall.axis == axis && wall.is_upper == upper;
            self.walls.iter().find(of_axis).map(|wall| wall.position)
        };
        position(true).unwrap_or(domain.max[axis]) - position(false).unwrap_or(domain.min[axis])
    }

    /// Position (m) and stress of each wall that is servo-controlled in some stage (Pa, tension-positive; N/m in the plane).
    pub fn servo_outputs<const R: usize>(
        &self,
        clock: &Clock,
        cell: &PeriodicCell<D>,
        grains: &Grains<D, R>,
    ) -> Vec<ScalarOutput> {
        let mut outputs = Vec::new();
        for boundary in &clock.case.boundaries {
            let name = boundary.name();
            // The servo of this stage, or else that of the first stage that has one for the wall.
            let stages = clock.stage_options().into_iter().chain(clock.options.stages.values());
            let Some(servo) = stages.filter_map(|stage| stage.walls.get(name)).next() else { continue };
            let wall = self.walls.iter().find(|wall| wall.name == name);
            let (position, stress) = wall.map_or((f64::NAN, f64::NAN), |wall| {
                let area = self.servo_area(clock, cell, grains, servo, wall.axis);
                (wall.position, -wall.outward_force() / area)
            });
            outputs.push((format!("wall.{name}.position"), "m".to_owned(), position));
            outputs.push((format!("wall.{name}.stress"), "Pa".to_owned(), stress));
        }
        outputs
    }
}
