//! Fixed-corotated elasticity (sheet: constitutive §2.13; Stomakhin et al. 2012, 2013).
//!
//! Energy `Ψ = μ Σ (s_A - 1)² + λ/2 (J - 1)²` per initial volume of the principal stretches `s_A`; Kirchhoff
//! stress `τ = 2μ (F - R) Fᵀ + λ (J - 1) J 1`, in principal values `τ_A = 2μ s_A (s_A - 1) + λ J (J - 1)`.
//! Path-independent. Parameters: Young's modulus (Pa) and Poisson's ratio at small strain. Limits: the stress
//! is finite however far the point is flattened, so it does not prevent points from inverting.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Elasticity;
use super::finite_elastic::{
    FiniteElastic, PrincipalStress, elongations, jacobian, solve_deformation, volume_change,
};
use super::linear_elastic::incompressibility_warnings;
use crate::Warning;
use crate::contract::tangent::kirchhoff_tangent;
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::{Material, MaterialError, SymTensor, Tangent};

/// Parameters of `fixed-corotated`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixedCorotatedSpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Small-strain Young's modulus (Pa), positive.
    pub youngs_modulus: f64,
    /// Small-strain Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
}

impl FixedCorotatedSpec {
    /// Parameters from density (kg/m³), Young's modulus (Pa) and Poisson's ratio (-).
    #[must_use]
    pub fn new(density: f64, youngs_modulus: f64, poissons_ratio: f64) -> Self {
        Self { density, youngs_modulus, poissons_ratio }
    }
}

impl Model for FixedCorotatedSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Stomakhin et al. 2013; Gaume et al. 2020, 4.1",
        kind: ModelFamily::Solid,
        strain: "finite",
        tangent: "analytic",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        Ok(Arc::new(FixedCorotated { elasticity }))
    }

    fn warnings(&self) -> Vec<Warning> {
        incompressibility_warnings(self.poissons_ratio)
    }

    fn examples() -> Vec<Self> {
        vec![Self { density: 2000.0, youngs_modulus: 20e6, poissons_ratio: 0.3 }]
    }
}

/// Fixed-corotated law. See the module's head for source and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedCorotated {
    /// Elastic constants at small strain.
    pub elasticity: Elasticity,
}

impl FixedCorotated {
    /// Principal Kirchhoff stresses (Pa) of principal elongations (stretches minus one).
    #[inline]
    pub fn principal(&self, elongations: [f64; 3]) -> PrincipalStress {
        let (mu, lame) = (self.elasticity.shear_modulus, self.elasticity.lame());
        let change = volume_change(elongations);
        let jacobian = 1.0 + change;
        let volumetric = lame * jacobian * change;
        let stress = elongations.map(|e| 2.0 * mu * (1.0 + e) * e + volumetric);
        let mut slope = [[lame * jacobian * (jacobian + change); 3]; 3];
        for (a, e) in elongations.into_iter().enumerate() {
            slope[a][a] += 2.0 * mu * (1.0 + e) * (1.0 + 2.0 * e);
        }
        PrincipalStress { stress, slope }
    }

    /// Cauchy stress (Pa) of `b - 1` with the elongation tensor `E = b^½ - 1` and the volume change `J - 1`: since `b - 1 = 2E + E²`, the
    /// Kirchhoff stress is `2μ (b - 1 - E) + λ J (J - 1) 1`.
    #[inline(always)]
    fn stress_of_elongation(&self, b: &SymTensor, elongation: &SymTensor, change: f64) -> SymTensor {
        let (mu, lame) = (self.elasticity.shear_modulus, self.elasticity.lame());
        let jacobian = 1.0 + change;
        ((*b - *elongation) * (2.0 * mu) + SymTensor::isotropic(lame * jacobian * change)) * (1.0 / jacobian)
    }

    /// Elastic energy per unit initial volume (J/m³) of principal elongations (stretches minus one).
    pub fn energy(&self, elongations: [f64; 3]) -> f64 {
        let change = volume_change(elongations);
        self.elasticity.shear_modulus * elongations.iter().map(|e| e * e).sum::<f64>()
            + 0.5 * self.elasticity.lame() * change * change
    }
}

impl FiniteElastic for FixedCorotated {
    const NAME: &'static str = "fixed-corotated";

    #[inline(always)]
    fn cauchy_stress(&self, b: &SymTensor) -> SymTensor {
        let [x, y, z] = elongations(b.principal_values_without_branches());
        let (i1, i2, i3) = (x + y + z, x * y + y * z + z * x, x * y * z);
        // `b - 1 = 2E + E²` with the elongation tensor `E`, whose third power follows from its invariants by the
        // Cayley–Hamilton theorem; the divisor is the product of the sums of two stretches each, so it is never zero.
        let (linear, constant) = (4.0 + 4.0 * i1 + i1 * i1 - i2, i3 * (4.0 + i1));
        let inverse = 1.0 / (2.0 * linear - (i3 - 4.0 * i2 - i1 * i2));
        let square = SymTensor::IDENTITY.rotated(&b.to_matrix());
        let elongation = (*b * linear - square + SymTensor::isotropic(constant)) * inverse;
        self.stress_of_elongation(b, &elongation, i1 + i2 + i3)
    }

    #[inline(always)]
    fn cauchy_stress_in_plane(&self, b: &SymTensor) -> SymTensor {
        let [xx, yy, zz, xy, ..] = b.0;
        // Square root of the matrix in the plane, minus one: `(1 + b + det(V) 1)/tr(V) - 1`.
        let (trace, rest) = (xx + yy, xx * yy - xy * xy);
        let area = (trace + rest) / (1.0 + (1.0 + (trace + rest)).sqrt());
        let sum = (4.0 + (trace + 2.0 * area)).sqrt();
        let shift = area - (trace + 2.0 * area) / (2.0 + sum);
        let inverse = 1.0 / sum;
        let across = zz / (1.0 + (1.0 + zz).sqrt());
        let elongation =
            SymTensor([(xx + shift) * inverse, (yy + shift) * inverse, across, xy * inverse, 0.0, 0.0]);
        self.stress_of_elongation(b, &elongation, area + across + area * across)
    }

    fn deformation_for_stress(&self, stress: &SymTensor) -> Result<SymTensor, MaterialError> {
        solve_deformation(Self::NAME, stress, &self.elasticity, |e| self.principal(e))
    }

    fn spatial_tangent(&self, b: &SymTensor) -> Tangent {
        let spectrum = b.spectrum();
        let PrincipalStress { stress, slope } = self.principal(elongations(spectrum.values));
        kirchhoff_tangent(&spectrum, stress, spectrum.values.map(|b| 1.0 + b), &slope)
    }

    #[inline(always)]
    fn max_wave_modulus(&self, b: &SymTensor, largest: f64, _stress: &SymTensor) -> f64 {
        let (mu, lame, jacobian) = (self.elasticity.shear_modulus, self.elasticity.lame(), jacobian(b));
        // max (c_AAAA + τ_A) / J of §3.9, which is 2 μ s² + λ J² in the direction stretched most.
        2.0 * mu * (1.0 + largest) / jacobian + lame * jacobian
    }

    fn initial_energy(&self, b: &SymTensor) -> f64 {
        self.energy(elongations(b.spectrum().values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BLOCK_SIZE, InitialCondition, Mat3, Motion, MotionBlock};
    use proptest::prelude::*;

    const LAW: FixedCorotated =
        FixedCorotated { elasticity: Elasticity { bulk_modulus: 2e6, shear_modulus: 1e6 } };

    /// Cauchy stress from the principal stretches.
    fn stress_of_spectrum(b: &SymTensor) -> SymTensor {
        let spectrum = b.spectrum();
        let elongations = elongations(spectrum.values);
        spectrum.compose(LAW.principal(elongations).stress) * (1.0 / (1.0 + volume_change(elongations)))
    }

    /// Tensor `b - 1` of principal stretches and rotation angles about z and x.
    fn change(stretches: [f64; 3], [about_z, about_x]: [f64; 2]) -> SymTensor {
        let (sin, cos) = about_x.sin_cos();
        let q = Mat3::rotation_z(about_z) * Mat3([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]]);
        let [x, y, z] = stretches.map(|s| (s - 1.0) * (s + 1.0));
        SymTensor::diagonal(x, y, z).rotated(&q)
    }

    proptest! {
        #[test]
        fn closed_forms_are_those_of_the_spectrum(
            exponents in proptest::array::uniform3(-1.0..1.0f64), size in -9.0..0.0f64,
            angles in proptest::array::uniform2(0.0..3.0f64), twins in 0..3u8,
        ) {
            let [mut x, mut y, z] = exponents.map(|e| (e * 10f64.powf(size)).exp());
            if twins > 0 {
                x = y;
            }
            if twins > 1 {
                y = z;
            }
            let close = |found: SymTensor, exact: SymTensor| {
                (found - exact).norm() <= 1e-12 * exact.norm() + 1e-14 * LAW.elasticity.shear_modulus * 10f64.powf(size)
            };
            let b = change([x, y, z], angles);
            prop_assert!(close(LAW.cauchy_stress(&b), stress_of_spectrum(&b)), "{b:?}");
            let b = change([x, y, z], [angles[0], 0.0]);
            prop_assert!(close(LAW.cauchy_stress_in_plane(&b), stress_of_spectrum(&b)), "{b:?}");
        }

        #[test]
        fn blocks_have_the_bits_of_single_points(
            entries in proptest::array::uniform9(-0.2..0.2f64), planar in proptest::array::uniform8(0..3u8),
        ) {
            let law = FixedCorotatedSpec::new(2000.0, 1e6, 0.3).build().unwrap();
            let mut motions = MotionBlock::at_rest(1e-3, 1.0, false);
            let step = |i: usize| {
                let mut f = Mat3(std::array::from_fn(|r| std::array::from_fn(|c| {
                    f64::from(u8::from(r == c)) + entries[(3 * r + c + i) % 9]
                })));
                if planar[i % 8] > 0 {
                    (f.0[0][2], f.0[1][2], f.0[2][0], f.0[2][1]) = (0.0, 0.0, 0.0, 0.0);
                }
                Motion { deformation: f, ..Motion::AT_REST }
            };
            let steps: Vec<Motion> = (0..BLOCK_SIZE).map(step).collect();
            prop_assume!(steps.iter().all(|step| (0.5..=2.0).contains(&step.deformation.determinant())));
            steps.iter().enumerate().for_each(|(i, step)| motions.set(i, step));
            let start = InitialCondition { stress: SymTensor::ZERO, density: 2000.0 };
            let (mut stresses, mut states) = law.initial(&[start; BLOCK_SIZE]).unwrap();
            law.update_block(&motions, &mut stresses, &mut states.blocks_mut()[0]).unwrap();
            let mut moduli = [0.0; BLOCK_SIZE];
            law.wave_moduli(&stresses, &states.blocks()[0], &mut moduli);
            for (i, step) in steps.iter().enumerate() {
                let (mut stress, mut state) = law.initial(&[start]).unwrap();
                law.update(&[*step], &mut stress, &mut state.blocks_mut()[0]).unwrap();
                prop_assert_eq!(stress[0], stresses[i]);
                let mut modulus = [0.0];
                law.wave_moduli(&stress, &state.blocks()[0], &mut modulus);
                prop_assert_eq!(modulus[0], moduli[i]);
            }
        }
    }
}
