//! Rates of height, where heights are integrated in time (sheet: depth-sph §2.10).

use rayon::prelude::*;

use crate::config::choices::ThicknessEquation;
use crate::config::settings::Numerics;
use crate::kernel::Kernel;
use crate::phases::phase::PhaseSet;
use crate::points::MIN_NODES_PER_TASK;
use crate::points::phase_nodes::{PlanVector, dot};

/// Computes the rates of height (m/s) by the chosen thickness equation.
pub(super) fn find_thickness_rates<const D: usize>(numerics: &Numerics, sets: &mut [PhaseSet<D>]) {
    let (kernel, form) = (numerics.kernel, numerics.continuity);
    for set in sets {
        set.update_image_velocities();
        set.find_thickness_rates(kernel, form);
    }
}

impl<const D: usize> PhaseSet<D> {
    /// Rates of the partial thickness by the velocity divergence of the neighbours (m/s).
    fn find_thickness_rates(&mut self, kernel: Kernel, form: ThicknessEquation) {
        let (data, neighbours) = (&self.neighbour_data, &self.same_phase_neighbours);
        let rate = |i: usize| -> f64 {
            let (x, v, height) = (&data.position[i], &data.velocity[i], data.height[i]);
            let pair = |&j: &u32| {
                let j = j as usize;
                let apart: PlanVector<D> = std::array::from_fn(|c| x[c] - data.position[j][c]);
                let relative: PlanVector<D> = std::array::from_fn(|c| v[c] - data.velocity[j][c]);
                let mean = 0.5 * (data.length[i] + data.length[j]);
                let gradient = kernel.gradient::<D>(dot(&apart, &apart).sqrt(), mean);
                let volume = data.volume[j];
                gradient
                    * match form {
                        ThicknessEquation::RateDifference => volume * dot(&relative, &apart),
                        ThicknessEquation::RateVolume => {
                            height * volume / data.height[j] * dot(&relative, &apart)
                        }
                        _ => -height * volume / data.height[j] * dot(&data.velocity[j], &apart),
                    }
            };
            neighbours.neighbours(i).iter().map(pair).sum()
        };
        let count = self.nodes.len();
        (0..count)
            .into_par_iter()
            .with_min_len(MIN_NODES_PER_TASK)
            .map(rate)
            .collect_into_vec(&mut self.rate);
    }
}
