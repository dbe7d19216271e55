//! Free rigid bodies, for all methods: mass and moments of inertia of their points, motion and orientation, and their time step by Newton's
//! and Euler's laws (docs/theory/mpm.md, rigid bodies).

mod rigid_contact_newton;
mod rigid_step;
mod support;
mod twist;

#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

use crate::description::Velocity;
use crate::measure::ScalarOutput;
use crate::{Budget, spatial};

pub use crate::rigid::rigid_contact_newton::{
    ContactLawAtPoint, ContactSystem, add_impulses, add_stiffness, unconverged_warning,
};
pub use crate::rigid::rigid_step::{RigidBodyActions, RigidStep};
pub use crate::rigid::support::{ObstacleContact, SupportPoints, SupportReaction, WallPlane};
pub use crate::rigid::twist::{
    IDENTITY_AXES, Twist, multiply, rotation, solve, transposed, velocity_at, wrench_at,
};

/// State of a rigid body in a restart: motion and orientation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RigidState {
    /// Velocity of the centre of mass (m/s).
    pub velocity: [f64; 3],
    /// Angular velocity (rad/s).
    pub angular_velocity: [f64; 3],
    /// Angular momentum about the centre of mass (kg m²/s), with mass scaling.
    pub angular_momentum: [f64; 3],
    /// Current directions of its initial axes, as columns.
    pub axes: [[f64; 3]; 3],
}

impl Default for RigidState {
    fn default() -> Self {
        Self {
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            angular_momentum: [0.0; 3],
            axes: IDENTITY_AXES,
        }
    }
}

impl RigidState {
    /// State with the velocity of the case: uniform, or linear with a rotation.
    pub fn initial(mass: &RigidMass, given: &Velocity) -> Self {
        let velocity = given.velocity_at(mass.centre);
        // The velocity is linear: differences over a metre are its gradient.
        let slope = |i: usize, j: usize| {
            let mut to = mass.centre;
            to[j] += 1.0;
            given.velocity_at(to)[i] - velocity[i]
        };
        let spin = [slope(2, 1), slope(0, 2), slope(1, 0)];
        Self {
            velocity,
            angular_velocity: spin,
            angular_momentum: multiply(&mass.inertia, &spin),
            ..Self::default()
        }
    }

    /// State with the momentum of points of these masses (kg) and velocities (m/s).
    pub fn of_points<const D: usize>(
        mass: &RigidMass,
        masses: &[f64],
        positions: &[[f64; D]],
        velocities: &[[f64; D]],
    ) -> Self {
        let mut sum = [0.0; 6];
        for ((m, x), v) in masses.iter().zip(positions).zip(velocities) {
            let own = wrench_at(&spatial(&v.map(|c| m * c)), &mass.lever_arm(&spatial(x)));
            (0..6).for_each(|k| sum[k] += own[k]);
        }
        let [px, py, pz, lx, ly, lz] = sum;
        let free = [false, false, false, D == 3, D == 3, D >= 2];
        // Before they belong to the body, the points have no rotation of their own.
        let spin = RigidMass::of_points(masses, positions, 0.0).angular_velocity(&[lx, ly, lz], &free);
        let velocity = [px, py, pz].map(|p| p / mass.mass);
        Self {
            velocity,
            angular_velocity: spin,
            angular_momentum: multiply(&mass.inertia, &spin),
            ..Self::default()
        }
    }

    /// Sets the velocity and angular momentum to zero at the current position.
    pub fn set_at_rest(&mut self) {
        *self = Self { axes: self.axes, ..Self::default() };
    }

    /// Adds the rotational energy and angular momentum of the points about their own centres to a budget: squares or cubes of one width (m)
    /// and of a total mass (kg).
    pub fn add_rotation_energy(&self, mass: f64, width: f64, budget: &mut Budget) {
        let own = own_inertia(width) * mass;
        budget.kinetic += 0.5 * own * self.angular_velocity.iter().map(|w| w * w).sum::<f64>();
        (0..3).for_each(|c| budget.angular_momentum[c] += own * self.angular_velocity[c]);
    }

    /// Scalar outputs of the body `name` in a space of `dimension` axes: velocity, angular velocity, and in the plane the angle.
    pub fn scalar_outputs(&self, name: &str, dimension: usize) -> Vec<ScalarOutput> {
        let axes = ["x", "y", "z"].into_iter().enumerate();
        let along = axes.clone().take(dimension);
        let about = axes.filter(|(c, _)| dimension == 3 || (dimension == 2 && *c == 2));
        let velocities = along.map(|(c, axis)| (format!("{name}.velocity.{axis}"), "m/s", self.velocity[c]));
        let spins = about.map(|(c, axis)| (format!("{name}.spin.{axis}"), "rad/s", self.angular_velocity[c]));
        let angle = (dimension == 2).then(|| (format!("{name}.angle"), "rad", self.angle()));
        let all = velocities.chain(spins).chain(angle);
        all.map(|(column, unit, value)| (column, unit.to_owned(), value)).collect()
    }

    /// Rotation angle in the plane, from -π to π (rad).
    fn angle(&self) -> f64 {
        self.axes[1][0].atan2(self.axes[0][0])
    }
}

/// Mass and moments of inertia of a rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMass {
    /// Mass (kg).
    pub mass: f64,
    /// Centre of mass (m).
    pub centre: [f64; 3],
    /// Moments of inertia about the centre of mass (kg m²).
    pub inertia: [[f64; 3]; 3],
}

/// Moment of inertia of a point about its own centre, over its mass (m²): that of a square or a cube of this width (m).
fn own_inertia(width: f64) -> f64 {
    width * width / 6.0
}

impl RigidMass {
    /// Mass properties of points of these masses (kg), squares or cubes of one width (m).
    pub fn of_points<const D: usize>(masses: &[f64], positions: &[[f64; D]], width: f64) -> Self {
        let mut sum = [0.0; D];
        for (m, x) in masses.iter().zip(positions) {
            (0..D).for_each(|c| sum[c] += m * x[c]);
        }
        let mass = masses.iter().sum::<f64>();
        let centre = spatial(&sum.map(|c| c / mass));
        let (own, mut inertia) = (own_inertia(width), [[0.0; 3]; 3]);
        for (m, x) in masses.iter().zip(positions) {
            let x = spatial(x);
            let arm: [f64; 3] = std::array::from_fn(|c| x[c] - centre[c]);
            let square = arm.iter().map(|c| c * c).sum::<f64>() + own;
            for i in 0..3 {
                (0..3).for_each(|j| inertia[i][j] -= m * arm[i] * arm[j]);
                inertia[i][i] += m * square;
            }
        }
        Self { mass, centre, inertia }
    }

    /// Mass properties with all inertia times a factor.
    pub fn scaled(mut self, scale: f64) -> Self {
        self.mass *= scale;
        self.inertia = self.inertia.map(|row| row.map(|i| scale * i));
        self
    }

    /// Position relative to the centre of mass (m).
    pub fn lever_arm(&self, x: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|c| x[c] - self.centre[c])
    }

    /// Mass and moments of inertia as one 6 × 6 matrix.
    pub fn matrix(&self) -> [Twist; 6] {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| match (i < 3, j < 3) {
                (true, true) if i == j => self.mass,
                (false, false) => self.inertia[i - 3][j - 3],
                _ => 0.0,
            })
        })
    }

    /// Angular velocity (rad/s) about the `free` components, for an angular momentum (kg m²/s).
    pub fn angular_velocity(&self, turning: &[f64; 3], free: &[bool; 6]) -> [f64; 3] {
        let right = [0.0, 0.0, 0.0, turning[0], turning[1], turning[2]];
        let only = [false, false, false, free[3], free[4], free[5]];
        solve(&self.matrix(), &right, &only).map_or([0.0; 3], |x| [x[3], x[4], x[5]])
    }

    /// Largest radius of gyration about an axis (m).
    pub fn radius(&self) -> f64 {
        (0..3).map(|k| self.inertia[k][k] / self.mass).fold(0.0, f64::max).sqrt()
    }
}
