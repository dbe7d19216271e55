//! Smoothing kernels in plan, in one and two dimensions (sheet: depth-sph §2.10).

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wide::f64x4;

/// Smoothing kernel `W(r, ℓ)`, `q = r/ℓ`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "DepthKernel")]
pub enum Kernel {
    /// Cubic spline, support 2 ℓ.
    #[default]
    CubicSpline,
    /// Wendland C2, support 2 ℓ.
    WendlandC2,
    /// Quintic spline, support 3 ℓ.
    QuinticSpline,
    /// Gaussian, truncated at 3 ℓ: integral too small by 2.2e-5 in 1D, 1.2e-4 in 2D.
    Gaussian,
}

impl Kernel {
    /// Radius of the support in smoothing lengths.
    #[inline]
    pub fn support(self) -> f64 {
        match self {
            Self::CubicSpline | Self::WendlandC2 => 2.0,
            Self::QuinticSpline | Self::Gaussian => 3.0,
        }
    }

    /// Normalisation factor for `ℓ` = 1, with which the kernel integral over a line (`D` = 1) or plane (`D` = 2) is one.
    #[inline]
    pub fn factor<const D: usize>(self) -> f64 {
        match (self, D) {
            (Self::CubicSpline, 1) => 2.0 / 3.0,
            (Self::CubicSpline, _) => 10.0 / (7.0 * PI),
            (Self::WendlandC2, 1) => 5.0 / 8.0,
            (Self::WendlandC2, _) => 7.0 / (4.0 * PI),
            (Self::QuinticSpline, 1) => 1.0 / 120.0,
            (Self::QuinticSpline, _) => 7.0 / (478.0 * PI),
            (Self::Gaussian, 1) => 1.0 / PI.sqrt(),
            (Self::Gaussian, _) => 1.0 / PI,
        }
    }

    /// Profile `f(q)` of the kernel, without its factor.
    #[inline]
    pub fn profile<const D: usize>(self, q: f64) -> f64 {
        let part = |edge: f64| (edge - q).max(0.0);
        match self {
            Self::CubicSpline => {
                // Both forms are evaluated, so that there is no branch.
                let (near, far) = (1.0 + q * q * (0.75 * q - 1.5), 0.25 * part(2.0).powi(3));
                if q < 1.0 { near } else { far }
            }
            Self::WendlandC2 if D == 1 => (0.5 * part(2.0)).powi(3) * (1.5 * q + 1.0),
            Self::WendlandC2 => (0.5 * part(2.0)).powi(4) * (2.0 * q + 1.0),
            Self::QuinticSpline => part(3.0).powi(5) - 6.0 * part(2.0).powi(5) + 15.0 * part(1.0).powi(5),
            Self::Gaussian if q < 3.0 => (-q * q).exp(),
            Self::Gaussian => 0.0,
        }
    }

    /// Slope `f'(q) / q`, negative: gradients are `factor ℓ^-(D + 2) f'(q)/q (x - x')`, without a division by the distance.
    #[inline]
    pub fn slope<const D: usize>(self, q: f64) -> f64 {
        let part = |edge: f64| (edge - q).max(0.0);
        match self {
            Self::CubicSpline => {
                let (near, far) = (2.25 * q - 3.0, -0.75 * part(2.0).powi(2) / q);
                if q < 1.0 { near } else { far }
            }
            // d/dq (1 - q/2)³(3q/2 + 1) = -3 q (1 - q/2)².
            Self::WendlandC2 if D == 1 => -3.0 * (0.5 * part(2.0)).powi(2),
            // d/dq (1 - q/2)⁴(2q + 1) = -5 q (1 - q/2)³.
            Self::WendlandC2 => -5.0 * (0.5 * part(2.0)).powi(3),
            Self::QuinticSpline => {
                let sum = part(3.0).powi(4) - 6.0 * part(2.0).powi(4) + 15.0 * part(1.0).powi(4);
                // The quotient has a limit at the centre, -120.
                if q > 1e-8 { -5.0 * sum / q } else { -120.0 }
            }
            Self::Gaussian if q < 3.0 => -2.0 * (-q * q).exp(),
            Self::Gaussian => 0.0,
        }
    }

    // The forms for four arguments are separate from those for one: they need not vanish beyond the support, take inverses that are known
    // and select among lanes in place of branches, so that one form for both would be slower for either or change results.

    /// [`Kernel::profile`] of four arguments within the support.
    #[inline(always)]
    pub fn profile_of_four<const D: usize>(self, q: f64x4) -> f64x4 {
        let part = |edge: f64| (f64x4::splat(edge) - q).fast_max(f64x4::ZERO);
        match self {
            Self::CubicSpline => {
                let (near, far) = (part(1.0), part(2.0));
                far * far * far * 0.25 - near * near * near
            }
            Self::WendlandC2 => {
                let half = part(2.0) * 0.5;
                let cube = half * half * half;
                if D == 1 { cube * (q * 1.5 + 1.0) } else { cube * half * (q * 2.0 + 1.0) }
            }
            Self::QuinticSpline => {
                let fifth = |x: f64x4| (x * x) * (x * x) * x;
                fifth(part(3.0)) - fifth(part(2.0)) * 6.0 + fifth(part(1.0)) * 15.0
            }
            Self::Gaussian => (f64x4::ZERO - q * q).exp(),
        }
    }

    /// [`Kernel::slope`] of four positive arguments within the support, with their inverses.
    #[inline(always)]
    pub fn slope_of_four<const D: usize>(self, q: f64x4, inverse: f64x4) -> f64x4 {
        let part = |edge: f64| (f64x4::splat(edge) - q).fast_max(f64x4::ZERO);
        match self {
            Self::CubicSpline => {
                let far = part(2.0);
                q.simd_lt(f64x4::ONE).select(q * 2.25 - 3.0, far * far * inverse * -0.75)
            }
            Self::WendlandC2 => {
                let half = part(2.0) * 0.5;
                if D == 1 { half * half * -3.0 } else { half * half * half * -5.0 }
            }
            Self::QuinticSpline => {
                let fourth = |x: f64x4| (x * x) * (x * x);
                let sum = fourth(part(3.0)) - fourth(part(2.0)) * 6.0 + fourth(part(1.0)) * 15.0;
                // The quotient has a limit at the centre, -120.
                let centre = q.simd_lt(f64x4::splat(1e-8));
                centre.select(f64x4::splat(-120.0), sum * inverse * -5.0)
            }
            Self::Gaussian => (f64x4::ZERO - q * q).exp() * -2.0,
        }
    }

    /// Kernel value `W(r, ℓ)` (1/m in one dimension, 1/m² in two).
    #[inline]
    pub fn value<const D: usize>(self, distance: f64, length: f64) -> f64 {
        self.factor::<D>() / length.powi(D as i32) * self.profile::<D>(distance / length)
    }

    /// Gradient factor `(∂W/∂r)/r`, which times `x_I - x_J` is the kernel gradient with respect to node `I`.
    #[inline]
    pub fn gradient<const D: usize>(self, distance: f64, length: f64) -> f64 {
        self.factor::<D>() / length.powi(D as i32 + 2) * self.slope::<D>(distance / length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Kernel; 4] =
        [Kernel::CubicSpline, Kernel::WendlandC2, Kernel::QuinticSpline, Kernel::Gaussian];

    /// Integral of `f` from 0 to `end` by Gauss's three-point rule on many intervals.
    fn integral(end: f64, f: impl Fn(f64) -> f64) -> f64 {
        let (count, root) = (3000, 0.6f64.sqrt());
        let width = end / f64::from(count);
        let cell = |k: i32| {
            let middle = width * (f64::from(k) + 0.5);
            let at = |s: f64| f(middle + 0.5 * width * s);
            width / 18.0 * (5.0 * at(-root) + 8.0 * at(0.0) + 5.0 * at(root))
        };
        (0..count).map(cell).sum()
    }

    #[test]
    fn integrals_are_one() {
        for kernel in ALL {
            let end = kernel.support();
            let line = 2.0 * integral(end, |r| kernel.value::<1>(r, 1.0));
            let plane = 2.0 * PI * integral(end, |r| r * kernel.value::<2>(r, 1.0));
            // The Gaussian lacks its part beyond the cut (sheet: depth-sph V31, as amended).
            let exact = if kernel == Kernel::Gaussian { (0.999_978, 0.999_877) } else { (1.0, 1.0) };
            let tolerance = if kernel == Kernel::Gaussian { 5e-7 } else { 1e-12 };
            assert!((line - exact.0).abs() < tolerance, "{kernel:?}: {line}");
            assert!((plane - exact.1).abs() < tolerance, "{kernel:?}: {plane}");
        }
    }

    #[test]
    fn cubic_spline_has_the_values_of_the_sheet() {
        let kernel = Kernel::CubicSpline;
        let near = |a: f64, b: f64| assert!((a - b).abs() < 5e-7, "{a} for {b}");
        near(kernel.value::<1>(0.0, 1.0), 0.666_667);
        near(kernel.value::<2>(0.0, 1.0), 0.454_728);
        near(kernel.value::<1>(1.0, 1.0), 0.166_667);
        near(kernel.value::<2>(1.0, 1.0), 0.113_682);
    }

    #[test]
    fn gradients_are_those_of_the_values() {
        for kernel in ALL {
            for q in [0.05, 0.4, 0.99, 1.3, 1.9, 2.4] {
                let (length, step) = (0.7, 1e-6);
                let r = q * length;
                let by_difference =
                    |value: &dyn Fn(f64) -> f64| (value(r + step) - value(r - step)) / (2.0 * step);
                let one = by_difference(&|r| kernel.value::<1>(r, length));
                let two = by_difference(&|r| kernel.value::<2>(r, length));
                assert!((kernel.gradient::<1>(r, length) * r - one).abs() < 1e-7, "{kernel:?} {q}");
                assert!((kernel.gradient::<2>(r, length) * r - two).abs() < 1e-7, "{kernel:?} {q}");
            }
        }
    }

    #[test]
    fn packed_kernel_values_equal_scalar_values() {
        for kernel in ALL {
            for k in 0..60 {
                let q: [f64; 4] = std::array::from_fn(|lane| 1e-9 + 0.0124 * f64::from(4 * k + lane as i32));
                let q = q.map(|q| if q < kernel.support() { q } else { 0.5 });
                let near = |found: f64x4, single: [f64; 4]| {
                    for (found, single) in found.to_array().iter().zip(single) {
                        assert!((found - single).abs() < 1e-10 * single.abs().max(1.0), "{kernel:?} {q:?}");
                    }
                };
                let inverse = f64x4::new(q.map(f64::recip));
                near(kernel.profile_of_four::<1>(f64x4::new(q)), q.map(|q| kernel.profile::<1>(q)));
                near(kernel.profile_of_four::<2>(f64x4::new(q)), q.map(|q| kernel.profile::<2>(q)));
                near(kernel.slope_of_four::<1>(f64x4::new(q), inverse), q.map(|q| kernel.slope::<1>(q)));
                near(kernel.slope_of_four::<2>(f64x4::new(q), inverse), q.map(|q| kernel.slope::<2>(q)));
            }
        }
    }

    #[test]
    fn lattice_sums_are_near_one() {
        for kernel in [Kernel::CubicSpline, Kernel::WendlandC2] {
            let reach = -4..=4;
            let mut sum = 0.0;
            for i in reach.clone() {
                for j in reach.clone() {
                    sum += kernel.value::<2>(f64::from(i).hypot(f64::from(j)), 1.3);
                }
            }
            assert!((sum - 1.0).abs() < 0.011, "{kernel:?}: {sum}");
        }
    }
}
