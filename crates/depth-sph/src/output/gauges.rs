//! Gauges: depth and flux at a position, and discharge across a line.

use crate::kernel::Kernel;
use crate::phases::phase::PhaseSet;
use crate::points::phase_nodes::{PlanVector, dot};

/// Least number of samples along a gauge line per smoothing length.
const PLACES_PER_LENGTH: f64 = 4.0;
/// Largest number of samples along a gauge line.
const MAX_SAMPLES: f64 = 1e4;

/// Depth (m) and volume flux per width (m²/s) at a position in plan, by kernel sums.
pub fn depth_and_flux<const D: usize>(
    kernel: Kernel,
    sets: &[PhaseSet<D>],
    x: &PlanVector<D>,
) -> (f64, PlanVector<D>) {
    let (mut depth, mut flux) = (0.0, [0.0; D]);
    for set in sets {
        let nodes = &set.nodes;
        for i in 0..nodes.len() {
            let apart: PlanVector<D> = std::array::from_fn(|c| nodes.position[i][c] - x[c]);
            let (square, reach) = (dot(&apart, &apart), kernel.support() * nodes.length[i]);
            if square >= reach * reach {
                continue;
            }
            let share = nodes.volume[i] * kernel.value::<D>(square.sqrt(), nodes.length[i]);
            depth += share;
            (0..D).for_each(|c| flux[c] += share * nodes.velocity[i][c]);
        }
    }
    (depth, flux)
}

/// Discharge across a gauge line in plan (m³/s), positive to the right of the direction from `from` to `to`; zero in a profile.
pub fn discharge<const D: usize>(
    kernel: Kernel,
    sets: &[PhaseSet<D>],
    from: &PlanVector<D>,
    to: &PlanVector<D>,
) -> f64 {
    if D != 2 {
        return 0.0;
    }
    let along: PlanVector<D> = std::array::from_fn(|c| to[c] - from[c]);
    let length = dot(&along, &along).sqrt();
    let shortest = sets.iter().flat_map(|set| &set.nodes.length).copied().fold(f64::INFINITY, f64::min);
    let count = (PLACES_PER_LENGTH * length / shortest).ceil().clamp(1.0, MAX_SAMPLES);
    let part = |k: usize| {
        let share = (k as f64 + 0.5) / count;
        let (_, flux) = depth_and_flux(kernel, sets, &std::array::from_fn(|c| from[c] + share * along[c]));
        // The normal to the right, as long as the line.
        (flux[0] * along[D - 1] - flux[D - 1] * along[0]) / count
    };
    (0..count as usize).map(part).sum()
}
