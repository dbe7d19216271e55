//! Bounds of depth and speed that follow from the initial state of a flow (sheet: depth-sph §2.9, item 8 as amended).

use crate::bed::BedPoint;
use crate::phases::phase::PhaseSet;
use crate::points::phase_nodes::norm;

/// Depth below which a node has no partner phase, over the largest initial depth; it is at least one millimetre.
const MIN_DEPTH_RATIO: f64 = 1e-3;

/// Bounds of depth and speed by the initial state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowLimits {
    /// Depth below which a phase has no partner (m).
    pub min_partner_depth: f64,
    /// Highest initial level, of bed plus depth (m).
    pub max_initial_level: f64,
    /// Largest initial speed (m/s).
    pub max_initial_speed: f64,
}

impl Default for FlowLimits {
    fn default() -> Self {
        Self {
            min_partner_depth: MIN_DEPTH_RATIO,
            max_initial_level: f64::NEG_INFINITY,
            max_initial_speed: 0.0,
        }
    }
}

impl FlowLimits {
    /// Limits of depth and speed for the nodes of a flow.
    pub fn for_sets<const D: usize>(sets: &[PhaseSet<D>]) -> Self {
        let depths = || sets.iter().flat_map(|set| set.nodes.depth.iter().zip(&set.bed));
        let deepest = depths().map(|(depth, _)| *depth).fold(0.0, f64::max);
        let level = |(depth, bed): (&f64, &BedPoint<D>)| depth + bed.level;
        let speeds = sets.iter().flat_map(|set| &set.nodes.velocity).map(norm);
        Self {
            min_partner_depth: MIN_DEPTH_RATIO * deepest.min(1.0),
            max_initial_level: depths().map(level).fold(f64::NEG_INFINITY, f64::max),
            max_initial_speed: speeds.fold(0.0, f64::max),
        }
    }

    /// Raises the limits for material that enters with a level (m) and a speed (m/s).
    pub fn include(&mut self, level: f64, speed: f64) {
        self.max_initial_level = self.max_initial_level.max(level);
        self.max_initial_speed = self.max_initial_speed.max(speed);
    }
}
