//! Bodies with their initial velocity and stress.

use colluvium_points::{Sampling, Shape};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::description::formula::Formula;

mod point_file;
mod pore_fluid;

pub use point_file::PointFile;
pub use pore_fluid::{PoreFluid, PorePressure};

/// Points per direction in the search for overlaps of bodies.
pub(crate) const OVERLAP_RESOLUTION: usize = 24;

/// Region filled with one material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Name of the body.
    pub name: String,
    /// Region of the body.
    pub shape: Shape,
    /// Points from a file in place of those of the method. All must lie in the shape, which still defines overlaps, weights and loaded
    /// faces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<PointFile>,
    /// Arrangement of the points. Grains (dem) and methods over the plan have their own.
    #[serde(default, skip_serializing_if = "Sampling::is_lattice")]
    pub sampling: Sampling,
    /// Seed of the positions of `poisson-disk`.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub sampling_seed: u64,
    /// Name of its material.
    pub material: String,
    /// Initial velocity (m/s); at rest by default. For a rigid body `uniform`, or `linear` with a rotation, if the first stage leaves it
    /// free.
    #[serde(default)]
    pub velocity: Velocity,
    /// Initial stress; none by default.
    #[serde(default)]
    pub stress: InitialStress,
    /// Whether the body is rigid: at rest, or moved by `stages[].motions`. Material in contact sticks to it unless an option of the method
    /// says otherwise. Only the density of its material is used.
    #[serde(default)]
    pub rigid: bool,
    /// Pore fluid that moves independently (two-phase analysis).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pore_fluid: Option<PoreFluid>,
    /// Whether points that leave the domain are removed, with mass, momentum and energy; otherwise they end the run.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub remove_outside: bool,
}

/// Whether a number is zero, its default, so that a written case leaves it out.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde requires a reference")]
fn is_zero(value: &u64) -> bool {
    *value == 0
}

/// Initial velocity field (m/s).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Velocity {
    /// At rest.
    #[default]
    Rest,
    /// Uniform velocity.
    Uniform {
        /// Velocity (m/s).
        value: Vec<f64>,
    },
    /// `v = value + gradient (x - origin)`.
    Linear {
        /// Velocity at the origin (m/s).
        value: Vec<f64>,
        /// Point at which the velocity is `value` (m).
        origin: Vec<f64>,
        /// Velocity gradient `∂v_i/∂x_j` (1/s), row by row.
        gradient: Vec<Vec<f64>>,
    },
    /// `v = amplitude sin(wave_vector · x + phase)`.
    Sine {
        /// Amplitude (m/s).
        amplitude: Vec<f64>,
        /// Wave vector (rad/m).
        wave_vector: Vec<f64>,
        /// Phase (degrees).
        #[serde(default)]
        phase: f64,
    },
    /// Formula of the coordinates for each component.
    Formula {
        /// Components, one per space dimension.
        value: Vec<Formula>,
    },
    /// First mode of a slender cantilever, at rest behind its clamp.
    Bending {
        /// Axis of the beam: 0 is x.
        along: usize,
        /// Axis of the deflection.
        across: usize,
        /// Coordinate of the clamp along the beam (m).
        clamp: f64,
        /// Length of the beam (m).
        length: f64,
        /// Velocity of the tip (m/s).
        tip: f64,
    },
}

/// Initial stress field (Pa, tension-positive).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum InitialStress {
    /// Stress-free.
    #[default]
    None,
    /// Uniform stress: xx yy zz xy yz zx.
    Uniform {
        /// Stress components.
        value: [f64; 6],
    },
    /// Formula of the coordinates for each component: xx yy zz xy yz zx.
    Formula {
        /// Stress components.
        value: Box<[Formula; 6]>,
    },
    /// Stress from the weight of the material above, and a ratio of horizontal to vertical stress. Bodies up to `surface` count with their
    /// density (saturated with a pore fluid), but not rigid ones and empty space. Empty space below the surface of the body's hydrostatic
    /// pore fluid counts as open water, which the case also applies as `pressure` and `pore-pressure`. Pore pressure is subtracted; that of
    /// an `undrained` material is added again. The stress is in equilibrium under level ground in level layers; elsewhere give the first
    /// stage an `equilibrium`. A state outside yield is refused without `return_initial_stress_to_yield`.
    K0 {
        /// Coordinate of the ground surface along gravity (m), up to which bodies count.
        surface: f64,
        /// Ratio of horizontal to vertical effective stress.
        coefficient: f64,
    },
}
