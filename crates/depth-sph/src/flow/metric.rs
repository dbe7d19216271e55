//! The force of depth gradients over steep terrain, and the reaction of the bed (sheet: depth-sph §2.9, metric as amended).

use super::forces::{Pairs, Sums, corrected};
use crate::choices::{Frame, Metric};
use crate::nodes::{Plan, dot};

impl<const D: usize> Pairs<'_, D> {
    /// Gradient of the depth of what stands over node `i`: that of the sums of pressure, or by corrected differences.
    #[inline]
    pub(super) fn depth_gradient(&self, i: usize, sums: &Sums<D>, plain: bool) -> Plan<D> {
        if plain {
            let both = 2.0 * self.seen.pressure[i];
            return if both > 0.0 { sums.push.map(|push| push / both) } else { [0.0; D] };
        }
        let [own, partner] = [0, 1].map(|field| corrected(&sums.moment, &sums.slopes[field]));
        std::array::from_fn(|c| own[c] + partner[c])
    }

    /// Share of the part along the slope of the bed that the force of a depth gradient loses over it (sheet: depth-sph §2.9, metric as
    /// amended): none below a level surface, `1 - cos²θ` below one that follows the bed.
    #[inline]
    pub(super) fn damping(&self, i: usize, gradient: &Plan<D>) -> f64 {
        let settings = self.settings;
        let steepness = self.bed[i].steepness();
        match settings.metric {
            Metric::Normal => 1.0 - 1.0 / steepness,
            // Where gradients are those of the free surface, or nothing is vertical, there is nothing to damp.
            _ if settings.numerics.surface_gradient || settings.frame != Frame::Horizontal => 0.0,
            Metric::Vertical => 0.0,
            Metric::Blended => {
                1.0 - 1.0 / (steepness + dot(&self.bed[i].slope, gradient)).clamp(1.0, steepness)
            }
        }
    }

    /// A force without this share of its part along the slope of the bed.
    #[inline]
    pub(super) fn along_bed(&self, i: usize, force: &Plan<D>, share: f64) -> Plan<D> {
        let slope = &self.bed[i].slope;
        let square = dot(slope, slope);
        if share == 0.0 || square == 0.0 {
            return *force;
        }
        let part = share * dot(slope, force) / square;
        std::array::from_fn(|c| force[c] - part * slope[c])
    }

    /// The force of node `i` with viscosity, the reaction of the bed and gravity along the frame (m/s²).
    #[inline]
    pub(super) fn with_bed(&self, i: usize, force: &Plan<D>, viscous: &Plan<D>) -> Plan<D> {
        let settings = self.settings;
        let slope = &self.bed[i].slope;
        // What the free surface has counted of the bed is left out here.
        let counted = if settings.numerics.surface_gradient { self.nodes.pull[i] } else { 0.0 };
        let reaction = self.reaction[i] - counted;
        std::array::from_fn(|c| force[c] + viscous[c] - reaction * slope[c] + settings.drive[c])
    }
}
