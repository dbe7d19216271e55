//! Averages of a field over listed neighbours (sheet: depth-sph §2.10).

use crate::kernel::Kernel;
use crate::points::phase_nodes::{NeighbourData, PlanVector};

/// Denominator below which an average over the nodes of a phase does not exist (sheet: depth-sph §2.10).
pub const NO_PARTNER: f64 = 1e-6;

/// Square of the distance of two positions (m²).
#[inline]
pub fn square<const D: usize>(a: &PlanVector<D>, b: &PlanVector<D>) -> f64 {
    (0..D).map(|c| (a[c] - b[c]).powi(2)).sum()
}

/// Kernel average `Σ (m/h) f W / Σ (m/h) W` of a field at a position; `None` if no node is within the support.
#[inline]
pub fn kernel_average<const D: usize, const N: usize>(
    kernel: Kernel,
    x: &PlanVector<D>,
    length: f64,
    data: &NeighbourData<D>,
    neighbours: impl Iterator<Item = usize>,
    field: impl Fn(usize) -> [f64; N],
) -> Option<[f64; N]> {
    let inverse = 1.0 / length;
    let support = kernel.support();
    let (mut weights, mut total) = (0.0, [0.0; N]);
    for j in neighbours {
        let q = square(x, &data.position[j]).sqrt() * inverse;
        if q < support {
            let weight = data.volume[j] / data.height[j] * kernel.profile::<D>(q);
            weights += weight;
            let value = field(j);
            for c in 0..N {
                total[c] += weight * value[c];
            }
        }
    }
    let whole = weights * kernel.factor::<D>() * inverse.powi(D as i32);
    (whole > NO_PARTNER).then(|| total.map(|sum| sum / weights))
}
