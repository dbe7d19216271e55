//! Volumetric strain of both phases, shared within cells (sheet: mpm §2.17).

use colluvium_constitutive::BLOCK;
use colluvium_grid::Gathered;

use super::TwoPhase;
use crate::pore::{LIQUID, SOLID};
use crate::solver::MpmSolver;

impl<const D: usize> MpmSolver<D> {
    /// Shares the volumetric strains of the step, phase by phase, where the case asks for it.
    pub(super) fn share_phase_strains<const FROM_SOLVED: bool>(&mut self, phases: &TwoPhase, dt: f64) {
        if !self.strains.is_shared() {
            return;
        }
        self.share_strains(&|solver, set, block, out| {
            let (ground, points) = (solver.background.ground(), set.points().range(block));
            let mut all = [[Gathered::ZERO; 2]; BLOCK];
            let reads = &mut all[..points.len()];
            if FROM_SOLVED {
                solver.background.sweeps.gather_phases(&ground, &points, &phases.nodes, reads);
            } else {
                solver.background.sweeps.gather_velocities(&ground, &points, &phases.remapped, reads);
            }
            for ((out, read), position) in out.iter_mut().zip(&*reads).zip(points.position) {
                *out =
                    [SOLID, LIQUID].map(|phase| dt * solver.background.dilation(&read[phase], position[0]));
            }
        });
    }
}
