//! Cells of the output rasters in plan view.

use colluvium_points::{Georeference, Raster};

use crate::CaseErrorKind;
use crate::description::Rasters;
use crate::{Case, CaseError};

/// Largest number of cells of a raster: more fill the memory of a small machine.
const MAX_CELLS: f64 = 5e7;

impl Case {
    /// Output rasters of the case in plan view.
    ///
    /// # Errors
    /// Where the space has no plan view.
    pub fn plan_rasters(&self) -> Result<Option<&Rasters>, CaseError> {
        if self.output.rasters.is_some() && self.dimension() != 3 {
            let problem =
                CaseErrorKind::coded("wrong-dimension", "a profile has no plan: rasters need a space of 3d");
            return Err(CaseError::new("output.rasters", problem));
        }
        Ok(self.output.rasters.as_ref())
    }
}

impl Rasters {
    /// Creates square cells of width `cell` (m) from the corner `low` to the corner `high` (m), without values.
    ///
    /// # Errors
    /// For more cells than fit into memory.
    pub fn raster_grid(
        low: [f64; 2],
        high: [f64; 2],
        cell: f64,
        reference: Georeference,
    ) -> Result<Raster, CaseError> {
        let count = [0, 1].map(|c| ((high[c] - low[c]) / cell - 1e-9).ceil());
        if !(count[0] * count[1] <= MAX_CELLS) {
            let problem =
                format!("{cell} m gives {:.0e} cells, more than {MAX_CELLS:.0e}", count[0] * count[1]);
            return Err(CaseError::new("output.rasters.cell", problem));
        }
        let [columns, rows] = count.map(|count| count.max(2.0) as usize);
        let origin = low.map(|x| x + 0.5 * cell);
        Ok(Raster { columns, rows, origin, spacing: [cell; 2], values: Vec::new(), reference })
    }
}
