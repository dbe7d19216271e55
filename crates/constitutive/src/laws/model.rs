//! Interface of the models in the list: their parameters in a case file.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::de::value::MapDeserializer;
use serde::{Deserialize, Serialize};

use crate::Warning;
use crate::laws::StrengthReduction;
use crate::{Corotational, Hencky, Material, MaterialError, MaterialSpec, PrincipalReturn, SmallStrain};

/// Parameters of one model in a case file, angles in degrees.
pub trait Model: Sized {
    /// Information for the table of models.
    const INFO: ModelInfo;

    /// Builds the law, with parameters checked and angles converted. Models around another implement [`Model::wrap_material`] instead.
    ///
    /// # Errors
    /// The first parameter out of range.
    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        let inner =
            self.inner().ok_or_else(|| MaterialError::incompatible_options("model", "is not implemented"))?;
        let law = inner.build().map_err(|error| error.under_key(Self::INNER_KEY))?;
        self.wrap_material(law)
    }

    /// Wraps the law `inner` of the inner material, for models that modify another one.
    ///
    /// # Errors
    /// The first parameter out of range.
    fn wrap_material(&self, _inner: Arc<dyn Material>) -> Result<Arc<dyn Material>, MaterialError> {
        Err(MaterialError::incompatible_options("model", "acts on no other material"))
    }

    /// Key of the inner material.
    const INNER_KEY: &'static str = "material";

    /// Warnings about valid but unusual parameter values, each with the name of the parameter.
    fn warnings(&self) -> Vec<Warning> {
        Vec::new()
    }

    /// Inner material, for models that modify another one.
    fn inner(&self) -> Option<&MaterialSpec> {
        None
    }

    /// Returns the model with reduced strength; `None` for models without a strength to reduce.
    fn strength_reduced(&self, _reduction: &StrengthReduction) -> Option<Result<Self, MaterialError>> {
        None
    }

    /// Example parameters that include all variants of the model, for tests.
    fn examples() -> Vec<Self>;
}

/// Parameters of a model, or options of a method, from their required numbers by name; all others have the defaults of a case file.
///
/// # Panics
/// When a required value is not in the list.
pub fn with_defaults<T: DeserializeOwned>(required: &[(&'static str, f64)]) -> T {
    let numbers: MapDeserializer<'_, _, serde::de::value::Error> =
        MapDeserializer::new(required.iter().copied());
    T::deserialize(numbers).expect("the list names all required values")
}

/// Information on a model for the table of models.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModelInfo {
    /// Publication from which the model is taken.
    pub source: &'static str,
    /// Family of the model.
    pub kind: ModelFamily,
    /// Strain measure.
    pub strain: &'static str,
    /// Method of the consistent tangent.
    pub tangent: &'static str,
}

/// Families of models.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelFamily {
    /// Shear stress at rest is kept.
    Solid,
    /// Shear stress at rest is zero, or at most the yield stress.
    Fluid,
    /// Model that acts on another material.
    Wrapper,
}

/// Strain measure of linear elasticity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StrainMeasure {
    /// Small strain, co-rotating frame (Jaumann rate).
    #[default]
    Rate,
    /// Logarithmic (Hencky) elastic strain: finite, path-independent.
    Hencky,
}

impl StrainMeasure {
    /// Wraps the law with this strain measure.
    pub(crate) fn wrap<L: SmallStrain + PrincipalReturn>(self, law: L) -> Arc<dyn Material> {
        match self {
            Self::Rate => Arc::new(Corotational(law)),
            Self::Hencky => Arc::new(Hencky(law)),
        }
    }
}
