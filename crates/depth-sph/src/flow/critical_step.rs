//! Critical time step, and totals (sheet: depth-sph §3.3).

use rayon::prelude::*;

use crate::bed::{Bed, BedPoint, ErodibleBed};
use crate::config::choices::Phases;
use crate::flow::Flow;
use crate::phases::phase::TASK;
use crate::phases::phase_nodes::{PlanVector, norm};

/// Largest displacement of a node in a step, over its smoothing length and over a cell of the bed.
const LONGEST_MOVE: f64 = 0.5;

/// Limit of the time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitingNode {
    /// Time step (s); infinite where nothing limits it.
    pub dt: f64,
    /// Set and index of the limiting node.
    pub node: Option<(usize, usize)>,
}

/// Totals of one set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseTotals<const D: usize> {
    /// Mass (kg).
    pub mass: f64,
    /// Momentum in plan (kg m/s).
    pub momentum: [f64; D],
    /// Vertical momentum of the motion along the bed (kg m/s).
    pub vertical_momentum: f64,
    /// Kinetic energy, including the vertical velocity (J).
    pub kinetic: f64,
    /// Potential energy of gravity (J).
    pub potential: f64,
}

impl<const D: usize> Flow<D> {
    /// Largest stable step (s): waves and motion across smoothing lengths.
    pub fn limit(&self) -> LimitingNode {
        let numerics = &self.settings.numerics;
        let passive = self.settings.earth_pressure.map_or(1.0, |k| k.passive.max(1.0));
        // Half a cell of the bed at its speed, or in free fall from rest (sheet: depth-sph §3.3).
        let cell = LONGEST_MOVE * self.bed.cell().unwrap_or(f64::INFINITY);
        let fall = (2.0 * cell / self.settings.whole_gravity()).sqrt();
        let mut least = LimitingNode { dt: f64::INFINITY, node: None };
        for inflow in &self.inflows {
            // No row passes from beyond its reach across the line in a step.
            let section = inflow.max_section();
            let wave = (inflow.gravity * section.max_depth).sqrt() + section.speed;
            least.dt = least.dt.min(numerics.courant * inflow.ratio * inflow.spacing / wave);
        }
        for (number, set) in self.sets.iter().enumerate() {
            let of_node = |i: usize| {
                let nodes = &set.nodes;
                let (length, speed) = (nodes.length[i], norm(&nodes.velocity[i]));
                let wave = (passive * nodes.effective_gravity[i] * nodes.depth[i]).sqrt() + speed;
                let dt = (numerics.courant * length / wave).min(LONGEST_MOVE * length / speed);
                let dt = dt.min(cell / speed).min(fall);
                // Of equal limits the first, on any number of threads.
                (dt, i)
            };
            let nodes = (0..set.nodes.len()).into_par_iter();
            let none = (f64::INFINITY, 0);
            let (dt, i) =
                nodes.with_min_len(TASK).map(of_node).reduce(|| none, |a, b| if b.0 < a.0 { b } else { a });
            if dt < least.dt {
                least = LimitingNode { dt, node: Some((number, i)) };
            }
        }
        least
    }

    /// Bed below a node; level zero beyond its end, where nodes are only until the end of the step.
    pub fn bed_below(&self, x: &PlanVector<D>) -> BedPoint<D> {
        self.bed.at(x).unwrap_or(BedPoint::flat(0.0))
    }

    /// Erodible bed, where erosion is recorded.
    pub fn erodible_bed(&self) -> Option<&ErodibleBed> {
        if let Bed::Erodible(worn) = &self.bed { Some(worn) } else { None }
    }

    /// Density of a set (kg/m³).
    pub fn density(&self, set: usize) -> f64 {
        let material = &self.settings.material;
        match (self.sets.len(), set) {
            (1, _) => material.density(),
            (_, 0) => material.densities.grain,
            _ => material.densities.fluid,
        }
    }

    /// Porosity of the flow at a node.
    fn porosity(&self, set: usize, i: usize) -> f64 {
        let nodes = &self.sets[set].nodes;
        let share = nodes.partial_thickness[i] / nodes.depth[i];
        match (self.settings.phases, set) {
            (Phases::Two, 0) => 1.0 - share,
            (Phases::Two, _) => share,
            _ => self.settings.material.porosity,
        }
    }

    /// Submerged density of the flow at a node (kg/m³).
    pub fn submerged(&self, set: usize, i: usize) -> f64 {
        self.settings.material.densities.submerged(self.porosity(set, i))
    }

    /// Density of the flow at a node (kg/m³), of grains and fluid that of both.
    pub fn density_over(&self, set: usize, i: usize) -> f64 {
        match self.settings.phases {
            Phases::Two => self.settings.material.densities.mixture(self.porosity(set, i)),
            Phases::One | Phases::Layers => self.density(set),
        }
    }

    /// Totals of a set, summed in the order of the nodes' numbers.
    pub fn totals(&self, set: usize) -> PhaseTotals<D> {
        let nodes = &self.sets[set].nodes;
        let density = self.density(set);
        let mut order: Vec<usize> = (0..nodes.len()).collect();
        order.sort_by_key(|&i| nodes.id[i]);
        let mut totals = PhaseTotals {
            mass: 0.0,
            momentum: [0.0; D],
            vertical_momentum: 0.0,
            kinetic: 0.0,
            potential: 0.0,
        };
        for i in order {
            let mass = density * nodes.volume[i];
            let (x, v) = (&nodes.position[i], &nodes.velocity[i]);
            totals.mass += mass;
            let bed = self.bed_below(x);
            totals.kinetic += 0.5 * mass * bed.speed(v).powi(2);
            let level = bed.level + 0.5 * nodes.depth[i];
            let along: f64 = (0..D).map(|c| self.settings.plan_gravity[c] * x[c]).sum();
            totals.potential += mass * (self.settings.gravity * level - along);
            for c in 0..D {
                totals.momentum[c] += mass * v[c];
                totals.vertical_momentum += mass * v[c] * bed.slope[c];
            }
        }
        totals
    }
}
