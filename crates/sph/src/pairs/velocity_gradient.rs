//! Velocity gradient of a particle.

use crate::config::{ContinuityEquation, VelocityGradientOperator};
use crate::pairs::operators::{GradientMoment, product};
use crate::pairs::{PairSums, VelocityGradient};
use crate::points::packed_particles;
use crate::points::packed_particles::{GroupsOfFour, Lanes};
use crate::points::particles::SquareMatrix;

/// Sums of the four lanes of each component.
fn sum_lanes<const D: usize>(sums: &[[Lanes; D]; D]) -> SquareMatrix<D> {
    sums.map(|row| row.map(packed_particles::sum))
}

/// Symmetric matrix from its upper half.
#[inline]
fn from_upper_half<const D: usize>(upper: &SquareMatrix<D>) -> SquareMatrix<D> {
    std::array::from_fn(|a| std::array::from_fn(|b| upper[a.min(b)][a.max(b)]))
}

/// Corrects a velocity gradient `L` (1/s) with the moment matrix `M` to be exact for rotations, `L - RM + R`. `R` is the rotation that best
/// fits the velocities of the neighbours (docs/theory/sph.md). Where velocities are the chords of a step of `chord` (s), `R` is that of the
/// chords, `Ω + (cos θ - 1)/Δt` across the axis with `sin θ = Ω Δt`. Returns the change of the trace.
#[inline]
fn corotate<const D: usize>(gradient: &mut SquareMatrix<D>, moment: &GradientMoment<D>, chord: f64) -> f64 {
    let Some(spin) = moment.rotation(gradient) else { return 0.0 };
    let square: SquareMatrix<D> =
        std::array::from_fn(|a| product(&spin.map(|row| row.map(|c| -c)), &spin[a]));
    let rate = -0.5 * (0..D).map(|c| square[c][c]).sum::<f64>();
    let short = chord / (1.0 + (1.0 - rate * chord * chord).max(0.0).sqrt());
    let mut change = 0.0;
    for (a, row) in gradient.iter_mut().enumerate() {
        let turn: [f64; D] = std::array::from_fn(|b| spin[a][b] + short * square[a][b]);
        let applied = product(&moment.matrix, &turn);
        (0..D).for_each(|b| row[b] += turn[b] - applied[b]);
        change += turn[a] - applied[a];
    }
    change
}

/// Sums that the velocity gradient needs, by the options.
#[derive(Clone, Copy, PartialEq, Eq)]
struct GradientForm {
    /// Whether pairs are weighted by the mass of the neighbour over the density, instead of its volume.
    by_mass: bool,
    /// Whether the gradient is corrected by the inverse of the moment.
    is_corrected: bool,
    /// Whether the gradient is made exact for rotations.
    is_corotated: bool,
    /// Continuity equation.
    continuity: ContinuityEquation,
    /// Whether the divergence has a sum of its own; where the forms of gradient and continuity equation agree, it is the trace.
    sums_divergence: bool,
}

/// Form of the default options.
const DEFAULT_FORM: GradientForm = GradientForm {
    by_mass: true,
    is_corrected: false,
    is_corotated: true,
    continuity: ContinuityEquation::Trace,
    sums_divergence: false,
};

/// Sums over the neighbours of a particle.
#[derive(Clone, Copy)]
pub struct GradientSums<const D: usize> {
    gradient: SquareMatrix<D>, // (1/s)
    moment: GradientMoment<D>,
    trace: f64, // divergence (1/s)
}

impl<const D: usize> GradientSums<D> {
    /// Sums without neighbours.
    pub const ZERO: Self = Self {
        gradient: [[0.0; D]; D],
        moment: GradientMoment { matrix: [[0.0; D]; D], neighbours: 0 },
        trace: 0.0,
    };

    /// Divides sums of masses by the density of the particle (kg/m³).
    #[inline(always)]
    fn divide_by_density(&mut self, density: f64, form: &GradientForm) {
        if form.by_mass {
            self.gradient = self.gradient.map(|row| row.map(|c| c / density));
            let volume = 1.0 / density;
            self.moment.matrix = self.moment.matrix.map(|row| row.map(|c| c * volume));
        }
        self.trace /= if form.continuity == ContinuityEquation::Mass { density } else { 1.0 };
    }
}

impl<const D: usize> PairSums<'_, D> {
    /// Sums of the velocity gradient of particle `i` over its neighbours, walls and smooth bodies included. The weights are those of its
    /// acceleration.
    #[inline]
    pub fn velocity_gradient_sums(&self, i: usize, (row, weights): (&[u32], &[f64])) -> GradientSums<D> {
        self.sums_of_form::<false>(i, (row, weights), &[[0.0; D]; D], true)
    }

    /// Sums of the velocity gradient of a particle of a rigid body, from velocities without the rotation `turn` of the body (1/s). Walls
    /// and obstacles contribute if `ground` is true; a freely moving body they support as a whole.
    #[inline(never)]
    pub fn velocity_gradient_sums_rotating(
        &self,
        i: usize,
        row: &[u32],
        weights: &[f64],
        turn: &SquareMatrix<D>,
        ground: bool,
    ) -> GradientSums<D> {
        let row = if ground { row } else { &row[..self.neighbours_before(row, self.particles.len())] };
        self.sums_of_form::<true>(i, (row, weights), turn, ground)
    }

    /// Sums of the velocity gradient with those of walls, obstacles and smooth bodies.
    #[inline(always)]
    fn sums_of_form<const TURNS: bool>(
        &self,
        i: usize,
        (row, weights): (&[u32], &[f64]),
        turn: &SquareMatrix<D>,
        ground: bool,
    ) -> GradientSums<D> {
        let regular = self.first_mirrored(row);
        let pairs = (row, weights, regular);
        // The default form has a loop of its own, without the branches of the others.
        let mut sums = match self.gradient_form() {
            DEFAULT_FORM => self.gradient_sums::<TURNS>(i, pairs, turn, &DEFAULT_FORM),
            form => self.gradient_sums::<TURNS>(i, pairs, turn, &form),
        };
        let GradientSums { gradient, moment, trace } = &mut sums;
        if !self.walls.smooth_bodies.is_empty() {
            self.add_smooth_gradient(i, row, (&mut *gradient, &mut *trace, &mut *moment));
        }
        if regular < row.len() {
            self.add_wall_gradient(i, &row[regular..], (&mut *gradient, &mut *trace, &mut *moment));
        }
        if ground && !self.walls.obstacles.is_empty() {
            self.add_obstacle_gradient(i, (gradient, trace, moment));
        }
        sums
    }

    /// Velocity gradient of particle `i` (1/s) from its sums, step 6 of `sheet: sph §3.3`. Velocities are chords of a step of `chord` (s),
    /// or, for 0, those at the positions.
    #[inline]
    pub fn velocity_gradient(&self, i: usize, sums: &GradientSums<D>, chord: f64) -> VelocityGradient<D> {
        let (form, &GradientSums { gradient, mut moment, mut trace }) = (self.gradient_form(), sums);
        let spread = if self.grad_h() { self.pair_data.grad_h_factor[i] } else { 1.0 };
        // The corrected gradient is exact for the plain weights: 1/ϑ belongs to the other sums.
        let correction = if form.is_corrected { moment.correction() } else { None };
        let mut gradient = match correction {
            Some(l) => gradient.map(|row| product(&l, &row)),
            None => gradient.map(|row| row.map(|c| c * spread)),
        };
        if form.is_corotated {
            if self.grad_h() {
                moment.matrix = moment.matrix.map(|row| row.map(|c| c * spread));
            }
            trace += corotate(&mut gradient, &moment, chord) / spread;
        }
        let divergence =
            if form.sums_divergence { trace * spread } else { (0..D).map(|c| gradient[c][c]).sum() };
        VelocityGradient { gradient, divergence }
    }

    /// Returns the sums of the options.
    #[inline(always)]
    fn gradient_form(&self) -> GradientForm {
        let operator = self.options.gradient_operator();
        let by_mass = operator == VelocityGradientOperator::DensityDifference;
        let is_corrected = operator == VelocityGradientOperator::Corrected;
        let continuity = self.options.continuity;
        let sums_divergence = match continuity {
            ContinuityEquation::Mass => !by_mass,
            ContinuityEquation::Volume => by_mass || is_corrected,
            ContinuityEquation::Trace | ContinuityEquation::Summation => false,
        };
        let is_corotated = self.options.is_corotated();
        GradientForm { by_mass, is_corrected, is_corotated, continuity, sums_divergence }
    }

    /// Sums of particle `i` over the first `regular` neighbours of its list, which are not mirrored. With `TURNS` the rotation `turn` (1/s)
    /// is subtracted from the velocities.
    #[inline(always)]
    fn gradient_sums<const TURNS: bool>(
        &self,
        i: usize,
        (row, weights, regular): (&[u32], &[f64], usize),
        turn: &SquareMatrix<D>,
        form: &GradientForm,
    ) -> GradientSums<D> {
        let &GradientForm { by_mass, is_corrected, is_corotated, continuity, sums_divergence } = form;
        let records = &self.pair_data.records;
        let own = packed_particles::packed_kinematics::<D>([&records[i]; 4]);
        let mut gradient = [[Lanes::splat(0.0); D]; D];
        let (mut moment, mut neighbours) = ([[Lanes::splat(0.0); D]; D], Lanes::splat(0.0));
        let mut trace = Lanes::splat(0.0);
        for (start, four, count) in GroupsOfFour::new(&row[..regular], i) {
            let other = packed_particles::packed_kinematics::<D>(four.map(|j| &records[j]));
            let apart: [Lanes; D] = std::array::from_fn(|c| other.x[c] - own.x[c]);
            let mut relative: [Lanes; D] = std::array::from_fn(|c| other.v[c] - own.v[c]);
            if TURNS {
                for (relative, row) in relative.iter_mut().zip(turn) {
                    (0..D).for_each(|b| *relative -= apart[b] * row[b]);
                }
            }
            let volume = other.volume * packed_particles::load_four(weights, start, count);
            let mass = volume * other.density;
            let scaled = apart.map(|c| c * if by_mass { mass } else { volume });
            for a in 0..D {
                for b in 0..D {
                    gradient[a][b] += relative[a] * scaled[b];
                }
            }
            if sums_divergence {
                let weight = if continuity == ContinuityEquation::Mass { mass } else { volume };
                trace += packed_particles::dot(&relative, &apart) * weight;
            }
            if is_corrected || is_corotated {
                // Upper half only, since the moment is symmetric.
                for a in 0..D {
                    for b in a..D {
                        moment[a][b] += apart[a] * scaled[b];
                    }
                }
            }
            if is_corrected {
                neighbours += volume.simd_gt(Lanes::splat(0.0)) & Lanes::splat(1.0);
            }
        }
        let neighbours =
            if is_corrected { packed_particles::sum(neighbours) as u32 } else { row.len() as u32 };
        let mut sums = GradientSums {
            gradient: sum_lanes(&gradient),
            moment: GradientMoment { matrix: from_upper_half(&sum_lanes(&moment)), neighbours },
            trace: packed_particles::sum(trace),
        };
        sums.divide_by_density(self.particles.density[i], form);
        sums
    }
}
