//! Rigid bodies that move freely stand on walls: each corner of a point near a wall meets it where the wall is.

use colluvium_case::description::Wall;
use colluvium_case::rigid::RigidStep;
use colluvium_case::spatial;

use crate::background::Background;
use crate::bodies::Bodies;
use crate::clock::Clock;
use crate::vectors::{dot, norm};

/// Inertia with which a wall takes what comes, over the mass of the body: it sinks in under its weight this much more slowly
/// than it would fall from rest in a step.
pub const STIFF: f64 = 1e6;

/// A corner of a body near a wall.
#[derive(Clone, Copy, Debug)]
pub struct Plank {
    /// From the centre of mass (m).
    pub arm: [f64; 3],
    /// Velocity of the wall (m/s).
    pub velocity: [f64; 3],
    /// Unit vector off the wall.
    normal: [f64; 3],
    /// Velocity of approach that takes the corner to the wall in the step (m/s).
    room: f64,
    /// Coefficient of friction; infinite where it sticks.
    friction: f64,
}

impl Plank {
    /// Push of a wall of some inertia on a body with the velocity `w` (m/s) here, share of a sliding velocity that it takes
    /// away times the inertia (kg), and that velocity; `None` off the wall.
    fn pressed(&self, inertia: f64, w: &[f64; 3]) -> Option<(f64, f64, [f64; 3])> {
        let relative: [f64; 3] = std::array::from_fn(|c| w[c] - self.velocity[c]);
        let away = dot(&relative, &self.normal);
        let push = inertia * (-away - self.room);
        let along: [f64; 3] = std::array::from_fn(|c| relative[c] - away * self.normal[c]);
        let slip = norm(&along);
        let held = if slip > 0.0 { inertia.min(self.friction * push / slip) } else { inertia };
        // Written so that NaN is off the wall.
        (push > 0.0).then_some((push, held, along))
    }

    /// Impulse (N s) of a wall of some inertia (kg) on a body with the velocity `w` (m/s) here.
    pub fn impulse(&self, inertia: f64, w: &[f64; 3]) -> [f64; 3] {
        self.pressed(inertia, w).map_or([0.0; 3], |(push, held, along)| {
            std::array::from_fn(|c| push * self.normal[c] - held * along[c])
        })
    }

    /// How it falls with that velocity (kg).
    pub fn stiffness(&self, inertia: f64, w: &[f64; 3]) -> [[f64; 3]; 3] {
        let Some((_, held, along)) = self.pressed(inertia, w) else { return [[0.0; 3]; 3] };
        let slip = norm(&along);
        let slips = held < inertia && slip > 0.0;
        let t = along.map(|c| if slips { c / slip } else { 0.0 });
        let drag = if slips { self.friction } else { 0.0 };
        let n = &self.normal;
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let one = if i == j { 1.0 } else { 0.0 };
                inertia * (n[i] - drag * t[i]) * n[j] + held * (one - n[i] * n[j] - t[i] * t[j])
            })
        })
    }
}

/// Lists the corners of the points of rigid body `number` that can reach walls in the step.
pub fn planks<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &Bodies<D>,
    number: usize,
    loose: &RigidStep,
    planks: &mut Vec<Plank>,
) {
    planks.clear();
    let Some(set) = bodies.sets.iter().find(|set| set.rigid == Some(number)) else { return };
    let half = 0.5 * set.extent[0];
    // From the middle of a point to its corners; in a plane the third axis has none.
    let corner = |k: usize| -> [f64; 3] {
        let axis = |a: usize| if a < D { half * if k >> a & 1 == 0 { -1.0 } else { 1.0 } } else { 0.0 };
        let own = [axis(0), axis(1), axis(2)];
        std::array::from_fn(|c| (0..3).map(|a| loose.axes[c][a] * own[a]).sum())
    };
    let domain = &clock.case.domain;
    for (_, boundary) in clock.case.active_boundaries(clock.stage) {
        let friction = match boundary.wall {
            Wall::Rough => f64::INFINITY,
            Wall::Smooth => 0.0,
            Wall::Frictional { friction_coefficient, .. } => friction_coefficient,
            Wall::Absorbing { .. } => continue,
        };
        let axis = boundary.side.axis();
        // The axis of rotation holds nothing.
        if boundary.group.is_some() || (background.axisymmetric && axis == 0) {
            continue;
        }
        let off = if boundary.side.is_max() { -1.0 } else { 1.0 };
        let face = boundary.position(domain);
        let normal = std::array::from_fn(|c| if c == axis { off } else { 0.0 });
        let velocity = boundary.velocity.as_ref().map_or([0.0; 3], |v| spatial(v));
        for x in &set.points.position {
            if off * (x[axis] - face) > 3.0 * half {
                continue;
            }
            for k in 0..1 << D {
                let own = corner(k);
                let gap = off * (x[axis] + own[axis] - face);
                if gap > half {
                    continue;
                }
                let at = spatial(x);
                let arm = loose.mass.arm(&std::array::from_fn(|c| at[c] + own[c]));
                let room = gap.max(0.0) / clock.dt;
                planks.push(Plank { arm, velocity, normal, room, friction });
            }
        }
    }
}
