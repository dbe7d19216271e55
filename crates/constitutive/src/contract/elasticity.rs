//! Isotropic linear elasticity (sheet: constitutive §2.2): constants, and stress of a strain.

use crate::{MaterialError, SymTensor, Tangent};

/// Isotropic elastic constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elasticity {
    /// Bulk modulus `K` (Pa).
    pub bulk_modulus: f64,
    /// Shear modulus `G` (Pa).
    pub shear_modulus: f64,
}

impl Elasticity {
    /// Returns the constants from Young's modulus (Pa) and Poisson's ratio.
    ///
    /// # Errors
    /// Unless `youngs_modulus > 0` and `-1 < poissons_ratio < 0.5`.
    pub fn new(youngs_modulus: f64, poissons_ratio: f64) -> Result<Self, MaterialError> {
        if !(youngs_modulus.is_finite() && youngs_modulus > 0.0) {
            let rule = "must be finite and positive (Pa)";
            return Err(MaterialError::parameter("youngs_modulus", youngs_modulus, rule));
        }
        if !(poissons_ratio > -1.0 && poissons_ratio < 0.5) {
            let rule = "is not between -1 and 0.5 (exclusive)";
            return Err(MaterialError::parameter("poissons_ratio", poissons_ratio, rule));
        }
        Ok(Self {
            bulk_modulus: youngs_modulus / (3.0 * (1.0 - 2.0 * poissons_ratio)),
            shear_modulus: youngs_modulus / (2.0 * (1.0 + poissons_ratio)),
        })
    }

    /// First Lamé constant `λ = K - 2G/3` (Pa).
    #[inline]
    pub fn lame(&self) -> f64 {
        self.bulk_modulus - 2.0 / 3.0 * self.shear_modulus
    }

    /// Oedometric (P-wave) modulus `K + 4G/3` (Pa).
    #[inline]
    pub fn p_wave_modulus(&self) -> f64 {
        self.bulk_modulus + 4.0 / 3.0 * self.shear_modulus
    }

    /// Stress (Pa) of the elastic strain `strain`.
    #[inline]
    pub fn stress(&self, strain: &SymTensor) -> SymTensor {
        let volumetric = self.lame() * strain.trace();
        let two_g = 2.0 * self.shear_modulus;
        let e = &strain.0;
        SymTensor([
            volumetric + two_g * e[0],
            volumetric + two_g * e[1],
            volumetric + two_g * e[2],
            two_g * e[3],
            two_g * e[4],
            two_g * e[5],
        ])
    }

    /// Elastic strain of the stress `stress` (Pa).
    #[inline]
    pub fn strain(&self, stress: &SymTensor) -> SymTensor {
        let s = stress.deviator() * (0.5 / self.shear_modulus);
        s + SymTensor::isotropic(stress.trace() / (9.0 * self.bulk_modulus))
    }

    /// Elastic energy density (J/m³) at `stress`.
    #[inline]
    pub fn energy(&self, stress: &SymTensor) -> f64 {
        0.5 * stress.dot(&self.strain(stress))
    }

    /// Work dissipated by a return from `trial` to `stress` (J/m³).
    pub fn dissipation(&self, trial: &SymTensor, stress: &SymTensor) -> f64 {
        stress.dot(&self.strain(&(*trial - *stress)))
    }

    /// Deviatoric tangent: `2G θ` times the deviatoric projection.
    pub(crate) fn deviatoric_tangent(&self, theta: f64) -> Tangent {
        let two_g = 2.0 * self.shear_modulus * theta;
        let mut tangent = Tangent::ZERO;
        for i in 0..3 {
            tangent.0[i][i] = two_g;
            tangent.0[i + 3][i + 3] = 0.5 * two_g;
        }
        tangent.add_dyad(-two_g / 3.0, &SymTensor::IDENTITY, &SymTensor::IDENTITY);
        tangent
    }

    /// Elasticity matrix of principal values (Pa).
    pub fn principal(&self) -> [[f64; 3]; 3] {
        let lame = self.lame();
        std::array::from_fn(|a| {
            std::array::from_fn(|b| if a == b { lame + 2.0 * self.shear_modulus } else { lame })
        })
    }

    /// Elasticity matrix (Pa), engineering shear on the strain side.
    pub fn tangent(&self) -> Tangent {
        let mut c = [[0.0; 6]; 6];
        for i in 0..3 {
            for j in 0..3 {
                c[i][j] = self.lame();
            }
            c[i][i] += 2.0 * self.shear_modulus;
            c[i + 3][i + 3] = self.shear_modulus;
        }
        Tangent(c)
    }
}
