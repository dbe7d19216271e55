//! Runs of a case and their results.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use colluvium::case::run::{Run, RunEnd, RunEvent, RunReport, SafetyResult};
use colluvium::case::{Case, PlanRaster, RunOptions, Warning};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::cases::read_case;
use crate::channel::{Channel, Message};
use crate::errors::TaskError;
use crate::frames::{FrameData, RasterData};
use crate::tables::{TableArray, table_array};

/// Interval between two messages about progress.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(100);

/// Case, method and options of a run.
pub struct RunRequest {
    /// JSON text of the case.
    pub text: String,
    /// Folder at which file names in the case start.
    pub folder: PathBuf,
    /// Name of the method.
    pub method: Option<String>,
    /// Folder of the results.
    pub out: Option<PathBuf>,
    /// Whether to continue the run in the folder.
    pub resume: bool,
    /// Whether to replace the run in the folder.
    pub overwrite: bool,
    /// Whether frames are sent.
    pub frames: bool,
    /// Whether the run waits until each frame is taken.
    pub waits: bool,
}

impl RunRequest {
    /// Runs the case to its end or until it is stopped.
    pub fn run(self, channel: &Arc<Channel>) -> Result<RunData, TaskError> {
        let case = Arc::new(read_case(&self.text, &self.folder)?);
        let method = colluvium::select_method(&case, self.method.as_deref())?;
        method.problem_size(&case)?.check_memory(colluvium::machine::free_memory())?;
        channel.send(Message { time: case.end_time(), ..Message::text("begin", method.name().to_owned()) });
        let (plan, solver) = method.plan_and_build(&case)?;
        let warnings = plan.all_warnings(&case);
        warnings.iter().for_each(|warning| channel.warn(warning));
        let options = RunOptions {
            method: method.name().to_owned(),
            output_folder: self.out.clone(),
            resume: self.resume,
            overwrite: self.overwrite,
            // Frames before the checkpoint are those of the files.
            keep_frames: self.resume && self.frames,
            stop_flag: Some(Arc::clone(&channel.stop)),
            commit: colluvium::COMMIT.map(str::to_owned),
            warnings,
            ..RunOptions::default()
        };
        let run = Run::with_plan(Arc::clone(&case), method, solver, options)?;
        self.follow(run, &case, channel)
    }

    /// Follows a run to its end, and sends its messages.
    fn follow(&self, mut run: Run<'_>, case: &Case, channel: &Channel) -> Result<RunData, TaskError> {
        let (mut last, mut frame_count, mut warnings) = (Instant::now(), 0, Vec::new());
        loop {
            let event = match run.advance() {
                Ok(Some(event)) => event,
                Ok(None) => break,
                Err(error) => {
                    let table = run.table().clone();
                    return Err(TaskError::Stopped(
                        Box::new(error),
                        Box::new((table, run.solver().step_count())),
                    ));
                }
            };
            let (time, step) = (run.time(), run.solver().step_count());
            let message = |kind, text| Message { kind, time, step, text, frame: None };
            match event {
                RunEvent::Warning(warning) => {
                    channel.warn(&warning);
                    warnings.push(warning);
                }
                RunEvent::Frame(frame) if self.frames => {
                    frame_count += 1;
                    let message =
                        Message { frame: Some(frame.on_map(case)), ..message("frame", String::new()) };
                    if self.waits { channel.send_and_wait(message) } else { channel.send(message) }
                }
                event if event.search_message().is_some() => {
                    channel.send(message("search", event.search_message().unwrap_or_default()));
                }
                _ if last.elapsed() >= PROGRESS_INTERVAL => {
                    last = Instant::now();
                    channel.send(message("progress", String::new()));
                }
                _ => {}
            }
        }
        let report = run.finish()?;
        Ok(RunData { report: Some(report), frame_count, warnings })
    }
}

/// Results of a run.
#[pyclass(module = "colluvium._native")]
pub struct RunData {
    report: Option<RunReport>,
    /// Number of frames that were sent.
    frame_count: usize,
    /// Warnings that were sent during the run.
    warnings: Vec<Warning>,
}

impl RunData {
    fn report(&self) -> PyResult<&RunReport> {
        self.report.as_ref().ok_or_else(|| PyRuntimeError::new_err("the results were taken before"))
    }
}

/// Name, factor, largest stable and smallest failing factor, and text of a search for a factor of safety.
type SafetyRow = (String, Option<f64>, f64, f64, String);

#[pymethods]
impl RunData {
    /// Whether the run was stopped before its end.
    #[getter]
    fn is_interrupted(&self) -> PyResult<bool> {
        Ok(self.report()?.ending == RunEnd::Interrupted)
    }

    /// Number of steps.
    #[getter]
    fn steps(&self) -> PyResult<u64> {
        Ok(self.report()?.steps)
    }

    /// Wall-clock time (s).
    #[getter]
    fn wall(&self) -> PyResult<f64> {
        Ok(self.report()?.wall)
    }

    /// Codes and texts of the warnings about the results that were not sent during the run.
    #[getter]
    fn warnings(&self) -> PyResult<Vec<(String, String)>> {
        let new = self.report()?.warnings_at_end.iter().filter(|warning| !self.warnings.contains(warning));
        Ok(new.map(|warning| (warning.code.to_string(), warning.text.clone())).collect())
    }

    /// Codes and texts of the notes about the run.
    #[getter]
    fn notes(&self) -> PyResult<Vec<(String, String)>> {
        Ok(self.report()?.notes.iter().map(|note| (note.code.to_string(), note.text.clone())).collect())
    }

    /// Hash of the points at the end.
    #[getter]
    fn hash(&self) -> PyResult<String> {
        Ok(format!("{:016x}", self.report()?.snapshot.hash()))
    }

    /// Names and units of the columns of the measures, and their rows.
    fn measures<'py>(&self, py: Python<'py>) -> PyResult<TableArray<'py>> {
        let table = &self.report()?.table;
        table_array(py, table.columns.clone(), &table.rows)
    }

    /// Name, factor, largest stable and smallest failing factor, and text of each search for a factor of safety. The factor is `None` where
    /// the search is undecided or outside its range.
    #[getter]
    fn safety(&self) -> PyResult<Vec<SafetyRow>> {
        let found = self.report()?.safety.iter();
        let of = |(name, found): (&String, &SafetyResult)| {
            (name.clone(), found.factor(), found.stable_factor, found.failing_factor, found.message())
        };
        Ok(found.map(of).collect())
    }

    /// Rasters at the end.
    #[getter]
    fn rasters(&self) -> PyResult<Vec<RasterData>> {
        let rasters = self.report()?.rasters.iter();
        let of = |PlanRaster { name, unit, raster }: &PlanRaster| RasterData::new(name, unit, raster.clone());
        Ok(rasters.map(of).collect())
    }

    /// Frames from before a restart, which are moved out.
    fn take_earlier_frames(&mut self, py: Python<'_>) -> PyResult<Vec<Py<FrameData>>> {
        let report =
            self.report.as_mut().ok_or_else(|| PyRuntimeError::new_err("the results were taken before"))?;
        let mut frames = std::mem::take(&mut report.frames);
        frames.truncate(frames.len().saturating_sub(self.frame_count));
        frames.into_iter().map(|frame| FrameData::new(py, frame.into())).collect()
    }

    /// Points at the end, which are moved out.
    fn take_last(&mut self, py: Python<'_>) -> PyResult<Py<FrameData>> {
        let report =
            self.report.as_mut().ok_or_else(|| PyRuntimeError::new_err("the results were taken before"))?;
        FrameData::new(py, std::mem::take(&mut report.snapshot).into())
    }
}
