//! The sums over neighbours that give the rates of the particles (sheet: sph §3.3, steps 4 and 6).

use colluvium_constitutive::SymTensor;
use colluvium_points::ROWS;
use rayon::prelude::*;

use crate::bearing::{bear, tell_obstacles};
use crate::clock::Clock;
use crate::config::SmoothingLength;
use crate::confinement::confine;
use crate::lists::Lists;
use crate::pairs::{Pairs, Sums, over_rows};
use crate::particles::{Bodies, Derivatives};
use crate::rates::Rates;
use crate::setting::Setting;
use crate::walls::Walls;

/// Accelerations, gravity and local damping of the stage included; keeps the weights of the pairs.
pub fn accelerate<const D: usize>(
    setting: &Setting<D>,
    clock: &Clock,
    bodies: &Bodies<D>,
    walls: &Walls<D>,
    lists: &mut Lists<D>,
    rates: &mut Rates<D>,
    dt: f64,
) {
    let gravity = setting.gravity_at(clock, dt);
    let sums = Sums::new(setting, bodies, walls);
    rates.of.acceleration.resize(bodies.particles.len(), [0.0; D]);
    let whole = |pull: [f64; D]| std::array::from_fn(|c| pull[c] + gravity[c]);
    if bodies.any_rigid() {
        // What particles of a rigid body do to each other moves nothing, but stresses may give it a moment.
        // The ground bears those that move freely as a whole.
        sum_up(walls, lists, rates, |i, row, weights, by_obstacles| {
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
        sum_up(walls, lists, rates, |i, row, weights, by_obstacles| {
            whole(sums.acceleration(i, row, weights, by_obstacles))
        });
    }
    tell_obstacles(&sums, setting, walls, rates);
    (lists.weighed, rates.current) = (true, true);
    confine(setting, clock, bodies, walls, lists, rates, dt);
    bear(setting, clock, bodies, rates, dt);
    resist_hourglass(setting, clock, bodies, walls, lists, rates);
    // Smooth bodies feel nothing.
    walls.smooth.ranges().for_each(|body| rates.of.acceleration[body].fill([0.0; D]));
    bodies.stiffen(setting, clock, rates, &gravity, dt);
}

/// Acceleration of each particle `of` its neighbours and their weights, with the share of obstacles where there are any.
#[inline(always)]
fn sum_up<const D: usize>(
    walls: &Walls<D>,
    lists: &mut Lists<D>,
    rates: &mut Rates<D>,
    of: impl Fn(usize, &[u32], &mut [f64], Option<&mut [f64; D]>) -> [f64; D] + Sync,
) {
    let (neighbours, weights) = (&lists.neighbours, &mut lists.weights);
    let accelerations = &mut rates.of.acceleration;
    if walls.obstacles.is_empty() {
        return over_rows(neighbours, weights, accelerations, |i, row, weights, a| {
            *a = of(i, row, weights, None);
        });
    }
    rates.by_obstacles.resize(accelerations.len(), [0.0; D]);
    let both = accelerations.par_chunks_mut(ROWS).zip(rates.by_obstacles.par_chunks_mut(ROWS));
    let blocks = both.zip(weights).zip(neighbours.blocks()).enumerate();
    blocks.for_each(|(number, (((all, by_obstacles), weights), rows))| {
        for (k, (a, own)) in all.iter_mut().zip(by_obstacles).enumerate() {
            *a = of(number * ROWS + k, rows.of(k), &mut weights[rows.range(k)], Some(own));
        }
    });
}

/// Viscosity against what the velocity gradients of the step before do not see.
fn resist_hourglass<const D: usize>(
    setting: &Setting<D>,
    clock: &Clock,
    bodies: &Bodies<D>,
    walls: &Walls<D>,
    lists: &mut Lists<D>,
    rates: &mut Rates<D>,
) {
    let strength = setting.options.hourglass_viscosity;
    if strength == 0.0 || clock.last_step == 0.0 {
        return;
    }
    let pairs = Pairs::new(setting, &bodies.particles, walls);
    let Derivatives { acceleration, gradient, .. } = &mut rates.of;
    over_rows(&lists.neighbours, &mut lists.weights, acceleration, |i, row, weights, a| {
        let pull = pairs.hourglass(i, (row, weights), gradient);
        (0..D).for_each(|c| a[c] += strength * pull[c]);
    });
}

/// Velocity gradients and divergences; step 6. Velocities are the chords of a step of `chord` (s), or zero for those at the positions.
pub fn find_rates<const D: usize>(
    setting: &Setting<D>,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &mut Lists<D>,
    rates: &mut Rates<D>,
    (dt, chord): (f64, f64),
) {
    walls.move_images(bodies);
    walls.follow_soil(setting, bodies, &lists.neighbours);
    find_gradients(setting, bodies, walls, lists, rates, chord);
    find_drift(setting, bodies, walls, lists, rates);
    follow_rate(setting, bodies, walls, lists, rates, dt);
    keep_still(bodies, walls, &mut rates.of);
}

fn find_gradients<const D: usize>(
    setting: &Setting<D>,
    bodies: &Bodies<D>,
    walls: &Walls<D>,
    lists: &mut Lists<D>,
    rates: &mut Rates<D>,
    chord: f64,
) {
    let (sums, weighed) = (Sums::new(setting, bodies, walls), lists.weighed);
    let any_rigid = bodies.any_rigid();
    let diffusion = 2.0 * setting.options.density_diffusion;
    let fluid = |i: usize| bodies.of(i).filter(|group| group.fluid);
    // The gradient and the divergence of a particle stand in two arrays.
    let Derivatives { gradient, divergence, .. } = &mut rates.of;
    let both = gradient.par_chunks_mut(ROWS).zip(divergence.par_chunks_mut(ROWS));
    let blocks = both.zip(&mut lists.weights).zip(lists.neighbours.blocks()).enumerate();
    blocks.for_each(|(number, (((gradient, divergence), weights), rows))| {
        for k in 0..gradient.len() {
            let i = number * ROWS + k;
            let (row, weights) = (rows.of(k), &mut weights[rows.range(k)]);
            if !weighed {
                sums.fill_weights(i, row, weights);
            }
            let turn = if any_rigid { bodies.turn_of(i) } else { None };
            let rate = match &turn {
                Some((turn, ground)) => sums.rates_in_turn(i, row, weights, turn, *ground),
                None => sums.rates(i, (row, weights), chord),
            };
            gradient[k] = rate.gradient;
            divergence[k] = rate.divergence;
            if diffusion > 0.0
                && let Some(body) = fluid(i)
            {
                divergence[k] += diffusion * sums.density_diffusion(i, (row, weights), &body.range());
            }
        }
    });
    lists.weighed = true;
}

/// Velocities of XSPH. Bodies that are held or rigid move with none.
fn find_drift<const D: usize>(
    setting: &Setting<D>,
    bodies: &Bodies<D>,
    walls: &Walls<D>,
    lists: &mut Lists<D>,
    rates: &mut Rates<D>,
) {
    let share = setting.options.xsph;
    if share == 0.0 {
        return;
    }
    let pairs = Pairs::new(setting, &bodies.particles, walls);
    rates.drift.resize(bodies.particles.len(), [0.0; D]);
    over_rows(&lists.neighbours, &mut lists.weights, &mut rates.drift, |i, row, _, drift| {
        *drift = pairs.drift(i, row).map(|v| v * share);
    });
    for group in bodies.groups.iter().filter(|group| group.held.is_some() || group.rigid.is_some()) {
        rates.drift[group.range()].fill([0.0; D]);
    }
}

/// Smoothing lengths by their rate.
fn follow_rate<const D: usize>(
    setting: &Setting<D>,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &mut Lists<D>,
    rates: &mut Rates<D>,
    dt: f64,
) {
    if setting.options.smoothing_length != SmoothingLength::Rate {
        return;
    }
    rates.length.resize(bodies.particles.len(), 0.0);
    let pairs = Pairs::new(setting, &bodies.particles, walls);
    over_rows(&lists.neighbours, &mut lists.weights, &mut rates.length, |i, row, weights, rate| {
        *rate = pairs.length_rate(i, row, weights);
    });
    let h = setting.smoothing.length();
    let (least, most) = (h / setting.options.smoothing_growth, h * setting.options.smoothing_growth);
    for (length, rate) in bodies.particles.length.iter_mut().zip(&rates.length) {
        *length = (*length + dt * rate).clamp(least, most);
    }
}

/// Copies of particles of other ranks do not strain here: they lack neighbours, and come anew before the next step.
/// Smooth bodies feel nothing.
fn keep_still<const D: usize>(bodies: &Bodies<D>, walls: &Walls<D>, rates: &mut Derivatives<D>) {
    let guests = bodies.guests.iter().enumerate().filter_map(|(i, guest)| guest.then_some(i));
    for i in guests.chain(walls.smooth.ranges().flatten()) {
        rates.gradient[i] = [[0.0; D]; D];
        rates.divergence[i] = 0.0;
    }
}

/// Diffusion of stress over the step (sheet: sph §2.10); the law takes it back to yield.
pub fn diffuse_stress<const D: usize>(
    setting: &Setting<D>,
    clock: &Clock,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &mut Lists<D>,
    rates: &mut Rates<D>,
    dt: f64,
) {
    let strength = 2.0 * setting.options.stress_diffusion;
    if strength == 0.0 {
        return;
    }
    let gravity = setting.gravity_at(clock, 0.0);
    rates.stress.resize(bodies.particles.len(), SymTensor::ZERO);
    let pairs = Pairs::new(setting, &bodies.particles, walls);
    over_rows(&lists.neighbours, &mut lists.weights, &mut rates.stress, |i, row, weights, rate| {
        if let Some(body) = bodies.of(i) {
            *rate = pairs.stress_diffusion(i, (row, weights), &gravity, &body.range());
        }
    });
    let stress = bodies.particles.stress.iter_mut().zip(&rates.stress);
    stress.for_each(|(stress, rate)| *stress += *rate * (strength * dt));
}
