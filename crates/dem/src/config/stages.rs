//! Options of single stages.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::PairOverride;

/// Options of the discrete element method that differ in a stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GrainStage {
    /// Acceleration of gravity in the stage (m/s²), which replaces that of the case.
    pub gravity: Option<Vec<f64>>,
    /// Forces on bodies (N; N/m in the plane), by the names of the bodies, each distributed over the grains of its body by mass.
    pub forces: BTreeMap<String, Vec<f64>>,
    /// Flexible membranes, by the names of their bodies.
    pub membranes: BTreeMap<String, Membrane>,
    /// Shaking of the domain, in the frame of the domain.
    pub shaking: Option<Shaking>,
    /// Contact laws of pairs that differ in this stage only.
    pub pairs: Vec<PairOverride>,
    /// Whether all tangential springs are set to zero at the start of the stage.
    pub reset_contacts: bool,
    /// Random velocity (m/s) added to grains at the beginning of the stage, as the largest value of each component.
    pub agitation: f64,
    /// Growth rate of diameters (1/s); masses grow with them.
    pub growth: f64,
    /// Mean pressure in the periodic cell at which the growth of grains ends (Pa; N/m in the plane).
    pub grow_until: Option<f64>,
    /// Form of the local `damping`.
    pub damping_form: DampingForm,
    /// Deformation of the periodic cell; the cell keeps its shape when absent.
    pub cell: Option<CellControl>,
    /// Servo-controlled walls, by the name of the wall in the case, that follow a stress in place of the velocity of their boundary:
    /// platens of a biaxial, triaxial or oedometer test.
    pub walls: BTreeMap<String, WallServo>,
}

/// Membrane of a triaxial test: a row of grains in the plane, or a sheet of them in space, under a fluid pressure. The pressure acts
/// normal to the line through the centres of the grains, or to the surface between them, in the order of the grains in the body (upwards
/// in a lattice one grain wide, that of the file for a file of points), for any curvature. Bonds to their neighbours keep the grains
/// together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Membrane {
    /// Fluid pressure (Pa; N/m in the plane), not negative.
    pub pressure: f64,
    /// Name of the body on which the membrane is pressed: towards the centre of mass of its grains.
    pub against: String,
    /// Number of grains in each row of a sheet in space, at least two. The rows follow each other in the body: in a lattice one grain
    /// thick they are parallel to the first axis of its plane. Absent in the plane.
    #[serde(default)]
    pub columns: Option<usize>,
    /// Whether the last grain of each row is next to the first one, as in a sleeve around a cylinder; in space.
    #[serde(default)]
    pub closed: bool,
}

/// Shaking at a frequency that may change over the stage: an acceleration `a sin 2π(f t + (f₁ - f) t²/2T)` acts as gravity does, which is
/// the effect of shaking in the frame of the box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Shaking {
    /// Acceleration amplitude `a` along each axis (m/s²).
    pub acceleration: Vec<f64>,
    /// Frequency `f` at the start of the stage (Hz).
    pub frequency: f64,
    /// Frequency `f₁` at the end of the stage (Hz); when absent that at the start.
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

/// Servo control of a wall that follows a stress (sheet: dem §3.7). The area of the wall is bounded by the walls beside it, or by the
/// period; where there are none, `area` or `sleeve` gives it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallServo {
    /// Normal stress of the grains on the wall (Pa, tension-positive, so that -1e5 is a pressure; N/m in the plane).
    pub stress: f64,
    /// Largest speed of the wall (m/s), and its speed of approach without contact.
    pub speed: f64,
    /// Fraction of the force difference that the wall corrects in a step (-), 0 to 0.1; 0.05 when absent. The wall moves with the grains in
    /// contact with it: a moving wall has the full stress, within 0.5 % in the mean over a strain of 1 % at inertial numbers up to 0.001,
    /// and the run warns where the error is more than 2 %.
    #[serde(default = "default_gain")]
    pub gain: f64,
    /// Area on which the stress acts (m²; m in the plane).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub area: Option<f64>,
    /// Name of the body that is a closed membrane around the specimen, in space. The area is the mean of the areas that its rows
    /// currently enclose, to the centres of their grains.
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
    /// Damping of each component of force against its component of velocity.
    #[default]
    Components,
    /// Damping of the force against its power.
    Vector,
}

/// Deformation of a periodic cell: each entry of its velocity gradient follows a rate or a stress. Entries that are not given have a rate
/// of zero.
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
    /// Damping of entries that follow a stress, over `√(P d^(D-2) / m)` of the mean grain; 1 when absent. It acts on the rate less its
    /// mean, so that a cell in steady deformation has the full stress: its mean over a strain of 1 % is within 0.5 % at inertial numbers
    /// up to 0.001, and the run warns where the error is more than 2 %. Below half of the stress the damping acts on the whole rate of
    /// the cell (sheet: dem §3.7).
    pub damping: Option<f64>,
}

/// Entry of the velocity gradient of a periodic cell: a prescribed rate, stress or cycle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CellEntry {
    /// Prescribed rate (1/s).
    Rate(f64),
    /// Prescribed stress (Pa, tension-positive; N/m in the plane) that the cell follows.
    Stress(f64),
    /// Prescribed cyclic logarithmic strain.
    CyclicStrain(CyclicStrain),
    /// Prescribed cyclic stress that the cell follows.
    CyclicStress(CyclicStress),
}

/// Cyclic strain `amplitude × sin 2πt/period`, with the time `t` from the start of the stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CyclicStrain {
    /// Strain amplitude (-), relative to the start of the stage.
    pub amplitude: f64,
    /// Period of a cycle (s).
    pub period: f64,
}

/// Cyclic stress `mean + amplitude × sin 2πt/period`, with the time `t` from the start of the stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CyclicStress {
    /// Mean stress, and stress at the start (Pa, tension-positive; N/m in the plane).
    pub mean: f64,
    /// Stress amplitude (Pa; N/m in the plane).
    pub amplitude: f64,
    /// Period of a cycle (s).
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
