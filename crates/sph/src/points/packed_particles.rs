//! SIMD sums over four neighbours at a time.

use crate::kernel::{Kernel, Smoothing};

/// SIMD vector of one number of each of four neighbours.
pub use wide::f64x4 as Lanes;

/// Data of a particle for pair sums, in rows of four numbers: position and velocity; volume, density, speed of sound and smoothing length;
/// stress. The rows of four particles can be transposed into SIMD lanes. Volumes instead of masses save a division in most sums over pairs.
pub type PairRecord = [[f64; 4]; 4];

/// Returns the record of a particle.
#[inline(always)]
pub fn pair_record<const D: usize>(
    x: &[f64; D],
    v: &[f64; D],
    [volume, density, sound, length]: [f64; 4],
    [xx, yy, zz, xy, yz, zx]: [f64; 6],
) -> PairRecord {
    if D == 3 {
        [[x[0], x[1], x[2], volume], [v[0], v[1], v[2], density], [xx, yy, zz, xy], [yz, zx, sound, length]]
    } else {
        let (last_x, last_v) = if D == 2 { (x[1], v[1]) } else { (0.0, 0.0) };
        [[x[0], last_x, v[0], last_v], [volume, density, sound, length], [xx, yy, xy, 0.0], [0.0; 4]]
    }
}

/// Sets the velocity of a record.
#[inline(always)]
pub fn set_velocity<const D: usize>(record: &mut PairRecord, v: &[f64; D]) {
    if D == 3 {
        record[1][..D].copy_from_slice(v);
    } else {
        record[0][2..2 + D].copy_from_slice(v);
    }
}

/// Sets the volume of a record to zero, so that it does not contribute to neighbour sums.
#[inline(always)]
pub fn clear_volume<const D: usize>(record: &mut PairRecord) {
    if D == 3 {
        record[0][3] = 0.0;
    } else {
        record[1][0] = 0.0;
    }
}

/// Positions, velocities, volumes and densities of four particles.
pub struct PackedKinematics<const D: usize> {
    /// Position (m).
    pub x: [Lanes; D],
    /// Velocity (m/s).
    pub v: [Lanes; D],
    /// Volume (m³).
    pub volume: Lanes,
    /// Density (kg/m³).
    pub density: Lanes,
}

/// Remaining fields of four particles.
pub struct PackedState {
    /// Sound speed (m/s).
    pub sound: Lanes,
    /// Smoothing length (m).
    pub length: Lanes,
    /// Stress components in the order of `SymTensor` (Pa).
    pub stress: [Lanes; 6],
}

/// Transposes a row of four records into lanes. Not `Lanes::transpose`, which is not inlined.
#[inline(always)]
fn transpose([a, b, c, d]: [&PairRecord; 4], row: usize) -> [Lanes; 4] {
    let (a, b, c, d) = (&a[row], &b[row], &c[row], &d[row]);
    let lane = |k: usize| Lanes::new([a[k], b[k], c[k], d[k]]);
    [lane(0), lane(1), lane(2), lane(3)]
}

/// Returns the lanes of position, velocity, volume and density.
#[inline(always)]
pub fn packed_kinematics<const D: usize>(four: [&PairRecord; 4]) -> PackedKinematics<D> {
    let (first, second) = (transpose(four, 0), transpose(four, 1));
    if D == 3 {
        PackedKinematics {
            x: std::array::from_fn(|c| first[c]),
            v: std::array::from_fn(|c| second[c]),
            volume: first[3],
            density: second[3],
        }
    } else {
        PackedKinematics {
            x: std::array::from_fn(|c| first[c]),
            v: std::array::from_fn(|c| first[2 + c]),
            volume: second[0],
            density: second[1],
        }
    }
}

/// Returns the lanes of the remaining fields.
#[inline(always)]
pub fn packed_state<const D: usize>(four: [&PairRecord; 4]) -> PackedState {
    if D == 3 {
        let ([xx, yy, zz, xy], [yz, zx, sound, length]) = (transpose(four, 2), transpose(four, 3));
        PackedState { sound, length, stress: [xx, yy, zz, xy, yz, zx] }
    } else {
        let ([_, _, sound, length], [xx, yy, xy, zero]) = (transpose(four, 1), transpose(four, 2));
        PackedState { sound, length, stress: [xx, yy, zero, xy, zero, zero] }
    }
}

/// Product of a symmetric tensor and a vector.
#[inline(always)]
pub fn product<const D: usize>(tensor: &[Lanes; 6], x: &[Lanes; D]) -> [Lanes; D] {
    // Component (a, b) of a SymTensor.
    /// Position of matrix component `[i][j]` in the array of a symmetric tensor.
    const COMPONENT_INDEX: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
    std::array::from_fn(|a| {
        let mut sum = tensor[COMPONENT_INDEX[a][0]] * x[0];
        for b in 1..D {
            sum += tensor[COMPONENT_INDEX[a][b]] * x[b];
        }
        sum
    })
}

/// Scalar product `a·b`.
#[inline(always)]
pub fn dot<const D: usize>(a: &[Lanes; D], b: &[Lanes; D]) -> Lanes {
    let mut sum = a[0] * b[0];
    for c in 1..D {
        sum += a[c] * b[c];
    }
    sum
}

/// Sum of the lanes, in the same order on every machine.
#[inline(always)]
pub fn sum(lanes: Lanes) -> f64 {
    let [a, b, c, d] = lanes.to_array();
    (a + b) + (c + d)
}

/// Groups of four neighbours: index of the first entry, the neighbours and the number of valid ones. The last group is filled up with the
/// particle itself, whose distance is zero.
pub struct GroupsOfFour<'a> {
    left: &'a [u32],
    start: usize,
    own: usize,
}

impl<'a> GroupsOfFour<'a> {
    /// Groups of the neighbours `row` of the particle `own`.
    #[inline(always)]
    pub fn new(row: &'a [u32], own: usize) -> Self {
        Self { left: row, start: 0, own }
    }
}

impl Iterator for GroupsOfFour<'_> {
    type Item = (usize, [usize; 4], usize);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let (left, start) = (self.left, self.start);
        if left.is_empty() {
            return None;
        }
        let (four, count) = match left.first_chunk::<4>() {
            Some(four) => (four.map(|j| j as usize), 4),
            None => {
                let of = |k: usize| left.get(k).map_or(self.own, |&j| j as usize);
                ([of(0), of(1), of(2), self.own], left.len())
            }
        };
        (self.left, self.start) = (&left[count..], start + 4);
        Some((start, four, count))
    }
}

/// Loads four numbers; zero beyond the end of `values`.
#[inline(always)]
pub fn load_four(values: &[f64], start: usize, count: usize) -> Lanes {
    match values[start..].first_chunk::<4>() {
        Some(four) if count == 4 => Lanes::new(*four),
        _ => {
            let mut four = [0.0; 4];
            four[..count].copy_from_slice(&values[start..start + count]);
            Lanes::new(four)
        }
    }
}

/// Stores the first `count` lanes from index `start` on.
#[inline(always)]
pub fn store_four(values: &mut [f64], start: usize, count: usize, lanes: Lanes) {
    let lanes = lanes.to_array();
    match values[start..].first_chunk_mut::<4>() {
        Some(four) if count == 4 => *four = lanes,
        _ => values[start..start + count].iter_mut().zip(lanes).for_each(|(value, lane)| *value = lane),
    }
}

/// Power `x^n` for `n` from 2 to 7.
#[inline(always)]
fn power(x: Lanes, n: u32) -> Lanes {
    match n {
        2 => x * x,
        3 => x * x * x,
        4 => (x * x) * (x * x),
        5 => (x * x) * (x * x) * x,
        6 => (x * x * x) * (x * x * x),
        _ => (x * x * x) * (x * x * x) * x,
    }
}

/// Power `x^n` of any whole `n`.
#[inline(always)]
pub fn whole_power(mut x: Lanes, mut n: u32) -> Lanes {
    let mut product = Lanes::splat(1.0);
    while n > 0 {
        if n % 2 == 1 {
            product *= x;
        }
        x *= x;
        n /= 2;
    }
    product
}

impl<const D: usize> Smoothing<D> {
    /// Kernel values `W` of four squared distances, like [`Smoothing::value`].
    #[inline]
    pub(crate) fn values(&self, square: Lanes) -> Lanes {
        let (zero, one, two) = (Lanes::splat(0.0), Lanes::splat(1.0), Lanes::splat(2.0));
        let clip = |x: Lanes| x.fast_max(zero);
        let q = square.sqrt() * self.inverse;
        let t = clip(one - q * 0.5);
        let profile = match self.kernel {
            // (2 - q)³/6 - 2 (1 - q)³/3.
            Kernel::CubicSpline => (power(clip(two - q), 3) - power(clip(one - q), 3) * 4.0) / 6.0,
            Kernel::Gaussian => (zero - q * q).exp(),
            Kernel::Quadratic => t * t * 0.75,
            Kernel::QuinticSpline => {
                let three = Lanes::splat(3.0);
                power(clip(three - q), 5) - power(clip(two - q), 5) * 6.0 + power(clip(one - q), 5) * 15.0
            }
            Kernel::WendlandC2 if D == 1 => power(t, 3) * (q * 1.5 + 1.0),
            Kernel::WendlandC2 => power(t, 4) * (q * 2.0 + 1.0),
            Kernel::WendlandC4 => power(t, 6) * ((q * (35.0 / 12.0) + 3.0) * q + 1.0),
            Kernel::WendlandC6 => power(t, 7) * t * (((q * 4.0 + 6.25) * q + 4.0) * q + 1.0),
        };
        let inside = (q * self.length).simd_lt(Lanes::splat(self.radius));
        inside & (profile * self.constant)
    }

    /// Kernel weights `F = -W'/r` of four squared distances, like [`Smoothing::gradient_factor`].
    #[inline(always)]
    pub(crate) fn weights(&self, square: Lanes) -> Lanes {
        self.weights_of(self.kernel, square)
    }

    /// [`Smoothing::weights`] where the kernel is known to the compiler.
    #[inline(always)]
    pub(crate) fn weights_of(&self, kernel: Kernel, square: Lanes) -> Lanes {
        let (zero, one, two) = (Lanes::splat(0.0), Lanes::splat(1.0), Lanes::splat(2.0));
        let clip = |x: Lanes| x.fast_max(zero);
        // Coincident particles: the gradient is zero, since their distance is.
        let q = (square.sqrt() * self.inverse).fast_max(Lanes::splat(1e-12));
        let t = clip(one - q * 0.5);
        let steepness = match kernel {
            // 2 - 3q/2 up to 1, (2 - q)²/(2q) from there on.
            Kernel::CubicSpline => (power(clip(two - q), 2) - power(clip(one - q), 2) * 4.0) / (q * 2.0),
            Kernel::Gaussian => (zero - q * q).exp() * 2.0,
            Kernel::Quadratic => t * 0.75 / q,
            Kernel::QuinticSpline => {
                let three = Lanes::splat(3.0);
                let slope = power(clip(three - q), 4) - power(clip(two - q), 4) * 6.0
                    + power(clip(one - q), 4) * 15.0;
                slope * 5.0 / q
            }
            Kernel::WendlandC2 if D == 1 => t * t * 3.0,
            Kernel::WendlandC2 => power(t, 3) * 5.0,
            Kernel::WendlandC4 => power(t, 5) * (q * (35.0 / 3.0) + 14.0 / 3.0),
            Kernel::WendlandC6 => power(t, 7) * 2.75 * ((q * 8.0 + 7.0) * q + 2.0),
        };
        let inside = (q * self.length).simd_lt(Lanes::splat(self.radius));
        inside & (steepness * (self.constant * self.inverse * self.inverse))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn agrees<const D: usize>() {
        for kernel in Kernel::ALL {
            let Ok(smoothing) = Smoothing::<D>::new(kernel, 0.37) else { continue };
            let scale = smoothing.gradient_factor(0.05);
            for k in 0..100 {
                let r: [f64; 4] = std::array::from_fn(|lane| 0.003 * f64::from(4 * k + lane as i32) + 1e-4);
                let values = smoothing.values(Lanes::new(r.map(|r| r * r))).to_array();
                for (r, value) in r.iter().zip(values) {
                    assert!(
                        (value - smoothing.value(*r)).abs() < 1e-13 * smoothing.value(0.0),
                        "{kernel:?} {D}D at {r}"
                    );
                }
                let found = smoothing.weights(Lanes::new(r.map(|r| r * r))).to_array();
                for (r, found) in r.iter().zip(found) {
                    assert!(
                        (found - smoothing.gradient_factor(*r)).abs() < 1e-12 * scale,
                        "{kernel:?} {D}D at {r}"
                    );
                }
            }
            assert!(smoothing.weights(Lanes::splat(0.0)).to_array().iter().all(|w| w.is_finite()));
        }
    }

    #[test]
    fn packed_kernel_weights_equal_scalar_weights() {
        agrees::<1>();
        agrees::<2>();
        agrees::<3>();
    }

    #[test]
    fn whole_powers_are_products() {
        for n in 0..12u32 {
            let found = whole_power(Lanes::new([0.0, 0.5, 1.0, 3.0]), n).to_array();
            assert_eq!(found, [0.0, 0.5, 1.0, 3.0].map(|x: f64| x.powi(n as i32)), "power {n}");
        }
    }

    #[test]
    fn rows_of_any_length_are_visited_once() {
        for length in 0..11u32 {
            let row: Vec<u32> = (10..10 + length).collect();
            let mut visited = Vec::new();
            for (start, four, count) in GroupsOfFour::new(&row, 7) {
                assert_eq!(start, visited.len());
                assert!(four[count..].iter().all(|&j| j == 7));
                visited.extend(four[..count].iter().map(|&j| j as u32));
            }
            assert_eq!(visited, row);
        }
        assert_eq!(load_four(&[1.0, 2.0, 3.0, 4.0, 5.0], 4, 1).to_array(), [5.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn packed_records_return_the_stored_values() {
        let of = |k: f64| {
            pair_record::<3>(
                &[k, k + 1.0, k + 2.0],
                &[0.0; 3],
                [k + 3.0, k + 4.0, k + 5.0, k + 6.0],
                [7.0, 8.0, 9.0, 10.0, 11.0, k],
            )
        };
        let mut all = [of(0.0), of(10.0), of(20.0), of(30.0)];
        set_velocity(&mut all[2], &[1.0, 2.0, 3.0]);
        let four = [&all[0], &all[1], &all[2], &all[3]];
        let m = packed_kinematics::<3>(four);
        assert_eq!(m.x[2].to_array(), [2.0, 12.0, 22.0, 32.0]);
        assert_eq!(m.v[1].to_array(), [0.0, 0.0, 2.0, 0.0]);
        assert_eq!(m.density.to_array(), [4.0, 14.0, 24.0, 34.0]);
        let r = packed_state::<3>(four);
        assert_eq!(r.sound.to_array(), [5.0, 15.0, 25.0, 35.0]);
        assert_eq!(r.stress[5].to_array(), [0.0, 10.0, 20.0, 30.0]);
        let p = product::<3>(&r.stress, &[Lanes::splat(1.0), Lanes::splat(0.0), Lanes::splat(0.0)]);
        assert_eq!(p.map(|l| l.to_array()[1]), [7.0, 10.0, 10.0]);
    }
}
