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
    /// Points from a file, in place of those that a method sets in the shape. The shape still defines the region of the body for
    /// overlaps, weights, and loaded faces. All points must be in it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<PointFile>,
    /// Arrangement of the points that a method sets in the shape. Grains (dem) and methods over the plan have their own arrangements.
    #[serde(default, skip_serializing_if = "Sampling::is_lattice")]
    pub sampling: Sampling,
    /// Seed of the positions of `poisson-disk`: another number gives other positions.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub sampling_seed: u64,
    /// Name of the material of the body.
    pub material: String,
    /// Initial velocity (m/s); at rest by default. For a rigid body it is `uniform`, or `linear` with a rotation, where the motion of the
    /// first stage leaves it free.
    #[serde(default)]
    pub velocity: Velocity,
    /// Initial stress (Pa, tension-positive); stress-free by default.
    #[serde(default)]
    pub stress: InitialStress,
    /// Whether the body is rigid: it keeps its shape and moves as the `motions` of the stages prescribe, or is at rest where they have
    /// none. It moves at a prescribed velocity, or under its weight, a force and contact forces. Material in contact sticks to it, unless
    /// the options of the method say otherwise. Of its material only the density is used.
    #[serde(default)]
    pub rigid: bool,
    /// Fluid in the pores that moves independently (coupled two-phase analysis); none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pore_fluid: Option<PoreFluid>,
    /// Whether points of the body that leave the domain are removed with their mass, momentum and energy, as through an outlet. Otherwise
    /// a point that leaves ends the run.
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
    /// Formula of the coordinates for each component (m/s).
    Formula {
        /// Components, as many as the space has dimensions.
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
    /// Uniform stress (Pa, tension-positive): xx yy zz xy yz zx.
    Uniform {
        /// Stress components.
        value: [f64; 6],
    },
    /// Formula of the coordinates for each component (Pa, tension-positive): xx yy zz xy yz zx.
    Formula {
        /// Stress components.
        value: Box<[Formula; 6]>,
    },
    /// Stress from the weight of the material above along gravity, and a ratio of horizontal to vertical stress. All bodies above the
    /// point count, up to `surface`, each with its own density (with a pore fluid the saturated one). Rigid bodies have no weight. Empty
    /// space has none either, unless it lies below the surface of a hydrostatic pore fluid of the body: it is then open water, which a
    /// case applies to the ground as a `pressure` and a `pore-pressure`. Pore pressure is subtracted, and that of an `undrained` material
    /// is added again to its initial total stress. The stress is in equilibrium under level ground in level layers. Where the weight
    /// above differs at the same height, give the first stage an `equilibrium`. A state outside the yield surface of the material is
    /// refused, unless the material has `return_initial_stress_to_yield`.
    K0 {
        /// Coordinate along the axis of gravity (m) up to which bodies count: the top of the ground.
        surface: f64,
        /// Ratio of horizontal to vertical effective stress.
        coefficient: f64,
    },
}
