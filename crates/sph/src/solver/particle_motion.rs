//! Motion of particles: kick and drift.

use colluvium_case::{FailureReason, SolverError};
use rayon::prelude::*;

use crate::clock::Clock;
use crate::context::SolverContext;
use crate::neighbours::verlet_lists::VerletLists;
use crate::points::packed_particles::set_velocity;
use crate::points::particles::{Bodies, MIN_PARTICLES_PER_TASK, ParticleGroup, Particles};
use crate::points::vector_algebra::square;
use crate::rates::Rates;
use crate::solver::EquilibriumTerms;
use crate::walls::Walls;

/// Equilibrium terms of each free particle: unbalanced and external forces, kinetic energy and work.
pub fn equilibrium_terms<const D: usize>(
    setting: &SolverContext<D>,
    clock: &Clock,
    bodies: &Bodies<D>,
    rates: &Rates<D>,
    dt: f64,
) -> impl Iterator<Item = (usize, EquilibriumTerms)> {
    let gravity = setting.gravity_at(clock, dt);
    let p = &bodies.particles;
    let free = bodies.groups.iter().filter(|group| group.prescribed_velocity.is_none());
    free.flat_map(ParticleGroup::range).filter(|&i| !bodies.is_ghost(i)).map(move |i| {
        let (m, v) = (p.mass[i], &p.velocity[i]);
        let push = rates.external_accelerations.get(i).copied().unwrap_or([0.0; D]);
        let audit = EquilibriumTerms {
            unbalanced: m * m * square(&rates.derivatives.acceleration[i]),
            external: m * m * (square(&gravity) + square(&push)),
            kinetic: 0.5 * m * square(v),
            work: m * dt * (0..D).map(|c| (gravity[c] + push[c]) * v[c]).sum::<f64>(),
        };
        (i, audit)
    })
}

/// Adds the accelerations times `step` to the velocities, and the damping of `dt`; step 5.
pub fn add_accelerations<const D: usize>(
    setting: &SolverContext<D>,
    clock: &Clock,
    bodies: &mut Bodies<D>,
    accelerations: &[[f64; D]],
    step: f64,
    dt: f64,
) {
    let local = setting.case.stages[clock.stage].damping;
    let (p, records) = (&mut bodies.particles, &mut bodies.pair_data.records);
    let len = p.len();
    let moving = p.velocity[..len].par_iter_mut().zip(records).zip(accelerations);
    moving.zip(&p.sound).zip(&p.length).with_min_len(MIN_PARTICLES_PER_TASK).for_each(
        |((((v, record), a), sound), h)| {
            let factor = setting.damping_factor(*sound, *h, dt);
            for c in 0..D {
                let resisted = if v[c] == 0.0 { 0.0 } else { local * a[c].abs() * v[c].signum() };
                v[c] = (v[c] + step * (a[c] - resisted)) * factor;
            }
            set_velocity(record, v);
        },
    );
    bodies.impose_held_velocities();
}

/// Largest distance of a particle outside a face or the domain (m).
fn margin<const D: usize>(setting: &SolverContext<D>) -> f64 {
    0.5 * setting.options.spacing
}

/// Permitted range of particle positions along each axis at a time (s), between walls and ends of the domain (m). A soft material may
/// penetrate a wall as far as the wall's first particles.
fn allowed_range<const D: usize>(setting: &SolverContext<D>, walls: &Walls<D>, time: f64) -> [(f64, f64); D] {
    let (domain, margin) = (&setting.case.domain, margin(setting));
    std::array::from_fn(|c| {
        if domain.is_periodic(c) {
            return (-f64::INFINITY, f64::INFINITY);
        }
        let (low, high) = walls.planes.bounding_faces(c, time);
        (domain.min[c].max(low) - margin, domain.max[c].min(high) + margin)
    })
}

/// Reason why the position `x` of a particle at `time` (s) is outside of the allowed range.
fn out_of_range_reason<const D: usize>(
    setting: &SolverContext<D>,
    walls: &Walls<D>,
    x: &[f64; D],
    time: f64,
) -> String {
    let Some(wall) = walls.planes.first_passed(x, time, margin(setting)) else {
        return "it left the domain: enlarge the domain or add a wall on that side".to_owned();
    };
    let (name, axis) = (setting.case.boundaries[wall.boundary].name(), ["x", "y", "z"][wall.axis]);
    format!(
        "it passed the wall {name:?}, whose face is at {axis} = {} m. For walls of particles set \
         methods.sph.wall_guard; for mirror walls set methods.sph.hourglass_viscosity, or use walls of \
         particles (methods.sph.smooth_wall, rough_wall)",
        wall.face_at(time)
    )
}

/// Reason of the failure of a particle that is too fast.
const MOVED_TOO_FAR: &str = "it moved by more than 0.2 smoothing lengths in a step";

/// Moves the particles to the end of the step (step 9).
pub fn drift<const D: usize>(
    setting: &SolverContext<D>,
    clock: &Clock,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &mut VerletLists<D>,
    rates: &mut Rates<D>,
    dt: f64,
) -> Result<(), SolverError> {
    let longest = 0.2 * setting.smoothing.length();
    let end = clock.time + dt;
    let room = allowed_range(setting, walls, end);
    let Bodies { particles, ghost_particles: guests, .. } = bodies;
    let extra = &rates.xsph_velocity;
    let len = particles.len();
    let Particles { position, velocity, stress, .. } = particles;
    let all = position[..len].par_iter_mut().zip(&*velocity).zip(&*stress).enumerate();
    let first = all
        .with_min_len(MIN_PARTICLES_PER_TASK)
        .map(|(i, ((x, v), stress))| {
            let v = extra.get(i).map_or(*v, |extra| std::array::from_fn(|c| v[c] + extra[c]));
            let far = !(square(&v) * dt * dt <= longest * longest);
            (0..D).for_each(|c| x[c] += dt * v[c]);
            let outside = (0..D).any(|c| x[c] < room[c].0 || x[c] > room[c].1);
            if guests.get(i).is_some_and(|guest| *guest) {
                None
            } else if far {
                Some((i, Some(FailureReason::Unstable(MOVED_TOO_FAR.to_owned()))))
            } else if !stress.is_finite() {
                Some((i, Some(FailureReason::NotFinite("its stress is not finite".to_owned()))))
            } else if outside {
                Some((i, None))
            } else {
                None
            }
        })
        .reduce(|| None, Option::or);
    lists.weights_current = false;
    rates.is_current = false;
    first.map_or(Ok(()), |(i, reason)| {
        let astray =
            || FailureReason::LeftDomain(out_of_range_reason(setting, walls, &particles.position[i], end));
        Err(particles.particle_error(clock, i, reason.unwrap_or_else(astray)))
    })
}

#[cfg(test)]
mod tests {
    use colluvium_constitutive::SymTensor;
    use serde_json::json;

    use crate::setup::rates_only;
    use crate::setup::rates_only::PrescribedParticle;

    /// Checked between two neighbour lists too.
    #[test]
    fn images_in_a_moving_mirror_remain_symmetric_in_every_step() {
        let text = json!({
            "title": "mirror", "space": "plane-strain", "domain": { "min": [-1, -1], "max": [2, 2] }, "gravity": [0, 0],
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] } }],
            "boundaries": [{ "side": "x-min", "position": 0, "wall": { "kind": "smooth" }, "velocity": [0.5, 0] }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "sph": { "spacing": 0.1 } }
        });
        let case = colluvium_case::Case::from_json(&text.to_string()).unwrap();
        let still = |_: u32, _: &[f64; 2]| PrescribedParticle {
            displacement: [0.0; 2],
            velocity: [0.0; 2],
            compression: 1.0,
            stress: SymTensor::ZERO,
        };
        let mut solver = rates_only::solver::<2>(&case, still);
        for _ in 0..5 {
            solver.advance(1e-4).unwrap();
            solver.update_lists(true).unwrap();
            let (p, time) = (&solver.bodies.particles, solver.clock.time);
            assert!(!solver.walls.images.is_empty() && solver.lists.listed_positions.time < time);
            for (image, slot) in solver.walls.images.iter().zip(p.len()..) {
                let middle = 0.5 * (p.position[slot][0] + p.position[image.source as usize][0]);
                assert!((middle - 0.5 * time).abs() < 1e-15, "{middle} m after {time} s");
            }
        }
    }
}
