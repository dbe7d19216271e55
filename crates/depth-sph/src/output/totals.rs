//! Totals of mass, momentum and energy (sheet: depth-sph §3.4, step 11).

use crate::bed::Bed;
use crate::config::settings::FlowSettings;
use crate::phases::phase::PhaseSet;

/// Total mass, momentum and energies of the nodes of one phase or layer.
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

/// Mass, momentum and energies of a node set, summed in the order of node numbers.
pub fn totals<const D: usize>(
    settings: &FlowSettings<D>,
    bed: &Bed<D>,
    sets: &[PhaseSet<D>],
    set: usize,
) -> PhaseTotals<D> {
    let nodes = &sets[set].nodes;
    let density = settings.set_density(sets.len(), set);
    let mut order: Vec<usize> = (0..nodes.len()).collect();
    order.sort_by_key(|&i| nodes.id[i]);
    let mut totals =
        PhaseTotals { mass: 0.0, momentum: [0.0; D], vertical_momentum: 0.0, kinetic: 0.0, potential: 0.0 };
    for i in order {
        let mass = density * nodes.volume[i];
        let (x, v) = (&nodes.position[i], &nodes.velocity[i]);
        totals.mass += mass;
        let below = bed.bed_below(x);
        totals.kinetic += 0.5 * mass * below.speed(v).powi(2);
        let level = below.level + 0.5 * nodes.depth[i];
        let along: f64 = (0..D).map(|c| settings.plan_gravity[c] * x[c]).sum();
        totals.potential += mass * (settings.gravity * level - along);
        for c in 0..D {
            totals.momentum[c] += mass * v[c];
            totals.vertical_momentum += mass * v[c] * below.slope[c];
        }
    }
    totals
}
