//! Dummy particles of walls with the mirrored state of each particle (sheet: sph §2.13 b–d, f).

use colluvium_constitutive::SymTensor;

use crate::config::WallVelocity;
use crate::pairs::operators::{GradientMoment, product};
use crate::pairs::{MomentumForm, PairContext, PairSums, SOFTENING};
use crate::points::particles::SquareMatrix;
use crate::points::vector_algebra::{separation, with_scaled_shear};
use crate::walls::{FlatWall, WallContact};

/// Upper bound of the factor on the particle velocity in a mirrored velocity, `β_max - 1` (Morris et al. 1997).
pub(crate) const MAX_MIRROR_FACTOR: f64 = 0.5;
/// Range of the wall repulsion, in spacings; wall particles begin half a spacing behind the face.
const REPULSION_RANGE: f64 = 0.5;
/// Distance over the range below which the wall repulsion does not grow further.
const REPULSION_CORE: f64 = 0.6;

/// Slip over `μ σ_n / (ρ c)` below which a contact sticks, as friction would stop it within about one step.
pub(crate) const STICK_RATIO: f64 = 0.25;

/// Mirrored state of a wall particle for a particle.
pub(crate) struct MirrorState<const D: usize> {
    /// Velocity of the wall particle minus that of the particle (m/s).
    pub relative: [f64; D],
    /// Stress of the wall particle (Pa).
    pub stress: SymTensor,
    /// Artificial stress of the wall particle over density squared.
    pub repulsion: SymTensor,
    /// Friction of viscous forces in addition to the stress; `None` without friction or in sticking contact.
    pub slip_friction: Option<SlipFriction<D>>,
}

impl<const D: usize> MirrorState<D> {
    /// Returns a state without slip friction.
    #[inline]
    pub fn new(relative: [f64; D], stress: SymTensor, repulsion: SymTensor) -> Self {
        Self { relative, stress, repulsion, slip_friction: None }
    }
}

/// Friction of viscous forces on a wall: their normal component causes friction, like the normal stress.
pub(crate) struct SlipFriction<const D: usize> {
    /// Unit normal of the wall.
    pub normal: [f64; D],
    /// Direction against the slip, times the friction coefficient.
    pub direction: [f64; D],
}

impl<const D: usize> PairSums<'_, D> {
    /// Mirrored state of the dummy particle `wall` for particle `i`; `None` where the material separates.
    fn mirror_state(&self, i: usize, wall: usize) -> Option<MirrorState<D>> {
        let p = self.particles;
        let number = self.walls.planes.face_of[wall - self.first_wall_particle] as usize;
        let plane = &self.walls.planes.faces[number];
        let (stress, axis) = (p.stress[i], plane.axis);
        let repulsion = self.pair_data().repulsion.get(i).copied().unwrap_or(SymTensor::ZERO);
        // Velocity relative to the wall.
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
                Some(MirrorState::new(own.map(|v| -v * (1.0 + opposed)), stress, repulsion))
            }
            WallContact::FreeSlip => {
                let [stress, repulsion] = [stress, repulsion].map(|s| with_scaled_shear(&s, axis, -1.0));
                Some(MirrorState::new(along(1.0), stress, repulsion))
            }
            WallContact::Friction(coefficient) => {
                let (normal, shear) = face_tractions(&stress, plane);
                if normal > 0.0 {
                    return None;
                }
                let largest = -coefficient * normal;
                let speed: f64 = (0..D).filter(|&c| c != axis).map(|c| own[c] * own[c]).sum::<f64>().sqrt();
                if speed > STICK_RATIO * largest / (p.density[i] * p.sound[i]) {
                    let rubs = coefficient * p.friction_pressure(i, -normal);
                    let factor = rubs / speed * if plane.is_upper { -1.0 } else { 1.0 };
                    let normal = std::array::from_fn(|c| f64::from(u8::from(c == axis)));
                    let against =
                        std::array::from_fn(|c| if c == axis { 0.0 } else { -coefficient * own[c] / speed });
                    let stress = friction_mirror_stress::<D>(&stress, axis, |c| factor * own[c]);
                    let rub = SlipFriction { normal, direction: against };
                    let sliding = MirrorState::new(along(1.0), stress, repulsion);
                    return Some(MirrorState { slip_friction: Some(rub), ..sliding });
                }
                if shear <= largest {
                    return Some(MirrorState::new(along(-1.0), stress, repulsion));
                }
                let stress = friction_mirror_stress::<D>(&stress, axis, |c| {
                    stress.component(axis, c) * largest / shear
                });
                Some(MirrorState::new(along(1.0), stress, repulsion))
            }
        }
    }

    /// Adds the acceleration by the mirrored states of walls.
    pub(crate) fn wall_acceleration(&self, i: usize, row: &[u32], form: MomentumForm, sum: &mut [f64; D]) {
        let near = row.iter().map(|&wall| wall as usize);
        self.mirror_acceleration(i, self.separations(i, near), form, |wall| self.mirror_state(i, wall), sum);
    }

    /// Particles `near`, with their positions relative to particle `i` (m) and squared distances (m²).
    #[inline]
    pub(crate) fn separations(
        &self,
        i: usize,
        near: impl Iterator<Item = usize>,
    ) -> impl Iterator<Item = (usize, ([f64; D], f64))> {
        let positions = &self.particles.position;
        near.map(move |wall| (wall, separation(&positions[i], &positions[wall])))
    }

    /// Adds the acceleration by the mirrored states at the positions `near`.
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
            if let Some(repulsion) = self.repulsion.filter(|_| !shown.repulsion.is_empty()) {
                let factor = repulsion.power(self.kernel_ratio_argument_of(h, r));
                pair += (shown.repulsion[i] + answer.repulsion) * factor;
            }
            let closing = (0..D).map(|c| answer.relative[c] * apart[c]).sum::<f64>().min(0.0);
            let pi = h * closing / (square + SOFTENING * h * h);
            let (linear, quadratic) = (self.options.viscosity_linear, self.options.viscosity_quadratic);
            let viscosity = (linear * sound * pi - quadratic * pi * pi) / density;
            // With a corrected gradient, the adjoint is corrected too.
            let turned = shown.correction.get(i).map_or(apart, |l| product(l, &apart));
            for a in 0..D {
                let stress_term: f64 = (0..D).map(|b| pair.component(a, b) * turned[b]).sum();
                sum[a] += mass * weight * (stress_term + viscosity * apart[a]);
            }
            if let Some(SlipFriction { normal, direction: against }) = &answer.slip_friction {
                let across: f64 = (0..D).map(|c| apart[c] * normal[c]).sum();
                let push = (mass * weight * viscosity * across).abs();
                (0..D).for_each(|c| sum[c] += push * against[c]);
            }
        }
    }

    /// Adds the mirrored states of walls to the velocity gradient, the divergence and the moment.
    pub(crate) fn add_wall_gradient(
        &self,
        i: usize,
        row: &[u32],
        sums: (&mut SquareMatrix<D>, &mut f64, &mut GradientMoment<D>),
    ) {
        let near = row.iter().map(|&wall| wall as usize);
        self.add_mirror_gradient(i, self.separations(i, near), |wall| self.mirror_state(i, wall), sums);
    }

    /// Adds the mirrored states at the positions `near` to velocity gradient, divergence and moment matrix.
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

    /// Adds the repulsion by wall particles that are too close (sheet: sph §2.13 d).
    pub(crate) fn wall_repulsion(&self, i: usize, row: &[u32], sum: &mut [f64; D]) {
        let near = row.iter().map(|&wall| wall as usize);
        self.repulsion_of(i, self.separations(i, near).map(|(_, apart)| apart), sum);
    }

    /// Adds the wall repulsion by the positions `near`.
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

/// Normal traction on a face (tension positive) and magnitude of the shear traction (Pa).
fn face_tractions<const D: usize>(stress: &SymTensor, plane: &FlatWall<D>) -> (f64, f64) {
    let axis = plane.axis;
    let shear: f64 = (0..D).filter(|&c| c != axis).map(|c| stress.component(axis, c).powi(2)).sum();
    (stress.component(axis, axis), shear.sqrt())
}

/// Mirrored stress for which the shear traction on a face normal to `axis`, the mean of both stresses, is
/// `traction(axis)`.
fn friction_mirror_stress<const D: usize>(
    stress: &SymTensor,
    axis: usize,
    traction: impl Fn(usize) -> f64,
) -> SymTensor {
    // Index in a SymTensor of the component (a, b).
    /// Position of matrix component `[i][j]` in the array of a symmetric tensor.
    const COMPONENT_INDEX: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
    let mut answer = *stress;
    for c in (0..D).filter(|&c| c != axis) {
        answer[COMPONENT_INDEX[axis][c]] = 2.0 * traction(c) - stress.component(axis, c);
    }
    answer
}
