//! Volumetric strain of both phases, shared within cells (sheet: mpm §2.17).

use colluvium_constitutive::BLOCK;
use colluvium_grid::Gathered;

use super::TwoPhase;
use crate::background::Background;
use crate::bodies::Bodies;
use crate::clock::Clock;
use crate::nodes::Velocities;
use crate::pore::{LIQUID, SOLID};
use crate::strain::{CellStrains, share_strains};

/// Shares the volumetric strains of the step, phase by phase, where the case asks for it.
pub(super) fn share_phase_strains<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &Bodies<D>,
    strains: &mut CellStrains,
    (phases, read): (&TwoPhase, Velocities),
) {
    share_strains(background, bodies, strains, &|set, block, out| {
        let points = set.places().range(block);
        let mut all = [[Gathered::ZERO; 2]; BLOCK];
        let reads = &mut all[..points.len()];
        phases.gather(read, background, &points, reads);
        for ((out, read), position) in out.iter_mut().zip(&*reads).zip(points.position) {
            *out = [SOLID, LIQUID].map(|phase| clock.dt * background.dilation(&read[phase], position[0]));
        }
    });
}
