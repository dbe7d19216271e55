//! Terrain as the bed of a plan or of a profile.

use colluvium_points::Terrain;

use super::{BedPoint, Surface};
use crate::nodes::Plan;

/// Terrain as the bed of a plan or, where it is the same along y, of a profile.
#[derive(Clone, Debug)]
pub struct Sampled {
    pub(super) terrain: Terrain,
    /// Where a profile lies (m).
    pub(super) y: f64,
}

impl Sampled {
    /// The bed of a terrain.
    pub fn new(terrain: Terrain) -> Self {
        let raster = terrain.raster();
        let y = 0.5 * (raster.origin[1] + raster.end()[1]);
        Self { terrain, y }
    }
}

impl<const D: usize> Surface<D> for Sampled {
    fn at(&self, x: &Plan<D>) -> Option<BedPoint<D>> {
        let bed = self.terrain.bed(x[0], x.get(1).copied().unwrap_or(self.y))?;
        let [xx, xy, yy] = bed.hessian;
        let curvature = [[xx, xy], [xy, yy]];
        Some(BedPoint {
            level: bed.height,
            slope: std::array::from_fn(|c| bed.gradient[c]),
            curvature: std::array::from_fn(|c| std::array::from_fn(|k| curvature[c][k])),
        })
    }

    fn holds(&self, x: &Plan<D>) -> bool {
        self.terrain.holds(x[0], x.get(1).copied().unwrap_or(self.y))
    }

    fn cell(&self) -> Option<f64> {
        let [dx, dy] = self.terrain.raster().spacing;
        Some(dx.min(dy))
    }
}
