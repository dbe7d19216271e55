//! Rigid body: state and motion, and forces on it in a step.

use colluvium_case::rigid::{RigidBodyActions, RigidMass, RigidState, RigidStep, Twist};
use serde::{Deserialize, Serialize};

/// Motion of a rigid body.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct RigidBody {
    /// Position, with velocity and spin half a step earlier.
    pub state: RigidState,
    /// Rates of velocity and spin by the last forces (m/s², rad/s²).
    pub rate: Twist,
    /// Motion of the body in the current step.
    #[serde(skip)]
    pub step: Option<RigidStep>,
    /// Whether the body moves freely in the step.
    #[serde(skip)]
    pub moves_freely: bool,
    /// Velocity gradient of its rotation in the step (1/s).
    #[serde(skip)]
    pub rotation_gradient: [[f64; 3]; 3],
}

/// Forces on a rigid body in a step.
#[derive(Clone, Copy)]
pub struct RigidForces {
    /// Index of the group of its particles.
    pub group: usize,
    /// Mass, centre and inertia at its position.
    pub mass: RigidMass,
    /// Forces, and prescribed or free components.
    pub actions: RigidBodyActions,
    /// Rates of velocity and spin (m/s², rad/s²).
    pub rate: Twist,
}

impl RigidBody {
    /// Returns the body at the start.
    pub fn new(state: RigidState) -> Self {
        Self { state, ..Self::default() }
    }

    /// State extrapolated by a time (s) with the last forces.
    pub fn extrapolated(&self, time: f64) -> RigidState {
        let mut state = self.state;
        for c in 0..3 {
            state.velocity[c] += time * self.rate[c];
            state.angular_velocity[c] += time * self.rate[c + 3];
        }
        state
    }

    /// Sets velocity and spin to zero.
    pub fn set_at_rest(&mut self) {
        self.state.set_at_rest();
        self.rate = [0.0; 6];
    }
}
