//! Terrain as the bed of a plan or of a profile.

use std::ops::Range;

use colluvium_points::{Raster, RasterError};

use crate::bed::bicubic_spline::{BicubicSpline, smoothed_raster};
use crate::bed::{BedPoint, BedSurface};
use crate::points::phase_nodes::PlanVector;

/// Raster nodes around a position in plan with their bilinear weights, whose sum is one.
pub type BilinearWeights = [(usize, f64); 4];

/// Terrain as the bed of a flow in plan or, if constant along y, in a profile: bicubic spline of the levels of a raster.
#[derive(Clone, Debug)]
pub struct TerrainBed {
    raster: Raster,
    spline: BicubicSpline,
    /// Position of a profile along y (m).
    pub(super) y: f64,
}

impl TerrainBed {
    /// Bed of the levels of a raster (m).
    ///
    /// # Errors
    /// As [`Raster::validate`].
    pub fn new(raster: Raster) -> Result<Self, RasterError> {
        raster.validate()?;
        let y = 0.5 * (raster.origin[1] + raster.last_node_position()[1]);
        Ok(Self { spline: BicubicSpline::new(&raster), raster, y })
    }

    /// Levels of a survey after smoothing `times` times with the weights 1, 2, 1 along each axis.
    pub fn smoothed(raster: &Raster, times: usize) -> Raster {
        if times == 0 { raster.clone() } else { smoothed_raster(raster, times) }
    }

    /// Levels of the surface.
    pub fn raster(&self) -> &Raster {
        &self.raster
    }

    /// Levels of the raster (m) to be changed; [`TerrainBed::update_window`] must follow.
    pub(super) fn levels_mut(&mut self) -> &mut [f64] {
        &mut self.raster.values
    }

    /// Updates the surface after the levels of given columns and rows have changed.
    pub(super) fn update_window(&mut self, window: [Range<usize>; 2]) {
        self.spline.update_window(&self.raster, window);
    }

    /// Updates the surface after changes of any levels.
    pub(super) fn update_all(&mut self) {
        self.spline = BicubicSpline::new(&self.raster);
    }

    /// Raster nodes around a position in plan (m) with their bilinear weights; `None` outside the raster.
    pub fn weights(&self, x: f64, y: f64) -> Option<BilinearWeights> {
        let ([i, j], [s, t]) = self.raster.locate_cell(x, y)?;
        let node = j * self.raster.columns + i;
        let above = node + self.raster.columns;
        Some([
            (node, (1.0 - s) * (1.0 - t)),
            (node + 1, s * (1.0 - t)),
            (above, (1.0 - s) * t),
            (above + 1, s * t),
        ])
    }

    /// Raster cell at a position in plan (m) and the fractional position in it. `None` outside the raster and in cells with a node without
    /// data.
    #[inline]
    fn cell_around<const D: usize>(&self, x: &PlanVector<D>) -> Option<([usize; 2], [f64; 2])> {
        let (cell, share) = self.raster.locate_cell(x[0], x.get(1).copied().unwrap_or(self.y))?;
        let below = cell[1] * self.raster.columns + cell[0];
        let above = below + self.raster.columns;
        let values = &self.raster.values;
        let sum = (values[below] + values[below + 1]) + (values[above] + values[above + 1]);
        sum.is_finite().then_some((cell, share))
    }
}

impl<const D: usize> BedSurface<D> for TerrainBed {
    #[inline]
    fn bed_point(&self, x: &PlanVector<D>) -> Option<BedPoint<D>> {
        let (cell, share) = self.cell_around(x)?;
        let (level, slope, [xx, xy, yy]) = self.spline.evaluate(cell, share, self.raster.spacing);
        let curvature = [[xx, xy], [xy, yy]];
        Some(BedPoint {
            level,
            slope: std::array::from_fn(|c| slope[c]),
            curvature: std::array::from_fn(|c| std::array::from_fn(|k| curvature[c][k])),
        })
    }

    fn is_defined(&self, x: &PlanVector<D>) -> bool {
        self.cell_around(x).is_some()
    }

    fn cell(&self) -> Option<f64> {
        let [dx, dy] = self.raster.spacing;
        Some(dx.min(dy))
    }
}
