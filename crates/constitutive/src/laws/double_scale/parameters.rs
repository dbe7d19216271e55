//! Parameters of `double-scale` and construction of the law.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::super::cohesive_band::CohesiveBandSpec;
use super::super::cohesive_damage::CohesiveDamageSpec;
use super::super::drucker_prager::{DruckerPrager, DruckerPragerSpec, Matching, Softening};
use super::super::linear_elastic::{LinearElastic, incompressibility_warnings};
use super::{BandSurroundings, DoubleScale};
use crate::Warning;
use crate::contract::elasticity::Elasticity;
use crate::contract::parameter_checks::positive;
use crate::laws::model::{Model, ModelFamily, ModelInfo, StrainMeasure};
use crate::{Corotational, InterfaceLaw, Material, MaterialError};

/// Parameters of `double-scale`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DoubleScaleSpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Young's modulus outside (Pa), positive.
    pub youngs_modulus: f64,
    /// Poisson's ratio outside, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Drucker–Prager strength outside; elastic when absent.
    #[serde(default)]
    pub outside: Option<OutsideStrength>,
    /// Interface law.
    pub band: BandSpec,
    /// Criterion and orientation of a new band.
    #[serde(default)]
    pub onset: Onset,
    /// Solver for the jump; when absent `return` in elastic surroundings, else `newton`.
    #[serde(default)]
    pub local_solve: Option<LocalSolve>,
    /// Band length (m), positive; when absent one cell in MPM (two with splines), two spacings in SPH.
    #[serde(default)]
    pub size: Option<f64>,
    /// Whether points restart intact when fully broken (desiccation networks).
    #[serde(default)]
    pub intact_reset: bool,
    /// Whether points large enough to snap back are allowed.
    #[serde(default)]
    pub allow_snapback: bool,
}

/// Interface law of a band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "law", rename_all = "kebab-case")]
pub enum BandSpec {
    /// Mixed-mode cohesion, friction.
    CohesiveFriction(CohesiveBandSpec),
    /// Exponentially softening damage, no friction.
    CohesiveDamage(CohesiveDamageSpec),
}

/// Criterion of new bands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Onset {
    /// Where the yield function of the band is exceeded, on the plane where it is largest.
    #[default]
    BandYield,
    /// Where the largest principal stress reaches the tensile strength, on the plane normal to it.
    Rankine,
    /// Where the determinant of the outer acoustic tensor is not positive, on that plane.
    Ellipticity,
}

/// Solver for the jump, without effect on the solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LocalSolve {
    /// Return map with elastic surroundings and band in series.
    Return,
    /// Newton's method, `σ(Δε - n ⊗ Δu/H) n = t(u + Δu)`.
    Newton,
}

/// Drucker–Prager strength outside.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutsideStrength {
    /// Friction angle (degrees), non-negative, below 90.
    pub friction_angle: f64,
    /// Cohesion (Pa), non-negative.
    #[serde(default)]
    pub cohesion: f64,
    /// Dilatancy angle (degrees), within ±`friction_angle`.
    #[serde(default)]
    pub dilatancy_angle: f64,
    /// Cone matching to Mohr–Coulomb.
    #[serde(default)]
    pub matching: Matching,
    /// Exponential softening.
    #[serde(default)]
    pub softening: Option<Softening>,
}

impl OutsideStrength {
    /// Strength of a friction angle (degrees), without cohesion, dilatancy and softening.
    #[must_use]
    pub fn new(friction_angle: f64) -> Self {
        let (cohesion, dilatancy_angle, matching) = (0.0, 0.0, Matching::default());
        Self { friction_angle, cohesion, dilatancy_angle, matching, softening: None }
    }
}

impl DoubleScaleSpec {
    /// Parameters from density (kg/m³), Young's modulus (Pa), Poisson's ratio (-) and band; all others have the defaults of a case file.
    #[must_use]
    pub fn new(density: f64, youngs_modulus: f64, poissons_ratio: f64, band: BandSpec) -> Self {
        Self {
            density,
            youngs_modulus,
            poissons_ratio,
            band,
            outside: None,
            onset: Onset::default(),
            local_solve: None,
            size: None,
            intact_reset: false,
            allow_snapback: false,
        }
    }

    /// Checks the ranges and builds the law around `band`, elastic outside.
    ///
    /// # Errors
    /// The first parameter out of range; a given size that snaps back unless that is allowed.
    pub fn law<B: InterfaceLaw>(&self, band: B) -> Result<DoubleScale<B>, MaterialError> {
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        if self.onset == Onset::Ellipticity && self.outside.is_none() {
            return Err(MaterialError::incompatible_options(
                "onset",
                "ellipticity needs a strength outside, which can be lost",
            ));
        }
        self.build_with_surroundings(LinearElastic { elasticity }, elasticity, band)
    }

    /// Law of a point that yields outside its band.
    fn plastic<B: InterfaceLaw>(
        &self,
        strength: OutsideStrength,
        band: B,
    ) -> Result<DoubleScale<B, DruckerPrager>, MaterialError> {
        if self.local_solve == Some(LocalSolve::Return) {
            return Err(MaterialError::incompatible_options(
                "local_solve",
                "return needs elastic surroundings",
            ));
        }
        let spec = DruckerPragerSpec {
            density: self.density,
            youngs_modulus: self.youngs_modulus,
            poissons_ratio: self.poissons_ratio,
            friction_angle: strength.friction_angle,
            cohesion: strength.cohesion,
            dilatancy_angle: strength.dilatancy_angle,
            matching: strength.matching,
            softening: strength.softening,
            dilatancy_decay: 0.0,
            integration: Default::default(),
            strain_measure: StrainMeasure::Rate,
            return_initial_stress_to_yield: false,
        };
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        let outside = spec.law().map_err(|error| error.under_key("outside"))?;
        self.build_with_surroundings(outside.with_name(super::NAME), elasticity, band)
    }

    /// Law of the band and the surrounding material, with the size of the point checked for snap-back.
    fn build_with_surroundings<B: InterfaceLaw, M: BandSurroundings>(
        &self,
        outside: M,
        elasticity: Elasticity,
        band: B,
    ) -> Result<DoubleScale<B, M>, MaterialError> {
        let largest = band.snap_back_size(self.youngs_modulus, elasticity.shear_modulus);
        if let Some(size) = self.size {
            positive("size", size, "m")?;
            if size >= largest && !self.allow_snapback {
                let rule = format!("causes snap-back: must be less than {largest} m, or set allow_snapback");
                return Err(MaterialError::parameter("size", size, rule));
            }
        }
        Ok(DoubleScale {
            newton: self.outside.is_some() || self.local_solve == Some(LocalSolve::Newton),
            outside,
            band,
            onset: self.onset,
            size: self.size,
            snap_back_size: if self.allow_snapback { f64::INFINITY } else { largest },
            intact_reset: self.intact_reset,
        })
    }

    /// Material of the parameters with a given band law; elastic or plastic outside the band.
    fn material<B: InterfaceLaw>(&self, band: B) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(match self.outside {
            None => Arc::new(Corotational(self.law(band)?)),
            Some(strength) => Arc::new(Corotational(self.plastic(strength, band)?)),
        })
    }

    /// Length of a band (m) above which it snaps back, unless that is allowed; `None` if parameters are invalid or the size is given.
    pub fn largest_band(&self) -> Option<f64> {
        self.largest_size().filter(|_| !self.allow_snapback && self.size.is_none())
    }

    /// Size (m) above which a point snaps back; `None` where the parameters are out of range.
    fn largest_size(&self) -> Option<f64> {
        let shear = Elasticity::new(self.youngs_modulus, self.poissons_ratio).ok()?.shear_modulus;
        match &self.band {
            BandSpec::CohesiveFriction(band) => {
                Some(band.law().ok()?.snap_back_size(self.youngs_modulus, shear))
            }
            BandSpec::CohesiveDamage(band) => {
                Some(band.law().ok()?.snap_back_size(self.youngs_modulus, shear))
            }
        }
    }
}

impl Model for DoubleScaleSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Bui & Nguyen 2021, eqs. 88–109; Wang et al. 2020 (band)",
        kind: ModelFamily::Solid,
        strain: "rate",
        tangent: "analytic",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        match &self.band {
            BandSpec::CohesiveFriction(band) => self.material(band.law()?),
            BandSpec::CohesiveDamage(band) => self.material(band.law()?),
        }
    }

    fn warnings(&self) -> Vec<Warning> {
        let mut warnings = incompressibility_warnings(self.poissons_ratio);
        if let (Some(size), Some(largest)) = (self.size, self.largest_size())
            && size >= largest
        {
            warnings.push(Warning::new(
                "snap-back",
                format!(
                    "size: snap-back, because {size} m is not less than {largest:.4} m. Use \
                               smaller cells, or give a smaller size"
                ),
            ));
        }
        warnings
    }

    fn examples() -> Vec<Self> {
        let band = CohesiveBandSpec {
            cohesion: 20e3,
            tensile_strength: 10e3,
            friction_coefficient: 0.6,
            dilatancy_coefficient: 0.2,
            opening_energy: 10.0,
            sliding_energy: 40.0,
            normal_stiffness: 5e9,
            shear_stiffness: 2e9,
        };
        let with = |band| Self {
            density: 2000.0,
            youngs_modulus: 20e6,
            poissons_ratio: 0.3,
            outside: None,
            band,
            onset: Onset::BandYield,
            local_solve: None,
            size: None,
            intact_reset: false,
            allow_snapback: false,
        };
        let isochoric = CohesiveBandSpec { dilatancy_coefficient: 0.0, ..band };
        let damage = CohesiveDamageSpec { tensile_strength: 10e3, fracture_energy: 10.0, stiffness: 5e9 };
        let newton = Self { local_solve: Some(LocalSolve::Newton), ..with(BandSpec::CohesiveFriction(band)) };
        vec![
            newton,
            with(BandSpec::CohesiveFriction(band)),
            with(BandSpec::CohesiveFriction(isochoric)),
            Self { onset: Onset::Rankine, ..with(BandSpec::CohesiveFriction(band)) },
            with(BandSpec::CohesiveDamage(damage)),
        ]
    }
}
