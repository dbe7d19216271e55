//! What there is at the start: bodies with their velocity and stress.

use colluvium_points::{Sampling, Shape};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{PointFile, PoreFluid};
use crate::Formula;

/// A region filled with one material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Name.
    pub name: String,
    /// Where it is.
    pub shape: Shape,
    /// Points from a file in place of those that a method sets in the shape, which still says what the body covers: for overlaps,
    /// weights, and faces that bear loads. All points must be in it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<PointFile>,
    /// How the points lie that a method sets in the shape; grains (dem) and methods over the plan have ways of their own.
    #[serde(default, skip_serializing_if = "Sampling::is_lattice")]
    pub sampling: Sampling,
    /// What the places of `poisson-disk` follow from: another number, other places.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub sampling_seed: u64,
    /// Name of its material.
    pub material: String,
    /// Initial velocity; at rest by default. Of a rigid body `uniform`, or `linear` with a turn, where the motion of the first
    /// stage leaves it free.
    #[serde(default)]
    pub velocity: Velocity,
    /// Initial stress; stress-free by default.
    #[serde(default)]
    pub stress: InitialStress,
    /// Whether it keeps its shape and moves as the `motions` of the stages say, at rest where they say nothing: at a prescribed
    /// velocity, or as its weight, a force and what it touches make it. What it touches sticks to it, unless the method's
    /// options say otherwise; of its material only the density counts.
    #[serde(default)]
    pub rigid: bool,
    /// Fluid in its pores that moves by itself (coupled two-phase analysis); none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pore_fluid: Option<PoreFluid>,
    /// Whether points of it that leave the domain are taken away, with all that they carry, as through an outlet; else that
    /// ends the run.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub remove_outside: bool,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_zero(value: &u64) -> bool {
    *value == 0
}

/// An initial velocity field (m/s).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Velocity {
    /// At rest.
    #[default]
    Rest,
    /// The same everywhere.
    Uniform {
        /// Velocity (m/s).
        value: Vec<f64>,
    },
    /// `v = value + gradient (x - origin)`.
    Linear {
        /// Velocity at the origin (m/s).
        value: Vec<f64>,
        /// Where `value` holds (m).
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
    /// A formula of the coordinates for each component (m/s).
    Formula {
        /// Components, as many as the space has dimensions.
        value: Vec<Formula>,
    },
    /// The first mode of a slender cantilever, at rest behind its clamp.
    Bending {
        /// Axis of the beam: 0 is x.
        along: usize,
        /// Axis of its deflection.
        across: usize,
        /// Coordinate of the clamp along the beam (m).
        clamp: f64,
        /// Length of the beam (m).
        length: f64,
        /// Velocity of its tip (m/s).
        tip: f64,
    },
}

/// An initial stress field.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum InitialStress {
    /// Stress-free.
    #[default]
    None,
    /// The same everywhere (Pa, tension-positive): xx yy zz xy yz zx.
    Uniform {
        /// Stress components.
        value: [f64; 6],
    },
    /// A formula of the coordinates for each component (Pa, tension-positive): xx yy zz xy yz zx.
    Formula {
        /// Stress components.
        value: Box<[Formula; 6]>,
    },
    /// Weight of the material above along gravity, and a ratio of horizontal to vertical stress. All bodies count that lie
    /// above the point, up to `surface`, each with its own density (with a pore fluid the saturated one); what is rigid
    /// weighs nothing, and what is empty neither, unless it lies below the surface of a hydrostatic pore fluid of the body:
    /// that is open water, which a case puts on the ground as a `pressure` and a `pore-pressure`. Pore pressure is taken
    /// off, and that of an `undrained` material added again to the total stress with which it starts. The stress is in
    /// balance under level ground in level layers; where the weight above differs at the same height, let the first stage
    /// have an `equilibrium`. A state outside the yield surface of the material is refused, unless the material has
    /// `return_initial_stress_to_yield`.
    K0 {
        /// Coordinate along the axis of gravity (m) up to which bodies count: the top of the ground.
        surface: f64,
        /// Ratio of horizontal to vertical effective stress.
        coefficient: f64,
    },
}
