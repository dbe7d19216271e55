//! Heights by summation over neighbours, and smoothing lengths that follow them (sheet: depth-sph §2.10).

use rayon::prelude::*;

use crate::config::choices::{PressureForceForm, ThicknessEquation};
use crate::config::settings::Numerics;
use crate::kernel::Kernel;
use crate::neighbours::cell_sorted::CellSorted;
use crate::neighbours::kernel_average::square;
use crate::neighbours::nearby_nodes::NearbyNodes;
use crate::neighbours::simd_neighbour_list::MARGIN;
use crate::phases::phase::PhaseSet;
use crate::points::MIN_NODES_PER_TASK;
use crate::points::image_nodes::copy_with_images;

/// Largest number of Newton steps for the height of a node, and the relative change of its smoothing length at which they stop.
const NEWTON: (usize, f64) = (50, 1e-13);
/// Value of `Ω` below which a node is isolated: its smoothing length is at its upper bound.
const MIN_OMEGA: f64 = 1e-3;

impl<const D: usize> PhaseSet<D> {
    /// Step 2: heights of the phase, with smoothing lengths for which `h ℓ^d / m` is constant.
    pub fn sum_thickness(&mut self, numerics: &Numerics) {
        let kernel = numerics.kernel;
        if numerics.momentum == PressureForceForm::Variational {
            self.solve_thickness(numerics);
            return;
        }
        let has_heights = self.nodes.partial_thickness.iter().all(|height| *height > 0.0);
        if numerics.continuity == ThicknessEquation::Normalised && has_heights {
            self.update_image_thickness();
        }
        self.max_smoothing_length.update(
            &self.neighbour_data.position,
            &self.neighbour_data.length,
            (1.0 + MARGIN) * kernel.support(),
        );
        let Self { nodes, cell_sorted, packed_neighbours, max_smoothing_length, .. } = self;
        let (cell_sorted, max_smoothing_length) = (&*cell_sorted, &*max_smoothing_length);
        let (position, volume, first, scale) =
            (&nodes.position, &nodes.volume, &nodes.first_length, &nodes.scale);
        let columns = nodes
            .partial_thickness
            .par_chunks_mut(MIN_NODES_PER_TASK)
            .zip(nodes.length.par_chunks_mut(MIN_NODES_PER_TASK));
        let blocks = packed_neighbours.blocks(position.len()).par_iter_mut().zip(columns).enumerate();
        blocks.for_each_init(
            || cell_sorted.nearby_nodes(),
            |nearby, (number, (block, (heights, lengths)))| {
                block.clear();
                for (k, (height, length)) in heights.iter_mut().zip(lengths).enumerate() {
                    let i = number * MIN_NODES_PER_TASK + k;
                    let (x, before) = (position[i], *length);
                    block.push(nearby.list_neighbours(kernel, x, before, max_smoothing_length.length_at(&x)));
                    for _ in 0..numerics.summation_passes {
                        // For the cubic spline the compiler makes a loop of its own.
                        *height = match kernel {
                            Kernel::CubicSpline => nearby.sum_of::<true>(kernel, *length),
                            _ => nearby.sum_of::<false>(kernel, *length),
                        };
                        if numerics.variable_length {
                            *length =
                                length_from_thickness::<D>(numerics, scale[i], volume[i], *height, first[i]);
                        }
                    }
                    if *length > (1.0 + MARGIN) * before {
                        block.mark_incomplete();
                    }
                }
            },
        );
        packed_neighbours.check_complete();
        if numerics.continuity == ThicknessEquation::Normalised {
            if !has_heights {
                // There are no heights before the first sum.
                self.update_image_thickness();
            }
            self.normalise(kernel);
        }
    }

    /// Solves heights `h = Σ m W(ℓ(h))` by Newton's method, with `Ω` (sheet: depth-sph §3.4).
    fn solve_thickness(&mut self, numerics: &Numerics) {
        let Self { nodes, cell_sorted, omega, .. } = self;
        let cell_sorted = &*cell_sorted;
        omega.resize(nodes.len(), 1.0);
        let (position, volume, first, scale) =
            (&nodes.position, &nodes.volume, &nodes.first_length, &nodes.scale);
        let columns =
            nodes.partial_thickness.par_iter_mut().zip(nodes.length.par_iter_mut()).zip(omega).enumerate();
        columns.with_min_len(MIN_NODES_PER_TASK).for_each_init(
            || cell_sorted.nearby_nodes(),
            |nearby, (i, ((height, length), omega))| {
                nearby.move_to(position[i]);
                (*height, *omega) =
                    solve_node_thickness(nearby, numerics, length, scale[i] * volume[i], first[i]);
            },
        );
    }

    /// Divides heights by `Σ (m/h) W`, with the heights before.
    fn normalise(&mut self, kernel: Kernel) {
        let (data, nearby, nodes) = (&self.neighbour_data, &self.same_phase_neighbours, &self.nodes);
        let share = |i: usize| {
            let own = kernel.value::<D>(0.0, nodes.length[i]) * nodes.volume[i] / data.height[i];
            nearby.neighbours(i).iter().fold(own, |sum, &j| {
                let j = j as usize;
                let r = square(&nodes.position[i], &data.position[j]).sqrt();
                sum + data.volume[j] / data.height[j] * kernel.value::<D>(r, nodes.length[i])
            })
        };
        (0..nodes.len())
            .into_par_iter()
            .with_min_len(MIN_NODES_PER_TASK)
            .map(share)
            .collect_into_vec(&mut self.scratch_scalars);
        for (height, share) in self.nodes.partial_thickness.iter_mut().zip(&self.scratch_scalars) {
            *height /= share;
        }
    }

    /// Updates smoothing lengths where heights are integrated in time.
    pub fn update_smoothing_lengths(&mut self, numerics: &Numerics) {
        if !numerics.variable_length {
            return;
        }
        let nodes = &mut self.nodes;
        for i in 0..nodes.len() {
            let (scale, first) = (nodes.scale[i], nodes.first_length[i]);
            nodes.length[i] = length_from_thickness::<D>(
                numerics,
                scale,
                nodes.volume[i],
                nodes.partial_thickness[i],
                first,
            );
        }
    }

    /// Heights of the other phase at each node (m), by kernel summation.
    pub fn sum_partner_thickness(&mut self, kernel: Kernel, other: &CellSorted<D>) {
        let nodes = &self.nodes;
        let partner = |i: usize| other.sum(kernel, &nodes.position[i], nodes.length[i]);
        (0..nodes.len())
            .into_par_iter()
            .with_min_len(MIN_NODES_PER_TASK)
            .map(partner)
            .collect_into_vec(&mut self.scratch_scalars);
        copy_with_images(&self.images, &self.scratch_scalars, &mut self.neighbour_data.partner_height);
    }
}

/// Height of a node (m) for which `ℓ^d h` equals `kept`, and its `Ω = 1 + ℓ/(d h) ∂h/∂ℓ`. `Ω` is 1 if the smoothing length is at a bound.
fn solve_node_thickness<const D: usize>(
    nearby: &mut NearbyNodes<'_, D>,
    numerics: &Numerics,
    length: &mut f64,
    kept: f64,
    first: f64,
) -> (f64, f64) {
    let kernel = numerics.kernel;
    if !numerics.variable_length {
        return (nearby.sum(kernel, *length), 1.0);
    }
    let (low, high) = length_bounds(numerics, first);
    *length = length.clamp(low, high);
    let (mut height, mut omega) = (0.0, 1.0);
    for _ in 0..NEWTON.0 {
        let (sum, slope) = nearby.sum_and_slope(kernel, *length);
        (height, omega) = (sum, 1.0 + *length / (D as f64 * sum) * slope);
        let wanted = if omega > MIN_OMEGA {
            let excess = 1.0 - kept / (length.powi(D as i32) * sum);
            (*length * (1.0 - (excess / (D as f64 * omega)).clamp(-1.0, 0.5))).clamp(low, high)
        } else {
            high
        };
        let change = (wanted - *length).abs();
        if change <= NEWTON.1 * *length {
            break;
        }
        *length = wanted;
    }
    (height, if *length > low && *length < high { omega } else { 1.0 })
}

/// Bounds of a smoothing length (m) of initial value `first` (m).
#[inline]
fn length_bounds(numerics: &Numerics, first: f64) -> (f64, f64) {
    let (smallest, largest) = numerics.length_range;
    let shortest = numerics.shortest.min(first);
    ((smallest * first).max(shortest), (largest * first).max(shortest))
}

/// Smoothing length `ℓ = (scale m / h)^(1/d)` within its bounds.
#[inline]
fn length_from_thickness<const D: usize>(
    numerics: &Numerics,
    scale: f64,
    volume: f64,
    height: f64,
    first: f64,
) -> f64 {
    let power = scale * volume / height;
    let length = if D == 1 { power } else { power.sqrt() };
    let (low, high) = length_bounds(numerics, first);
    // A height of zero has an infinite length: the upper bound applies.
    length.clamp(low, high)
}
