//! Smoothing and diffusion beside the equations of motion (sheet: sph §2.10, §2.12). Options, off by default:
//! plain loops.

use std::ops::Range;

use colluvium_constitutive::SymTensor;

use crate::config::MAX_SHIFT;
use crate::pairs::PairContext;
use crate::pairs::operators::{GradientMoment, product};
use crate::points::particles::SquareMatrix;
use crate::points::vector_algebra::{geostatic_stress, separation};

/// Softening of the stress diffusion for coincident particles (sheet: sph §2.10).
const SOFTENING: f64 = 1e-4;
/// Strength and exponent of the shifting term against coincident particles.
const CLOSE_PAIR_TERM: (f64, i32) = (0.2, 4);

/// Shift of a particle towards even spacing, with the changes of its fields.
#[derive(Clone)]
pub struct Shift<const D: usize> {
    /// Displacement (m).
    pub displacement: [f64; D],
    /// Change of velocity (m/s).
    pub velocity: [f64; D],
    /// Change of density (kg/m³).
    pub density: f64,
    /// Change of stress (Pa).
    pub stress: SymTensor,
}

impl<const D: usize> PairContext<'_, D> {
    /// Kernel average of the velocities of the neighbours relative to the particle (m/s), for XSPH without its factor.
    pub fn xsph_velocity(&self, i: usize, row: &[u32]) -> [f64; D] {
        let p = self.particles;
        let mut sum = [0.0; D];
        for &j in &row[..self.neighbours_before(row, self.first_wall_particle)] {
            let j = j as usize;
            if self.walls.smooth_bodies.contain(j) {
                continue;
            }
            let (_, square) = separation(&p.position[i], &p.position[j]);
            let weight = 2.0 * p.mass[j] / (p.density[i] + p.density[j]) * self.value(i, j, square.sqrt());
            for c in 0..D {
                sum[c] += weight * (p.velocity[j][c] - p.velocity[i][c]);
            }
        }
        sum
    }

    /// Hourglass acceleration without its factor (m/s²). It is the artificial viscosity of BN 111 with the relative velocity of a pair
    /// reduced by its linear part, for approaching and separating pairs. It follows the hourglass viscosity of Flanagan & Belytschko (1981)
    /// in the pairwise form of Ganzenmüller (2015), and conserves linear and angular momentum.
    pub fn hourglass_acceleration(
        &self,
        i: usize,
        (row, weights): (&[u32], &[f64]),
        gradients: &[SquareMatrix<D>],
    ) -> [f64; D] {
        let p = self.particles;
        let mut sum = [0.0; D];
        for (&j, weight) in row[..self.neighbours_before(row, self.first_wall_particle)].iter().zip(weights) {
            let j = j as usize;
            if self.walls.smooth_bodies.contain(j) {
                continue;
            }
            let gradient = if j < p.len() {
                gradients[j]
            } else {
                let image = &self.walls.images[j - p.len()];
                image.gradient(&gradients[image.source as usize])
            };
            let (apart, square) = separation(&p.position[i], &p.position[j]);
            let unseen = |c: usize| {
                let expected: f64 = (0..D).map(|b| (gradients[i][c][b] + gradient[c][b]) * apart[b]).sum();
                p.velocity[j][c] - p.velocity[i][c] - 0.5 * expected
            };
            let along: f64 = (0..D).map(|c| unseen(c) * apart[c]).sum();
            let h = 0.5 * (p.length[i] + p.length[j]);
            let viscosity = h * (p.sound[i] + p.sound[j]) / (p.density[i] + p.density[j]);
            let weight_factor =
                p.mass[j] * weight * viscosity * along / (square + crate::pairs::SOFTENING * h * h);
            (0..D).for_each(|c| sum[c] += weight_factor * apart[c]);
        }
        sum
    }

    /// Summed density `Σ m W`, the particle itself included (BN 2).
    pub fn summed_density(&self, i: usize, row: &[u32]) -> f64 {
        let p = self.particles;
        let mut sum = p.mass[i] * self.smoothing.value(0.0);
        for &j in row {
            let j = j as usize;
            let k = self.effective_index(i, j);
            let (_, square) = separation(&p.position[i], &p.position[j]);
            sum += p.mass[k] * self.smoothing.value(square.sqrt());
        }
        sum
    }

    /// Divergence `-ρ̇/ρ` by the diffusion of density within `body`, without `2 δ` (δ-SPH).
    pub fn density_diffusion(&self, i: usize, (row, weights): (&[u32], &[f64]), body: &Range<usize>) -> f64 {
        let p = self.particles;
        let mut sum = 0.0;
        for (&j, weight) in row[..self.neighbours_before(row, self.first_wall_particle)].iter().zip(weights) {
            let j = j as usize;
            if body.contains(&self.source(j)) {
                sum += p.mass[j] / p.density[j] * (p.density[j] - p.density[i]) * weight;
            }
        }
        -p.length[i] * p.sound[i] * sum / p.density[i]
    }

    /// Stress rate of the stress diffusion within `body`, without `2 ζ`; the geostatic difference under `gravity` is
    /// excluded.
    pub fn stress_diffusion(
        &self,
        i: usize,
        (row, weights): (&[u32], &[f64]),
        gravity: &[f64; D],
        body: &Range<usize>,
    ) -> SymTensor {
        let p = self.particles;
        let size = gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        let mut sum = SymTensor::ZERO;
        for (&j, &weight) in row[..self.neighbours_before(row, self.first_wall_particle)].iter().zip(weights)
        {
            let j = j as usize;
            if weight == 0.0 || !body.contains(&self.source(j)) {
                continue;
            }
            let (apart, square) = separation(&p.position[i], &p.position[j]);
            let mut difference = p.stress[i] - p.stress[j];
            if size > 0.0 {
                difference -= self.geostatic_difference(&apart, gravity, size, p.density[i]);
            }
            let h = p.length[i];
            // x_ij·∇W = -F r².
            let factor = p.mass[j] / p.density[j] * weight * square / (square + SOFTENING * h * h);
            sum += difference * -factor;
        }
        sum * (p.length[i] * p.sound[i])
    }

    /// Difference of geostatic stress between a particle and a neighbour at the distance vector `apart` (m).
    fn geostatic_difference(
        &self,
        apart: &[f64; D],
        gravity: &[f64; D],
        size: f64,
        density: f64,
    ) -> SymTensor {
        let up = gravity.map(|g| -g / size);
        let rise: f64 = -(0..D).map(|c| up[c] * apart[c]).sum::<f64>();
        let k0 = self.options.stress_diffusion_k0;
        geostatic_stress(density * size * rise, k0, &up)
    }

    /// Displacement of particle `i` of `body` towards even spacing, after a motion by `length` in the step (m; sheet: sph §2.12). `None`
    /// close to free surfaces. Density and stress are discontinuous between bodies: their gradients are those within the body.
    pub fn shift(
        &self,
        i: usize,
        row: &[u32],
        length: f64,
        (body, surface): (&Range<usize>, &[bool]),
    ) -> Option<Shift<D>> {
        let p = self.particles;
        let (h, reference) = (p.length[i], self.smoothing.value(self.options.spacing));
        let mut crowding = [0.0; D];
        let (mut all, mut within) = (GradientMoment::default(), GradientMoment::default());
        let (mut velocity, mut fields) = ([[0.0; D]; D], [[0.0; D]; 7]);
        for &j in row {
            let j = j as usize;
            if j < p.len() && surface[j] {
                return None;
            }
            let (apart, square) = separation(&p.position[i], &p.position[j]);
            if square >= self.support_square() {
                continue;
            }
            let (k, r) = (self.effective_index(i, j), square.sqrt());
            let weight = p.mass[k] / p.density[k] * self.pair_gradient_factor(i, k, r);
            let ratio = self.kernel_ratio_argument(i, k, r) / reference;
            let close = 1.0 + CLOSE_PAIR_TERM.0 * ratio.powi(CLOSE_PAIR_TERM.1);
            (0..D).for_each(|c| crowding[c] += weight * close * apart[c]);
            if j >= self.first_wall_particle || self.walls.smooth_bodies.contain(j) {
                continue;
            }
            all.add(weight, &apart);
            for (a, slope) in velocity.iter_mut().enumerate() {
                let difference = p.velocity[j][a] - p.velocity[i][a];
                (0..D).for_each(|c| slope[c] += weight * difference * apart[c]);
            }
            if !body.contains(&self.source(j)) {
                continue;
            }
            within.add(weight, &apart);
            let mut differences = [p.density[j] - p.density[i]; 7];
            differences[1..].copy_from_slice(&(p.stress[j] - p.stress[i]).0);
            for (slope, difference) in fields.iter_mut().zip(differences) {
                (0..D).for_each(|c| slope[c] += weight * difference * apart[c]);
            }
        }
        let (all, within) = (all.correction()?, within.correction()?);
        let scale = -self.options.shifting * h * length;
        let size = crowding.iter().map(|c| c * c).sum::<f64>().sqrt() * scale.abs();
        let limit = MAX_SHIFT * self.options.spacing;
        let scale = if size > limit { scale * limit / size } else { scale };
        let displacement = crowding.map(|c| c * scale);
        let change = |correction: &SquareMatrix<D>, slope: &[f64; D]| -> f64 {
            product(correction, slope).iter().zip(&displacement).map(|(g, x)| g * x).sum()
        };
        Some(Shift {
            displacement,
            velocity: std::array::from_fn(|c| change(&all, &velocity[c])),
            density: change(&within, &fields[0]),
            stress: SymTensor(std::array::from_fn(|c| change(&within, &fields[1 + c]))),
        })
    }

    /// Squared distance beyond which the kernel weight of a pair is zero (m²).
    #[inline]
    fn support_square(&self) -> f64 {
        if self.options.is_variable() { f64::INFINITY } else { self.smoothing.radius().powi(2) }
    }

    /// Kernel gradient over distance of a pair at distance `r` (m), `W'(r)/r`.
    #[inline]
    fn pair_gradient_factor(&self, i: usize, j: usize, r: f64) -> f64 {
        if self.options.is_variable() {
            self.pair_kernel(i, j, r)[0]
        } else {
            self.smoothing.gradient_factor(r)
        }
    }

    /// Trace of the moment of particle `i`.
    pub fn moment_trace(&self, i: usize, row: &[u32]) -> f64 {
        let (p, support, mut squares) = (self.particles, self.support_square(), [0.0; D]);
        for &j in row {
            let j = j as usize;
            let (apart, square) = separation(&p.position[i], &p.position[j]);
            if square < support {
                let k = self.effective_index(i, j);
                let weight = p.mass[k] / p.density[k] * self.pair_gradient_factor(i, k, square.sqrt());
                (0..D).for_each(|c| squares[c] += weight * apart[c] * apart[c]);
            }
        }
        squares.iter().sum()
    }

    /// Gradient moment `M = Σ V F x ⊗ x`, whose trace decreases at free surfaces (sheet: sph §2.13 h).
    pub(crate) fn moment(&self, i: usize, row: &[u32]) -> GradientMoment<D> {
        let mut moment = GradientMoment::default();
        self.for_each_weighted(i, row, |weight, apart| moment.add(weight, apart));
        moment
    }

    /// Uncorrected gradient of a constant field of value one, `Σ V ∇W` (1/m) (BN 19).
    pub fn gradient_of_constant(&self, i: usize, row: &[u32]) -> [f64; D] {
        let mut sum = [0.0; D];
        self.for_each_weighted(i, row, |weight, apart| (0..D).for_each(|c| sum[c] += weight * apart[c]));
        sum
    }

    /// Calls `visit(V F, x_j - x_i)` for every neighbour; dummy particles and smooth bodies have the volume of the particle.
    #[inline]
    fn for_each_weighted(&self, i: usize, row: &[u32], mut visit: impl FnMut(f64, &[f64; D])) {
        let p = self.particles;
        for &j in row {
            let j = j as usize;
            let k = self.effective_index(i, j);
            let (apart, square) = separation(&p.position[i], &p.position[j]);
            visit(p.mass[k] / p.density[k] * self.pair_gradient_factor(i, k, square.sqrt()), &apart);
        }
    }

    /// Rate `ḣ` of the smoothing length (m/s) of AL1 36–37, with `ρ̇` from the corrected gradient.
    pub fn length_rate(&self, i: usize, row: &[u32], weights: &[f64]) -> f64 {
        let p = self.particles;
        let kernel = self.kernel_of(p.length[i]);
        let (mut moment, mut gradient) = (GradientMoment::default(), [[0.0; D]; D]);
        let (mut rate, mut slope) = (0.0, p.mass[i] * kernel.length_derivative(0.0));
        for (&j, &weight) in row[..self.first_mirrored(row)].iter().zip(weights) {
            let j = j as usize;
            if self.walls.smooth_bodies.contain(j) {
                continue;
            }
            let (apart, square) = separation(&p.position[i], &p.position[j]);
            let volume = p.mass[j] / p.density[j] * weight;
            slope += p.mass[j] * kernel.length_derivative(square.sqrt());
            moment.add(volume, &apart);
            for a in 0..D {
                let relative = p.velocity[j][a] - p.velocity[i][a];
                rate -= p.mass[j] * weight * relative * apart[a];
                for b in 0..D {
                    gradient[a][b] += volume * relative * apart[b];
                }
            }
        }
        let Some(l) = moment.correction() else { return 0.0 };
        let divergence: f64 = (0..D).map(|a| product(&l, &gradient[a])[a]).sum();
        if slope == 0.0 { 0.0 } else { (-p.density[i] * divergence - rate) / slope }
    }
}
