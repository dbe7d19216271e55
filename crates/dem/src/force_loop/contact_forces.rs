//! Forces of all contacts in a step, and their sums.

use crate::boundary::controlled_cell::ControlledCell;
use crate::boundary::walls::{RigidWall, WallReaction};
use crate::clock::Clock;
use crate::config::{ContactVelocity, LeverArm};
use crate::contact::ContactEnergies;
use crate::contact::contact_laws::ContactLaws;
use crate::force_loop::contact_buffers::ContactBuffers;
use crate::force_loop::{ContactInput, ForceKernel, scatter_forces};
use crate::neighbours::grain_neighbours::GrainNeighbours;
use crate::neighbours::wall_list::{WallList, WallListView};
use crate::points::grain_extremes::GrainExtremes;
use crate::points::grains::Grains;
use crate::points::vector::{add, dot};

/// Computes the forces of all contacts from positions and the velocities half a step earlier, before a step of `next` (s).
pub fn find_forces<const D: usize, const R: usize>(
    clock: &Clock,
    laws: &ContactLaws,
    cell: &ControlledCell<D>,
    (grains, extremes): (&mut Grains<D, R>, &GrainExtremes),
    walls: &[RigidWall<D>],
    neighbours: &mut GrainNeighbours<D, R>,
    (buffers, next): (&mut ContactBuffers<D, R>, f64),
) {
    cell.geometry.shifts(&mut buffers.shifts);
    // Unused lanes read the first grain.
    let single = grains.mass.is_empty() || laws.scalar_only;
    let kernel = if single { ForceKernel::Scalar } else { ForceKernel::for_laws(laws.stage.pairs.iter()) };
    match kernel {
        ForceKernel::Scalar => neighbours.pairs.clear_active(),
        _ => neighbours.select_active_pairs(laws, cell, grains, extremes, &buffers.shifts),
    }
    let slabs = neighbours.pairs.slab_count();
    let ContactBuffers { slab_energies, reactions, shifts, velocity, spin, records } = buffers;
    slab_energies.clear();
    slab_energies.resize(slabs + 1, (ContactEnergies::default(), [[0.0; D]; D]));
    reactions.clear();
    reactions.resize(slabs * walls.len(), WallReaction::ZERO);
    let (grains, (force, torque)) = grains.view_and_forces();
    let mut input = ContactInput::new(grains, &laws.stage.pairs, laws.kinds.len());
    (input.shifts, input.growth) = (shifts, cell.growth_rate(clock));
    (input.dt, input.next_step) = (clock.last_step, next);
    input.radii = clock.options.lever_arm == LeverArm::Radius;
    if clock.options.velocity == ContactVelocity::Predicted {
        (input.velocity, input.spin) = (velocity, spin);
    }
    input.kernel = kernel;
    if !single {
        input.plane_kernel = ForceKernel::for_laws(walls.iter().flat_map(|wall| &wall.laws));
    }
    records.resize(grains.mass.len());
    input.contacts(&mut neighbours.pairs, records, slab_energies);
    input.motions = &records.motion;
    scatter_forces(&records.forces, grains.radius, (&mut *force, &mut *torque));
    let WallList { grain, wall, slabs: of_slabs, history, facet, .. } = &mut neighbours.walls;
    if !grain.is_empty() {
        let view = WallListView { grain, wall, slabs: of_slabs, facet };
        let list = (&view, neighbours.pairs.slabs.as_slice());
        let slab_energies = &mut slab_energies[..slabs];
        input.wall_forces(walls, list, history.view(), (force, torque), slab_energies, reactions);
    }
}

/// Adds up contact energies, virial of the cell and wall reactions of all slabs, in the order of the slabs.
pub fn sum_contacts<const D: usize, const R: usize>(
    clock: &Clock,
    cell: &mut ControlledCell<D>,
    walls: &mut [RigidWall<D>],
    buffers: &ContactBuffers<D, R>,
) -> ContactEnergies {
    let (mut energies, mut virial) = (ContactEnergies::default(), [[0.0; D]; D]);
    for (own, part) in &buffers.slab_energies {
        energies.add(own);
        for (row, more) in virial.iter_mut().zip(part) {
            add(row, 1.0, more);
        }
    }
    cell.virial[0] = virial;
    let count = walls.len();
    for (number, wall) in walls.iter_mut().enumerate() {
        let (mut force, mut moment) = ([0.0; D], [0.0; 3]);
        for part in buffers.reactions.iter().skip(number).step_by(count) {
            add(&mut force, 1.0, &part.force);
            add(&mut moment, 1.0, &part.moment);
        }
        wall.moment = moment;
        let before = std::mem::replace(&mut wall.reaction[0], force);
        // Mean of the forces at both ends of the displacement. Its sum is that of the kicks, over half of the steps before and after.
        let mean: [f64; D] = std::array::from_fn(|c| 0.5 * (before[c] + force[c]));
        if wall.surface.is_none() {
            energies.boundary -= dot(&mean, &wall.velocity) * clock.last_step;
        }
        add(&mut wall.reaction[1], clock.last_step, &mean);
    }
    energies
}
