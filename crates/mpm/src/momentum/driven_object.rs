//! Driven objects: rigid bodies, and patches of nodes with a prescribed motion (sheet: mpm §2.11).

use colluvium_case::rigid::{RigidState, RigidStep};
use colluvium_grid::{NodalState, Vector4};
use serde::{Deserialize, Serialize};

/// Rigid body, or patch of prescribed velocity, with its motion and the force on it.
#[derive(Clone, Debug)]
pub struct DrivenObject {
    /// Name of the body or patch.
    pub name: String,
    /// Index into `Case::patches`; `None` for a rigid body.
    pub patch: Option<usize>,
    /// Corners of the bounding box of the patch at the start (m).
    pub bounds: [[f64; 3]; 2],
    /// Prescribed velocity at the start of the step (m/s); `None` for components that were not prescribed.
    pub previous_velocity: [Option<f64>; 3],
    /// Motion of a free rigid body in the step.
    pub free_rigid_body: Option<RigidStep>,
    /// Motion and force of the object, which a checkpoint stores.
    pub state: DrivenObjectState,
}

/// State of a [`DrivenObject`] that changes during a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DrivenObjectState {
    /// Velocity of a patch at the end of the step (m/s); `None` for components that are not prescribed.
    pub velocity: [Option<f64>; 3],
    /// Motion of a rigid body at the end of the step.
    pub rigid: RigidState,
    /// Velocity that a program prescribes in place of the motion of the case (m/s).
    pub program_velocity: Option<[f64; 3]>,
    /// Displacement since the start (m).
    pub displacement: [f64; 3],
    /// Force of the material on the object in the last step (N).
    pub force: [f64; 3],
    /// Impulse of the material on the object since the start (N s).
    pub impulse: [f64; 3],
}

impl DrivenObject {
    /// Adds an impulse (N s) of the material in a step of `dt`.
    pub fn add_impulse(&mut self, impulse: [f64; 3], dt: f64) {
        for c in 0..3 {
            self.state.impulse[c] += impulse[c];
            self.state.force[c] += impulse[c] / dt;
        }
    }

    /// Sets velocity and acceleration of a solved node to the prescribed motion. Returns the impulse of the material on the object (N s),
    /// without mass scaling.
    pub fn impose_on_node(&self, node: &mut NodalState, keep_start: bool, dt: f64) -> [f64; 3] {
        let (mut end, mut rate) = (node.momentum_and_mass.to_array(), node.force.to_array());
        let mut impulse = [0.0; 3];
        for c in 0..3 {
            let Some(prescribed) = self.state.velocity[c] else { continue };
            let own = end[c] - dt * rate[c];
            let start = if keep_start { own } else { self.previous_velocity[c].unwrap_or(own) };
            let acceleration = (prescribed - start) / dt;
            impulse[c] = end[3] * dt * (rate[c] - acceleration);
            end[c] = prescribed;
            rate[c] = acceleration;
        }
        *node = NodalState { momentum_and_mass: Vector4::new(end), force: Vector4::new(rate) };
        impulse
    }

    /// Sets the prescribed components of a velocity (m/s).
    pub fn impose_velocity(&self, vector: &mut Vector4) {
        let mut velocity = vector.to_array();
        for c in 0..3 {
            velocity[c] = self.state.velocity[c].unwrap_or(velocity[c]);
        }
        *vector = Vector4::new(velocity);
    }

    /// Velocity of a rigid body at a position (m/s).
    pub fn velocity_at(&self, x: &[f64; 3]) -> [f64; 3] {
        self.free_rigid_body.as_ref().map_or(self.velocity(), |free_body| free_body.velocity_at(x))
    }

    /// Velocity of the centre of mass of a rigid body, or of a patch with zero for components that are not prescribed (m/s).
    pub fn velocity(&self) -> [f64; 3] {
        if self.patch.is_some() {
            self.state.velocity.map(|v| v.unwrap_or(0.0))
        } else {
            self.state.rigid.velocity
        }
    }
}
