//! Walls that follow a stress (sheet: dem §3.7, rigid-wall servo).

use colluvium_case::measure::ScalarOutput;

use crate::boundary::walls::RigidWall;
use crate::config::WallServo;
use crate::contact::{CONTACT_APART, NormalForceLaw};
use crate::force_loop::ContactInput;
use crate::solver::DemSolver;

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Walls that the stage presses take the velocities with which they go on for `dt` (s): inwards
    /// `(α (F - F_w) + Δt Σ k_n v_n + Σ γ_n v) / (Δt Σ k_n + Σ γ_n)`, at most their speed, and that speed where nothing touches them. `v` is the
    /// velocity that they had: the force at the wall has what dashpots make of it. Without them in the rule a wall whose `α Σ γ_n` is beyond
    /// `Δt Σ k_n` turns round every step. `v_n` are the velocities of the grains that touch the wall: it goes with them, and makes good a
    /// share of the missing force besides (sheet: dem §3.7).
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

    /// Force with which grains press a wall outwards (N).
    pub(crate) fn wall_force(&self, number: usize) -> f64 {
        let (axis, inward) = inward_normal(&self.walls[number]);
        -inward * self.walls[number].reaction[0][axis]
    }

    /// Area that the stress on a wall across an axis is of (m², a length in the plane).
    pub(crate) fn servo_area(&self, press: &WallServo, axis: usize) -> f64 {
        let sleeve = || press.sleeve.as_ref().and_then(|name| self.enclosed_by(name, axis));
        press.area.or_else(sleeve).unwrap_or_else(|| self.wall_area(axis))
    }

    /// Area of walls across an axis (m², a length in the plane).
    fn wall_area(&self, axis: usize) -> f64 {
        (0..D).filter(|other| *other != axis).map(|other| self.extent(other)).product()
    }

    /// Extent of the specimen along an axis (m): what lies between the walls where they stand, or as wide as the domain.
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

    /// Sums over the contacts with a wall of the normal stiffness (N/m), of the dashpots along the normal (N s/m), and of the stiffness times
    /// the velocity of the grain inwards (N/s).
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
                // The force goes with the overlap to the power 3/2.
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

    /// Place and stress of the walls that some stage presses (m; Pa, tension-positive; N/m in the plane).
    pub(crate) fn wall_outputs(&self) -> Vec<ScalarOutput> {
        let mut readings = Vec::new();
        for boundary in &self.case.boundaries {
            let name = boundary.name();
            // As in this stage, or else as in the first one that presses it.
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

/// The axis across a wall, and the sign along it of the way to the grains.
fn inward_normal<const D: usize>(wall: &RigidWall<D>) -> (usize, f64) {
    (wall.axis, if wall.upper { -1.0 } else { 1.0 })
}
