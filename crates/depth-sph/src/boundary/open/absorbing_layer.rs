//! Absorbing layers before open sides, in which waves decay (sheet: depth-sph §3.9).
//!
//! Depth and speed along the normal relax to the initial state of the layer, both at the same rate: their ratio in a wave along the
//! normal is then that without a layer, so that the layer itself reflects nothing. Speed along the side is not changed: if it relaxed,
//! waves at an angle would be reflected more. Volume that nodes lose or gain counts as passed. Both of two layers relax at one rate,
//! that of the surface: waves of the surface and of the interface then keep their shape, and those of the interface decay sooner.

use crate::boundary::open::open_boundary::{OpenBoundary, SideRegion};
use crate::boundary::open::{open_sides, region_of};
use crate::phases::phase::PhaseSet;
use crate::points::phase_nodes::PlanVector;

/// Logarithm of the factor by which an absorbing layer reduces a wave that crosses it once in the normal direction.
const DECAY: f64 = 2.0;
/// Exponent of the increase of the relaxation rate with the distance from the inner edge of the layer.
const POWER: i32 = 2;

/// Initial state of an absorbing layer in cells as wide as the node spacing.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct AbsorbingLayer {
    /// Length of the layer (m).
    length: f64,
    /// Cells of a set from the side inward, strip by strip; none where there was no material.
    undisturbed_cells: [Vec<Option<UndisturbedState>>; 2],
}

/// Initial state in a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
struct UndisturbedState {
    /// Depth of both phases or of the layer (m).
    depth: f64,
    /// Depth of both layers (m).
    total_depth: f64,
    /// Outward speed (m/s).
    speed: f64,
}

impl AbsorbingLayer {
    /// Absorbing layer of a length (m), without a state.
    pub(super) fn new(length: f64) -> Self {
        Self { length, ..Self::default() }
    }
}

impl<const D: usize> OpenBoundary<D> {
    /// Number of cells of the layer along the normal.
    fn cells(&self) -> usize {
        (self.layer.length / self.spacing).ceil() as usize
    }

    /// Cell of the layer that contains a position.
    fn cell(&self, x: &PlanVector<D>) -> Option<usize> {
        let inside = -self.distance_beyond(x);
        if !(0.0..self.layer.length).contains(&inside) {
            return None;
        }
        let cells = self.cells();
        Some(self.strip(x) * cells + ((inside / self.spacing) as usize).min(cells - 1))
    }

    /// Stores the initial state in the layer.
    pub(crate) fn store_undisturbed(
        &mut self,
        sets: &[PhaseSet<D>],
        region: &dyn Fn(&PlanVector<D>) -> SideRegion,
    ) {
        let cells = self.cells();
        for (number, set) in self.own_sets(sets) {
            let mut sums = vec![[0.0; 4]; cells * self.strips.len()];
            let nodes = &set.nodes;
            let depths = self.depths(nodes);
            for (i, x) in nodes.position.iter().enumerate() {
                let Some(cell) = self.cell(x).filter(|_| region(x) == SideRegion::Interior) else { continue };
                let one = [1.0, depths[i], nodes.depth[i], self.outward * nodes.velocity[i][self.axis]];
                (0..4).for_each(|k| sums[cell][k] += one[k]);
            }
            let mean = |[count, depth, whole, speed]: &[f64; 4]| {
                let calm = || UndisturbedState {
                    depth: depth / count,
                    total_depth: whole / count,
                    speed: speed / count,
                };
                (*count > 0.0).then(calm)
            };
            self.layer.undisturbed_cells[number] = sums.iter().map(mean).collect();
        }
    }

    /// Relaxes waves over `dt` (s).
    fn relax_layer(
        &mut self,
        number: usize,
        set: &mut PhaseSet<D>,
        dt: f64,
        region: &dyn Fn(&PlanVector<D>) -> SideRegion,
    ) {
        let nodes = &mut set.nodes;
        for i in 0..nodes.len() {
            let x = nodes.position[i];
            let Some(cell) = self.cell(&x).filter(|_| region(&x) == SideRegion::Interior) else { continue };
            let Some(calm) = self.layer.undisturbed_cells[number][cell] else { continue };
            let celerity = (nodes.effective_gravity[i] * calm.total_depth).sqrt();
            // Layers that have speeds of their own have one rate.
            let stream = if self.flow_layer.is_some() { 0.0 } else { calm.speed };
            let wave = (stream + celerity).max(0.5 * celerity);
            let within = 1.0 + self.distance_beyond(&x) / self.layer.length;
            let rate = f64::from(1 + POWER) * DECAY * wave / self.layer.length * within.powi(POWER);
            let stays = (-rate * dt).exp();
            let still = self.outward * calm.speed;
            let speed = &mut nodes.velocity[i][self.axis];
            *speed = still + stays * (*speed - still);
            // Where there is next to no material, no more is added than at half of the depth.
            let excess = 1.0 - calm.depth / self.depths(nodes)[i].max(0.5 * calm.depth);
            let taken = (1.0 - stays) * excess * nodes.volume[i];
            nodes.volume[i] -= taken;
            self.state.outflow[number] += taken;
        }
    }
}

/// Relaxes the flow in the absorbing layers at open boundaries towards its initial state over `dt` (s).
pub(crate) fn relax_absorbing_layers<const D: usize>(
    open: &mut [OpenBoundary<D>],
    sets: &mut [PhaseSet<D>],
    dt: f64,
) {
    if open.iter().all(|end| end.layer.length == 0.0) {
        return;
    }
    let sides = open_sides(open);
    for (number, end) in open.iter_mut().enumerate() {
        let region = |x: &PlanVector<D>| region_of(&sides, number, x);
        for (role, set) in sets.iter_mut().enumerate() {
            if end.is_of(role) {
                end.relax_layer(role, set, dt, &region);
            }
        }
    }
}
