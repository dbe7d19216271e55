//! Grains that enter during a run (sheet: dem §3.8.4, pluviation).

use colluvium_case::{Case, spatial};
use colluvium_points::Shape;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::cell::{apply, inverse};
use crate::config::{DemOptions, Diameters, Rain};
use crate::grains::volume;
use crate::setup::holds;
use crate::solver::DemSolver;
use crate::vector::{dot, minus};

/// Places that are drawn for a grain in a step before it waits for the next one.
const DRAWS: usize = 100;

/// Grains that wait, over what has entered, from which on the run tells.
const BEHIND: f64 = 0.02;

/// A body whose grains enter during the run.
#[derive(Clone, Debug)]
pub struct Source {
    body: u32,
    kind: u32,
    rain: Rain,
    shape: Shape,
    sizes: Diameters,
    density: f64,
    spin: Vec<f64>,
    /// What has entered.
    pub entered: Entered,
}

/// What has entered of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Entered {
    /// Grains.
    pub count: u64,
    /// Mass (kg).
    pub mass: f64,
    /// Mass that waits for room (kg).
    pub waits: f64,
}

/// The sources of a case; the options are checked.
pub fn sources(case: &Case, options: &DemOptions) -> Vec<Source> {
    let source = |(number, body): (usize, &colluvium_case::description::Body)| {
        let own = options.bodies.get(&body.name)?;
        let kind = options.grains.get(&body.material)?;
        Some(Source {
            body: number as u32,
            kind: options.grains.keys().position(|name| *name == body.material)? as u32,
            rain: own.rain?,
            shape: body.shape.clone(),
            sizes: kind.diameter.clone()?,
            density: kind.density,
            spin: own.spin.clone(),
            entered: Entered::default(),
        })
    };
    case.bodies.iter().enumerate().filter_map(source).collect()
}

impl Source {
    /// Kind, and radius and mass of its smallest and largest grains.
    pub fn extremes<const D: usize>(&self) -> (usize, [(f64, f64); 2]) {
        let (low, high) = self.sizes.range();
        let of = |diameter: f64| (0.5 * diameter, self.density * volume(D, 0.5 * diameter));
        (self.kind as usize, [of(low), of(high)])
    }

    /// Mean diameter of its grains by number (m).
    pub fn mean(&self, dimension: usize) -> f64 {
        self.sizes.mean_power(dimension, 1)
    }

    /// Grains that will have entered by `end` (s), about.
    pub fn expected(&self, dimension: usize, end: f64) -> f64 {
        let mean = self.density * volume(dimension, 0.5) * self.sizes.mean_power(dimension, dimension as i32);
        self.due(end) / mean
    }

    /// Mass that should have entered by `time` (s).
    fn due(&self, time: f64) -> f64 {
        let end = self.rain.end.map_or(time, |end| end.min(time));
        self.rain.rate * (end - self.rain.start).max(0.0)
    }

    /// Draws of grain number `count`: the size by themselves, places anew in each step.
    fn draws(&self, seed: u64, step: u64) -> ChaCha8Rng {
        let body = seed.wrapping_add(u64::from(self.body)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let count = self.entered.count.wrapping_add(1).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        ChaCha8Rng::seed_from_u64(body ^ count ^ step.wrapping_mul(0x94d0_49bb_1331_11eb))
    }
}

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Lets grains enter that are due.
    pub(crate) fn rain(&mut self) {
        for number in 0..self.sources.len() {
            let body = self.sources[number].body as usize;
            if self.case.is_removed(&self.case.bodies[body].name, self.stage) {
                continue;
            }
            while self.enter(number) {}
        }
    }

    /// Lets the next grain of a source enter, if it is due and has room.
    fn enter(&mut self, number: usize) -> bool {
        let source = &self.sources[number];
        let waits = source.due(self.time) - source.entered.mass;
        let seed = self.options.seed;
        let radius = 0.5 * source.sizes.draw(D, &mut source.draws(seed, 0));
        let mass = source.density * volume(D, radius);
        let place = if waits < mass { None } else { self.room(source, radius) };
        let source = &mut self.sources[number];
        source.entered.waits = if waits < mass { 0.0 } else { waits };
        let Some(x) = place else { return false };
        source.entered = Entered { count: source.entered.count + 1, mass: source.entered.mass + mass, waits };
        let velocity = self.case.bodies[source.body as usize].velocity.at(spatial(&x));
        let g = &mut self.grains;
        g.push(source.body, source.kind, x, radius, source.density);
        let last = g.len() - 1;
        g.id[last] = self.next_id;
        g.velocity[last] = std::array::from_fn(|c| velocity[c]);
        g.spin[last] = std::array::from_fn(|c| source.spin.get(c).copied().unwrap_or(0.0));
        if self.options.orientation {
            g.orientation.push(if D == 2 { [0.0; 4] } else { [1.0, 0.0, 0.0, 0.0] });
        }
        self.next_id += 1;
        let speed = dot(&g.velocity[last], &g.velocity[last]);
        if self.ledger.start.is_some() {
            let rotation = 0.5 * g.inertia(last) * dot(&g.spin[last], &g.spin[last]);
            self.ledger.entered += 0.5 * mass * speed + rotation;
        }
        self.fastest = self.fastest.max(speed.sqrt());
        self.radii = (self.radii.0.min(radius), self.radii.1.max(radius));
        self.since.cell = None;
        true
    }

    /// A place in the shape of a source where a grain touches nothing.
    fn room(&self, source: &Source, radius: f64) -> Option<[f64; D]> {
        let mut random = source.draws(self.options.seed, self.step + 1);
        let (low, high) = source.shape.bounds(D);
        let (unit, _) = inverse(&self.cell.h);
        (0..DRAWS).find_map(|_| {
            let x: [f64; D] = std::array::from_fn(|c| low[c] + (high[c] - low[c]) * random.random::<f64>());
            (holds(&source.shape, &x, radius) && self.is_free(&x, radius, &unit)).then_some(x)
        })
    }

    /// Whether a grain at `x` would touch nothing.
    fn is_free(&self, x: &[f64; D], radius: f64, unit: &[[f64; D]; D]) -> bool {
        let g = &self.grains;
        let apart = |i: usize| {
            let apart = minus(x, &g.position[i]);
            if !self.cell.is_periodic() {
                return apart;
            }
            let mut s = apply(unit, &apart);
            for c in (0..D).filter(|&c| self.cell.periodic[c]) {
                s[c] -= s[c].round();
            }
            apply(&self.cell.h, &s)
        };
        let clear = |i: usize| {
            let apart = apart(i);
            dot(&apart, &apart) > (radius + g.radius[i]).powi(2)
        };
        let off = |wall: &crate::walls::Wall<D>| match wall.now() {
            None => wall.distance(x).0 > radius,
            Some(surface) => !surface.contains(x) && surface.gap(x, radius).is_none(),
        };
        self.walls.iter().all(off) && (0..g.len()).all(clear)
    }

    /// A source that cannot keep up.
    pub(crate) fn full_region(&self) -> Option<String> {
        let behind = |source: &&Source| source.entered.waits > BEHIND * source.entered.mass;
        let source = self.sources.iter().find(behind)?;
        Some(format!(
            "t = {} s: {:.3e} kg of body {:?} wait for room to enter, which its shape no longer has: make the shape larger, its \
             velocity higher, or rain.rate smaller",
            self.time, source.entered.waits, self.case.bodies[source.body as usize].name
        ))
    }
}
