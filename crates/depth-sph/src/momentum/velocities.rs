//! Velocities beside the present ones: of the drift, before the step, before the kick.

use rayon::prelude::*;

use crate::config::settings::FlowSettings;
use crate::phases::depths::find_neighbours;
use crate::phases::failure::FlowFailure;
use crate::phases::phase::PhaseSet;
use crate::points::MIN_NODES_PER_TASK;
use crate::points::image_nodes::PlanBoundaries;
use crate::points::phase_nodes::{PlanVector, dot};

/// Stores the velocities at the beginning of a step, for the slip of two phases.
pub(super) fn store_start_velocities<const D: usize>(sets: &mut [PhaseSet<D>]) {
    sets.iter_mut().for_each(|set| set.start_velocity.clone_from(&set.nodes.velocity));
}

/// Stores the velocities before the kick or the resistance, for the energy balance.
pub(super) fn store_velocities<const D: usize>(sets: &mut [PhaseSet<D>]) {
    sets.iter_mut().for_each(|set| set.stored_velocity.clone_from(&set.nodes.velocity));
}

/// Computes the drift velocities of the nodes: with XSPH, a weighted mean of their own and of their neighbours' velocities.
pub(super) fn smooth_velocities<const D: usize>(
    settings: &FlowSettings<D>,
    walls: &PlanBoundaries<D>,
    sets: &mut [PhaseSet<D>],
) -> Result<(), FlowFailure> {
    if settings.numerics.xsph == 0.0 {
        return Ok(());
    }
    find_neighbours(settings, walls, sets)?;
    let (kernel, share) = (settings.numerics.kernel, settings.numerics.xsph);
    for set in sets {
        set.update_image_thickness();
        let (data, neighbours) = (&set.neighbour_data, &set.same_phase_neighbours);
        let smoothed = |i: usize| -> PlanVector<D> {
            let mut v = data.velocity[i];
            for &j in neighbours.neighbours(i) {
                let j = j as usize;
                let apart: PlanVector<D> = std::array::from_fn(|c| data.position[i][c] - data.position[j][c]);
                let mean = 0.5 * (data.length[i] + data.length[j]);
                let weight = 2.0 * data.volume[j] / (data.height[i] + data.height[j])
                    * kernel.value::<D>(dot(&apart, &apart).sqrt(), mean);
                for c in 0..D {
                    v[c] += share * weight * (data.velocity[j][c] - data.velocity[i][c]);
                }
            }
            v
        };
        let count = set.nodes.len();
        (0..count)
            .into_par_iter()
            .with_min_len(MIN_NODES_PER_TASK)
            .map(smoothed)
            .collect_into_vec(&mut set.scratch_vectors);
    }
    Ok(())
}
