//! What a case file says: plain data, SI units, angles in degrees (converted once, on load).

mod strength;

use std::collections::BTreeMap;
use std::fmt;

use colluvium_constitutive::MaterialSpec;
use colluvium_points::Shape;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
pub use strength::{FactorOfSafety, Weakening};

pub use crate::point_list::PointFile;
pub use crate::pore_fluid::{PoreFluid, PorePressure};
pub use crate::surface::{Load, LoadCarrier, LoadProfile, RampShape};

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
    /// Acceleration of gravity (m/s²), one number per space dimension.
    pub gravity: Vec<f64>,
    /// Materials by name.
    pub materials: BTreeMap<String, MaterialSpec>,
    /// Bodies, which must not overlap.
    pub bodies: Vec<Body>,
    /// Walls; a side of the domain without one is open.
    #[serde(default)]
    pub boundaries: Vec<Boundary>,
    /// Loads on bodies.
    #[serde(default)]
    pub loads: Vec<Load>,
    /// Regions in which the velocity of the grid is prescribed, by the `motions` of the stages; for methods with a grid.
    #[serde(default)]
    pub patches: Vec<Patch>,
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
}

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
    /// Name of its material.
    pub material: String,
    /// Initial velocity; at rest by default.
    #[serde(default)]
    pub velocity: Velocity,
    /// Initial stress; stress-free by default.
    #[serde(default)]
    pub stress: InitialStress,
    /// Whether it keeps its shape and moves as the `motions` of the stages say, at rest where they say nothing. What
    /// it touches sticks to it, unless the method's options say otherwise; of its material only the density counts.
    #[serde(default)]
    pub rigid: bool,
    /// Fluid in its pores that moves by itself (coupled two-phase analysis); none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pore_fluid: Option<PoreFluid>,
    /// Whether points of it that leave the domain are taken away, with all that they carry, as through an outlet; else that
    /// ends the run.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub drop_outside: bool,
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

/// The prescribed motion of a rigid body or of a patch in a stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PrescribedMotion {
    /// Name of the rigid body or patch.
    pub of: String,
    /// Velocity (m/s), one number per space dimension; for a patch null leaves a component free.
    pub velocity: Vec<Option<f64>>,
    /// Time over which it grows from zero (s), counted from the beginning of the stage.
    #[serde(default)]
    pub ramp: f64,
}

impl PrescribedMotion {
    /// Velocity after `elapsed` seconds of the stage (m/s); `None` for a component that is free.
    pub fn velocity_at(&self, elapsed: f64) -> [Option<f64>; 3] {
        let factor = if self.ramp > 0.0 { (elapsed / self.ramp).clamp(0.0, 1.0) } else { 1.0 };
        std::array::from_fn(|c| self.velocity.get(c).copied().flatten().map(|v| factor * v))
    }
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
    /// Weight of the material above along gravity, and a ratio of horizontal to vertical stress. All bodies count that lie
    /// above the point, up to `surface`, each with its own density (with a pore fluid the saturated one); what is rigid
    /// weighs nothing, and what is empty neither, unless it lies below the surface of a hydrostatic pore fluid of the body:
    /// that is open water, which a case puts on the ground as a `pressure` and a `pore-pressure`. Pore pressure is taken
    /// off, and that of an `undrained` material added again to the total stress with which it starts. The stress is in
    /// balance under level ground in level layers; where the weight above differs at the same height, let the first stage
    /// have an `equilibrium`. A state outside the yield surface of the material is refused, unless the material has
    /// `project`.
    K0 {
        /// Coordinate along the axis of gravity (m) up to which bodies count: the top of the ground.
        surface: f64,
        /// Ratio of horizontal to vertical effective stress.
        coefficient: f64,
    },
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
        #[serde(default = "whole")]
        normal: f64,
        /// Factor on the dashpots along the face, `ρ c_S`.
        #[serde(default = "whole")]
        tangential: f64,
        /// Thickness of material whose stiffness acts as a spring beside the dashpots, against creep (m); none when
        /// absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        spring_length: Option<f64>,
    },
}

impl Wall {
    /// Whether material lifts off it by its nature, with or without `separation`.
    pub fn lets_go(&self) -> bool {
        matches!(self, Self::Frictional { bilateral: false, .. })
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
    /// Prescribed motions of rigid bodies and patches.
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

    /// Local damping factor of each axis.
    pub fn damping_of_axes(&self) -> [f64; 3] {
        let acts = |axis: &usize| self.damping_axes.as_ref().is_none_or(|axes| axes.contains(axis));
        std::array::from_fn(|axis| if acts(&axis) { self.damping } else { 0.0 })
    }
}

/// When a quasi-static stage has converged (MPM sheet §2.14).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EquilibriumCriterion {
    /// Bound on the unbalanced-force ratio.
    pub unbalanced_force: f64,
    /// Bound on kinetic energy over external work.
    pub kinetic_energy: f64,
    /// Consecutive checks that must hold.
    pub hold: u32,
}

impl Default for EquilibriumCriterion {
    fn default() -> Self {
        Self { unbalanced_force: 1e-2, kinetic_energy: 1e-2, hold: 10 }
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

/// What is written, and when.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Time between frames (s); none when absent, except the first and the last. Steps are shortened so that they end at
    /// the time of an output.
    pub frames: Option<f64>,
    /// Time between rows of the measures (s); a hundredth of the whole run when absent.
    pub measures: Option<f64>,
    /// Cell size (m) of a regular grid over the domain on which every frame is averaged as well: density in space, and averages
    /// of the fields weighted with mass, for iso-surfaces and volume rendering. It should be two points wide or more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<f64>,
    /// Wall-clock seconds between checkpoints.
    pub checkpoint: f64,
    /// Fields in the frames; all when absent. Identity, body and extent of each point are always there.
    pub fields: Option<Vec<String>>,
}

impl Default for Output {
    fn default() -> Self {
        Self { frames: None, measures: None, grid: None, checkpoint: 60.0, fields: None }
    }
}

/// A quantity to follow in time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Measure {
    /// Where the mass ends along an axis (m). The base is divided into columns of cells; those whose lowest
    /// cell holds a point, counted without a gap from the wall behind the mass, are the connected region, and
    /// the front is the farthest end of a point's domain in it. Points beyond a gap are detached and do not
    /// count. Where no column at the wall is occupied, counting begins at the rearmost that is; where nothing
    /// lies on the base, a column is occupied by points at any height. With a quantile below 1, the place
    /// behind which that fraction of the mass lies, which stray points do not move. Rigid bodies do not count, unless
    /// `bodies` names them.
    Front {
        /// Direction in which the front moves.
        side: Side,
        /// Fraction of the mass behind the front.
        #[serde(default = "whole")]
        quantile: f64,
        /// Width of the columns (m), for a quantile of 1; by default the cells of the method's grid, or two
        /// point widths for a method that tells of none.
        #[serde(default)]
        cell: Option<f64>,
        /// Names of the bodies whose points count; all that are not rigid when absent, those that a method holds (`held`)
        /// included.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bodies: Option<Vec<String>>,
    },
    /// `(front - initial) / initial`, both counted from `origin`; the front is that of the measure `front`.
    RunOut {
        /// Direction in which the front moves.
        side: Side,
        /// Coordinate of the wall behind the mass (m).
        origin: f64,
        /// Initial length (m).
        initial_length: f64,
        /// Fraction of the mass behind the front.
        #[serde(default = "whole")]
        quantile: f64,
        /// Width of the columns (m), as in `front`.
        #[serde(default)]
        cell: Option<f64>,
        /// Names of the bodies whose points count; all that are not rigid when absent, those that a method holds (`held`)
        /// included.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bodies: Option<Vec<String>>,
    },
    /// Height of the surface in bins along an axis, written at each frame. Rigid bodies do not count, unless `bodies` names
    /// them.
    Profile {
        /// Axis along which the bins lie: 0 is x.
        axis: usize,
        /// Axis of height.
        height: usize,
        /// Width of a bin (m).
        bin: f64,
        /// Names of the bodies whose points count; all that are not rigid when absent, those that a method holds (`held`)
        /// included.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bodies: Option<Vec<String>>,
    },
    /// Fields averaged over the points within `radius` of a place.
    Probe {
        /// Where (m).
        position: Vec<f64>,
        /// Radius (m).
        radius: f64,
        /// Names of fields.
        fields: Vec<String>,
    },
    /// Force of the material on a rigid body or a patch (N; per metre in plane strain, per radian in axisymmetry): in
    /// the last step, and its impulse since the start (N s), whose slope is the mean force.
    Reaction {
        /// Name of the rigid body or patch.
        of: String,
    },
    /// Energy that the materials have dissipated since the start (J; per metre in plane strain, per radian in
    /// axisymmetry): the work of their stresses less what they store. A law that stores no energy that can be told
    /// counts all work as dissipated.
    Dissipation {},
    /// The factor by which strength may be divided before the bodies no longer come to rest, by trials from
    /// the state at the end of a stage. Found after the run.
    FactorOfSafety(FactorOfSafety),
}

fn whole() -> f64 {
    1.0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
