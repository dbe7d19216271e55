//! What the list of models asks of each: its parameters as a case file gives them.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::laws::StrengthReduction;
use crate::{Corotational, Hencky, Material, MaterialError, MaterialSpec, PrincipalReturn, SmallStrain};

/// Parameters of one model as a case file gives them, angles in degrees.
pub trait Model: Sized {
    /// What a reader of the table of models should know.
    const INFO: ModelInfo;

    /// The law, parameters checked and angles converted. Models around another write [`Model::wrap`] in its place.
    ///
    /// # Errors
    /// The first parameter out of range.
    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        let inner = self.inner().ok_or_else(|| MaterialError::choice("model", "is not implemented"))?;
        let law = inner.build().map_err(|error| error.under_key(Self::INNER))?;
        self.wrap(law)
    }

    /// The law around `inner`, the law of the material this one acts on, which is valid; for models around another.
    ///
    /// # Errors
    /// The first parameter out of range.
    fn wrap(&self, _inner: Arc<dyn Material>) -> Result<Arc<dyn Material>, MaterialError> {
        Err(MaterialError::choice("model", "acts on no other material"))
    }

    /// Key of the material this one acts on.
    const INNER: &'static str = "material";

    /// What is allowed but worth a word, each starting with the parameter's name.
    fn warnings(&self) -> Vec<String> {
        Vec::new()
    }

    /// The material this one acts on, for models around another.
    fn inner(&self) -> Option<&MaterialSpec> {
        None
    }

    /// The same model with reduced strength; `None` for models without a strength to reduce.
    fn strength_reduced(&self, _reduction: &StrengthReduction) -> Option<Result<Self, MaterialError>> {
        None
    }

    /// Samples of every way to run the model: what the contract tests run over.
    fn examples() -> Vec<Self>;
}

/// What a reader of the table of models should know about one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModelInfo {
    /// Where it comes from.
    pub source: &'static str,
    /// What it is for.
    pub kind: ModelFamily,
    /// How it measures strain.
    pub strain: &'static str,
    /// How it gets its consistent tangent.
    pub tangent: &'static str,
}

/// Families of models.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelFamily {
    /// Keeps shear stress at rest.
    Solid,
    /// Forgets shear: at rest it carries none, or no more than its yield stress.
    Fluid,
    /// Acts on another material.
    Wrapper,
}

/// How a law with linear elasticity measures strain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StrainMeasure {
    /// Small-strain increments in a co-rotating frame (Jaumann rate).
    #[default]
    Rate,
    /// Logarithmic (Hencky) strain of the elastic deformation: finite strain, path-independent elasticity.
    Hencky,
}

impl StrainMeasure {
    /// The law under this measure.
    pub(crate) fn wrap<L: SmallStrain + PrincipalReturn>(self, law: L) -> Arc<dyn Material> {
        match self {
            Self::Rate => Arc::new(Corotational(law)),
            Self::Hencky => Arc::new(Hencky(law)),
        }
    }
}

/// An error naming `field` unless `holds`.
pub(crate) fn check(field: &'static str, value: f64, holds: bool, rule: &str) -> Result<(), MaterialError> {
    if holds { Ok(()) } else { Err(MaterialError::parameter(field, value, rule)) }
}

/// `value` must be finite and positive; `unit` is named in the error.
pub(crate) fn positive(field: &'static str, value: f64, unit: &str) -> Result<(), MaterialError> {
    let rule =
        if unit.is_empty() { "must be positive".to_owned() } else { format!("must be positive ({unit})") };
    check(field, value, value.is_finite() && value > 0.0, &rule)
}

/// `value` must be finite and not negative; `unit` is named in the error.
pub(crate) fn not_negative(field: &'static str, value: f64, unit: &str) -> Result<(), MaterialError> {
    let rule = if unit.is_empty() {
        "must not be negative".to_owned()
    } else {
        format!("must not be negative ({unit})")
    };
    check(field, value, value.is_finite() && value >= 0.0, &rule)
}

/// `value` must lie between `low` and `high`, both allowed.
pub(crate) fn within_range(
    field: &'static str,
    value: f64,
    low: f64,
    high: f64,
) -> Result<(), MaterialError> {
    check(field, value, (low..=high).contains(&value), &format!("is not between {low} and {high}"))
}
