//! Isotropic elasticity with pressure-dependent stiffness (sheet: constitutive §2.2; Anura3D manual
//! eqs. 7.6–7.11).
//!
//! Sand: `G = A (p/p_ref)ⁿ`, `K = 2(1+ν)/(3(1-2ν)) G`. Clay: `K = (1+e) p/κ`, `G = 3(1-2ν)/(2(1+ν)) K`.
//! Poisson's ratio is constant; `dp = K dε_v`, `ds = 2G de` with volume compression `ε_v`, and the
//! void ratio follows from the volume, `1 + e = (1 + e₀) exp(tr ε)`. Pressure is integrated in closed form, so
//! that it is a function of volume alone (clay: `e + κ ln p` is constant), and the deviator with the secant
//! shear modulus of the step, which is exact for a constant direction of strain. Below the least
//! pressure the stiffness is that of the least pressure, also in tension. Limits: with constant
//! Poisson's ratio no elastic energy exists, so a closed strain path may leave a residual shear stress.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::linear_elastic::incompressibility_warnings;
use crate::Warning;
use crate::contract::parameter_checks::{check, positive, within_range};
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::return_maps::radial_return::RadialTrial;
use crate::{
    Corotational, InitialCondition, Law, Material, MaterialError, Motion, Point, PointLaw, SmallStrain,
    SymTensor, Tangent,
};

/// Value of the key `model` in case files.
const NAME: &str = "pressure-dependent-elastic";

/// Reference pressure of laws that have none as a parameter (Pa).
pub(super) const REFERENCE_PRESSURE: f64 = 1e3;

/// Smallest pressure over the reference pressure (sheet: constitutive P-14).
const MIN_PRESSURE_RATIO: f64 = 1e-3;

/// Smallest pressure of laws that have no reference pressure as a parameter (Pa).
pub(super) const MIN_PRESSURE: f64 = MIN_PRESSURE_RATIO * REFERENCE_PRESSURE;

/// Stiffness as function of pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum PressureStiffness {
    /// Power law of pressure: `G = A (p/p_ref)ⁿ`.
    Sand {
        /// Shear modulus `A` at reference pressure (Pa), positive.
        shear_modulus: f64,
        /// Reference pressure (Pa), positive.
        reference_pressure: f64,
        /// Exponent `n`, 0 (constant stiffness) to 1.
        exponent: f64,
    },
    /// Stiffness proportional to pressure: `K = (1+e) p/κ`.
    Clay {
        /// Slope `κ` of unloading, positive.
        swelling_slope: f64,
    },
}

/// Parameters of `pressure-dependent-elastic`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressureElasticSpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Stiffness as function of pressure.
    pub stiffness: PressureStiffness,
    /// Poisson's ratio, between -1 and 0.5.
    #[serde(default = "poissons_ratio")]
    pub poissons_ratio: f64,
    /// Initial void ratio, positive.
    pub void_ratio: f64,
    /// Pressure (Pa) below which stiffness is constant, positive; by default 0.001 of the reference (1 kPa for clay).
    #[serde(default)]
    pub least_pressure: Option<f64>,
}

/// Default Poisson's ratio.
fn poissons_ratio() -> f64 {
    0.2
}

/// Checks that Poisson's ratio lies between -1 and 0.5, both excluded.
pub(super) fn check_poissons_ratio(value: f64) -> Result<(), MaterialError> {
    check("poissons_ratio", value, value > -1.0 && value < 0.5, "is not between -1 and 0.5 (exclusive)")
}

/// Ratio `G/K = 3(1-2ν)/(2(1+ν))`.
pub(super) fn shear_ratio(poissons_ratio: f64) -> f64 {
    1.5 * (1.0 - 2.0 * poissons_ratio) / (1.0 + poissons_ratio)
}

impl PressureElasticSpec {
    /// Parameters from density (kg/m³), stiffness and void ratio (-); all others have the defaults of a case file.
    #[must_use]
    pub fn new(density: f64, stiffness: PressureStiffness, void_ratio: f64) -> Self {
        Self { density, stiffness, void_ratio, poissons_ratio: poissons_ratio(), least_pressure: None }
    }

    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<PressureElastic, MaterialError> {
        let smallest = match self.stiffness {
            PressureStiffness::Sand { shear_modulus, reference_pressure, exponent } => {
                positive("stiffness.shear_modulus", shear_modulus, "Pa")?;
                positive("stiffness.reference_pressure", reference_pressure, "Pa")?;
                within_range("stiffness.exponent", exponent, 0.0, 1.0)?;
                MIN_PRESSURE_RATIO * reference_pressure
            }
            PressureStiffness::Clay { swelling_slope } => {
                positive("stiffness.swelling_slope", swelling_slope, "")?;
                MIN_PRESSURE
            }
        };
        check_poissons_ratio(self.poissons_ratio)?;
        positive("void_ratio", self.void_ratio, "")?;
        let least_pressure = self.least_pressure.unwrap_or(smallest);
        positive("least_pressure", least_pressure, "Pa")?;
        let shear_ratio = shear_ratio(self.poissons_ratio);
        Ok(PressureElastic { spec: self.clone(), shear_ratio, least_pressure })
    }
}

impl Model for PressureElasticSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Anura3D manual 2021, eqs. 7.6–7.11",
        kind: ModelFamily::Solid,
        strain: "rate",
        tangent: "analytic",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(Arc::new(Corotational(self.law()?)))
    }

    fn warnings(&self) -> Vec<Warning> {
        incompressibility_warnings(self.poissons_ratio)
    }

    fn examples() -> Vec<Self> {
        let sand = PressureStiffness::Sand { shear_modulus: 20e6, reference_pressure: 100e3, exponent: 0.5 };
        let clay = PressureStiffness::Clay { swelling_slope: 0.1 };
        let with = |stiffness| Self {
            density: 1800.0,
            stiffness,
            poissons_ratio: 0.2,
            void_ratio: 0.9,
            least_pressure: None,
        };
        [sand, clay].map(with).into()
    }
}

/// Pressure-dependent elastic law. See the module's head for source and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct PressureElastic {
    spec: PressureElasticSpec,
    shear_ratio: f64,
    least_pressure: f64,
}

/// State of a point: the void ratio.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct VoidRatio {
    /// Void ratio: volume of voids over volume of grains.
    pub void_ratio: f64,
}

/// Void ratio after the volumetric strain `volumetric` (expansion-positive): `(1+e) exp(tr ε) - 1`.
#[inline]
pub(super) fn void_ratio_after(void_ratio: f64, volumetric: f64) -> f64 {
    void_ratio + (1.0 + void_ratio) * volumetric.exp_m1()
}

/// Pressure after a volume compression `Δ`, with the moduli of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct VolumeStep {
    /// Pressure `p` (Pa).
    pub pressure: f64,
    /// Tangent modulus `dp/dΔ` (Pa).
    pub tangent: f64,
    /// Secant modulus `(p - p_n)/Δ` (Pa).
    pub secant: f64,
    /// Slope `d secant/dΔ` of the secant modulus (Pa).
    pub secant_slope: f64,
}

impl VolumeStep {
    /// Returns the step of a compression from the pressure `p_n` with bulk modulus `modulus`, to `(1 + growth) p_n` with bulk modulus
    /// `tangent` (Pa). `curvature = dK/dΔ` at the start replaces differences in very small steps.
    pub(super) fn new(
        p_n: f64,
        compression: f64,
        growth: f64,
        modulus: f64,
        tangent: f64,
        curvature: f64,
    ) -> Self {
        let pressure = p_n + p_n * growth;
        if (modulus * compression).abs() <= 1e-6 * p_n.abs() {
            let secant = modulus + 0.5 * curvature * compression;
            return Self { pressure, tangent, secant, secant_slope: 0.5 * curvature };
        }
        let secant = p_n * growth / compression;
        Self { pressure, tangent, secant, secant_slope: (tangent - secant) / compression }
    }

    /// Returns the step of a constant bulk modulus.
    fn linear(p_n: f64, compression: f64, modulus: f64) -> Self {
        let pressure = p_n + modulus * compression;
        Self { pressure, tangent: modulus, secant: modulus, secant_slope: 0.0 }
    }
}

impl PressureElastic {
    /// Bulk modulus (Pa) at a pressure (Pa, compression-positive) and void ratio.
    pub fn bulk_modulus(&self, pressure: f64, void_ratio: f64) -> f64 {
        let p = pressure.max(self.least_pressure);
        match self.spec.stiffness {
            PressureStiffness::Sand { shear_modulus, reference_pressure, exponent } => {
                shear_modulus / self.shear_ratio * (p / reference_pressure).powf(exponent)
            }
            PressureStiffness::Clay { swelling_slope } => (1.0 + void_ratio) * p / swelling_slope,
        }
    }

    /// Shear modulus (Pa) at a pressure (Pa, compression-positive) and void ratio.
    pub fn shear_modulus(&self, pressure: f64, void_ratio: f64) -> f64 {
        self.shear_ratio * self.bulk_modulus(pressure, void_ratio)
    }

    /// Pressure after the compression `Δ` from `p` at void ratio `e`.
    fn compress(&self, p: f64, e: f64, compression: f64) -> VolumeStep {
        let whole = self.compress_within_branch(p, e, compression);
        let low = self.least_pressure;
        if (p < low) == (whole.pressure < low) || p == low {
            return whole;
        }
        // Across the least pressure: up to it, and on with the other branch.
        let first = self.compression_to(p, e, low);
        let middle = void_ratio_after(e, -first);
        let second = self.compress_within_branch(low, middle, compression - first);
        let secant = (second.pressure - p) / compression;
        VolumeStep { secant, secant_slope: (second.tangent - secant) / compression, ..second }
    }

    /// Pressure after a compression like [`Self::compress`], for pressures all above or all below the smallest pressure.
    fn compress_within_branch(&self, p: f64, e: f64, compression: f64) -> VolumeStep {
        let modulus = self.bulk_modulus(p, e);
        let after = void_ratio_after(e, -compression);
        let linear = p < self.least_pressure || (p == self.least_pressure && compression < 0.0);
        match self.spec.stiffness {
            PressureStiffness::Sand { .. } if linear => VolumeStep::linear(p, compression, modulus),
            PressureStiffness::Sand { exponent, .. } => {
                let y = modulus * compression / p;
                let growth = if exponent < 1.0 {
                    // Negative pressures are beyond the least pressure in any case.
                    (((1.0 - exponent) * y).max(-1.0).ln_1p() / (1.0 - exponent)).exp_m1()
                } else {
                    y.exp_m1()
                };
                let tangent = modulus * (1.0 + growth).powf(exponent);
                VolumeStep::new(p, compression, growth, modulus, tangent, exponent * modulus * modulus / p)
            }
            PressureStiffness::Clay { swelling_slope } => {
                // `(e - after) / κ`, without the cancellation.
                let drop = -(1.0 + e) * (-compression).exp_m1() / swelling_slope;
                if linear {
                    // K = (1+e) p_min/κ still depends on the void ratio.
                    let gain = self.least_pressure * drop;
                    let tangent = self.bulk_modulus(p, after);
                    let scale = self.least_pressure;
                    let step = VolumeStep::new(scale, compression, gain / scale, modulus, tangent, -modulus);
                    return VolumeStep { pressure: p + gain, ..step };
                }
                let growth = drop.exp_m1();
                let tangent = (1.0 + after) * p * (1.0 + growth) / swelling_slope;
                VolumeStep::new(p, compression, growth, modulus, tangent, modulus * (modulus / p - 1.0))
            }
        }
    }

    /// Compression that changes the pressure from `p` to `to` (Pa), both above or both below the smallest pressure.
    fn compression_to(&self, p: f64, e: f64, to: f64) -> f64 {
        match self.spec.stiffness {
            PressureStiffness::Sand { exponent, .. } => {
                let modulus = self.bulk_modulus(p, e);
                if p < self.least_pressure {
                    (to - p) / modulus
                } else if exponent < 1.0 {
                    p / modulus * ((to / p).powf(1.0 - exponent) - 1.0) / (1.0 - exponent)
                } else {
                    p / modulus * (to / p).ln()
                }
            }
            PressureStiffness::Clay { swelling_slope } => {
                let low = self.least_pressure;
                let drop = if p < low { (to - p) / low } else { (to / p).ln() };
                -(-swelling_slope * drop / (1.0 + e)).ln_1p()
            }
        }
    }

    /// Elastic trial of a strain increment: volumetric step and deviatoric trial stress with the secant moduli (Pa).
    fn trial(&self, strain: &SymTensor, old: &Point<VoidRatio>) -> (VolumeStep, RadialTrial) {
        let step = self.compress(old.stress.pressure(), old.state.void_ratio, -strain.trace());
        let (shear, slope) = (self.shear_ratio * step.secant, self.shear_ratio * step.secant_slope);
        (step, RadialTrial::new(&old.stress, strain, shear, slope))
    }
}

impl Law for PressureElastic {
    fn name(&self) -> &'static str {
        NAME
    }

    fn output_names(&self) -> &[&'static str] {
        &["void_ratio"]
    }
}

impl PointLaw for PressureElastic {
    type State = VoidRatio;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<VoidRatio>, MaterialError> {
        super::check_compressive(NAME, &initial.stress)?;
        Ok(Point { stress: initial.stress, state: VoidRatio { void_ratio: self.spec.void_ratio } })
    }

    fn wave_modulus(&self, point: &Point<VoidRatio>) -> f64 {
        let modulus = self.bulk_modulus(point.stress.pressure(), point.state.void_ratio);
        1.1 * modulus * (1.0 + 4.0 / 3.0 * self.shear_ratio)
    }

    fn outputs(&self, point: &Point<VoidRatio>, out: &mut [f64]) {
        out[0] = point.state.void_ratio;
    }
}

impl SmallStrain for PressureElastic {
    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<VoidRatio>,
    ) -> Result<Point<VoidRatio>, MaterialError> {
        let (step, trial) = self.trial(strain, old);
        let state = VoidRatio { void_ratio: void_ratio_after(old.state.void_ratio, strain.trace()) };
        Ok(Point { stress: trial.stress(step.pressure, 1.0), state })
    }

    fn max_strain_increment(&self) -> f64 {
        f64::INFINITY
    }

    fn tangent(&self, strain: &SymTensor, _motion: &Motion, old: &Point<VoidRatio>) -> Option<Tangent> {
        let (step, trial) = self.trial(strain, old);
        Some(trial.tangent(1.0, &SymTensor::isotropic(-step.tangent), &SymTensor::ZERO))
    }
}
