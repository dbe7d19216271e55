//! Elastic spheres after Hertz (1882), springs across after Mindlin, damping after Tsuji et al. (1992): the restitution does
//! not depend on the speed (sheet: dem §2.8).

use super::{Elastic, Touch};
use crate::vector::Number;

/// Parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hertz<T = f64> {
    /// `E*`: `1/E* = (1-ν_i²)/E_i + (1-ν_j²)/E_j` (Pa).
    pub modulus: T,
    /// `G*` of the spring across: that of the grains, or a quarter of `E*` times the stiffness ratio that was asked for (Pa).
    pub shear_modulus: T,
    /// `G*` of the grains: `1/G* = (2-ν_i)/G_i + (2-ν_j)/G_j` (Pa).
    pub grain_shear_modulus: T,
    /// `2 √(5/6) β`, of a dashpot `that · √(S m_eff)`.
    pub damping: T,
    /// The same of the dashpot across, of which the stiffness is that across.
    pub damping_across: T,
    /// Root of the stiffness across over that along.
    pub root_across: T,
}

/// Dashpot over `√(S m_eff)` for a damping ratio, `β` of which is the ratio.
pub fn dashpot(damping_ratio: f64) -> f64 {
    2.0 * (5.0f64 / 6.0).sqrt() * damping_ratio
}

impl<T: Number> Hertz<T> {
    /// What it says of an overlap.
    #[inline]
    pub fn at<const D: usize, const R: usize>(&self, touch: &Touch<D, R, T>) -> Elastic<T> {
        let overlap = touch.overlap.or_zero();
        let width = (touch.radius * overlap).root();
        let stiffness = T::of(2.0) * self.modulus * width;
        let across = T::of(8.0) * self.shear_modulus * width;
        let force = T::of(2.0 / 3.0) * stiffness * overlap;
        let root = (stiffness * touch.mass).root();
        Elastic {
            force,
            energy: T::of(0.4) * force * overlap,
            damping: self.damping * root,
            across,
            damping_across: self.damping_across * self.root_across * root,
        }
    }
}

impl Hertz {
    /// Of grains with Young's moduli (Pa) and Poisson ratios; the stiffness across is Mindlin's.
    pub fn new(youngs: [f64; 2], poisson: [f64; 2], damping_ratio: f64, damping_ratio_across: f64) -> Self {
        let normal: f64 = (0..2).map(|k| (1.0 - poisson[k] * poisson[k]) / youngs[k]).sum();
        let shear: f64 = (0..2).map(|k| (2.0 - poisson[k]) * 2.0 * (1.0 + poisson[k]) / youngs[k]).sum();
        Self {
            modulus: 1.0 / normal,
            shear_modulus: 1.0 / shear,
            grain_shear_modulus: 1.0 / shear,
            damping: dashpot(damping_ratio),
            damping_across: dashpot(damping_ratio_across),
            root_across: (4.0 * normal / shear).sqrt(),
        }
    }

    /// With this stiffness across over that along in place of Mindlin's.
    #[must_use]
    pub fn with_stiffness_ratio(self, ratio: f64) -> Self {
        Self { shear_modulus: 0.25 * ratio * self.modulus, root_across: ratio.sqrt(), ..self }
    }

    /// Largest overlap (m) of an elastic impact of effective mass (kg), radius (m) and speed (m/s).
    pub fn deepest(&self, mass: f64, radius: f64, speed: f64) -> f64 {
        (15.0 * mass * speed * speed / (16.0 * self.modulus * radius.sqrt())).powf(0.4)
    }

    /// Duration (s) of an elastic impact.
    pub fn duration(&self, mass: f64, radius: f64, speed: f64) -> f64 {
        2.868_266 * (mass * mass / (self.modulus * self.modulus * radius * speed)).powf(0.2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_impact_of_glass_spheres_has_the_values_of_the_sheet() {
        // Sheet: dem §3.6.
        let law = Hertz::new([70e9; 2], [0.3; 2], 0.0, 0.0);
        let mass = 0.5 * 4.0 / 3.0 * std::f64::consts::PI * 0.005f64.powi(3) * 2500.0;
        let (radius, speed) = (0.0025, 1.0);
        let deepest = law.deepest(mass, radius, speed);
        assert!((deepest / 1.00358e-5 - 1.0).abs() < 1e-5);
        assert!((law.duration(mass, radius, speed) / 2.9538e-5 - 1.0).abs() < 1e-4);
        let touch: Touch<3, 3> = Touch {
            overlap: deepest,
            normal: [1.0, 0.0, 0.0],
            separation: 0.0,
            sliding: [0.0; 3],
            turning: [0.0; 3],
            spin: 0.0,
            mass,
            radius,
            small: 0.005,
        };
        let at = law.at(&touch);
        assert!((at.force / 81.5202 - 1.0).abs() < 1e-5);
        assert!((at.energy / (0.5 * mass) - 1.0).abs() < 1e-9);
    }
}
