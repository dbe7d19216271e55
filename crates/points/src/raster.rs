//! Rasters: numbers on a rectangular grid in plan, with a georeference.

use thiserror::Error;

/// Georeference of a raster's file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Georeference {
    /// EPSG code of the coordinate reference system.
    pub epsg: Option<u32>,
    /// Name or text of the coordinate reference system, as in the file.
    pub crs: Option<String>,
    /// Whether the file gives the corner of the first cell rather than its centre.
    pub pixel_is_area: bool,
    /// No-data value of the file; NaN in memory.
    pub no_data: Option<f64>,
    /// Number of values of the file that are not finite and differ from the no-data value; they are NaN in memory too.
    pub undeclared_no_data: usize,
    /// Number of these values that are too large for any quantity: programs mark no data in this way.
    pub huge_values: usize,
    /// GeoKeys of a GeoTIFF that define its horizontal system by a projection and its parameters, with their identifiers; empty where the
    /// system has a code or a text.
    pub geo_keys: Vec<(u16, GeoKey)>,
}

/// Value of a GeoKey (OGC 19-008r4, GeoTIFF Standard 1.1).
#[derive(Clone, Debug, PartialEq)]
pub enum GeoKey {
    /// Code.
    Code(u16),
    /// Numeric parameters.
    Numbers(Vec<f64>),
    /// Name or text.
    Text(String),
}

/// Numbers at the nodes of a regular grid in plan, such as the heights of a terrain (m). A cell-registered file has its nodes at the
/// centres of its cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// Number of nodes along x.
    pub columns: usize,
    /// Number of nodes along y.
    pub rows: usize,
    /// Node with the smallest x and y (m).
    pub origin: [f64; 2],
    /// Distance of the nodes along x and y (m).
    pub spacing: [f64; 2],
    /// One number per node, row by row from south to north (from the smallest y), each from west to east; NaN where there is none.
    pub values: Vec<f64>,
    /// Georeference of the file.
    pub reference: Georeference,
}

/// Error in a raster.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RasterError {
    /// Number of values that differs from the number of nodes.
    #[error("{columns} columns and {rows} rows do not make {values} values")]
    Count {
        /// Columns.
        columns: usize,
        /// Rows.
        rows: usize,
        /// Values.
        values: usize,
    },
    /// Too few nodes.
    #[error("{columns} columns and {rows} rows are too few: a surface needs two of each")]
    TooFewNodes {
        /// Columns.
        columns: usize,
        /// Rows.
        rows: usize,
    },
    /// Spacing that is not a length, or origin that is not finite.
    #[error("a spacing of {spacing:?} m at {origin:?} m must be finite and positive")]
    Spacing {
        /// Spacing (m).
        spacing: [f64; 2],
        /// Origin (m).
        origin: [f64; 2],
    },
    /// Raster without a single number.
    #[error("contains no data: every value is the no-data value")]
    Empty,
    /// Window that does not overlap the raster.
    #[error("the window from {low:?} to {high:?} m does not contain two nodes along each axis of the raster")]
    Window {
        /// Lower corner (m).
        low: [f64; 2],
        /// Upper corner (m).
        high: [f64; 2],
    },
}

impl RasterError {
    /// Stable code of the error, which `docs/messages.md` of the repository explains.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Empty => "raster-empty",
            Self::Count { .. } | Self::TooFewNodes { .. } | Self::Spacing { .. } | Self::Window { .. } => {
                "raster-size"
            }
        }
    }
}

/// Magnitude above which a thickness or a depth (m) probably stands for no data.
const LIKELY_NO_DATA: f64 = 9000.0;

impl Raster {
    /// Warning about numbers in a file that seem to stand for no data although the file declares no such value; `None` without them.
    pub fn undeclared_no_data_warning(&self) -> Option<String> {
        /// Instruction for messages: how a file declares its no-data value.
        const NAME_IT: &str = "declare it in the file, as NODATA_value or in the GDAL tag";
        let boundless = self.reference.huge_values;
        if boundless > 0 {
            return Some(format!(
                "{boundless} of its values are 1e30 or more and are not the declared no-data value. If such \
                 a value stands for no data, {NAME_IT}"
            ));
        }
        let far = || self.values.iter().copied().filter(|value| value.abs() >= LIKELY_NO_DATA);
        let first = far().next()?;
        Some(format!(
            "{} of its values are {LIKELY_NO_DATA} or more, or -{LIKELY_NO_DATA} or less, for example \
             {first}. If that value stands for no data, {NAME_IT}",
            far().count()
        ))
    }

    /// Raster of `function` at nodes `spacing` (m) apart, from `origin` (m).
    pub fn from_function(
        [columns, rows]: [usize; 2],
        origin: [f64; 2],
        spacing: [f64; 2],
        function: impl Fn(f64, f64) -> f64,
    ) -> Self {
        let at = |number: usize| {
            let (i, j) = (number % columns, number / columns);
            function(origin[0] + i as f64 * spacing[0], origin[1] + j as f64 * spacing[1])
        };
        let values = (0..columns * rows).map(at).collect();
        Self { columns, rows, origin, spacing, values, reference: Georeference::default() }
    }

    /// Checks sizes and spacing, and that at least one node has a number.
    ///
    /// # Errors
    /// The first error found.
    pub fn validate(&self) -> Result<(), RasterError> {
        let Self { columns, rows, origin, spacing, values, .. } = self;
        if *columns < 2 || *rows < 2 {
            return Err(RasterError::TooFewNodes { columns: *columns, rows: *rows });
        }
        if columns.checked_mul(*rows) != Some(values.len()) {
            return Err(RasterError::Count { columns: *columns, rows: *rows, values: values.len() });
        }
        let good = spacing.iter().all(|s| s.is_finite() && *s > 0.0) && origin.iter().all(|o| o.is_finite());
        if !good {
            return Err(RasterError::Spacing { spacing: *spacing, origin: *origin });
        }
        if values.iter().all(|v| !v.is_finite()) { Err(RasterError::Empty) } else { Ok(()) }
    }

    /// Value of a node.
    pub fn value(&self, column: usize, row: usize) -> f64 {
        self.values[row * self.columns + column]
    }

    /// Position of a node in plan (m).
    pub fn node_position(&self, column: usize, row: usize) -> [f64; 2] {
        [self.origin[0] + column as f64 * self.spacing[0], self.origin[1] + row as f64 * self.spacing[1]]
    }

    /// Position of the last node (m): that with the largest x and y.
    pub fn last_node_position(&self) -> [f64; 2] {
        self.node_position(self.columns - 1, self.rows - 1)
    }

    /// Cell between four nodes that contains a position in plan. It is given by its node with the smallest x and y, with the position
    /// relative to that node in spacings. `None` beyond the outermost nodes.
    #[inline]
    pub fn locate_cell(&self, x: f64, y: f64) -> Option<([usize; 2], [f64; 2])> {
        let (mut cell, mut share) = ([0; 2], [0.0; 2]);
        for (axis, (at, count)) in [(x, self.columns), (y, self.rows)].into_iter().enumerate() {
            let steps = (at - self.origin[axis]) / self.spacing[axis];
            if !(steps >= 0.0 && steps <= (count - 1) as f64) {
                return None;
            }
            cell[axis] = (steps as usize).min(count - 2);
            share[axis] = steps - cell[axis] as f64;
        }
        Some((cell, share))
    }

    /// Value at a position in plan by bilinear interpolation; `None` beyond the outermost nodes or where a node with a weight has no data.
    pub fn interpolate(&self, x: f64, y: f64) -> Option<f64> {
        let ([i, j], [s, t]) = self.locate_cell(x, y)?;
        let terms = [
            (i, j, (1.0 - s) * (1.0 - t)),
            (i + 1, j, s * (1.0 - t)),
            (i, j + 1, (1.0 - s) * t),
            (i + 1, j + 1, s * t),
        ];
        let sum: f64 =
            terms.iter().filter(|(_, _, w)| *w > 0.0).map(|(i, j, w)| w * self.value(*i, *j)).sum();
        sum.is_finite().then_some(sum)
    }

    /// Part of the raster with the nodes in a window of the plan (m).
    ///
    /// # Errors
    /// When the window contains fewer than two nodes along an axis.
    pub fn cropped(&self, low: [f64; 2], high: [f64; 2]) -> Result<Self, RasterError> {
        let counts = [self.columns, self.rows];
        let mut first = [0; 2];
        let mut size = [0; 2];
        for c in 0..2 {
            // A node on the boundary of the window, within round-off, belongs to it.
            let from = ((low[c] - self.origin[c]) / self.spacing[c] - 1e-9).ceil().max(0.0);
            let to =
                ((high[c] - self.origin[c]) / self.spacing[c] + 1e-9).floor().min((counts[c] - 1) as f64);
            if !(to >= from + 1.0) {
                return Err(RasterError::Window { low, high });
            }
            (first[c], size[c]) = (from as usize, (to - from) as usize + 1);
        }
        let row = |j: usize| {
            let start = (first[1] + j) * self.columns + first[0];
            &self.values[start..start + size[0]]
        };
        let values = (0..size[1]).flat_map(row).copied().collect();
        let (columns, rows, origin) = (size[0], size[1], self.node_position(first[0], first[1]));
        Ok(Self { columns, rows, origin, spacing: self.spacing, values, reference: self.reference.clone() })
    }

    /// Raster on nodes of another `spacing` (m) over the same window. A smaller spacing is obtained by bilinear interpolation, and a larger
    /// one by means over the new cells, so that no ridge is missed. There is no data where none is near.
    ///
    /// # Errors
    /// When the spacing is not a length or leaves fewer than two nodes along an axis.
    pub fn resampled(&self, spacing: [f64; 2]) -> Result<Self, RasterError> {
        if !spacing.iter().all(|s| s.is_finite() && *s > 0.0) {
            return Err(RasterError::Spacing { spacing, origin: self.origin });
        }
        let end = self.last_node_position();
        let count = |c: usize| ((end[c] - self.origin[c]) / spacing[c] + 1e-9).floor() as usize + 1;
        let (columns, rows) = (count(0), count(1));
        if columns < 2 || rows < 2 {
            return Err(RasterError::TooFewNodes { columns, rows });
        }
        let parts: [usize; 2] =
            std::array::from_fn(|c| (spacing[c] / self.spacing[c]).ceil().max(1.0) as usize);
        let mean = |x: f64, y: f64| {
            let (mut sum, mut number) = (0.0, 0);
            for k in 0..parts[0] * parts[1] {
                let offset = |c: usize, k: usize| ((k as f64 + 0.5) / parts[c] as f64 - 0.5) * spacing[c];
                // Half cells beyond the boundary take the values of the boundary.
                let px = (x + offset(0, k % parts[0])).clamp(self.origin[0], end[0]);
                let py = (y + offset(1, k / parts[0])).clamp(self.origin[1], end[1]);
                if let Some(value) = self.interpolate(px, py) {
                    (sum, number) = (sum + value, number + 1);
                }
            }
            if number * 2 > parts[0] * parts[1] { sum / f64::from(number as u32) } else { f64::NAN }
        };
        let mut fresh = Self::from_function([columns, rows], self.origin, spacing, mean);
        fresh.reference = self.reference.clone();
        Ok(fresh)
    }

    /// Raster with its origin shifted by `offset` (m).
    pub fn shifted(mut self, offset: [f64; 2]) -> Self {
        (0..2).for_each(|c| self.origin[c] += offset[c]);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane() -> Raster {
        Raster::from_function([11, 6], [100.0, 200.0], [2.0, 3.0], |x, y| 5.0 + 0.5 * x - 0.25 * y)
    }

    #[test]
    fn a_plane_stays_one_between_nodes_in_crops_and_at_other_spacings() {
        let exact = |x: f64, y: f64| 5.0 + 0.5 * x - 0.25 * y;
        let raster = plane();
        let near = |raster: &Raster, x: f64, y: f64| {
            let value = raster.interpolate(x, y).unwrap();
            assert!((value - exact(x, y)).abs() < 1e-9, "{value} at {x}, {y}");
        };
        near(&raster, 107.3, 211.9);
        near(&raster, 120.0, 215.0);
        assert_eq!(raster.interpolate(99.9, 205.0), None);
        let crop = raster.cropped([103.0, 200.0], [111.0, 209.0]).unwrap();
        assert_eq!((crop.columns, crop.rows, crop.origin), (4, 4, [104.0, 200.0]));
        near(&crop, 108.1, 204.0);
        let fine = raster.resampled([0.5, 0.75]).unwrap();
        assert_eq!((fine.columns, fine.rows), (41, 21));
        near(&fine, 101.7, 213.3);
        let coarse = raster.resampled([4.0, 6.0]).unwrap();
        // Away from the boundary, where half of a cell lies outside.
        assert!((coarse.value(2, 1) - exact(108.0, 206.0)).abs() < 1e-9);
        assert!(raster.cropped([500.0, 0.0], [600.0, 1.0]).is_err());
    }

    #[test]
    fn no_data_is_not_interpolated_and_empty_rasters_are_invalid() {
        let mut raster = plane();
        raster.values[14] = f64::NAN;
        assert_eq!(raster.interpolate(107.0, 204.0), None);
        assert!(raster.interpolate(104.0, 203.0).is_some(), "on a node its own value counts alone");
        raster.values.fill(f64::NAN);
        assert_eq!(raster.validate(), Err(RasterError::Empty));
        raster.values.pop();
        assert!(matches!(raster.validate(), Err(RasterError::Count { .. })));
    }
}
