//! Erosion of the bed, friction between layers, and removal of nodes that leave (sheet: depth-sph §2.8,
//! §2.11, §3.4 step 8).

use colluvium_points::ScratchBuffers;
use rayon::prelude::*;

use crate::bed::Bed;
use crate::config::choices::Phases;
use crate::flow::{Flow, FlowFailure, OutsideNodes, PorePressureColumns, failure};
use crate::neighbours::thickness::kernel_average;
use crate::phases::phase::{PhaseSet, TASK};
use crate::phases::phase_nodes::{PhaseNodes, PlanVector, dot, norm};

impl<const D: usize> Flow<D> {
    /// Step 8: entrainment of eroded material by the nodes, which share their momentum with it.
    pub(crate) fn erode_bed(&mut self, dt: f64) {
        for set in &mut self.sets {
            let paths = set.nodes.path.iter_mut().zip(&set.nodes.velocity).zip(&set.bed);
            paths.for_each(|((path, velocity), bed)| *path += bed.speed(velocity) * dt);
        }
        if self.settings.zones.iter().all(|zone| zone.erosion.is_none()) {
            return;
        }
        self.with_erosion(|flow| flow.entrain(dt));
    }

    /// Adds eroded material to the nodes.
    fn entrain(&mut self, dt: f64) {
        let densities = self.settings.material.densities;
        for number in 0..self.sets.len() {
            let set = &self.sets[number];
            let growth = |i: usize| -> f64 {
                let (nodes, bed) = (&set.nodes, &set.bed[i]);
                let Some(law) = &self.settings.zone(&nodes.position[i]).erosion else { return 0.0 };
                let speeds = [bed.speed(&nodes.velocity[i]), norm(&nodes.velocity[i])];
                let tangent = dot(&bed.slope, &bed.slope).sqrt();
                let porosity =
                    set.neighbour_data.porosity.get(i).copied().unwrap_or(self.settings.material.porosity);
                let submerged = densities.submerged(porosity);
                let concentration = submerged / (submerged + densities.fluid);
                law.growth(speeds, tangent, nodes.depth[i], concentration, dt)
            };
            let found: Vec<f64> =
                (0..set.nodes.len()).into_par_iter().with_min_len(TASK).map(growth).collect();
            let PhaseSet { nodes, bed, .. } = &mut self.sets[number];
            for (i, mut growth) in found.into_iter().enumerate() {
                if growth <= 0.0 {
                    continue;
                }
                let mut taken = nodes.volume[i] * growth;
                if let Bed::Erodible(worn) = &mut self.bed {
                    taken = worn.erode(&nodes.position[i], taken);
                    growth = taken / nodes.volume[i];
                    if growth <= 0.0 {
                        continue;
                    }
                }
                nodes.volume[i] += taken;
                nodes.eroded[i] += taken;
                // The node slows down while it grows.
                let speed = bed[i].speed(&nodes.velocity[i]);
                nodes.path[i] -= speed * dt * (1.0 - growth.ln_1p() / growth);
                self.entrained[number] += taken;
                nodes.velocity[i].iter_mut().for_each(|v| *v /= 1.0 + growth);
            }
        }
        if let Bed::Erodible(worn) = &mut self.bed {
            let lowered = worn.update_surface::<D>(self.step);
            if lowered {
                self.transport_velocities();
            }
        }
    }

    /// Friction between two layers, `τ = ½ C_f ρ₂ |v₂ - v₁| (v₂ - v₁)`, implicit in the slip.
    pub(crate) fn interface_friction(&mut self, dt: f64) {
        debug_assert_eq!(self.settings.phases, Phases::Layers);
        let factor = self.settings.interface_friction;
        if factor == 0.0 {
            return;
        }
        let kernel = self.settings.numerics.kernel;
        let densities = self.settings.material.densities;
        let changes: Vec<Vec<PlanVector<D>>> = (0..2)
            .map(|role| {
                let (own, other) = (&self.sets[role], &self.sets[1 - role]);
                let change = |i: usize| {
                    let across = own.other_phase_neighbours.neighbours(i).iter().map(|&j| j as usize);
                    let (x, length) = (&own.nodes.position[i], own.nodes.length[i]);
                    let velocity = |j: usize| other.neighbour_data.velocity[j];
                    let Some(there) =
                        kernel_average(kernel, x, length, &other.neighbour_data, across, velocity)
                    else {
                        return [0.0; D];
                    };
                    let slip: PlanVector<D> = std::array::from_fn(|c| there[c] - own.nodes.velocity[i][c]);
                    let heights = [own.nodes.partial_thickness[i], own.neighbour_data.partner[i]];
                    if heights[1] < self.min_partner_depth {
                        return [0.0; D];
                    }
                    let [lower, upper] = if role == 0 { heights } else { [heights[1], heights[0]] };
                    let stress = 0.5 * factor * densities.fluid * norm(&slip) * dt;
                    let masses = [densities.grain * lower, densities.fluid * upper];
                    let both = stress / masses[0] + stress / masses[1];
                    std::array::from_fn(|c| stress / masses[role] / (1.0 + both) * slip[c])
                };
                (0..own.nodes.len()).into_par_iter().with_min_len(TASK).map(change).collect::<Vec<_>>()
            })
            .collect();
        for (set, changes) in self.sets.iter_mut().zip(&changes) {
            for (v, change) in set.nodes.velocity.iter_mut().zip(changes) {
                for c in 0..D {
                    v[c] += change[c];
                }
            }
        }
    }

    /// Removes nodes that have left the bed.
    pub(crate) fn remove_outside(&mut self) -> Result<(), FlowFailure> {
        if self.bed.is_flat() {
            return Ok(());
        }
        for number in 0..self.sets.len() {
            let set = &self.sets[number];
            let is_out = |i: &usize| !self.bed.is_defined(&set.nodes.position[*i]);
            let out: Vec<usize> =
                (0..set.nodes.len()).into_par_iter().with_min_len(TASK).filter(is_out).collect();
            let Some(first) = out.first() else { continue };
            if self.outside == OutsideNodes::Fail {
                return Err(failure(
                    set,
                    *first,
                    "it has left the terrain, which is an error by `leaving_is_an_error`".to_owned(),
                ));
            }
            self.outflow_volume[number] += out.iter().map(|&i| set.nodes.volume[i]).sum::<f64>();
            self.removed_nodes += out.len() as u64;
            self.with_external_change(|flow| flow.remove(number, |i| out.binary_search(&i).is_ok()));
        }
        Ok(())
    }

    /// Removes nodes, with their columns of pore pressure.
    pub fn remove_where(&mut self, gone: impl Fn(&PhaseNodes<D>, usize) -> bool) {
        for number in 0..self.sets.len() {
            let nodes = &self.sets[number].nodes;
            let out: Vec<bool> = (0..nodes.len()).map(|i| gone(nodes, i)).collect();
            if out.contains(&true) {
                self.remove(number, |i| out[i]);
            }
        }
    }

    fn remove(&mut self, number: usize, gone: impl Fn(usize) -> bool) {
        let Self { sets, pore_columns: heads, scratch: spare, .. } = self;
        let set = &mut sets[number];
        let order: Vec<u32> = (0..set.nodes.len()).filter(|i| !gone(*i)).map(|i| i as u32).collect();
        keep_nodes(set, (number == 0).then_some(heads), &order, spare);
    }
}

/// Keeps the nodes of a set that `order` lists, with their columns of pore pressure if the set has them.
pub fn keep_nodes<const D: usize>(
    set: &mut PhaseSet<D>,
    heads: Option<&mut PorePressureColumns>,
    order: &[u32],
    spare: &mut ScratchBuffers,
) {
    if let Some(heads) = heads {
        heads.reorder(order);
    }
    set.nodes.reorder(order, spare);
    set.clear_lists();
}
