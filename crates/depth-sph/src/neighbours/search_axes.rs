//! Axes of the cells of a neighbour search, rotated with the flow (sheet: depth-sph §3.4).

use crate::points::phase_nodes::PlanVector;

/// Largest number of positions in the covariance: the direction need not be exact.
const MAX_SAMPLES: usize = 1000;

/// Direction along which nodes are sorted in cells; by default the last axis of the plan.
#[derive(Clone, Copy, Debug)]
pub struct SearchAxes<const D: usize> {
    direction: Option<PlanVector<D>>,
}

impl<const D: usize> SearchAxes<D> {
    /// Axes of the plan.
    pub const PLAN: Self = Self { direction: None };

    /// Axes along the longest extent of the nodes, the principal axis of their covariance. In a profile, and if a position is not finite,
    /// they are the axes of the plan.
    pub fn along_longest_extent(places: &[PlanVector<D>]) -> Self {
        if D != 2 || places.is_empty() {
            return Self::PLAN;
        }
        let looked_at = || places.iter().step_by(places.len().div_ceil(MAX_SAMPLES));
        let mut mean = [0.0; D];
        for x in looked_at() {
            (0..D).for_each(|c| mean[c] += x[c]);
        }
        mean = mean.map(|sum| sum / looked_at().len() as f64);
        let (mut difference, mut product) = (0.0, 0.0);
        for x in looked_at() {
            let [a, b] = [x[0] - mean[0], x[1] - mean[1]];
            difference += a * a - b * b;
            product += a * b;
        }
        // Cosine of twice the angle; that of half of it by roots, which are equal on every machine.
        let cosine = difference / difference.hypot(2.0 * product);
        if !cosine.is_finite() {
            return Self::PLAN;
        }
        let half = |sign: f64| (0.5 * (1.0 + sign * cosine)).max(0.0).sqrt();
        let mut along = [half(1.0); D];
        along[1] = half(-1.0).copysign(product);
        Self { direction: Some(along) }
    }

    /// Components of a position along the search axes (m).
    #[inline(always)]
    pub fn to_axes(self, x: &PlanVector<D>) -> PlanVector<D> {
        let Some(along) = self.direction else { return *x };
        let mut turned = *x;
        turned[D - 1] = x[0] * along[0] + x[D - 1] * along[D - 1];
        if D == 2 {
            turned[0] = x[0] * along[1] - x[1] * along[0];
        }
        turned
    }

    /// Whether the search axes are those of the plan.
    pub fn are_those_of_the_plan(&self) -> bool {
        self.direction.is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_follow_a_strip_at_any_angle() {
        for degrees in [-90.0f64, -60.0, -1.0, 0.0, 30.0, 45.0, 90.0, 135.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let mut places = Vec::new();
            for i in 0..40 {
                for j in 0..3 {
                    let [a, b] = [f64::from(i), f64::from(j)];
                    places.push([1e4 + a * cos - b * sin, a * sin + b * cos]);
                }
            }
            let axes = SearchAxes::along_longest_extent(&places);
            let [first, last] = [axes.to_axes(&places[0]), axes.to_axes(&places[117])];
            assert!((last[0] - first[0]).abs() < 1e-9, "{degrees}: {first:?} {last:?}");
            assert!(((last[1] - first[1]).abs() - 39.0).abs() < 1e-9, "{degrees}: {first:?} {last:?}");
        }
    }

    #[test]
    fn points_without_a_longest_extent_keep_the_axes_of_the_plan() {
        assert!(
            SearchAxes::along_longest_extent(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
                .are_those_of_the_plan()
        );
        assert!(SearchAxes::along_longest_extent(&[[0.0, 0.0], [f64::NAN, 0.0]]).are_those_of_the_plan());
        assert!(SearchAxes::along_longest_extent(&[[0.0], [1.0]]).are_those_of_the_plan());
    }
}
