//! Quantities of porous media common to several laws (sheet: constitutive §2.17).

use crate::contract::parameter_checks::{check, positive};
use crate::{MaterialError, SymTensor};

/// Biot's poroelastic constants of a saturated soil or rock: grains, skeleton and fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Biot {
    /// Biot coefficient `B = 1 - K_T/K_s`.
    pub coefficient: f64,
    /// Porosity.
    pub porosity: f64,
    /// Bulk modulus of the grains `K_s` (Pa).
    pub grain_modulus: f64,
    /// Bulk modulus of the fluid `K_f` (Pa).
    pub fluid_modulus: f64,
}

impl Biot {
    /// Returns Biot's constants from the drained bulk modulus `K_T` of the skeleton and the moduli of grains and fluid (Pa).
    ///
    /// # Errors
    /// Unless all moduli are positive, `0 ≤ B ≤ 1` and the porosity lies between 0 and 1.
    pub fn new(
        skeleton_modulus: f64,
        grain_modulus: f64,
        fluid_modulus: f64,
        porosity: f64,
    ) -> Result<Self, MaterialError> {
        positive("skeleton_modulus", skeleton_modulus, "Pa")?;
        Self::with_coefficient(1.0 - skeleton_modulus / grain_modulus, grain_modulus, fluid_modulus, porosity)
    }

    /// Returns Biot's constants from the Biot coefficient.
    ///
    /// # Errors
    /// Those of [`Biot::new`].
    pub fn with_coefficient(
        coefficient: f64,
        grain_modulus: f64,
        fluid_modulus: f64,
        porosity: f64,
    ) -> Result<Self, MaterialError> {
        positive("grain_modulus", grain_modulus, "Pa")?;
        positive("fluid_modulus", fluid_modulus, "Pa")?;
        let rule = "is not between 0 and 1";
        check("biot_coefficient", coefficient, (0.0..=1.0).contains(&coefficient), rule)?;
        let inside = porosity > 0.0 && porosity < 1.0;
        check("porosity", porosity, inside, "is not between 0 and 1 (both excluded)")?;
        Ok(Self { coefficient, porosity, grain_modulus, fluid_modulus })
    }

    /// Biot modulus `M_B = K_s K_f / (K_f (B - n) + K_s n)` (Pa; Sun 2020, eq. 36).
    pub fn modulus(&self) -> f64 {
        let (grain, fluid) = (self.grain_modulus, self.fluid_modulus);
        grain * fluid / (fluid * (self.coefficient - self.porosity) + grain * self.porosity)
    }

    /// Undrained bulk modulus `K_u = K_T + B² M_B` (Pa), of a skeleton with modulus `K_T`.
    pub fn undrained_modulus(&self, skeleton_modulus: f64) -> f64 {
        skeleton_modulus + self.coefficient * self.coefficient * self.modulus()
    }

    /// Total stress `σ - B p_w 1` of an effective stress and a pore pressure (compression-positive).
    pub fn total_stress(&self, effective: &SymTensor, pore_pressure: f64) -> SymTensor {
        *effective - SymTensor::isotropic(self.coefficient * pore_pressure)
    }
}

/// Intrinsic permeability after Kozeny and Carman, `d² n³ / (180 (1 - n)²)` (m²), of grains of diameter
/// `diameter` (m) at the porosity `n` (Sun 2020, Fig. 28).
pub fn kozeny_carman(diameter: f64, porosity: f64) -> f64 {
    diameter * diameter / 180.0 * porosity.powi(3) / (1.0 - porosity).powi(2)
}

/// Hydraulic conductivity `k ρ g / μ` (m/s) of an intrinsic permeability `k` (m²), a fluid of density `ρ`
/// (kg/m³) and viscosity `μ` (Pa s) under gravity `g` (m/s²) (Anura3D manual eq. 3.25).
pub fn hydraulic_conductivity(permeability: f64, density: f64, viscosity: f64, gravity: f64) -> f64 {
    permeability * density * gravity / viscosity
}

/// Effective stress of an unsaturated soil after Bishop, `σ = σ_total + (χ p_w + (1 - χ) p_a) 1` (Pa), with the saturation as `χ` (sheet:
/// constitutive §2.17).
pub fn bishop_stress(
    total: &SymTensor,
    saturation: f64,
    water_pressure: f64,
    air_pressure: f64,
) -> SymTensor {
    *total + SymTensor::isotropic(saturation * water_pressure + (1.0 - saturation) * air_pressure)
}

/// Apparent cohesion `S_r s tan φ` (Pa) of the suction `s = p_a - p_w` (Pa), friction angle in radians.
pub fn apparent_cohesion(saturation: f64, suction: f64, friction_angle: f64) -> f64 {
    saturation * suction * friction_angle.tan()
}

/// Geostatic `K₀` stress at a depth `z` (Pa): vertical `σ_v = -γ z` in y, horizontal `K₀ σ_v` (sheet: constitutive §3.11). `gamma` is the
/// unit weight (N/m³), the depth is positive downwards (m).
pub fn geostatic_stress(gamma: f64, depth: f64, earth_pressure: f64) -> SymTensor {
    let vertical = -gamma * depth;
    SymTensor::diagonal(earth_pressure * vertical, vertical, earth_pressure * vertical)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn biot_moduli_of_the_sheet() {
        // V-24: Sun 2020, Table 2; within 0.5 %.
        for (porosity, coefficient, exact) in [(0.375, 0.976, 179.5e6), (0.427, 0.983, 167.9e6)] {
            let biot = Biot::with_coefficient(coefficient, 0.33e9, 0.1e9, porosity).unwrap();
            assert!((biot.modulus() / exact - 1.0).abs() < 5e-3, "{}", biot.modulus());
        }
        assert!(Biot::new(1e9, 0.5e9, 1e8, 0.3).unwrap_err().to_string().starts_with("biot_coefficient"));
        assert!(Biot::new(1e8, 0.5e9, 1e8, 1.0).unwrap_err().to_string().starts_with("porosity"));
    }

    #[test]
    fn incompressible_grains_give_the_modulus_of_the_fluid_over_porosity() {
        // §5.3: K_L = 2.15 GPa, n = 0.4, set R1: K_u = 5.391667 GPa, ν_u = 0.499287.
        let biot = Biot::with_coefficient(1.0, 1e30, 2.15e9, 0.4).unwrap();
        let (k, g) = (16_666_666.67, 7_692_307.69);
        let undrained = biot.undrained_modulus(k);
        assert!((undrained / 5.391_667e9 - 1.0).abs() < 1e-6, "{undrained}");
        let poisson = (3.0 * undrained - 2.0 * g) / (2.0 * (3.0 * undrained + g));
        assert!((poisson - 0.499_287).abs() < 1e-6, "{poisson}");
    }

    #[test]
    fn permeabilities_have_their_units() {
        let k = kozeny_carman(1e-3, 0.4);
        assert!((k - 1e-6 / 180.0 * 0.064 / 0.36).abs() < 1e-20);
        assert!((hydraulic_conductivity(1e-11, 1000.0, 1e-3, 9.81) - 9.81e-5).abs() < 1e-12);
    }

    #[test]
    fn suction_gives_compressive_effective_stress_and_apparent_cohesion() {
        let stress = bishop_stress(&SymTensor::ZERO, 0.5, -20e3, 0.0);
        assert_eq!(stress, SymTensor::isotropic(-10e3));
        assert!((apparent_cohesion(0.5, 20e3, 45f64.to_radians()) - 10e3).abs() < 1e-9);
        assert_eq!(geostatic_stress(20e3, 5.0, 0.5), SymTensor::diagonal(-50e3, -100e3, -50e3));
    }
}
