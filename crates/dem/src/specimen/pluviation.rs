//! Pluviation: grains that enter during a run (sheet: dem §3.8).

use colluvium_case::Case;
use colluvium_points::Shape;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::config::{DemOptions, Diameters, Pluviation};
use crate::points::grains::volume;

/// Body whose grains enter during the run.
#[derive(Clone, Debug)]
pub struct GrainSource {
    /// Index into the bodies of the case.
    pub body: u32,
    /// Index into the kinds.
    pub kind: u32,
    pluviation: Pluviation,
    /// Shape in which the grains appear.
    pub shape: Shape,
    sizes: Diameters,
    /// Density of the grains (kg/m³).
    pub density: f64,
    /// Angular velocity of entering grains (rad/s).
    pub spin: Vec<f64>,
    /// Number and mass of the grains that have entered.
    pub entered_grains: EnteredGrains,
}

/// Number and mass of the grains of a body that have entered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnteredGrains {
    /// Number of grains.
    pub count: u64,
    /// Mass (kg).
    pub mass: f64,
    /// Mass that waits for space (kg).
    pub waiting_mass: f64,
}

/// Sources of a case with validated options.
pub fn sources(case: &Case, options: &DemOptions) -> Vec<GrainSource> {
    let source = |(number, body): (usize, &colluvium_case::description::Body)| {
        let own = options.bodies.get(&body.name)?;
        let kind = options.grains.get(&body.material)?;
        Some(GrainSource {
            body: number as u32,
            kind: options.grains.keys().position(|name| *name == body.material)? as u32,
            pluviation: own.pluviation?,
            shape: body.shape.clone(),
            sizes: kind.diameter.clone()?,
            density: kind.density,
            spin: own.spin.clone(),
            entered_grains: EnteredGrains::default(),
        })
    };
    case.bodies.iter().enumerate().filter_map(source).collect()
}

impl GrainSource {
    /// Kind, and radius (m) and mass (kg) of its smallest and largest grains.
    pub fn extremes<const D: usize>(&self) -> (usize, [(f64, f64); 2]) {
        let (low, high) = self.sizes.range();
        let of = |diameter: f64| (0.5 * diameter, self.density * volume(D, 0.5 * diameter));
        (self.kind as usize, [of(low), of(high)])
    }

    /// Mean diameter of the grains by number (m).
    pub fn mean(&self, dimension: usize) -> f64 {
        self.sizes.mean_power(dimension, 1)
    }

    /// Approximate number of grains that enter until `end` (s).
    pub fn expected_count(&self, dimension: usize, end: f64) -> f64 {
        let mean = self.density * volume(dimension, 0.5) * self.sizes.mean_power(dimension, dimension as i32);
        self.mass_by(end) / mean
    }

    /// Mass due by `time` (s).
    pub fn mass_by(&self, time: f64) -> f64 {
        let end = self.pluviation.end.map_or(time, |end| end.min(time));
        self.pluviation.rate * (end - self.pluviation.start).max(0.0)
    }

    /// Radius of the next grain (m).
    pub fn radius(&self, dimension: usize, seed: u64) -> f64 {
        0.5 * self.sizes.draw(dimension, &mut self.random_draws(seed, 0))
    }

    /// Random number generator for the next grain: `step` 0 for its size, others for its position in a step.
    pub fn random_draws(&self, seed: u64, step: u64) -> ChaCha8Rng {
        let body = seed.wrapping_add(u64::from(self.body)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let count = self.entered_grains.count.wrapping_add(1).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        ChaCha8Rng::seed_from_u64(body ^ count ^ step.wrapping_mul(0x94d0_49bb_1331_11eb))
    }
}

/// Whether a ball is in a shape, by its centre and its extreme points along the axes.
pub fn contains_ball<const D: usize>(shape: &Shape, x: &[f64; D], radius: f64) -> bool {
    let inner = radius * (1.0 - 1e-9);
    shape.contains(x)
        && (0..2 * D).all(|end| {
            let mut y = *x;
            y[end / 2] += if end % 2 == 0 { inner } else { -inner };
            shape.contains(&y)
        })
}
