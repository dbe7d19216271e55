//! Depth-integrated pressures in the form that the momentum sums use (sheet: depth-sph §2.5).

use rayon::prelude::*;

use crate::config::choices::PressureForceForm;
use crate::config::settings::FlowSettings;
use crate::kernel::Kernel;
use crate::phases::phase::PhaseSet;
use crate::points::MIN_NODES_PER_TASK;
use crate::points::image_nodes::copy_with_images;
use crate::points::phase_nodes::dot;
use crate::pore_pressure::pore_pressure_columns::PorePressureColumns;

/// Width of the transition of the earth-pressure coefficient over `√(g/h)` (sheet: depth-sph §2.5).
const SWITCH_WIDTH: f64 = 1e-2;

/// Earth-pressure coefficient of a node with a depth (m) and a rate of divergence (1/s).
fn earth_pressure<const D: usize>(settings: &FlowSettings<D>, depth: f64, divergence: f64) -> f64 {
    let width = || SWITCH_WIDTH * (settings.gravity / depth).sqrt();
    settings
        .earth_pressure
        .as_ref()
        .map_or(1.0, |coefficients| coefficients.coefficient_at(divergence, width()))
}

/// Computes the divergence rates of the first node set (1/s), if the earth-pressure coefficient depends on them.
pub(super) fn find_earth_pressure<const D: usize>(settings: &FlowSettings<D>, set: &mut PhaseSet<D>) {
    if settings.earth_pressure.is_none() {
        return;
    }
    let kernel = settings.numerics.kernel;
    let (data, neighbours) = (&set.neighbour_data, &set.same_phase_neighbours);
    let divergence = |i: usize| -> f64 {
        let pair = |&j: &u32| {
            let j = j as usize;
            let apart: [f64; D] = std::array::from_fn(|c| data.position[i][c] - data.position[j][c]);
            let relative: [f64; D] = std::array::from_fn(|c| data.velocity[i][c] - data.velocity[j][c]);
            let gradient = kernel.gradient::<D>(dot(&apart, &apart).sqrt(), data.length[i]);
            -data.volume[j] / data.height[j] * gradient * dot(&relative, &apart)
        };
        neighbours.neighbours(i).iter().map(pair).sum()
    };
    let count = set.nodes.len();
    (0..count)
        .into_par_iter()
        .with_min_len(MIN_NODES_PER_TASK)
        .map(divergence)
        .collect_into_vec(&mut set.divergence);
}

/// Computes pressures of a single phase, or of layers.
pub(super) fn find_single_pressures<const D: usize>(
    settings: &FlowSettings<D>,
    sets: &mut [PhaseSet<D>],
    pore_columns: &PorePressureColumns,
) {
    let material = &settings.material;
    let submerged = material.densities.submerged_density(material.porosity);
    for (number, set) in sets.iter_mut().enumerate() {
        let PhaseSet {
            nodes, neighbour_data: data, images, scratch_scalars: scalars, divergence, omega, ..
        } = set;
        scalars.clear();
        if number > 0 || settings.earth_pressure.is_none() {
            scalars.resize(nodes.len(), 0.5);
        } else {
            let of_node = |i: usize| {
                let excess = earth_pressure(settings, nodes.depth[i], divergence[i]) - 1.0;
                if !material.is_saturated {
                    return 0.5 * (1.0 + excess);
                }
                // Only the effective part of the stress has a horizontal share other than the vertical one.
                let effective =
                    (0.5 - pore_columns.mean(i) / nodes.depth[i]) * submerged / material.density();
                0.5 + excess * effective
            };
            scalars.extend((0..nodes.len()).map(of_node));
        }
        if settings.numerics.momentum == PressureForceForm::Variational {
            scalars.iter_mut().zip(&*omega).for_each(|(pressure, omega)| *pressure /= omega);
        }
        copy_with_images(images, scalars, &mut data.pressure);
    }
}

/// Computes pressures of grains and pore fluid: `P_s` and `P_w` over `g_* h_α²`, and `h ρ' ψ̄`.
pub(super) fn find_phase_pressures<const D: usize>(
    settings: &FlowSettings<D>,
    sets: &mut [PhaseSet<D>],
    pore_columns: &PorePressureColumns,
) {
    let densities = settings.material.densities;
    // Mean heads of the grains; for the fluid, averages of those around it.
    let count = sets[0].nodes.len();
    let heads: Vec<f64> = (0..count).into_par_iter().map(|i| pore_columns.mean(i)).collect();
    let of_fluid = heads_at_fluid(settings.numerics.kernel, sets, pore_columns, &heads);
    for role in 0..2 {
        let set = &sets[role];
        let of_node = |i: usize| {
            let (height, depth) = (set.nodes.partial_thickness[i], set.nodes.depth[i]);
            let porosity = set.neighbour_data.porosity[i];
            let submerged = densities.submerged_density(porosity);
            let head = if role == 0 { heads[i] } else { of_fluid[i] };
            let excess = depth * submerged * head;
            let pressure = if role == 0 {
                let divergence = set.divergence.get(i).copied().unwrap_or(0.0);
                let lateral = earth_pressure(settings, depth, divergence) - 1.0;
                let effective = lateral * (0.5 * submerged * depth * depth - excess);
                0.5 * height * depth + (effective - porosity * excess) / densities.grain
            } else {
                0.5 * height * depth + porosity * excess / densities.fluid
            };
            (pressure / (height * height), excess)
        };
        let found: Vec<(f64, f64)> =
            (0..set.nodes.len()).into_par_iter().with_min_len(MIN_NODES_PER_TASK).map(of_node).collect();
        let set = &mut sets[role];
        let (pressures, excesses): (Vec<f64>, Vec<f64>) = found.into_iter().unzip();
        copy_with_images(&set.images, &pressures, &mut set.neighbour_data.pressure);
        copy_with_images(&set.images, &excesses, &mut set.neighbour_data.excess);
    }
}

/// Mean pore-pressure head of the grains around each fluid node (m).
fn heads_at_fluid<const D: usize>(
    kernel: Kernel,
    sets: &[PhaseSet<D>],
    pore_columns: &PorePressureColumns,
    heads: &[f64],
) -> Vec<f64> {
    let (solid, fluid) = (&sets[0], &sets[1]);
    if pore_columns.is_empty() {
        return vec![0.0; fluid.nodes.len()];
    }
    let sorted_heads = solid.cell_sorted.sorted_values(|j| [heads[solid.number(j)]]);
    let mean = |i: usize| {
        let (x, length) = (&fluid.nodes.position[i], fluid.nodes.length[i]);
        solid.cell_sorted.mean(kernel, x, length, &sorted_heads).map_or(0.0, |[value]| value)
    };
    (0..fluid.nodes.len()).into_par_iter().with_min_len(MIN_NODES_PER_TASK).map(mean).collect::<Vec<_>>()
}
