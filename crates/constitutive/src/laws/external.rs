//! External materials: a method whose cells represent a material point registers a factory, and case files name it.

use std::sync::{Arc, PoisonError, RwLock};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::{Material, MaterialError};

/// Factory of materials defined outside this crate.
pub trait MaterialFactory: Send + Sync {
    /// Name of the law, the key `law` of a case file.
    fn name(&self) -> &'static str;

    /// Builds the law of a point with an initial density (kg/m³), from the parameters of a case file.
    ///
    /// # Errors
    /// The first parameter that is out of range or unknown, by its path within `parameters`.
    fn build(
        &self,
        density: f64,
        parameters: &Map<String, Value>,
    ) -> Result<Arc<dyn Material>, MaterialError>;
}

/// Factories of materials that other crates have registered.
static FACTORIES: RwLock<Vec<&'static dyn MaterialFactory>> = RwLock::new(Vec::new());

/// Registers a factory, whose law case files select by `{"model": "external", "law": …}`. Of two factories with one name the first is kept.
pub fn register_material(factory: &'static dyn MaterialFactory) {
    let mut known = FACTORIES.write().unwrap_or_else(PoisonError::into_inner);
    if known.iter().all(|other| other.name() != factory.name()) {
        known.push(factory);
    }
}

/// Parameters of `external`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExternalSpec {
    /// Density of the material with its pores (kg/m³), > 0.
    pub density: f64,
    /// Name of the law: `granular-cell`, a periodic cell of grains.
    pub law: String,
    /// Parameters of that law; for `granular-cell` see docs/theory/dem.md, "A cell of grains as a material".
    #[serde(default)]
    pub parameters: Map<String, Value>,
}

impl Model for ExternalSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "a method that provides it",
        kind: ModelFamily::Solid,
        strain: "the law's",
        tangent: "the law's",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        let known = FACTORIES.read().unwrap_or_else(PoisonError::into_inner);
        let Some(factory) = known.iter().find(|factory| factory.name() == self.law) else {
            let names: Vec<&str> = known.iter().map(|factory| factory.name()).collect();
            let rule =
                format!("the law {:?} is not available here; there is {}", self.law, name_list(&names));
            return Err(MaterialError::incompatible_options("law", rule));
        };
        factory.build(self.density, &self.parameters).map_err(|error| error.under_key("parameters"))
    }

    /// No samples: the laws depend on the registered factories.
    fn examples() -> Vec<Self> {
        Vec::new()
    }
}

/// Names separated by commas, or `none`.
fn name_list(names: &[&str]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}
