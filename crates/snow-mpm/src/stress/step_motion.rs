//! Deformation of the points of a block in a step, and the work of their stresses: each component of all points in an array of its own
//! (sheet: snow-mpm §3.5, step 4).

use colluvium_constitutive::{BLOCK_SIZE, MotionBlock, SymTensor};
use colluvium_grid::{InterpolatedMotion, SquareMatrix};

use crate::config::DeformationUpdate;

/// Values of one component at a group of points.
type BlockArray = [f64; BLOCK_SIZE];

/// Computes gradients and deformations of the points from the interpolated motions `reads`, in a step of `motions.dt`. Returns the
/// changes of their volumes.
pub fn find_motions<const D: usize>(
    reads: &[InterpolatedMotion<D>],
    how: DeformationUpdate,
    motions: &mut MotionBlock,
) -> BlockArray {
    let dt = motions.dt;
    motions.set_gradients(reads.iter().map(|read| read.gradient.map(|column| (column * dt).to_array())));
    match how {
        DeformationUpdate::Linear => motions.deform_linearly::<D>(),
        DeformationUpdate::Exponential => deform_exponentially::<D>(motions),
    }
    motions.volume_ratios()
}

/// Sets the deformation gradients of the step to the exponentials of the velocity gradients times the step.
fn deform_exponentially<const D: usize>(motions: &mut MotionBlock) {
    for p in 0..BLOCK_SIZE {
        let f = exponential(&matrix::<D>(&motions.velocity_gradient_dt, p));
        for i in 0..D {
            for j in 0..D {
                motions.deformation[3 * i + j][p] = f[i][j];
            }
        }
    }
}

/// Work of the stresses in a step over the logarithmic strain (J), with the mean of `V σ` before and after the step. It is of second order
/// in the step.
pub struct StressWork {
    previous_stress: [BlockArray; 6],
}

impl StressWork {
    /// Work record with the stresses before the step.
    pub fn before_step<const D: usize>(stress: &[SymTensor]) -> Self {
        Self { previous_stress: components::<D>(stress) }
    }

    /// Adds the work of the step to `work`, from volumes and stresses after the step and volume ratios.
    pub fn add<const D: usize>(
        &self,
        motions: &MotionBlock,
        stretches: &BlockArray,
        (volume, stress): (&[f64], &[SymTensor]),
        work: &mut [f64],
    ) {
        let (before, after) = (&self.previous_stress, components::<D>(stress));
        let (mut volumes, mut done) = ([0.0; BLOCK_SIZE], [0.0; BLOCK_SIZE]);
        volumes[..volume.len()].copy_from_slice(volume);
        for p in 0..BLOCK_SIZE {
            let started = volumes[p] / stretches[p];
            let mean = |c: usize| before[c][p] * (0.5 * started) + after[c][p] * (0.5 * volumes[p]);
            // Logarithmic strain of the step, to the third order; zero outside the axes of the space.
            let gradient: SquareMatrix<D> = matrix(&motions.velocity_gradient_dt, p);
            let squared = product(&gradient, &gradient);
            let part = |i: usize, j: usize| gradient[i][j] - squared[i][j] * 0.5;
            let strain = |i: usize, j: usize| 0.5 * (part(i, j) + part(j, i));
            let (mut along, mut across) = (0.0, 0.0);
            for i in 0..D {
                along += mean(i) * part(i, i);
            }
            // xy, yz, zx.
            for k in 3..2 * D {
                across += mean(k) * strain(k - 3, (k - 2) % 3);
            }
            done[p] = along + 2.0 * across;
        }
        work.iter_mut().zip(&done).for_each(|(work, done)| *work += done);
    }
}

/// Components of the stresses in `D` dimensions.
#[inline(always)]
fn components<const D: usize>(stress: &[SymTensor]) -> [BlockArray; 6] {
    let mut lanes = [[0.0; BLOCK_SIZE]; 6];
    for (p, stress) in stress.iter().enumerate().take(BLOCK_SIZE) {
        for i in 0..D {
            lanes[i][p] = stress.0[i];
        }
        for k in 3..2 * D {
            lanes[k][p] = stress.0[k];
        }
    }
    lanes
}

/// Matrix of point `p` from one array per component.
#[inline(always)]
fn matrix<const D: usize>(lanes: &[BlockArray; 9], p: usize) -> SquareMatrix<D> {
    let mut matrix = [[0.0; D]; D];
    for i in 0..D {
        for j in 0..D {
            matrix[i][j] = lanes[3 * i + j][p];
        }
    }
    matrix
}

/// Product of two square matrices.
#[inline(always)]
fn product<const D: usize>(a: &SquareMatrix<D>, b: &SquareMatrix<D>) -> SquareMatrix<D> {
    let mut product = [[0.0; D]; D];
    for i in 0..D {
        for j in 0..D {
            for k in 0..D {
                product[i][j] += a[i][k] * b[k][j];
            }
        }
    }
    product
}

/// Sum `1 + a`.
#[inline(always)]
fn identity_plus<const D: usize>(a: &SquareMatrix<D>) -> SquareMatrix<D> {
    let mut sum = *a;
    for i in 0..D {
        sum[i][i] += 1.0;
    }
    sum
}

/// Matrix times a factor.
#[inline(always)]
fn scaled<const D: usize>(a: &SquareMatrix<D>, factor: f64) -> SquareMatrix<D> {
    let mut scaled = *a;
    for i in 0..D {
        for j in 0..D {
            scaled[i][j] *= factor;
        }
    }
    scaled
}

/// Exponential `exp a`, to the fourth order.
#[inline(always)]
fn exponential<const D: usize>(a: &SquareMatrix<D>) -> SquareMatrix<D> {
    let mut sum = identity_plus(&scaled(a, 0.25));
    for share in [1.0 / 3.0, 0.5, 1.0] {
        sum = identity_plus(&scaled(&product(a, &sum), share));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn updates_without_the_exponential_strain_a_rotating_body() {
        // Sheet: snow-mpm V3: each principal logarithmic strain after a turn, `N/2 ln(1 + (2π/N)²)`.
        for (steps, exact) in [(100, 0.197_003_474_1), (1000, 0.019_738_819_2), (10_000, 0.001_973_920_5)] {
            let angle = 2.0 * std::f64::consts::PI / f64::from(steps);
            let step = identity_plus(&[[0.0, -angle], [angle, 0.0]]);
            let [[a, b], [c, d]] = (0..steps).fold(identity_plus(&[[0.0; 2]; 2]), |f, _| product(&step, &f));
            let strain = 0.5 * (a * d - b * c).ln();
            assert!((strain - exact).abs() < 1e-9, "{steps}: {strain}");
        }
    }

    #[test]
    fn a_thousand_small_rotations_make_a_turn_without_strain() {
        let angle = 2.0 * std::f64::consts::PI / 1000.0;
        let step = exponential(&[[0.0, -angle, 0.0], [angle, 0.0, 0.0], [0.0; 3]]);
        let turned = (0..1000).fold(identity_plus(&[[0.0; 3]; 3]), |f, _| product(&step, &f));
        for (i, row) in turned.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                assert!((value - if i == j { 1.0 } else { 0.0 }).abs() < 1e-8, "{turned:?}");
            }
        }
    }
}
