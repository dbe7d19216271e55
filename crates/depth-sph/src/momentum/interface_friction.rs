//! Friction between two layers (sheet: depth-sph §2.11).

use rayon::prelude::*;

use crate::config::choices::Phases;
use crate::config::settings::FlowSettings;
use crate::neighbours::kernel_average::kernel_average;
use crate::phases::limits::FlowLimits;
use crate::phases::phase::PhaseSet;
use crate::points::MIN_NODES_PER_TASK;
use crate::points::phase_nodes::{PlanVector, norm};

/// Friction between two layers, `τ = ½ C_f ρ₂ |v₂ - v₁| (v₂ - v₁)`, implicit in the slip.
pub(super) fn apply_interface_friction<const D: usize>(
    settings: &FlowSettings<D>,
    limits: &FlowLimits,
    sets: &mut [PhaseSet<D>],
    dt: f64,
) {
    debug_assert_eq!(settings.phases, Phases::Layers);
    let factor = settings.interface_friction;
    if factor == 0.0 {
        return;
    }
    let kernel = settings.numerics.kernel;
    let densities = settings.material.densities;
    let changes: Vec<Vec<PlanVector<D>>> = (0..2)
        .map(|role| {
            let (own, other) = (&sets[role], &sets[1 - role]);
            let change = |i: usize| {
                let across = own.other_phase_neighbours.neighbours(i).iter().map(|&j| j as usize);
                let (x, length) = (&own.nodes.position[i], own.nodes.length[i]);
                let velocity = |j: usize| other.neighbour_data.velocity[j];
                let Some(there) = kernel_average(kernel, x, length, &other.neighbour_data, across, velocity)
                else {
                    return [0.0; D];
                };
                let slip: PlanVector<D> = std::array::from_fn(|c| there[c] - own.nodes.velocity[i][c]);
                let heights = [own.nodes.partial_thickness[i], own.neighbour_data.partner_height[i]];
                if heights[1] < limits.min_partner_depth {
                    return [0.0; D];
                }
                let [lower, upper] = if role == 0 { heights } else { [heights[1], heights[0]] };
                let stress = 0.5 * factor * densities.fluid * norm(&slip) * dt;
                let masses = [densities.grain * lower, densities.fluid * upper];
                let both = stress / masses[0] + stress / masses[1];
                std::array::from_fn(|c| stress / masses[role] / (1.0 + both) * slip[c])
            };
            (0..own.nodes.len())
                .into_par_iter()
                .with_min_len(MIN_NODES_PER_TASK)
                .map(change)
                .collect::<Vec<_>>()
        })
        .collect();
    for (set, changes) in sets.iter_mut().zip(&changes) {
        for (v, change) in set.nodes.velocity.iter_mut().zip(changes) {
            for c in 0..D {
                v[c] += change[c];
            }
        }
    }
}
