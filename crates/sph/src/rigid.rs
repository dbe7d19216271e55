//! How a rigid body moves in a step, by the `motions` of the stage.

use colluvium_case::Case;

use crate::clock::Clock;

/// How a rigid body moves in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rigid {
    /// Velocity (m/s); `None` along a component that follows forces.
    pub velocity: [Option<f64>; 3],
    /// Force along these (N).
    pub force: [f64; 3],
    /// Moment about the centre of mass (N m), in the plane.
    pub moment: f64,
    /// Whether it turns.
    pub turns: bool,
    /// Its spin (rad/s), in the plane.
    pub spin: f64,
}

impl Rigid {
    /// Of a body in a step of `dt` (s), of which velocities are those in the middle; at rest where the stage says nothing.
    pub fn of(case: &Case, body: u32, clock: &Clock, dt: f64) -> Self {
        let name = &case.bodies[body as usize].name;
        let Some(motion) = case.stages[clock.stage].motion_of(name) else {
            return Self { velocity: [Some(0.0); 3], ..Self::default() };
        };
        let elapsed = clock.time + 0.5 * dt - clock.stage_start;
        Self {
            velocity: motion.velocity_at(elapsed),
            force: motion.force_at(elapsed),
            moment: motion.moment_at(elapsed)[2],
            turns: motion.turns,
            spin: 0.0,
        }
    }
}
