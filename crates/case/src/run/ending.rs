//! End of a run: last output, summary and report.

use crate::run::progress::RunProgress;
use crate::run::{Phase, Run, RunEnd, RunError, RunEvent, RunReport};
use crate::{Budget, PlanRaster};

impl Run<'_> {
    /// Ends the run: writes the last output and the summary.
    pub(super) fn end(&mut self, ending: RunEnd) {
        let status = match ending {
            RunEnd::Completed => "completed",
            RunEnd::Interrupted => "interrupted",
        };
        match self.write_ending(status, None) {
            Ok(()) => {
                self.events.push_back(RunEvent::Ended(ending));
                self.phase = Phase::Ended(ending);
            }
            Err(error) => {
                self.failure = Some(error);
                self.phase = Phase::Failed;
            }
        }
    }

    /// Ends the run by an error.
    pub(super) fn fail(&mut self, error: RunError) {
        let error = self.with_last_output(error);
        // The first error is the reason, also where the summary cannot be written.
        let _ = self.write_ending("failed", Some(&error.to_string()));
        self.failure = Some(error);
        self.phase = Phase::Failed;
    }

    /// Adds the time of the last frame and its name to an error of the solver.
    fn with_last_output(&self, error: RunError) -> RunError {
        let error = match error {
            RunError::Solver(source) => RunError::Solver(source.on_map(self.case.origin())),
            error => error,
        };
        match (error, self.progress.collection.frames.last()) {
            (RunError::Solver(source), Some((time, frame))) => {
                let frame = if self.options.output_folder.is_some() { frame.clone() } else { String::new() };
                RunError::Stopped { source, frame, time: *time }
            }
            (error, _) => error,
        }
    }

    /// Writes the last output, the summary and the warnings at the end of a run.
    fn write_ending(&mut self, status: &str, reason: Option<&str>) -> Result<(), RunError> {
        let completed = status == "completed";
        let last = if completed { self.last_output() } else { Ok(()) };
        self.warnings_at_end = self.warnings_so_far();
        if completed {
            self.warnings_at_end.extend(self.recorder.warnings_of_results());
            let of_searches = self.safety.iter().flat_map(|(name, found)| found.warnings(name));
            self.warnings_at_end.extend(of_searches);
        }
        self.recorder.reserved_space = None;
        match last {
            Ok(()) => self.summary(status, reason, &self.warnings_at_end),
            Err(error) => {
                self.summary("failed", Some(&error.to_string()), &self.warnings_at_end)?;
                Err(error)
            }
        }
    }

    /// Writes the last output of a complete run.
    fn last_output(&mut self) -> Result<(), RunError> {
        let written = self.recorder.output_last(&*self.solver, &mut self.progress)?;
        self.push_output(written);
        if self.solver.has_specimen() {
            // Final state: without wall-clock times the file is identical for the same case.
            self.recorder.save(&*self.solver, &RunProgress { wall: 0.0, ..self.progress.clone() })?;
        }
        Ok(self.recorder.rasters(&*self.solver)?)
    }

    /// Rasters of the solver on the map.
    fn rasters_on_map(&self) -> Vec<PlanRaster> {
        let origin = self.case.origin();
        let on_map =
            |one: PlanRaster| PlanRaster { raster: one.raster.shifted([origin[0], origin[1]]), ..one };
        self.solver.rasters().into_iter().map(on_map).collect()
    }

    /// Results of the run so far; frames and measures are moved into them.
    pub(super) fn report(&mut self) -> RunReport {
        let session = self.start_instant.elapsed().as_secs_f64();
        let steps = self.solver.step_count();
        let updates = (steps - self.first_step) as f64 * self.solver.point_count() as f64;
        let ending = match self.phase {
            Phase::Ended(ending) => ending,
            _ => RunEnd::Interrupted,
        };
        RunReport {
            ending,
            snapshot: self.solver.snapshot().on_map(&self.case),
            table: std::mem::take(&mut self.recorder.table),
            frames: std::mem::take(&mut self.recorder.kept_frames),
            rasters: self.rasters_on_map(),
            start: self.progress.start.unwrap_or(Budget::UNKNOWN),
            end: self.solver.totals(),
            steps,
            warnings_at_end: std::mem::take(&mut self.warnings_at_end),
            notes: self.solver.notes(),
            wall: self.wall(),
            updates_per_second: updates / (session - self.search_time.as_secs_f64()),
            safety: std::mem::take(&mut self.safety),
            failed_trials: std::mem::take(&mut self.failing_points),
            specimen: if self.options.keep_specimen { self.solver.specimen() } else { None },
        }
    }
}
