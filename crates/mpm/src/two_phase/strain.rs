//! Volumetric strain averaged over cells, against locking (MPM sheet §2.17).

use colluvium_grid::{Basis, Lanes, Stencil};

use super::{LIQUID, SOLID, TwoPhase, transfer::trace};
use crate::points::PointDomain;
use crate::solver::MpmSolver;

impl<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>> MpmSolver<D, S, B, P> {
    /// Averages the volumetric strains of the step over the points of each cell, phase by phase.
    pub(super) fn average_strains<const FROM_SOLVED: bool>(&self, phases: &mut TwoPhase, dt: f64) {
        self.layout.reset(&mut phases.cells);
        let strides = self.layout.strides();
        let TwoPhase { nodes, remapped, cells, .. } = phases;
        self.layout.scatter(cells, |slab, window, offset| {
            for set in &self.sets {
                let wet = set.pore.as_ref().is_some_and(|pore| pore.fluid.is_some());
                for p in set.slabs[slab]..set.slabs[slab + 1] {
                    let position = &set.position[p];
                    let extent = set.domain[p].extent(&set.extent, self.grid.cell);
                    let stencil = Stencil::<D, S>::new::<B>(&self.grid, position, &extent);
                    let read = if FROM_SOLVED {
                        stencil.gather_phases(nodes, &strides)
                    } else {
                        stencil.gather_velocities(remapped, &strides)
                    };
                    let volume = set.volume[p];
                    let moved = if wet { volume } else { 0.0 };
                    let [solid, liquid] = [SOLID, LIQUID].map(|phase| dt * trace(&read[phase].gradient));
                    window[self.lowest_node(position) - offset] +=
                        Lanes::new([volume, volume * solid, moved, moved * liquid]);
                }
            }
        });
    }

    /// Number of the lowest node of the cell that holds `position`.
    #[inline(always)]
    fn lowest_node(&self, position: &[f64; D]) -> usize {
        let (cell, strides) = (self.grid.cell_of(position), self.layout.strides());
        (0..D).map(|axis| (cell[axis] + B::GHOSTS) * strides[axis]).sum()
    }

    /// Average volumetric strains of skeleton and liquid in the cell that holds `position`.
    #[inline(always)]
    pub(super) fn cell_strains(&self, phases: &TwoPhase, position: &[f64; D]) -> [f64; 2] {
        let [volume, solid, moved, liquid] = phases.cells[self.lowest_node(position)].to_array();
        [solid / volume, if moved > 0.0 { liquid / moved } else { 0.0 }]
    }
}
