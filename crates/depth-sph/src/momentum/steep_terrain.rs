//! Force of depth gradients over steep terrain, and reaction of the bed (sheet: depth-sph §2.9, metric as amended).

use crate::config::choices::{DepthFrame, Metric};
use crate::momentum::force_sums::{ForceSums, solve_or_copy};
use crate::momentum::pair_forces::PairForces;
use crate::points::phase_nodes::{PlanVector, dot};

/// Depth gradient as a share of the bed slope up to which the flow is regarded as a sheet parallel to the bed.
const SHEET_SLOPE_FRACTION: f64 = 0.5;

/// Levelness of the surface: 0 if it is parallel to the bed, 1 if it is level. It follows from the share `t = -q·∇h/|q|²` of the bed slope
/// that the depth gradient compensates. It is even in `t`: gradients of a sheet scatter about zero, and pressure that is stronger uphill
/// than downhill would take energy. Near a level surface nothing changes to first order.
#[inline]
fn surface_levelness<const D: usize>(slope: &PlanVector<D>, gradient: &PlanVector<D>) -> f64 {
    let square = dot(slope, slope);
    if square == 0.0 {
        return 1.0;
    }
    let share = (((dot(slope, gradient) / square).abs() - SHEET_SLOPE_FRACTION)
        / (1.0 - SHEET_SLOPE_FRACTION))
        .clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

impl<const D: usize> PairForces<'_, D> {
    /// Gradient of the flow depth at node `i`: from the pressure sums, or from corrected differences.
    #[inline]
    pub(crate) fn depth_gradient(&self, i: usize, sums: &ForceSums<D>, plain: bool) -> PlanVector<D> {
        if plain {
            let both = 2.0 * self.neighbour_data.pressure[i];
            return if both > 0.0 { sums.pressure_gradient.map(|push| push / both) } else { [0.0; D] };
        }
        let [own, partner] = [0, 1].map(|field| solve_or_copy(&sums.moment, &sums.field_gradients[field]));
        std::array::from_fn(|c| own[c] + partner[c])
    }

    /// Reduction of the depth-gradient force along the bed slope (sheet: depth-sph §2.9, metric as amended): zero for a level surface, `1 -
    /// cos²θ` for one parallel to the bed.
    #[inline]
    pub(crate) fn slope_reduction(&self, i: usize, gradient: &PlanVector<D>) -> f64 {
        let settings = self.settings;
        let steepness = self.bed[i].steepness();
        match settings.metric {
            Metric::Normal => 1.0 - 1.0 / steepness,
            // Where gradients are those of the free surface, or no axis is vertical, nothing needs to be reduced.
            _ if settings.numerics.surface_gradient || settings.frame != DepthFrame::Horizontal => 0.0,
            Metric::Vertical => 0.0,
            Metric::Blended => {
                (1.0 - 1.0 / steepness) * (1.0 - surface_levelness(&self.bed[i].slope, gradient))
            }
        }
    }

    /// Force reduced by a share of its component along the bed slope.
    #[inline]
    pub(crate) fn along_bed(&self, i: usize, force: &PlanVector<D>, share: f64) -> PlanVector<D> {
        let slope = &self.bed[i].slope;
        let square = dot(slope, slope);
        if share == 0.0 || square == 0.0 {
            return *force;
        }
        let part = share * dot(slope, force) / square;
        std::array::from_fn(|c| force[c] - part * slope[c])
    }

    /// Total force on node `i` (m/s²): pressure, viscosity, bed reaction and gravity along the frame.
    #[inline]
    pub(crate) fn with_bed(&self, i: usize, force: &PlanVector<D>, viscous: &PlanVector<D>) -> PlanVector<D> {
        let settings = self.settings;
        let slope = &self.bed[i].slope;
        // The part of the bed's reaction in the gradient of the free surface is left out here.
        let counted = if settings.numerics.surface_gradient { self.nodes.effective_gravity[i] } else { 0.0 };
        let reaction = self.reaction[i] - counted;
        std::array::from_fn(|c| force[c] + viscous[c] - reaction * slope[c] + settings.plan_gravity[c])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levelness_is_one_for_a_level_surface_and_zero_for_a_uniform_sheet() {
        let slope = [0.6, -0.3];
        let at = |share: f64| surface_levelness(&slope, &slope.map(|q| -share * q));
        assert!((at(1.0) - 1.0).abs() < 1e-12 && at(1.5) == 1.0);
        assert!([-0.4, 0.0, 0.4, 0.5].iter().all(|share| at(*share) == 0.0));
        // Uphill and downhill alike, so that a gradient returns the energy that it takes from a sheet.
        assert!([0.6, 0.8, 1.2].iter().all(|share| (at(*share) - at(-*share)).abs() < 1e-12));
        // A small error of a level surface has no effect of first order.
        assert!(1.0 - at(0.99) < 2e-3, "{}", at(0.99));
        assert!((at(0.75) - 0.5).abs() < 1e-12 && surface_levelness(&[0.0; 2], &[0.1, 0.0]) == 1.0);
    }
}
