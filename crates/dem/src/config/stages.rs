//! Options of single stages.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::PairOverride;

/// Options of the grains that differ in a stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GrainStage {
    /// Acceleration of gravity (m/s²) in place of that of the case.
    pub gravity: Option<Vec<f64>>,
    /// Forces on bodies (N; N/m in the plane), by their names, each shared among the grains of its body by their mass.
    pub forces: BTreeMap<String, Vec<f64>>,
    /// Bodies that are flexible membranes, by their names.
    pub membranes: BTreeMap<String, Membrane>,
    /// Shakes the domain, seen from within it.
    pub shaking: Option<Shaking>,
    /// Pairs that differ, in this stage only.
    pub pairs: Vec<PairOverride>,
    /// Sets the springs across all contacts to zero when the stage begins.
    pub reset_contacts: bool,
    /// Velocity of grains that is added at random when the stage begins (m/s), each component at most so large.
    pub agitation: f64,
    /// Rate at which diameters grow (1/s), masses with them.
    pub growth: f64,
    /// Grains grow only while the mean pressure in the periodic cell is below this (Pa; N/m in the plane).
    pub grow_until: Option<f64>,
    /// Form of the local `damping`.
    pub damping_form: DampingForm,
    /// How the periodic cell deforms; it keeps its shape when absent.
    pub cell: Option<CellControl>,
    /// Walls of the case, by name, that follow a stress in place of the velocity of their boundary: platens of a biaxial, triaxial
    /// or oedometer test.
    pub walls: BTreeMap<String, WallServo>,
}

/// A row of grains in the plane, or a sheet of them in space, on which a fluid presses, as on the membrane of a triaxial test: the pressure
/// acts across the line through the centres of the grains, or across the surface between them, in the order in which the body has them
/// (upwards in a lattice one grain wide, as in the file in one of points), whatever way it bends. Bonds to their neighbours keep the
/// grains together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Membrane {
    /// Pressure (Pa; N/m in the plane), not negative.
    pub pressure: f64,
    /// The body that it is pressed against: towards the centre of mass of its grains.
    pub against: String,
    /// Grains in each row of a sheet in space, at least two, whose rows follow each other in the body: of a lattice one grain thick those
    /// along the first axis of its plane. Left out in the plane.
    #[serde(default)]
    pub columns: Option<usize>,
    /// Whether the last grain of each row is beside the first one, as in a sleeve around a cylinder; in space.
    #[serde(default)]
    pub closed: bool,
}

/// Shaking at a frequency that may change over the stage: an acceleration `a sin 2π(f t + (f₁ - f) t²/2T)` acts as gravity does, which is
/// what grains in a shaken box see.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Shaking {
    /// Largest acceleration along each axis (m/s²).
    pub acceleration: Vec<f64>,
    /// Frequency at the start of the stage (Hz).
    pub frequency: f64,
    /// Frequency at its end (Hz); as at the start when absent.
    #[serde(default)]
    pub last_frequency: Option<f64>,
}

impl Shaking {
    /// Factor on the acceleration at time `elapsed` of a stage of `duration` (s).
    pub fn factor(&self, elapsed: f64, duration: f64) -> f64 {
        let change = self.last_frequency.map_or(0.0, |last| (last - self.frequency) / duration);
        (std::f64::consts::TAU * elapsed * (self.frequency + 0.5 * change * elapsed)).sin()
    }
}

/// A wall that follows a stress (sheet: dem §3.7). Its area is what lies between the walls beside it, or within the period; where there are none, `area` or
/// `sleeve` says it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallServo {
    /// Normal stress that the grains are to bear on it (Pa, tension-positive, so that -1e5 is a pressure; N/m in the plane).
    pub stress: f64,
    /// Largest speed (m/s), and that with which it comes where nothing touches it.
    pub speed: f64,
    /// Share of the missing force that it makes good in a step, 0 to 0.1; 0.05 when absent. The wall goes with the grains that
    /// touch it: one that moves has the whole stress, within 0.5 % in the mean over a strain of 1 % at inertial numbers up to 0.001, and the run
    /// warns where it is off by more than 2 %.
    #[serde(default = "default_gain")]
    pub gain: f64,
    /// Area on which the stress acts (m²; m in the plane).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub area: Option<f64>,
    /// Body that is a closed membrane around the specimen, in space: the area is the mean of what its rows enclose now, to the centres of their
    /// grains.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sleeve: Option<String>,
}

/// Default value (sheet: dem §3.7, half of the largest).
fn default_gain() -> f64 {
    0.05
}

/// Form of local damping (sheet: dem §2.9).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DampingForm {
    /// Each component of force against its component of velocity.
    #[default]
    Components,
    /// The force against its power.
    Vector,
}

/// Deformation of a periodic cell: each entry of its velocity gradient follows a rate or a stress; entries that are not given have a
/// rate of zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CellControl {
    /// `∂v_x/∂x`.
    pub xx: Option<CellEntry>,
    /// `∂v_y/∂y`.
    pub yy: Option<CellEntry>,
    /// `∂v_z/∂z`.
    pub zz: Option<CellEntry>,
    /// `∂v_x/∂y`: simple shear.
    pub xy: Option<CellEntry>,
    /// `∂v_y/∂z`.
    pub yz: Option<CellEntry>,
    /// `∂v_x/∂z`.
    pub xz: Option<CellEntry>,
    /// Damping of entries that follow a stress, over `√(P d^(D-2) / m)` of the mean grain; 1 when absent. It acts on the rate less
    /// its mean, so that a cell which deforms steadily has the whole stress: its mean over a strain of 1 % is within 0.5 % at inertial
    /// numbers up to 0.001, and the run warns where it is off by more than 2 %. Below half of the stress a cell is damped in
    /// its whole rate (sheet: dem §3.7).
    pub damping: Option<f64>,
}

/// One entry of the velocity gradient of a periodic cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CellEntry {
    /// Rate (1/s).
    Rate(f64),
    /// Stress (Pa, tension-positive; N/m in the plane) that the cell follows.
    Stress(f64),
    /// A logarithmic strain that goes to and fro.
    CyclicStrain(CyclicStrain),
    /// A stress that goes to and fro, which the cell follows.
    CyclicStress(CyclicStress),
}

/// `amplitude × sin 2πt/period` from the start of the stage on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CyclicStrain {
    /// Largest strain from where the stage begins.
    pub amplitude: f64,
    /// Time of a cycle (s).
    pub period: f64,
}

/// `mean + amplitude × sin 2πt/period` from the start of the stage on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CyclicStress {
    /// Stress at the start (Pa, tension-positive; N/m in the plane).
    pub mean: f64,
    /// Largest difference from it (Pa; N/m in the plane).
    pub amplitude: f64,
    /// Time of a cycle (s).
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
