//! Materials of a case file: the list of all models.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Warning;
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::laws::*;
use crate::{Material, MaterialError};

/// Initial density from a model's parameters: their field `density`, or the expression of the list.
macro_rules! density {
    ($spec:ident) => {
        $spec.density
    };
    ($spec:ident, $($place:tt)+) => {
        $spec.$($place)+
    };
}

/// Enum of all models and the calls of each. Where parameters have no field `density` of their own, the list
/// gives the expression.
macro_rules! models {
    ($($(#[$doc:meta])* $name:literal => $variant:ident($spec:ty $(, $($density:tt)+)?),)*) => {
        /// Material: the name of the model and its parameters.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(tag = "model")]
        pub enum MaterialSpec {
            $($(#[$doc])* #[serde(rename = $name)] $variant($spec),)*
        }

        $(impl From<$spec> for MaterialSpec {
            fn from(spec: $spec) -> Self {
                Self::$variant(spec)
            }
        })*

        impl MaterialSpec {
            /// Name and information of every model, in the order of the list.
            pub const MODELS: &'static [(&'static str, ModelInfo)] = &[$(($name, <$spec as Model>::INFO),)*];

            /// Name of the model.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$variant(_) => $name,)* }
            }

            /// Name, source and properties of the model.
            pub fn model_info(&self) -> ModelInfo {
                match self { $(Self::$variant(_) => <$spec as Model>::INFO,)* }
            }

            /// Initial density (kg/m³).
            pub fn density(&self) -> f64 {
                match self { $(Self::$variant(spec) => density!(spec $(, $($density)+)?),)* }
            }

            /// Builds the law, with parameters checked and angles converted.
            ///
            /// # Errors
            /// The first parameter out of range.
            pub fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
                self.check_depth()?;
                let density = match self.inner() {
                    None => crate::contract::parameter_checks::positive("density", self.density(), "kg/m³"),
                    Some(_) => Ok(()),
                };
                let law = || match self { $(Self::$variant(spec) => spec.build(),)* };
                density.and_then(|()| law()).map_err(|error| error.with_model(self.name()))
            }

            /// Warnings about valid but unusual parameter values, each with the name of the parameter.
            pub fn warnings(&self) -> Vec<Warning> {
                match self { $(Self::$variant(spec) => spec.warnings(),)* }
            }

            /// Inner material, for models that modify another one.
            pub fn inner(&self) -> Option<&MaterialSpec> {
                match self { $(Self::$variant(spec) => spec.inner(),)* }
            }

            /// Returns the material with reduced strength (sheet: constitutive §3.11).
            ///
            /// # Errors
            /// For models without a strength to reduce, and where the reduced peak falls below the residual.
            pub fn strength_reduced(&self, reduction: &StrengthReduction) -> Result<Self, MaterialError> {
                crate::contract::parameter_checks::positive("factor", reduction.factor, "")?;
                let none = || MaterialError::incompatible_options("model", format!("{} has no strength to reduce", self.name()));
                match self {
                    $(Self::$variant(spec) => {
                        let reduced = spec.strength_reduced(reduction).ok_or_else(none)?.map(Self::$variant);
                        reduced.map_err(|error| error.with_model(self.name()))
                    })*
                }
            }

            /// Example materials that include all variants of each model, for tests.
            pub fn examples() -> Vec<Self> {
                let mut all = Vec::new();
                $(if <$spec as Model>::INFO.kind != ModelFamily::Wrapper {
                    all.extend(<$spec as Model>::examples().into_iter().map(Self::$variant));
                })*
                all
            }

            /// Example materials of the models that modify another one.
            pub fn wrapped_examples() -> Vec<Self> {
                let mut all = Vec::new();
                $(if <$spec as Model>::INFO.kind == ModelFamily::Wrapper {
                    all.extend(<$spec as Model>::examples().into_iter().map(Self::$variant));
                })*
                all
            }
        }
    };
}

models! {
    /// Linear isotropic elasticity.
    "linear-elastic" => LinearElastic(LinearElasticSpec),
    /// Compressible neo-Hookean elasticity, finite strain.
    "neo-hookean" => NeoHookean(NeoHookeanSpec),
    /// St. Venant–Kirchhoff elasticity, finite strain.
    "st-venant-kirchhoff" => StVenantKirchhoff(StVenantKirchhoffSpec),
    /// Fixed-corotated elasticity, finite strain.
    "fixed-corotated" => FixedCorotated(FixedCorotatedSpec),
    /// Drucker–Prager plasticity.
    "drucker-prager" => DruckerPrager(DruckerPragerSpec),
    /// Sand without cohesion at finite strain (Klar); volume gained by separation is closed again.
    "sand" => Sand(SandSpec),
    /// Mohr–Coulomb plasticity.
    "mohr-coulomb" => MohrCoulomb(MohrCoulombSpec),
    /// Tresca plasticity.
    "tresca" => Tresca(TrescaSpec),
    /// Von Mises plasticity.
    "von-mises" => VonMises(VonMisesSpec),
    /// Isotropic elasticity with a stiffness that grows with pressure.
    "pressure-dependent-elastic" => PressureElastic(PressureElasticSpec),
    /// Modified Cam-clay.
    "modified-cam-clay" => CamClay(CamClaySpec),
    /// Original Cam-clay.
    "original-cam-clay" => OriginalCamClay(OriginalCamClaySpec, 0.density),
    /// Snow that breaks and compacts (Stomakhin), finite strain.
    "snow" => Snow(SnowSpec),
    /// Cohesive Cam Clay: snow slabs and weak layers, finite strain.
    "cohesive-cam-clay" => CohesiveCamClay(CohesiveCamClaySpec),
    /// Elasticity with a tension cut-off.
    "tension-cut" => TensionCut(TensionCutSpec),
    /// Undrained saturated soil around a skeleton in effective stresses.
    "undrained" => Undrained(UndrainedSpec, skeleton.density()),
    /// Stress-free shrinkage or swelling of another material.
    "eigenstrain" => Eigenstrain(EigenstrainSpec, material.density()),
    /// Another material with its strength divided by a factor.
    "strength-reduced" => StrengthReduced(StrengthReducedSpec, material.density()),
    /// Another material that loses cohesion by wetting.
    "saturation-softened" => SaturationSoftened(SaturationSoftenedSpec, material.density()),
    /// Hypoplasticity with critical state, and an acceleration-based viscous part.
    "hypoplastic" => Hypoplastic(HypoplasticSpec),
    /// Critical-state sand.
    "simsand" => Simsand(SimsandSpec),
    /// User material of Abaqus in a shared library.
    "umat" => Umat(UmatSpec),
    /// Elastic point with a possible cohesive–frictional band.
    "double-scale" => DoubleScale(DoubleScaleSpec),
    /// Weakly compressible Newtonian fluid.
    "newtonian-fluid" => NewtonianFluid(NewtonianFluidSpec),
    /// Fluid with a constant yield stress.
    "bingham" => Bingham(BinghamSpec),
    /// Fluid with a yield stress that grows with pressure.
    "frictional-fluid" => FrictionalFluid(FrictionalFluidSpec),
    /// Dense granular flow, μ(I) rheology.
    "mu-i" => MuI(MuISpec),
    /// Elastic–perfectly plastic soil with pressure from density.
    "cfd-soil" => CfdSoil(CfdSoilSpec),
    /// Law provided by a method, such as a periodic cell of grains.
    "external" => External(ExternalSpec),
}

/// Largest depth of nested materials.
const MAX_NESTING: usize = 8;

impl MaterialSpec {
    /// Requires at most [`MAX_NESTING`] nested materials.
    fn check_depth(&self) -> Result<(), MaterialError> {
        if std::iter::successors(Some(self), |spec| spec.inner()).nth(MAX_NESTING).is_none() {
            return Ok(());
        }
        let rule = format!("more than {MAX_NESTING} materials are nested");
        Err(MaterialError::incompatible_options("model", rule))
    }

    /// Parameters of the double-scale law, if the material is one or contains one.
    pub fn double_scale(&self) -> Option<&DoubleScaleSpec> {
        match self {
            Self::DoubleScale(spec) => Some(spec),
            _ => self.inner().and_then(Self::double_scale),
        }
    }

    /// Whether the parameters are meaningful in plane strain only.
    pub fn assumes_plane_strain(&self) -> bool {
        let planar = [Matching::PlaneStrain, Matching::PlaneStrainAssociated];
        if let Some(inner) = self.inner() {
            return inner.assumes_plane_strain();
        }
        matches!(self, Self::DruckerPrager(spec) if planar.contains(&spec.matching))
    }

    /// Whether the material is a fluid, with a shear stress at rest of at most its yield stress.
    pub fn is_fluid(&self) -> bool {
        self.inner().map_or(self.model_info().kind == ModelFamily::Fluid, Self::is_fluid)
    }
}
