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
    /// Grain kinds; that of a body is its `material`, whose properties are not used.
    pub grains: BTreeMap<String, GrainKind>,
    /// Contact laws.
    pub pairs: Vec<PairSpec>,
    /// Parameters of bodies in place of their kind's.
    #[serde(default)]
    pub bodies: BTreeMap<String, BodyGrains>,
    /// Specimen of `colluvium specimen`, from the case's folder. Its bodies, with kinds as in the case, start from it in place of their
    /// fill. It gives positions, velocities (not of `held` grains), spins, sizes, contact histories, the periodic cell, and equally named
    /// walls.
    #[serde(default)]
    pub specimen: Option<String>,
    /// Parameters of stages.
    #[serde(default)]
    pub stages: BTreeMap<String, GrainStage>,
    /// Whether missing pairs derive from those of equal kinds, otherwise refused: harmonic mean stiffnesses, smaller friction, geometric
    /// mean damping ratios. Rolling, torsion, adhesion and bonds are left out; `check` warns.
    #[serde(default)]
    pub mix: bool,
    /// End of the lever arms of contact forces.
    #[serde(default)]
    pub lever_arm: LeverArm,
    /// Velocities in contact forces.
    #[serde(default)]
    pub velocity: ContactVelocity,
    /// Neighbour-list margin over mean diameter, 0.01 to 2.
    #[serde(default = "skin")]
    pub skin: f64,
    /// Time step over half the stiffest contact's period, `π/ω₀`, up to 0.12.
    #[serde(default = "step_fraction")]
    pub step_fraction: f64,
    /// Fixed time step (s), at most 0.4/ω₀ of the stiffest contact; the solver's when absent.
    #[serde(default)]
    pub time_step: Option<f64>,
    /// Largest initial overlap over the smaller radius, 0 to 0.3.
    #[serde(default = "initial_overlap")]
    pub initial_overlap: f64,
    /// Whether rotations are written as `orientation`: an angle in the plane, quaternion in space.
    #[serde(default)]
    pub orientation: bool,
    /// Whether Laguerre cells (power diagram) are written, in the plane: area (m²), solid fraction, and surface cells (beyond three mean
    /// diameters). The measures have the solid fraction of cells not at a surface.
    #[serde(default)]
    pub voronoi: bool,
    /// Coarse-graining kernel width on `output.grid` over mean diameter, 0.5 to 20. Below 2 single grains are visible.
    #[serde(default = "coarse_graining")]
    pub coarse_graining: f64,
    /// Measuring regions, with means in the measures. `NAME.porosity` is of grain parts within. `NAME.grains`, `NAME.coordination`
    /// (contacts per grain), `NAME.velocity.x`, … (by mass) and `NAME.stress.xx`, … (tension-positive; grain mean times one minus porosity)
    /// are of grains centred there. Empty without grains; periodic images count.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub regions: BTreeMap<String, MeasuringRegion>,
    /// Seed of random sizes, positions and bond strengths.
    #[serde(default)]
    pub seed: u64,
}

/// Fixed measuring circle (sphere in space).
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

/// End of contact forces' lever arms (sheet: dem §2.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LeverArm {
    /// Common point on the line of centres: conserves angular momentum exactly.
    #[default]
    ContactPoint,
    /// Undeformed surfaces: the error of angular momentum is friction times overlap.
    Radius,
}

/// Velocities in contact forces (sheet: dem §3.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ContactVelocity {
    /// Half a step behind positions, as in velocity Verlet. Stable up to `ω₀ Δt = 2 (√(1+ζ²) - ζ)`.
    #[default]
    Lagged,
    /// Extrapolated by half a step with the last acceleration. Stable up to `ω₀ Δt = 2 (√(1+4ζ²) - 2ζ)`.
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
