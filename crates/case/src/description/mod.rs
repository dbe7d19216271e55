//! Case files: plain data in SI units, angles in degrees (converted once, on load).

mod body;
mod constructors;
mod expression;
pub(crate) mod formula;
mod motion;
mod obstacle;
mod output;
pub(crate) mod properties;
mod removal_shape;
mod strength_reduction;
mod surface_loads;

use std::collections::BTreeMap;
use std::fmt;

use colluvium_constitutive::MaterialSpec;
use colluvium_points::Shape;

use crate::Measure;

pub use crate::description::removal_shape::{
    AxisBounds, RemovalAction, RemovalShape, SweptRegion, min_extent,
};
pub use crate::description::strength_reduction::{FactorOfSafety, Weakening};
pub(crate) use body::OVERLAP_RESOLUTION;
pub use body::{Body, InitialStress, PointFile, PoreFluid, PorePressure, Velocity};
pub use constructors::MethodOptions;
pub use motion::PrescribedMotion;
pub use obstacle::{
    Obstacle, ObstacleMotion, ObstacleRegion, ObstacleShape, ObstacleWall, ProfilePiece, RasterCellSelection,
};
pub use output::{Compression, Output, Rasters};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use surface_loads::{Load, LoadProfile, LoadTarget, RampShape};

/// Case: a problem to solve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Address of the JSON Schema, for editors; ignored.
    #[serde(rename = "$schema", default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// Title of the case, one line.
    pub title: String,
    /// Longer notes; ignored.
    #[serde(default)]
    pub notes: Vec<String>,
    /// Dimension and kinematics.
    pub space: Space,
    /// Box that contains the problem.
    pub domain: Domain,
    /// Gravity (m/s²), one number per dimension; none when absent.
    #[serde(default)]
    pub gravity: Vec<f64>,
    /// Materials by name.
    #[serde(default)]
    pub materials: BTreeMap<String, MaterialSpec>,
    /// Bodies; most methods need one.
    #[serde(default)]
    pub bodies: Vec<Body>,
    /// Walls.
    #[serde(default)]
    pub boundaries: Vec<Boundary>,
    /// Rigid geometry: slopes, terrain, blocks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<Obstacle>,
    /// Loads on bodies.
    #[serde(default)]
    pub loads: Vec<Load>,
    /// Regions of prescribed grid velocity; for methods with a grid.
    #[serde(default)]
    pub patches: Vec<Patch>,
    /// Moving shapes that remove points.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub removal_shapes: Vec<RemovalShape>,
    /// Stages, in their order.
    pub stages: Vec<Stage>,
    /// Output files and their times.
    #[serde(default)]
    pub output: Output,
    /// Quantities recorded in time; no names of standard columns.
    #[serde(default)]
    pub measures: BTreeMap<String, Measure>,
    /// Options per method; a method without an entry runs with its default options.
    #[serde(default)]
    pub methods: BTreeMap<String, serde_json::Value>,
}

/// Dimension and kinematics of the space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Space {
    /// One dimension, unit section, confined laterally (uniaxial strain).
    #[serde(rename = "1d")]
    OneD,
    /// Two dimensions, unit thickness, no strain across.
    #[serde(rename = "plane-strain")]
    PlaneStrain,
    /// Two dimensions (r, z), per radian; r is x, the axis is x = 0.
    #[serde(rename = "axisymmetric")]
    Axisymmetric,
    /// Three dimensions.
    #[serde(rename = "3d")]
    ThreeD,
}

impl Space {
    /// Number of coordinates.
    pub fn dimension(self) -> usize {
        match self {
            Self::OneD => 1,
            Self::PlaneStrain | Self::Axisymmetric => 2,
            Self::ThreeD => 3,
        }
    }
}

/// Axis-aligned box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// Lower corner (m), one number per dimension.
    pub min: Vec<f64>,
    /// Upper corner (m).
    pub max: Vec<f64>,
    /// Reference point near the domain in map coordinates (m), as of UTM; zero when absent. It is subtracted from coordinates in the case
    /// and its files, and added to those that a run writes. Energies, angular momentum and waves of an initial velocity refer to it. Cases
    /// far from zero lose digits without it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub origin: Vec<f64>,
    /// Periodic axes: points that leave on one side enter on the other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub periodic: Vec<Axis>,
}

/// Axis of the space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// First axis.
    X,
    /// Second axis.
    Y,
    /// Third axis.
    Z,
}

impl Axis {
    /// Number of the axis, from zero.
    pub fn number(self) -> usize {
        self as usize
    }
}

impl Domain {
    /// Whether the domain is periodic along an axis.
    pub fn is_periodic(&self, axis: usize) -> bool {
        self.periodic.iter().any(|periodic| periodic.number() == axis)
    }

    /// Size of the domain along its longest axis (m).
    pub fn max_extent(&self) -> f64 {
        self.min.iter().zip(&self.max).map(|(min, max)| max - min).fold(0.0, f64::max)
    }
}

/// Region with prescribed velocity of grid nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Patch {
    /// Name for `motions`; inactive in stages without one.
    pub name: String,
    /// Region of nodes at the start, with surface.
    pub region: Shape,
    /// Whether the region moves with its velocity.
    #[serde(default)]
    pub moves: bool,
    /// Whether pore fluid passes; otherwise its velocity is prescribed too.
    #[serde(default)]
    pub drained: bool,
}

/// Side of the domain, or of an inner plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Below a plane of constant x.
    XMin,
    /// Above a plane of constant x.
    XMax,
    /// Below a plane of constant y.
    YMin,
    /// Above a plane of constant y.
    YMax,
    /// Below a plane of constant z.
    ZMin,
    /// Above a plane of constant z.
    ZMax,
}

impl Side {
    /// Axis normal to the wall: 0, 1, 2.
    pub fn axis(self) -> usize {
        match self {
            Self::XMin | Self::XMax => 0,
            Self::YMin | Self::YMax => 1,
            Self::ZMin | Self::ZMax => 2,
        }
    }

    /// Whether it is an upper side.
    pub fn is_max(self) -> bool {
        matches!(self, Self::XMax | Self::YMax | Self::ZMax)
    }

    /// Name in a case file.
    pub fn name(self) -> &'static str {
        match self {
            Self::XMin => "x-min",
            Self::XMax => "x-max",
            Self::YMin => "y-min",
            Self::YMax => "y-max",
            Self::ZMin => "z-min",
            Self::ZMax => "z-max",
        }
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Action of a wall on material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Wall {
    /// No slip: velocity of the wall.
    Rough,
    /// Free slip: normal velocity of the wall.
    Smooth,
    /// Coulomb friction; the material may separate, unless it is `bilateral`.
    Frictional {
        /// Interface friction coefficient.
        friction_coefficient: f64,
        /// Whether the normal velocity is constrained in both directions, as by a smooth wall. Under tension there is no friction.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        bilateral: bool,
    },
    /// Dashpots in place of a wall that absorb arriving waves (Lysmer and Kuhlemeyer). For small motions of bodies that reach it; no
    /// lasting stress is carried.
    Absorbing {
        /// Factor on the normal dashpot, `ρ c_P`; 1 absorbs plane waves at a right angle.
        #[serde(default = "default_fraction")]
        normal: f64,
        /// Factor on the tangential dashpots, `ρ c_S`.
        #[serde(default = "default_fraction")]
        tangential: f64,
        /// Material thickness (m) that acts as a spring beside the dashpots, against creep; none when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        spring_length: Option<f64>,
    },
}

impl Wall {
    /// Whether material may separate from it, with or without `separation`.
    pub fn allows_separation(&self) -> bool {
        matches!(self, Self::Frictional { bilateral: false, .. })
    }

    /// Friction coefficient; infinite for a no-slip wall, zero without a wall.
    pub fn friction(&self) -> f64 {
        match *self {
            Self::Rough => f64::INFINITY,
            Self::Smooth | Self::Absorbing { .. } => 0.0,
            Self::Frictional { friction_coefficient, .. } => friction_coefficient,
        }
    }
}

/// Wall on a domain side, or on a parallel inner plane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Boundary {
    /// Name for stages that remove it; its side by default.
    #[serde(default)]
    pub name: Option<String>,
    /// Side of the wall.
    pub side: Side,
    /// Physical group of a mesh file, on whose nodes the wall acts; `side` is then only its facing direction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Face coordinate (m); the domain's side by default.
    #[serde(default)]
    pub position: Option<f64>,
    /// Action on material.
    pub wall: Wall,
    /// Whether material may separate from a rough or smooth wall. From a frictional one it may, unless `bilateral`.
    #[serde(default)]
    pub separation: bool,
    /// Velocity (m/s); at rest by default.
    #[serde(default)]
    pub velocity: Option<Vec<f64>>,
    /// Whether pore fluid passes at zero pressure; otherwise impermeable. Sides without a wall, also of bodies, are drained.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub drained: bool,
}

/// Part of the run with its own end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stage {
    /// Stage name.
    pub name: String,
    /// Longest duration (s); `equilibrium` may end the stage earlier.
    pub duration: f64,
    /// Local damping factor, 0 to 1, reducing nodal forces against the motion. For quasi-static stages only.
    #[serde(default)]
    pub damping: f64,
    /// Damped axes (0 is x); all when absent.
    #[serde(default)]
    pub damping_axes: Option<Vec<usize>>,
    /// Mass-proportional Rayleigh damping (1/s): a force against motion of this factor times mass and velocity. Its damping ratio is
    /// `factor / (2 ω)`.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rayleigh_damping: f64,
    /// Time of gravity's growth from zero (s).
    #[serde(default)]
    pub gravity_ramp: f64,
    /// Criterion that ends the stage early, after all ramps.
    #[serde(default)]
    pub equilibrium: Option<EquilibriumCriterion>,
    /// Motions of rigid bodies and patches.
    #[serde(default)]
    pub motions: Vec<PrescribedMotion>,
    /// Quantities reset at the stage's end.
    #[serde(default)]
    pub reset: Vec<Reset>,
    /// Boundaries removed at the start, as a gate.
    #[serde(default)]
    pub remove_boundaries: Vec<String>,
    /// Bodies removed at the start, as an excavation.
    #[serde(default)]
    pub remove_bodies: Vec<String>,
    /// Regions of any body removed at the start, as an excavation in lifts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub excavate: Vec<Shape>,
    /// Strength reduction of materials, until a later stage changes it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weakening: Option<Weakening>,
}

impl Stage {
    /// Factor on gravity after `elapsed` seconds of the stage, 0 to 1.
    pub fn gravity_factor(&self, elapsed: f64) -> f64 {
        if self.gravity_ramp > 0.0 { (elapsed / self.gravity_ramp).min(1.0) } else { 1.0 }
    }

    /// Prescribed motion of the rigid body or patch of that name.
    pub fn motion_of(&self, name: &str) -> Option<&PrescribedMotion> {
        self.motions.iter().find(|motion| motion.target == name)
    }

    /// Local damping factor of each axis.
    pub fn damping_of_axes(&self) -> [f64; 3] {
        let acts = |axis: &usize| self.damping_axes.as_ref().is_none_or(|axes| axes.contains(axis));
        std::array::from_fn(|axis| if acts(&axis) { self.damping } else { 0.0 })
    }
}

/// Convergence criterion (sheet: mpm §2.14).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EquilibriumCriterion {
    /// Largest unbalanced-force ratio.
    pub unbalanced_force: f64,
    /// Largest kinetic energy over external work.
    pub kinetic_energy: f64,
    /// Consecutive checks to satisfy.
    pub hold: u32,
    /// Whether a stage without convergence is an error; otherwise the run continues and reports its distance from rest.
    pub required: bool,
}

impl Default for EquilibriumCriterion {
    fn default() -> Self {
        Self { unbalanced_force: 1e-2, kinetic_energy: 1e-2, hold: 10, required: true }
    }
}

/// Quantity reset at a stage's end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Reset {
    /// Velocities, set to zero.
    Velocity,
    /// Displacements, counted from here.
    Displacement,
    /// Internal variables (plastic strain, hardening), set to initial values; stress is kept. The run stops if the law has no such state:
    /// stress beyond an initial cap or strength, a flowing fluid.
    State,
}

/// Default fraction: 1.
fn default_fraction() -> f64 {
    1.0
}

/// Whether a number is zero, its default, so that a written case leaves it out.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde requires a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
