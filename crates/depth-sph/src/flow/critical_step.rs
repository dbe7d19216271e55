//! Critical time step (sheet: depth-sph §3.3).

use rayon::prelude::*;

use crate::bed::Bed;
use crate::config::settings::FlowSettings;
use crate::inflow::Inflow;
use crate::phases::phase::PhaseSet;
use crate::points::MIN_NODES_PER_TASK;
use crate::points::phase_nodes::norm;

/// Largest displacement of a node in a step, over its smoothing length.
const LONGEST_MOVE: f64 = 1.0;

/// Largest displacement of a node in a step, over a cell of the bed.
const LONGEST_MOVE_OVER_BED: f64 = 0.75;

/// Largest turn of the bed's normal along the path of a node in a step (rad).
const LARGEST_TURN: f64 = 0.1;

/// Limit of the time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitingNode {
    /// Time step (s); infinite for a flow without limiting node.
    pub dt: f64,
    /// Limiting node as number of its node set and index in it.
    pub limiting_node: Option<(usize, usize)>,
}

/// Largest stable step (s): waves in the frame of each node, and its motion over the bed.
pub(super) fn critical_step<const D: usize>(
    settings: &FlowSettings<D>,
    bed: &Bed<D>,
    inflows: &[Inflow<D>],
    sets: &[PhaseSet<D>],
) -> LimitingNode {
    let numerics = &settings.numerics;
    let passive = settings.earth_pressure.map_or(1.0, |k| k.passive.max(1.0));
    // Half a cell of the bed in free fall from rest (sheet: depth-sph §3.3).
    let cell = bed.cell().unwrap_or(f64::INFINITY);
    let fall = (cell / settings.total_gravity()).sqrt();
    // Waves of two sets travel relative to both, which the neighbours of one do not show.
    let is_alone = sets.len() == 1;
    let mut smallest = LimitingNode { dt: f64::INFINITY, limiting_node: None };
    for inflow in inflows {
        // No row passes from beyond its reach across the line in a step.
        let section = inflow.max_section();
        let wave = (inflow.gravity * section.max_depth).sqrt() + section.speed;
        smallest.dt = smallest.dt.min(numerics.courant * inflow.ratio * inflow.spacing / wave);
    }
    for (number, set) in sets.iter().enumerate() {
        let of_node = |i: usize| {
            let nodes = &set.nodes;
            let (length, speed) = (nodes.length[i], norm(&nodes.velocity[i]));
            let is_known = is_alone && !nodes.relative_speed[i].is_nan();
            let relative = if is_known { nodes.relative_speed[i] } else { speed };
            let wave = (passive * nodes.effective_gravity[i] * nodes.depth[i]).sqrt() + relative;
            let path = (LONGEST_MOVE * length)
                .min(LONGEST_MOVE_OVER_BED * cell)
                .min(LARGEST_TURN / nodes.path_curvature[i]);
            let dt = (numerics.courant * length / wave).min(path / speed).min(fall);
            // Of equal limits the first, on any number of threads.
            (dt, i)
        };
        let nodes = (0..set.nodes.len()).into_par_iter();
        let none = (f64::INFINITY, 0);
        let (dt, i) = nodes
            .with_min_len(MIN_NODES_PER_TASK)
            .map(of_node)
            .reduce(|| none, |a, b| if b.0 < a.0 { b } else { a });
        if dt < smallest.dt {
            smallest = LimitingNode { dt, limiting_node: Some((number, i)) };
        }
    }
    smallest
}
