//! Grains: sizes, and how they fill bodies.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A kind of grains.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GrainKind {
    /// Density of the grains themselves (kg/m³).
    pub density: f64,
    /// Their diameters; not needed where all bodies are single grains or have a file of points.
    #[serde(default)]
    pub diameter: Option<Diameters>,
    /// How they fill a body.
    #[serde(default)]
    pub fill: Option<Fill>,
}

/// Distributions of diameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "distribution", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Diameters {
    /// All the same.
    Equal {
        /// Diameter (m).
        value: f64,
    },
    /// Uniform by number.
    Uniform {
        /// Smallest (m).
        min: f64,
        /// Largest (m).
        max: f64,
    },
    /// Equal mass in every interval of sizes (sheet: dem §3.8).
    EqualMass {
        /// Smallest (m).
        min: f64,
        /// Largest (m).
        max: f64,
    },
    /// A grading curve by mass that is a cumulative beta distribution (Voivret et al. 2007; sheet: dem §3.8).
    CumulativeBeta {
        /// Smallest (m).
        min: f64,
        /// Largest (m).
        max: f64,
        /// First shape parameter.
        a: f64,
        /// Second shape parameter.
        b: f64,
        /// Number of classes of sizes for grains whose numbers are not drawn but follow the curve; drawn when absent.
        #[serde(default)]
        classes: Option<usize>,
    },
    /// A grading curve by points, linear between them.
    Curve {
        /// Diameters (m), ascending.
        diameters: Vec<f64>,
        /// Mass that passes, from 0 to 1.
        passing: Vec<f64>,
    },
}

/// How grains fill the shape of a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Fill {
    /// One grain that is the body, which must be a ball.
    Single,
    /// On a lattice, those that lie in the shape.
    Lattice {
        /// Which lattice.
        packing: LatticePacking,
        /// Distance of next neighbours (m); the largest diameter when absent.
        #[serde(default)]
        pitch: Option<f64>,
        /// Random displacement along each axis, at most this share of the pitch.
        #[serde(default)]
        jitter: f64,
    },
    /// At random, at a solid fraction: places drawn at random, radii that grow while overlaps are pushed apart. In the box
    /// around the body, periodic where the domain is and the body spans it, or within a ball or a cylinder; of other shapes
    /// those grains that lie in the shape, so that they are looser along it.
    Random {
        /// Area or volume of the grains over that of the box.
        solid_fraction: f64,
    },
    /// In layers of equal mass along the last axis, each drawn at random above those that are there and pressed with them by a lid, the
    /// lower ones too little at first, so that later ones don't make them denser than the rest (multilayer undercompaction,
    /// Jiang et al. 2003). In the box around the body, as `random`.
    Layers {
        /// Area or volume of all grains over that of the box.
        solid_fraction: f64,
        /// How many layers, 1 to 100.
        layers: usize,
        /// Solid fraction of the first layer while it is alone, up to `solid_fraction`; void ratios of what there is fall
        /// linearly from layer to layer.
        first_solid_fraction: f64,
    },
    /// Grains dropped along the last axis one by one at random places, each of which rolls until it rests on two others in the plane, on three
    /// in space, sides counting as others, or on the floor of the box around the body, until the box is full (ballistic deposition).
    /// In the period where the domain is periodic along another axis and the body spans it. The density follows from the sizes.
    DropAndRoll,
    /// Rings of grains of one size above each other, the sleeve of a triaxial test, from the base on: the shape is the `difference` of two
    /// cylinders about one axis, on whose inner side the grains rest. Rings are about as far apart as the grains of a ring, which need not touch:
    /// a `bond.gap` that is wide enough bonds them.
    Sleeve {
        /// Grains in each ring, at least three.
        columns: usize,
    },
}

/// Lattices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LatticePacking {
    /// Square; simple cubic in space.
    Square,
    /// Hexagonal, rows along x; in space hexagonal layers one above the other in the hollows, face-centred cubic.
    Hexagonal,
    /// Body-centred cubic, in space.
    BodyCentred,
    /// Face-centred cubic with cubes along the axes, in space.
    FaceCentred,
}

/// Parameters of the grains of a body that differ from those of their kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BodyGrains {
    /// How it is filled; as its kind says when absent.
    pub fill: Option<Fill>,
    /// Whether its grains are held: they move with the body's `velocity` whatever acts on them, as a rough floor does.
    pub held: bool,
    /// Angular velocity at the start (rad/s): one number in the plane, three in space.
    pub spin: Vec<f64>,
    /// Has its grains enter during the run, through its shape; it begins empty.
    #[serde(rename = "rain")]
    pub pluviation: Option<Pluviation>,
}

/// Grains that enter during a run: their sizes are those of their kind, their velocity is that of the body, their places are
/// drawn at random in its shape, where there is room. Without room they wait, and the run reports it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pluviation {
    /// Mass that enters in a second (kg/s; in the plane per metre of thickness), positive.
    pub rate: f64,
    /// When it begins (s), not negative.
    #[serde(default)]
    pub start: f64,
    /// When it ends (s), after its start; with the run when absent.
    #[serde(default)]
    pub end: Option<f64>,
}
