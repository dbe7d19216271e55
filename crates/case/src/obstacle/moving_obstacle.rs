//! Moving obstacles, for all methods.

use std::sync::Arc;

use colluvium_points::Surface;
use colluvium_points::surface::{PlacedSurface, RigidTransform};

use crate::description::ObstacleMotion;
use crate::obstacle::normal_inside;
use crate::{StepLimit, TimeStep};

/// Step limit by the displacement of an obstacle.
const MOTION: StepLimit = StepLimit::new("motion of an obstacle");

/// Obstacle with a prescribed motion.
#[derive(Clone, Debug)]
pub struct MovingObstacle<const D: usize> {
    /// Prescribed motion of the obstacle.
    pub motion: ObstacleMotion,
    /// Surface at its current position.
    pub surface: PlacedSurface<D>,
    /// Point on the axis of rotation (m).
    centre: [f64; D],
    /// Velocity of that point (m/s).
    velocity: [f64; D],
    /// Angular velocity (rad/s).
    spin: [f64; 3],
    /// Largest distance of its surface from that point (m).
    max_radius: f64,
    /// Corners of the domain (m).
    domain: ([f64; D], [f64; D]),
}

/// Distance of the farthest corner of a box from a position (m).
fn farthest_corner<const D: usize>(centre: &[f64; D], (low, high): &([f64; D], [f64; D])) -> f64 {
    let far = |c: usize| (low[c] - centre[c]).abs().max((high[c] - centre[c]).abs());
    (0..D).map(|c| far(c).powi(2)).sum::<f64>().sqrt()
}

impl<const D: usize> MovingObstacle<D> {
    /// Obstacle at its initial position, in a domain with these corners (m).
    pub fn new(motion: &ObstacleMotion, surface: &Arc<dyn Surface<D>>, domain: ([f64; D], [f64; D])) -> Self {
        let centre: [f64; D] = std::array::from_fn(|c| motion.centre.get(c).copied().unwrap_or(0.0));
        let mut moving = Self {
            motion: motion.clone(),
            surface: PlacedSurface { surface: Arc::clone(surface), transform: motion.transform(0.0) },
            centre,
            velocity: [0.0; D],
            spin: [0.0; 3],
            max_radius: farthest_corner(&centre, &surface.bounds()),
            domain,
        };
        moving.move_to(0.0);
        moving.set_mean_velocity(0.0, 0.0);
        moving
    }

    /// Moves it to its position at `time` (s).
    pub fn move_to(&mut self, time: f64) {
        let at = |values: &[f64], c: usize| values.get(c).copied().unwrap_or(0.0);
        let full = self.motion.equivalent_full_speed_time(time);
        self.surface.transform = self.motion.transform(time);
        self.centre =
            std::array::from_fn(|c| at(&self.motion.centre, c) + full * at(&self.motion.velocity, c));
    }

    /// Sets the mean velocity over a step of `step` (s) that ends at `end` (s): the work of a force is then force times displacement.
    pub fn set_mean_velocity(&mut self, end: f64, step: f64) {
        let motion = &self.motion;
        let at = |values: &[f64], c: usize| values.get(c).copied().unwrap_or(0.0);
        let pace = if step > 0.0 {
            (motion.equivalent_full_speed_time(end) - motion.equivalent_full_speed_time(end - step)) / step
        } else {
            motion.ramp_factor(end)
        };
        self.velocity = std::array::from_fn(|c| pace * at(&motion.velocity, c));
        let rate = pace * motion.rotation.to_radians();
        let axis: [f64; 3] =
            if D == 2 { [0.0, 0.0, 1.0] } else { std::array::from_fn(|c| at(&motion.axis, c)) };
        let length = axis.iter().map(|c| c * c).sum::<f64>().sqrt();
        self.spin = if rate == 0.0 { [0.0; 3] } else { axis.map(|c| rate * c / length) };
    }

    /// Largest speed of its surface in the domain once its motion has its full rate (m/s).
    pub fn max_speed(&self) -> f64 {
        let reach = self.max_radius.min(farthest_corner(&self.centre, &self.domain));
        let along = self.motion.velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        along + self.motion.rotation.to_radians().abs() * reach
    }

    /// Upper bound of the displacement of its surface in the domain from `start` to `end` (s) (m).
    pub fn max_displacement(&self, start: f64, end: f64) -> f64 {
        self.max_speed()
            * (self.motion.equivalent_full_speed_time(end) - self.motion.equivalent_full_speed_time(start))
    }

    /// Velocity of the obstacle at the position `x` (m/s).
    pub fn velocity(&self, x: &[f64; D]) -> [f64; D] {
        self.velocity_with_rotation(&self.velocity, &std::array::from_fn(|c| x[c] - self.centre[c]))
    }

    /// Velocity of the rotation at an arm (m/s).
    pub fn rotational_velocity(&self, arm: &[f64; D]) -> [f64; D] {
        self.velocity_with_rotation(&[0.0; D], arm)
    }

    /// Sum of a velocity (m/s) and that of the rotation at an arm (m).
    fn velocity_with_rotation(&self, velocity: &[f64; D], arm: &[f64; D]) -> [f64; D] {
        let at = |c: usize| arm.get(c).copied().unwrap_or(0.0);
        std::array::from_fn(|c| {
            let (a, b) = ((c + 1) % 3, (c + 2) % 3);
            velocity[c] + self.spin[a] * at(b) - self.spin[b] * at(a)
        })
    }

    /// Angular velocity (rad/s).
    pub fn angular_velocity<const R: usize>(&self) -> [f64; R] {
        if R == 1 { [self.spin[2]; R] } else { std::array::from_fn(|c| self.spin[c]) }
    }

    /// Outward normal and velocity (m/s) of the obstacle at a grid node inside it; `None` where the node is outside.
    pub fn nodal_constraint(
        &self,
        place: &[f64; D],
        cell: f64,
        (next, dt): (&RigidTransform<D>, f64),
    ) -> Option<([f64; 3], [f64; 3])> {
        let normal = normal_inside(&self.surface, place, cell)?;
        let goes = self.material_position(place, next);
        let mut velocity = [0.0; 3];
        (0..D).for_each(|c| velocity[c] = (goes[c] - place[c]) / dt);
        Some((normal, velocity))
    }

    /// Position at another time of the material point of the obstacle at `x` (m). `frame` is the placement of the obstacle then.
    pub fn material_position(&self, x: &[f64; D], frame: &RigidTransform<D>) -> [f64; D] {
        frame.to_space(&self.surface.transform.to_body(x))
    }
}

/// Time step from `time` (s) in which moving obstacles move by at most `upper_limit` (m), where it is shorter than the `critical` one. It
/// holds for `steps` steps.
pub fn limit_step_by_obstacles<'a, const D: usize>(
    critical: TimeStep,
    moving: impl Iterator<Item = &'a MovingObstacle<D>>,
    (time, upper_limit, steps): (f64, f64, u64),
) -> TimeStep {
    let until = time + steps as f64 * critical.dt;
    let fastest = moving.map(|own| own.motion.ramp_factor(until) * own.max_speed()).fold(0.0, f64::max);
    if fastest == 0.0 || fastest * critical.dt <= upper_limit {
        return critical;
    }
    TimeStep { dt: upper_limit / fastest, limit: MOTION, point: None, position: [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use colluvium_points::surface::HalfSpace;

    use super::*;

    fn moving_ball(velocity: &[f64], rotation: f64, start: f64) -> MovingObstacle<2> {
        let motion = ObstacleMotion {
            velocity: velocity.to_vec(),
            rotation,
            centre: vec![1.0, 0.0],
            axis: Vec::new(),
            start,
            ramp: 0.0,
        };
        let plane: Arc<dyn Surface<2>> = Arc::new(HalfSpace::new([0.0; 2], [0.0, 1.0]).unwrap());
        MovingObstacle::new(&motion, &plane, ([0.0; 2], [4.0, 4.0]))
    }

    #[test]
    fn velocity_of_a_moving_obstacle_is_the_time_derivative_of_its_material_positions() {
        let mut own = moving_ball(&[0.3, -0.2], 40.0, 0.1);
        let (time, step) = (0.7, 1e-5);
        own.move_to(time);
        own.set_mean_velocity(time + step, step);
        let x = [2.0, 0.5];
        let after = own.material_position(&x, &own.motion.transform(time + step));
        let before = own.material_position(&x, &own.motion.transform(time - step));
        for c in 0..2 {
            let slope = (after[c] - before[c]) / (2.0 * step);
            assert!((own.velocity(&x)[c] - slope).abs() < 1e-8, "{slope}");
        }
    }

    #[test]
    fn a_step_is_short_enough_for_the_fastest_obstacle_and_no_shorter_before_it_moves() {
        let critical = TimeStep { dt: 0.1, limit: StepLimit::ELASTIC_WAVE, point: None, position: [0.0; 3] };
        let own = [moving_ball(&[3.0, 4.0], 0.0, 2.0)];
        let found = |time: f64| limit_step_by_obstacles(critical, own.iter(), (time, 0.05, 10));
        assert_eq!(found(0.5).dt, 0.1);
        assert_eq!((found(1.5).dt, found(1.5).limit), (0.01, MOTION));
        // With a rotation of one radian per second, its farthest position in the domain is 5 m from the centre.
        let turning = [moving_ball(&[], 1f64.to_degrees(), 0.0)];
        let found = limit_step_by_obstacles(critical, turning.iter(), (1.0, 0.05, 10));
        assert!((found.dt - 0.01).abs() < 1e-15, "{}", found.dt);
    }
}
