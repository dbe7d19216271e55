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

/// Region of one material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Body name.
    pub name: String,
    /// Region of the body.
    pub shape: Shape,
    /// Points from a file. All must lie in the shape, which still defines overlaps, weights and loaded faces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<PointFile>,
    /// Point arrangement. Grains (dem) and methods over the plan have their own.
    #[serde(default, skip_serializing_if = "Sampling::is_lattice")]
    pub sampling: Sampling,
    /// Seed of `poisson-disk` positions.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub sampling_seed: u64,
    /// Material name.
    pub material: String,
    /// Initial velocity (m/s). For rigid bodies `uniform`, or `linear` with rotation, if free in the first stage.
    #[serde(default)]
    pub velocity: Velocity,
    /// Initial stress.
    #[serde(default)]
    pub stress: InitialStress,
    /// Whether the body is rigid: at rest, or moved by `stages[].motions`. Touching material sticks unless a method option says otherwise.
    /// Only the density of its material is used.
    #[serde(default)]
    pub rigid: bool,
    /// Pore fluid that moves independently (two-phase).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pore_fluid: Option<PoreFluid>,
    /// Whether points leaving the domain are removed, with mass, momentum and energy, or end the run.
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
        /// Point where the velocity is `value` (m).
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
    /// Formula of each component.
    Formula {
        /// Components, one per space dimension.
        value: Vec<Formula>,
    },
    /// First mode of a slender cantilever, at rest behind the clamp.
    Bending {
        /// Beam axis: 0 is x.
        along: usize,
        /// Deflection axis.
        across: usize,
        /// Clamp coordinate along the beam (m).
        clamp: f64,
        /// Beam length (m).
        length: f64,
        /// Tip velocity (m/s).
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
    /// Uniform stress.
    Uniform {
        /// Components xx yy zz xy yz zx.
        value: [f64; 6],
    },
    /// Formula of each component.
    Formula {
        /// Components xx yy zz xy yz zx.
        value: Box<[Formula; 6]>,
    },
    /// Stress from the overburden and a ratio of horizontal to vertical stress. Bodies up to `surface` count with their density (saturated
    /// with a pore fluid), except rigid ones. Empty space below the surface of the body's hydrostatic pore fluid counts as open water,
    /// which the case also applies as `pressure` and `pore-pressure`. Pore pressure is subtracted; that of an `undrained` material is added
    /// again. The stress is in equilibrium under level ground in level layers; elsewhere give the first stage an `equilibrium`. States
    /// outside yield are refused without `return_initial_stress_to_yield`.
    K0 {
        /// Ground surface coordinate along gravity (m).
        surface: f64,
        /// Horizontal over vertical effective stress.
        coefficient: f64,
    },
}
