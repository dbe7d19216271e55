//! Time step of a rigid body.

use crate::description::PrescribedMotion;
use crate::loads::damping::{rayleigh_damped_velocity, sign_or_zero};
use crate::rigid::{
    IDENTITY_AXES, RigidMass, RigidState, Twist, multiply, rotation, solve, transposed, velocity_at,
};
use crate::spatial;

/// External actions on a rigid body in a step, and the free components of its motion.
#[derive(Clone, Copy, Debug)]
pub struct RigidBodyActions {
    /// Whether each component of its motion follows from forces.
    pub free_components: [bool; 6],
    /// Prescribed velocities of the other components (m/s).
    pub prescribed_velocities: [Option<f64>; 3],
    /// External force on the body (N).
    pub force: [f64; 3],
    /// Moment about the centre of mass (N m).
    pub moment: [f64; 3],
}

impl RigidBodyActions {
    /// Actions on a body at rest: no forces and no free components.
    pub const AT_REST: Self = Self {
        free_components: [false; 6],
        prescribed_velocities: [Some(0.0); 3],
        force: [0.0; 3],
        moment: [0.0; 3],
    };

    /// Actions on a body that moves at a prescribed velocity (m/s) and does not rotate.
    pub fn prescribed(velocity: [f64; 3]) -> Self {
        Self { prescribed_velocities: velocity.map(Some), ..Self::AT_REST }
    }

    /// Actions of a prescribed motion after `elapsed` seconds of its stage, with an additional force (N) and moment (N m).
    pub fn of_motion(
        motion: &PrescribedMotion,
        elapsed: f64,
        dimension: usize,
        beside: (&[f64; 3], &[f64; 3]),
    ) -> Self {
        let held = motion.velocity_at(elapsed);
        let free_components = std::array::from_fn(|c| match c {
            0..3 => c < dimension && held[c].is_none(),
            5 => motion.rotates && dimension >= 2,
            _ => motion.rotates && dimension == 3,
        });
        let (force, moment) = (motion.force_at(elapsed), motion.moment_at(elapsed));
        Self {
            free_components,
            prescribed_velocities: held,
            force: std::array::from_fn(|c| force[c] + beside.0[c]),
            moment: std::array::from_fn(|c| moment[c] + beside.1[c]),
        }
    }

    /// Force and moment (N, N m).
    pub fn applied(&self) -> Twist {
        let ([fx, fy, fz], [mx, my, mz]) = (self.force, self.moment);
        [fx, fy, fz, mx, my, mz]
    }

    /// Whether the body rotates.
    fn rotates(&self) -> bool {
        self.free_components[5]
    }
}

/// State of a rigid body during a step.
#[derive(Clone, Copy, Debug)]
pub struct RigidStep {
    /// Mass properties at the start of the step.
    pub mass: RigidMass,
    /// Directions of its initial axes at the start of the step, as columns.
    pub axes: [[f64; 3]; 3],
    /// Whether each component of its motion follows from forces.
    pub free_components: [bool; 6],
    /// Twist at the start of the step: velocity (m/s) and angular velocity (rad/s).
    pub start: Twist,
    /// Current estimate of the twist at the end of the step.
    pub motion: Twist,
    /// External force and moment (N, N m).
    pub applied_wrench: Twist,
}

impl RigidStep {
    /// State at the end of a step of `dt` (s) under external forces, before contact. `share` is the Rayleigh-damping coefficient times the
    /// step.
    pub fn new(mass: RigidMass, state: &RigidState, acts: &RigidBodyActions, dt: f64, share: f64) -> Self {
        let RigidBodyActions { free_components, prescribed_velocities: held, force, moment } = *acts;
        let turning = state.angular_momentum.map(|l| if acts.rotates() { l } else { 0.0 });
        let begun = mass.angular_velocity(&turning, &free_components);
        let pushed: [f64; 3] =
            std::array::from_fn(|c| rayleigh_damped_velocity(turning[c], turning[c] + dt * moment[c], share));
        let turned = mass.angular_velocity(&pushed, &free_components);
        let (mut start, mut motion) = ([0.0; 6], [0.0; 6]);
        for c in 0..3 {
            start[c] = state.velocity[c];
            let pushed = rayleigh_damped_velocity(start[c], start[c] + dt * force[c] / mass.mass, share);
            motion[c] = held[c].unwrap_or(if free_components[c] { pushed } else { 0.0 });
            (start[c + 3], motion[c + 3]) = (begun[c], turned[c]);
        }
        Self { mass, axes: state.axes, free_components, start, motion, applied_wrench: acts.applied() }
    }

    /// Velocity of the body at a position (m/s).
    pub fn velocity_at(&self, x: &[f64; 3]) -> [f64; 3] {
        velocity_at(&self.motion, &self.mass.lever_arm(x))
    }

    /// Kinetic energy of the change of velocity in the step (J).
    pub fn kinetic_energy_gain(&self) -> f64 {
        let change: Twist = std::array::from_fn(|k| self.motion[k] - self.start[k]);
        let momentum = multiply(&self.mass.matrix(), &change);
        0.5 * (0..6).map(|k| change[k] * momentum[k]).sum::<f64>()
    }

    /// Adds an impulse and its moment about the centre of mass (N s, N m s) to the motion.
    pub fn add_impulse(&mut self, impulse: &Twist) {
        if let Some(change) = solve(&self.mass.matrix(), impulse, &self.free_components) {
            (0..6).for_each(|k| self.motion[k] += change[k]);
        }
    }

    /// Applies local damping to the free components by their total change; rotations have the largest factor of the axes.
    pub fn damp(&mut self, damping: &[f64; 3]) {
        let largest = damping.iter().copied().fold(0.0, f64::max);
        for k in (0..6).filter(|k| self.free_components[*k]) {
            let change = self.motion[k] - self.start[k];
            let factor = damping.get(k).copied().unwrap_or(largest);
            self.motion[k] -= factor * change.abs() * sign_or_zero(self.start[k]);
        }
    }

    /// Angular momentum about the centre of mass (kg m²/s), with mass scaling.
    fn angular_momentum(&self) -> [f64; 3] {
        if self.rotates() { multiply(&self.mass.inertia, &self.angular_velocity()) } else { [0.0; 3] }
    }

    /// Whether the body rotates about the normal of the plane.
    fn rotates(&self) -> bool {
        self.free_components[5]
    }

    /// Velocity of the centre of mass (m/s).
    pub fn velocity(&self) -> [f64; 3] {
        [self.motion[0], self.motion[1], self.motion[2]]
    }

    /// Angular velocity (rad/s).
    pub fn angular_velocity(&self) -> [f64; 3] {
        [self.motion[3], self.motion[4], self.motion[5]]
    }

    /// Work of the external forces in a step of `dt` (J).
    pub fn work(&self, dt: f64) -> f64 {
        (0..6)
            .filter(|k| self.free_components[*k])
            .map(|k| self.applied_wrench[k] * self.motion[k] * dt)
            .sum()
    }

    /// Sets the twist of the body to that at the end of the step; the position remains that at the start.
    pub fn apply(&self, state: &mut RigidState) {
        (state.velocity, state.angular_velocity, state.angular_momentum) =
            (self.velocity(), self.angular_velocity(), self.angular_momentum());
    }

    /// Rotation matrix of a step of `dt` (s), by the angular velocity at mid-step, which is of second order.
    fn rotation(&self, dt: f64) -> [[f64; 3]; 3] {
        let by = |spin: [f64; 3], time: f64| rotation(&spin.map(|w| time * w));
        // The angular velocity about a fixed axis is constant.
        let middle = if self.free_components[3] {
            self.spin_after(&by(self.angular_velocity(), 0.5 * dt))
        } else {
            self.angular_velocity()
        };
        by(middle, dt)
    }

    /// Angular velocity of the body after a rotation, for its angular momentum (rad/s).
    fn spin_after(&self, turn: &[[f64; 3]; 3]) -> [f64; 3] {
        multiply(
            turn,
            &self.mass.angular_velocity(
                &multiply(&transposed(turn), &self.angular_momentum()),
                &self.free_components,
            ),
        )
    }

    /// Mean velocity gradient of the rotation in a step of `dt` (s), relative to the positions at its start (1/s).
    pub fn mean_gradient(&self, dt: f64) -> [[f64; 3]; 3] {
        let turn = if self.rotates() { self.rotation(dt) } else { IDENTITY_AXES };
        std::array::from_fn(|i| std::array::from_fn(|j| (turn[i][j] - IDENTITY_AXES[i][j]) / dt))
    }

    /// Rotates the body in a step of `dt` (s) with constant angular momentum, and returns the rotation matrix.
    pub fn rotate(&self, dt: f64, state: &mut RigidState) -> [[f64; 3]; 3] {
        let turn = self.rotation(dt);
        state.axes = std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..3).map(|k| turn[i][k] * self.axes[k][j]).sum())
        });
        state.angular_velocity = self.spin_after(&turn);
        turn
    }

    /// Moves the body and its points in a step of `dt` (s) and sets the velocities of the points, with constant angular momentum.
    pub fn move_points<const D: usize>(
        &self,
        dt: f64,
        state: &mut RigidState,
        positions: &mut [[f64; D]],
        velocities: &mut [[f64; D]],
    ) {
        let (turn, turns) = (self.rotate(dt, state), self.rotates());
        let [vx, vy, vz] = self.velocity();
        let motion =
            [vx, vy, vz, state.angular_velocity[0], state.angular_velocity[1], state.angular_velocity[2]];
        for (x, v) in positions.iter_mut().zip(velocities) {
            let mut arm = self.mass.lever_arm(&spatial(x));
            if turns {
                arm = multiply(&turn, &arm);
            }
            let velocity = velocity_at(&motion, &arm);
            for c in 0..D {
                x[c] = if turns { self.mass.centre[c] + arm[c] } else { x[c] } + dt * self.motion[c];
                v[c] = velocity[c];
            }
        }
    }
}
