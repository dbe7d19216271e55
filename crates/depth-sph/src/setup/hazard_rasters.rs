//! Cells of the hazard rasters of a case.

use colluvium_case::description::Rasters;
use colluvium_case::{Case, CaseError, CaseErrorKind};
use colluvium_points::{Georeference, Raster};

use crate::output::hazard_rasters::{HazardRasters, PlanCells};
use crate::setup::bed::case_bed::CaseBed;
use colluvium_case::Warning;

/// Tolerance of areas for round-off, as a share of the area.
const NEGLIGIBLE: f64 = 1e-6;

/// Hazard rasters of a case, on the cells of the terrain or on cells of a given width.
pub fn hazard_rasters<const D: usize>(
    case: &Case,
    ground: &CaseBed<D>,
    spacing: f64,
    warnings: &mut Vec<Warning>,
) -> Result<Option<HazardRasters>, CaseError> {
    let Some(rasters) = case.plan_rasters()? else { return Ok(None) };
    let own = ground.grid.as_ref().filter(|_| rasters.cell.is_none());
    let grid = match own {
        Some(grid) => grid.clone(),
        None => cells_of_width(case, ground.grid.as_ref(), rasters.cell.unwrap_or(spacing))?,
    };
    let mut maps = HazardRasters::new(grid, rasters.threshold, &ground.bed);
    if let Some(file) = &rasters.mapped_outline {
        /// Path of the option in case files.
        const KEY: &str = "output.rasters.mapped";
        let outline = case.outline(file);
        let beyond = maps.compare(&outline.map_err(|problem| CaseError::new(KEY, problem))?);
        if beyond > 1.0 - NEGLIGIBLE {
            return Err(CaseError::new(
                KEY,
                CaseErrorKind::coded_file(file, "outside-domain", "lies outside the terrain"),
            ));
        }
        if beyond > NEGLIGIBLE {
            warnings.push(Warning::new(
                "outline-outside-terrain",
                format!(
                    "{KEY}: {:.1} % of the outline's area lies outside the terrain and counts as missed \
                 (`mapped_missed`). Use a larger terrain, or cut the outline",
                    100.0 * beyond
                ),
            ));
        }
    }
    Ok(Some(maps))
}

/// Raster cells of a given width over the terrain or the domain.
fn cells_of_width(case: &Case, terrain: Option<&PlanCells>, cell: f64) -> Result<PlanCells, CaseError> {
    let (low, high): ([f64; 2], [f64; 2]) = match terrain {
        Some(grid) => {
            let low = std::array::from_fn(|c| grid.origin[c] - 0.5 * grid.spacing[c]);
            (low, std::array::from_fn(|c| low[c] + grid.counts[c] as f64 * grid.spacing[c]))
        }
        None => (std::array::from_fn(|c| case.domain.min[c]), std::array::from_fn(|c| case.domain.max[c])),
    };
    let reference = terrain.map_or_else(Georeference::default, |grid| grid.reference.clone());
    let Raster { columns, rows, origin, spacing, reference, .. } =
        Rasters::raster_grid(low, high, cell, reference)?;
    Ok(PlanCells { counts: [columns, rows], origin, spacing, reference })
}
