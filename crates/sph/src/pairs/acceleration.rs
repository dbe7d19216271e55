//! Acceleration of a particle by its neighbours.

use std::ops::Range;

use super::{PairSums, SOFTENING};
use crate::config::MomentumEquation;
use crate::kernel::Kernel;
use crate::points::packed_particles;
use crate::points::packed_particles::{GroupsOfFour, Lanes, PackedKinematics, PackedState};

/// Factors of the pair stresses in the momentum equation.
#[derive(Clone, Copy)]
pub struct MomentumForm {
    /// Factor on the stress of the particle itself in the momentum sum; -1 in the difference form.
    pub own_factor: f64,
    /// Whether the sum is divided by both densities.
    pub divides_by_both: bool,
}

impl MomentumForm {
    /// Returns the form of a momentum equation.
    pub fn of_equation(momentum: MomentumEquation) -> Self {
        let own = if momentum == MomentumEquation::Difference { -1.0 } else { 1.0 };
        Self { own_factor: own, divides_by_both: momentum != MomentumEquation::Rho2 }
    }
}

impl<const D: usize> PairSums<'_, D> {
    /// Acceleration of particle `i` by its neighbours (m/s²), steps 3 and 4 of `sheet: sph §3.3`. It stores the weights of the pairs, and
    /// writes the acceleration by obstacles.
    #[inline]
    pub fn acceleration(
        &self,
        i: usize,
        row: &[u32],
        weights: &mut [f64],
        by_obstacles: Option<&mut [f64; D]>,
    ) -> [f64; D] {
        // The usual settings have loops of their own, without the branches of the others.
        let (form, mut sum) = (MomentumForm::of_equation(self.options.momentum), [0.0; D]);
        match self.smoothing.kernel() {
            Kernel::CubicSpline if self.is_plain() => {
                self.add_neighbours::<true>(i, (row, weights), form, Kernel::CubicSpline, &mut sum);
            }
            Kernel::WendlandC2 if self.is_plain() => {
                self.add_neighbours::<true>(i, (row, weights), form, Kernel::WendlandC2, &mut sum);
            }
            kernel => self.add_neighbours::<false>(i, (row, weights), form, kernel, &mut sum),
        }
        self.other_accelerations(i, (row, &*weights), form, &mut sum, by_obstacles);
        sum
    }

    /// Whether smoothing lengths are constant and there is neither artificial stress nor short-range repulsion.
    #[inline(always)]
    fn is_plain(&self) -> bool {
        !self.options.is_variable() && self.repulsion.is_none() && self.short_range_repulsion.is_none()
    }

    /// Adds the acceleration of particle `i` by the neighbours without a mirrored state, with a kernel that is that of the case. `PLAIN`
    /// says that [`PairSums::is_plain`] holds.
    #[inline(always)]
    fn add_neighbours<const PLAIN: bool>(
        &self,
        i: usize,
        (row, weights): (&[u32], &mut [f64]),
        form: MomentumForm,
        kernel: Kernel,
        total: &mut [f64; D],
    ) {
        let records = &self.pair_data.records;
        let regular = self.first_mirrored(row);
        let own_record = [&records[i]; 4];
        let (own, mine) = (
            packed_particles::packed_kinematics::<D>(own_record),
            packed_particles::packed_state::<D>(own_record),
        );
        let viscous = self.options.viscosity_linear > 0.0 || self.options.viscosity_quadratic > 0.0;
        let variable = !PLAIN && self.options.is_variable();
        let grad_h = !PLAIN && self.grad_h();
        if variable {
            self.fill_weights(i, row, weights);
        }
        let (thinness, h) = (Lanes::splat(1.0) / own.density, Lanes::splat(self.smoothing.length()));
        let mut sum = [Lanes::splat(0.0); D];
        let (reach, mut push) = (self.short_range_repulsion.map_or(0.0, |close| close.square), [0.0; D]);
        for (start, four, count) in GroupsOfFour::new(&row[..regular], i) {
            let near = four.map(|j| &records[j]);
            let (other, more) =
                (packed_particles::packed_kinematics::<D>(near), packed_particles::packed_state::<D>(near));
            let apart: [Lanes; D] = std::array::from_fn(|c| other.x[c] - own.x[c]);
            let square = packed_particles::dot(&apart, &apart);
            let mut weight = self.kernel_weights((kernel, variable), square, weights, (start, count));
            let mass = other.volume * other.density;
            let mut acceleration = if grad_h {
                let others = self.weights_of_others(four, square);
                let flux = std::array::from_fn(|c| mine.stress[c] * weight + more.stress[c] * others);
                weight = (weight + others) * 0.5;
                packed_particles::product::<D>(&flux, &apart).map(|c| c * mass)
            } else {
                let flux = std::array::from_fn(|c| mine.stress[c] * form.own_factor + more.stress[c]);
                let scale = weight * if form.divides_by_both { other.volume * thinness } else { mass };
                packed_particles::product::<D>(&flux, &apart).map(|c| c * scale)
            };
            if !PLAIN {
                self.add_artificial_stress((i, four), (&apart, square), weight * mass, &mut acceleration);
            }
            if viscous {
                let h = if PLAIN { h } else { (mine.length + more.length) * 0.5 };
                let viscosity =
                    self.viscosity((&own, &mine), (&other, &more), (&apart, square, h)) * (weight * mass);
                (0..D).for_each(|c| acceleration[c] += apart[c] * viscosity);
            }
            (0..D).for_each(|c| sum[c] += acceleration[c]);
            if let Some(close) = self.short_range_repulsion.filter(|_| !PLAIN)
                && square.simd_lt(Lanes::splat(reach)).any()
            {
                self.add_repulsion(i, (close, four), (&apart, square), &mut push);
            }
        }
        (0..D).for_each(|c| total[c] += packed_particles::sum(sum[c]) + push[c]);
    }

    /// Kernel weights `F` of four neighbours. For variable smoothing lengths they are already stored, else they follow from squared
    /// distances (m²) and are stored in `weights`.
    #[inline(always)]
    fn kernel_weights(
        &self,
        (kernel, variable): (Kernel, bool),
        square: Lanes,
        weights: &mut [f64],
        (start, count): (usize, usize),
    ) -> Lanes {
        if variable {
            return packed_particles::load_four(weights, start, count);
        }
        let weight = self.smoothing.weights_of(kernel, square);
        packed_particles::store_four(weights, start, count, weight);
        weight
    }

    /// Adds the artificial stress of four pairs, with their weights times the masses of the neighbours.
    #[inline(always)]
    fn add_artificial_stress(
        &self,
        (i, four): (usize, [usize; 4]),
        (apart, square): (&[Lanes; D], Lanes),
        weight: Lanes,
        acceleration: &mut [Lanes; D],
    ) {
        if let Some(repelled) = self.repulsion_stress(i, four, square) {
            let extra = packed_particles::product::<D>(&repelled, apart);
            (0..D).for_each(|c| acceleration[c] += extra[c] * weight);
        }
    }

    /// Acceleration of particle `i` by the particles of its own body (m/s²), which have a range of indices.
    pub fn acceleration_within(
        &self,
        i: usize,
        row: &[u32],
        weights: &mut [f64],
        body: &Range<usize>,
    ) -> [f64; D] {
        let own = self.neighbours_before(row, body.start)..self.neighbours_before(row, body.end);
        let mut by_obstacles = [0.0; D];
        let whole = self.acceleration(i, &row[own.clone()], &mut weights[own], Some(&mut by_obstacles));
        std::array::from_fn(|c| whole[c] - by_obstacles[c])
    }

    /// Acceleration of particle `i` by other bodies and their images (m/s²); the indices of its own body are a range.
    pub fn acceleration_by_others(
        &self,
        i: usize,
        row: &[u32],
        weights: &mut [f64],
        body: &Range<usize>,
    ) -> [f64; D] {
        let [own, rest] = [body.start, body.end].map(|number| self.neighbours_before(row, number));
        let [images, walls] = [self.particles.len(), self.first_wall_particle]
            .map(|number| self.neighbours_before(row, number));
        let of_others = |k: &usize| !body.contains(&self.source(row[*k] as usize));
        let parts = [0..own, rest..images].into_iter();
        let mut sum = [0.0; D];
        for part in parts.chain((images..walls).filter(of_others).map(|k| k..k + 1)) {
            if part.is_empty() {
                continue;
            }
            let mut by_obstacles = [0.0; D];
            let whole = self.acceleration(i, &row[part.clone()], &mut weights[part], Some(&mut by_obstacles));
            (0..D).for_each(|c| sum[c] += whole[c] - by_obstacles[c]);
        }
        sum
    }

    /// Adds the acceleration of particle `i` by its own image, corrections, mirrored walls, obstacles and short-range repulsion.
    fn other_accelerations(
        &self,
        i: usize,
        (row, weights): (&[u32], &[f64]),
        form: MomentumForm,
        sum: &mut [f64; D],
        by_obstacles: Option<&mut [f64; D]>,
    ) {
        let regular = self.first_mirrored(row);
        if let Some(close) = self.short_range_repulsion {
            self.add_image_repulsion(i, close, sum);
        }
        if self.options.momentum == MomentumEquation::Corrected {
            self.add_corrected(i, &row[..regular], weights, sum);
        }
        if !self.walls.smooth_bodies.is_empty() {
            self.smooth_acceleration(i, row, form, sum);
        }
        if regular < row.len() {
            self.wall_acceleration(i, &row[regular..], form, sum);
        }
        if !self.walls.obstacles.is_empty() {
            let before = *sum;
            self.obstacle_acceleration(i, form, sum);
            if let Some(own) = by_obstacles {
                *own = std::array::from_fn(|c| sum[c] - before[c]);
            }
        }
        if self.options.wall_guard > 0.0 {
            self.wall_repulsion(i, &row[self.neighbours_before(row, self.first_wall_particle)..], sum);
        }
    }

    /// Weights `F` of the kernels of the neighbours.
    fn weights_of_others(&self, four: [usize; 4], square: Lanes) -> Lanes {
        let square = square.to_array();
        let weight =
            |k: usize| self.kernel_of(self.particles.length[four[k]]).gradient_factor(square[k].sqrt());
        Lanes::new(std::array::from_fn(weight))
    }

    /// Viscous pair term `(α c π - β π²) / ρ` of approaching pairs (BN 111), with their vectors, squared distances and smoothing lengths.
    #[inline(always)]
    fn viscosity(
        &self,
        (own, mine): (&PackedKinematics<D>, &PackedState),
        (other, more): (&PackedKinematics<D>, &PackedState),
        (apart, square, h): (&[Lanes; D], Lanes, Lanes),
    ) -> Lanes {
        let relative: [Lanes; D] = std::array::from_fn(|c| other.v[c] - own.v[c]);
        let closing = packed_particles::dot(&relative, apart).fast_min(Lanes::splat(0.0));
        let softened = square + h * h * SOFTENING;
        let (sound, density) = (mine.sound + more.sound, own.density + other.density);
        let (linear, quadratic) = (self.options.viscosity_linear, self.options.viscosity_quadratic);
        // One division for both: π = h closing / softened.
        let product = h * closing;
        if quadratic == 0.0 {
            product * sound * linear / (softened * density)
        } else {
            product * (sound * softened * linear - product * (2.0 * quadratic))
                / (softened * softened * density)
        }
    }
}
