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
    /// Kinds of grains, by name; the kind of a body is its `material`. Properties of the material itself are not used.
    pub grains: BTreeMap<String, GrainKind>,
    /// Contact laws of kinds and walls.
    pub pairs: Vec<PairSpec>,
    /// Parameters of bodies in place of those of their kind.
    #[serde(default)]
    pub bodies: BTreeMap<String, BodyGrains>,
    /// Specimen file of `colluvium specimen`, from the folder of the case. Its bodies, which must be in the case with their kinds, start
    /// from it in place of their fill. It gives positions, velocities (not of `held` grains), spins, sizes and contact histories, the
    /// periodic cell, and walls of equal name.
    #[serde(default)]
    pub specimen: Option<String>,
    /// Parameters of single stages, by stage.
    #[serde(default)]
    pub stages: BTreeMap<String, GrainStage>,
    /// Whether laws of missing pairs derive from those of equal kinds, otherwise refused: harmonic means of stiffnesses, the smaller
    /// friction, geometric means of damping ratios. Rolling and torsional resistance, adhesion and bonds are left out; `check` warns of it.
    #[serde(default)]
    pub mix: bool,
    /// End of the lever arms of contact forces.
    #[serde(default)]
    pub lever_arm: LeverArm,
    /// Velocities in the contact forces.
    #[serde(default)]
    pub velocity: ContactVelocity,
    /// Margin of the neighbour lists over the mean diameter, 0.01 to 2.
    #[serde(default = "skin")]
    pub skin: f64,
    /// Time step over half the period of the stiffest contact, `π/ω₀`, up to 0.12.
    #[serde(default = "step_fraction")]
    pub step_fraction: f64,
    /// Fixed time step (s), at most 0.4/ω₀ of the stiffest contact; chosen by the solver when absent.
    #[serde(default)]
    pub time_step: Option<f64>,
    /// Largest overlap of grains at the start, over the smaller radius, 0 to 0.3.
    #[serde(default = "initial_overlap")]
    pub initial_overlap: f64,
    /// Whether rotations are written as `orientation`: an angle in the plane, a quaternion in space.
    #[serde(default)]
    pub orientation: bool,
    /// Whether the Laguerre tessellation (power diagram) is written, in the plane: area (m²) and solid fraction of cells, and whether a
    /// cell is at a surface (farther than three mean diameters). The measures have the solid fraction of the others.
    #[serde(default)]
    pub voronoi: bool,
    /// Width of the coarse-graining kernel on `output.grid` over the mean diameter, 0.5 to 20. Below 2 single grains are visible.
    #[serde(default = "coarse_graining")]
    pub coarse_graining: f64,
    /// Measuring regions, by name, with means in the measures. `NAME.porosity` is of the parts of grains within. `NAME.grains` (number),
    /// `NAME.coordination` (contacts per grain), `NAME.velocity.x`, … (by mass) and `NAME.stress.xx`, … (tension-positive; grain mean times
    /// one minus porosity) are of grains centred there. Empty without grains; images along periodic axes count.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub regions: BTreeMap<String, MeasuringRegion>,
    /// Seed of random sizes, positions and bond strengths.
    #[serde(default)]
    pub seed: u64,
}

/// Fixed measuring region: a circle, in space a sphere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuringRegion {
    /// Centre (m).
    pub centre: Vec<f64>,
    /// Radius (m), positive, best of several grains.
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

/// End of the lever arms of contact forces (sheet: dem §2.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LeverArm {
    /// Common point on the line of centres: conserves angular momentum exactly.
    #[default]
    ContactPoint,
    /// Undeformed surfaces: the error of angular momentum is friction times overlap.
    Radius,
}

/// Velocities in the contact forces (sheet: dem §3.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ContactVelocity {
    /// Half a step behind the positions, as in velocity Verlet. Stable up to `ω₀ Δt = 2 (√(1+ζ²) - ζ)`.
    #[default]
    Lagged,
    /// Extrapolated by half a step with the last acceleration. Stable only up to `ω₀ Δt = 2 (√(1+4ζ²) - 2ζ)`.
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
