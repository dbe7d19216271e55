//! Walls of particles that answer to each particle with what it is itself (sheet: sph §2.13 b–d, f).

use colluvium_constitutive::SymTensor;

use super::{Form, Pairs, SOFTENING, Sums};
use crate::algebra::{apart, sheared};
use crate::config::WallVelocity;
use crate::operators::{Moment, product};
use crate::particles::Matrix;
use crate::walls::{Contact, Plane};

/// Most of the particle's own velocity that a wall opposes, `β_max - 1` (Morris et al. 1997).
pub(super) const MOST_OPPOSED: f64 = 0.5;
/// Reach of the guard, in spacings: particles of the wall start half a spacing behind its face.
const GUARD_REACH: f64 = 0.5;
/// Closer than this share of its reach the guard grows no further.
const GUARD_CORE: f64 = 0.6;

/// Below this share of `μ σ_n / (ρ c)` slip counts as none: friction stops it within a step or so.
pub(super) const STOPPED: f64 = 0.25;

/// What a wall opposes to a particle.
pub(super) struct Answer<const D: usize> {
    /// Velocity of the wall's particle less the particle's own (m/s).
    pub relative: [f64; D],
    /// Stress of the wall's particle (Pa).
    pub stress: SymTensor,
    /// Its artificial stress over density squared.
    pub repulsion: SymTensor,
    /// How it rubs beyond its stress; `None` where it does not, or holds.
    pub rub: Option<Rub<D>>,
}

/// Friction of what slips: viscosity pushes off a wall too, and what it bears rubs as the stress does.
pub(super) struct Rub<const D: usize> {
    /// Unit normal of the wall.
    pub normal: [f64; D],
    /// Against the slip, of the size of the coefficient of friction.
    pub against: [f64; D],
}

impl<const D: usize> Sums<'_, D> {
    /// The answer of the particle `wall` of a wall to `i`; `None` where the material lifts off.
    fn answer(&self, i: usize, wall: usize) -> Option<Answer<D>> {
        let p = self.particles;
        let number = self.walls.planes.face_of[wall - self.first_wall] as usize;
        let plane = &self.walls.planes.faces[number];
        let (stress, axis) = (p.stress[i], plane.axis);
        let repulsion = self.shown().repulsion.get(i).copied().unwrap_or(SymTensor::ZERO);
        // Towards the wall's own motion.
        let pace = plane.pace();
        let own: [f64; D] = std::array::from_fn(|c| p.velocity[i][c] - pace[c]);
        let along = |keep: f64| -> [f64; D] {
            std::array::from_fn(|c| own[c] * if c == axis { -2.0 } else { keep - 1.0 })
        };
        match plane.contact {
            Contact::NoSlip => {
                let opposed = match self.options.wall_velocity {
                    WallVelocity::Mirrored => 1.0,
                    WallVelocity::Linear => {
                        let near = plane.distance(&p.position[i]).max(1e-3 * self.options.spacing);
                        (-plane.distance(&p.position[wall]) / near).min(MOST_OPPOSED)
                    }
                };
                Some(Answer { relative: own.map(|v| -v * (1.0 + opposed)), stress, repulsion, rub: None })
            }
            Contact::FreeSlip => Some(Answer {
                relative: along(1.0),
                stress: sheared(&stress, axis, -1.0),
                repulsion: sheared(&repulsion, axis, -1.0),
                rub: None,
            }),
            Contact::Friction(coefficient) => {
                let (normal, shear) = tractions(&stress, plane);
                if normal > 0.0 {
                    return None;
                }
                let most = -coefficient * normal;
                let speed: f64 = (0..D).filter(|&c| c != axis).map(|c| own[c] * own[c]).sum::<f64>().sqrt();
                if speed > STOPPED * most / (p.density[i] * p.sound[i]) {
                    let rubs = coefficient * p.pressure_of_friction(i, -normal);
                    let factor = rubs / speed * if plane.upper { -1.0 } else { 1.0 };
                    let normal = std::array::from_fn(|c| f64::from(u8::from(c == axis)));
                    let against =
                        std::array::from_fn(|c| if c == axis { 0.0 } else { -coefficient * own[c] / speed });
                    return Some(Answer {
                        relative: along(1.0),
                        stress: rubbed::<D>(&stress, axis, |c| factor * own[c]),
                        repulsion,
                        rub: Some(Rub { normal, against }),
                    });
                }
                if shear <= most {
                    return Some(Answer { relative: along(-1.0), stress, repulsion, rub: None });
                }
                let stress = rubbed::<D>(&stress, axis, |c| stress.at(axis, c) * most / shear);
                Some(Answer { relative: along(1.0), stress, repulsion, rub: None })
            }
        }
    }

    /// Acceleration by the walls that answer.
    pub(crate) fn push_off_walls(&self, i: usize, row: &[u32], form: Form, sum: &mut [f64; D]) {
        let near = row.iter().map(|&wall| wall as usize);
        self.push_off(i, self.apart_from(i, near), form, |wall| self.answer(i, wall), sum);
    }

    /// The particles `near`, each with its place less that of `i` (m) and the square of their distance.
    #[inline]
    pub(super) fn apart_from(
        &self,
        i: usize,
        near: impl Iterator<Item = usize>,
    ) -> impl Iterator<Item = (usize, ([f64; D], f64))> {
        let positions = &self.particles.position;
        near.map(move |wall| (wall, apart(&positions[i], &positions[wall])))
    }

    /// Acceleration by what is `near`, which answers.
    #[inline]
    pub(super) fn push_off<T>(
        &self,
        i: usize,
        near: impl Iterator<Item = (T, ([f64; D], f64))>,
        form: Form,
        answer: impl Fn(T) -> Option<Answer<D>>,
        sum: &mut [f64; D],
    ) {
        let p = self.particles;
        let (mass, density, sound) = (p.mass[i], p.density[i], p.sound[i]);
        let shown = self.shown();
        let kernel = self.kernel_of(p.length[i]);
        let h = kernel.length();
        let scale = Pairs::<D>::flux_scale(self.options.momentum, density, shown.spread[i]);
        let scale = if form.by_both { scale / (density * density) } else { scale };
        for (wall, (apart, square)) in near {
            let r = square.sqrt();
            let weight = kernel.weight(r);
            if weight == 0.0 {
                continue;
            }
            let Some(answer) = answer(wall) else { continue };
            let mut pair = (p.stress[i] * form.own + answer.stress) * scale;
            if let Some(repulsion) = self.repulsion().filter(|_| !shown.repulsion.is_empty()) {
                let factor = (self.rescaled_alone(h, r) * repulsion.scale).powf(repulsion.exponent);
                pair += (shown.repulsion[i] + answer.repulsion) * factor;
            }
            let closing = (0..D).map(|c| answer.relative[c] * apart[c]).sum::<f64>().min(0.0);
            let pi = h * closing / (square + SOFTENING * h * h);
            let (linear, quadratic) = (self.options.viscosity_linear, self.options.viscosity_quadratic);
            let viscosity = (linear * sound * pi - quadratic * pi * pi) / density;
            // Where the gradient is corrected its partner is too.
            let turned = shown.correction.get(i).map_or(apart, |l| product(l, &apart));
            for a in 0..D {
                let pull: f64 = (0..D).map(|b| pair.at(a, b) * turned[b]).sum();
                sum[a] += mass * weight * (pull + viscosity * apart[a]);
            }
            if let Some(Rub { normal, against }) = &answer.rub {
                let across: f64 = (0..D).map(|c| apart[c] * normal[c]).sum();
                let push = (mass * weight * viscosity * across).abs();
                (0..D).for_each(|c| sum[c] += push * against[c]);
            }
        }
    }

    /// What walls that answer add to the velocity gradient, the divergence and the moment.
    pub(crate) fn strain_at_walls(
        &self,
        i: usize,
        row: &[u32],
        sums: (&mut Matrix<D>, &mut f64, &mut Moment<D>),
    ) {
        let near = row.iter().map(|&wall| wall as usize);
        self.strain_at(i, self.apart_from(i, near), |wall| self.answer(i, wall), sums);
    }

    /// What is `near`, and answers, adds to the velocity gradient, the divergence and the moment.
    #[inline]
    pub(super) fn strain_at<T>(
        &self,
        i: usize,
        near: impl Iterator<Item = (T, ([f64; D], f64))>,
        answer: impl Fn(T) -> Option<Answer<D>>,
        (gradient, trace, moment): (&mut Matrix<D>, &mut f64, &mut Moment<D>),
    ) {
        let p = self.particles;
        let kernel = self.kernel_of(p.length[i]);
        let volume = p.mass[i] / p.density[i];
        for (wall, (apart, square)) in near {
            let weight = volume * kernel.weight(square.sqrt());
            if weight == 0.0 {
                continue;
            }
            let Some(answer) = answer(wall) else { continue };
            moment.add(weight, &apart);
            for a in 0..D {
                *trace += weight * answer.relative[a] * apart[a];
                for b in 0..D {
                    gradient[a][b] += weight * answer.relative[a] * apart[b];
                }
            }
        }
    }

    /// Repulsion off particles of walls that are too close (sheet: sph §2.13 d).
    pub(crate) fn guard_walls(&self, i: usize, row: &[u32], sum: &mut [f64; D]) {
        let near = row.iter().map(|&wall| wall as usize);
        self.guard(i, self.apart_from(i, near).map(|(_, apart)| apart), sum);
    }

    /// The same off what is `near`.
    pub(super) fn guard(&self, i: usize, near: impl Iterator<Item = ([f64; D], f64)>, sum: &mut [f64; D]) {
        let p = self.particles;
        let reach = GUARD_REACH * self.options.spacing;
        let strength = self.options.wall_guard * p.sound[i] * p.sound[i];
        for (apart, square) in near {
            if square < reach * reach && square > 0.0 {
                let r = square.sqrt().max(GUARD_CORE * reach);
                let ratio = (reach / r).powi(4);
                let push = strength * (ratio.powi(3) - ratio) / (r * r);
                (0..D).for_each(|c| sum[c] -= push * apart[c]);
            }
        }
    }
}

/// The normal traction on a face (tension positive) and the size of the shear traction (Pa).
fn tractions<const D: usize>(stress: &SymTensor, plane: &Plane<D>) -> (f64, f64) {
    let axis = plane.axis;
    let shear: f64 = (0..D).filter(|&c| c != axis).map(|c| stress.at(axis, c).powi(2)).sum();
    (stress.at(axis, axis), shear.sqrt())
}

/// The answer to `stress` that makes the shear traction between both, the mean of theirs, `traction(axis)` on a face
/// normal to `axis`.
fn rubbed<const D: usize>(stress: &SymTensor, axis: usize, traction: impl Fn(usize) -> f64) -> SymTensor {
    // Index in a SymTensor of the component (a, b).
    const AT: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
    let mut answer = *stress;
    for c in (0..D).filter(|&c| c != axis) {
        answer[AT[axis][c]] = 2.0 * traction(c) - stress.at(axis, c);
    }
    answer
}
