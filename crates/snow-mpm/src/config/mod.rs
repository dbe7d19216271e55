//! Options of `methods.snow-mpm`.

mod checks;
mod choices;

pub use choices::{DeformationUpdate, SnowTransfer, SplineShape};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Name of the method.
pub const NAME: &str = "snow-mpm";

/// Options of the finite-strain material point method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SnowOptions {
    /// Edge of the square (cubic) grid cells (m); the domain must be a whole number of cells wide.
    pub cell_size: f64,
    /// Points per cell and direction.
    #[serde(default = "default_points_per_cell")]
    pub points_per_cell: usize,
    /// Shape functions.
    #[serde(default)]
    pub shape: SplineShape,
    /// How velocities pass from the grid to the points and back.
    #[serde(default)]
    pub transfer: SnowTransfer,
    /// With `transfer` `flip`: share of FLIP in the velocity update, 0 to 1, 0.99 when absent; the rest is PIC. The share
    /// counts in each step: shorter steps damp more, and results do not converge as steps shrink. Use `blend_time` for a share that
    /// follows the step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flip_ratio: Option<f64>,
    /// With `transfer` `flip`, in place of `flip_ratio`: time (s) over which PIC takes over; the share of PIC in a step is the
    /// step over this time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blend_time: Option<f64>,
    /// How the deformation of a step follows from the velocity gradient.
    #[serde(default)]
    pub deformation: DeformationUpdate,
    /// Step over cell size / (wave speed + speed) of the fastest point, 0 to 1 (0 excluded).
    #[serde(default = "courant_elastic")]
    pub courant_elastic: f64,
    /// Step over cell size / speed of the fastest point, 0 to 1 (0 excluded).
    #[serde(default = "courant_velocity")]
    pub courant_velocity: f64,
    /// Fixed time step (s), which must be below the critical one, and stops the run when it is not any more; chosen in each step
    /// by the solver when absent. Before an output steps are shorter, so that they end at its time.
    #[serde(default)]
    pub time_step: Option<f64>,
    /// Nodes lighter than this share of the mean mass of a point get no force and move with the points around them.
    #[serde(default = "mass_cutoff")]
    pub node_mass_cutoff: f64,
}

impl SnowOptions {
    /// Share of FLIP in a step of `dt` (s).
    pub(crate) fn flip_share(&self, dt: f64) -> f64 {
        match (self.transfer, self.blend_time) {
            (SnowTransfer::Apic, _) => 0.0,
            (SnowTransfer::Flip, Some(time)) => (1.0 - dt / time).max(0.0),
            (SnowTransfer::Flip, None) => self.flip_ratio.unwrap_or(FLIP_RATIO),
        }
    }
}

/// Sheet: snow-mpm §3.5.
const FLIP_RATIO: f64 = 0.99;

fn default_points_per_cell() -> usize {
    2
}
/// Sheet: snow-mpm §3.4.
fn courant_elastic() -> f64 {
    0.4
}
/// Sheet: snow-mpm §3.4.
fn courant_velocity() -> f64 {
    0.5
}
/// Sheet: snow-mpm §3.5.
fn mass_cutoff() -> f64 {
    1e-14
}
