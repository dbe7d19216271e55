//! Manufactured solutions: a chosen motion with the body force that satisfies the equation of motion.
//!
//! A method with support for them has a function beside its [`Method`](crate::Method) with a case and a [`Manufactured`] as arguments: the
//! force is not part of a case.

use colluvium_constitutive::{Mat3, Motion, PoreFluidState};

/// Prescribed position, velocity and deformation of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrescribedState {
    /// Position (m).
    pub position: [f64; 3],
    /// Velocity (m/s).
    pub velocity: [f64; 3],
    /// Deformation gradient from the stress-free state, row by row.
    pub deformation: [[f64; 3]; 3],
}

/// Initial state of the point at a position (m) in the stress-free state.
type InitialStateField = dyn Fn([f64; 3]) -> PrescribedState + Send + Sync;
/// Body force (m/s²) on that point at a time (s).
type BodyForceField = dyn Fn([f64; 3], f64) -> [f64; 3] + Send + Sync;

/// Manufactured solution: initial states of the points and the body force on them.
pub struct Manufactured {
    /// Initial state of the point at a position (m) in the stress-free state.
    pub start: Box<InitialStateField>,
    /// Body force (m/s²) on that point at a time (s).
    pub force: Box<BodyForceField>,
}

impl PrescribedState {
    /// Deformation of a point as one step from the stress-free state. `density` is its current density (kg/m³) and `size` its size (m).
    pub fn motion(&self, density: f64, size: f64) -> Motion {
        let deformation = Mat3(self.deformation);
        let gradient = deformation - Mat3::IDENTITY;
        Motion {
            deformation,
            velocity_gradient_dt: gradient,
            dt: 1.0,
            density,
            size,
            pore: PoreFluidState::default(),
        }
    }
}

impl Manufactured {
    /// Initial velocity gradient `∂v/∂x` (1/s; row `i`, column `j`) around the point at `place` (m) in the stress-free state, by
    /// differences over `width` (m). `None` where the deformation is not invertible.
    pub fn velocity_gradient(&self, place: [f64; 3], width: f64) -> Option<[[f64; 3]; 3]> {
        let velocity = |axis: usize, shift: f64| {
            let mut at = place;
            at[axis] += shift;
            (self.start)(at).velocity
        };
        let sides: [_; 3] = std::array::from_fn(|j| [0.5, -0.5].map(|half| velocity(j, half * width)));
        let rate = |i: usize, j: usize| (sides[j][0][i] - sides[j][1][i]) / width;
        let rates = Mat3(std::array::from_fn(|i| std::array::from_fn(|j| rate(i, j))));
        Some((rates * Mat3((self.start)(place).deformation).inverse()?).0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_velocity_gradient_is_that_in_the_deformed_body() {
        // Stretched to the double along x, with a further stretching rate of 3/s there: v = 3 x = 6 X; sheared by 0.5 y a second.
        let solution = Manufactured {
            start: Box::new(|[x, y, z]| PrescribedState {
                position: [2.0 * x, y, z],
                velocity: [6.0 * x + 0.5 * y, 0.0, 0.0],
                deformation: [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            }),
            force: Box::new(|_, _| [0.0; 3]),
        };
        let gradient = solution.velocity_gradient([0.3, -0.2, 1.0], 0.5).unwrap();
        let exact = [[3.0, 0.5, 0.0], [0.0; 3], [0.0; 3]];
        for (found, exact) in gradient.as_flattened().iter().zip(exact.as_flattened()) {
            assert!((found - exact).abs() < 1e-12, "{gradient:?}");
        }
        let motion = (solution.start)([0.0; 3]).motion(200.0, 0.1);
        assert_eq!(
            (motion.deformation.0[0][0], motion.velocity_gradient_dt.0[0][0], motion.density),
            (2.0, 1.0, 200.0)
        );
    }
}
