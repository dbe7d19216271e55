//! Kinds of grains: sizes and methods of filling bodies.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Kind of grains.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GrainKind {
    /// Density of the grains themselves (kg/m³).
    pub density: f64,
    /// Diameters of the grains; not needed where all bodies are single grains or have a file of points.
    #[serde(default)]
    pub diameter: Option<Diameters>,
    /// Method of filling a body with grains.
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

/// Distribution of grain diameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "distribution", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Diameters {
    /// Equal diameters.
    Equal {
        /// Diameter (m).
        value: f64,
    },
    /// Uniform distribution by number.
    Uniform {
        /// Smallest diameter (m).
        min: f64,
        /// Largest diameter (m).
        max: f64,
    },
    /// Equal mass in every interval of diameters (sheet: dem §3.8).
    EqualMass {
        /// Smallest diameter (m).
        min: f64,
        /// Largest diameter (m).
        max: f64,
    },
    /// Grading curve by mass, as a cumulative beta distribution (Voivret et al. 2007; sheet: dem §3.8).
    CumulativeBeta {
        /// Smallest diameter (m).
        min: f64,
        /// Largest diameter (m).
        max: f64,
        /// First shape parameter (-).
        a: f64,
        /// Second shape parameter (-).
        b: f64,
        /// Number of size classes whose grain numbers follow the curve; diameters are drawn at random when absent.
        #[serde(default)]
        classes: Option<usize>,
    },
    /// Grading curve given by points, linear between them.
    Curve {
        /// Diameters (m), ascending.
        diameters: Vec<f64>,
        /// Passing share by mass (-) at each diameter, from 0 to 1.
        passing: Vec<f64>,
    },
}

/// Method of filling the shape of a body with grains.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Fill {
    /// Single grain in place of the body, which must be a ball.
    Single,
    /// Grains on a lattice, those within the shape.
    Lattice {
        /// Lattice type.
        packing: LatticePacking,
        /// Distance of nearest neighbours (m); the largest diameter when absent.
        #[serde(default)]
        pitch: Option<f64>,
        /// Largest random displacement along each axis, over the pitch (-).
        #[serde(default)]
        jitter: f64,
    },
    /// Random packing of a given solid fraction: positions are drawn at random, and radii grow while overlaps are pushed apart. In the
    /// box around the body, periodic where the domain is and the body spans it, or within a ball or a cylinder. Other shapes keep the
    /// grains of the box that are within the shape, so that they are looser along the boundary.
    Random {
        /// Solid fraction (-): area or volume of the grains over that of the box.
        solid_fraction: f64,
    },
    /// Multilayer undercompaction (Jiang et al. 2003): layers of equal mass along the last axis, each drawn at random above the previous
    /// ones and compressed together with them by a lid. Lower layers are compacted too little at first, so that later ones do not make
    /// them denser than the rest. In the box around the body, as `random`.
    Layers {
        /// Final solid fraction (-): area or volume of all grains over that of the box.
        solid_fraction: f64,
        /// Number of layers, 1 to 100.
        layers: usize,
        /// Solid fraction of the first layer while it is alone (-), up to `solid_fraction`; void ratios of the deposited layers decrease
        /// linearly from layer to layer.
        first_solid_fraction: f64,
    },
    /// Ballistic deposition: grains are dropped along the last axis one by one at random positions, until the box around the body is
    /// full. Each grain rolls until it rests on two others in the plane, on three in space, or on the floor of the box. Sides count as
    /// other grains. Periodic where the domain is periodic along another axis and the body spans it. The density follows from the sizes.
    DropAndRoll,
    /// Sleeve of a triaxial test: rings of grains of one size above each other, from the base on. The shape is the `difference` of two
    /// cylinders about one axis, on whose inner side the grains rest. Rings are about as far apart as the grains of a ring, which need
    /// not touch: a sufficient `bond.gap` bonds them.
    Sleeve {
        /// Number of grains in each ring, at least three.
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

/// Lattice type of a packing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LatticePacking {
    /// Square lattice; simple cubic in space.
    Square,
    /// Hexagonal lattice with rows along x; in space face-centred cubic, as hexagonal layers each in the hollows of the one below.
    Hexagonal,
    /// Body-centred cubic lattice, in space.
    BodyCentred,
    /// Face-centred cubic lattice with cubes along the axes, in space.
    FaceCentred,
}

/// Parameters of the grains of a body that replace those of their kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BodyGrains {
    /// Method by which grains fill the body; when absent that of their kind.
    pub fill: Option<Fill>,
    /// Whether the grains have a prescribed motion with the `velocity` of the body, for example as a rough floor. Forces do not change it.
    pub held: bool,
    /// Initial angular velocity (rad/s): one number in the plane, three in space.
    pub spin: Vec<f64>,
    /// Pluviation: grains enter during the run through the shape of the body, which is empty at the start.
    #[serde(rename = "rain")]
    pub pluviation: Option<Pluviation>,
}

/// Pluviation: grains enter during a run at random free positions of the body's shape, with the sizes of their kind and the velocity of
/// the body. Without free space they wait, and the run reports it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pluviation {
    /// Mass rate of entering grains (kg/s; in the plane per metre of thickness), positive.
    pub rate: f64,
    /// Time at which the first grain enters (s), not negative.
    #[serde(default)]
    pub start: f64,
    /// Time after which no grain enters (s), after the start; when absent the end of the run.
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
