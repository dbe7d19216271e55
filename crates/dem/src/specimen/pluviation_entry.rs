//! Entry of grains by pluviation: time, position, and energy.

use colluvium_case::spatial;
use rand::RngExt;

use crate::boundary::periodic_cell::{apply, inverse};
use crate::points::grains::volume;
use crate::points::vector::{difference, dot};
use crate::solver::DemSolver;
use crate::specimen::pluviation::{EnteredGrains, GrainSource, contains_ball};

/// Number of positions drawn for a grain in a step before it waits for the next step.
const DRAWS: usize = 100;

/// Waiting mass over entered mass above which the run warns.
const REPORTED_BACKLOG: f64 = 0.02;

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Adds the grains that are due.
    pub(crate) fn add_entering_grains(&mut self) {
        for number in 0..self.sources.len() {
            let body = self.sources[number].body as usize;
            if self.case.is_removed(&self.case.bodies[body].name, self.stage) {
                continue;
            }
            while self.add_next_grain(number) {}
        }
    }

    /// Adds the next grain of a source if it is due and there is space; returns whether it was added.
    fn add_next_grain(&mut self, number: usize) -> bool {
        let source = &self.sources[number];
        let waits = source.due(self.time) - source.entered.mass;
        let seed = self.options.seed;
        let radius = source.radius(D, seed);
        let mass = source.density * volume(D, radius);
        let place = if waits < mass { None } else { self.free_position(source, radius) };
        let source = &mut self.sources[number];
        source.entered.waiting_mass = if waits < mass { 0.0 } else { waits };
        let Some(x) = place else { return false };
        source.entered = EnteredGrains {
            count: source.entered.count + 1,
            mass: source.entered.mass + mass,
            waiting_mass: waits,
        };
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
        if self.energy_balance.start.is_some() {
            let rotation = 0.5 * g.inertia(last) * dot(&g.spin[last], &g.spin[last]);
            self.energy_balance.entered += 0.5 * mass * speed + rotation;
        }
        self.max_speed = self.max_speed.max(speed.sqrt());
        self.radii = (self.radii.0.min(radius), self.radii.1.max(radius));
        self.membranes.clear();
        self.since_list_build.cell = None;
        true
    }

    /// Random position in the shape of a source where a grain is not in contact; `None` if none is found.
    fn free_position(&self, source: &GrainSource, radius: f64) -> Option<[f64; D]> {
        let mut random = source.random_draws(self.options.seed, self.step + 1);
        let (low, high) = source.shape.bounds(D);
        let (unit, _) = inverse(&self.cell.h);
        let near = self.nearby_grains(&low, &high, radius);
        (0..DRAWS).find_map(|_| {
            let x: [f64; D] = std::array::from_fn(|c| low[c] + (high[c] - low[c]) * random.random::<f64>());
            (contains_ball(&source.shape, &x, radius) && self.is_free(&x, radius, &unit, &near)).then_some(x)
        })
    }

    /// Grains that may be in contact with one of this radius (m) in the box between two corners (m): all of them in a periodic cell,
    /// because of images.
    fn nearby_grains(&self, low: &[f64], high: &[f64], radius: f64) -> Vec<usize> {
        let g = &self.grains;
        let beside = |i: &usize| {
            let (x, reach) = (&g.position[*i], radius + g.radius[*i]);
            (0..D).all(|c| x[c] > low[c] - reach && x[c] < high[c] + reach)
        };
        (0..g.len()).filter(|i| self.cell.is_periodic() || beside(i)).collect()
    }

    /// Whether a grain at `x` would be in contact with neither a wall nor one of the grains `near`.
    fn is_free(&self, x: &[f64; D], radius: f64, unit: &[[f64; D]; D], near: &[usize]) -> bool {
        let g = &self.grains;
        let apart = |i: usize| {
            let apart = difference(x, &g.position[i]);
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
        let off = |wall: &crate::boundary::walls::RigidWall<D>| match wall.current_surface() {
            None => wall.distance(x).0 > radius,
            Some(surface) => !surface.contains(x) && surface.gap(x, radius).is_none(),
        };
        self.walls.iter().all(off) && near.iter().all(|i| clear(*i))
    }

    /// Warning about a source that cannot keep up.
    pub(crate) fn full_source_warning(&self) -> Option<String> {
        let behind =
            |source: &&GrainSource| source.entered.waiting_mass > REPORTED_BACKLOG * source.entered.mass;
        let source = self.sources.iter().find(behind)?;
        Some(format!(
            "t = {:.4e} s: {:.3e} kg of body {:?} wait for room to enter, which its shape no longer has: make the shape larger, its \
             velocity higher, or rain.rate smaller",
            self.time, source.entered.waiting_mass, self.case.bodies[source.body as usize].name
        ))
    }
}
