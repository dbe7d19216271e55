//! Smoothing kernels (sheet: sph §2.2).
//!
//! A kernel is `W(r, h) = α w(q)` with `q = r / h`; `α` normalises it in one, two or three
//! dimensions. [`Kernel`] selects the function, [`Smoothing`] adds dimension and smoothing length.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Smoothing kernel `W(r, h)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Kernel {
    /// Gaussian, truncated at three smoothing lengths.
    Gaussian,
    /// Cubic spline.
    #[default]
    CubicSpline,
    /// Quadratic, whose slope at the centre is not zero: resists clumping in compression.
    Quadratic,
    /// Quintic spline, support three smoothing lengths.
    QuinticSpline,
    /// Wendland C2; in 1D the one-dimensional polynomial.
    WendlandC2,
    /// Wendland C4, in 2D and 3D.
    WendlandC4,
    /// Wendland C6, in 2D and 3D.
    WendlandC6,
}

/// Reason why a smoothing kernel cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum KernelError {
    /// The kernel has no constant in this dimension.
    #[error("{kernel:?} is not defined in {dimension} dimension(s)")]
    Dimension {
        /// The kernel.
        kernel: Kernel,
        /// Number of dimensions.
        dimension: usize,
    },
    /// Invalid smoothing length.
    #[error("smoothing length {0} must be finite and positive (m)")]
    Length(f64),
}

impl KernelError {
    /// Stable code of the error, which `docs/messages.md` of the repository explains.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Dimension { .. } => "kernel",
            Self::Length(_) => "out-of-range",
        }
    }
}

/// Truncated power `x_+^n`.
fn positive_power(x: f64, n: i32) -> f64 {
    x.max(0.0).powi(n)
}

impl Kernel {
    /// All kernels.
    pub const ALL: [Self; 7] = [
        Self::Gaussian,
        Self::CubicSpline,
        Self::Quadratic,
        Self::QuinticSpline,
        Self::WendlandC2,
        Self::WendlandC4,
        Self::WendlandC6,
    ];

    /// Radius of the support over the smoothing length.
    pub fn support(self) -> f64 {
        match self {
            Self::Gaussian | Self::QuinticSpline => 3.0,
            _ => 2.0,
        }
    }

    /// Normalisation constant `α h^d`; `None` where the sheet has none.
    pub fn constant(self, dimension: usize) -> Option<f64> {
        let table = match self {
            Self::Gaussian => [1.0 / PI.sqrt(), 1.0 / PI, PI.powf(-1.5)],
            Self::CubicSpline => [1.0, 15.0 / (7.0 * PI), 1.5 / PI],
            Self::Quadratic => [1.0, 2.0 / PI, 1.25 / PI],
            Self::QuinticSpline => [1.0 / 120.0, 7.0 / (478.0 * PI), 1.0 / (120.0 * PI)],
            Self::WendlandC2 => [0.625, 1.75 / PI, 21.0 / (16.0 * PI)],
            Self::WendlandC4 => [f64::NAN, 2.25 / PI, 495.0 / (256.0 * PI)],
            Self::WendlandC6 => [f64::NAN, 39.0 / (14.0 * PI), 1365.0 / (512.0 * PI)],
        };
        dimension.checked_sub(1).and_then(|d| table.get(d)).copied().filter(|c| c.is_finite())
    }

    /// Kernel profile `w(q)`. The Gaussian is not truncated here.
    #[inline]
    pub fn profile(self, dimension: usize, q: f64) -> f64 {
        let t = (1.0 - 0.5 * q).max(0.0);
        match self {
            Self::Gaussian => (-q * q).exp(),
            Self::CubicSpline if q < 1.0 => 2.0 / 3.0 - q * q + 0.5 * q * q * q,
            Self::CubicSpline => positive_power(2.0 - q, 3) / 6.0,
            Self::Quadratic if q < 2.0 => 0.75 * t * t,
            Self::Quadratic => 0.0,
            Self::QuinticSpline => {
                positive_power(3.0 - q, 5) - 6.0 * positive_power(2.0 - q, 5)
                    + 15.0 * positive_power(1.0 - q, 5)
            }
            Self::WendlandC2 if dimension == 1 => t.powi(3) * (1.0 + 1.5 * q),
            Self::WendlandC2 => t.powi(4) * (1.0 + 2.0 * q),
            Self::WendlandC4 => t.powi(6) * (35.0 / 12.0 * q * q + 3.0 * q + 1.0),
            Self::WendlandC6 => t.powi(8) * (4.0 * q.powi(3) + 6.25 * q * q + 4.0 * q + 1.0),
        }
    }

    /// Steepness `-w'(q) / q`, in forms without division where the limit at `q = 0` is finite.
    #[inline]
    fn steepness(self, dimension: usize, q: f64) -> f64 {
        let t = (1.0 - 0.5 * q).max(0.0);
        match self {
            Self::Gaussian => 2.0 * (-q * q).exp(),
            Self::CubicSpline if q < 1.0 => 2.0 - 1.5 * q,
            Self::CubicSpline => 2.0 * t * t / q,
            Self::Quadratic => 0.75 * t / q,
            Self::QuinticSpline => {
                let slope = positive_power(3.0 - q, 4) - 6.0 * positive_power(2.0 - q, 4)
                    + 15.0 * positive_power(1.0 - q, 4);
                5.0 * slope / q
            }
            Self::WendlandC2 if dimension == 1 => 3.0 * t * t,
            Self::WendlandC2 => 5.0 * t * t * t,
            // (1 - q/2)^5 (7/3) (2 + 5q), from -3 (1 - q/2)^5 p + (1 - q/2)^6 p'.
            Self::WendlandC4 => t.powi(5) * (14.0 / 3.0 + 35.0 / 3.0 * q),
            // (1 - q/2)^7 (11/4) (2 + 7q + 8q²), likewise.
            Self::WendlandC6 => t.powi(7) * 2.75 * (2.0 + 7.0 * q + 8.0 * q * q),
        }
    }

    /// Slope `w'(q)`.
    #[inline]
    pub fn slope(self, dimension: usize, q: f64) -> f64 {
        if q > 0.0 { -q * self.steepness(dimension, q) } else { 0.0 }
    }

    /// Curvature `w''(q)`.
    pub fn curvature(self, dimension: usize, q: f64) -> f64 {
        let t = (1.0 - 0.5 * q).max(0.0);
        match self {
            Self::Gaussian => (4.0 * q * q - 2.0) * (-q * q).exp(),
            Self::CubicSpline if q < 1.0 => 3.0 * q - 2.0,
            Self::CubicSpline => (2.0 - q).max(0.0),
            Self::Quadratic if q < 2.0 => 0.375,
            Self::Quadratic => 0.0,
            Self::QuinticSpline => {
                20.0 * (positive_power(3.0 - q, 3) - 6.0 * positive_power(2.0 - q, 3)
                    + 15.0 * positive_power(1.0 - q, 3))
            }
            Self::WendlandC2 if dimension == 1 => 3.0 * t * (q - t),
            Self::WendlandC2 => t * t * (7.5 * q - 5.0 * t),
            Self::WendlandC4 => {
                // -d/dq of q (14/3 + 35/3 q) t^5.
                let (p, slope) = (q * (14.0 + 35.0 * q) / 3.0, (14.0 + 70.0 * q) / 3.0);
                t.powi(4) * (2.5 * p - slope * t)
            }
            Self::WendlandC6 => {
                let p = 2.75 * q * (2.0 + 7.0 * q + 8.0 * q * q);
                let slope = 2.75 * (2.0 + 14.0 * q + 24.0 * q * q);
                t.powi(6) * (3.5 * p - slope * t)
            }
        }
    }
}

/// Kernel in `D` dimensions with a smoothing length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothing<const D: usize> {
    /// Kernel function.
    pub(crate) kernel: Kernel,
    /// Smoothing length `h` (m).
    pub(crate) length: f64,
    /// Inverse of the smoothing length (1/m).
    pub(crate) inverse: f64,
    /// Normalisation constant `α`.
    pub(crate) constant: f64,
    /// Radius of the support (m).
    pub(crate) radius: f64,
}

impl<const D: usize> Smoothing<D> {
    /// Returns `kernel` with the smoothing length `h = length` (m).
    ///
    /// # Errors
    /// When the kernel is not defined in `D` dimensions or the length is not positive and finite.
    pub fn new(kernel: Kernel, length: f64) -> Result<Self, KernelError> {
        if !(length.is_finite() && length > 0.0) {
            return Err(KernelError::Length(length));
        }
        let constant = kernel.constant(D).ok_or(KernelError::Dimension { kernel, dimension: D })?;
        Ok(Self {
            kernel,
            length,
            inverse: 1.0 / length,
            constant: constant / length.powi(D as i32),
            radius: kernel.support() * length,
        })
    }

    /// Returns the kernel with another smoothing length (m).
    #[inline]
    pub(crate) fn with_length(&self, length: f64) -> Self {
        if length == self.length {
            return *self;
        }
        let constant = self.constant * (self.length / length).powi(D as i32);
        let radius = self.kernel.support() * length;
        Self { kernel: self.kernel, length, inverse: 1.0 / length, constant, radius }
    }

    /// Kernel function.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// Smoothing length `h` (m).
    #[inline]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Radius of the support (m).
    #[inline]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Value `W(r)` (1/m^d), zero from the edge of the support on.
    #[inline]
    pub fn value(&self, r: f64) -> f64 {
        if r >= self.radius { 0.0 } else { self.constant * self.kernel.profile(D, r * self.inverse) }
    }

    /// Slope `W'(r) = ∂W/∂r` (1/m^(d+1)), never positive.
    #[inline]
    pub fn slope(&self, r: f64) -> f64 {
        if r >= self.radius {
            return 0.0;
        }
        self.constant * self.inverse * self.kernel.slope(D, r * self.inverse)
    }

    /// Gradient factor `F(r) = -W'(r) / r` (1/m^(d+2)), never negative: the gradient at `i` of the kernel around `j` is
    /// `F (x_j - x_i)`. Zero for coincident particles.
    #[inline]
    pub fn gradient_factor(&self, r: f64) -> f64 {
        let q = r * self.inverse;
        if r >= self.radius || q < 1e-12 {
            return 0.0;
        }
        self.constant * self.inverse * self.inverse * self.kernel.steepness(D, q)
    }

    /// Laplacian `∇²W = W'' + (d - 1) W' / r` (1/m^(d+2)).
    pub fn laplacian(&self, r: f64) -> f64 {
        if r >= self.radius {
            return 0.0;
        }
        let scale = self.constant * self.inverse * self.inverse;
        scale * self.kernel.curvature(D, r * self.inverse) - (D - 1) as f64 * self.gradient_factor(r)
    }

    /// Derivative by the smoothing length `∂W/∂h = -α/h (d w + q w')`.
    pub fn length_derivative(&self, r: f64) -> f64 {
        if r >= self.radius {
            return 0.0;
        }
        let q = r * self.inverse;
        let sum = D as f64 * self.kernel.profile(D, q) + q * self.kernel.slope(D, q);
        -self.constant * self.inverse * sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integral by Simpson's rule on pieces that end at the knots of the splines.
    fn integral(f: impl Fn(f64) -> f64, end: f64) -> f64 {
        let pieces = (end * 2.0) as usize;
        let n = 400;
        (0..pieces)
            .map(|piece| {
                let (start, width) = (0.5 * piece as f64, 0.5 / n as f64);
                let weight = |k: usize| if k == 0 || k == n { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
                (0..=n).map(|k| weight(k) * f(start + k as f64 * width)).sum::<f64>() * width / 3.0
            })
            .sum()
    }

    /// Surface of the unit ball.
    fn surface(dimension: usize) -> f64 {
        [2.0, 2.0 * PI, 4.0 * PI][dimension - 1]
    }

    fn for_all_kernels(mut check: impl FnMut(Kernel, usize, f64)) {
        for kernel in Kernel::ALL {
            for dimension in 1..=3 {
                if let Some(constant) = kernel.constant(dimension) {
                    check(kernel, dimension, constant);
                }
            }
        }
    }

    #[test]
    fn kernels_are_normalised() {
        for_all_kernels(|kernel, d, constant| {
            let end = if kernel == Kernel::Gaussian { 8.0 } else { 3.0 };
            let mass = integral(|q| kernel.profile(d, q) * q.powi(d as i32 - 1), end) * surface(d) * constant;
            assert!((mass - 1.0).abs() < 1e-10, "{kernel:?} in {d}D: {mass}");
        });
    }

    #[test]
    fn second_moments_are_those_of_the_sheet() {
        let expected = [
            (Kernel::Gaussian, [0.5, 0.5, 0.5]),
            (Kernel::CubicSpline, [1.0 / 3.0, 31.0 / 98.0, 0.3]),
            (Kernel::WendlandC2, [8.0 / 21.0, 5.0 / 18.0, 4.0 / 15.0]),
        ];
        for (kernel, moments) in expected {
            for (d, moment) in (1..).zip(moments) {
                let sum = integral(|q| kernel.profile(d, q) * q.powi(d as i32 + 1), 8.0) * surface(d);
                let found = kernel.constant(d).unwrap() * sum / d as f64;
                assert!((found - moment).abs() < 1e-10, "{kernel:?} in {d}D: {found}");
            }
        }
    }

    #[test]
    fn slopes_and_curvatures_are_derivatives() {
        for_all_kernels(|kernel, d, _| {
            for k in 1..60 {
                let (q, e) = (0.05 * f64::from(k) + 0.013, 1e-5);
                let slope = (kernel.profile(d, q + e) - kernel.profile(d, q - e)) / (2.0 * e);
                let curvature = (kernel.slope(d, q + e) - kernel.slope(d, q - e)) / (2.0 * e);
                let scale = kernel.profile(d, 0.0);
                assert!((slope - kernel.slope(d, q)).abs() < 1e-8 * scale, "{kernel:?} {d}D at {q}");
                assert!((curvature - kernel.curvature(d, q)).abs() < 1e-7 * scale, "{kernel:?} {d}D at {q}");
            }
        });
    }

    #[test]
    fn kernels_are_positive_fall_and_end_at_their_support() {
        for_all_kernels(|kernel, d, _| {
            let support = kernel.support();
            for k in 0..400 {
                let q = 0.01 * f64::from(k);
                assert!(kernel.slope(d, q) <= 0.0 && kernel.profile(d, q) >= 0.0);
                if q < 0.999 * support {
                    assert!(kernel.profile(d, q) > 0.0, "{kernel:?} {d}D at {q}");
                }
            }
        });
        let smoothing = Smoothing::<2>::new(Kernel::Gaussian, 0.1).unwrap();
        assert!(smoothing.value(0.299) > 0.0 && smoothing.gradient_factor(0.299) > 0.0);
        assert_eq!(
            [smoothing.value(0.301), smoothing.gradient_factor(0.301), smoothing.slope(0.301)],
            [0.0; 3]
        );
        assert_eq!(smoothing.gradient_factor(0.0), 0.0);
        assert!(Smoothing::<1>::new(Kernel::WendlandC4, 0.1).is_err());
        assert!(Smoothing::<1>::new(Kernel::CubicSpline, f64::NAN).is_err());
    }

    #[test]
    fn values_are_those_of_the_sheet() {
        // W at 0, 0.5, 1, 1.5 and W' at 0.5, 1, 1.5, for h = 1.
        type Row = (Kernel, usize, [f64; 7]);
        #[rustfmt::skip]
        let table: [Row; 9] = [
            (Kernel::CubicSpline, 1, [0.6666666667, 0.4791666667, 0.1666666667, 0.0208333333, -0.625, -0.5, -0.125]),
            (Kernel::CubicSpline, 2, [0.4547284088, 0.3268360438, 0.1136821022, 0.0142102628, -0.4263078833, -0.3410463066, -0.0852615767]),
            (Kernel::CubicSpline, 3, [std::f64::consts::FRAC_1_PI, 0.2287852307, 0.0795774715, 0.0099471839, -0.2984155183, -0.2387324146, -0.0596831037]),
            (Kernel::WendlandC2, 1, [0.625, 0.4614257812, 0.1953125, 0.0317382812, -0.52734375, -0.46875, -0.17578125]),
            (Kernel::WendlandC2, 2, [0.5570423008, 0.352503331, 0.1044454314, 0.008703786, -0.5875055516, -0.348151438, -0.0652783946]),
            (Kernel::WendlandC2, 3, [0.4177817256, 0.2643774982, 0.0783340736, 0.0065278395, -0.4406291637, -0.2611135785, -0.048958796]),
            (Kernel::Gaussian, 1, [0.5641895835, 0.4393912895, 0.2075537487, 0.0594651446, -0.4393912895, -0.4151074974, -0.1783954338]),
            (Kernel::Gaussian, 2, [std::f64::consts::FRAC_1_PI, 0.2478999886, 0.117099663, 0.0335496152, -0.2478999886, -0.2341993261, -0.1006488455]),
            (Kernel::Gaussian, 3, [0.1795871221, 0.1398625913, 0.0660664101, 0.0189283434, -0.1398625913, -0.1321328203, -0.0567850302]),
        ];
        for (kernel, d, expected) in table {
            let constant = kernel.constant(d).unwrap();
            let values = [0.0, 0.5, 1.0, 1.5].map(|q| constant * kernel.profile(d, q));
            let slopes = [0.5, 1.0, 1.5].map(|q| constant * kernel.slope(d, q));
            for (found, expected) in values.iter().chain(&slopes).zip(expected) {
                assert!((found - expected).abs() < 1e-10, "{kernel:?} {d}D: {found} for {expected}");
            }
        }
    }

    /// Sums on a lattice: `Σ V W` with and without the particle itself, `M_11`, `½ Σ V x₁² ∇²W` and the number of neighbours.
    fn lattice<const D: usize>(kernel: Kernel, ratio: f64) -> [f64; 5] {
        let smoothing = Smoothing::<D>::new(kernel, ratio).unwrap();
        let mut sums = [smoothing.value(0.0), 0.0, 0.0, 0.0, 0.0];
        let width = 9i32;
        for number in 0..width.pow(D as u32) {
            let x: [f64; D] = std::array::from_fn(|c| f64::from(number / width.pow(c as u32) % width - 4));
            let r = x.iter().map(|c| c * c).sum::<f64>().sqrt();
            if r > 0.0 && r < smoothing.radius() - 1e-9 {
                sums[0] += smoothing.value(r);
                sums[1] += smoothing.value(r);
                sums[2] += smoothing.gradient_factor(r) * x[0] * x[0];
                sums[3] += 0.5 * smoothing.laplacian(r) * x[0] * x[0];
                sums[4] += 1.0;
            }
        }
        sums
    }

    #[test]
    fn lattice_sums_are_those_of_the_sheet() {
        let cubic = Kernel::CubicSpline;
        let wendland = Kernel::WendlandC2;
        #[rustfmt::skip]
        let table = [
            (lattice::<2>(cubic, 1.0), [1.00086183, 0.54613342, 1.01309945, 0.974664, 8.0]),
            (lattice::<2>(cubic, 1.2), [0.99975731, 0.68397369, 0.99079306, 1.097472, 20.0]),
            (lattice::<2>(cubic, 1.3), [0.99994677, 0.73087670, 1.01054296, 1.113355, 20.0]),
            (lattice::<2>(cubic, 1.5), [1.00344040, 0.80133888, 1.00672451, 0.888640, 24.0]),
            (lattice::<2>(cubic, 2.0), [0.99995761, 0.88627551, 0.99910021, 1.003341, 44.0]),
            (lattice::<3>(cubic, 1.2), [1.00080955, 0.81660244, 0.98168857, 0.952100, 56.0]),
            (lattice::<2>(wendland, 1.2), [1.01795174, 0.63111681, 0.96384980, 0.956913, 20.0]),
            (lattice::<2>(wendland, 1.5), [1.00514234, 0.75756798, 0.99739927, 1.009378, 24.0]),
            (lattice::<2>(wendland, 1.8), [1.00212488, 0.83019824, 0.99534753, 1.011939, 36.0]),
            (lattice::<3>(wendland, 1.2), [1.01745693, 0.77568509, 0.98522927, 0.895976, 56.0]),
            (lattice::<2>(Kernel::Gaussian, 1.2), [0.99975898, 0.77871044, 0.99767974, 0.981081, 36.0]),
        ];
        for (row, (found, expected)) in table.iter().enumerate() {
            // The sheet gives eight digits, six of the Laplacian.
            for (k, tolerance) in [1e-8, 1e-8, 1e-8, 1e-6, 0.0].into_iter().enumerate() {
                assert!((found[k] - expected[k]).abs() <= tolerance, "row {row}: {found:?}");
            }
        }
    }

    /// Exponents of the artificial stress (sheet: sph §2.11).
    #[test]
    fn ratios_of_kernels_are_those_of_the_sheet() {
        let (cubic, wendland) = (Kernel::CubicSpline, Kernel::WendlandC2);
        for (kernel, ratio, sheet) in [
            (cubic, 1.0, 4.0),
            (cubic, 1.2, 2.548_673),
            (cubic, 1.3, 2.203_611),
            (wendland, 1.2, 3.238_651),
            (wendland, 1.5, 2.169_643),
            (wendland, 2.0, 1.580_247),
        ] {
            let plane = Smoothing::<2>::new(kernel, ratio).unwrap();
            let space = Smoothing::<3>::new(kernel, ratio).unwrap();
            for found in [plane.value(0.0) / plane.value(1.0), space.value(0.0) / space.value(1.0)] {
                assert!((found - sheet).abs() < 1e-6, "{kernel:?} {ratio}: {found}");
            }
        }
    }

    #[test]
    fn the_derivative_by_the_smoothing_length_is_one() {
        for kernel in Kernel::ALL {
            let at = |h: f64, r: f64| Smoothing::<3>::new(kernel, h).unwrap().value(r);
            for r in [0.0, 0.3, 0.9, 1.4] {
                let found = Smoothing::<3>::new(kernel, 1.0).unwrap().length_derivative(r);
                let expected = (at(1.0 + 1e-5, r) - at(1.0 - 1e-5, r)) / 2e-5;
                assert!((found - expected).abs() < 1e-7, "{kernel:?} at {r}: {found} {expected}");
            }
        }
    }
}
