//! Parameters of a representative cell of grains as a material.

use colluvium_constitutive::MaterialError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::config::{Diameters, Friction, NormalLaw, RollingSpec, TangentialSpec};

/// Parameters of the material model `granular-cell`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GranularCellSpec {
    /// Number of dimensions: 2 for disks, in plane strain; 3 for spheres.
    #[serde(default = "default_dimension")]
    pub dimension: usize,
    /// Approximate number of grains of a cell, 16 to 100000. The noise of the stress decreases with the square root of the number;
    /// computing time grows with it.
    #[serde(default = "default_grains")]
    pub grains: usize,
    /// Grain density (kg/m³), positive.
    pub grain_density: f64,
    /// Diameters of the grains.
    pub diameter: Diameters,
    /// Contact law of the grains.
    pub contact: CellContact,
    /// Preparation of the specimen.
    pub preparation: Preparation,
    /// Upper bound of the inertial number `γ̇ d √(ρ/p)` of the cell (-), 1e-6 to 0.1: smaller values need more steps of the grains for a
    /// strain.
    #[serde(default = "inertial_number")]
    pub inertial_number: f64,
    /// Local damping of grains (-), 0 up to 0.9.
    #[serde(default = "damping")]
    pub damping: f64,
    /// Noise level of the stress of a cell, as a share of the stress (-), 1e-6 to 0.1.
    #[serde(default = "tolerance")]
    pub tolerance: f64,
    /// Seed of the random draws of sizes and positions.
    #[serde(default)]
    pub seed: u64,
}

/// Contact law of the grains of a cell; see `methods.dem.pairs`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CellContact {
    /// Normal law, along the line of centres.
    pub normal: NormalLaw,
    /// Tangential law.
    #[serde(default)]
    pub tangential: TangentialSpec,
    /// Coulomb friction.
    pub friction: Friction,
    /// Rolling resistance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rolling: Option<RollingSpec>,
}

/// Preparation of a specimen by isotropic compression of a random packing (sheet: dem §3.8).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Preparation {
    /// Pressure of the compression (Pa), > 0. Points that start at less than a twentieth of it are unloaded by expansion.
    pub pressure: f64,
    /// Friction coefficient during compression (-). 0, the default, makes the specimen dense; that of the contacts makes it loose.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Porosity under the pressure (-), met within 0.002 by a search for the friction of the compression between 0 and 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub porosity: Option<f64>,
    /// Solid fraction of the initial random packing (-), 0.2 to 0.75: 0.7 for disks and 0.5 for spheres when absent.
    #[serde(default)]
    pub solid_fraction: Option<f64>,
}

impl CellContact {
    /// Contacts of a normal law and a friction, without rolling resistance.
    #[must_use]
    pub fn new(normal: NormalLaw, friction: Friction) -> Self {
        Self { normal, tangential: TangentialSpec::default(), friction, rolling: None }
    }
}

impl Preparation {
    /// Compression without friction to a pressure (Pa).
    #[must_use]
    pub fn new(pressure: f64) -> Self {
        Self { pressure, friction: None, porosity: None, solid_fraction: None }
    }
}

/// Default dimension of the cell: disks in the plane.
fn default_dimension() -> usize {
    2
}
/// Default number of grains of the cell.
fn default_grains() -> usize {
    200
}
/// Default inertial number of the deformation.
fn inertial_number() -> f64 {
    1e-3
}
/// Default value (sheet: dem §2.9).
fn damping() -> f64 {
    0.2
}
/// Default noise level of the stress, as a share of the stress (-).
fn tolerance() -> f64 {
    2e-3
}

/// Returns an error about a parameter of the cell.
pub fn parameter_error(field: &str, rule: impl Into<String>) -> MaterialError {
    MaterialError::IncompatibleOptions { model: "external", field: field.to_owned(), rule: rule.into() }
}

impl GranularCellSpec {
    /// Cell of disks of a density (kg/m³), with their diameters, contacts and preparation.
    #[must_use]
    pub fn new(
        grain_density: f64,
        diameter: Diameters,
        contact: CellContact,
        preparation: Preparation,
    ) -> Self {
        Self {
            dimension: default_dimension(),
            grains: default_grains(),
            grain_density,
            diameter,
            contact,
            preparation,
            inertial_number: inertial_number(),
            damping: damping(),
            tolerance: tolerance(),
            seed: 0,
        }
    }

    /// Checks the ranges; the discrete element method checks its own options when the cell is made.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn validate(&self) -> Result<(), MaterialError> {
        let within = |field: &str, value: f64, low: f64, high: f64| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            let (model, field, rule) =
                ("external", field.to_owned(), format!("is not between {low} and {high}"));
            Err(MaterialError::Parameter { model, field, value, rule })
        };
        if !(2..=3).contains(&self.dimension) {
            return Err(parameter_error(
                "dimension",
                format!("{} is neither 2 (disks) nor 3 (spheres)", self.dimension),
            ));
        }
        within("grains", self.grains as f64, 16.0, 1e5)?;
        within("inertial_number", self.inertial_number, 1e-6, 0.1)?;
        within("damping", self.damping, 0.0, 0.9)?;
        within("tolerance", self.tolerance, 1e-6, 0.1)?;
        within("preparation.pressure", self.preparation.pressure, f64::MIN_POSITIVE, 1e12)?;
        within("preparation.friction", self.preparation.friction.unwrap_or(0.0), 0.0, 10.0)?;
        if let Some(porosity) = self.preparation.porosity {
            within("preparation.porosity", porosity, 0.05, 0.8)?;
            if self.preparation.friction.is_some() {
                return Err(parameter_error(
                    "preparation.friction",
                    "is determined from porosity: leave it out",
                ));
            }
        }
        within("preparation.solid_fraction", self.solid_fraction(), 0.2, 0.75)
    }

    /// Solid fraction at which grains are placed in the cell; by default that of a loose packing.
    pub(crate) fn solid_fraction(&self) -> f64 {
        self.preparation.solid_fraction.unwrap_or(if self.dimension == 3 { 0.5 } else { 0.7 })
    }
}
