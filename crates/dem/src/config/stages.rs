//! Options of single stages.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::PairOverride;

/// Options of a stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GrainStage {
    /// Gravity (m/s²), in place of the case's.
    pub gravity: Option<Vec<f64>>,
    /// Forces on bodies (N; N/m in the plane), distributed over grains by mass.
    pub forces: BTreeMap<String, Vec<f64>>,
    /// Flexible membranes, by body.
    pub membranes: BTreeMap<String, Membrane>,
    /// Shaking, in the domain's frame.
    pub shaking: Option<Shaking>,
    /// Pair laws of the stage.
    pub pairs: Vec<PairOverride>,
    /// Whether tangential springs are zeroed at the start.
    pub reset_contacts: bool,
    /// Random velocity (m/s) added at the start: largest value of each component.
    pub agitation: f64,
    /// Growth rate of diameters (1/s); masses grow with them.
    pub growth: f64,
    /// Mean pressure of the periodic cell that ends growth (Pa; N/m in the plane).
    pub grow_until: Option<f64>,
    /// Form of local `damping`.
    pub damping_form: DampingForm,
    /// Periodic cell deformation; none when absent.
    pub cell: Option<CellControl>,
    /// Walls that follow a stress, not their velocity, as platens of tests.
    pub walls: BTreeMap<String, WallServo>,
}

/// Triaxial-test membrane: a row of grains in the plane, a sheet in space, under fluid pressure normal to the line or surface of centres.
/// Grains are ordered as in the body: upwards in a lattice one grain wide, or as a file of points. Bonds keep them together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Membrane {
    /// Fluid pressure (Pa; N/m in the plane), non-negative.
    pub pressure: f64,
    /// Body that it presses, towards its centre of mass.
    pub against: String,
    /// Grains per row of a sheet in space, at least two (three if `closed`); absent in the plane. Lattice rows are parallel to the first
    /// axis of its plane.
    #[serde(default)]
    pub columns: Option<usize>,
    /// Whether rows close, as in a sleeve; in space.
    #[serde(default)]
    pub closed: bool,
}

/// Acceleration `a sin 2π(f t + (f₁ - f) t²/2T)` that acts as gravity, as in a shaken box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Shaking {
    /// Amplitude `a` by axis (m/s²).
    pub acceleration: Vec<f64>,
    /// Initial frequency `f` (Hz).
    pub frequency: f64,
    /// Final frequency `f₁` (Hz); `frequency` when absent.
    #[serde(default)]
    pub last_frequency: Option<f64>,
}

impl Membrane {
    /// Row of grains under a pressure (Pa; N/m in the plane) on the body of a name.
    #[must_use]
    pub fn new(pressure: f64, against: impl Into<String>) -> Self {
        Self { pressure, against: against.into(), columns: None, closed: false }
    }
}

impl Shaking {
    /// Shaking of an acceleration amplitude along each axis (m/s²) at a constant frequency (Hz).
    #[must_use]
    pub fn new(acceleration: impl Into<Vec<f64>>, frequency: f64) -> Self {
        Self { acceleration: acceleration.into(), frequency, last_frequency: None }
    }

    /// Factor on the acceleration at time `elapsed` of a stage of `duration` (s).
    pub fn factor(&self, elapsed: f64, duration: f64) -> f64 {
        let change = self.last_frequency.map_or(0.0, |last| (last - self.frequency) / duration);
        (std::f64::consts::TAU * elapsed * (self.frequency + 0.5 * change * elapsed)).sin()
    }
}

/// Wall that follows a stress (sheet: dem §3.7). Its area ends at walls beside it or the period; without them give `area` or `sleeve`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallServo {
    /// Normal stress of grains on the wall (Pa, negative: -1e5 is a pressure; N/m in the plane).
    pub stress: f64,
    /// Largest speed (m/s), and approach speed without contact.
    pub speed: f64,
    /// Share of the force difference corrected per step, 0 to 0.1. The mean stress over 1 % of strain is within 0.5 % at inertial numbers
    /// up to 0.001. The run warns of errors above 2 %.
    #[serde(default = "default_gain")]
    pub gain: f64,
    /// Area of the stress (m²; m in the plane).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub area: Option<f64>,
    /// Closed membrane around the specimen, in space: the area is the mean within its rows, to grain centres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sleeve: Option<String>,
}

impl WallServo {
    /// Servo of a stress (Pa, tension-positive; N/m in the plane) with a largest speed of the wall (m/s).
    #[must_use]
    pub fn new(stress: f64, speed: f64) -> Self {
        Self { stress, speed, gain: default_gain(), area: None, sleeve: None }
    }
}

/// Default value (sheet: dem §3.7, half of the largest).
fn default_gain() -> f64 {
    0.05
}

/// Form of local damping (sheet: dem §2.9).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DampingForm {
    /// Each force component against its component of velocity.
    #[default]
    Components,
    /// Force against its power.
    Vector,
}

/// Periodic cell deformation: velocity gradient entries follow a rate or stress, zero when absent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CellControl {
    /// Entry `∂v_x/∂x` (1/s).
    pub xx: Option<CellEntry>,
    /// Entry `∂v_y/∂y` (1/s).
    pub yy: Option<CellEntry>,
    /// Entry `∂v_z/∂z` (1/s).
    pub zz: Option<CellEntry>,
    /// Entry `∂v_x/∂y` (1/s): simple shear.
    pub xy: Option<CellEntry>,
    /// Entry `∂v_y/∂z` (1/s).
    pub yz: Option<CellEntry>,
    /// Entry `∂v_x/∂z` (1/s).
    pub xz: Option<CellEntry>,
    /// Damping of entries that follow a stress, over the mean grain's `√(P d^(D-2) / m)`; 1 when absent. It acts on the rate less its mean,
    /// below half the stress on the whole rate (sheet: dem §3.7). Accuracy as of `walls`.
    pub damping: Option<f64>,
}

/// Velocity gradient entry: a rate, stress or cycle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CellEntry {
    /// Prescribed rate (1/s).
    Rate(f64),
    /// Prescribed stress (Pa, tension-positive; N/m in the plane).
    Stress(f64),
    /// Cyclic logarithmic strain.
    CyclicStrain(CyclicStrain),
    /// Cyclic stress.
    CyclicStress(CyclicStress),
}

/// Strain `amplitude × sin 2πt/period`, `t` from the stage's start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CyclicStrain {
    /// Strain amplitude, relative to the stage's start.
    pub amplitude: f64,
    /// Period (s).
    pub period: f64,
}

/// Stress `mean + amplitude × sin 2πt/period`, `t` from the stage's start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CyclicStress {
    /// Mean and initial stress (Pa, tension-positive; N/m in the plane).
    pub mean: f64,
    /// Stress amplitude (Pa; N/m in the plane).
    pub amplitude: f64,
    /// Period (s).
    pub period: f64,
}

impl CellEntry {
    /// Problem of the entry, if there is one.
    pub fn validation_error(&self) -> Option<String> {
        let (numbers, period) = match *self {
            Self::Rate(value) | Self::Stress(value) => ([value, 0.0], None),
            Self::CyclicStrain(own) => ([own.amplitude, 0.0], Some(own.period)),
            Self::CyclicStress(own) => ([own.mean, own.amplitude], Some(own.period)),
        };
        if let Some(value) = numbers.iter().find(|value| !value.is_finite()) {
            return Some(format!("{value} must be finite"));
        }
        let period = period.filter(|period| !(period.is_finite() && *period > 0.0))?;
        Some(format!("a period of {period} s must be finite and positive"))
    }
}
