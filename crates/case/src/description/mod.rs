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
    /// Acceleration of gravity (m/s²), one number per space dimension; none when absent.
    #[serde(default)]
    pub gravity: Vec<f64>,
    /// Materials by name.
    #[serde(default)]
    pub materials: BTreeMap<String, MaterialSpec>,
    /// Bodies, which must not overlap; most methods need one.
    #[serde(default)]
    pub bodies: Vec<Body>,
    /// Walls; a side of the domain without a wall is open.
    #[serde(default)]
    pub boundaries: Vec<Boundary>,
    /// Rigid geometry of any shape in contact with bodies: slopes, terrain, blocks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<Obstacle>,
    /// Loads on bodies.
    #[serde(default)]
    pub loads: Vec<Load>,
    /// Regions in which the `motions` of the stages prescribe the velocity of the grid; for methods with a grid.
    #[serde(default)]
    pub patches: Vec<Patch>,
    /// Shapes that move through bodies and remove the points that they cover.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub removal_shapes: Vec<RemovalShape>,
    /// Stages, in the order in which they run.
    pub stages: Vec<Stage>,
    /// Output files and their times.
    #[serde(default)]
    pub output: Output,
    /// Quantities recorded in time, by name; the names of the standard columns are reserved.
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
    /// Lower corner (m), one number per space dimension.
    pub min: Vec<f64>,
    /// Upper corner (m).
    pub max: Vec<f64>,
    /// Reference point near the domain in map coordinates (m), for example of UTM. It is subtracted from all coordinates in the case and
    /// in the files that the case names, and added to the coordinates that a run writes. Energies, angular momentum and waves of an
    /// initial velocity refer to it. Zero when absent; cases far from zero need it, or digits are lost.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub origin: Vec<f64>,
    /// Axes along which the domain is periodic: points that leave on one side enter on the other.
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

/// Region in which the velocity of the nodes of the grid is prescribed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Patch {
    /// Name of the patch, for the `motions` of the stages: the patch is inactive in a stage without a motion for it.
    pub name: String,
    /// Region of the nodes at the start; nodes on its surface belong to it.
    pub region: Shape,
    /// Whether the region moves with its velocity, as a rigid plate does.
    #[serde(default)]
    pub moves: bool,
    /// Whether pore fluid passes, as through a porous plate; otherwise it has the prescribed velocity too.
    #[serde(default)]
    pub drained: bool,
}

/// Side of the domain box, or of an inner plane, that a wall occupies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Everything below a plane of constant x.
    XMin,
    /// Everything above a plane of constant x.
    XMax,
    /// Everything below a plane of constant y.
    YMin,
    /// Everything above a plane of constant y.
    YMax,
    /// Everything below a plane of constant z.
    ZMin,
    /// Everything above a plane of constant z.
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

/// Action of a wall on material in contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Wall {
    /// No slip: all components of velocity are those of the wall.
    Rough,
    /// Free slip: only the normal component of velocity is that of the wall.
    Smooth,
    /// Coulomb friction; the material may separate from the wall, unless the wall is `bilateral`.
    Frictional {
        /// Friction coefficient (-), the tangent of the friction angle of the interface.
        friction_coefficient: f64,
        /// Whether the wall constrains the normal velocity in both directions, as a smooth one does: it then also carries tension, under
        /// which there is no friction.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        bilateral: bool,
    },
    /// Absorbing boundary in place of a wall: dashpots that absorb arriving waves, as if the material continued (Lysmer and Kuhlemeyer).
    /// For small motions of bodies that reach the boundary; it carries no lasting stress.
    Absorbing {
        /// Factor (-) on the dashpot normal to the face, `ρ c_P`; at 1 plane waves that arrive at a right angle leave without reflection.
        #[serde(default = "default_fraction")]
        normal: f64,
        /// Factor (-) on the dashpots along the face, `ρ c_S`.
        #[serde(default = "default_fraction")]
        tangential: f64,
        /// Thickness of material (m) whose stiffness acts as a spring in parallel with the dashpots, against creep; none when absent.
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

/// Wall on a side of the domain, or on an inner plane parallel to one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Boundary {
    /// Name of the wall, for stages that remove it; the name of the side by default.
    #[serde(default)]
    pub name: Option<String>,
    /// Side that the wall occupies.
    pub side: Side,
    /// Name of a physical group of the mesh: the wall acts on its nodes instead of those on and beyond a plane, and `side` is only the
    /// direction that the wall faces. For methods with a mesh from a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Coordinate of the face of the wall (m); that side of the domain by default.
    #[serde(default)]
    pub position: Option<f64>,
    /// Action of the wall on material in contact.
    pub wall: Wall,
    /// Whether material may separate from rough and smooth walls, which otherwise prevent it. From frictional ones it always may, unless
    /// they are `bilateral`.
    #[serde(default)]
    pub separation: bool,
    /// Velocity of the wall (m/s); at rest by default.
    #[serde(default)]
    pub velocity: Option<Vec<f64>>,
    /// Whether pore fluid passes freely through the wall, at zero pressure; walls are impermeable otherwise, and a
    /// side of the domain or of a body without a wall is drained.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub drained: bool,
}

/// Part of the run with its own end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stage {
    /// Name of the stage.
    pub name: String,
    /// Longest duration (s). The stage ends here unless `equilibrium` ends it earlier. With `equilibrium` given, it is an error if the
    /// stage does not converge within this time.
    pub duration: f64,
    /// Local damping factor (-), 0 to 1: each nodal force is reduced by this fraction of its size against the motion. For quasi-static
    /// stages only.
    #[serde(default)]
    pub damping: f64,
    /// Axes along which `damping` acts (0 is x); all when absent.
    #[serde(default)]
    pub damping_axes: Option<Vec<usize>>,
    /// Mass-proportional factor of Rayleigh damping (1/s): a force against the motion of this factor times mass and velocity. A velocity
    /// under no other force decays as `exp(-factor × time)`, and one degree of freedom of angular frequency `ω` has the damping ratio
    /// `factor / (2 ω)`.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rayleigh_damping: f64,
    /// Time over which gravity grows linearly from zero (s).
    #[serde(default)]
    pub gravity_ramp: f64,
    /// Criterion that ends the stage early, at rest, once gravity, motions of the stage and all active loads have completed their ramps.
    #[serde(default)]
    pub equilibrium: Option<EquilibriumCriterion>,
    /// Motions of rigid bodies and patches.
    #[serde(default)]
    pub motions: Vec<PrescribedMotion>,
    /// Quantities that are reset at the end of the stage.
    #[serde(default)]
    pub reset: Vec<Reset>,
    /// Names of boundaries removed at the start of the stage, e.g. a gate.
    #[serde(default)]
    pub remove_boundaries: Vec<String>,
    /// Names of bodies removed at the start of the stage, e.g. an excavation.
    #[serde(default)]
    pub remove_bodies: Vec<String>,
    /// Regions whose material is removed at the start of the stage, of any body: an excavation in lifts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub excavate: Vec<Shape>,
    /// Strength reduction from the start of the stage until a later stage changes it, relative to the materials
    /// of the case.
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

/// Convergence criterion of a quasi-static stage (sheet: mpm §2.14).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EquilibriumCriterion {
    /// Upper bound of the unbalanced-force ratio (-).
    pub unbalanced_force: f64,
    /// Upper bound of kinetic energy over external work (-).
    pub kinetic_energy: f64,
    /// Number of consecutive checks that must be satisfied.
    pub hold: u32,
    /// Whether a stage whose duration ends before convergence is an error. Otherwise the run continues and reports its distance from
    /// rest.
    pub required: bool,
}

impl Default for EquilibriumCriterion {
    fn default() -> Self {
        Self { unbalanced_force: 1e-2, kinetic_energy: 1e-2, hold: 10, required: true }
    }
}

/// Quantity that a stage resets at its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Reset {
    /// Velocities, set to zero.
    Velocity,
    /// Displacements, set to zero and counted from this time.
    Displacement,
    /// Internal variables (plastic strain, hardening), set to their initial values; stress is kept. The run stops where the law has no
    /// such state: stress beyond an initial cap or strength that has grown, a fluid that flows.
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
