//! Kinds of grains: sizes and methods of filling bodies.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Grain kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GrainKind {
    /// Grain density (kg/m³).
    pub density: f64,
    /// Diameters; not for single grains and files of points.
    #[serde(default)]
    pub diameter: Option<Diameters>,
    /// Filling of bodies.
    #[serde(default)]
    pub fill: Option<Fill>,
}

impl GrainKind {
    /// Kind of a density of the grains themselves (kg/m³), without diameters and fill.
    #[must_use]
    pub fn new(density: f64) -> Self {
        Self { density, diameter: None, fill: None }
    }

    /// Kind of a density (kg/m³) whose bodies are filled with grains of a distribution of diameters.
    #[must_use]
    pub fn filled(density: f64, diameter: Diameters, fill: Fill) -> Self {
        Self { density, diameter: Some(diameter), fill: Some(fill) }
    }
}

/// Grain diameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "distribution", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Diameters {
    /// Equal diameters.
    Equal {
        /// Diameter (m).
        value: f64,
    },
    /// Uniform by number.
    Uniform {
        /// Smallest diameter (m).
        min: f64,
        /// Largest diameter (m).
        max: f64,
    },
    /// Equal mass in equal diameter intervals (sheet: dem §3.8).
    EqualMass {
        /// Smallest diameter (m).
        min: f64,
        /// Largest diameter (m).
        max: f64,
    },
    /// Cumulative beta by mass (Voivret et al. 2007; sheet: dem §3.8).
    CumulativeBeta {
        /// Smallest diameter (m).
        min: f64,
        /// Largest diameter (m).
        max: f64,
        /// First shape parameter.
        a: f64,
        /// Second shape parameter.
        b: f64,
        /// Size classes on the curve; random diameters when absent.
        #[serde(default)]
        classes: Option<usize>,
    },
    /// Grading curve, linear between points.
    Curve {
        /// Diameters (m), ascending.
        diameters: Vec<f64>,
        /// Mass share passing each diameter, from 0 to 1.
        passing: Vec<f64>,
    },
}

/// Filling of a shape with grains.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Fill {
    /// Single grain; the body must be a ball.
    Single,
    /// Lattice within the shape.
    Lattice {
        /// Lattice type.
        packing: LatticePacking,
        /// Nearest-neighbour distance (m); the largest diameter when absent.
        #[serde(default)]
        pitch: Option<f64>,
        /// Largest random displacement along each axis over the pitch.
        #[serde(default)]
        jitter: f64,
    },
    /// Random packing of given solid fraction: radii grow at random positions while overlaps are pushed apart. It fills the body's box
    /// (periodic where the domain is and the body spans it), a ball or a cylinder. Other shapes keep the grains within, looser along the
    /// boundary.
    Random {
        /// Solid share of the box, by area or volume.
        solid_fraction: f64,
    },
    /// Multilayer undercompaction (Jiang et al. 2003), in the box as `random`. Layers of equal mass are drawn at random above the others
    /// and compressed with them by a lid. Lower layers start looser.
    Layers {
        /// Final solid share of the box, by area or volume.
        solid_fraction: f64,
        /// Layers, 1 to 100.
        layers: usize,
        /// Solid fraction of the first layer alone, up to `solid_fraction`; void ratios decrease linearly between layers.
        first_solid_fraction: f64,
    },
    /// Ballistic deposition: grains drop one by one at random positions, until the body's box is full. Each rolls until it rests on two
    /// others (three in space) or the floor; sides count as grains. Other axes are periodic as in `random`. Sizes determine the density.
    DropAndRoll,
    /// Triaxial-test sleeve: rings of equal grains from the base, inside a `difference` of coaxial cylinders. Rings are about as far apart
    /// as their grains, which need not touch: choose `bond.gap`.
    Sleeve {
        /// Grains per ring, at least three.
        columns: usize,
    },
}

impl Fill {
    /// Grains on a lattice at the distance of the largest diameter, without random displacements.
    #[must_use]
    pub fn lattice(packing: LatticePacking) -> Self {
        Self::Lattice { packing, pitch: None, jitter: 0.0 }
    }
}

/// Lattice type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LatticePacking {
    /// Square; simple cubic in space.
    Square,
    /// Hexagonal, rows along x; in space face-centred cubic, hexagonal layers in the hollows of those below.
    Hexagonal,
    /// Body-centred cubic, in space.
    BodyCentred,
    /// Face-centred cubic with cubes along the axes, in space.
    FaceCentred,
}

/// Parameters of a body in place of its kind's.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BodyGrains {
    /// Filling; the kind's when absent.
    pub fill: Option<Fill>,
    /// Whether grains keep the body's `velocity`, as a rough floor.
    pub held: bool,
    /// Initial angular velocity (rad/s): one number in the plane, three in space.
    pub spin: Vec<f64>,
    /// Grains entering in the run; the body starts empty.
    #[serde(rename = "rain")]
    pub pluviation: Option<Pluviation>,
}

/// Pluviation: grains enter at random free positions of the shape with the body's velocity. Without space they wait, and the run reports
/// it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pluviation {
    /// Mass rate (kg/s; kg/(s m) in the plane), positive.
    pub rate: f64,
    /// First entry (s), non-negative.
    #[serde(default)]
    pub start: f64,
    /// Last entry (s), after `start`; the run's end when absent.
    #[serde(default)]
    pub end: Option<f64>,
}

impl Pluviation {
    /// Grains that enter at a mass rate (kg/s; in the plane per metre of thickness) from the start to the end of the run.
    #[must_use]
    pub fn new(rate: f64) -> Self {
        Self { rate, start: 0.0, end: None }
    }
}
