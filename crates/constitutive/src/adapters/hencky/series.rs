//! Logarithm and exponential of small symmetric tensors without their spectrum: power series, of which the
//! Cayley–Hamilton theorem leaves three coefficients. Without branches, for loops over several points at once.

use crate::SymTensor;

/// Number of terms of the logarithm series. The first omitted term is below 2⁻⁵⁶ of the tensor at [`MAX_LOG_NORM_SQUARED`].
const LOG_TERMS: usize = 14;

/// Square of the largest norm of `x` for which [`half_log`] is accurate.
pub(super) const MAX_LOG_NORM_SQUARED: f64 = 1.0 / 256.0;

/// Number of terms of the exponential series. The first omitted term is below 2⁻⁵⁶ of the tensor at [`MAX_EXP_NORM_SQUARED`].
const EXP_TERMS: usize = 13;

/// Square of the largest norm of `2ε` for which [`exp_minus_one`] is accurate.
pub(super) const MAX_EXP_NORM_SQUARED: f64 = 1.0 / 16.0;

/// Coefficients of the Taylor series of the logarithm, `½ (-1)^k/(k + 1)`.
const LOG: [f64; LOG_TERMS] = {
    let mut terms = [0.0; LOG_TERMS];
    let (mut k, mut sign) = (0, 0.5);
    while k < LOG_TERMS {
        terms[k] = sign / (k + 1) as f64;
        sign = -sign;
        k += 1;
    }
    terms
};

/// Coefficients of the Taylor series of the exponential without the constant term, `1/(k + 1)!`.
const EXP: [f64; EXP_TERMS] = {
    let mut terms = [0.0; EXP_TERMS];
    let (mut k, mut term) = (0, 1.0);
    while k < EXP_TERMS {
        term /= (k + 1) as f64;
        terms[k] = term;
        k += 1;
    }
    terms
};

/// Power series `x (c₀ + c₁ x + c₂ x² + …)`, by Horner's scheme on the coefficients of `x²`, `x` and `1`, with
/// `x³ = I₁ x² - I₂ x + I₃`.
#[inline(always)]
fn series<const TERMS: usize>(x: &SymTensor, terms: &[f64; TERMS]) -> SymTensor {
    let [xx, yy, zz, xy, yz, zx] = x.0;
    let square = [
        xx * xx + xy * xy + zx * zx,
        xy * xy + yy * yy + yz * yz,
        zx * zx + yz * yz + zz * zz,
        xy * (xx + yy) + zx * yz,
        yz * (yy + zz) + xy * zx,
        zx * (xx + zz) + xy * yz,
    ];
    let i1 = xx + yy + zz;
    let i2 = (xx * yy - xy * xy) + (yy * zz - yz * yz) + (zz * xx - zx * zx);
    let i3 = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * zx) + zx * (xy * yz - yy * zx);
    let (mut a, mut b, mut c) = (0.0, 0.0, terms[TERMS - 1]);
    for k in (0..TERMS - 1).rev() {
        (a, b, c) = (a * i1 + b, c - a * i2, a * i3 + terms[k]);
    }
    (a, b, c) = (a * i1 + b, c - a * i2, a * i3);
    let diagonal = |k: usize| a * square[k] + b * x.0[k] + c;
    let shear = |k: usize| a * square[k] + b * x.0[k];
    SymTensor([diagonal(0), diagonal(1), diagonal(2), shear(3), shear(4), shear(5)])
}

/// Power series [`series`] of a tensor with the third axis as principal axis.
#[inline(always)]
fn planar_series<const TERMS: usize>(x: &SymTensor, terms: &[f64; TERMS]) -> SymTensor {
    let [xx, yy, zz, xy, ..] = x.0;
    let (i1, i2) = (xx + yy, xx * yy - xy * xy);
    let (mut b, mut c, mut across) = (0.0, terms[TERMS - 1], terms[TERMS - 1]);
    for k in (0..TERMS - 1).rev() {
        (b, c) = (b * i1 + c, terms[k] - b * i2);
        across = across * zz + terms[k];
    }
    (b, c) = (b * i1 + c, -b * i2);
    SymTensor([b * xx + c, b * yy + c, across * zz, b * xy, 0.0, 0.0])
}

/// Half the logarithm, `½ ln(1 + x)`.
#[inline(always)]
pub(super) fn half_log<const PLANAR: bool>(x: &SymTensor) -> SymTensor {
    if PLANAR { planar_series(x, &LOG) } else { series(x, &LOG) }
}

/// Exponential minus one, `exp(x) - 1`.
#[inline(always)]
pub(super) fn exp_minus_one<const PLANAR: bool>(x: &SymTensor) -> SymTensor {
    if PLANAR { planar_series(x, &EXP) } else { series(x, &EXP) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn series_are_those_of_the_spectrum(c in proptest::array::uniform6(-1.0..1.0f64), size in -9.0..0.0f64) {
            let x = SymTensor(c);
            for (largest, planar) in [(MAX_LOG_NORM_SQUARED, false), (MAX_LOG_NORM_SQUARED, true), (MAX_EXP_NORM_SQUARED, false), (MAX_EXP_NORM_SQUARED, true)] {
                let mut x = x;
                if planar {
                    (x[4], x[5]) = (0.0, 0.0);
                }
                let x = x * (largest.sqrt() * 10f64.powf(size) / x.norm().max(1e-3));
                let spectrum = x.spectrum();
                let exp = spectrum.compose(spectrum.values.map(f64::exp_m1));
                let found = if planar { exp_minus_one::<true>(&x) } else { exp_minus_one::<false>(&x) };
                prop_assert!((found - exp).norm() <= 2e-15 * x.norm(), "{:e}", (found - exp).norm() / x.norm());
                if largest == MAX_LOG_NORM_SQUARED {
                    let log = spectrum.compose(spectrum.values.map(|b| 0.5 * b.ln_1p()));
                    let found = if planar { half_log::<true>(&x) } else { half_log::<false>(&x) };
                    prop_assert!((found - log).norm() <= 2e-15 * x.norm(), "{:e}", (found - log).norm() / x.norm());
                }
            }
        }
    }
}
