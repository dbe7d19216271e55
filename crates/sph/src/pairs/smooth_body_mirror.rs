//! Held smooth bodies: particles beside them slip freely along their surface (sheet: sph §2.13 b–c).
//!
//! For a particle `i` each of their particles `a` is as that of a smooth wall: with the particle's own stress and velocity mirrored in the
//! plane normal to the direction `n` of `Σ F x_ia`, from the particle to the body. The forces `(σ + H σ H) Σ F x_ia` with `H = 1 - 2 n ⊗ n`
//! then have a resultant along `n`: no force acts along the surface, whatever its shape, and the result is independent of rotation. Their
//! power is that of the stress on the contribution of the mirrored velocities to the velocity gradient.

use std::ops::Range;

use colluvium_constitutive::SymTensor;

use crate::pairs::operators::GradientMoment;
use crate::pairs::wall_mirror::MirrorState;
use crate::pairs::{MomentumForm, PairContext, PairSums};
use crate::points::particles::SquareMatrix;
use crate::points::vector_algebra::separation;

/// Smooth body next to a particle: direction into the body, and its particles among the neighbours.
struct FrictionlessBodyFace<'a, const D: usize> {
    normal: [f64; D],
    nearby_particles: [&'a [u32]; 2],
}

impl<const D: usize> FrictionlessBodyFace<'_, D> {
    /// Indices of the particles near the face.
    fn nearby_particles(&self) -> impl Iterator<Item = usize> {
        self.nearby_particles.iter().copied().flatten().map(|&a| a as usize)
    }
}

/// Reflected stress `H σ H` with `H = 1 - 2 n ⊗ n`.
pub(crate) fn reflected_stress<const D: usize>(stress: &SymTensor, n: &[f64; D]) -> SymTensor {
    let n: [f64; 3] = std::array::from_fn(|c| n.get(c).copied().unwrap_or(0.0));
    let t = stress.apply(n);
    let across: f64 = (0..3).map(|c| t[c] * n[c]).sum();
    let change = |a: usize, b: usize| 4.0 * across * n[a] * n[b] - 2.0 * (n[a] * t[b] + t[a] * n[b]);
    let [xx, yy, zz, xy, yz, zx] = stress.0;
    SymTensor([
        xx + change(0, 0),
        yy + change(1, 1),
        zz + change(2, 2),
        xy + change(0, 1),
        yz + change(1, 2),
        zx + change(2, 0),
    ])
}

impl<const D: usize> PairContext<'_, D> {
    /// Smooth bodies close to particle `i`, without the one to which it belongs.
    fn faces<'r>(&'r self, i: usize, row: &'r [u32]) -> impl Iterator<Item = FrictionlessBodyFace<'r, D>> {
        let outside = self
            .walls
            .smooth_bodies
            .ranges_of_bodies
            .iter()
            .filter(move |place| !place.body_particles.contains(&i));
        outside.filter_map(move |place| {
            let part = |range: &Range<usize>| {
                &row[self.neighbours_before(row, range.start)..self.neighbours_before(row, range.end)]
            };
            let mut face = FrictionlessBodyFace {
                normal: [0.0; D],
                nearby_particles: [part(&place.body_particles), part(&place.images)],
            };
            let (p, kernel) = (self.particles, self.kernel_of(self.particles.length[i]));
            let mut sum = [0.0; D];
            for a in face.nearby_particles() {
                let (apart, square) = separation(&p.position[i], &p.position[a]);
                let weight = kernel.gradient_factor(square.sqrt());
                (0..D).for_each(|c| sum[c] += weight * apart[c]);
            }
            let size = sum.iter().map(|c| c * c).sum::<f64>().sqrt();
            face.normal = sum.map(|c| c / size);
            (size > 0.0).then_some(face)
        })
    }
}

impl<const D: usize> PairSums<'_, D> {
    /// Mirrored state of particle `a` of a smooth body.
    fn smooth_mirror_state(&self, i: usize, a: usize, normal: &[f64; D]) -> MirrorState<D> {
        let p = self.particles;
        let closing: f64 = (0..D).map(|c| normal[c] * (p.velocity[i][c] - p.velocity[a][c])).sum();
        MirrorState {
            relative: normal.map(|n| -2.0 * closing * n),
            stress: reflected_stress(&p.stress[i], normal),
            repulsion: self
                .pair_data()
                .repulsion
                .get(i)
                .map_or(SymTensor::ZERO, |own| reflected_stress(own, normal)),
            slip_friction: None,
        }
    }

    /// Adds the acceleration by the smooth bodies. Not inlined, for the speed of sums without them.
    #[inline(never)]
    pub(crate) fn smooth_acceleration(&self, i: usize, row: &[u32], form: MomentumForm, sum: &mut [f64; D]) {
        for face in self.faces(i, row) {
            self.mirror_acceleration(
                i,
                self.separations(i, face.nearby_particles()),
                form,
                |a| Some(self.smooth_mirror_state(i, a, &face.normal)),
                sum,
            );
        }
    }

    /// Adds the mirrored states of smooth bodies to the velocity gradient, the divergence and the moment.
    #[inline(never)]
    pub(crate) fn add_smooth_gradient(
        &self,
        i: usize,
        row: &[u32],
        (gradient, trace, moment): (&mut SquareMatrix<D>, &mut f64, &mut GradientMoment<D>),
    ) {
        for face in self.faces(i, row) {
            let answer = |a| Some(self.smooth_mirror_state(i, a, &face.normal));
            self.add_mirror_gradient(
                i,
                self.separations(i, face.nearby_particles()),
                answer,
                (&mut *gradient, &mut *trace, &mut *moment),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirrored_stress_has_no_shear_beside_its_own() {
        let stress = SymTensor([3.0, -1.0, 2.0, 0.7, -0.4, 0.9]);
        let n = [0.6, 0.48, 0.64];
        let mirrored = reflected_stress(&stress, &n);
        assert!((mirrored.trace() - stress.trace()).abs() < 1e-12);
        let (traction, own) = ((stress + mirrored).apply(n), stress.apply(n));
        let across: f64 = (0..3).map(|c| own[c] * n[c]).sum();
        for c in 0..3 {
            assert!((traction[c] - 2.0 * across * n[c]).abs() < 1e-12, "{traction:?}");
        }
        let twice = reflected_stress(&mirrored, &n);
        assert!((twice - stress).norm() < 1e-12);
        let flat = reflected_stress(&SymTensor([3.0, -1.0, 2.0, 0.7, 0.0, 0.0]), &[1.0, 0.0]);
        assert_eq!(flat, SymTensor([3.0, -1.0, 2.0, -0.7, 0.0, 0.0]));
    }
}
