//! Body force of a program on the particles.

use colluvium_case::SolverError;
use rayon::prelude::*;

use crate::clock::Clock;
use crate::points::particles::{Bodies, MIN_PARTICLES_PER_TASK, Particles};
use crate::rates::Rates;

/// Computes the body force of the program at the present positions, velocities and time, for bodies that are neither rigid nor held.
///
/// # Errors
/// The first particle at which it is not finite; nothing else has changed then.
pub fn update_body_forces<const D: usize>(clock: &Clock, bodies: &mut Bodies<D>) -> Result<(), SolverError> {
    let Bodies { particles, groups, loads, .. } = bodies;
    let Some(force) = &loads.body_force else { return Ok(()) };
    let len = particles.len();
    particles.body_force.resize(len, [0.0; D]);
    for group in groups.iter().filter(|group| group.is_free()) {
        let Particles { position, velocity, body_force, .. } = &mut *particles;
        let (x, v) = (&position[group.range()], &velocity[group.range()]);
        let computed = force.accelerations(x, v, clock.time, &mut body_force[group.range()]);
        if let Err(invalid) = computed {
            return Err(particles.particle_error(clock, group.start + invalid.point, invalid.to_string()));
        }
    }
    Ok(())
}

/// Adds the body force of the program to the accelerations.
pub fn apply_body_forces<const D: usize>(particles: &Particles<D>, rates: &mut Rates<D>) {
    let Rates { external_accelerations, derivatives, .. } = rates;
    let all = derivatives.acceleration.par_iter_mut().zip(external_accelerations).zip(&particles.body_force);
    all.with_min_len(MIN_PARTICLES_PER_TASK).for_each(|((acceleration, external), force)| {
        for c in 0..D {
            external[c] += force[c];
            acceleration[c] += force[c];
        }
    });
}
