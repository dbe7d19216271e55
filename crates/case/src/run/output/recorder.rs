//! Recorder of a run: measures, frames, checkpoints and summary, and the restart from them.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::json;

use crate::measure::{MeasuredState, fields_of_measures};
use crate::output::{
    Collection, FileChecksum, OutputError, Table, WriteOptions, averages, file_extension, read_frame,
    read_json, write_atomically, write_dataset, write_frame,
};
use crate::run::checkpoint::{Checkpoint, checkpoint_error, read_checkpoint};
use crate::run::output::measure_row;
use crate::run::output::run_folder;
use crate::run::output::run_folder::{CASE, CHECKPOINT, COLLECTION, MEASURES, SUMMARY, Tables};
use crate::run::progress::RunProgress;
use crate::run::verify;
use crate::run::{RunError, RunOptions};
use crate::solver::save_value;
use crate::{Case, Dataset, DatasetGeometry, Frame, FrameRequest, Snapshot, Solver, SolverError};

/// Approximate number of rows of the measures over a whole run, where the case gives no interval.
const DEFAULT_ROWS: f64 = 100.0;

/// Whether the time of output number `count` has been reached at `time` (s).
fn is_due(time: f64, count: u64, interval: f64) -> bool {
    time >= count as f64 * interval - 1e-9 * interval
}

/// Snapshot on which measures are evaluated: `points`, or else the first dataset of the frame as points.
fn measured_snapshot<'a>(points: Option<&'a Snapshot>, others: &Frame) -> Cow<'a, Snapshot> {
    match points {
        Some(points) => Cow::Borrowed(points),
        None => Cow::Owned(others.first_as_points().unwrap_or_default()),
    }
}

/// Output at an instant.
#[derive(Default)]
pub(crate) struct RecordedOutput {
    /// Whether a row of the measures was written.
    pub(crate) row: bool,
    /// Frame that was written.
    pub(crate) frame: Option<Frame>,
}

/// Writes measures, frames, checkpoints and the summary of a run.
pub(crate) struct RunRecorder {
    pub(crate) case: Arc<Case>,
    pub(crate) options: Arc<RunOptions>,
    frame_interval: Option<f64>,
    row_interval: f64,
    /// Whether steps end at the times of rows, because the case gives an interval.
    ends_on_rows: bool,
    /// Fields that rows of the measures need.
    measured_fields: Vec<String>,
    /// Tables in the folder of the run.
    pub(crate) tables: Tables,
    /// Table of measures in memory.
    pub(crate) table: Table,
    /// Frames that the report of the run contains.
    pub(crate) kept_frames: Vec<Snapshot>,
    /// States of the solver at the ends of stages, by name.
    states: BTreeMap<String, Arc<Vec<u8>>>,
    /// Fingerprint of the case.
    fingerprint: u64,
    /// Checksums of the files that the case names, by path.
    pub(crate) files: BTreeMap<String, String>,
    /// Lock of the folder against other runs.
    lock: Option<fs::File>,
    /// Reserved space on the disk for the last summary.
    pub(crate) reserved_space: Option<fs::File>,
    /// Names of the raster files written, in the folder of the run.
    pub(crate) rasters: Vec<String>,
}

impl RunRecorder {
    /// Opens the folder for the run.
    pub(crate) fn open(case: Arc<Case>, options: Arc<RunOptions>) -> Result<Self, RunError> {
        let files = case.file_checksums();
        let mut recorder = Self {
            frame_interval: case.output.frames,
            row_interval: case.output.measures.unwrap_or(case.end_time() / DEFAULT_ROWS),
            ends_on_rows: case.output.measures.is_some(),
            measured_fields: fields_of_measures(&case),
            tables: Tables::new(options.output_folder.clone()),
            table: Table::default(),
            kept_frames: Vec::new(),
            states: BTreeMap::new(),
            fingerprint: case.fingerprint_with(&files),
            files,
            lock: None,
            reserved_space: None,
            rasters: Vec::new(),
            case,
            options,
        };
        if let Some(out) = recorder.options.output_folder.clone() {
            recorder.prepare(&out)?;
        }
        Ok(recorder)
    }

    /// Prepares the folder of the run: rejects one with another run, unless the options allow to resume or to overwrite it.
    fn prepare(&mut self, out: &Path) -> Result<(), RunError> {
        let folder =
            |code: &'static str, problem: String| RunError::Folder { path: out.to_owned(), code, problem };
        let running = json!({
            "status": "running", "title": self.case.title, "method": self.options.method, "fingerprint": self.case_fingerprint(),
            "inputs": self.files,
            "version": env!("CARGO_PKG_VERSION"), "commit": self.options.commit, "warnings": self.options.warnings,
        });
        let used = out.join(SUMMARY).exists() || out.join(CHECKPOINT).exists();
        if self.options.resume && !used {
            return Err(folder("no-run-to-resume", "contains no run to resume".to_owned()));
        }
        if used && !self.options.resume && !self.options.overwrite {
            let problem =
                "already contains an earlier run (resume it, overwrite it or choose another folder)";
            return Err(folder("folder-has-run", problem.to_owned()));
        }
        if let Some(name) = run_folder::existing_run_file(out)?.filter(|_| !used) {
            let problem =
                format!("contains {name}, which no run wrote: choose another folder, or move it away");
            return Err(folder("foreign-file", problem));
        }
        self.lock = run_folder::lock(out)?;
        self.reserved_space = run_folder::reserve_space(out, &self.case.to_json());
        if self.options.resume {
            return self.check_resumable(out);
        }
        // Written first, so that files of an old run never look complete, and the files in the folder are known to be those of a run.
        self.write_summary(&running)?;
        if used {
            run_folder::clear(out)?;
        }
        run_folder::create(out)?;
        Ok(self.write_case(out)?)
    }
    fn write_case(&self, out: &Path) -> Result<(), OutputError> {
        write_atomically(&out.join(CASE), self.case.to_json().as_bytes())
    }

    /// Writes the case into the folder where it is missing, because a run was killed or the file was removed.
    pub(crate) fn keep_case(&self, out: &Path) -> Result<(), OutputError> {
        if out.join(CASE).exists() { Ok(()) } else { self.write_case(out) }
    }

    /// Rejects the resume of a complete run, or of another case, before any file is written.
    fn check_resumable(&self, out: &Path) -> Result<(), RunError> {
        let folder = |code, problem: &str| RunError::Folder {
            path: out.to_owned(),
            code,
            problem: problem.to_owned(),
        };
        let path = out.join(SUMMARY);
        let summary = if path.exists() { read_json(&path)? } else { serde_json::Value::Null };
        if summary["status"] == "completed" {
            return Err(folder("run-complete", "contains a complete run: there is nothing to resume"));
        }
        if summary["fingerprint"].as_str().is_some_and(|mark| mark != self.case_fingerprint()) {
            let changed = verify::changed_files(&summary, &self.files);
            if changed.is_empty() {
                return Err(folder("run-of-other-case", "contains a run of another case"));
            }
            let problem = format!("contains a run of the case with other contents of {}", changed.join(", "));
            return Err(folder("input-changed", &problem));
        }
        Ok(())
    }

    /// Fingerprint of the case in a summary.
    pub(crate) fn case_fingerprint(&self) -> String {
        format!("{:016x}", self.fingerprint)
    }

    /// Writes the first row and frame, at time zero.
    pub(crate) fn begin(
        &mut self,
        solver: &dyn Solver,
        progress: &mut RunProgress,
    ) -> Result<RecordedOutput, RunError> {
        progress.start = solver.budget();
        self.output(solver, progress)
    }

    /// Times between rows and between frames at which steps are shortened to end (s).
    fn intervals(&self) -> [f64; 2] {
        let row = if self.ends_on_rows { self.row_interval } else { f64::INFINITY };
        [row, self.frame_interval.unwrap_or(f64::INFINITY)]
    }

    /// Next time of a row or a frame at which a step is to end (s).
    pub(crate) fn next_output(&self, progress: &RunProgress) -> f64 {
        let [row, frame] = self.intervals();
        // Before the first row and frame: infinity times zero is not a number.
        let next = |count: u64, interval: f64| if count == 0 { 0.0 } else { count as f64 * interval };
        next(progress.rows, row).min(next(progress.frames, frame))
    }

    /// Shortest time between two outputs at which steps end (s).
    pub(crate) fn shortest_interval(&self) -> f64 {
        let [row, frame] = self.intervals();
        row.min(frame)
    }

    /// Whether a row of measures is due at `time` (s) in a run whose steps need not end at the row times.
    pub(crate) fn is_unscheduled_row_due(&self, time: f64, progress: &RunProgress) -> bool {
        !self.ends_on_rows && is_due(time, progress.rows, self.row_interval)
    }

    /// Writes the row and the frame whose output times have been reached.
    pub(crate) fn output(
        &mut self,
        solver: &dyn Solver,
        progress: &mut RunProgress,
    ) -> Result<RecordedOutput, RunError> {
        let time = solver.time();
        let row = is_due(time, progress.rows, self.row_interval);
        let frame = match self.frame_interval {
            Some(interval) => is_due(time, progress.frames, interval),
            None => progress.frames == 0,
        };
        if !row && !frame {
            return Ok(RecordedOutput::default());
        }
        let names: Vec<&str> = self.measured_fields.iter().map(String::as_str).collect();
        let wanted = if frame { FrameRequest::Requested } else { FrameRequest::Fields(&names) };
        let mut now = solver.frame(wanted);
        let points = now.take_points();
        if row {
            self.row(solver, points.as_ref(), &now, progress.time_step)?;
            progress.rows += 1;
            // Steps may be longer than the time between rows at which they do not end.
            while !self.ends_on_rows && is_due(time, progress.rows, self.row_interval) {
                progress.rows += 1;
            }
        }
        let mut written = RecordedOutput { row, frame: None };
        if frame {
            written.frame = Some(self.frame(points, now, progress)?);
            progress.frames += 1;
        }
        Ok(written)
    }

    /// Writes the row and the frame at the end, unless they have just been written.
    pub(crate) fn output_last(
        &mut self,
        solver: &dyn Solver,
        progress: &mut RunProgress,
    ) -> Result<RecordedOutput, RunError> {
        let time = solver.time();
        let mut now = solver.frame(FrameRequest::Requested);
        let points = now.take_points();
        let mut written = RecordedOutput::default();
        if self.table.last("time") != Some(time) {
            self.row(solver, points.as_ref(), &now, progress.time_step)?;
            written.row = true;
        }
        if progress.collection.frames.last().map(|(at, _)| *at) != Some(time) {
            written.frame = Some(self.frame(points, now, progress)?);
        }
        Ok(written)
    }

    /// Writes a row of measures, from `points` or else from the first dataset of the frame.
    fn row(
        &mut self,
        solver: &dyn Solver,
        points: Option<&Snapshot>,
        others: &Frame,
        time_step: Option<f64>,
    ) -> Result<(), RunError> {
        let measured = measured_snapshot(points, others);
        let mut readings = measure_row::run_outputs(solver, time_step);
        readings.extend(measure_row::case_outputs(&self.case, solver, &measured));
        if self.table.columns.is_empty() {
            self.table.columns =
                readings.iter().map(|(name, unit, _)| (name.clone(), unit.clone())).collect();
        }
        let row = vec![readings.into_iter().map(|(.., value)| value).collect()];
        self.tables.append(MEASURES, &self.table.columns, &row)?;
        self.table.rows.extend(row);
        Ok(())
    }

    /// Writes a frame with its points and other datasets, and returns it.
    fn frame(
        &mut self,
        points: Option<Snapshot>,
        mut others: Frame,
        progress: &mut RunProgress,
    ) -> Result<Frame, RunError> {
        let case = Arc::clone(&self.case);
        let field_names = case.output.fields.as_deref();
        let compression = self.case.output.compression;
        for dataset in &mut others.datasets {
            if !matches!(dataset.geometry, DatasetGeometry::Mesh(_)) {
                dataset.fields.retain(|field| field_names.is_none_or(|names| names.contains(&field.name)));
            }
        }
        self.profiles(&measured_snapshot(points.as_ref(), &others))?;
        if let Some(points) = &points {
            let on_nodes = |dataset: &Dataset| dataset.name == Dataset::GRID;
            if let Some(cell) = self.case.output.grid.filter(|_| !others.datasets.iter().any(on_nodes)) {
                others.datasets.insert(0, averages(&self.case, cell, points, field_names));
            }
        }
        let number = progress.collection.frames.len();
        let file =
            |dataset: &Dataset| run_folder::frame(&dataset.name, number, file_extension(&dataset.geometry));
        let of_points = points.as_ref().map(|_| run_folder::frame(Collection::POINTS, number, "vtu"));
        // A frame has the name of its first dataset.
        let first = of_points.clone().or_else(|| others.datasets.first().map(file)).unwrap_or_default();
        progress.collection.frames.push((others.time, first));
        progress.frame_steps.push(others.step);
        if let Some(out) = &self.options.output_folder {
            if let (Some(name), Some(points)) = (of_points, &points) {
                let checksum = write_frame(
                    &out.join(&name),
                    points,
                    self.case.origin(),
                    WriteOptions { field_names, compression },
                )?;
                progress.frame_checksums.insert(name, checksum);
            }
            for dataset in &others.datasets {
                let name = file(dataset);
                let checksum = write_dataset(&out.join(&name), dataset, self.case.origin(), compression)?;
                progress.frame_checksums.insert(name, checksum);
            }
            self.write_collections(out, progress)?;
        }
        if self.options.keep_frames {
            let shown = points.clone().or_else(|| others.first_as_points());
            self.kept_frames.extend(shown.map(|shown| shown.on_map(&self.case)));
        }
        if let Some(points) = points {
            others.insert_points(points);
        }
        Ok(others)
    }

    /// Writes the lists of frames with their times, one for each dataset.
    fn write_collections(&self, out: &Path, progress: &RunProgress) -> Result<(), OutputError> {
        progress.collection.write(&out.join(COLLECTION))?;
        let mut beside: BTreeMap<&str, Vec<(usize, &String)>> = BTreeMap::new();
        for file in progress.frame_checksums.keys() {
            if let Some((name, number)) = run_folder::parse_frame_name(file) {
                beside.entry(name).or_default().push((number, file));
            }
        }
        let times = &progress.collection.frames;
        for (name, mut files) in beside {
            files.retain(|(number, file)| times.get(*number).is_some_and(|(_, first)| first != *file));
            if files.is_empty() {
                continue;
            }
            files.sort_unstable();
            let frames = files.into_iter().map(|(number, file)| (times[number].0, file.clone()));
            Collection { frames: frames.collect() }
                .write(&out.join(run_folder::collection_file_name(name)))?;
        }
        Ok(())
    }

    /// Appends the current surface profiles to their tables (m).
    fn profiles(&mut self, snapshot: &Snapshot) -> Result<(), RunError> {
        let columns = [("time", "s"), ("position", "m"), ("height", "m")];
        let columns = columns.map(|(name, unit)| (name.to_owned(), unit.to_owned()));
        let state = MeasuredState::of_points(&self.case, snapshot);
        for (name, measure) in &self.case.measures {
            let Some(heights) = measure.profile(&state) else { continue };
            let rows: Vec<Vec<f64>> =
                heights.into_iter().map(|(x, top)| vec![snapshot.time, x, top]).collect();
            self.tables.append(&run_folder::profile(name), &columns, &rows)?;
        }
        Ok(())
    }

    /// Writes a checkpoint after all rows are synchronised to the disk.
    pub(crate) fn save(&self, solver: &dyn Solver, progress: &RunProgress) -> Result<(), RunError> {
        let Some(out) = &self.options.output_folder else { return Ok(()) };
        let checkpoint = Checkpoint {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            fingerprint: self.fingerprint,
            method: self.options.method.clone(),
            progress: progress.clone(),
            tables: self.tables.sync()?,
        };
        run_folder::write_state(&out.join(CHECKPOINT), |file| {
            save_value(&checkpoint, file)?;
            solver.save(file)
        })
    }

    /// Stores the state of the solver at the end of a stage, in memory and in the folder.
    pub(crate) fn keep_state(&mut self, stage: &str, bytes: Vec<u8>) -> Result<(), RunError> {
        if let Some(path) = self.state_file(stage) {
            run_folder::write_state(&path, |file| Ok(file.write_all(&bytes)?))?;
        }
        self.states.insert(stage.to_owned(), Arc::new(bytes));
        Ok(())
    }

    /// State of the solver at the end of a stage, also of one before a restart, which is read once.
    pub(crate) fn state(&mut self, stage: &str) -> Result<Arc<Vec<u8>>, RunError> {
        if let Some(bytes) = self.states.get(stage) {
            return Ok(Arc::clone(bytes));
        }
        let mut bytes = Vec::new();
        if let Some(path) = self.state_file(stage) {
            let mut file = run_folder::read_state(&path)?;
            file.read_to_end(&mut bytes).map_err(|error| OutputError::new(&path, error))?;
        }
        let bytes = Arc::new(bytes);
        self.states.insert(stage.to_owned(), Arc::clone(&bytes));
        Ok(bytes)
    }

    /// Path of the state at the end of a stage, from which the trials of a search start.
    fn state_file(&self, stage: &str) -> Option<PathBuf> {
        let number = self.case.stages.iter().position(|s| s.name == stage)?;
        Some(self.options.output_folder.as_ref()?.join(run_folder::state(number)))
    }

    /// Reads solver and progress from the checkpoint. `None` where the run ended before its first checkpoint; its files are then removed.
    /// Tables and collection are reset to the checkpoint.
    pub(crate) fn resume(&mut self, solver: &mut dyn Solver) -> Result<Option<RunProgress>, RunError> {
        let Some(out) = &self.options.output_folder else { return Ok(None) };
        let of_run = (self.fingerprint, self.options.method.as_str());
        let Some((checkpoint, mut state)) = read_checkpoint(out, of_run)? else {
            run_folder::clear(out)?;
            run_folder::create(out)?;
            self.keep_case(out)?;
            return Ok(None);
        };
        solver
            .restore(&mut state)
            .map_err(|error: SolverError| checkpoint_error(out, error.code(), error.to_string()))?;
        let progress = checkpoint.progress;
        self.check_frames(out, &progress.frame_checksums)?;
        if self.options.keep_frames {
            self.kept_frames = read_frames(out, &progress)?;
        }
        self.tables.resume(&checkpoint.tables)?;
        let kept: Vec<&str> = checkpoint.tables.iter().map(|(name, _)| name.as_str()).collect();
        run_folder::keep_profiles(out, &kept)?;
        run_folder::remove_partial_files(out)?;
        run_folder::create(out)?;
        self.keep_case(out)?;
        self.table = Table::read(&out.join(MEASURES))?;
        self.write_collections(out, &progress)?;
        Ok(Some(progress))
    }

    /// Rejects a resume with missing or changed frames, which the collection would list although the run did not write them.
    fn check_frames(&self, out: &Path, checksums: &BTreeMap<String, FileChecksum>) -> Result<(), RunError> {
        for (name, checksum) in checksums {
            let path = out.join(name);
            let wrong = match path.exists() {
                false => "missing",
                true if FileChecksum::of_file(&path, None)? != *checksum => "changed",
                true => continue,
            };
            let problem = format!("needs {name}, which is {wrong}: run the case anew");
            return Err(checkpoint_error(out, "frame-missing", problem));
        }
        Ok(())
    }
}

/// Frames of a run before a restart, from their files.
fn read_frames(out: &Path, progress: &RunProgress) -> Result<Vec<Snapshot>, OutputError> {
    let frames = progress.collection.frames.iter().zip(&progress.frame_steps);
    let read = |((time, name), step): (&(f64, String), &u64)| {
        Ok(Snapshot { step: *step, ..read_frame(&out.join(name), *time)? })
    };
    frames.map(read).collect()
}
