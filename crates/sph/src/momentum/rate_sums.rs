//! Sums over neighbours for the rates of the particles (sheet: sph §3.3, steps 4 and 6).

use colluvium_constitutive::SymTensor;
use colluvium_points::BLOCK_POINTS;
use rayon::prelude::*;

use crate::clock::Clock;
use crate::config::SmoothingLength;
use crate::context::SolverContext;
use crate::momentum::confining_pressure::apply_confining_pressure;
use crate::momentum::external_forces::{apply_loads, record_reactions};
use crate::neighbours::verlet_lists::VerletLists;
use crate::pairs::velocity_gradient::GradientSums;
use crate::pairs::{PairContext, PairSums, for_each_particle};
use crate::points::particles::{Bodies, Derivatives};
use crate::rates::Rates;
use crate::walls::Walls;

/// Number of particles whose sums over neighbours precede their velocity gradients. Roots and divisions of several particles overlap, which
/// those of one cannot, since each waits for the one before.
const SUMS_PER_PASS: usize = 16;

/// Computes the accelerations of all particles with gravity and local damping, and stores the weights of the pairs.
pub fn accelerate<const D: usize>(
    setting: &SolverContext<D>,
    clock: &Clock,
    bodies: &Bodies<D>,
    walls: &Walls<D>,
    lists: &mut VerletLists<D>,
    rates: &mut Rates<D>,
    dt: f64,
) {
    let gravity = setting.gravity_at(clock, dt);
    let sums = PairSums::new(setting, bodies, walls);
    rates.derivatives.acceleration.resize(bodies.particles.len(), [0.0; D]);
    let whole = |acceleration: [f64; D]| std::array::from_fn(|c| acceleration[c] + gravity[c]);
    if bodies.any_rigid() {
        // Internal pair forces of a rigid body do not move it, but stresses may give it a moment.
        // Supports carry a freely moving body as a whole.
        sum_accelerations(walls, lists, rates, |i, row, weights, by_obstacles| {
            let body = bodies.rigid_range(i);
            if let Some(body) = body.as_ref().filter(|_| bodies.moves_freely(setting, clock, i)) {
                if let Some(own) = by_obstacles {
                    *own = [0.0; D];
                }
                sums.fill_weights(i, row, weights);
                return whole(sums.acceleration_by_others(i, row, weights, body));
            }
            let all = sums.acceleration(i, row, weights, by_obstacles);
            let Some(body) = body else { return whole(all) };
            let own = sums.acceleration_within(i, row, weights, &body);
            whole(std::array::from_fn(|c| all[c] - own[c]))
        });
    } else {
        sum_accelerations(walls, lists, rates, |i, row, weights, by_obstacles| {
            whole(sums.acceleration(i, row, weights, by_obstacles))
        });
    }
    record_reactions(&sums, setting, walls, rates);
    (lists.weights_current, rates.is_current) = (true, true);
    apply_confining_pressure(setting, clock, bodies, walls, lists, rates, dt);
    apply_loads(setting, clock, bodies, rates, dt);
    add_hourglass_viscosity(setting, clock, bodies, walls, lists, rates);
    // No forces act on smooth bodies.
    walls.smooth_bodies.ranges().for_each(|body| rates.derivatives.acceleration[body].fill([0.0; D]));
    bodies.rigidify_accelerations(setting, clock, rates, &gravity, dt);
}

/// Sets the acceleration of each particle to the sum `of` over its neighbours with their weights, plus that of obstacles.
#[inline(always)]
fn sum_accelerations<const D: usize>(
    walls: &Walls<D>,
    lists: &mut VerletLists<D>,
    rates: &mut Rates<D>,
    of: impl Fn(usize, &[u32], &mut [f64], Option<&mut [f64; D]>) -> [f64; D] + Sync,
) {
    let (neighbours, weights) = (&lists.neighbours, &mut lists.weights);
    let accelerations = &mut rates.derivatives.acceleration;
    if walls.obstacles.is_empty() {
        return for_each_particle(neighbours, weights, accelerations, |i, row, weights, a| {
            *a = of(i, row, weights, None);
        });
    }
    rates.obstacle_accelerations.resize(accelerations.len(), [0.0; D]);
    let both = accelerations
        .par_chunks_mut(BLOCK_POINTS)
        .zip(rates.obstacle_accelerations.par_chunks_mut(BLOCK_POINTS));
    let blocks = both.zip(weights).zip(neighbours.blocks()).enumerate();
    blocks.for_each(|(number, (((all, by_obstacles), weights), rows))| {
        for (k, (a, own)) in all.iter_mut().zip(by_obstacles).enumerate() {
            *a = of(number * BLOCK_POINTS + k, rows.neighbours(k), &mut weights[rows.range(k)], Some(own));
        }
    });
}

/// Adds the viscosity against velocity modes that the velocity gradients of the last step do not include.
fn add_hourglass_viscosity<const D: usize>(
    setting: &SolverContext<D>,
    clock: &Clock,
    bodies: &Bodies<D>,
    walls: &Walls<D>,
    lists: &mut VerletLists<D>,
    rates: &mut Rates<D>,
) {
    let strength = setting.options.hourglass_viscosity;
    if strength == 0.0 || clock.last_step == 0.0 {
        return;
    }
    let pairs = PairContext::new(setting, &bodies.particles, walls);
    let Derivatives { acceleration, gradient, .. } = &mut rates.derivatives;
    for_each_particle(&lists.neighbours, &mut lists.weights, acceleration, |i, row, weights, a| {
        let pull = pairs.hourglass_acceleration(i, (row, weights), gradient);
        (0..D).for_each(|c| a[c] += strength * pull[c]);
    });
}

/// Computes velocity gradients and divergences; step 6. Velocities are chords of a step of `chord` (s), or, for 0, those at the positions.
pub fn find_rates<const D: usize>(
    setting: &SolverContext<D>,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &mut VerletLists<D>,
    rates: &mut Rates<D>,
    (dt, chord): (f64, f64),
) {
    walls.move_images(bodies);
    walls.extrapolate_velocities(setting, bodies, &lists.neighbours);
    find_gradients(setting, bodies, walls, lists, rates, chord);
    update_xsph_velocity(setting, bodies, walls, lists, rates);
    update_smoothing_lengths(setting, bodies, walls, lists, rates, dt);
    zero_ghost_rates(bodies, walls, &mut rates.derivatives);
}

/// Computes velocity gradients and divergences of all particles.
fn find_gradients<const D: usize>(
    setting: &SolverContext<D>,
    bodies: &Bodies<D>,
    walls: &Walls<D>,
    lists: &mut VerletLists<D>,
    rates: &mut Rates<D>,
    chord: f64,
) {
    let (pairs, weighed) = (PairSums::new(setting, bodies, walls), lists.weights_current);
    let any_rigid = bodies.any_rigid();
    let turn_of = |i: usize| if any_rigid { bodies.rotation_of(i) } else { None };
    let diffusion = 2.0 * setting.options.density_diffusion;
    let fluid = |i: usize| bodies.group_of(i).filter(|group| group.fluid);
    // Gradient and divergence of a particle are in two arrays.
    let Derivatives { gradient, divergence, .. } = &mut rates.derivatives;
    let both = gradient.par_chunks_mut(BLOCK_POINTS).zip(divergence.par_chunks_mut(BLOCK_POINTS));
    let blocks = both.zip(&mut lists.weights).zip(lists.neighbours.blocks()).enumerate();
    blocks.for_each(|(number, (((gradient, divergence), weights), rows))| {
        let (first, mut sums) = (number * BLOCK_POINTS, [GradientSums::ZERO; SUMS_PER_PASS]);
        for start in (0..gradient.len()).step_by(SUMS_PER_PASS) {
            let some = start..gradient.len().min(start + SUMS_PER_PASS);
            for (k, sums_of_one) in some.clone().zip(&mut sums) {
                let (i, row, weights) = (first + k, rows.neighbours(k), &mut weights[rows.range(k)]);
                if !weighed {
                    pairs.fill_weights(i, row, weights);
                }
                *sums_of_one = match turn_of(i) {
                    Some((turn, ground)) => {
                        pairs.velocity_gradient_sums_rotating(i, row, weights, &turn, ground)
                    }
                    None => pairs.velocity_gradient_sums(i, (row, weights)),
                };
            }
            for (k, sums_of_one) in some.zip(&sums) {
                let i = first + k;
                let turn = turn_of(i);
                let mut rate =
                    pairs.velocity_gradient(i, sums_of_one, if turn.is_some() { 0.0 } else { chord });
                if let Some((turn, _)) = turn {
                    rate.add_rotation(&turn);
                }
                (gradient[k], divergence[k]) = (rate.gradient, rate.divergence);
                if diffusion > 0.0
                    && let Some(body) = fluid(i)
                {
                    let row = (rows.neighbours(k), &weights[rows.range(k)]);
                    divergence[k] += diffusion * pairs.density_diffusion(i, row, &body.range());
                }
            }
        }
    });
    lists.weights_current = true;
}

/// Computes the XSPH velocities; zero for rigid bodies and bodies of prescribed motion.
fn update_xsph_velocity<const D: usize>(
    setting: &SolverContext<D>,
    bodies: &Bodies<D>,
    walls: &Walls<D>,
    lists: &mut VerletLists<D>,
    rates: &mut Rates<D>,
) {
    let share = setting.options.xsph;
    if share == 0.0 {
        return;
    }
    let pairs = PairContext::new(setting, &bodies.particles, walls);
    rates.xsph_velocity.resize(bodies.particles.len(), [0.0; D]);
    for_each_particle(&lists.neighbours, &mut lists.weights, &mut rates.xsph_velocity, |i, row, _, drift| {
        *drift = pairs.xsph_velocity(i, row).map(|v| v * share);
    });
    for group in
        bodies.groups.iter().filter(|group| group.prescribed_velocity.is_some() || group.rigid.is_some())
    {
        rates.xsph_velocity[group.range()].fill([0.0; D]);
    }
}

/// Computes the rates of the smoothing lengths.
fn update_smoothing_lengths<const D: usize>(
    setting: &SolverContext<D>,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &mut VerletLists<D>,
    rates: &mut Rates<D>,
    dt: f64,
) {
    if setting.options.smoothing_length != SmoothingLength::Rate {
        return;
    }
    rates.length.resize(bodies.particles.len(), 0.0);
    let pairs = PairContext::new(setting, &bodies.particles, walls);
    for_each_particle(&lists.neighbours, &mut lists.weights, &mut rates.length, |i, row, weights, rate| {
        *rate = pairs.length_rate(i, row, weights);
    });
    let h = setting.smoothing.length();
    let (smallest, largest) = (h / setting.options.smoothing_growth, h * setting.options.smoothing_growth);
    for (length, rate) in bodies.particles.length.iter_mut().zip(&rates.length) {
        *length = (*length + dt * rate).clamp(smallest, largest);
    }
}

/// Sets the rates of ghost particles and smooth bodies to zero. Ghosts lack neighbours on this rank and are replaced before the next step;
/// no forces act on smooth bodies.
fn zero_ghost_rates<const D: usize>(bodies: &Bodies<D>, walls: &Walls<D>, rates: &mut Derivatives<D>) {
    let guests = bodies.ghost_particles.iter().enumerate().filter_map(|(i, guest)| guest.then_some(i));
    for i in guests.chain(walls.smooth_bodies.ranges().flatten()) {
        rates.gradient[i] = [[0.0; D]; D];
        rates.divergence[i] = 0.0;
    }
}

/// Applies stress diffusion over the step (sheet: sph §2.10); the material law then returns the stress to yield.
pub fn diffuse_stress<const D: usize>(
    setting: &SolverContext<D>,
    clock: &Clock,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &mut VerletLists<D>,
    rates: &mut Rates<D>,
    dt: f64,
) {
    let strength = 2.0 * setting.options.stress_diffusion;
    if strength == 0.0 {
        return;
    }
    let gravity = setting.gravity_at(clock, 0.0);
    rates.stress.resize(bodies.particles.len(), SymTensor::ZERO);
    let pairs = PairContext::new(setting, &bodies.particles, walls);
    for_each_particle(&lists.neighbours, &mut lists.weights, &mut rates.stress, |i, row, weights, rate| {
        if let Some(body) = bodies.group_of(i) {
            *rate = pairs.stress_diffusion(i, (row, weights), &gravity, &body.range());
        }
    });
    let stress = bodies.particles.stress.iter_mut().zip(&rates.stress);
    stress.for_each(|(stress, rate)| *stress += *rate * (strength * dt));
}
