//! Averages of the volumetric strain of both phases within cells (sheet: mpm §2.17).

use colluvium_constitutive::BLOCK_SIZE;
use colluvium_grid::InterpolatedMotion;

use crate::background_grid::BackgroundGrid;
use crate::clock::Clock;
use crate::momentum::velocity_fields::VelocitySource;
use crate::phases::TwoPhase;
use crate::points::bodies::Bodies;
use crate::points::pore_fluid::{LIQUID, SOLID};
use crate::stress::volumetric_strain::{CellStrains, average_strains};

/// Averages the volumetric strain increments of each phase, if the options require it.
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
