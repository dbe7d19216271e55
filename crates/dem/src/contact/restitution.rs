//! Restitution and damping ratio of a linear spring and dashpot (sheet: dem §2.3; Schwager and Pöschel 2007).

use std::f64::consts::PI;

/// Coefficient of restitution for a damping ratio, if spring and dashpot may be in tension.
pub fn restitution_with_tension(ratio: f64) -> f64 {
    if ratio >= 1.0 { 0.0 } else { (-PI * ratio / (1.0 - ratio * ratio).sqrt()).exp() }
}

/// Coefficient of restitution for a damping ratio without tension: the contact ends when its force vanishes.
pub fn restitution_without_tension(ratio: f64) -> f64 {
    let square = ratio * ratio;
    if (ratio - 1.0).abs() < 1e-9 {
        return (-2.0f64).exp();
    }
    if ratio < 1.0 {
        let root = (1.0 - square).sqrt();
        let angle = PI - (2.0 * ratio * root).atan2(1.0 - 2.0 * square);
        (-ratio / root * angle).exp()
    } else {
        let root = (square - 1.0).sqrt();
        (-ratio / root * ((ratio + root) / (ratio - root)).ln()).exp()
    }
}

/// Damping ratio for a coefficient of restitution, if spring and dashpot may be in tension.
pub fn damping_ratio_with_tension(restitution: f64) -> f64 {
    let log = restitution.ln();
    -log / (PI * PI + log * log).sqrt()
}

/// Damping ratio of a coefficient of restitution without tension, by bisection.
pub fn damping_ratio_without_tension(restitution: f64) -> f64 {
    if restitution >= 1.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    while restitution_without_tension(high) > restitution && high < 1e6 {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if restitution_without_tension(middle) > restitution { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn restitution_and_damping_ratio_are_those_of_the_tables() {
        // Sheet: dem §2.3, second table.
        for (ratio, free, held) in [
            (0.05, 0.854_468, 0.858_758),
            (0.1, 0.729_248, 0.744_079),
            (0.2, 0.526_621, 0.571_740),
            (0.3, 0.372_326, 0.450_975),
            (0.5, 0.163_034, 0.298_436),
            (0.7, 0.045_988, 0.210_285),
            (1.0, 0.0, 0.135_335),
            (1.5, 0.0, 0.075_588),
        ] {
            assert!(
                (restitution_with_tension(ratio) - free).abs() < 1e-6
                    && (restitution_without_tension(ratio) - held).abs() < 1e-6
            );
        }
        // Sheet: dem §2.3, first table.
        for (restitution, free, held, mixed) in [
            (0.95, 0.01632, 0.01650, 0.9505),
            (0.8, 0.07085, 0.07436, 0.8081),
            (0.5, 0.21545, 0.25528, 0.5503),
            (0.1, 0.59116, 1.24319, 0.2527),
        ] {
            assert!((damping_ratio_with_tension(restitution) - free).abs() < 1e-5);
            assert!((damping_ratio_without_tension(restitution) - held).abs() < 1e-5);
            assert!(
                (restitution_without_tension(damping_ratio_with_tension(restitution)) - mixed).abs() < 1e-4
            );
        }
    }
}
