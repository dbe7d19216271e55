//! Volumetric strain of both phases, shared within cells (sheet: mpm §2.17).

use colluvium_constitutive::BLOCK_SIZE;
use colluvium_grid::InterpolatedMotion;

use super::TwoPhase;
use crate::background::BackgroundGrid;
use crate::bodies::Bodies;
use crate::clock::Clock;
use crate::nodes::VelocitySource;
use crate::pore::{LIQUID, SOLID};
use crate::strain::{CellStrains, average_strains};

/// Shares the volumetric strains of the step, phase by phase, where the case asks for it.
pub(super) fn average_phase_strains<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    strains: &mut CellStrains,
    (phases, read): (&TwoPhase, VelocitySource),
) {
    average_strains(background, bodies, strains, &|set, block, out| {
        let points = set.point_slice().range(block);
        let mut all = [[InterpolatedMotion::ZERO; 2]; BLOCK_SIZE];
        let reads = &mut all[..points.len()];
        phases.g2p(read, background, &points, reads);
        for ((out, read), position) in out.iter_mut().zip(&*reads).zip(points.position) {
            *out = [SOLID, LIQUID].map(|phase| clock.dt * background.dilation(&read[phase], position[0]));
        }
    });
}
