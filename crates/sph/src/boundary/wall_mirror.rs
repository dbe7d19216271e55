//! Walls of particles that answer to each particle with what it is itself (sheet: sph §2.13 b–d, f).

use colluvium_constitutive::SymTensor;

use crate::boundary::walls::{FlatWall, WallContact};
use crate::config::WallVelocity;
use crate::pairs::operators::{GradientMoment, product};
use crate::pairs::{MomentumForm, PairContext, PairSums, SOFTENING};
use crate::points::particles::SquareMatrix;
use crate::points::vector_algebra::{separation, with_scaled_shear};

/// Most of the particle's own velocity that a wall opposes, `β_max - 1` (Morris et al. 1997).
pub(crate) const MAX_MIRROR_FACTOR: f64 = 0.5;
/// Reach of the guard, in spacings: particles of the wall start half a spacing behind its face.
const REPULSION_RANGE: f64 = 0.5;
/// Closer than this share of its reach the guard grows no further.
const REPULSION_CORE: f64 = 0.6;

/// Below this share of `μ σ_n / (ρ c)` slip counts as none: friction stops it within a step or so.
pub(crate) const STICK_RATIO: f64 = 0.25;

/// What a wall opposes to a particle.
pub(crate) struct MirrorState<const D: usize> {
    /// Velocity of the wall's particle less the particle's own (m/s).
    pub relative: [f64; D],
    /// Stress of the wall's particle (Pa).
    pub stress: SymTensor,
    /// Its artificial stress over density squared.
    pub repulsion: SymTensor,
    /// How it rubs beyond its stress; `None` where it does not, or holds.
    pub slip_friction: Option<SlipFriction<D>>,
}

/// Friction of what slips: viscosity pushes off a wall too, and what it bears rubs as the stress does.
pub(crate) struct SlipFriction<const D: usize> {
    /// Unit normal of the wall.
    pub normal: [f64; D],
    /// Against the slip, of the size of the coefficient of friction.
    pub direction: [f64; D],
}

impl<const D: usize> PairSums<'_, D> {
    /// The answer of the particle `wall` of a wall to `i`; `None` where the material lifts off.
    fn mirror_state(&self, i: usize, wall: usize) -> Option<MirrorState<D>> {
        let p = self.particles;
        let number = self.walls.planes.face_of[wall - self.first_wall_particle] as usize;
        let plane = &self.walls.planes.faces[number];
        let (stress, axis) = (p.stress[i], plane.axis);
        let repulsion = self.pair_data().repulsion.get(i).copied().unwrap_or(SymTensor::ZERO);
        // Towards the wall's own motion.
        let pace = plane.mean_velocity();
        let own: [f64; D] = std::array::from_fn(|c| p.velocity[i][c] - pace[c]);
        let along = |keep: f64| -> [f64; D] {
            std::array::from_fn(|c| own[c] * if c == axis { -2.0 } else { keep - 1.0 })
        };
        match plane.contact {
            WallContact::NoSlip => {
                let opposed = match self.options.wall_velocity {
                    WallVelocity::Mirrored => 1.0,
                    WallVelocity::Linear => {
                        let near = plane.distance(&p.position[i]).max(1e-3 * self.options.spacing);
                        (-plane.distance(&p.position[wall]) / near).min(MAX_MIRROR_FACTOR)
                    }
                };
                Some(MirrorState {
                    relative: own.map(|v| -v * (1.0 + opposed)),
                    stress,
                    repulsion,
                    slip_friction: None,
                })
            }
            WallContact::FreeSlip => Some(MirrorState {
                relative: along(1.0),
                stress: with_scaled_shear(&stress, axis, -1.0),
                repulsion: with_scaled_shear(&repulsion, axis, -1.0),
                slip_friction: None,
            }),
            WallContact::Friction(coefficient) => {
                let (normal, shear) = face_tractions(&stress, plane);
                if normal > 0.0 {
                    return None;
                }
                let most = -coefficient * normal;
                let speed: f64 = (0..D).filter(|&c| c != axis).map(|c| own[c] * own[c]).sum::<f64>().sqrt();
                if speed > STICK_RATIO * most / (p.density[i] * p.sound[i]) {
                    let rubs = coefficient * p.friction_pressure(i, -normal);
                    let factor = rubs / speed * if plane.upper { -1.0 } else { 1.0 };
                    let normal = std::array::from_fn(|c| f64::from(u8::from(c == axis)));
                    let against =
                        std::array::from_fn(|c| if c == axis { 0.0 } else { -coefficient * own[c] / speed });
                    return Some(MirrorState {
                        relative: along(1.0),
                        stress: friction_mirror_stress::<D>(&stress, axis, |c| factor * own[c]),
                        repulsion,
                        slip_friction: Some(SlipFriction { normal, direction: against }),
                    });
                }
                if shear <= most {
                    return Some(MirrorState {
                        relative: along(-1.0),
                        stress,
                        repulsion,
                        slip_friction: None,
                    });
                }
                let stress =
                    friction_mirror_stress::<D>(&stress, axis, |c| stress.at(axis, c) * most / shear);
                Some(MirrorState { relative: along(1.0), stress, repulsion, slip_friction: None })
            }
        }
    }

    /// Acceleration by the walls that answer.
    pub(crate) fn wall_acceleration(&self, i: usize, row: &[u32], form: MomentumForm, sum: &mut [f64; D]) {
        let near = row.iter().map(|&wall| wall as usize);
        self.mirror_acceleration(i, self.separations(i, near), form, |wall| self.mirror_state(i, wall), sum);
    }

    /// The particles `near`, each with its place less that of `i` (m) and the square of their distance.
    #[inline]
    pub(crate) fn separations(
        &self,
        i: usize,
        near: impl Iterator<Item = usize>,
    ) -> impl Iterator<Item = (usize, ([f64; D], f64))> {
        let positions = &self.particles.position;
        near.map(move |wall| (wall, separation(&positions[i], &positions[wall])))
    }

    /// Acceleration by what is `near`, which answers.
    #[inline]
    pub(crate) fn mirror_acceleration<T>(
        &self,
        i: usize,
        near: impl Iterator<Item = (T, ([f64; D], f64))>,
        form: MomentumForm,
        answer: impl Fn(T) -> Option<MirrorState<D>>,
        sum: &mut [f64; D],
    ) {
        let p = self.particles;
        let (mass, density, sound) = (p.mass[i], p.density[i], p.sound[i]);
        let shown = self.pair_data();
        let kernel = self.kernel_of(p.length[i]);
        let h = kernel.length();
        let scale = PairContext::<D>::flux_scale(self.options.momentum, density, shown.grad_h_factor[i]);
        let scale = if form.divides_by_both { scale / (density * density) } else { scale };
        for (wall, (apart, square)) in near {
            let r = square.sqrt();
            let weight = kernel.gradient_factor(r);
            if weight == 0.0 {
                continue;
            }
            let Some(answer) = answer(wall) else { continue };
            let mut pair = (p.stress[i] * form.own_factor + answer.stress) * scale;
            if let Some(repulsion) = self.repulsion().filter(|_| !shown.repulsion.is_empty()) {
                let factor = (self.kernel_ratio_argument_of(h, r) * repulsion.scale).powf(repulsion.exponent);
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
            if let Some(SlipFriction { normal, direction: against }) = &answer.slip_friction {
                let across: f64 = (0..D).map(|c| apart[c] * normal[c]).sum();
                let push = (mass * weight * viscosity * across).abs();
                (0..D).for_each(|c| sum[c] += push * against[c]);
            }
        }
    }

    /// What walls that answer add to the velocity gradient, the divergence and the moment.
    pub(crate) fn add_wall_gradient(
        &self,
        i: usize,
        row: &[u32],
        sums: (&mut SquareMatrix<D>, &mut f64, &mut GradientMoment<D>),
    ) {
        let near = row.iter().map(|&wall| wall as usize);
        self.add_mirror_gradient(i, self.separations(i, near), |wall| self.mirror_state(i, wall), sums);
    }

    /// What is `near`, and answers, adds to the velocity gradient, the divergence and the moment.
    #[inline]
    pub(crate) fn add_mirror_gradient<T>(
        &self,
        i: usize,
        near: impl Iterator<Item = (T, ([f64; D], f64))>,
        answer: impl Fn(T) -> Option<MirrorState<D>>,
        (gradient, trace, moment): (&mut SquareMatrix<D>, &mut f64, &mut GradientMoment<D>),
    ) {
        let p = self.particles;
        let kernel = self.kernel_of(p.length[i]);
        let volume = p.mass[i] / p.density[i];
        for (wall, (apart, square)) in near {
            let weight = volume * kernel.gradient_factor(square.sqrt());
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
    pub(crate) fn wall_repulsion(&self, i: usize, row: &[u32], sum: &mut [f64; D]) {
        let near = row.iter().map(|&wall| wall as usize);
        self.repulsion_of(i, self.separations(i, near).map(|(_, apart)| apart), sum);
    }

    /// The same off what is `near`.
    pub(crate) fn repulsion_of(
        &self,
        i: usize,
        near: impl Iterator<Item = ([f64; D], f64)>,
        sum: &mut [f64; D],
    ) {
        let p = self.particles;
        let reach = REPULSION_RANGE * self.options.spacing;
        let strength = self.options.wall_guard * p.sound[i] * p.sound[i];
        for (apart, square) in near {
            if square < reach * reach && square > 0.0 {
                let r = square.sqrt().max(REPULSION_CORE * reach);
                let ratio = (reach / r).powi(4);
                let push = strength * (ratio.powi(3) - ratio) / (r * r);
                (0..D).for_each(|c| sum[c] -= push * apart[c]);
            }
        }
    }
}

/// The normal traction on a face (tension positive) and the size of the shear traction (Pa).
fn face_tractions<const D: usize>(stress: &SymTensor, plane: &FlatWall<D>) -> (f64, f64) {
    let axis = plane.axis;
    let shear: f64 = (0..D).filter(|&c| c != axis).map(|c| stress.at(axis, c).powi(2)).sum();
    (stress.at(axis, axis), shear.sqrt())
}

/// The answer to `stress` that makes the shear traction between both, the mean of theirs, `traction(axis)` on a face
/// normal to `axis`.
fn friction_mirror_stress<const D: usize>(
    stress: &SymTensor,
    axis: usize,
    traction: impl Fn(usize) -> f64,
) -> SymTensor {
    // Index in a SymTensor of the component (a, b).
    const AT: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
    let mut answer = *stress;
    for c in (0..D).filter(|&c| c != axis) {
        answer[AT[axis][c]] = 2.0 * traction(c) - stress.at(axis, c);
    }
    answer
}
