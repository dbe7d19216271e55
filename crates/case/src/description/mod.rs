//! What a case file says: plain data, SI units, angles in degrees (converted once, on load).

mod body;
mod motion;
mod obstacle;
mod output;
mod removal_shape;
mod strength_reduction;

use std::collections::BTreeMap;
use std::fmt;

use colluvium_constitutive::MaterialSpec;
use colluvium_points::Shape;

pub use crate::description::removal_shape::{
    AxisBounds, RemovalAction, RemovalShape, SweptRegion, min_extent,
};
pub use crate::description::strength_reduction::{FactorOfSafety, Weakening};
pub use body::{Body, InitialStress, Velocity};
pub use motion::PrescribedMotion;
pub use obstacle::{
    Obstacle, ObstacleMotion, ObstacleRegion, ObstacleShape, ObstacleWall, ProfilePiece, RasterCellSelection,
};
pub use output::{BreakageCriterion, Compression, CrackTip, Measure, Output, Rasters};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::bodies::point_file::PointFile;
pub use crate::loads::surface_loads::{Load, LoadProfile, LoadTarget, RampShape};
pub use crate::pore_fluid::{PoreFluid, PorePressure};

/// A problem.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Address of the JSON Schema, for editors; ignored.
    #[serde(rename = "$schema", default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// What the case is, in a line.
    pub title: String,
    /// Longer notes; ignored.
    #[serde(default)]
    pub notes: Vec<String>,
    /// Dimension and kinematics.
    pub space: Space,
    /// The box in which everything happens.
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
    /// Walls; a side of the domain without one is open.
    #[serde(default)]
    pub boundaries: Vec<Boundary>,
    /// Rigid geometry of any shape that bodies meet: slopes, terrain, blocks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<Obstacle>,
    /// Loads on bodies.
    #[serde(default)]
    pub loads: Vec<Load>,
    /// Regions in which the velocity of the grid is prescribed, by the `motions` of the stages; for methods with a grid.
    #[serde(default)]
    pub patches: Vec<Patch>,
    /// Shapes that move through bodies and take away what they cover.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub removal_shapes: Vec<RemovalShape>,
    /// Stages, run one after another.
    pub stages: Vec<Stage>,
    /// What is written.
    #[serde(default)]
    pub output: Output,
    /// Quantities to follow, by name; those of the columns that are there anyway are taken.
    #[serde(default)]
    pub measures: BTreeMap<String, Measure>,
    /// Options per method; a method without an entry runs with its defaults.
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

/// An axis-aligned box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// Lower corner (m), one number per space dimension.
    pub min: Vec<f64>,
    /// Upper corner (m).
    pub max: Vec<f64>,
    /// A place near the domain in the coordinates of the map (m), for example of UTM: taken off all coordinates in the case and in
    /// the files that it names, and put back on what a run writes. Energies, angular momentum and waves of an initial velocity
    /// are counted from it. Zero when absent; cases far from zero need it, or digits are lost.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub origin: Vec<f64>,
    /// Axes along which the domain repeats itself: what leaves on one side comes in on the other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub periodic: Vec<Axis>,
}

/// An axis of the space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

impl Axis {
    /// Its number, from zero.
    pub fn number(self) -> usize {
        self as usize
    }
}

impl Domain {
    /// Whether the domain repeats itself along an axis.
    pub fn is_periodic(&self, axis: usize) -> bool {
        self.periodic.iter().any(|periodic| periodic.number() == axis)
    }

    /// Its size along the longest axis (m).
    pub fn max_extent(&self) -> f64 {
        self.min.iter().zip(&self.max).map(|(min, max)| max - min).fold(0.0, f64::max)
    }
}

/// A region in which the velocity of the grid's nodes is prescribed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Patch {
    /// Name, for the `motions` of the stages: without one in a stage the patch does nothing.
    pub name: String,
    /// Where the nodes are at the start; those on its surface belong to it.
    pub region: Shape,
    /// Whether the region goes along with its velocity, as a rigid plate does.
    #[serde(default)]
    pub moves: bool,
    /// Whether pore fluid passes, as through a porous plate; else it has the prescribed velocity too.
    #[serde(default)]
    pub drained: bool,
}

/// The side of the box, or of an inner plane, that a wall occupies.
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

    /// True for the upper sides.
    pub fn is_max(self) -> bool {
        matches!(self, Self::XMax | Self::YMax | Self::ZMax)
    }

    /// Its name in a case file.
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

/// How a wall acts on what touches it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Wall {
    /// No slip: all components of velocity are the wall's.
    Rough,
    /// Free slip: only the normal component is the wall's.
    Smooth,
    /// Coulomb friction; the material may lift off, unless the wall is `bilateral`.
    Frictional {
        /// Coefficient of friction, tangent of the friction angle of the interface.
        friction_coefficient: f64,
        /// Whether the wall holds the normal velocity both ways, as a smooth one does: it also bears tension, under which
        /// there is no friction.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        bilateral: bool,
    },
    /// No wall: dashpots that take up the waves which arrive, as if the material went on (Lysmer and Kuhlemeyer).
    /// For small motions of bodies that reach to it; it carries no lasting stress.
    Absorbing {
        /// Factor on the dashpot normal to the face, `ρ c_P`; 1 lets plane waves out that arrive at a right angle.
        #[serde(default = "default_fraction")]
        normal: f64,
        /// Factor on the dashpots along the face, `ρ c_S`.
        #[serde(default = "default_fraction")]
        tangential: f64,
        /// Thickness of material whose stiffness acts as a spring beside the dashpots, against creep (m); none when
        /// absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        spring_length: Option<f64>,
    },
}

impl Wall {
    /// Whether material lifts off it by its nature, with or without `separation`.
    pub fn allows_separation(&self) -> bool {
        matches!(self, Self::Frictional { bilateral: false, .. })
    }

    /// Coefficient of friction; infinite where nothing slips, zero where there is no wall.
    pub fn friction(&self) -> f64 {
        match *self {
            Self::Rough => f64::INFINITY,
            Self::Smooth | Self::Absorbing { .. } => 0.0,
            Self::Frictional { friction_coefficient, .. } => friction_coefficient,
        }
    }
}

/// A wall on a side of the domain, or on an inner plane parallel to one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Boundary {
    /// Name, for stages that remove it; the side's name by default.
    #[serde(default)]
    pub name: Option<String>,
    /// The side it occupies.
    pub side: Side,
    /// Name of a physical group of the mesh, whose nodes the wall holds in place of those on and beyond a plane; `side`
    /// then says only which way the wall faces. For methods with a mesh from a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Coordinate of the wall's face (m); that side of the domain by default.
    #[serde(default)]
    pub position: Option<f64>,
    /// How it acts.
    pub wall: Wall,
    /// Whether material may lift off (rough and smooth walls hold it otherwise; from frictional ones it always may, unless
    /// they are `bilateral`).
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

/// A part of the run with an end of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stage {
    /// Name.
    pub name: String,
    /// Longest duration (s). The stage ends here unless `equilibrium` ends it before; with
    /// `equilibrium` given, not converging within it is an error.
    pub duration: f64,
    /// Local damping factor, 0 to 1: each nodal force is reduced by this fraction of its size
    /// against the motion. For quasi-static stages only.
    #[serde(default)]
    pub damping: f64,
    /// Axes along which `damping` acts (0 is x); all when absent.
    #[serde(default)]
    pub damping_axes: Option<Vec<usize>>,
    /// Rayleigh damping, its mass part (1/s): a force against the motion of this factor times mass and velocity, so that
    /// what nothing else acts on slows down as `exp(-factor × time)`, and one degree of freedom of angular frequency `ω`
    /// has the damping ratio `factor / (2 ω)`.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rayleigh_damping: f64,
    /// Time over which gravity grows linearly from zero (s).
    #[serde(default)]
    pub gravity_ramp: f64,
    /// Ends the stage early, at rest, once gravity and motions of the stage and all loads that act have grown over
    /// their ramps.
    #[serde(default)]
    pub equilibrium: Option<EquilibriumCriterion>,
    /// How rigid bodies and patches move.
    #[serde(default)]
    pub motions: Vec<PrescribedMotion>,
    /// What is set back at the end of the stage.
    #[serde(default)]
    pub reset: Vec<Reset>,
    /// Names of boundaries that vanish when the stage begins, e.g. a gate.
    #[serde(default)]
    pub remove_boundaries: Vec<String>,
    /// Names of bodies that vanish when the stage begins, e.g. an excavation.
    #[serde(default)]
    pub remove_bodies: Vec<String>,
    /// Regions whose material vanishes when the stage begins, of whatever body: an excavation in lifts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub excavate: Vec<Shape>,
    /// Strength that is lost when the stage begins, for good or until a later stage says otherwise: counted
    /// from what the materials are in the case.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weakening: Option<Weakening>,
}

impl Stage {
    /// Factor on gravity after `elapsed` seconds of the stage, 0 to 1.
    pub fn gravity_factor(&self, elapsed: f64) -> f64 {
        if self.gravity_ramp > 0.0 { (elapsed / self.gravity_ramp).min(1.0) } else { 1.0 }
    }

    /// How the rigid body or patch of that name moves.
    pub fn motion_of(&self, name: &str) -> Option<&PrescribedMotion> {
        self.motions.iter().find(|motion| motion.target == name)
    }

    /// Local damping factor of each axis.
    pub fn damping_of_axes(&self) -> [f64; 3] {
        let acts = |axis: &usize| self.damping_axes.as_ref().is_none_or(|axes| axes.contains(axis));
        std::array::from_fn(|axis| if acts(&axis) { self.damping } else { 0.0 })
    }
}

/// When a quasi-static stage has converged (sheet: mpm §2.14).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EquilibriumCriterion {
    /// Bound on the unbalanced-force ratio.
    pub unbalanced_force: f64,
    /// Bound on kinetic energy over external work.
    pub kinetic_energy: f64,
    /// Consecutive checks that must hold.
    pub hold: u32,
    /// Whether a stage whose duration ends before is an error. Otherwise the run goes on, and says how far from rest it was.
    pub required: bool,
}

impl Default for EquilibriumCriterion {
    fn default() -> Self {
        Self { unbalanced_force: 1e-2, kinetic_energy: 1e-2, hold: 10, required: true }
    }
}

/// What a stage sets back when it ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Reset {
    /// Velocities to zero.
    Velocity,
    /// Displacements to zero: counted from here on.
    Displacement,
    /// Internal variables (plastic strain, hardening) to their initial values; stress is kept. The run stops where the law
    /// has no such state: stress beyond an initial cap or strength that has grown, a fluid that flows.
    State,
}

fn default_fraction() -> f64 {
    1.0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
