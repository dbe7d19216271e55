//! Terrain as the bed of a plan or of a profile.

use std::ops::Range;

use colluvium_points::{Raster, RasterError};

use crate::bed::bicubic_spline::{BicubicSpline, smoothed_raster};
use crate::bed::{BedPoint, BedSurface};
use crate::points::phase_nodes::PlanVector;

/// Nodes around a position in plan and their bilinear weights, which add up to one.
pub type BilinearWeights = [(usize, f64); 4];

/// Terrain as the bed of a plan or, where it is constant along y, of a profile: a bicubic spline of the levels of a raster.
#[derive(Clone, Debug)]
pub struct TerrainBed {
    raster: Raster,
    spline: BicubicSpline,
    /// Position of a profile along y (m).
    pub(super) y: f64,
}

impl TerrainBed {
    /// Creates the bed of these levels (m).
    ///
    /// # Errors
    /// As [`Raster::validate`].
    pub fn new(raster: Raster) -> Result<Self, RasterError> {
        raster.validate()?;
        let y = 0.5 * (raster.origin[1] + raster.last_node_position()[1]);
        Ok(Self { spline: BicubicSpline::new(&raster), raster, y })
    }

    /// Levels of a survey after `times` means with weights 1, 2, 1 along each axis, from which a bed is made.
    pub fn smoothed(raster: &Raster, times: usize) -> Raster {
        if times == 0 { raster.clone() } else { smoothed_raster(raster, times) }
    }

    /// Levels of the surface.
    pub fn raster(&self) -> &Raster {
        &self.raster
    }

    /// Levels (m), to change them; call [`TerrainBed::update_window`] afterwards.
    pub(super) fn levels_mut(&mut self) -> &mut [f64] {
        &mut self.raster.values
    }

    /// Updates the surface after changes of levels in these columns and rows.
    pub(super) fn update_window(&mut self, window: [Range<usize>; 2]) {
        self.spline.update_window(&self.raster, window);
    }

    /// Updates the surface after changes of any levels.
    pub(super) fn update_all(&mut self) {
        self.spline = BicubicSpline::new(&self.raster);
    }

    /// Nodes around a position in plan (m) with their weights; `None` beyond the outermost nodes.
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

    /// Cell around a position in plan (m) and the fractions of it along both axes; `None` beyond the outermost nodes or where a node
    /// of the cell has no data.
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
