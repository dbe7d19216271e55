//! What every particle shows its neighbours (sheet: sph §3.3, step 3).

use colluvium_constitutive::SymTensor;
use rayon::prelude::*;

use crate::clock::Clock;
use crate::config::{Continuity, Momentum, Symmetrisation, Tensile};
use crate::lanes::hide;
use crate::lists::Lists;
use crate::pairs::Pairs;
use crate::particles::{Bodies, Particles, Shown, TASK};
use crate::setting::Setting;
use crate::tensile::repulsion;
use crate::walls::Walls;

/// What every particle shows its neighbours, walls and images included; step 3.
pub fn show<const D: usize>(
    setting: &Setting<D>,
    clock: &Clock,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &Lists<D>,
) {
    if setting.options.continuity == Continuity::Summation {
        // Images need their masses.
        walls.load_images(bodies);
        sum_densities(setting, bodies, walls, lists);
        let len = bodies.particles.len();
        bodies.particles.density[..len].copy_from_slice(&bodies.shown.summed);
    }
    walls.ask_soil(setting, clock, bodies, &lists.neighbours);
    find_repulsion(setting.options.tensile, bodies);
    find_spread(setting, bodies, walls, lists);
    walls.load_images(bodies);
    walls.move_images(bodies);
    fill_records(setting.options.momentum, bodies, walls);
    find_corrections(setting, bodies, walls, lists);
}

fn find_repulsion<const D: usize>(tensile: Tensile, bodies: &mut Bodies<D>) {
    if tensile == Tensile::None {
        return;
    }
    let (p, shown) = (&bodies.particles, &mut bodies.shown.repulsion);
    shown.resize(p.position.len(), SymTensor::ZERO);
    let all = shown.par_iter_mut().zip(&p.stress).zip(&p.density);
    all.with_min_len(TASK).for_each(|((slot, stress), &density)| {
        if density > 0.0 {
            *slot = repulsion::<D>(tensile, stress, density);
        }
    });
}

fn fill_records<const D: usize>(momentum: Momentum, bodies: &mut Bodies<D>, walls: &Walls<D>) {
    let (p, Shown { records, spread, .. }) = (&bodies.particles, &mut bodies.shown);
    // The lanes do not correct: they leave the stress to those who do.
    let scale = |i: usize| match momentum {
        Momentum::Corrected => 0.0,
        _ => Pairs::<D>::flux_scale(momentum, p.density[i], spread[i]),
    };
    records.par_iter_mut().enumerate().with_min_len(TASK).for_each(|(i, record)| {
        if p.density[i] > 0.0 {
            *record = p.record(i, scale(i));
        }
    });
    walls.smooth.particles().for_each(|i| hide::<D>(&mut records[i]));
}

/// `Σ m W` of every particle (BN 2).
pub fn sum_densities<const D: usize>(
    setting: &Setting<D>,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &Lists<D>,
) {
    let pairs = Pairs::new(setting, &bodies.particles, walls);
    let summed = &mut bodies.shown.summed;
    summed.resize(bodies.particles.len(), 0.0);
    summed.par_iter_mut().enumerate().with_min_len(TASK).for_each(|(i, density)| {
        *density = pairs.summed_density(i, lists.neighbours.of(i));
    });
}

/// Corrections of the gradient, for the momentum equation that has them.
fn find_corrections<const D: usize>(
    setting: &Setting<D>,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &Lists<D>,
) {
    if setting.options.momentum != Momentum::Corrected {
        return;
    }
    let (len, images) = (bodies.particles.len(), &walls.images);
    let pairs = Pairs::new(setting, &bodies.particles, walls);
    let correction = &mut bodies.shown.correction;
    correction.resize(len + images.len(), [[0.0; D]; D]);
    correction[..len].par_iter_mut().enumerate().with_min_len(TASK).for_each(|(i, correction)| {
        *correction = pairs.correction(i, lists.neighbours.of(i));
    });
    for (image, slot) in images.iter().zip(len..) {
        let l = correction[image.source as usize];
        let flip = image.flip;
        correction[slot] = std::array::from_fn(|a| std::array::from_fn(|b| flip[a] * l[a][b] * flip[b]));
    }
}

/// Factors of the gradient of the smoothing length.
fn find_spread<const D: usize>(
    setting: &Setting<D>,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &Lists<D>,
) {
    if !setting.options.is_variable() || setting.options.symmetrisation != Symmetrisation::GradH {
        return;
    }
    // Images need their smoothing lengths.
    walls.load_images(bodies);
    let len = bodies.particles.len();
    let pairs = Pairs::new(setting, &bodies.particles, walls);
    bodies.shown.spread[..len].par_iter_mut().enumerate().with_min_len(TASK).for_each(|(i, spread)| {
        *spread = pairs.spread(i, lists.neighbours.of(i));
    });
}

/// Puts the velocities of all particles into their records.
pub fn show_velocities<const D: usize>(bodies: &mut Bodies<D>) {
    let p: &Particles<D> = &bodies.particles;
    let all = bodies.shown.records[..p.len()].par_iter_mut().zip(&p.velocity);
    all.with_min_len(TASK).for_each(|(record, v)| crate::lanes::set_velocity(record, v));
}
