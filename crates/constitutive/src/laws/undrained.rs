//! Undrained saturated soil in effective stresses (sheet: constitutive §2.17, §3.11; Anura3D manual
//! eq. 4.52 with `K_L/n` in place of the printed `K_L`).
//!
//! The pore water moves with the skeleton: `Δp_w = -(K_f/n) tr A`, at least minus the cavitation strength. The
//! stress of the point is the total stress `σ = σ' - p_w 1`, that of the skeleton's law the effective stress `σ'`. Density is
//! that of the saturated soil. Limit: no seepage.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Warning;
use crate::adapters::wrapper::{WrappedMaterial, Wrapper};
use crate::contract::parameter_checks::{check, not_negative, positive};
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::{Material, MaterialError, MaterialSpec, Motion, SymTensor, Tangent};

/// Parameters of `undrained`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UndrainedSpec {
    /// Bulk modulus of the pore fluid `K_f` (Pa), positive.
    pub fluid_bulk_modulus: f64,
    /// Porosity, above 0, below 1.
    pub porosity: f64,
    /// Initial pore pressure (Pa, compression-positive); initial stresses are total.
    #[serde(default)]
    pub initial_pore_pressure: f64,
    /// Cavitation tension (Pa), non-negative; none when absent.
    #[serde(default)]
    pub cavitation_strength: Option<f64>,
    /// Skeleton in effective stresses, with the saturated density.
    pub skeleton: Box<MaterialSpec>,
}

impl UndrainedSpec {
    /// Parameters from fluid bulk modulus (Pa), porosity (-) and skeleton; all others have the defaults of a case file.
    #[must_use]
    pub fn new(fluid_bulk_modulus: f64, porosity: f64, skeleton: impl Into<MaterialSpec>) -> Self {
        Self {
            fluid_bulk_modulus,
            porosity,
            skeleton: Box::new(skeleton.into()),
            initial_pore_pressure: 0.0,
            cavitation_strength: None,
        }
    }
}

impl Model for UndrainedSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Anura3D manual 2021, eq. 4.52",
        kind: ModelFamily::Wrapper,
        strain: "the skeleton's",
        tangent: "the skeleton's",
    };

    const INNER_KEY: &'static str = "skeleton";

    fn inner(&self) -> Option<&MaterialSpec> {
        Some(&self.skeleton)
    }

    fn wrap_material(&self, inner: Arc<dyn Material>) -> Result<Arc<dyn Material>, MaterialError> {
        positive("fluid_bulk_modulus", self.fluid_bulk_modulus, "Pa")?;
        let inside = self.porosity > 0.0 && self.porosity < 1.0;
        check("porosity", self.porosity, inside, "is not between 0 and 1 (both excluded)")?;
        let pressure = self.initial_pore_pressure;
        check("initial_pore_pressure", pressure, pressure.is_finite(), "must be finite (Pa)")?;
        if let Some(strength) = self.cavitation_strength {
            not_negative("cavitation_strength", strength, "Pa")?;
            let rule = "is below minus the cavitation strength";
            check("initial_pore_pressure", pressure, pressure >= -strength, rule)?;
        }
        let wrapper = Undrained {
            modulus: self.fluid_bulk_modulus / self.porosity,
            start: pressure,
            min_pore_pressure: self.cavitation_strength.map_or(f64::NEG_INFINITY, |strength| -strength),
        };
        Ok(Arc::new(WrappedMaterial::new(wrapper, inner)))
    }

    fn warnings(&self) -> Vec<Warning> {
        let mut warnings: Vec<Warning> =
            self.skeleton.warnings().into_iter().map(|warning| warning.at("skeleton")).collect();
        // Flow at constant volume cannot dilate: suction grows as long as the soil is sheared.
        let psi = match &*self.skeleton {
            MaterialSpec::MohrCoulomb(spec) if spec.dilatancy_decay == 0.0 => spec.dilatancy_angle,
            MaterialSpec::DruckerPrager(spec) if spec.dilatancy_decay == 0.0 => spec.dilatancy_angle,
            _ => 0.0,
        };
        if psi > 0.0 && self.cavitation_strength.is_none() {
            warnings.push(Warning::new("unlimited-dilation", format!(
                "skeleton.dilatancy_angle: with {psi} degrees the undrained strength grows without limit. \
                 Give 0, or a dilatancy_decay or cavitation_strength"
            )));
        }
        warnings
    }

    fn strength_reduced(&self, reduction: &super::StrengthReduction) -> Option<Result<Self, MaterialError>> {
        let reduced = self.skeleton.strength_reduced(reduction);
        Some(reduced.map(|skeleton| Self { skeleton: Box::new(skeleton), ..self.clone() }))
    }

    fn examples() -> Vec<Self> {
        let skeletons =
            MaterialSpec::examples().into_iter().filter(|spec| spec.inner().is_none() && !spec.is_fluid());
        let one_of_each = skeletons.fold(Vec::<MaterialSpec>::new(), |mut all, spec| {
            if all.iter().all(|other| other.name() != spec.name()) {
                all.push(spec);
            }
            all
        });
        let around = |skeleton| Self {
            fluid_bulk_modulus: 2e8,
            porosity: 0.4,
            initial_pore_pressure: 0.0,
            cavitation_strength: Some(1e5),
            skeleton: Box::new(skeleton),
        };
        one_of_each.into_iter().map(around).collect()
    }
}

/// Undrained pore water; its internal variable is the pore pressure (Pa).
struct Undrained {
    /// Modulus `K_f/n` (Pa).
    modulus: f64,
    start: f64,
    min_pore_pressure: f64,
}

impl Wrapper for Undrained {
    type OwnState = f64;

    const NAME: &'static str = "undrained";

    const KEEPS_MOTION: bool = true;

    fn start(&self) -> f64 {
        self.start
    }

    fn inner_stress(&self, stress: &SymTensor, pressure: &f64) -> SymTensor {
        *stress + SymTensor::isotropic(*pressure)
    }

    fn outer_stress(&self, inner: &SymTensor, pressure: &f64) -> SymTensor {
        *inner - SymTensor::isotropic(*pressure)
    }

    fn step(&self, motion: &Motion, pressure: &f64) -> (Motion, f64) {
        (*motion, (pressure - self.modulus * motion.velocity_gradient_dt.trace()).max(self.min_pore_pressure))
    }

    fn added_modulus(&self) -> f64 {
        self.modulus
    }

    fn tangent(&self, mut inner: Tangent, motion: &Motion, pressure: &f64) -> Tangent {
        // A cavitating fluid has no stiffness.
        if self.step(motion, pressure).1 > self.min_pore_pressure {
            inner.add_dyad(self.modulus, &SymTensor::IDENTITY, &SymTensor::IDENTITY);
        }
        inner
    }

    fn added_energy(&self, pressure: &f64) -> f64 {
        0.5 * pressure * pressure / self.modulus
    }

    const OUTPUT: Option<&'static str> = Some("pore_pressure");

    fn output(&self, pressure: &f64) -> f64 {
        *pressure
    }
}
