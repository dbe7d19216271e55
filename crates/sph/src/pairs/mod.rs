//! Sums over neighbours: acceleration, velocity gradient and diffusion terms (sheet: sph §2.6–2.13).
//!
//! Every particle sums over its own neighbours, four at a time, in an order fixed by the data, so that the result does not depend on the
//! number of threads. Geometry and kernel are computed once per pair and step, with
//! the acceleration, and kept for the velocity gradient.

mod acceleration;
pub(crate) mod corrected_momentum;
pub(crate) mod diffusion;
pub(crate) mod obstacle_mirror;
pub mod operators;
pub(crate) mod pair_data;
pub(crate) mod short_range_repulsion;
pub(crate) mod smooth_body_mirror;
pub(crate) mod tensile_instability;
pub(crate) mod velocity_gradient;
pub(crate) mod wall_mirror;

use std::ops::Deref;

use colluvium_constitutive::SymTensor;
use colluvium_points::{BLOCK_POINTS, NeighbourList};
use rayon::prelude::*;

pub use crate::pairs::diffusion::Shift;
pub(crate) use crate::pairs::short_range_repulsion::{ShortRangeRepulsion, repulsion_energy};
pub use acceleration::MomentumForm;

use crate::config::{MomentumEquation, SphOptions, Symmetrisation};
use crate::context::SolverContext;
use crate::kernel::Smoothing;
use crate::points::particles::{Bodies, PairData, ParticleGroup, Particles, SquareMatrix};
use crate::points::vector_algebra::separation;

use crate::points::packed_particles::{self, GroupsOfFour, Lanes};
use crate::walls::Walls;

/// Softening of the viscosity for coincident particles (sheet: sph §2.8).
pub const SOFTENING: f64 = 0.01;

/// Calls `visit(particle, neighbours, weights, entry of out)` for every entry of `out`.
pub fn for_each_particle<const D: usize, T: Send>(
    neighbours: &NeighbourList<D>,
    weights: &mut [Vec<f64>],
    out: &mut [T],
    visit: impl Fn(usize, &[u32], &mut [f64], &mut T) + Sync,
) {
    let blocks = out.par_chunks_mut(BLOCK_POINTS).zip(weights).zip(neighbours.blocks()).enumerate();
    blocks.for_each(|(number, ((out, weights), rows))| {
        for (k, slot) in out.iter_mut().enumerate() {
            visit(number * BLOCK_POINTS + k, rows.neighbours(k), &mut weights[rows.range(k)], slot);
        }
    });
}

/// Input of sums over positions, masses, densities and stresses.
pub struct PairContext<'a, const D: usize> {
    /// Particles.
    pub particles: &'a Particles<D>,
    /// Kernel at the initial smoothing length.
    pub smoothing: &'a Smoothing<D>,
    /// Options.
    pub options: &'a SphOptions,
    /// Walls and obstacles.
    pub walls: &'a Walls<D>,
    /// Index of the first wall particle.
    pub first_wall_particle: usize,
    /// Index of the first neighbour that is a dummy particle with a mirrored state.
    pub first_dummy_particle: usize,
    /// Artificial repulsion against tensile instability; `None` if the case has none.
    pub repulsion: Option<ArtificialRepulsion>,
}

/// Input of the sums of the equations of motion: [`PairContext`] and the pair data of the particles.
pub struct PairSums<'a, const D: usize> {
    pairs: PairContext<'a, D>,
    /// Pressure, stress and volume terms of the particles.
    pub(crate) pair_data: &'a PairData<D>,
    /// Groups of particles, one per body and material.
    pub(crate) groups: &'a [ParticleGroup],
    /// Short-range repulsion, where there are fluids.
    short_range_repulsion: Option<ShortRangeRepulsion>,
}

impl<'a, const D: usize> Deref for PairSums<'a, D> {
    type Target = PairContext<'a, D>;

    #[inline(always)]
    fn deref(&self) -> &Self::Target {
        &self.pairs
    }
}

/// Velocity gradient of a particle, and its divergence by the continuity equation.
pub struct VelocityGradient<const D: usize> {
    /// Gradient `∂v_a/∂x_b` (1/s).
    pub gradient: SquareMatrix<D>,
    /// Divergence `-ρ̇/ρ` (1/s).
    pub divergence: f64,
}

impl<const D: usize> VelocityGradient<D> {
    /// Adds the rotation `turn` of a rigid body (1/s).
    pub(crate) fn add_rotation(&mut self, turn: &SquareMatrix<D>) {
        for (a, row) in self.gradient.iter_mut().enumerate() {
            (0..D).for_each(|b| row[b] += turn[a][b]);
            self.divergence += turn[a][a];
        }
    }
}

/// Parameters of the artificial repulsion.
#[derive(Clone, Copy)]
pub struct ArtificialRepulsion {
    /// Exponent of the ratio of kernels.
    exponent: f64,
    /// The exponent as a whole number, if it is one.
    whole_exponent: Option<i32>,
    /// Factor `1 / W(Δx)` at the initial smoothing length.
    scale: f64,
}

impl ArtificialRepulsion {
    /// Repulsion of an exponent, with the kernel `W` at the spacing (1/m^d).
    fn new(exponent: f64, kernel_at_spacing: f64) -> Self {
        let is_whole = exponent.fract() == 0.0 && exponent.abs() <= 64.0;
        Self { exponent, whole_exponent: is_whole.then_some(exponent as i32), scale: 1.0 / kernel_at_spacing }
    }

    /// Power of the ratio of a kernel value (1/m^d) to that at the spacing.
    #[inline]
    pub(crate) fn power(&self, kernel: f64) -> f64 {
        let ratio = kernel * self.scale;
        // Multiplications are many times faster than a power of a real exponent.
        self.whole_exponent.map_or_else(|| ratio.powf(self.exponent), |exponent| ratio.powi(exponent))
    }
}

impl<'a, const D: usize> PairContext<'a, D> {
    /// Returns the context of `particles` between `walls`.
    pub fn new(setting: &'a SolverContext<D>, particles: &'a Particles<D>, walls: &'a Walls<D>) -> Self {
        let len = particles.len();
        Self {
            particles,
            smoothing: &setting.smoothing,
            options: &setting.options,
            walls,
            first_wall_particle: walls.first(len),
            first_dummy_particle: walls.first_dummy_particle(setting, len),
            repulsion: setting.options.tensile.exponent().map(|exponent| {
                ArtificialRepulsion::new(exponent, setting.smoothing.value(setting.options.spacing))
            }),
        }
    }

    /// Factor of the particle stress in the momentum equation.
    #[inline]
    pub fn flux_scale(momentum: MomentumEquation, density: f64, spread: f64) -> f64 {
        if momentum == MomentumEquation::Rho2 { spread / (density * density) } else { 1.0 }
    }

    /// Number of neighbours without a mirrored state, which are the first ones of the list.
    #[inline(always)]
    pub(crate) fn first_mirrored(&self, row: &[u32]) -> usize {
        self.neighbours_before(row, self.first_dummy_particle)
    }

    /// Number of neighbours with an index below `number`.
    #[inline(always)]
    pub(crate) fn neighbours_before(&self, row: &[u32], number: usize) -> usize {
        match row.last() {
            Some(&last) if last as usize >= number => row.partition_point(|&j| (j as usize) < number),
            _ => row.len(),
        }
    }

    /// Particle of the neighbour `j`, for an image its source; `j` must not be a wall particle.
    #[inline]
    pub(crate) fn source(&self, j: usize) -> usize {
        let len = self.particles.len();
        if j < len { j } else { self.walls.images[j - len].source as usize }
    }

    /// Index of the fields of neighbour `j` for `i`: `i` itself for dummy particles and smooth bodies, else `j`.
    #[inline]
    pub(crate) fn effective_index(&self, i: usize, j: usize) -> usize {
        if j >= self.first_dummy_particle || self.walls.smooth_bodies.contain(j) { i } else { j }
    }

    /// Whether the momentum equation has the grad-h factor of variable smoothing lengths.
    pub(crate) fn grad_h(&self) -> bool {
        self.options.is_variable() && self.options.symmetrisation == Symmetrisation::GradH
    }

    /// Kernel of smoothing length `length` (m).
    #[inline]
    pub(crate) fn kernel_of(&self, length: f64) -> Smoothing<D> {
        self.smoothing.with_length(length)
    }

    /// Smoothing length of a pair of particles (m); `None` if each particle has its own kernel.
    pub(crate) fn common_length(&self, own: f64, other: f64) -> Option<f64> {
        match self.options.symmetrisation {
            Symmetrisation::Arithmetic => Some(0.5 * (own + other)),
            Symmetrisation::Harmonic => Some(2.0 * own * other / (own + other)),
            Symmetrisation::Geometric => Some((own * other).sqrt()),
            Symmetrisation::Max => Some(own.max(other)),
            Symmetrisation::Min => Some(own.min(other)),
            Symmetrisation::Kernel | Symmetrisation::GradH => None,
        }
    }

    /// Weight and value of the kernel between `i` and `j` at the distance `r` (m).
    pub(crate) fn pair_kernel(&self, i: usize, j: usize, r: f64) -> [f64; 2] {
        let p = self.particles;
        let (own, other) = (p.length[i], p.length[j]);
        let one = |length: f64| {
            let kernel = self.kernel_of(length);
            [kernel.gradient_factor(r), kernel.value(r)]
        };
        match self.common_length(own, other) {
            Some(length) => one(length),
            None if self.options.symmetrisation == Symmetrisation::GradH => one(own),
            None => {
                let ([f, w], [g, v]) = (one(own), one(other));
                [0.5 * (f + g), 0.5 * (w + v)]
            }
        }
    }

    /// Argument of the kernel ratio: `W` of the initial smoothing length between `i` and `j` at the distance `r` (m), scaled by their
    /// smoothing length. Over `W(Δx)` it is `W(r, h) / W(Δx h/h₀, h)`: one at the spacing of `h`. Symmetric in `i` and `j`, also where each
    /// has its own kernel.
    #[inline]
    pub(crate) fn kernel_ratio_argument(&self, i: usize, j: usize, r: f64) -> f64 {
        if !self.options.is_variable() {
            return self.smoothing.value(r);
        }
        let (own, other) = (self.particles.length[i], self.particles.length[j]);
        let one = |length: f64| self.kernel_ratio_argument_of(length, r);
        self.common_length(own, other).map_or_else(|| 0.5 * (one(own) + one(other)), one)
    }

    /// Argument of the kernel ratio for one smoothing length.
    #[inline]
    pub(crate) fn kernel_ratio_argument_of(&self, length: f64, r: f64) -> f64 {
        self.smoothing.value(r * (self.smoothing.length() / length))
    }

    /// Kernel value `W` between `i` and `j` at the distance `r` (m).
    #[inline]
    pub(crate) fn value(&self, i: usize, j: usize, r: f64) -> f64 {
        if self.options.is_variable() { self.pair_kernel(i, j, r)[1] } else { self.smoothing.value(r) }
    }

    /// Factor `1/ϑ` of the gradient of the smoothing length (BN 53), the particle itself included.
    pub fn grad_h_factor(&self, i: usize, row: &[u32]) -> f64 {
        let p = self.particles;
        let kernel = self.kernel_of(p.length[i]);
        let mut sum = p.mass[i] * kernel.length_derivative(0.0);
        for &j in row {
            let j = j as usize;
            let k = self.effective_index(i, j);
            let (_, square) = separation(&p.position[i], &p.position[j]);
            sum += p.mass[k] * kernel.length_derivative(square.sqrt());
        }
        // ∂h/∂ρ = -h / (d ρ).
        1.0 / (1.0 + p.length[i] / (D as f64 * p.density[i]) * sum)
    }
}

impl<'a, const D: usize> PairSums<'a, D> {
    /// Returns the sums of `bodies` between `walls`.
    pub fn new(setting: &'a SolverContext<D>, bodies: &'a Bodies<D>, walls: &'a Walls<D>) -> Self {
        Self {
            pairs: PairContext::new(setting, &bodies.particles, walls),
            pair_data: &bodies.pair_data,
            groups: &bodies.groups,
            short_range_repulsion: ShortRangeRepulsion::of_groups(setting, &bodies.groups),
        }
    }

    /// Pair data of the particles.
    pub(crate) fn pair_data(&self) -> &PairData<D> {
        self.pair_data
    }

    /// Computes the weights `F` of the neighbours of `i` without a mirrored state.
    pub fn fill_weights(&self, i: usize, row: &[u32], weights: &mut [f64]) {
        let regular = self.first_mirrored(row);
        if self.options.is_variable() {
            for (slot, &j) in weights.iter_mut().zip(&row[..regular]) {
                let p = self.particles;
                let (_, square) = separation(&p.position[i], &p.position[j as usize]);
                *slot = self.pair_kernel(i, j as usize, square.sqrt())[0];
            }
            return;
        }
        let records = &self.pair_data.records;
        let own = packed_particles::packed_kinematics::<D>([&records[i]; 4]);
        for (start, four, count) in GroupsOfFour::new(&row[..regular], i) {
            let other = packed_particles::packed_kinematics::<D>(four.map(|j| &records[j]));
            let apart: [Lanes; D] = std::array::from_fn(|c| other.x[c] - own.x[c]);
            let weight = self.smoothing.weights(packed_particles::dot(&apart, &apart));
            packed_particles::store_four(weights, start, count, weight);
        }
    }

    /// Artificial repulsion `R_i + R_j` times the power of the ratio of kernels; `None` where no particle is in tension.
    #[inline]
    fn repulsion_stress(&self, i: usize, four: [usize; 4], square: Lanes) -> Option<[Lanes; 6]> {
        let repulsion = &self.pair_data.repulsion;
        if repulsion.is_empty() {
            return None;
        }
        let law = self.pairs.repulsion?;
        let tensors = four.map(|j| &repulsion[j]);
        let own = &repulsion[i];
        if *own == SymTensor::ZERO && tensors.iter().all(|tensor| **tensor == SymTensor::ZERO) {
            return None;
        }
        let power = match law.whole_exponent {
            Some(exponent @ 0..) if !self.options.is_variable() => packed_particles::whole_power(
                self.smoothing.values(square) * law.scale,
                exponent.unsigned_abs(),
            ),
            _ => {
                let square = square.to_array();
                let ratio = |k: usize| self.kernel_ratio_argument(i, four[k], square[k].sqrt());
                Lanes::new(std::array::from_fn(|k| law.power(ratio(k))))
            }
        };
        Some(std::array::from_fn(|c| (Lanes::new(tensors.map(|tensor| tensor.0[c])) + own.0[c]) * power))
    }
}
