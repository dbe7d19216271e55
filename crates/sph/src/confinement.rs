//! Flexible confining pressure (SPH sheet §2.13 g; Bui & Nguyen 2021, eqs. 123–129): `2 p_c/ρ_i Σ V_j ∇W` vanishes
//! within a body and pushes inwards at its surface.

use rayon::prelude::*;

use crate::config::Confined;
use crate::pairs::Pairs;
use crate::solver::{SphSolver, TASK, square};

/// `Σ_{j≠i} V_j W` up to which a particle lies at the surface, in 1, 2 and 3 dimensions (BN 129; on a line that of
/// the sheet's rule: between the first layer and the rest).
const SURFACE: [f64; 3] = [0.35, 0.55, 0.70];

/// What the pressure needs of a particle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inward<const D: usize> {
    /// `Σ V_j ∇W` (1/m).
    pub direction: [f64; D],
    /// `Σ_{j≠i} V_j W`.
    pub index: f64,
}

impl<const D: usize> Default for Inward<D> {
    fn default() -> Self {
        Self { direction: [0.0; D], index: 0.0 }
    }
}

impl<const D: usize> Pairs<'_, D> {
    /// Direction and index of the surface at particle `i`; walls count as what they touch.
    fn inward(&self, i: usize, row: &[u32]) -> Inward<D> {
        let p = self.particles;
        let mut inward = Inward::default();
        for &j in row {
            let j = j as usize;
            let k = if j >= self.answering { i } else { j };
            let apart: [f64; D] = std::array::from_fn(|c| p.position[j][c] - p.position[i][c]);
            let r = square(&apart).sqrt();
            let volume = p.mass[k] / p.density[k];
            inward.index += volume * self.smoothing.value(r);
            let weight = volume * self.smoothing.weight(r);
            (0..D).for_each(|c| inward.direction[c] += weight * apart[c]);
        }
        inward
    }
}

impl<const D: usize> SphSolver<D> {
    /// Whether the confining pressure has its full size.
    pub(crate) fn is_confined(&self) -> bool {
        self.options.confining.as_ref().is_none_or(|confining| self.time >= confining.ramp)
    }

    /// Adds the confining pressure at the end of a step of `dt` to the accelerations.
    pub(crate) fn confine(&mut self, dt: f64) {
        let Some(confining) = &self.options.confining else { return };
        let ramp = confining.ramp;
        let grown = if ramp > 0.0 { ((self.time + dt) / ramp).min(1.0) } else { 1.0 };
        let pressure = 2.0 * grown * confining.pressure;
        let everywhere = confining.on == Confined::All;
        let mut inward = std::mem::take(&mut self.inward);
        inward.resize(self.particles.len, Inward::default());
        let mut accelerations = std::mem::take(&mut self.particles.acceleration);
        let pairs = self.pairs();
        let (p, neighbours) = (&self.particles, &self.neighbours);
        let all = inward.par_iter_mut().enumerate().with_min_len(TASK);
        all.for_each(|(i, slot)| *slot = pairs.inward(i, neighbours.of(i)));
        let near = 1.05 * self.options.spacing;
        // Also those beside the surface, which carry what is left of its force (sheet's proposal).
        let acts = |i: usize| {
            let of_surface = |j: usize| inward[j].index <= SURFACE[D - 1];
            everywhere
                || of_surface(i)
                || neighbours.of(i).iter().map(|&j| j as usize).filter(|&j| j < p.len).any(|j| {
                    let apart: [f64; D] = std::array::from_fn(|c| p.position[j][c] - p.position[i][c]);
                    of_surface(j) && square(&apart) <= near * near
                })
        };
        let mut pushes = std::mem::take(&mut self.pushes);
        pushes.clear();
        pushes.resize(p.len, [0.0; D]);
        for group in self.groups.iter().filter(|group| group.confined) {
            let range = group.range();
            let first = range.start;
            let pushed = accelerations[range.clone()].par_iter_mut().zip(&mut pushes[range]);
            pushed.enumerate().with_min_len(TASK).for_each(|(k, (a, push))| {
                let i = first + k;
                if acts(i) {
                    let scale = pressure / p.density[i];
                    *push = inward[i].direction.map(|d| scale * d);
                    (0..D).for_each(|c| a[c] += push[c]);
                }
            });
        }
        (self.inward, self.pushes, self.particles.acceleration) = (inward, pushes, accelerations);
    }
}
