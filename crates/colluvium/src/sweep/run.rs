//! Runs of a sweep: several at a time, each in a folder of its own.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use serde_json::Value;
use thiserror::Error;

use super::{Sweep, SweepCase, SweepResults, SweepRow, exceedance, intensity};
use crate::case::output::{OutputError, create_folder, read_json, write_atomically};
use crate::case::run::{RunEnd, verify};
use crate::case::{Case, Method, RunOptions, run_method};
use crate::parallel_runs::run_in_parallel;
use crate::sweep::results_table;

/// Name of the copy of the sweep in its folder.
const SWEEP_FILE: &str = "sweep.json";

/// Options of a sweep.
#[derive(Clone, Debug, Default)]
pub struct SweepOptions {
    /// Folder of all output.
    pub output_folder: PathBuf,
    /// Number of simultaneous runs.
    pub jobs: usize,
    /// Threads of each run.
    pub threads: usize,
    /// Whether to continue the sweep in the folder; complete runs are kept.
    pub resume: bool,
    /// Whether to delete the sweep in the folder.
    pub overwrite: bool,
    /// Flag that stops the runs with checkpoints; another thread sets it.
    pub stop_flag: Arc<AtomicBool>,
    /// Commit of the program, recorded with the results.
    pub commit: Option<String>,
}

/// State of a run of a sweep that has ended.
#[derive(Clone, Debug, PartialEq)]
pub enum SweepRunState {
    /// The run was complete already.
    AlreadyComplete,
    /// The run is complete.
    Completed,
    /// The run was stopped on request.
    Interrupted,
    /// The run failed.
    Failed {
        /// Code of the error.
        code: &'static str,
        /// Text of the error.
        reason: String,
    },
}

impl SweepRunState {
    /// State of a run that failed by an error of a file.
    fn of_output(error: &OutputError) -> Self {
        Self::Failed { code: error.code, reason: error.to_string() }
    }
}

/// Failure of a sweep before its runs.
#[derive(Debug, Error)]
pub enum SweepError {
    /// A file could not be written or read.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The folder cannot be used.
    #[error("{}: {problem}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Reason why it cannot be used.
        problem: String,
    },
    /// The system gives no threads.
    #[error("threads: {0}")]
    Threads(String),
}

impl SweepError {
    /// Stable code of the error, which `docs/messages.md` of the repository explains.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Output(error) => error.code,
            Self::Folder { .. } => "sweep-folder",
            Self::Threads(_) => "no-threads",
        }
    }
}

/// Folder of a run of a sweep with the folder `out`; numbers count from zero.
pub fn run_folder(out: &Path, number: usize) -> PathBuf {
    out.join(format!("run-{:04}", number + 1))
}

/// Whether a name is that of a run folder.
fn is_run_folder(name: &str) -> bool {
    name.strip_prefix("run-")
        .is_some_and(|number| number.len() >= 4 && number.bytes().all(|b| b.is_ascii_digit()))
}

/// Runs all cases of a sweep, `jobs` of them simultaneously. A failure does not stop the others. Writes `runs.csv` after each run, tables
/// and pictures of all at the end; `tell` is called with each run as it ends.
///
/// # Errors
/// When the folder cannot be used, or files or threads cannot be created.
pub fn run_sweep<'a>(
    sweep: &'a Sweep,
    members: &[SweepCase],
    method: &dyn Method,
    options: &SweepOptions,
    tell: &(dyn Fn(usize, &SweepRunState) + Sync),
) -> Result<SweepResults<'a>, SweepError> {
    prepare_folder(sweep, options)?;
    let waiting = |member: &SweepCase| SweepRow {
        values: member.values.clone(),
        status: String::new(),
        reason: None,
        measures: Vec::new(),
        wall_time: 0.0,
    };
    let results = Mutex::new(SweepResults { sweep, rows: members.iter().map(waiting).collect() });
    let work = |number: usize| -> Result<(), SweepError> {
        if options.stop_flag.load(Ordering::Relaxed) {
            return Ok(());
        }
        let (member, out) = (&members[number], run_folder(&options.output_folder, number));
        let state = run_case(method, &member.case, &out, options);
        let row = result_row(&out, member, &state);
        tell(number, &state);
        let mut results = results.lock().unwrap_or_else(PoisonError::into_inner);
        results.rows[number] = row;
        Ok(results.write(&options.output_folder)?)
    };
    run_in_parallel(members.len(), (options.jobs, options.threads), work, SweepError::Threads)?;
    let results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.draw(&options.output_folder, &scalar_measures(members))?;
    let folder_of = |number| run_folder(&options.output_folder, number);
    exceedance::write_exceedance(sweep, &options.output_folder, members, &results.rows, &folder_of)?;
    intensity::write_intensity(sweep, &options.output_folder, members, &results.rows, &folder_of)?;
    Ok(results)
}

/// Names of the measures that have a single column.
fn scalar_measures(members: &[SweepCase]) -> Vec<String> {
    let Some(first) = members.first() else { return Vec::new() };
    first
        .case
        .measures
        .iter()
        .filter(|(_, measure)| measure.is_single_number())
        .map(|(name, _)| name.clone())
        .collect()
}

/// Prepares the folder of the sweep.
fn prepare_folder(sweep: &Sweep, options: &SweepOptions) -> Result<(), SweepError> {
    let out = &options.output_folder;
    let refuse = |problem: &str| Err(SweepError::Folder { path: out.clone(), problem: problem.to_owned() });
    let fail = |error: std::io::Error| OutputError::new(out, error);
    let text = serde_json::to_string_pretty(sweep).map_err(|error| OutputError::new(out, error))?;
    let kept = out.join(SWEEP_FILE);
    let earlier = kept.exists().then(|| fs::read_to_string(&kept)).transpose().map_err(fail)?;
    match earlier {
        Some(earlier) if options.resume && earlier != text => return refuse("contains another sweep"),
        Some(_) if !options.resume && !options.overwrite => {
            return refuse(
                "contains an earlier sweep already (resume it, overwrite it or choose another folder)",
            );
        }
        None if options.resume => return refuse("contains no sweep to resume"),
        Some(earlier) if options.overwrite => remove_earlier_sweep(out, &earlier)?,
        None => {
            let foreign = results_table::TABLE_FILES.iter().find(|name| out.join(name).exists());
            if let Some(name) = foreign {
                return refuse(&format!(
                    "contains {name}, which no sweep wrote: choose another folder, or move the file"
                ));
            }
        }
        _ => {}
    }
    create_folder(out)?;
    Ok(write_atomically(&kept, text.as_bytes())?)
}

/// Removes the runs of an earlier sweep with its tables, pictures and rasters. Other files remain.
fn remove_earlier_sweep(out: &Path, earlier: &str) -> Result<(), OutputError> {
    let earlier: Value = serde_json::from_str(earlier).unwrap_or_default();
    let parameters = earlier["parameters"].as_object().into_iter().flat_map(|all| all.keys());
    let endings: Vec<String> = parameters.map(|name| format!("-{name}.svg")).collect();
    let is_picture = |name: &str| endings.iter().any(|ending| name.ends_with(ending));
    let fail = |error: std::io::Error| OutputError::new(out, error);
    for entry in fs::read_dir(out).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if is_run_folder(&name) && path.join("summary.json").exists() {
            crate::case::run::remove_run(&path)?;
        } else if name == results_table::PICTURE_FOLDER {
            remove_own_files(&path, &is_picture)?;
        } else if name == exceedance::RASTER_FOLDER {
            remove_own_files(&path, &exceedance::is_raster)?;
        } else if results_table::TABLE_FILES.contains(&name.as_str()) {
            fs::remove_file(&path).map_err(fail)?;
        }
    }
    Ok(())
}

/// Removes the files of a folder that `is_own` accepts by name, and the folder if it is empty then.
fn remove_own_files(folder: &Path, is_own: &dyn Fn(&str) -> bool) -> Result<(), OutputError> {
    let fail = |error: std::io::Error| OutputError::new(folder, error);
    let mut is_empty = true;
    for entry in fs::read_dir(folder).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        if path.file_name().is_some_and(|name| is_own(&name.to_string_lossy())) {
            fs::remove_file(&path).map_err(fail)?;
        } else {
            is_empty = false;
        }
    }
    if is_empty { fs::remove_dir(folder).map_err(fail) } else { Ok(()) }
}

/// Runs a case, from its checkpoint if there is one.
fn run_case(method: &dyn Method, case: &Case, out: &Path, options: &SweepOptions) -> SweepRunState {
    let path = out.join("summary.json");
    let begun = path.exists();
    let summary = match begun.then(|| read_json(&path)).transpose() {
        Ok(summary) => summary.unwrap_or_default(),
        Err(error) => return SweepRunState::of_output(&error),
    };
    let same = summary["fingerprint"] == format!("{:016x}", case.fingerprint()).as_str();
    if begun && same && summary["status"] == "completed" {
        return match verify(out) {
            Ok(verified) if verified.problems.is_empty() => SweepRunState::AlreadyComplete,
            Ok(verified) => {
                let problem = format!(
                    "files differ from those that the run wrote ({}): delete this folder to run the case again",
                    verified.problems.join("; ")
                );
                SweepRunState::of_output(&OutputError::coded(out, "run-files-changed", problem))
            }
            Err(error) => SweepRunState::of_output(&error),
        };
    }
    let run = RunOptions {
        method: method.name().to_owned(),
        output_folder: Some(out.to_owned()),
        resume: begun && same,
        overwrite: begun && !same,
        keep_frames: false,
        keep_specimen: false,
        stop_flag: Some(options.stop_flag.clone()),
        observer: None,
        commit: options.commit.clone(),
        warnings: case.warnings(),
    };
    match run_method(method, case, &run) {
        Ok(report) if report.ending == RunEnd::Interrupted => SweepRunState::Interrupted,
        Ok(_) => SweepRunState::Completed,
        Err(error) => SweepRunState::Failed { code: error.code(), reason: error.to_string() },
    }
}

/// Table row of a run that has ended.
fn result_row(out: &Path, member: &SweepCase, state: &SweepRunState) -> SweepRow {
    let failed = |reason: String| SweepRow {
        values: member.values.clone(),
        status: "failed".to_owned(),
        reason: Some(reason),
        measures: Vec::new(),
        wall_time: f64::NAN,
    };
    match (results_table::read_row(out, member.values.clone()), state) {
        // A run that could not begin has no results of its own.
        (Ok(row), SweepRunState::Failed { reason, .. }) => {
            SweepRow { status: "failed".to_owned(), reason: Some(reason.clone()), ..row }
        }
        (Ok(row), _) => row,
        (Err(_), SweepRunState::Failed { reason, .. }) => failed(reason.clone()),
        (Err(error), _) => failed(error.to_string()),
    }
}
