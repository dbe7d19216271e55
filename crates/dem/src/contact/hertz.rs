//! Hertz contact of elastic spheres (1882) with the tangential stiffness of Mindlin and the damping of Tsuji et al. (1992): the
//! restitution does not depend on the speed (sheet: dem §2.8).

use super::{ContactGeometry, NormalResponse};
use crate::points::vector::SimdNumber;

/// Parameters of Hertz–Mindlin contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hertz<T = f64> {
    /// Effective modulus `E*`: `1/E* = (1-ν_i²)/E_i + (1-ν_j²)/E_j` (Pa).
    pub modulus: T,
    /// Effective shear modulus `G*` of the tangential spring (Pa): that of the grains, or `E*`/4 times a given stiffness ratio.
    pub shear_modulus: T,
    /// Effective shear modulus `G*` of the grains: `1/G* = (2-ν_i)/G_i + (2-ν_j)/G_j` (Pa).
    pub grain_shear_modulus: T,
    /// Factor of the normal dashpot, `2 √(5/6) β`: the dashpot is the factor times `√(S m_eff)` (N s/m).
    pub damping: T,
    /// Factor of the tangential dashpot, `2 √(5/6) β_t`: the dashpot is the factor times `√(S_t m_eff)` (N s/m).
    pub tangential_damping: T,
    /// Square root of the tangential over the normal stiffness.
    pub tangential_stiffness_root: T,
}

/// Factor of a dashpot over `√(S m_eff)` for a damping ratio `β`.
pub fn dashpot_factor(damping_ratio: f64) -> f64 {
    2.0 * (5.0f64 / 6.0).sqrt() * damping_ratio
}

impl<T: SimdNumber> Hertz<T> {
    /// Normal force, energy, stiffness and dashpots at an overlap.
    #[inline]
    pub fn response<const D: usize, const R: usize>(
        &self,
        geometry: &ContactGeometry<D, R, T>,
    ) -> NormalResponse<T> {
        let overlap = geometry.overlap.or_zero();
        let width = (geometry.radius * overlap).root();
        let stiffness = T::broadcast(2.0) * self.modulus * width;
        let across = T::broadcast(8.0) * self.shear_modulus * width;
        let force = T::broadcast(2.0 / 3.0) * stiffness * overlap;
        let root = (stiffness * geometry.mass).root();
        NormalResponse {
            force,
            energy: T::broadcast(0.4) * force * overlap,
            damping: self.damping * root,
            tangential_stiffness: across,
            tangential_damping: self.tangential_damping * self.tangential_stiffness_root * root,
        }
    }
}

impl Hertz {
    /// Creates the law of grains with Young's moduli (Pa) and Poisson's ratios; the tangential stiffness is Mindlin's.
    pub fn new(youngs: [f64; 2], poisson: [f64; 2], damping_ratio: f64, damping_ratio_across: f64) -> Self {
        let normal: f64 = (0..2).map(|k| (1.0 - poisson[k] * poisson[k]) / youngs[k]).sum();
        let shear: f64 = (0..2).map(|k| (2.0 - poisson[k]) * 2.0 * (1.0 + poisson[k]) / youngs[k]).sum();
        Self {
            modulus: 1.0 / normal,
            shear_modulus: 1.0 / shear,
            grain_shear_modulus: 1.0 / shear,
            damping: dashpot_factor(damping_ratio),
            tangential_damping: dashpot_factor(damping_ratio_across),
            tangential_stiffness_root: (4.0 * normal / shear).sqrt(),
        }
    }

    /// Returns the law with a given ratio of tangential to normal stiffness, in place of Mindlin's.
    #[must_use]
    pub fn with_stiffness_ratio(self, ratio: f64) -> Self {
        Self { shear_modulus: 0.25 * ratio * self.modulus, tangential_stiffness_root: ratio.sqrt(), ..self }
    }

    /// Largest overlap (m) of an elastic impact of effective mass (kg), radius (m) and speed (m/s).
    pub fn max_impact_overlap(&self, mass: f64, radius: f64, speed: f64) -> f64 {
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
        let deepest = law.max_impact_overlap(mass, radius, speed);
        assert!((deepest / 1.00358e-5 - 1.0).abs() < 1e-5);
        assert!((law.duration(mass, radius, speed) / 2.9538e-5 - 1.0).abs() < 1e-4);
        let touch: ContactGeometry<3, 3> = ContactGeometry {
            overlap: deepest,
            normal: [1.0, 0.0, 0.0],
            separation_velocity: 0.0,
            sliding_velocity: [0.0; 3],
            relative_spin: [0.0; 3],
            spin: 0.0,
            mass,
            inverse_mass: 1.0 / mass,
            radius,
            min_radius: 0.005,
        };
        let at = law.response(&touch);
        assert!((at.force / 81.5202 - 1.0).abs() < 1e-5);
        assert!((at.energy / (0.5 * mass) - 1.0).abs() < 1e-9);
    }
}
