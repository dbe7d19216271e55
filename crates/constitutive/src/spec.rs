//! Materials as a case file gives them: the one list of models.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::laws::{
    DruckerPragerSpec, LinearElasticSpec, Matching, MohrCoulombSpec, NeoHookeanSpec, NewtonianFluidSpec,
    Softening, StrainMeasure,
};
use crate::{Material, MaterialError};

/// A material of a case file: the model's name and its parameters, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "model", rename_all = "kebab-case")]
pub enum MaterialSpec {
    /// Linear isotropic elasticity.
    LinearElastic(LinearElasticSpec),
    /// Compressible neo-Hookean elasticity, finite strain.
    NeoHookean(NeoHookeanSpec),
    /// Drucker–Prager plasticity.
    DruckerPrager(DruckerPragerSpec),
    /// Mohr–Coulomb plasticity.
    MohrCoulomb(MohrCoulombSpec),
    /// Weakly compressible Newtonian fluid.
    NewtonianFluid(NewtonianFluidSpec),
}

impl MaterialSpec {
    /// Name of the model.
    pub fn name(&self) -> &'static str {
        match self {
            Self::LinearElastic(_) => "linear-elastic",
            Self::NeoHookean(_) => "neo-hookean",
            Self::DruckerPrager(_) => "drucker-prager",
            Self::MohrCoulomb(_) => "mohr-coulomb",
            Self::NewtonianFluid(_) => "newtonian-fluid",
        }
    }

    /// Initial density (kg/m³).
    pub fn density(&self) -> f64 {
        match self {
            Self::LinearElastic(spec) => spec.density,
            Self::NeoHookean(spec) => spec.density,
            Self::DruckerPrager(spec) => spec.density,
            Self::MohrCoulomb(spec) => spec.density,
            Self::NewtonianFluid(spec) => spec.density,
        }
    }

    /// The law, parameters checked and angles converted.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        match self {
            Self::LinearElastic(spec) => spec.build(),
            Self::NeoHookean(spec) => Ok(Arc::new(spec.law()?)),
            Self::DruckerPrager(spec) => spec.build(),
            Self::MohrCoulomb(spec) => spec.build(),
            Self::NewtonianFluid(spec) => Ok(Arc::new(spec.law()?)),
        }
    }

    /// What is allowed but worth a word, each starting with the parameter's name.
    pub fn warnings(&self) -> Vec<String> {
        let (mut warnings, poissons_ratio) = match self {
            Self::LinearElastic(spec) => (Vec::new(), spec.poissons_ratio),
            Self::NeoHookean(spec) => (Vec::new(), spec.poissons_ratio),
            Self::DruckerPrager(spec) => (spec.warnings(), spec.poissons_ratio),
            Self::MohrCoulomb(spec) => {
                (crate::laws::angle_warnings(spec.friction_angle, spec.dilatancy_angle), spec.poissons_ratio)
            }
            Self::NewtonianFluid(_) => (Vec::new(), 0.0),
        };
        if poissons_ratio > 0.495 {
            warnings.push(format!(
                "poissons_ratio: {poissons_ratio} makes explicit steps short and low-order grids lock"
            ));
        }
        warnings
    }

    /// True for parameters that mean something in plane strain only.
    pub fn assumes_plane_strain(&self) -> bool {
        let planar = [Matching::PlaneStrain, Matching::PlaneStrainAssociated];
        matches!(self, Self::DruckerPrager(spec) if planar.contains(&spec.matching))
    }

    /// True for laws that forget shear: at rest they carry none, or no more than their yield stress.
    pub fn is_fluid(&self) -> bool {
        matches!(self, Self::NewtonianFluid(_))
    }

    /// A sample of every model and every way to run it: what the contract tests run over.
    pub fn examples() -> Vec<Self> {
        let (density, youngs_modulus, poissons_ratio) = (2000.0, 20e6, 0.3);
        let softening = Softening {
            residual_friction_angle: 20.0,
            residual_cohesion: 2e3,
            friction_rate: 3.0,
            cohesion_rate: 5.0,
        };
        let mut all = vec![
            Self::NeoHookean(NeoHookeanSpec { density, youngs_modulus, poissons_ratio }),
            Self::NewtonianFluid(NewtonianFluidSpec {
                density,
                bulk_modulus: 2e7,
                viscosity: 100.0,
                cavitation_strength: 1e4,
                equation_of_state: Default::default(),
            }),
        ];
        for strain_measure in [StrainMeasure::Rate, StrainMeasure::Hencky] {
            all.push(Self::LinearElastic(LinearElasticSpec {
                density,
                youngs_modulus,
                poissons_ratio,
                strain_measure,
            }));
            for softening in [None, Some(softening)] {
                let dilatancy_decay = if softening.is_some() { 2.0 } else { 0.0 };
                let (friction_angle, cohesion, dilatancy_angle) = (30.0, 10e3, 10.0);
                all.push(Self::MohrCoulomb(MohrCoulombSpec {
                    density,
                    youngs_modulus,
                    poissons_ratio,
                    friction_angle,
                    cohesion,
                    dilatancy_angle,
                    softening,
                    dilatancy_decay,
                    strain_measure,
                }));
                let matchings = [
                    Matching::Compression,
                    Matching::Extension,
                    Matching::PlaneStrain,
                    Matching::PlaneStrainAssociated,
                ];
                all.extend(matchings.map(|matching| {
                    Self::DruckerPrager(DruckerPragerSpec {
                        density,
                        youngs_modulus,
                        poissons_ratio,
                        friction_angle,
                        cohesion,
                        dilatancy_angle,
                        matching,
                        softening,
                        dilatancy_decay,
                        strain_measure,
                    })
                }));
            }
        }
        all
    }
}
