//! Mirrored states of obstacles for each particle, along any normal (sheet: sph §2.13 b–d, f).

use colluvium_constitutive::SymTensor;

use crate::boundary::flat_wall::WallContact;
use crate::config::WallVelocity;
use crate::obstacles::obstacle_faces::{DummySite, ObstacleFace, dummy_sites};
use crate::pairs::operators::GradientMoment;
use crate::pairs::smooth_body_mirror::reflected_stress;
use crate::pairs::wall_mirror::{MAX_MIRROR_FACTOR, MirrorState, STICK_RATIO, SlipFriction};
use crate::pairs::{MomentumForm, PairSums};
use crate::points::particles::SquareMatrix;
use crate::points::vector_algebra::dot;

/// Stress whose mean with `stress` has the shear traction `wanted` in place of `own` on faces with the normal `n`.
fn with_shear_traction<const D: usize>(
    stress: &SymTensor,
    n: &[f64; D],
    own: &[f64; D],
    wanted: &[f64; D],
) -> SymTensor {
    let at = |vector: &[f64; D], c: usize| vector.get(c).copied().unwrap_or(0.0);
    let change = |a: usize, b: usize| {
        let more = |c: usize| at(wanted, c) - at(own, c);
        2.0 * (more(a) * at(n, b) + more(b) * at(n, a))
    };
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

/// Normal traction (tension positive) and shear traction vector of a stress on faces with the normal `n` (Pa).
fn face_tractions<const D: usize>(stress: &SymTensor, n: &[f64; D]) -> (f64, [f64; D]) {
    let whole: [f64; D] = std::array::from_fn(|a| (0..D).map(|b| stress.component(a, b) * n[b]).sum());
    let across = dot(&whole, n);
    (across, std::array::from_fn(|c| whole[c] - across * n[c]))
}

impl<const D: usize> PairSums<'_, D> {
    /// Mirrored state of the dummy site `site` for particle `i`; `None` where the material separates. For a moving obstacle the state is
    /// that in its frame; between the two positions its velocity differs by its rotation.
    fn obstacle_mirror_state(&self, i: usize, site: &DummySite<'_, D>) -> Option<MirrorState<D>> {
        let mut answer = self.obstacle_mirror_state_relative(i, site)?;
        if let Some(turning) = self.walls.obstacles.rotational_velocity(site.face.obstacle, &site.separation)
        {
            (0..D).for_each(|c| answer.relative[c] += turning[c]);
        }
        Some(answer)
    }

    /// Mirrored state with velocities relative to the obstacle.
    fn obstacle_mirror_state_relative(&self, i: usize, site: &DummySite<'_, D>) -> Option<MirrorState<D>> {
        let p = self.particles;
        let ObstacleFace {
            normal: n, distance, contact, adhesion, allows_separation, velocity: course, ..
        } = site.face;
        let stress = p.stress[i];
        let repulsion = self.pair_data().repulsion.get(i).copied().unwrap_or(SymTensor::ZERO);
        let (across, shear) = face_tractions(&stress, n);
        if *allows_separation && across > 0.0 {
            return None;
        }
        let own: [f64; D] = std::array::from_fn(|c| p.velocity[i][c] - course[c]);
        let closing = dot(&own, n);
        let slip: [f64; D] = std::array::from_fn(|c| own[c] - closing * n[c]);
        let along = |keep: f64| -> [f64; D] {
            std::array::from_fn(|c| -2.0 * closing * n[c] + (keep - 1.0) * slip[c])
        };
        let with = |traction: &[f64; D]| with_shear_traction(&stress, n, &shear, traction);
        match contact {
            WallContact::NoSlip => {
                let opposed = match self.options.wall_velocity {
                    WallVelocity::Mirrored => 1.0,
                    WallVelocity::Linear => {
                        (site.depth / distance.max(1e-3 * self.options.spacing)).min(MAX_MIRROR_FACTOR)
                    }
                };
                Some(MirrorState::new(own.map(|v| -v * (1.0 + opposed)), stress, repulsion))
            }
            WallContact::FreeSlip => {
                let (stress, repulsion) = (reflected_stress(&stress, n), reflected_stress(&repulsion, n));
                Some(MirrorState::new(along(1.0), stress, repulsion))
            }
            WallContact::Friction(coefficient) => {
                let largest = adhesion - coefficient * across;
                let (speed, size) = (dot(&slip, &slip).sqrt(), dot(&shear, &shear).sqrt());
                if speed > STICK_RATIO * largest / (p.density[i] * p.sound[i]) {
                    let rubs = adhesion + coefficient * p.friction_pressure(i, -across);
                    let stress = with(&slip.map(|v| v * rubs / speed));
                    let rub = SlipFriction { normal: *n, direction: slip.map(|v| -coefficient * v / speed) };
                    let sliding = MirrorState::new(along(1.0), stress, repulsion);
                    return Some(MirrorState { slip_friction: Some(rub), ..sliding });
                }
                if size <= largest {
                    return Some(MirrorState::new(along(-1.0), stress, repulsion));
                }
                Some(MirrorState::new(along(1.0), with(&shear.map(|s| s * largest / size)), repulsion))
            }
        }
    }

    /// Dummy positions behind the faces close to particle `i`.
    fn dummy_sites(&self, i: usize) -> impl Iterator<Item = (DummySite<'_, D>, ([f64; D], f64))> {
        let reach = self.kernel_of(self.particles.length[i]).radius();
        dummy_sites(self.walls.obstacles.faces(i), self.options.spacing, reach)
    }

    /// Adds the acceleration by the obstacles. Not inlined, for the speed of sums without obstacles.
    #[inline(never)]
    pub(crate) fn obstacle_acceleration(&self, i: usize, form: MomentumForm, sum: &mut [f64; D]) {
        self.mirror_acceleration(
            i,
            self.dummy_sites(i),
            form,
            |site| self.obstacle_mirror_state(i, &site),
            sum,
        );
        if self.options.wall_guard > 0.0 {
            self.repulsion_of(i, self.dummy_sites(i).map(|(_, apart)| apart), sum);
        }
    }

    /// Acceleration by obstacle `obstacle` (m/s²).
    pub(crate) fn acceleration_by_obstacle(&self, i: usize, obstacle: u32) -> [f64; D] {
        let own = || self.dummy_sites(i).filter(|(site, _)| site.face.obstacle == obstacle);
        let mut sum = [0.0; D];
        self.mirror_acceleration(
            i,
            own(),
            MomentumForm::of_equation(self.options.momentum),
            |site| self.obstacle_mirror_state(i, &site),
            &mut sum,
        );
        if self.options.wall_guard > 0.0 {
            self.repulsion_of(i, own().map(|(_, apart)| apart), &mut sum);
        }
        sum
    }

    /// Adds the mirrored states of obstacles to the velocity gradient, the divergence and the moment.
    #[inline(never)]
    pub(crate) fn add_obstacle_gradient(
        &self,
        i: usize,
        sums: (&mut SquareMatrix<D>, &mut f64, &mut GradientMoment<D>),
    ) {
        self.add_mirror_gradient(i, self.dummy_sites(i), |site| self.obstacle_mirror_state(i, &site), sums);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frictional_mirror_has_the_prescribed_shear_traction() {
        let stress = SymTensor([-3.0, -1.0, -2.0, 0.7, -0.4, 0.9]);
        let n = [0.6, 0.48, 0.64];
        let (across, shear) = face_tractions(&stress, &n);
        assert!((dot(&shear, &n)).abs() < 1e-12);
        let wanted = shear.map(|s| 0.3 * s);
        let mean = (stress + with_shear_traction(&stress, &n, &shear, &wanted)) * 0.5;
        let (normal, along) = face_tractions(&mean, &n);
        assert!((normal - across).abs() < 1e-12);
        for c in 0..3 {
            assert!((along[c] - wanted[c]).abs() < 1e-12);
        }
        // Without shear it is the mirrored stress.
        let smooth = with_shear_traction(&stress, &n, &shear, &[0.0; 3]);
        assert!((smooth - reflected_stress(&stress, &n)).norm() < 1e-12);
    }
}
