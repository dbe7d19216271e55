//! Messages of a run to the user.

use std::io::Write;
use std::time::Instant;

use crate::run::progress::RunProgress;
use crate::run::{PROGRESS_INTERVAL, RunError, RunLoop};
use crate::{Advance, TimeStep};

impl RunLoop<'_> {
    /// Warnings of the run up to the current time.
    pub(crate) fn warnings_so_far(&self) -> Vec<String> {
        let RunProgress {
            collapse, warning, energy_warning: grown, energy, missed_equilibria: missed, ..
        } = &self.progress;
        let missed = missed.iter().map(|(_, remark)| remark);
        let warnings = collapse.iter().chain(warning).chain(grown).chain(missed).cloned();
        warnings.chain(energy.warning()).chain(self.solver.warnings_at_end()).collect()
    }

    /// Warns once that the step has become a small part of the first one.
    pub(crate) fn check_step_collapse(&mut self, limit: &TimeStep) {
        let first = *self.progress.first_time_step.get_or_insert(limit.dt);
        if self.progress.collapse.is_some() {
            return;
        }
        self.progress.collapse = limit.collapse(first, self.solver.time());
        self.report_warning(self.progress.collapse.clone());
    }

    /// Reports the first warning of the solver, and monitors its energy. Called at every row.
    pub(crate) fn check_solver_warning(&mut self) {
        if self.progress.energy.is_followed() {
            self.update_energy_monitor();
        }
        if self.progress.warning.is_none() {
            self.progress.warning = self.solver.warning();
            self.report_warning(self.progress.warning.clone());
        }
    }

    /// Starts the energy monitor of a stage, so that changes at its start do not count as growth, and keeps the warning of the previous
    /// stage.
    pub(crate) fn begin_energy(&mut self) {
        let grown = std::mem::take(&mut self.progress.energy).warning();
        self.progress.energy_warning = self.progress.energy_warning.take().or(grown);
        if self.solver.is_isolated() {
            self.update_energy_monitor();
        }
    }

    /// Reports a stage that ended without its optional equilibrium.
    pub(crate) fn note_missed_equilibrium(&mut self, why: &RunError) {
        let remark = why.to_string();
        self.progress.missed_equilibria.push((self.progress.stage, remark.clone()));
        self.report_warning(Some(remark));
    }

    /// Adds the energy balance at the current time to the check of its error.
    fn update_energy_monitor(&mut self) {
        if let Some(budget) = self.solver.budget() {
            self.progress.energy.add_row(&budget, self.solver.time());
        }
    }

    /// Shows the progress of the run, as a bar or as a line every few seconds.
    pub(crate) fn show_progress(&mut self, &Advance { dt, limit }: &Advance) {
        let steps = self.solver.step_count();
        if !self.options.progress || !steps.is_multiple_of(16) {
            return;
        }
        let time = self.solver.time();
        let message = || format!("t = {time:.4} s, step {steps}, dt = {dt:.2e} s ({limit})");
        if !self.progress_bar.is_hidden() {
            self.progress_bar.set_position((time * 1e9) as u64);
            self.progress_bar.set_message(message());
        } else if self.last_progress_line.elapsed() >= PROGRESS_INTERVAL {
            // A file or a pipe gets lines. A failed write does not end the run.
            self.last_progress_line = Instant::now();
            let share = 100.0 * time / self.case.end_time();
            let _ = writeln!(std::io::stderr(), "{share:.0} % of the time, {}", message());
        }
    }

    /// Reports a warning to the user while the run goes on.
    fn report_warning(&mut self, remark: Option<String>) {
        if let (Some(remark), Some(warn)) = (remark, self.options.on_warning) {
            self.progress_bar.suspend(|| warn(&remark));
            self.reported_warnings.push(remark);
        }
    }
}
