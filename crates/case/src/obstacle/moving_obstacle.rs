//! Moving obstacles, for all methods.

use std::sync::Arc;

use colluvium_points::Surface;
use colluvium_points::surface::{PlacedSurface, RigidTransform};
use serde::{Deserialize, Serialize};

use crate::description::ObstacleMotion;
use crate::obstacle::normal_inside;
use crate::{StepLimit, TimeStep};

/// Step limit by the displacement of an obstacle.
const MOTION: StepLimit = StepLimit::new("motion of an obstacle");

/// Velocity that a program gives an obstacle from a time on, in place of its motion in the case. Its rotation stops.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ProgramMotion {
    /// Time until which the obstacle has the motion of the case (s).
    start: f64,
    /// Time since which the velocity applies (s).
    since: f64,
    /// Displacement from `start` to `since` (m).
    displacement: [f64; 3],
    /// Velocity from `start` to `since`, of the last change before (m/s).
    previous_velocity: [f64; 3],
    /// Velocity (m/s).
    velocity: [f64; 3],
}

impl ProgramMotion {
    /// Displacement from the start to a time (s) (m).
    fn displacement_at(&self, time: f64) -> [f64; 3] {
        let (velocity, span) = (self.velocity_at(time), time - self.since);
        std::array::from_fn(|c| self.displacement[c] + span * velocity[c])
    }

    /// Velocity at a time (s) (m/s).
    fn velocity_at(&self, time: f64) -> [f64; 3] {
        if time < self.since { self.previous_velocity } else { self.velocity }
    }
}

/// Obstacle with a prescribed motion.
#[derive(Clone, Debug)]
pub struct MovingObstacle<const D: usize> {
    /// Motion of the obstacle in the case.
    motion: ObstacleMotion,
    /// Motion that a program prescribes instead; in checkpoints.
    pub program_motion: Option<ProgramMotion>,
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

/// Length of a vector.
fn norm(vector: &[f64]) -> f64 {
    vector.iter().map(|c| c * c).sum::<f64>().sqrt()
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
            program_motion: None,
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

    /// Gives it a velocity (m/s) from `time` (s) on.
    pub fn set_program_velocity(&mut self, time: f64, velocity: &[f64; D]) {
        let first = ProgramMotion { start: time, since: time, ..ProgramMotion::default() };
        let before = self.program_motion.unwrap_or(first);
        let is_same_time = before.since == time;
        self.program_motion = Some(ProgramMotion {
            start: before.start,
            since: time,
            displacement: before.displacement_at(time),
            previous_velocity: if is_same_time { before.previous_velocity } else { before.velocity },
            velocity: std::array::from_fn(|c| velocity.get(c).copied().unwrap_or(0.0)),
        });
    }

    /// Motion of a program that acts at `time` (s).
    fn program_motion_at(&self, time: f64) -> Option<&ProgramMotion> {
        self.program_motion.as_ref().filter(|program| time >= program.start)
    }

    /// Position and rotation at `time` (s).
    pub fn transform(&self, time: f64) -> RigidTransform<D> {
        match self.program_motion_at(time) {
            None => self.motion.transform(time),
            Some(program) => {
                let displacement = program.displacement_at(time);
                self.motion.transform(program.start).shifted(&std::array::from_fn(|c| displacement[c]))
            }
        }
    }

    /// Moves it to its position at `time` (s).
    pub fn move_to(&mut self, time: f64) {
        let at = |values: &[f64], c: usize| values.get(c).copied().unwrap_or(0.0);
        let program = self.program_motion_at(time);
        let displacement = program.map_or([0.0; 3], |program| program.displacement_at(time));
        let full = self.motion.equivalent_full_speed_time(program.map_or(time, |program| program.start));
        self.surface.transform = self.transform(time);
        self.centre = std::array::from_fn(|c| {
            at(&self.motion.centre, c) + full * at(&self.motion.velocity, c) + displacement[c]
        });
    }

    /// Sets the mean velocity over a step of `step` (s) that ends at `end` (s): the work of a force is then force times displacement.
    pub fn set_mean_velocity(&mut self, end: f64, step: f64) {
        // A program changes velocities between two steps.
        if let Some(program) = self.program_motion_at(end - step) {
            let velocity = program.velocity_at(end - step);
            (self.velocity, self.spin) = (std::array::from_fn(|c| velocity[c]), [0.0; 3]);
            return;
        }
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
        self.program_motion.map_or_else(|| self.max_speed_of_case(), |program| norm(&program.velocity))
    }

    /// Largest speed of its surface in the domain by its motion in the case at its full rate (m/s).
    fn max_speed_of_case(&self) -> f64 {
        let reach = self.max_radius.min(farthest_corner(&self.centre, &self.domain));
        norm(&self.motion.velocity) + self.motion.rotation.to_radians().abs() * reach
    }

    /// Share of its largest speed at `time` (s), 0 to 1.
    fn ramp_factor(&self, time: f64) -> f64 {
        if self.program_motion.is_some() { 1.0 } else { self.motion.ramp_factor(time) }
    }

    /// Upper bound of the displacement of its surface in the domain from `start` to `end` (s) (m).
    pub fn max_displacement(&self, start: f64, end: f64) -> f64 {
        if let Some(program) = self.program_motion_at(start) {
            return (end - start) * norm(&program.velocity).max(norm(&program.previous_velocity));
        }
        let (until, program_speed) = match &self.program_motion {
            Some(program) => (end.min(program.start), norm(&program.velocity)),
            None => (end, 0.0),
        };
        let motion = &self.motion;
        self.max_speed_of_case()
            * (motion.equivalent_full_speed_time(until) - motion.equivalent_full_speed_time(start))
            + program_speed * (end - until)
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
    let fastest = moving.map(|own| own.ramp_factor(until) * own.max_speed()).fold(0.0, f64::max);
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
        let after = own.material_position(&x, &own.transform(time + step));
        let before = own.material_position(&x, &own.transform(time - step));
        for c in 0..2 {
            let slope = (after[c] - before[c]) / (2.0 * step);
            assert!((own.velocity(&x)[c] - slope).abs() < 1e-8, "{slope}");
        }
    }

    /// The position is continuous where a program takes over and where it changes the velocity; before it, the motion is that of the case.
    #[test]
    fn a_velocity_of_a_program_follows_the_motion_of_the_case() {
        let mut own = moving_ball(&[0.3, -0.2], 40.0, 0.1);
        let by_case = own.transform(0.4);
        own.set_program_velocity(0.5, &[1.0, 0.0]);
        own.set_program_velocity(0.7, &[0.0, 2.0]);
        assert_eq!(own.transform(0.4), by_case);
        let start = own.motion.transform::<2>(0.5);
        for (time, x, y) in [(0.5, 0.0, 0.0), (0.6, 0.1, 0.0), (0.7, 0.2, 0.0), (0.8, 0.2, 0.2)] {
            let (found, expected) = (own.transform(time), start.shifted(&[x, y]));
            assert_eq!(found.rotation, expected.rotation);
            (0..2).for_each(|c| assert!((found.translation[c] - expected.translation[c]).abs() < 1e-14));
        }
        own.move_to(0.8);
        own.set_mean_velocity(0.8, 0.1);
        assert_eq!((own.velocity(&[3.0, 3.0]), own.max_speed()), ([0.0, 2.0], 2.0));
        assert!((own.max_displacement(0.7, 0.8) - 0.2).abs() < 1e-15);
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
