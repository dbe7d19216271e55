//! Options of `methods.dem`.

mod checks;
mod contact;
mod grains;
mod stages;

use std::collections::BTreeMap;

use colluvium_case::description::Body;
pub use contact::{
    Adhesion, BondSpec, Friction, NormalLaw, PairOverride, PairSpec, RollingSpec, SpringReset, TangentialSpec,
};
pub use grains::{BodyGrains, Diameters, Fill, GrainKind, LatticePacking, Pluviation};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
pub use stages::{
    CellControl, CellEntry, CyclicStrain, CyclicStress, DampingForm, GrainStage, Membrane, Shaking, WallServo,
};

/// Options of the discrete element method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DemOptions {
    /// Grains by kind. The grains of a body are of the kind that has the name of the body's `material`; of the material itself
    /// nothing counts but that it is there, so that one case serves methods for continua as well.
    pub grains: BTreeMap<String, GrainKind>,
    /// How grains act on each other and on walls.
    pub pairs: Vec<PairSpec>,
    /// Parameters that differ for single bodies, by the names of the bodies.
    #[serde(default)]
    pub bodies: BTreeMap<String, BodyGrains>,
    /// A specimen that bodies begin with in place of their fill: a file that `colluvium specimen` has written, from the folder of the
    /// case. Its bodies must be bodies of the case, of the same kind; their grains begin with places, velocities, spins and sizes of
    /// the file, held ones with the velocity that the case gives them, and contacts with all that they remember. The cell along
    /// periodic axes and walls of the same name are those of the file. Other bodies are filled beside them.
    #[serde(default)]
    pub specimen: Option<String>,
    /// Parameters of single stages, by the names of the stages.
    #[serde(default)]
    pub stages: BTreeMap<String, GrainStage>,
    /// Derives pairs of unlike kinds that are not given from those of like kinds: harmonic means of stiffness, the smaller
    /// friction, geometric means of damping ratios. Resistance against rolling and twisting, adhesion and bonds are not derived: `check`
    /// warns where the like kinds have them. Without it a pair that is missing is refused.
    #[serde(default)]
    pub mix: bool,
    /// Where the lever arms of contact forces end.
    #[serde(default)]
    pub lever_arm: LeverArm,
    /// Velocities that contact forces are found with.
    #[serde(default)]
    pub velocity: ContactVelocity,
    /// Thickness of the skin of the lists of neighbours, over the mean diameter, 0.01 to 2.
    #[serde(default = "skin")]
    pub skin: f64,
    /// Time step over half the period of the stiffest contact, `π/ω₀` with its lightest grains, up to 0.12.
    #[serde(default = "step_fraction")]
    pub step_fraction: f64,
    /// Fixed time step (s); chosen by the solver when absent. A step above 0.4/ω₀ of the stiffest contact is refused.
    #[serde(default)]
    pub time_step: Option<f64>,
    /// Overlap over the smaller radius with which grains may start, 0 to 0.3.
    #[serde(default = "initial_overlap")]
    pub initial_overlap: f64,
    /// Keeps how far each grain has turned: the angle in the plane, a quaternion in space, written as `orientation`.
    #[serde(default)]
    pub orientation: bool,
    /// In the plane, writes the area of the cell of each grain in the power diagram of Laguerre (m²), the solid fraction of the cell, and
    /// whether it is one of a surface (it reaches farther than three mean diameters); rows of the measures have the solid
    /// fraction of all others.
    #[serde(default)]
    pub voronoi: bool,
    /// Width of the kernel with which grains and contacts are spread on `output.grid`, over the mean diameter, 0.5 to 20: below 2
    /// single grains show.
    #[serde(default = "coarse_graining")]
    pub coarse_graining: f64,
    /// Regions over which rows of the measures have means, by their names: columns `NAME.porosity`, of the parts of grains that lie in
    /// it; and, of the grains with their centres there, `NAME.grains` (number), `NAME.coordination` (contacts a grain),
    /// `NAME.velocity.x` and so on (of their mass), and `NAME.stress.xx` and so on (tension-positive): the mean over the volumes of
    /// grains, times one minus the porosity. Empty where there is no grain. Where axes are periodic images count.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub regions: BTreeMap<String, MeasuringRegion>,
    /// Seed of the random draws: sizes, places, strengths of bonds.
    #[serde(default)]
    pub seed: u64,
}

/// A circle, in space a sphere, that stays where it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuringRegion {
    /// Centre (m).
    pub centre: Vec<f64>,
    /// Radius (m), > 0: of several grains, that single ones do not show.
    pub radius: f64,
}

impl DemOptions {
    /// Fill of a body: its own, or that of its kind.
    pub fn fill_of_body(&self, body: &Body) -> Option<Fill> {
        let own = self.bodies.get(&body.name).and_then(|own| own.fill);
        own.or_else(|| self.grains.get(&body.material).and_then(|kind| kind.fill))
    }
}

/// Where the lever arms of contact forces end (sheet: dem §2.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LeverArm {
    /// At one point of the line of centres for both grains: conserves angular momentum exactly.
    #[default]
    ContactPoint,
    /// At the undeformed surfaces: angular momentum is off by friction times overlap.
    Radius,
}

/// Velocities that contact forces are found with (sheet: dem §3.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ContactVelocity {
    /// Those half a step behind the positions. Stable up to `ω₀ Δt = 2 (√(1+ζ²) - ζ)`. The velocity Verlet scheme with the
    /// half-kicked velocity is the same.
    #[default]
    Lagged,
    /// Carried on by half a step with the last acceleration. Stable up to `ω₀ Δt = 2 (√(1+4ζ²) - 2ζ)` only.
    Predicted,
}

/// Default value (sheet: dem §3.2).
fn skin() -> f64 {
    0.3
}
/// Default value (sheet: dem §3.5).
fn step_fraction() -> f64 {
    1.0 / 30.0
}
/// Default value (sheet: dem §3.9, one to three).
fn coarse_graining() -> f64 {
    2.0
}
/// Default value (sheet: dem §7).
fn initial_overlap() -> f64 {
    0.1
}
