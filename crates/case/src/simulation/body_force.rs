//! Body force of a program: an acceleration by position, velocity and time.

use rayon::prelude::*;

use crate::solver::SolverError;

/// Function of a body force: acceleration (m/s²) at a position (m), a velocity (m/s) and a time (s).
type Acceleration<const D: usize> = dyn Fn(&[f64; D], &[f64; D], f64) -> [f64; D] + Send + Sync;

/// Fewest points for which a thread computes body forces.
const POINTS_PER_THREAD: usize = 1024;

/// Body force of a program on the points of a solver, in addition to gravity.
pub struct BodyForce<const D: usize> {
    acceleration: Box<Acceleration<D>>,
}

impl<const D: usize> BodyForce<D> {
    /// Body force from an acceleration (m/s²) by position (m), velocity (m/s) and time (s).
    pub fn new(acceleration: impl Fn(&[f64; D], &[f64; D], f64) -> [f64; D] + Send + Sync + 'static) -> Self {
        Self { acceleration: Box::new(acceleration) }
    }

    /// Computes the accelerations (m/s²) of points at a time (s), in parallel.
    ///
    /// # Errors
    /// The first point whose acceleration is not finite, by its index.
    pub fn accelerations(
        &self,
        positions: &[[f64; D]],
        velocities: &[[f64; D]],
        time: f64,
        out: &mut [[f64; D]],
    ) -> Result<(), InvalidBodyForce> {
        assert_eq!(positions.len(), out.len(), "one acceleration for each position");
        assert_eq!(velocities.len(), out.len(), "one acceleration for each velocity");
        let points = out.par_iter_mut().zip(positions).zip(velocities).with_min_len(POINTS_PER_THREAD);
        points.for_each(|((out, position), velocity)| *out = (self.acceleration)(position, velocity, time));
        match out.iter().position(|a| !a.iter().all(|a| a.is_finite())) {
            None => Ok(()),
            Some(point) => Err(InvalidBodyForce { point, acceleration: out[point].to_vec() }),
        }
    }
}

/// Point at which a body force is not finite.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("the body force of the program gives the acceleration {acceleration:?} m/s²")]
pub struct InvalidBodyForce {
    /// Index of the point.
    pub point: usize,
    /// Acceleration (m/s²).
    pub acceleration: Vec<f64>,
}

/// Refuses a state whose body force the solver has not, or the reverse: the function itself is not in a checkpoint.
///
/// # Errors
/// When exactly one of both has a body force.
pub fn check_saved_body_force(is_saved: bool, is_set: bool) -> Result<(), SolverError> {
    if is_saved == is_set {
        return Ok(());
    }
    let [with, cure] = if is_saved { ["with", "set"] } else { ["without", "clear"] };
    Err(SolverError::Checkpoint(format!(
        "was saved {with} a body force of the program: {cure} it before the state is restored"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accelerations_are_those_of_the_function_at_each_point() {
        let drag = BodyForce::new(|x: &[f64; 2], v: &[f64; 2], t| [x[0] - v[0], t * v[1]]);
        let (x, v) = ([[1.0, 0.0], [2.0, 0.0]], [[0.5, 3.0], [4.0, -1.0]]);
        let mut out = [[0.0; 2]; 2];
        drag.accelerations(&x, &v, 2.0, &mut out).unwrap();
        assert_eq!(out, [[0.5, 6.0], [-2.0, -2.0]]);
    }

    #[test]
    fn the_first_acceleration_that_is_not_finite_is_named() {
        let pole = BodyForce::new(|x: &[f64; 1], _: &[f64; 1], _| [1.0 / x[0]]);
        let error = pole.accelerations(&[[1.0], [0.0], [0.0]], &[[0.0]; 3], 0.0, &mut [[0.0]; 3]);
        assert_eq!(error.unwrap_err().point, 1);
    }

    #[test]
    fn a_saved_state_needs_the_same_presence_of_a_body_force() {
        assert!(check_saved_body_force(true, true).is_ok());
        assert!(check_saved_body_force(true, false).unwrap_err().to_string().contains("set it before"));
        assert!(check_saved_body_force(false, true).unwrap_err().to_string().contains("clear it before"));
    }
}
