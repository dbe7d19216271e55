//! External materials: a law that the program hands over ([`ExternalSpec::from_law`]), or one by name from a registered factory.

use std::fmt;
use std::panic::{RefUnwindSafe, UnwindSafe};
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

/// Registers a factory, whose law case files select by `{"model": "external", "law": …}`. A later factory replaces an earlier one of the
/// same name. Programs that describe their cases in Rust need no factory: see [`ExternalSpec::from_law`].
pub fn register_material(factory: &'static dyn MaterialFactory) {
    let mut known = FACTORIES.write().unwrap_or_else(PoisonError::into_inner);
    known.retain(|other| other.name() != factory.name());
    known.push(factory);
}

/// Law of the program in a case. Two are equal if they are the same law.
#[derive(Clone)]
pub struct ProgramLaw(pub Arc<dyn Material>);

// A law is only read, through a shared reference: a panic leaves it as it was.
impl UnwindSafe for ProgramLaw {}
impl RefUnwindSafe for ProgramLaw {}

impl PartialEq for ProgramLaw {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl fmt::Debug for ProgramLaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ProgramLaw({})", self.0.name())
    }
}

/// Parameters of `external`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExternalSpec {
    /// Density with pores (kg/m³), positive.
    pub density: f64,
    /// Law: `granular-cell`, a periodic cell of grains.
    pub law: String,
    /// Parameters; for `granular-cell` see docs/theory/dem.md, "A cell of grains as a material".
    #[serde(default)]
    pub parameters: Map<String, Value>,
    /// Law that the program has handed over; a case file cannot contain it.
    #[serde(skip)]
    #[schemars(skip)]
    pub program_law: Option<ProgramLaw>,
}

impl ExternalSpec {
    /// Material of a density (kg/m³) with a law of the program. A case file written from it names the law, and can only be read by a
    /// program that registers a factory of that name.
    #[must_use]
    pub fn from_law(name: impl Into<String>, density: f64, law: Arc<dyn Material>) -> Self {
        Self { program_law: Some(ProgramLaw(law)), ..Self::new(density, name) }
    }

    /// Parameters from density (kg/m³) and law; all others have the defaults of a case file.
    #[must_use]
    pub fn new(density: f64, law: impl Into<String>) -> Self {
        Self { density, law: law.into(), parameters: Map::new(), program_law: None }
    }
}

impl Model for ExternalSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "a method that provides it",
        kind: ModelFamily::Solid,
        strain: "the law's",
        tangent: "the law's",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        if let Some(ProgramLaw(law)) = &self.program_law {
            return Ok(Arc::clone(law));
        }
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
