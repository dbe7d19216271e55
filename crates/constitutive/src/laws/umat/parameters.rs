//! Parameters of `umat`.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of `umat`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UmatSpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Shared library (.so, .dylib, .dll), relative to the working directory.
    pub library: PathBuf,
    /// Routine name.
    #[serde(default = "default_symbol")]
    pub symbol: String,
    /// `CMNAME` (at most 80 bytes), for several materials.
    #[serde(default)]
    pub material_name: String,
    /// `PROPS`, in library units.
    #[serde(default)]
    pub props: Vec<f64>,
    /// Initial `STATEV`, all that the library needs.
    #[serde(default)]
    pub state_variables: Vec<f64>,
    /// Stress unit of the library (Pa), as 1000 for kPa; when absent 1, or that of incrementalDriver files.
    #[serde(default)]
    pub pascals: Option<f64>,
    /// P-wave modulus of the time step (Pa), positive; from the library when absent.
    #[serde(default)]
    pub wave_modulus: Option<f64>,
    /// Whether threads may call the library simultaneously.
    #[serde(default)]
    pub thread_safe: bool,
}

/// Default name of the routine in the library.
fn default_symbol() -> String {
    "umat_".to_owned()
}

impl UmatSpec {
    /// Parameters from density (kg/m³) and library; all others have the defaults of a case file.
    #[must_use]
    pub fn new(density: f64, library: impl Into<PathBuf>) -> Self {
        Self {
            density,
            library: library.into(),
            symbol: default_symbol(),
            material_name: String::new(),
            props: Vec::new(),
            state_variables: Vec::new(),
            pascals: None,
            wave_modulus: None,
            thread_safe: false,
        }
    }

    /// Unit of stress of the library (Pa).
    pub(super) fn unit(&self) -> f64 {
        self.pascals.unwrap_or(1.0)
    }
}
