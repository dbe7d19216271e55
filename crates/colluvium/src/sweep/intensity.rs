//! Intensity classes of the runs of a sweep, for each cell.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use colluvium_points::Raster;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::exceedance::{
    RASTER_FOLDER, check_raster_name, check_threshold, complete_runs, have_equal_cells, read_run_raster,
    write_sweep_raster,
};
use super::{Sweep, SweepCase, SweepRow};
use crate::case::CaseErrorKind;
use crate::case::output::{OutputError, PLAIN_NAME_RULE, create_folder, is_plain};
use crate::case::{Case, CaseError, CaseErrors};

/// Intensity class.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IntensityClass {
    /// Name of the class, which is part of the names of files.
    pub name: String,
    /// Conditions for a cell to be of this class, all of them fulfilled in one run: thresholds by the name of the raster, as in
    /// `exceedance`.
    #[serde(rename = "reaches")]
    pub thresholds: BTreeMap<String, f64>,
}

impl Sweep {
    /// Checks the classes against the rasters that a case writes.
    pub(super) fn check_intensities(&self, case: &Case) -> Result<(), CaseErrors> {
        let mut names = BTreeSet::new();
        for (number, class) in self.intensities.iter().enumerate() {
            let path = format!("intensities[{number}]");
            if !is_plain(&class.name) {
                return Err(CaseError::new(format!("{path}.name"), PLAIN_NAME_RULE).into());
            }
            if !names.insert(&class.name) {
                return Err(CaseError::new(
                    format!("{path}.name"),
                    CaseErrorKind::coded("duplicate-name", "is also the name of another class"),
                )
                .into());
            }
            if class.thresholds.is_empty() {
                let problem = "has no threshold: every cell would be of this class";
                return Err(CaseError::new(format!("{path}.reaches"), problem).into());
            }
            for (name, threshold) in &class.thresholds {
                let right =
                    check_raster_name(case, name).and_then(|()| check_threshold(case, name, *threshold));
                right.map_err(|problem| CaseError::new(format!("{path}.reaches.{name}"), problem))?;
            }
        }
        Ok(())
    }
}

/// Writes rasters of intensity classes: the strongest class of any complete run, and for each class the share of the runs of this or a
/// stronger class. Cells without a class have no data. Writes nothing while runs remain to be done.
///
/// # Errors
/// When a raster cannot be read or written, or two runs have different cells.
pub(super) fn write_intensity(
    sweep: &Sweep,
    out: &Path,
    members: &[SweepCase],
    rows: &[SweepRow],
    folder: &dyn Fn(usize) -> PathBuf,
) -> Result<(), OutputError> {
    let complete = complete_runs(rows);
    if sweep.intensities.is_empty() || complete.is_empty() {
        return Ok(());
    }
    let mut found: Option<(Raster, Vec<Vec<u32>>)> = None;
    for &number in &complete {
        let Some((like, classes)) = intensity_raster(sweep, &folder(number))? else { continue };
        let (first, counts) = found
            .get_or_insert_with(|| (like.clone(), vec![vec![0; like.values.len()]; sweep.intensities.len()]));
        if !have_equal_cells(first, &like) {
            let problem =
                "has other raster cells than the earlier runs: give all runs the same output.rasters.cell";
            return Err(OutputError::new(&folder(number), problem));
        }
        for (cell, class) in classes.iter().enumerate() {
            counts[..*class].iter_mut().for_each(|count| count[cell] += 1);
        }
    }
    let Some((first, counts)) = found else { return Ok(()) };
    let own = out.join(RASTER_FOLDER);
    create_folder(&own)?;
    let of = &members[complete[0]];
    let raster = |value: &dyn Fn(usize) -> f64| {
        let some = |value: f64| if value > 0.0 { value } else { f64::NAN };
        Raster { values: (0..first.values.len()).map(|cell| some(value(cell))).collect(), ..first.clone() }
    };
    let strongest = raster(&|cell| counts.iter().filter(|count| count[cell] > 0).count() as f64);
    let names: Vec<String> =
        sweep.intensities.iter().enumerate().map(|(k, class)| format!("{} {}", k + 1, class.name)).collect();
    write_sweep_raster(
        &own.join("intensity"),
        strongest,
        of,
        &sweep.title,
        &format!("intensity: {}", names.join(", ")),
    )?;
    for (class, count) in sweep.intensities.iter().zip(&counts) {
        let share = raster(&|cell| f64::from(count[cell]) / complete.len() as f64);
        let label = format!("share of {} runs with intensity {} or higher", complete.len(), class.name);
        write_sweep_raster(
            &own.join(format!("exceedance-intensity-{}", class.name)),
            share,
            of,
            &sweep.title,
            &label,
        )?;
    }
    Ok(())
}

/// Raster of a run with the index of the strongest class in each cell, from 1 for the first class, and 0 for none. `None` for a run without
/// rasters.
fn intensity_raster(sweep: &Sweep, folder: &Path) -> Result<Option<(Raster, Vec<usize>)>, OutputError> {
    let names: BTreeSet<&String> =
        sweep.intensities.iter().flat_map(|class| class.thresholds.keys()).collect();
    let mut rasters = BTreeMap::new();
    for name in names {
        rasters.extend(read_run_raster(name, folder)?.map(|raster| (name, raster)));
    }
    let Some(like) = rasters.values().next().cloned() else { return Ok(None) };
    let has = |cell: usize, (name, smallest): (&String, &f64)| {
        rasters.get(name).is_some_and(|raster| raster.values[cell] >= *smallest)
    };
    let strongest = |cell: usize| {
        let all = |number: &usize| {
            sweep.intensities[*number].thresholds.iter().all(|threshold| has(cell, threshold))
        };
        (0..sweep.intensities.len()).rev().find(all).map_or(0, |number| number + 1)
    };
    let classes = (0..like.values.len()).map(strongest).collect();
    Ok(Some((like, classes)))
}
