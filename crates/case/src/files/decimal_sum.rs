//! Exact sums of decimal numbers.

/// Largest difference of the decimal exponents of two numbers with an exact sum.
const MAX_DIGITS: u32 = 18;

/// Shortest decimal representation of a number as an integer and a power of ten.
fn digits(x: f64) -> Option<(i128, i32)> {
    let text = format!("{x:e}");
    let (digits, power) = text.split_once('e')?;
    let decimals = digits.split_once('.').map_or(0, |(_, decimals)| decimals.len() as i32);
    Some((digits.replace('.', "").parse().ok()?, power.parse::<i32>().ok()? - decimals))
}

/// Sum of two decimal numbers, or their difference for a `sign` of -1, without binary round-off where their exponents differ little.
pub(crate) fn decimal_sum(x: f64, by: f64, sign: i128) -> f64 {
    let rounded = x + sign as f64 * by;
    if by == 0.0 || x == 0.0 || !rounded.is_finite() {
        return rounded;
    }
    let exact = || {
        let ((a, p), (b, q)) = (digits(x)?, digits(by)?);
        let smallest = p.min(q);
        let scaled = |m: i128, power: i32| {
            let places = u32::try_from(power - smallest).ok().filter(|places| *places <= MAX_DIGITS)?;
            m.checked_mul(10i128.pow(places))
        };
        format!("{}e{smallest}", scaled(a, p)? + sign * scaled(b, q)?).parse::<f64>().ok()
    };
    exact().unwrap_or(rounded)
}

/// Coordinate relative to the origin of the map (m).
pub(crate) fn relative_to_origin(x: f64, origin: f64) -> f64 {
    decimal_sum(x, origin, -1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_those_of_the_decimals() {
        for (x, origin, exact) in [
            (500_000.1, 500_000.0, 0.1),
            (5_000_000.3, 5e6, 0.3),
            (4_999_999.7, 5e6, -0.3),
            (-0.1, 500_000.3, -500_000.4),
            (500_000.0, 500_000.0, 0.0),
            (0.25, 0.0, 0.25),
        ] {
            assert_eq!(relative_to_origin(x, origin), exact, "{x} - {origin}");
            assert_eq!(decimal_sum(exact, origin, 1), x, "{exact} + {origin}");
        }
        assert_eq!(relative_to_origin(1e-30, 5e5), -5e5, "too far apart");
    }
}
