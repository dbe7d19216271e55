//! Motion over a curved bed: velocities lie in its tangent planes (sheet: depth-sph §2.9, as amended).

use crate::bed::{Bed, BedPoint};
use crate::points::image_nodes::PlanBoundaries;
use crate::points::phase_nodes::{PlanVector, dot};

/// Scalar product of two velocities along a bed, from their components in plan and the slope of the bed.
#[inline]
pub fn dot_along_bed<const D: usize>(slope: &PlanVector<D>, a: &PlanVector<D>, b: &PlanVector<D>) -> f64 {
    dot(a, b) + dot(slope, a) * dot(slope, b)
}

/// Velocity in the plane of slope `from`, transported to that of slope `to`: `V - V·n'/(1 + n·n') (n + n')` in plan. The magnitude is
/// conserved.
#[inline]
pub fn parallel_transport<const D: usize>(
    v: &PlanVector<D>,
    from: &PlanVector<D>,
    to: &PlanVector<D>,
) -> PlanVector<D> {
    let (root, other) = ((1.0 + dot(from, from)).sqrt(), (1.0 + dot(to, to)).sqrt());
    let off = dot(from, v) - dot(to, v);
    let share = off / (other + (1.0 + dot(from, to)) / root);
    std::array::from_fn(|c| v[c] + share * (from[c] / root + to[c] / other))
}

/// Bed below the path of a node, with walls and periods.
pub struct BedPath<'a, const D: usize> {
    bed: &'a Bed<D>,
    walls: &'a PlanBoundaries<D>,
    is_open: bool,
}

impl<'a, const D: usize> BedPath<'a, D> {
    /// Path over a bed with walls and periodic boundaries.
    pub fn new(bed: &'a Bed<D>, walls: &'a PlanBoundaries<D>) -> Self {
        Self { bed, walls, is_open: walls.are_open() }
    }

    /// Bed at a position; beyond walls it is mirrored, beyond periodic boundaries repeated. `None` if there is no bed.
    #[inline]
    pub fn bed_point(&self, x: &PlanVector<D>) -> Option<BedPoint<D>> {
        if self.is_open {
            return self.bed.bed_point(x);
        }
        let (mut inside, mut origin) = (*x, [0.0; D]);
        let signs = self.walls.mirror(&mut inside);
        self.walls.wrap_into_period(&mut inside, &mut origin);
        self.bed.bed_point(&inside).map(|point| point.mirrored(&signs))
    }

    /// Reflects a node that has crossed a wall, with its velocity and the bed point below it.
    #[inline]
    pub fn reflect(&self, x: &mut PlanVector<D>, v: &mut PlanVector<D>, point: &mut BedPoint<D>) {
        if !self.is_open {
            let signs = self.walls.mirror(&mut { *x });
            *point = point.mirrored(&signs);
            self.walls.reflect(x, v);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parallel_transport_preserves_length_and_is_reversible() {
        let (v, a, b) = ([3.0, -1.0], [0.4, 1.3], [-2.0, 0.3]);
        let w = parallel_transport(&v, &a, &b);
        assert!((dot_along_bed(&a, &v, &v) - dot_along_bed(&b, &w, &w)).abs() < 1e-12);
        let back = parallel_transport(&w, &b, &a);
        assert!((0..2).all(|c| (back[c] - v[c]).abs() < 1e-12));
    }

    /// Along a circular arc all of the rotation is in the plane of the motion.
    #[test]
    fn a_profile_keeps_the_speed_along_its_bed() {
        let w = parallel_transport(&[2.0], &[0.0], &[-1.0]);
        assert!((w[0] - 2f64.sqrt()).abs() < 1e-15, "{w:?}");
    }
}
