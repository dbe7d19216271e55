//! A rigid body: how it stands and moves, and what acts on it in a step.

use colluvium_case::rigid::{RigidBodyActions, RigidMass, RigidState, RigidStep, Twist};
use serde::{Deserialize, Serialize};

/// A rigid body.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct RigidBody {
    /// Where it is and, half a step behind, how it moves.
    pub state: RigidState,
    /// How the last forces change velocity and spin (m/s², rad/s²).
    pub rate: Twist,
    /// What it does in the step.
    #[serde(skip)]
    pub step: Option<RigidStep>,
    /// Whether it moves freely in the step.
    #[serde(skip)]
    pub moves_freely: bool,
    /// Velocity gradient of its turn in the step (1/s).
    #[serde(skip)]
    pub rotation_gradient: [[f64; 3]; 3],
}

/// What acts on a rigid body in a step.
#[derive(Clone, Copy)]
pub struct RigidForces {
    /// Number of the group of its particles.
    pub group: usize,
    /// Its mass where it is.
    pub mass: RigidMass,
    /// Forces, and what follows them.
    pub actions: RigidBodyActions,
    /// Rates of its velocity and spin (m/s², rad/s²).
    pub rate: Twist,
}

impl RigidBody {
    /// At the start.
    pub fn new(state: RigidState) -> Self {
        Self { state, ..Self::default() }
    }

    /// Its motion some time (s) ahead, by the last forces.
    pub fn extrapolated(&self, time: f64) -> RigidState {
        let mut state = self.state;
        for c in 0..3 {
            state.velocity[c] += time * self.rate[c];
            state.angular_velocity[c] += time * self.rate[c + 3];
        }
        state
    }

    /// Brings it to rest where it is.
    pub fn stop(&mut self) {
        self.state.stop();
        self.rate = [0.0; 6];
    }
}
