//! Warnings of a run about its state.

use crate::run::progress::RunProgress;
use crate::run::{Run, RunEvent};
use crate::solver::{MissedEquilibrium, TimeStep};
use colluvium_constitutive::Warning;

impl Run<'_> {
    /// Warnings of the run up to the current time.
    pub(crate) fn warnings_so_far(&self) -> Vec<Warning> {
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
    pub(crate) fn note_missed_equilibrium(&mut self, why: &MissedEquilibrium) {
        let remark = Warning::new(
            "no-equilibrium",
            format!("{why}. Give the stage a longer duration or more damping"),
        );
        self.progress.missed_equilibria.push((self.progress.stages.stage, remark.clone()));
        self.report_warning(Some(remark));
    }

    /// Adds the energy balance at the current time to the check of its error.
    fn update_energy_monitor(&mut self) {
        if let Some(budget) = self.solver.budget() {
            self.progress.energy.add_row(&budget, self.solver.time());
        }
    }

    /// Reports a warning while the run goes on.
    fn report_warning(&mut self, warning: Option<Warning>) {
        self.events.extend(warning.map(RunEvent::Warning));
    }
}
