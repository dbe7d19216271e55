//! Options of `methods.dem`.

mod checks;
mod contact;
mod grains;
mod stages;

use std::collections::BTreeMap;

use colluvium_case::MethodOptions;
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
    /// Kinds of grains, by name. The kind of a body is named by the body's `material`. No property of the material itself is used, so
    /// that one case serves methods for continua as well.
    pub grains: BTreeMap<String, GrainKind>,
    /// Contact laws between kinds of grains and with walls.
    pub pairs: Vec<PairSpec>,
    /// Parameters of bodies that replace those of their kind, by body name.
    #[serde(default)]
    pub bodies: BTreeMap<String, BodyGrains>,
    /// Path of a specimen file, relative to the folder of the case, from which bodies start in place of their fill. The file is written by
    /// `colluvium specimen`. Its bodies must be bodies of the case, of the same kind. Their grains begin with the positions, velocities,
    /// spins and sizes of the file, `held` ones with the velocity of the case, and contacts with their histories. The cell along periodic
    /// axes and walls of the same name are those of the file. Other bodies are filled beside them.
    #[serde(default)]
    pub specimen: Option<String>,
    /// Parameters of single stages, by the names of the stages.
    #[serde(default)]
    pub stages: BTreeMap<String, GrainStage>,
    /// Whether the laws of missing pairs of different kinds are derived from those of equal kinds: harmonic means of stiffnesses, the
    /// smaller friction, geometric means of damping ratios. Rolling and torsional resistance, adhesion and bonds are not derived: `check`
    /// warns where the like kinds have them. Otherwise a missing pair is refused.
    #[serde(default)]
    pub mix: bool,
    /// Point at which the lever arms of contact forces end.
    #[serde(default)]
    pub lever_arm: LeverArm,
    /// Velocities in the contact forces.
    #[serde(default)]
    pub velocity: ContactVelocity,
    /// Margin of the neighbour lists over the mean diameter (-), 0.01 to 2.
    #[serde(default = "skin")]
    pub skin: f64,
    /// Time step over half the period of the stiffest contact, `π/ω₀` with its lightest grains (-), up to 0.12.
    #[serde(default = "step_fraction")]
    pub step_fraction: f64,
    /// Fixed time step (s); chosen by the solver when absent. A step above 0.4/ω₀ of the stiffest contact is refused.
    #[serde(default)]
    pub time_step: Option<f64>,
    /// Largest overlap of grains at the start, over the smaller radius (-), 0 to 0.3.
    #[serde(default = "initial_overlap")]
    pub initial_overlap: f64,
    /// Whether the rotation of each grain is recorded: the angle in the plane, a quaternion in space, written as `orientation`.
    #[serde(default)]
    pub orientation: bool,
    /// Whether the Laguerre tessellation (power diagram) is written, in the plane: the area of the cell of each grain (m²), the solid
    /// fraction of the cell, and whether it is a cell of a surface (it reaches farther than three mean diameters). Rows of the measures
    /// have the solid fraction of all other cells.
    #[serde(default)]
    pub voronoi: bool,
    /// Width of the coarse-graining kernel of grains and contacts on `output.grid`, over the mean diameter (-), 0.5 to 20. Below 2 single
    /// grains are visible.
    #[serde(default = "coarse_graining")]
    pub coarse_graining: f64,
    /// Measuring regions, by name, over which rows of the measures have means: columns `NAME.porosity`, of the parts of grains within the
    /// region; and, of the grains with their centres there, `NAME.grains` (number), `NAME.coordination` (contacts per grain),
    /// `NAME.velocity.x` and so on (weighted by mass), and `NAME.stress.xx` and so on (tension-positive): the mean over the volumes of
    /// grains, times one minus the porosity. Empty where there is no grain. Where axes are periodic, images count.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub regions: BTreeMap<String, MeasuringRegion>,
    /// Seed of the random draws of sizes, positions and strengths of bonds.
    #[serde(default)]
    pub seed: u64,
}

/// Measuring region of fixed position: a circle, in space a sphere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuringRegion {
    /// Centre (m).
    pub centre: Vec<f64>,
    /// Radius (m), > 0; it should include several grains, so that a single one has little effect.
    pub radius: f64,
}

impl MethodOptions for DemOptions {
    const METHOD: &'static str = "dem";
    const REQUIRED: &'static [&'static str] = &["grains", "pairs"];

    fn default_options(&self) -> Self {
        Self::new(self.grains.clone(), self.pairs.clone())
    }
}

impl MeasuringRegion {
    /// Region about a centre (m) of a radius (m).
    #[must_use]
    pub fn new(centre: impl Into<Vec<f64>>, radius: f64) -> Self {
        Self { centre: centre.into(), radius }
    }
}

impl DemOptions {
    /// Options with kinds of grains, each with its name, and the contact laws of their pairs; all others as a case file without them.
    pub fn new<N: Into<String>>(
        grains: impl IntoIterator<Item = (N, GrainKind)>,
        pairs: impl Into<Vec<PairSpec>>,
    ) -> Self {
        Self {
            grains: grains.into_iter().map(|(name, kind)| (name.into(), kind)).collect(),
            pairs: pairs.into(),
            bodies: BTreeMap::new(),
            specimen: None,
            stages: BTreeMap::new(),
            mix: false,
            lever_arm: LeverArm::default(),
            velocity: ContactVelocity::default(),
            skin: skin(),
            step_fraction: step_fraction(),
            time_step: None,
            initial_overlap: initial_overlap(),
            orientation: false,
            voronoi: false,
            coarse_graining: coarse_graining(),
            regions: BTreeMap::new(),
            seed: 0,
        }
    }

    /// Fill of a body: that of the body, or else that of its kind.
    pub fn fill_of_body(&self, body: &Body) -> Option<Fill> {
        let own = self.bodies.get(&body.name).and_then(|own| own.fill);
        own.or_else(|| self.grains.get(&body.material).and_then(|kind| kind.fill))
    }
}

/// Point at which the lever arms of contact forces end (sheet: dem §2.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LeverArm {
    /// Common point of the line of centres for both grains: conserves angular momentum exactly.
    #[default]
    ContactPoint,
    /// Undeformed surfaces of the grains: the error of angular momentum is friction times overlap.
    Radius,
}

/// Velocities in the contact forces (sheet: dem §3.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ContactVelocity {
    /// Velocities half a step behind the positions. Stable up to `ω₀ Δt = 2 (√(1+ζ²) - ζ)`. Equivalent to the velocity Verlet scheme with
    /// velocities of the half step.
    #[default]
    Lagged,
    /// Velocities extrapolated by half a step with the last acceleration. Stable only up to `ω₀ Δt = 2 (√(1+4ζ²) - 2ζ)`.
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
