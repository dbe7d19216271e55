//! Rigid-wall servo: walls that follow a stress (sheet: dem §3.7).

use colluvium_case::measure::ScalarOutput;

use crate::boundary::walls::RigidWall;
use crate::config::WallServo;
use crate::contact::{CONTACT_APART, NormalForceLaw};
use crate::force_loop::ContactInput;
use crate::solver::DemSolver;

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Updates the velocities of the servo-controlled walls for a step of `dt` (s): inwards
    /// `(α (F - F_w) + Δt Σ k_n v_n + Σ γ_n v) / (Δt Σ k_n + Σ γ_n)`, at most the given speed, and at that speed without contact. `v` is
    /// the old velocity of the wall: the wall force includes the dashpot forces. Without them in the rule, a wall with `α Σ γ_n > Δt Σ k_n`
    /// reverses every step. `v_n` are the velocities of the grains in contact with the wall: the wall moves with them, and also
    /// corrects a share of the missing force (sheet: dem §3.7).
    pub(crate) fn update_servo_walls(&mut self, dt: f64) {
        for number in 0..self.walls.len() {
            let wall = &self.walls[number];
            let Some(press) = self.stage().and_then(|stage| stage.walls.get(&wall.name)) else { continue };
            let (axis, inward) = inward_normal(wall);
            let missing = -press.stress * self.servo_area(press, axis) - self.wall_force(number);
            let [stiffness, dashpots, carried] = self.wall_resistance(number);
            let free = if stiffness > 0.0 {
                let known = dt * carried + dashpots * inward * wall.velocity[axis];
                (press.gain * missing + known) / (dt * stiffness + dashpots)
            } else {
                press.speed * missing.signum()
            };
            self.walls[number].velocity[axis] = inward * free.clamp(-press.speed, press.speed);
        }
    }

    /// Outward force of the grains on a wall (N).
    pub(crate) fn wall_force(&self, number: usize) -> f64 {
        let (axis, inward) = inward_normal(&self.walls[number]);
        -inward * self.walls[number].reaction[0][axis]
    }

    /// Area on which the stress of a servo-controlled wall acts (m²; a length in the plane, m).
    pub(crate) fn servo_area(&self, press: &WallServo, axis: usize) -> f64 {
        let sleeve = || press.sleeve.as_ref().and_then(|name| self.enclosed_by(name, axis));
        press.area.or_else(sleeve).unwrap_or_else(|| self.wall_area(axis))
    }

    /// Area of walls across an axis (m², a length in the plane).
    fn wall_area(&self, axis: usize) -> f64 {
        (0..D).filter(|other| *other != axis).map(|other| self.extent(other)).product()
    }

    /// Extent of the specimen along an axis (m): between the current positions of the walls, or the width of the domain.
    pub(crate) fn extent(&self, axis: usize) -> f64 {
        let domain = &self.case.domain;
        if self.cell.periodic[axis] {
            return self.cell.h[axis][axis];
        }
        let stands = |upper: bool| {
            let of_axis =
                |wall: &&RigidWall<D>| wall.surface.is_none() && wall.axis == axis && wall.upper == upper;
            self.walls.iter().find(of_axis).map(|wall| wall.position)
        };
        stands(true).unwrap_or(domain.max[axis]) - stands(false).unwrap_or(domain.min[axis])
    }

    /// Sums over the contacts of a wall: normal stiffness (N/m), normal dashpots (N s/m), and stiffness times the inward velocity
    /// of the grain (N/s).
    fn wall_resistance(&self, number: usize) -> [f64; 3] {
        let wall = &self.walls[number];
        let (axis, inward) = inward_normal(wall);
        let scene = ContactInput::new(self.grains.view(), &self.laws.pairs, self.kinds.len());
        let touching = (0..self.wall_list.grain.len()).filter(|&k| {
            self.wall_list.wall[k] as usize == number && self.wall_list.memory.state[k] != CONTACT_APART
        });
        let of_contact = |k: usize| {
            let i = self.wall_list.grain[k] as usize;
            let (touch, _) = scene.wall_contact_geometry(i, wall, wall.distance(&self.grains.position[i]));
            let [stiffness, dashpot] = match &wall.laws[self.grains.kind[i] as usize].normal {
                NormalForceLaw::Linear(law) => [law.stiffness(touch.radius), law.response(&touch).damping],
                // The Hertz force is proportional to the overlap to the power 3/2.
                NormalForceLaw::Hertz(law) if touch.overlap > 0.0 => {
                    let base = law.response(&touch);
                    [1.5 * base.force / touch.overlap, base.damping]
                }
                NormalForceLaw::Hertz(_) => [0.0; 2],
            };
            [stiffness, dashpot, stiffness * inward * self.grains.velocity[i][axis]]
        };
        touching.map(of_contact).fold([0.0; 3], |sums, own| std::array::from_fn(|c| sums[c] + own[c]))
    }

    /// Position and stress of the walls that are servo-controlled in some stage (m; Pa, tension-positive; N/m in the plane).
    pub(crate) fn wall_outputs(&self) -> Vec<ScalarOutput> {
        let mut readings = Vec::new();
        for boundary in &self.case.boundaries {
            let name = boundary.name();
            // The servo of this stage, or else that of the first stage that has one for the wall.
            let stages = self.stage().into_iter().chain(self.options.stages.values());
            let Some(press) = stages.filter_map(|stage| stage.walls.get(name)).next() else { continue };
            let standing = self.walls.iter().position(|wall| wall.name == name);
            let (place, stress) = standing.map_or((f64::NAN, f64::NAN), |number| {
                let area = self.servo_area(press, self.walls[number].axis);
                (self.walls[number].position, -self.wall_force(number) / area)
            });
            readings.push((format!("wall.{name}.position"), "m".to_owned(), place));
            readings.push((format!("wall.{name}.stress"), "Pa".to_owned(), stress));
        }
        readings
    }
}

/// Axis normal to a wall, and the sign of the inward direction along it.
fn inward_normal<const D: usize>(wall: &RigidWall<D>) -> (usize, f64) {
    (wall.axis, if wall.upper { -1.0 } else { 1.0 })
}
