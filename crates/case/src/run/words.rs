//! What a run says while it goes on.

use std::io::Write;
use std::time::Instant;

use super::progress::Progress;
use super::{BETWEEN_LINES, Run, RunError};
use crate::{Advance, TimeStep};

impl Run<'_> {
    pub(super) fn remarks_so_far(&self) -> Vec<String> {
        let Progress { collapse, warning, grown, energy, missed, .. } = &self.progress;
        let missed = missed.iter().map(|(_, remark)| remark);
        let said = collapse.iter().chain(warning).chain(grown).chain(missed).cloned();
        said.chain(energy.remark()).chain(self.solver.remarks()).collect()
    }

    /// Says once that the step has become a small part of the first one.
    pub(super) fn watch(&mut self, limit: &TimeStep) {
        let first = *self.progress.first_time_step.get_or_insert(limit.dt);
        if self.progress.collapse.is_some() {
            return;
        }
        self.progress.collapse = limit.collapse(first, self.solver.time());
        self.say(self.progress.collapse.clone());
    }

    /// Says once what the solver warns of, and follows its energy. Asked at every row.
    pub(super) fn listen(&mut self) {
        if self.progress.energy.is_followed() {
            self.take_energy();
        }
        if self.progress.warning.is_none() {
            self.progress.warning = self.solver.warning();
            self.say(self.progress.warning.clone());
        }
    }

    /// A stage begins: what changes with it is no growth, and what grew before is kept in words.
    pub(super) fn begin_energy(&mut self) {
        let grown = std::mem::take(&mut self.progress.energy).remark();
        self.progress.grown = self.progress.grown.take().or(grown);
        if self.solver.is_closed() {
            self.take_energy();
        }
    }

    /// Says that a stage is over that has not come to rest and need not.
    pub(super) fn miss(&mut self, why: &RunError) {
        let remark = why.to_string();
        self.progress.missed.push((self.progress.stage, remark.clone()));
        self.say(Some(remark));
    }

    fn take_energy(&mut self) {
        if let Some(budget) = self.solver.budget() {
            self.progress.energy.take(&budget, self.solver.time());
        }
    }

    /// Shows how far the run has come, as a bar or as a line every few seconds.
    pub(super) fn show(&mut self, &Advance { dt, limit }: &Advance) {
        let steps = self.solver.step_count();
        if !self.options.progress || !steps.is_multiple_of(16) {
            return;
        }
        let time = self.solver.time();
        let message = || format!("t = {time:.4} s, step {steps}, dt = {dt:.2e} s ({limit})");
        if !self.bar.is_hidden() {
            self.bar.set_position((time * 1e9) as u64);
            self.bar.set_message(message());
        } else if self.shown.elapsed() >= BETWEEN_LINES {
            // A file or a pipe gets lines. One that takes none more is no reason to end the run.
            self.shown = Instant::now();
            let share = 100.0 * time / self.case.end_time();
            let _ = writeln!(std::io::stderr(), "{share:.0} % of the time, {}", message());
        }
    }

    fn say(&mut self, remark: Option<String>) {
        if let (Some(remark), Some(warn)) = (remark, self.options.warn) {
            self.bar.suspend(|| warn(&remark));
            self.said.push(remark);
        }
    }
}
