//! Rasters of a run in plan.

use crate::output::{OutputError, create_folder};
use crate::run::output::recorder::RunRecorder;
use crate::run::output::run_folder;
use crate::run::output::run_folder::RASTERS;
use crate::{PlanRaster, Solver};

impl RunRecorder {
    /// Writes the rasters of the case, each as an ESRI ASCII grid and as a GeoTIFF. Rasters without a value are left out.
    pub(crate) fn rasters(&mut self, solver: &dyn Solver) -> Result<(), OutputError> {
        let (Some(out), true) = (&self.options.output_folder, self.case.output.rasters.is_some()) else {
            return Ok(());
        };
        let folder = out.join(RASTERS);
        create_folder(&folder)?;
        let origin = self.case.origin();
        for PlanRaster { name, raster, .. } in solver.rasters() {
            debug_assert!(
                run_folder::is_map(&format!("{name}.asc")),
                "{name}: a map that `--overwrite` does not know"
            );
            let mut raster = raster.shifted([origin[0], origin[1]]);
            // The value for no data must not be a possible value.
            raster.reference.no_data = raster.reference.no_data.filter(|number| *number < 0.0);
            if raster.values.iter().all(|value| value.is_nan()) {
                continue;
            }
            for ending in ["asc", "tif"] {
                let file = folder.join(format!("{name}.{ending}"));
                let written = colluvium_terrain::write_raster(&file, &raster);
                written.map_err(|error| OutputError::new(&file, error.problem))?;
            }
            // The coordinate reference system of the grid is in a file beside it.
            let has_system = raster.reference.epsg.is_some() || raster.reference.crs.is_some();
            let endings = ["asc", "tif"].into_iter().chain(has_system.then_some("prj"));
            self.rasters.extend(endings.map(|ending| format!("{RASTERS}/{name}.{ending}")));
        }
        Ok(())
    }
}
