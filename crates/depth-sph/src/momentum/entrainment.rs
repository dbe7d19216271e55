//! Step 8: erosion of the bed (sheet: depth-sph §2.8, §3.4).

use rayon::prelude::*;

use crate::bed::Bed;
use crate::config::settings::FlowSettings;
use crate::phases::phase::PhaseSet;
use crate::points::MIN_NODES_PER_TASK;
use crate::points::phase_nodes::{dot, norm};

/// Adds a step of `dt` (s) to the paths of the nodes over the bed.
pub(crate) fn extend_paths<const D: usize>(sets: &mut [PhaseSet<D>], dt: f64) {
    for set in sets {
        let paths = set.nodes.path.iter_mut().zip(&set.nodes.velocity).zip(&set.bed);
        paths.for_each(|((path, velocity), bed)| *path += bed.speed(velocity) * dt);
    }
}

/// Adds the material that is eroded in a step of `dt` (s) to the nodes, at constant momentum, and its volume to `entrained`.
pub(crate) fn entrain<const D: usize>(
    settings: &FlowSettings<D>,
    bed: &mut Bed<D>,
    sets: &mut [PhaseSet<D>],
    entrained: &mut [f64; 2],
    dt: f64,
) {
    for (number, set) in sets.iter_mut().enumerate() {
        let growths = volume_growths(settings, set, dt);
        let PhaseSet { nodes, bed: points, .. } = set;
        for (i, mut growth) in growths.into_iter().enumerate() {
            if growth <= 0.0 {
                continue;
            }
            let mut eroded = nodes.volume[i] * growth;
            if let Bed::Erodible(erodible) = bed {
                eroded = erodible.erode(&nodes.position[i], eroded);
                growth = eroded / nodes.volume[i];
                if growth <= 0.0 {
                    continue;
                }
            }
            nodes.volume[i] += eroded;
            nodes.eroded_volume[i] += eroded;
            // The node slows down while it grows.
            let speed = points[i].speed(&nodes.velocity[i]);
            nodes.path[i] -= speed * dt * (1.0 - growth.ln_1p() / growth);
            entrained[number] += eroded;
            nodes.velocity[i].iter_mut().for_each(|v| *v /= 1.0 + growth);
        }
    }
}

/// Growth of the volume of each node in a step of `dt` (s), over its volume, where the bed is not limited.
fn volume_growths<const D: usize>(settings: &FlowSettings<D>, set: &PhaseSet<D>, dt: f64) -> Vec<f64> {
    let densities = settings.material.densities;
    let growth = |i: usize| -> f64 {
        let (nodes, bed) = (&set.nodes, &set.bed[i]);
        let Some(law) = &settings.zone(&nodes.position[i]).erosion else { return 0.0 };
        let speeds = [bed.speed(&nodes.velocity[i]), norm(&nodes.velocity[i])];
        let tangent = dot(&bed.slope, &bed.slope).sqrt();
        let porosity = set.neighbour_data.porosity.get(i).copied().unwrap_or(settings.material.porosity);
        let submerged = densities.submerged_density(porosity);
        let concentration = submerged / (submerged + densities.fluid);
        law.growth(speeds, tangent, nodes.depth[i], concentration, dt)
    };
    (0..set.nodes.len()).into_par_iter().with_min_len(MIN_NODES_PER_TASK).map(growth).collect::<Vec<_>>()
}
