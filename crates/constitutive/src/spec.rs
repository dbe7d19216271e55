//! Materials as a case file gives them: the one list of models.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::laws::{
    DoubleScaleSpec, DruckerPragerSpec, HypoplasticSpec, LinearElasticSpec, Matching, MohrCoulombSpec,
    NeoHookeanSpec, NewtonianFluidSpec,
};
use crate::model::{Facts, Kind, Model};
use crate::{Material, MaterialError};

/// The enum of all models and what is asked of each of them.
macro_rules! models {
    ($($(#[$doc:meta])* $name:literal => $variant:ident($spec:ty),)*) => {
        /// A material of a case file: the model's name and its parameters, angles in degrees.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(tag = "model")]
        pub enum MaterialSpec {
            $($(#[$doc])* #[serde(rename = $name)] $variant($spec),)*
        }

        impl MaterialSpec {
            /// Name and facts of every model, in the order of the list.
            pub const MODELS: &'static [(&'static str, Facts)] = &[$(($name, <$spec as Model>::FACTS),)*];

            /// Name of the model.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$variant(_) => $name,)* }
            }

            /// What a reader should know about the model.
            pub fn facts(&self) -> Facts {
                match self { $(Self::$variant(_) => <$spec as Model>::FACTS,)* }
            }

            /// Initial density (kg/m³).
            pub fn density(&self) -> f64 {
                match self { $(Self::$variant(spec) => spec.density(),)* }
            }

            /// The law, parameters checked and angles converted.
            ///
            /// # Errors
            /// The first parameter out of range.
            pub fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
                crate::model::positive("density", self.density(), "kg/m³")?;
                match self { $(Self::$variant(spec) => spec.build(),)* }
            }

            /// What is allowed but worth a word, each starting with the parameter's name.
            pub fn warnings(&self) -> Vec<String> {
                match self { $(Self::$variant(spec) => spec.warnings(),)* }
            }

            /// A sample of every model and every way to run it: what the contract tests run over.
            pub fn examples() -> Vec<Self> {
                let mut all = Vec::new();
                $(all.extend(<$spec as Model>::examples().into_iter().map(Self::$variant));)*
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
    /// Drucker–Prager plasticity.
    "drucker-prager" => DruckerPrager(DruckerPragerSpec),
    /// Mohr–Coulomb plasticity.
    "mohr-coulomb" => MohrCoulomb(MohrCoulombSpec),
    /// Hypoplasticity with critical state, and an acceleration-based viscous part.
    "hypoplastic" => Hypoplastic(HypoplasticSpec),
    /// An elastic point that a cohesive–frictional band may cut.
    "double-scale" => DoubleScale(DoubleScaleSpec),
    /// Weakly compressible Newtonian fluid.
    "newtonian-fluid" => NewtonianFluid(NewtonianFluidSpec),
}

impl MaterialSpec {
    /// True for parameters that mean something in plane strain only.
    pub fn assumes_plane_strain(&self) -> bool {
        let planar = [Matching::PlaneStrain, Matching::PlaneStrainAssociated];
        matches!(self, Self::DruckerPrager(spec) if planar.contains(&spec.matching))
    }

    /// True for laws that forget shear: at rest they carry none, or no more than their yield stress.
    pub fn is_fluid(&self) -> bool {
        self.facts().kind == Kind::Fluid
    }
}
