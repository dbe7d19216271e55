//! Critical time step (sheet: sph §3.4).

use colluvium_case::{StepLimit, TimeStep, limit_step_by_obstacles, spatial};
use colluvium_constitutive::{BLOCK_SIZE, StateBlock};
use rayon::prelude::*;

use crate::clock::STEPS_PER_TIME_STEP;
use crate::config::SoundSpeed;
use crate::context::SolverContext;
use crate::pairs::ShortRangeRepulsion;
use crate::points::particles::{Bodies, Particles};
use crate::points::vector_algebra::square;
use crate::rates::Rates;
use crate::walls::ObstacleFaces;

/// Stability limit of the undamped leapfrog, in times `h / c` (sheet: sph §3.4, §7).
const STABLE: f64 = 1.8;

/// Largest move of an obstacle in a step (spacings).
const MAX_OBSTACLE_MOVE: f64 = 0.1;

/// Limit by the oscillation of close particles under repulsion.
const REPULSION: StepLimit = StepLimit::new("repulsion of close particles");

/// Time step (s), its limit, and the particle.
pub type LimitingParticle = (f64, StepLimit, Option<usize>);

/// Critical time step of waves, forces, viscosity and damping, with the limiting particle (sheet: sph §3.4). The speeds of sound are
/// updated. For a fixed step of the case the Courant number is the largest stable one.
pub fn critical_step<const D: usize>(
    setting: &SolverContext<D>,
    bodies: &mut Bodies<D>,
    rates: &Rates<D>,
) -> LimitingParticle {
    let (options, guests) = (&setting.options, &bodies.ghost_particles);
    let courant = if options.time_step.is_some() { STABLE } else { options.courant };
    let close = ShortRangeRepulsion::of_groups(setting, &bodies.groups);
    let p = &mut bodies.particles;
    let mut smallest: LimitingParticle = (f64::INFINITY, StepLimit::NO_MOTION, None);
    for group in bodies.groups.iter().filter(|group| !group.is_smooth) {
        let range = group.range();
        let sounds = p.sound[range.clone()].par_chunks_mut(BLOCK_SIZE);
        let blocks = group.states.blocks().par_iter().zip(sounds).enumerate();
        let (stresses, densities) = (&p.stress[range.clone()], &p.density[range.clone()]);
        let (lengths, velocities) = (&p.length[range.clone()], &p.velocity[range.clone()]);
        let accelerations = &rates.derivatives.acceleration;
        let of_block = |(number, (states, sounds)): (usize, (&StateBlock, &mut [f64]))| {
            let first = number * BLOCK_SIZE;
            let stress = &stresses[first..first + states.len()];
            let (mut moduli, mut viscosities) = ([0.0; BLOCK_SIZE], [0.0; BLOCK_SIZE]);
            group.material.wave_moduli(stress, states, &mut moduli[..stress.len()]);
            group.material.viscosities(stress, states, &mut viscosities[..stress.len()]);
            let mut smallest: LimitingParticle = (f64::INFINITY, StepLimit::NO_MOTION, None);
            for k in 0..states.len() {
                let (density, h) = (densities[first + k], lengths[first + k]);
                let wave = (moduli[k] / density).sqrt();
                sounds[k] = match (options.sound_speed, group.youngs_modulus) {
                    (SoundSpeed::YoungsModulus, Some(modulus)) => (modulus / density).sqrt(),
                    _ => wave,
                };
                if guests.get(range.start + first + k).is_some_and(|guest| *guest) {
                    continue;
                }
                let speed = square(&velocities[first + k]).sqrt();
                let acceleration = accelerations.get(range.start + first + k).map_or(0.0, square).sqrt();
                let apart = close.filter(|_| group.is_free_fluid());
                let limits = [
                    (courant * h / (wave + speed), StepLimit::ELASTIC_WAVE),
                    (0.25 * (h / acceleration).sqrt(), StepLimit::ACCELERATION),
                    (0.125 * h * h * density / viscosities[k], StepLimit::VISCOSITY),
                    (0.2 * h / (options.damping * sounds[k]), StepLimit::DAMPING),
                    (apart.map_or(f64::INFINITY, |close| close.stable_step(wave)), REPULSION),
                ];
                for (dt, name) in limits {
                    if dt < smallest.0 {
                        smallest = (dt, name, Some(range.start + first + k));
                    }
                }
            }
            smallest
        };
        // Of equal steps, that of the first particle.
        smallest = blocks.map(of_block).reduce(|| smallest, |a, b| if b.0 < a.0 { b } else { a });
    }
    smallest
}

/// Critical step at a `time` (s), limited so that obstacles move by at most a fraction of the `spacing` (m).
pub fn limit_by_obstacle_motion<const D: usize>(
    critical: TimeStep,
    obstacles: &ObstacleFaces<D>,
    (time, spacing): (f64, f64),
) -> TimeStep {
    limit_step_by_obstacles(
        critical,
        obstacles.moving_obstacles(),
        (time, MAX_OBSTACLE_MOVE * spacing, STEPS_PER_TIME_STEP + 1),
    )
}

/// Limit as a [`TimeStep`] for reports.
pub fn to_time_step<const D: usize>(
    (dt, limit, index): LimitingParticle,
    particles: &Particles<D>,
) -> TimeStep {
    TimeStep {
        dt,
        limit,
        point: index.map(|i| u64::from(particles.id[i])),
        position: index.map_or([0.0; 3], |i| spatial(&particles.position[i])),
    }
}
