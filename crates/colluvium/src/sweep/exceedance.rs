//! Share of the runs of a sweep that exceed a threshold, cell by cell.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use colluvium_points::Raster;
use colluvium_terrain::{read_raster, write_raster};

use super::{Sweep, SweepCase, SweepRow};
use crate::case::output::{OutputError, create_folder, write_atomically};
use crate::case::{Case, CaseError, CaseErrors};
use crate::output::raster_maps;
use crate::plots::Picture;

/// Name of the folder of these rasters.
pub(super) const RASTER_FOLDER: &str = "rasters";

/// Rasters of a run for which thresholds are possible, with their descriptions and units.
const THRESHOLD_RASTERS: [(&str, &str, &str); 6] = [
    ("peak_thickness_vertical", "peak thickness", "m"),
    ("peak_thickness_normal", "peak thickness", "m"),
    ("final_thickness_vertical", "final thickness", "m"),
    ("final_thickness_normal", "final thickness", "m"),
    ("peak_velocity", "peak velocity", "m/s"),
    ("peak_dynamic_pressure", "peak dynamic pressure", "Pa"),
];

impl Sweep {
    /// Checks the thresholds against the rasters that a case writes.
    pub(super) fn check_exceedance(&self, case: &Case) -> Result<(), CaseErrors> {
        for (name, thresholds) in &self.exceedance {
            let path = format!("exceedance.{name}");
            check_raster_name(case, name).map_err(|problem| CaseError::new(&path, problem))?;
            for (k, threshold) in thresholds.iter().enumerate() {
                let path = format!("{path}[{k}]");
                check_threshold(case, name, *threshold).map_err(|problem| CaseError::new(path, problem))?;
            }
        }
        Ok(())
    }
}

/// Checks the name of a raster with thresholds.
pub(super) fn check_raster_name(case: &Case, name: &str) -> Result<(), String> {
    if !THRESHOLD_RASTERS.iter().any(|(known, ..)| *known == name) {
        let known: Vec<&str> = THRESHOLD_RASTERS.iter().map(|(known, ..)| *known).collect();
        return Err(format!("is not a raster with thresholds; there are {}", known.join(", ")));
    }
    let problem = || "the case writes no rasters: add output.rasters to it".to_owned();
    case.output.rasters.as_ref().map(|_| ()).ok_or_else(problem)
}

/// Checks a threshold of a raster.
pub(super) fn check_threshold(case: &Case, name: &str, threshold: f64) -> Result<(), String> {
    if !(threshold > 0.0 && threshold.is_finite()) {
        return Err(format!("{threshold} must be positive"));
    }
    let smallest = case.output.rasters.as_ref().map_or(0.0, |rasters| rasters.threshold);
    if name.starts_with("peak_thickness") && threshold < smallest {
        return Err(format!("{threshold} m is below output.rasters.threshold, {smallest} m"));
    }
    Ok(())
}

/// Whether two rasters have the same cells.
pub(super) fn have_equal_cells(a: &Raster, b: &Raster) -> bool {
    (a.columns, a.rows, a.origin, a.spacing) == (b.columns, b.rows, b.origin, b.spacing)
}

/// Indices of the complete runs; empty while some runs have not been made.
pub(super) fn complete_runs(rows: &[SweepRow]) -> Vec<usize> {
    let done = rows.iter().all(|row| row.status == "completed" || row.status == "failed");
    (0..rows.len()).filter(|&number| done && rows[number].status == "completed").collect()
}

/// Writes, for each threshold, a raster of the share of the complete runs that reach it. Cells that no run reaches have no data. Writes
/// nothing while runs remain to be done.
///
/// # Errors
/// When a raster cannot be read or written, or two runs have different cells.
pub(super) fn write_exceedance(
    sweep: &Sweep,
    out: &Path,
    members: &[SweepCase],
    rows: &[SweepRow],
    folder: &dyn Fn(usize) -> PathBuf,
) -> Result<(), OutputError> {
    let complete = complete_runs(rows);
    if sweep.exceedance.is_empty() || complete.is_empty() {
        return Ok(());
    }
    let own = out.join(RASTER_FOLDER);
    create_folder(&own)?;
    let mut table = "raster,threshold,unit,runs,of,cells\n".to_owned();
    for (name, thresholds) in &sweep.exceedance {
        let rasters = read_rasters(name, &complete, folder)?;
        let (_, meaning, unit) =
            THRESHOLD_RASTERS.into_iter().find(|(known, ..)| known == name).unwrap_or_default();
        for threshold in thresholds {
            let share =
                rasters.first().map(|first| exceedance_share(first, &rasters, *threshold, complete.len()));
            let share = share.filter(|share| share.values.iter().any(|value| value.is_finite()));
            let cells =
                share.iter().flat_map(|share| &share.values).filter(|value| value.is_finite()).count();
            let _ = writeln!(table, "{name},{threshold},{unit},{},{},{cells}", complete.len(), rows.len());
            let Some(share) = share else { continue };
            let label =
                format!("share of {} runs with {meaning} of {threshold} {unit} or more", complete.len());
            write_sweep_raster(
                &own.join(format!("exceedance-{name}-{threshold}")),
                share,
                &members[complete[0]],
                &sweep.title,
                &label,
            )?;
        }
    }
    write_atomically(&own.join("exceedance.csv"), table.as_bytes())
}

/// Whether a file of the folder has the name of a raster of shares or intensity, of its map or of their table.
pub(super) fn is_raster(name: &str) -> bool {
    let stem =
        name.rsplit_once('.').filter(|(_, ending)| ["asc", "tif", "prj", "png", "csv"].contains(ending));
    stem.is_some_and(|(stem, _)| ["intensity", "exceedance"].iter().any(|own| stem.starts_with(own)))
}

/// Writes a raster in both formats, with its map.
pub(super) fn write_sweep_raster(
    stem: &Path,
    raster: Raster,
    of: &SweepCase,
    title: &str,
    label: &str,
) -> Result<(), OutputError> {
    // Numbers in the name may have a decimal point.
    let file = |ending: &str| PathBuf::from(format!("{}.{ending}", stem.display()));
    for ending in ["asc", "tif"] {
        let file = file(ending);
        write_raster(&file, &raster).map_err(|error| OutputError::new(&file, error.problem))?;
    }
    let picture = file("png");
    let map = raster_maps::raster_map(&of.case, raster, title, label);
    map.map_err(|error| OutputError::new(&picture, error))?.write(&picture)
}

/// Reads the raster of a name of each run. A run in which no cell was reached has none.
fn read_rasters(
    name: &str,
    complete: &[usize],
    folder: &dyn Fn(usize) -> PathBuf,
) -> Result<Vec<Raster>, OutputError> {
    let mut rasters: Vec<Raster> = Vec::new();
    for &number in complete {
        let file = raster_file(name, &folder(number));
        let Some(raster) = read_run_raster(name, &folder(number))? else { continue };
        if rasters.first().is_some_and(|first| !have_equal_cells(first, &raster)) {
            let problem =
                "has other raster cells than the earlier runs: give all runs the same output.rasters.cell";
            return Err(OutputError::coded(&file, "different-rasters", problem));
        }
        rasters.push(raster);
    }
    Ok(rasters)
}

/// Path of a raster in the folder of a run.
fn raster_file(name: &str, folder: &Path) -> PathBuf {
    folder.join(raster_maps::RASTER_FOLDER).join(format!("{name}.asc"))
}

/// Reads the raster of a name from the folder of a run; `None` where it does not exist.
pub(super) fn read_run_raster(name: &str, folder: &Path) -> Result<Option<Raster>, OutputError> {
    let file = raster_file(name, folder);
    let raster = file.exists().then(|| read_raster(&file)).transpose();
    raster.map_err(|error| OutputError::new(&file, error.problem))
}

/// Raster of the share of `runs` that reach a threshold.
fn exceedance_share(first: &Raster, rasters: &[Raster], threshold: f64, runs: usize) -> Raster {
    let share = |cell: usize| {
        let count = rasters.iter().filter(|raster| raster.values[cell] >= threshold).count();
        if count == 0 { f64::NAN } else { count as f64 / runs as f64 }
    };
    Raster { values: (0..first.values.len()).map(share).collect(), ..first.clone() }
}
