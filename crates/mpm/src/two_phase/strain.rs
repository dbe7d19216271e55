//! Volumetric strain of both phases, shared within cells (MPM sheet §2.17).

use colluvium_grid::{Basis, Support};

use super::{LIQUID, SOLID, TwoPhase};
use crate::points::PointDomain;
use crate::solver::MpmSolver;

impl<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>> MpmSolver<D, S, B, P> {
    /// Shares the volumetric strains of the step, phase by phase, where the case asks for it.
    pub(super) fn share_phase_strains<const FROM_SOLVED: bool>(&mut self, phases: &TwoPhase, dt: f64) {
        if !self.strains.is_shared() {
            return;
        }
        let strides = self.layout.strides();
        self.share_strains(|solver, set, p, support| {
            let read = if FROM_SOLVED {
                support.gather_phases(&phases.nodes, &strides)
            } else {
                support.gather_velocities(&phases.remapped, &strides)
            };
            [SOLID, LIQUID].map(|phase| dt * solver.dilation(&read[phase], set.position[p][0]))
        });
    }
}
