//! Flexible confining pressure (sheet: sph §2.13 g; Bui & Nguyen 2021, eqs. 123–129): `2 p_c/ρ_i Σ V_j ∇W` vanishes
//! within a body and pushes inwards at its surface.

use rayon::prelude::*;

use crate::clock::Clock;
use crate::config::ConfiningPressureTarget;
use crate::context::SolverContext;
use crate::kernel::Smoothing;
use crate::neighbours::verlet_lists::VerletLists;
use crate::pairs::PairContext;
use crate::points::particles::{Bodies, Derivatives, MIN_PARTICLES_PER_TASK};
use crate::points::vector_algebra::{separation, square};
use crate::rates::Rates;
use crate::walls::Walls;

/// Largest surface index `Σ_{j≠i} V_j W` of a surface particle, in 1, 2 and 3 dimensions (BN 129; in 1D between the indices of the first
/// layer and of the others).
const SURFACE_INDEX: [f64; 3] = [0.35, 0.55, 0.70];

/// Surface index `Σ_{j≠i} V_j W` of a particle with `above` lattice layers above it.
fn lattice_index<const D: usize>(smoothing: &Smoothing<D>, spacing: f64, above: i32) -> f64 {
    let reach = (smoothing.radius() / spacing).ceil() as i32;
    let width = 2 * reach + 1;
    let place = |number: i32, c: usize| number / width.pow(c as u32) % width - reach;
    let all =
        (0..width.pow(D as u32)).map(|number| -> [i32; D] { std::array::from_fn(|c| place(number, c)) });
    let others = all.filter(|x| x[0] <= above && x.iter().any(|c| *c != 0));
    let apart = |x: [i32; D]| square(&x.map(f64::from)).sqrt() * spacing;
    spacing.powi(D as i32) * others.map(|x| smoothing.value(apart(x))).sum::<f64>()
}

/// Reason why surface particles can't be detected at the spacing `spacing` (m), if so (sheet: sph §2.13 g, §7).
pub(crate) fn surface_detection_problem<const D: usize>(
    smoothing: &Smoothing<D>,
    spacing: f64,
) -> Option<String> {
    let [first, within] = [0, i32::MAX].map(|above| lattice_index(smoothing, spacing, above));
    let largest = SURFACE_INDEX[D - 1];
    let ratio = smoothing.length() / spacing;
    (first > largest || within <= largest).then(|| {
        format!(
            "{ratio} does not allow confining to detect surfaces by Σ V W <= {largest} with this kernel: the sum \
             is {first:.3} in the first layer, {within:.3} inside. Choose another value, or confine on all"
        )
    })
}

impl<const D: usize> PairContext<'_, D> {
    /// Surface index `Σ_{j≠i} V_j W` and inward direction `Σ V_j ∇W` at particle `i` (1/m). Walls count as material of the particle.
    fn surface_index_and_normal(&self, i: usize, row: &[u32]) -> (f64, [f64; D]) {
        let p = self.particles;
        let (mut index, mut direction) = (0.0, [0.0; D]);
        for &j in row {
            let j = j as usize;
            let k = self.effective_index(i, j);
            let apart: [f64; D] = std::array::from_fn(|c| p.position[j][c] - p.position[i][c]);
            let r = square(&apart).sqrt();
            let volume = p.mass[k] / p.density[k];
            index += volume * self.smoothing.value(r);
            let weight = volume * self.smoothing.gradient_factor(r);
            (0..D).for_each(|c| direction[c] += weight * apart[c]);
        }
        (index, direction)
    }
}

/// Whether the confining pressure has its full magnitude.
pub(crate) fn is_confined<const D: usize>(setting: &SolverContext<D>, clock: &Clock) -> bool {
    setting.options.confining.as_ref().is_none_or(|confining| clock.time >= confining.ramp)
}

/// Adds the acceleration by the confining pressure at the end of a step of `dt` (s).
pub(crate) fn apply_confining_pressure<const D: usize>(
    setting: &SolverContext<D>,
    clock: &Clock,
    bodies: &Bodies<D>,
    walls: &Walls<D>,
    lists: &VerletLists<D>,
    rates: &mut Rates<D>,
    dt: f64,
) {
    let Some(confining) = &setting.options.confining else { return };
    let ramp = confining.ramp;
    let grown = if ramp > 0.0 { ((clock.time + dt) / ramp).min(1.0) } else { 1.0 };
    let pressure = 2.0 * grown * confining.pressure;
    let everywhere = confining.on == ConfiningPressureTarget::All;
    let (p, neighbours) = (&bodies.particles, &lists.neighbours);
    let Rates {
        derivatives: Derivatives { acceleration, .. },
        surface_index: crowding,
        external_accelerations: pushes,
        ..
    } = rates;
    crowding.resize(p.len(), 0.0);
    pushes.resize(p.len(), [0.0; D]);
    let pairs = PairContext::new(setting, p, walls);
    let all = crowding.par_iter_mut().zip(&mut *pushes).enumerate();
    all.with_min_len(MIN_PARTICLES_PER_TASK).for_each(|(i, (index, push))| {
        (*index, *push) = pairs.surface_index_and_normal(i, neighbours.neighbours(i));
    });
    let near = 1.05 * setting.options.spacing;
    // Particles beside the surface are included (sheet's proposal), as they take the rest of its force, across periodic boundaries too. For
    // an image in a mirror the particle itself is on this side, and nearer.
    let acts = |i: usize| {
        let of_surface = |j: usize| crowding[j] <= SURFACE_INDEX[D - 1];
        everywhere
            || of_surface(i)
            || neighbours.neighbours(i).iter().map(|&j| j as usize).any(|j| {
                separation(&p.position[i], &p.position[j]).1 <= near * near
                    && walls.particle_of(p.len(), j).is_some_and(of_surface)
            })
    };
    for group in &bodies.groups {
        let range = group.range();
        let first = range.start;
        let pushed = acceleration[range.clone()].par_iter_mut().zip(&mut pushes[range]);
        pushed.enumerate().with_min_len(MIN_PARTICLES_PER_TASK).for_each(|(k, (a, push))| {
            let i = first + k;
            let scale = if group.is_confined && acts(i) { pressure / p.density[i] } else { 0.0 };
            *push = push.map(|direction| scale * direction);
            (0..D).for_each(|c| a[c] += push[c]);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::Kernel;

    fn identifies_surface<const D: usize>(kernel: Kernel, ratio: f64) -> bool {
        surface_detection_problem(&Smoothing::<D>::new(kernel, ratio).unwrap(), 1.0).is_none()
    }

    #[test]
    fn surface_particles_are_identified_for_the_kernels_and_ratios_of_the_sheet() {
        use Kernel::{CubicSpline, WendlandC2, WendlandC4, WendlandC6};
        for ratio in [1.2, 1.3, 1.5] {
            assert!(
                identifies_surface::<1>(CubicSpline, ratio) && identifies_surface::<2>(CubicSpline, ratio)
            );
            assert!(identifies_surface::<3>(CubicSpline, ratio));
        }
        for ratio in [1.2, 1.5] {
            assert!(identifies_surface::<2>(WendlandC2, ratio) && identifies_surface::<3>(WendlandC2, ratio));
        }
        for (kernel, ratio) in [(CubicSpline, 1.0), (WendlandC2, 1.0), (WendlandC4, 1.2), (WendlandC6, 1.2)] {
            assert!(!identifies_surface::<2>(kernel, ratio), "{kernel:?} {ratio}");
        }
    }

    /// Indices of layer 1, layer 2 and the interior.
    #[test]
    fn indices_of_layers_are_those_of_the_sheet() {
        fn of_layers<const D: usize>(kernel: Kernel, ratio: f64) -> [f64; 3] {
            let smoothing = Smoothing::<D>::new(kernel, ratio).unwrap();
            [0, 1, i32::MAX].map(|above| lattice_index(&smoothing, 1.0, above))
        }
        let (cubic, wendland) = (Kernel::CubicSpline, Kernel::WendlandC2);
        for (found, sheet) in [
            (of_layers::<2>(cubic, 1.2), [0.469, 0.681, 0.684]),
            (of_layers::<2>(cubic, 1.3), [0.494, 0.721, 0.731]),
            (of_layers::<2>(cubic, 1.5), [0.528, 0.773, 0.801]),
            (of_layers::<3>(cubic, 1.2), [0.608, 0.814, 0.817]),
            (of_layers::<3>(cubic, 1.5), [0.641, 0.883, 0.907]),
            (of_layers::<2>(wendland, 1.2), [0.436, 0.630, 0.631]),
            (of_layers::<2>(wendland, 1.5), [0.504, 0.738, 0.758]),
        ] {
            for (index, sheet) in found.iter().zip(sheet) {
                assert!((index - sheet).abs() <= 0.00051, "{found:?} {sheet}");
            }
        }
    }
}
