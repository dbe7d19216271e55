//! Forces of loads and the body force on particles, follower loads and reactions of obstacles ([`loads`](crate::points::body_loads)).

use colluvium_case::loads::load_vectors::{cofactor, nanson};

use crate::clock::Clock;
use crate::context::SolverContext;
use crate::kernel::Smoothing;
use crate::momentum::body_force::apply_body_forces;
use crate::neighbours::verlet_lists::VerletLists;
use crate::pairs::PairSums;
use crate::points::body_loads::BodyLoads;
use crate::points::particles::{Bodies, ParticleGroup, Particles, SquareMatrix};
use crate::points::vector_algebra::{dot, separation};
use crate::rates::{Rates, ReactionSample, ReactionSum};
use crate::walls::{ObstacleEnergies, Walls};

/// Adds the acceleration by loads at the end of a step of `dt` (s), and that by the body force of the program.
pub fn apply_loads<const D: usize>(
    setting: &SolverContext<D>,
    clock: &Clock,
    bodies: &Bodies<D>,
    rates: &mut Rates<D>,
    dt: f64,
) {
    let BodyLoads { loads, start_times, .. } = &bodies.loads;
    let p = &bodies.particles;
    if loads.is_empty() && p.body_force.is_empty() {
        return;
    }
    if setting.options.confining.is_none() {
        rates.external_accelerations.clear();
        rates.external_accelerations.resize(p.len(), [0.0; D]);
    }
    for on in loads {
        let load = &setting.case.loads[on.number];
        let factor = load.factor(clock.time + dt - start_times[on.number]);
        let group = bodies.groups.iter().find(|group| group.body == on.body);
        let Some(group) = group.filter(|_| factor != 0.0) else { continue };
        for i in group.range() {
            let carried = &on.vectors[(p.id[i] - on.first) as usize];
            if *carried == [0.0; D] {
                continue;
            }
            let force = load.force(carried);
            for c in 0..D {
                let push = factor * force[c] / p.mass[i];
                rates.external_accelerations[i][c] += push;
                rates.derivatives.acceleration[i][c] += push;
            }
        }
    }
    apply_body_forces(p, rates);
}

/// Records the forces of particles on obstacles with measured reactions, and the power of moving obstacles. The sum is serial, so that it
/// does not depend on the number of threads.
pub fn record_reactions<const D: usize>(
    sums: &PairSums<'_, D>,
    setting: &SolverContext<D>,
    walls: &Walls<D>,
    rates: &mut Rates<D>,
) {
    let obstacles = &walls.obstacles;
    if obstacles.recorded_or_moving().next().is_none() {
        return;
    }
    let first = setting.case.bodies.len();
    let Rates {
        obstacle_accelerations: by_obstacles, reactions: felt, power, reaction_samples: samples, ..
    } = rates;
    samples.clear();
    if obstacles.recorded_obstacles().next().is_some() {
        felt.resize(first + setting.case.obstacles.len(), ReactionSum::default());
        felt[first..].iter_mut().for_each(ReactionSum::begin_step);
    }
    power.clear();
    power.resize(by_obstacles.len(), 0.0);
    let p = sums.particles;
    for (i, whole) in by_obstacles.iter().enumerate() {
        let Some(nearest) = obstacles.faces(i).first() else { continue };
        let alone = obstacles.faces(i).iter().all(|face| face.obstacle == nearest.obstacle);
        for (number, is_told) in obstacles.recorded_or_moving() {
            let own = match (alone, nearest.obstacle as usize == number) {
                (true, true) => *whole,
                (true, false) => continue,
                (false, _) => sums.acceleration_by_obstacle(i, number as u32),
            };
            power[i] += dot(&own, &obstacles.velocity_at(number, &p.position[i]));
            if is_told {
                let (bearer, force) = ((first + number) as u32, own.map(|a| -p.mass[i] * a));
                samples.push(ReactionSample {
                    particle: i as u32,
                    reaction_index: bearer,
                    position: p.position[i],
                    force,
                    impulse: None,
                });
            }
        }
    }
    samples.iter().for_each(|one| felt[one.reaction_index as usize].accumulate(one));
}

/// Stops particles at obstacles at the end of a step of `dt` (s), and computes the energies that obstacles remove. Returns whether any was
/// stopped.
pub fn stop_at_obstacles<const D: usize>(
    setting: &SolverContext<D>,
    bodies: &mut Bodies<D>,
    walls: &mut Walls<D>,
    rates: &mut Rates<D>,
    (end, dt): (f64, f64),
) -> bool {
    if walls.obstacles.is_empty() {
        return false;
    }
    update_obstacle_energies(&bodies.particles, walls, rates, dt);
    let Rates { obstacle_energies, reactions, reaction_samples, support_reactions, .. } = rates;
    let first = setting.case.bodies.len();
    let mut hits = |particle: usize, obstacle: u32, x: &[f64; D], impulse: [f64; D]| {
        let number = first + obstacle as usize;
        if let Some(reaction) = reactions.get_mut(number) {
            let (force, impulse) = (impulse.map(|p| p / dt), Some(impulse));
            let hit = ReactionSample {
                particle: particle as u32,
                reaction_index: number as u32,
                position: *x,
                force,
                impulse,
            };
            reaction.accumulate(&hit);
            reaction_samples.push(hit);
        }
    };
    for (particle, own) in &*support_reactions {
        let (x, impulse) = (own.position, own.impulse);
        if walls.obstacles.is_recorded(own.obstacle as u32) {
            hits(
                *particle,
                own.obstacle as u32,
                &std::array::from_fn(|c| x[c]),
                std::array::from_fn(|c| impulse[c]),
            );
        }
    }
    walls.obstacles.limit_penetration(bodies, obstacle_energies, (end, dt, setting.options.spacing), hits)
}

/// Updates the energies that obstacles remove in a step of `dt` (s): friction, and work of moving obstacles. Friction is the product of the
/// acceleration along the nearest face and the slip at the end of the step.
fn update_obstacle_energies<const D: usize>(
    p: &Particles<D>,
    walls: &Walls<D>,
    rates: &mut Rates<D>,
    dt: f64,
) {
    let Rates { obstacle_accelerations, obstacle_energies, power, support_reactions, .. } = rates;
    obstacle_energies.clear();
    obstacle_energies.resize(p.len(), ObstacleEnergies::default());
    for (i, (energies, a)) in obstacle_energies.iter_mut().zip(obstacle_accelerations).enumerate() {
        let faces = walls.obstacles.faces(i);
        let Some(face) = faces.iter().min_by(|one, other| one.distance.total_cmp(&other.distance)) else {
            continue;
        };
        let v: [f64; D] = std::array::from_fn(|c| p.velocity[i][c] - face.velocity[c]);
        let slip = dot(a, &v) - dot(a, &face.normal) * dot(&v, &face.normal);
        energies.friction = -dt * p.mass[i] * slip;
        energies.work = dt * p.mass[i] * power.get(i).copied().unwrap_or(0.0);
    }
    for (particle, own) in &*support_reactions {
        obstacle_energies[*particle].friction += own.friction;
        obstacle_energies[*particle].work += own.work;
    }
}

/// Updates the follower loads after a step of `dt` (s). Over a reference configuration (`total`) the velocity gradients are exact for
/// rotations; those of the present one lack the neighbours beyond the surface, and are recomputed.
pub fn update_follower_loads<const D: usize>(
    setting: &SolverContext<D>,
    bodies: &mut Bodies<D>,
    lists: &VerletLists<D>,
    rates: &Rates<D>,
    total: bool,
    dt: f64,
) {
    let Bodies { particles: p, groups, loads, ghost_particles: guests, .. } = bodies;
    for on in loads.loads.iter_mut().filter(|on| on.is_follower(&setting.case)) {
        let Some(group) = groups.iter().find(|group| group.body == on.body) else { continue };
        // Ghost particles of other ranks lack neighbours here; their load vectors are sent by the owner.
        for i in group.range().filter(|i| !guests.get(*i).is_some_and(|guest| *guest)) {
            let vector = &mut on.vectors[(p.id[i] - on.first) as usize];
            if *vector == [0.0; D] {
                continue;
            }
            let gradient = if total {
                Some(rates.derivatives.gradient[i])
            } else {
                linear_velocity_gradient(&setting.smoothing, p, group, i, lists.neighbours.neighbours(i))
            };
            if let Some(gradient) = gradient {
                *vector = nanson(&gradient.map(|row| row.map(|l| dt * l)), vector);
            }
        }
    }
}

/// Velocity gradient at particle `i` (1/s) from its neighbours in the same body, exact for linear velocities. `None` if the neighbours do
/// not span the space.
fn linear_velocity_gradient<const D: usize>(
    smoothing: &Smoothing<D>,
    p: &Particles<D>,
    group: &ParticleGroup,
    i: usize,
    row: &[u32],
) -> Option<SquareMatrix<D>> {
    let (mut moments, mut sums) = ([[0.0; D]; D], [[0.0; D]; D]);
    for j in row.iter().map(|&j| j as usize).filter(|j| group.range().contains(j)) {
        let (away, square) = separation(&p.position[i], &p.position[j]);
        // Any weights are valid; present densities would not be available in other ranks.
        let weight = -smoothing.gradient_factor(square.sqrt()) * p.mass[j] / group.density;
        for a in 0..D {
            for b in 0..D {
                moments[a][b] += weight * away[a] * away[b];
                sums[a][b] += weight * (p.velocity[j][a] - p.velocity[i][a]) * away[b];
            }
        }
    }
    let cofactors = cofactor(&moments);
    let determinant: f64 = (0..D).map(|c| moments[0][c] * cofactors[0][c]).sum();
    // With a full support the moment is the unit matrix in all directions.
    if !(determinant > 1e-4) {
        return None;
    }
    Some(std::array::from_fn(|a| {
        std::array::from_fn(|b| (0..D).map(|c| sums[a][c] * cofactors[c][b]).sum::<f64>() / determinant)
    }))
}
