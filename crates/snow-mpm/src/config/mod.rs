//! Options of `methods.snow-mpm`.

mod checks;
mod choices;

pub use choices::{DeformationUpdate, SnowTransfer, SplineShape};
use colluvium_case::MethodOptions;
use colluvium_constitutive::with_defaults;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Name of the method.
pub const NAME: &str = "snow-mpm";

/// Options of the finite-strain material point method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SnowOptions {
    /// Edge of the square (cubic) grid cells (m). Domains are a whole number of cells wide.
    pub cell_size: f64,
    /// Points per cell and direction.
    #[serde(default = "default_points_per_cell")]
    pub points_per_cell: usize,
    /// Shape functions.
    #[serde(default)]
    pub shape: SplineShape,
    /// Transfer of velocities between points and grid.
    #[serde(default)]
    pub transfer: SnowTransfer,
    /// FLIP fraction per step, 0 to 1, with `transfer` `flip`; 0.99 when absent, the rest is PIC. Shorter steps damp more, and results do
    /// not converge as steps shrink; with `blend_time` it follows the step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flip_ratio: Option<f64>,
    /// Time (s) from FLIP to PIC, with `transfer` `flip`, in place of `flip_ratio`: the PIC fraction is the step over this time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blend_time: Option<f64>,
    /// Deformation of a step.
    #[serde(default)]
    pub deformation: DeformationUpdate,
    /// Courant number of elastic waves, 0 to 1 (0 excluded): step over cell size / (wave speed + speed) of the fastest point.
    #[serde(default = "courant_elastic")]
    pub courant_elastic: f64,
    /// Courant number of motion, 0 to 1 (0 excluded): step over cell size / speed of the fastest point.
    #[serde(default = "courant_velocity")]
    pub courant_velocity: f64,
    /// Fixed time step (s), below the critical step, or the run stops; the solver's when absent. Steps before outputs are shorter.
    #[serde(default)]
    pub time_step: Option<f64>,
    /// Mass of a node over the mean point mass below which it has no force and moves with surrounding points.
    #[serde(default = "mass_cutoff")]
    pub node_mass_cutoff: f64,
}

impl MethodOptions for SnowOptions {
    const METHOD: &'static str = NAME;
    const REQUIRED: &'static [&'static str] = &["cell_size"];

    fn default_options(&self) -> Self {
        Self::new(self.cell_size)
    }
}

impl SnowOptions {
    /// Options with a cell size (m) and the defaults of a case file.
    #[must_use]
    pub fn new(cell_size: f64) -> Self {
        with_defaults(&[("cell_size", cell_size)])
    }

    /// FLIP fraction of a step of `dt` (s).
    pub(crate) fn flip_share(&self, dt: f64) -> f64 {
        match (self.transfer, self.blend_time) {
            (SnowTransfer::Apic, _) => 0.0,
            (SnowTransfer::Flip, Some(time)) => (1.0 - dt / time).max(0.0),
            (SnowTransfer::Flip, None) => self.flip_ratio.unwrap_or(FLIP_RATIO),
        }
    }
}

/// Default value (sheet: snow-mpm §3.5).
const FLIP_RATIO: f64 = 0.99;

/// Default number of points per cell along each axis.
fn default_points_per_cell() -> usize {
    2
}
/// Default value (sheet: snow-mpm §3.4).
fn courant_elastic() -> f64 {
    0.4
}
/// Default value (sheet: snow-mpm §3.4).
fn courant_velocity() -> f64 {
    0.5
}
/// Default value (sheet: snow-mpm §3.5).
fn mass_cutoff() -> f64 {
    1e-14
}
