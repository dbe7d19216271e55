//! Pair data of the particles for the sums over neighbours (sheet: sph §3.3, step 3).

use colluvium_constitutive::SymTensor;
use rayon::prelude::*;

use crate::clock::Clock;
use crate::config::{ContinuityEquation, MomentumEquation, Symmetrisation, Tensile};
use crate::context::SolverContext;
use crate::neighbours::verlet_lists::VerletLists;
use crate::pairs::PairContext;
use crate::pairs::tensile_instability::artificial_stress;
use crate::points::packed_particles::clear_volume;
use crate::points::particles::{Bodies, MIN_PARTICLES_PER_TASK, PairData, Particles};
use crate::walls::Walls;

/// Updates the pair data of every particle, walls and images included; step 3.
pub fn update_pair_data<const D: usize>(
    setting: &SolverContext<D>,
    clock: &Clock,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &VerletLists<D>,
) {
    if setting.options.continuity == ContinuityEquation::Summation {
        // Images need their masses.
        walls.load_images(bodies);
        sum_densities(setting, bodies, walls, lists);
        let len = bodies.particles.len();
        bodies.particles.density[..len].copy_from_slice(&bodies.pair_data.summed_density);
    }
    walls.extrapolate_from_soil(setting, clock, bodies, &lists.neighbours);
    update_artificial_stress(setting.options.tensile, bodies);
    update_grad_h_factors(setting, bodies, walls, lists);
    walls.load_images(bodies);
    walls.move_images(bodies);
    fill_records(setting.options.momentum, bodies, walls);
    find_corrections(setting, bodies, walls, lists);
}

/// Updates the artificial stress of all particles.
fn update_artificial_stress<const D: usize>(tensile: Tensile, bodies: &mut Bodies<D>) {
    if tensile == Tensile::None {
        return;
    }
    let (p, shown) = (&bodies.particles, &mut bodies.pair_data.repulsion);
    shown.resize(p.position.len(), SymTensor::ZERO);
    let all = shown.par_iter_mut().zip(&p.stress).zip(&p.density);
    all.with_min_len(MIN_PARTICLES_PER_TASK).for_each(|((slot, stress), &density)| {
        if density > 0.0 {
            *slot = artificial_stress::<D>(tensile, stress, density);
        }
    });
}

/// Fills the packed records of all particles for SIMD sums.
fn fill_records<const D: usize>(momentum: MomentumEquation, bodies: &mut Bodies<D>, walls: &Walls<D>) {
    let (p, PairData { records, grad_h_factor: spread, .. }) = (&bodies.particles, &mut bodies.pair_data);
    // SIMD sums have no correction; the stress is zero there and enters by the corrected sums.
    let scale = |i: usize| match momentum {
        MomentumEquation::Corrected => 0.0,
        _ => PairContext::<D>::flux_scale(momentum, p.density[i], spread[i]),
    };
    records.par_iter_mut().enumerate().with_min_len(MIN_PARTICLES_PER_TASK).for_each(|(i, record)| {
        if p.density[i] > 0.0 {
            *record = p.record(i, scale(i));
        }
    });
    walls.smooth_bodies.particles().for_each(|i| clear_volume::<D>(&mut records[i]));
}

/// Computes the density `Σ m W` of every particle (BN 2).
pub fn sum_densities<const D: usize>(
    setting: &SolverContext<D>,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &VerletLists<D>,
) {
    let pairs = PairContext::new(setting, &bodies.particles, walls);
    let summed = &mut bodies.pair_data.summed_density;
    summed.resize(bodies.particles.len(), 0.0);
    summed.par_iter_mut().enumerate().with_min_len(MIN_PARTICLES_PER_TASK).for_each(|(i, density)| {
        *density = pairs.summed_density(i, lists.neighbours.neighbours(i));
    });
}

/// Computes the gradient corrections, for the corrected momentum equation.
fn find_corrections<const D: usize>(
    setting: &SolverContext<D>,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &VerletLists<D>,
) {
    if setting.options.momentum != MomentumEquation::Corrected {
        return;
    }
    let (len, images) = (bodies.particles.len(), &walls.images);
    let pairs = PairContext::new(setting, &bodies.particles, walls);
    let correction = &mut bodies.pair_data.correction;
    correction.resize(len + images.len(), [[0.0; D]; D]);
    correction[..len].par_iter_mut().enumerate().with_min_len(MIN_PARTICLES_PER_TASK).for_each(
        |(i, correction)| {
            *correction = pairs.correction(i, lists.neighbours.neighbours(i));
        },
    );
    for (image, slot) in images.iter().zip(len..) {
        let l = correction[image.source as usize];
        let flip = image.axis_sign;
        correction[slot] = std::array::from_fn(|a| std::array::from_fn(|b| flip[a] * l[a][b] * flip[b]));
    }
}

/// Computes the factors of the gradient of the smoothing length.
fn update_grad_h_factors<const D: usize>(
    setting: &SolverContext<D>,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &VerletLists<D>,
) {
    if !setting.options.is_variable() || setting.options.symmetrisation != Symmetrisation::GradH {
        return;
    }
    // Images need their smoothing lengths.
    walls.load_images(bodies);
    let len = bodies.particles.len();
    let pairs = PairContext::new(setting, &bodies.particles, walls);
    bodies.pair_data.grad_h_factor[..len]
        .par_iter_mut()
        .enumerate()
        .with_min_len(MIN_PARTICLES_PER_TASK)
        .for_each(|(i, spread)| {
            *spread = pairs.grad_h_factor(i, lists.neighbours.neighbours(i));
        });
}

/// Copies the velocities of all particles to their pair records.
pub fn update_pair_velocities<const D: usize>(bodies: &mut Bodies<D>) {
    let p: &Particles<D> = &bodies.particles;
    let all = bodies.pair_data.records[..p.len()].par_iter_mut().zip(&p.velocity);
    all.with_min_len(MIN_PARTICLES_PER_TASK)
        .for_each(|(record, v)| crate::points::packed_particles::set_velocity(record, v));
}
