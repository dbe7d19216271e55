//! Obstacles answer to each particle as walls of particles do, along any normal (sheet: sph §2.13 b–d, f).

use colluvium_constitutive::SymTensor;

use super::answer::{Answer, MOST_OPPOSED, Rub, STOPPED};
use super::smooth::reflected;
use super::{Form, Sums};
use crate::algebra::dot;
use crate::config::WallVelocity;
use crate::operators::Moment;
use crate::particles::Matrix;
use crate::walls::{Contact, Face, Site, sites};

/// The stress whose mean with `stress` has the shear traction `wanted`, in place of `own`, on faces of the normal `n`.
fn rubbed<const D: usize>(stress: &SymTensor, n: &[f64; D], own: &[f64; D], wanted: &[f64; D]) -> SymTensor {
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

/// Traction of a stress on faces of the normal `n`: across (tension positive), and the vector along (Pa).
fn tractions<const D: usize>(stress: &SymTensor, n: &[f64; D]) -> (f64, [f64; D]) {
    let whole: [f64; D] = std::array::from_fn(|a| (0..D).map(|b| stress.at(a, b) * n[b]).sum());
    let across = dot(&whole, n);
    (across, std::array::from_fn(|c| whole[c] - across * n[c]))
}

impl<const D: usize> Sums<'_, D> {
    /// What the place `site` behind a face answers to particle `i`; `None` where the material lifts off. An obstacle that moves
    /// answers as one at rest does, seen from it; between the two places its velocity differs by its rotation.
    fn answer_behind(&self, i: usize, site: &Site<'_, D>) -> Option<Answer<D>> {
        let mut answer = self.answer_seen(i, site)?;
        if let Some(turning) = self.walls.obstacles.turning(site.face.obstacle, &site.apart) {
            (0..D).for_each(|c| answer.relative[c] += turning[c]);
        }
        Some(answer)
    }

    /// The same with velocities as they are seen from the obstacle.
    fn answer_seen(&self, i: usize, site: &Site<'_, D>) -> Option<Answer<D>> {
        let p = self.particles;
        let Face { normal: n, distance, contact, adhesion, lets_go, course, .. } = site.face;
        let stress = p.stress[i];
        let repulsion = self.shown().repulsion.get(i).copied().unwrap_or(SymTensor::ZERO);
        let (across, shear) = tractions(&stress, n);
        if *lets_go && across > 0.0 {
            return None;
        }
        let own: [f64; D] = std::array::from_fn(|c| p.velocity[i][c] - course[c]);
        let closing = dot(&own, n);
        let slip: [f64; D] = std::array::from_fn(|c| own[c] - closing * n[c]);
        let along = |keep: f64| -> [f64; D] {
            std::array::from_fn(|c| -2.0 * closing * n[c] + (keep - 1.0) * slip[c])
        };
        let with = |traction: &[f64; D]| rubbed(&stress, n, &shear, traction);
        match contact {
            Contact::NoSlip => {
                let opposed = match self.options.wall_velocity {
                    WallVelocity::Mirrored => 1.0,
                    WallVelocity::Linear => {
                        (site.depth / distance.max(1e-3 * self.options.spacing)).min(MOST_OPPOSED)
                    }
                };
                Some(Answer { relative: own.map(|v| -v * (1.0 + opposed)), stress, repulsion, rub: None })
            }
            Contact::FreeSlip => Some(Answer {
                relative: along(1.0),
                stress: reflected(&stress, n),
                repulsion: reflected(&repulsion, n),
                rub: None,
            }),
            Contact::Friction(coefficient) => {
                let most = adhesion - coefficient * across;
                let (speed, size) = (dot(&slip, &slip).sqrt(), dot(&shear, &shear).sqrt());
                if speed > STOPPED * most / (p.density[i] * p.sound[i]) {
                    let rubs = adhesion + coefficient * p.pressure_of_friction(i, -across);
                    let stress = with(&slip.map(|v| v * rubs / speed));
                    let rub = Rub { normal: *n, against: slip.map(|v| -coefficient * v / speed) };
                    return Some(Answer { relative: along(1.0), stress, repulsion, rub: Some(rub) });
                }
                if size <= most {
                    return Some(Answer { relative: along(-1.0), stress, repulsion, rub: None });
                }
                let stress = with(&shear.map(|s| s * most / size));
                Some(Answer { relative: along(1.0), stress, repulsion, rub: None })
            }
        }
    }

    /// Places behind the faces near particle `i`.
    fn sites(&self, i: usize) -> impl Iterator<Item = (Site<'_, D>, ([f64; D], f64))> {
        let reach = self.kernel_of(self.particles.length[i]).radius();
        sites(self.walls.obstacles.faces(i), self.options.spacing, reach)
    }

    /// Acceleration by the obstacles. Not inlined, for the sums without them.
    #[inline(never)]
    pub(crate) fn push_off_obstacles(&self, i: usize, form: Form, sum: &mut [f64; D]) {
        self.push_off(i, self.sites(i), form, |site| self.answer_behind(i, &site), sum);
        if self.options.wall_guard > 0.0 {
            self.guard(i, self.sites(i).map(|(_, apart)| apart), sum);
        }
    }

    /// What of that obstacle number `obstacle` does.
    pub(crate) fn push_off_obstacle(&self, i: usize, obstacle: u32) -> [f64; D] {
        let own = || self.sites(i).filter(|(site, _)| site.face.obstacle == obstacle);
        let mut sum = [0.0; D];
        self.push_off(
            i,
            own(),
            Form::of(self.options.momentum),
            |site| self.answer_behind(i, &site),
            &mut sum,
        );
        if self.options.wall_guard > 0.0 {
            self.guard(i, own().map(|(_, apart)| apart), &mut sum);
        }
        sum
    }

    /// What obstacles add to the velocity gradient, the divergence and the moment.
    #[inline(never)]
    pub(crate) fn strain_at_obstacles(&self, i: usize, sums: (&mut Matrix<D>, &mut f64, &mut Moment<D>)) {
        self.strain_at(i, self.sites(i), |site| self.answer_behind(i, &site), sums);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_that_rubs_takes_the_traction_that_it_is_given_and_no_other() {
        let stress = SymTensor([-3.0, -1.0, -2.0, 0.7, -0.4, 0.9]);
        let n = [0.6, 0.48, 0.64];
        let (across, shear) = tractions(&stress, &n);
        assert!((dot(&shear, &n)).abs() < 1e-12);
        let wanted = shear.map(|s| 0.3 * s);
        let mean = (stress + rubbed(&stress, &n, &shear, &wanted)) * 0.5;
        let (normal, along) = tractions(&mean, &n);
        assert!((normal - across).abs() < 1e-12);
        for c in 0..3 {
            assert!((along[c] - wanted[c]).abs() < 1e-12);
        }
        // Without any shear it is the mirrored stress.
        let smooth = rubbed(&stress, &n, &shear, &[0.0; 3]);
        assert!((smooth - reflected(&stress, &n)).norm() < 1e-12);
    }
}
