//! Newton's method for the motion of a rigid body that satisfies the contact laws at all contact points.

use crate::rigid::{RigidStep, Twist, solve, velocity_at, wrench_at};
use colluvium_constitutive::Warning;

/// Largest number of Newton iterations.
const MAX_ITERATIONS: usize = 60;
/// Largest number of halvings of an iteration step.
const HALVINGS: usize = 12;
/// Change of the motion over the motion at convergence.
const CONVERGENCE_TOLERANCE: f64 = 1e-13;

/// Contact law at a point of a rigid body: impulse as a function of the velocity there.
pub trait ContactLawAtPoint {
    /// Position of the contact point relative to the centre of mass (m).
    fn lever_arm(&self) -> &[f64; 3];

    /// Impulse (N s) on the body for the velocity `w` (m/s) at this point.
    fn impulse(&self, w: &[f64; 3]) -> [f64; 3];

    /// Decrease of the impulse with the velocity at the point (kg).
    fn stiffness(&self, w: &[f64; 3]) -> [[f64; 3]; 3];
}

/// All contacts of a rigid body.
pub trait ContactSystem {
    /// Impulse (N s) and its moment (N m s) on the body for a motion; with `stuck`, contacts stick to the ground that supports the body.
    fn impulse(&self, motion: &Twist, stuck: bool) -> Twist;

    /// Decrease of impulse and moment with the motion.
    fn stiffness(&self, motion: &Twist, stuck: bool) -> [Twist; 6];
}

/// Adds to `sum` the impulses of contacts on a body with this motion.
pub fn add_impulses<T: ContactLawAtPoint>(touches: impl Iterator<Item = T>, motion: &Twist, sum: &mut Twist) {
    for touch in touches {
        let own = wrench_at(&touch.impulse(&velocity_at(motion, touch.lever_arm())), touch.lever_arm());
        (0..6).for_each(|k| sum[k] += own[k]);
    }
}

/// Adds to `sum` the derivative of the impulses of contacts by the motion, with a negative sign.
pub fn add_stiffness<T: ContactLawAtPoint>(
    touches: impl Iterator<Item = T>,
    motion: &Twist,
    sum: &mut [Twist; 6],
) {
    for touch in touches {
        let (arm, fall) = (touch.lever_arm(), touch.stiffness(&velocity_at(motion, touch.lever_arm())));
        for axis in 0..3 {
            let column = wrench_at(&std::array::from_fn(|c| fall[c][axis]), arm);
            // Velocity along an axis, by the six components of the motion.
            let along = wrench_at(&std::array::from_fn(|c| if c == axis { 1.0 } else { 0.0 }), arm);
            for i in 0..6 {
                (0..6).for_each(|j| sum[i][j] += column[i] * along[j]);
            }
        }
    }
}

/// Warning about the number of steps (`times`) in which the contact was not solved; `None` for zero.
pub fn unconverged_warning(times: u64) -> Option<Warning> {
    (times > 0).then(|| {
        Warning::new("rigid-contact-not-converged", format!(
            "the contact of a rigid body that moves freely did not converge in {times} steps. In these steps \
             its friction or its support is smaller than the contact law gives; momentum is conserved. Use a \
             smaller time step"
        ))
    })
}

/// Largest velocity and angular velocity of two motions.
fn speeds(one: &Twist, other: &Twist) -> [f64; 2] {
    [0..3, 3..6].map(|part| part.map(|k| one[k].abs().max(other[k].abs())).fold(0.0, f64::max))
}

impl RigidStep {
    /// Motion of the body that is consistent with the impulses of all contacts, and whether the iteration has converged.
    ///
    /// Newton's method may cycle from a sliding motion where friction that ends the sliding increases the normal force more than it
    /// decelerates (as in Painlevé's paradox); it is then restarted from the motion with sticking contacts.
    pub fn solve_contact(&self, touched: &dyn ContactSystem) -> (Twist, bool) {
        let first = self.solve_contact_from(&self.motion, touched, false);
        if first.1 {
            return first;
        }
        let stuck = self.solve_contact_from(&self.motion, touched, true).0;
        let again = self.solve_contact_from(&stuck, touched, false);
        // Sticking contacts dissipate energy; the last iterate of Newton's method without convergence is arbitrary.
        if again.1 { again } else { (stuck, false) }
    }

    /// Solves for the motion at the end of the step by Newton's method from the motion `start`; the second value is whether it converged.
    fn solve_contact_from(&self, start: &Twist, touched: &dyn ContactSystem, stuck: bool) -> (Twist, bool) {
        let (matrix, free, before) = (self.mass.matrix(), self.free_components, self.motion);
        let rest = |motion: &Twist| -> Twist {
            let impulse = touched.impulse(motion, stuck);
            std::array::from_fn(|i| {
                (0..6).map(|j| matrix[i][j] * (motion[j] - before[j])).sum::<f64>() - impulse[i]
            })
        };
        let size = |rest: &Twist| -> f64 {
            solve(&matrix, rest, &free).map_or(f64::NAN, |x| (0..6).map(|k| x[k] * rest[k]).sum())
        };
        let mut motion = *start;
        let mut open = rest(&motion);
        let mut large = size(&open);
        for _ in 0..MAX_ITERATIONS {
            if large == 0.0 {
                return (motion, true);
            }
            let mut tangent = touched.stiffness(&motion, stuck);
            (0..6).for_each(|i| (0..6).for_each(|j| tangent[i][j] += matrix[i][j]));
            let Some(step) = solve(&tangent, &open, &free) else { return (motion, false) };
            let [along, about] = speeds(&motion, &before);
            let about = about.max(along / self.mass.radius());
            let moves =
                (0..6).all(|k| step[k].abs() <= CONVERGENCE_TOLERANCE * if k < 3 { along } else { about });
            let (mut share, mut next) = (1.0, motion);
            for _ in 0..HALVINGS {
                next = std::array::from_fn(|k| motion[k] - share * step[k]);
                let left = rest(&next);
                let now = size(&left);
                if now <= large || moves {
                    (open, large) = (left, now);
                    break;
                }
                share *= 0.5;
                (open, large) = (left, now);
            }
            motion = next;
            if moves {
                return (motion, true);
            }
        }
        (motion, false)
    }
}
