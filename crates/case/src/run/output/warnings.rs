//! Warnings of a run about its state and its results.

use crate::description::{Body, Domain};
use crate::measure::{Front, Measure};
use crate::run::output::recorder::RunRecorder;
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

/// Kinetic energy at the end over the largest one, above which a run-out is not final.
const MOVING_SHARE: f64 = 0.05;

/// Distance of a front beyond a side over the size of the domain, at which the front lies at the side. A flow over terrain passes farther
/// beyond the domain, which does not limit it.
const AT_SIDE: std::ops::RangeInclusive<f64> = -5e-3..=5e-2;

impl RunRecorder {
    /// Warnings about the results of a complete run.
    pub(crate) fn warnings_of_results(&self) -> Vec<Warning> {
        let mut warnings = self.probes_without_points();
        warnings.extend(self.fronts_at_walls());
        warnings.extend(self.moving_run_outs());
        warnings
    }

    /// Fronts of soil that have reached a side of the domain, which limits the run-out.
    fn fronts_at_walls(&self) -> Vec<Warning> {
        let is_liquid = |body: &Body| self.case.materials[&body.material].is_fluid();
        if self.case.bodies.iter().all(is_liquid) {
            return Vec::new();
        }
        let reached = |(name, measure): (&String, &Measure)| {
            let Measure::Front(Front { side, .. }) = measure else { return None };
            let (axis, Domain { min, max, .. }) = (side.axis(), &self.case.domain);
            let end = if side.is_max() { max[axis] } else { min[axis] } + self.case.origin()[axis];
            let outwards = if side.is_max() { 1.0 } else { -1.0 };
            let front = self.table.last(name)?;
            let beyond = outwards * (front - end) / (max[axis] - min[axis]);
            AT_SIDE.contains(&beyond).then(|| {
                let text = format!(
                    "measures.{name}: the front has reached the side {side} of the domain, at {end} m, which limits \
                     the run-out. Make the domain longer"
                );
                Warning::new("front-at-domain-side", text)
            })
        };
        self.case.measures.iter().filter_map(reached).collect()
    }

    /// Run-outs of a mass that still moves at the end.
    fn moving_run_outs(&self) -> Option<Warning> {
        let measures = self.case.measures.iter();
        let (name, _) = measures.into_iter().find(|(_, measure)| matches!(measure, Measure::RunOut(_)))?;
        let energies = self.table.column("kinetic_energy")?;
        let (last, largest) = (*energies.last()?, energies.iter().copied().fold(0.0, f64::max));
        (last > MOVING_SHARE * largest).then(|| {
            let text = format!(
                "measures.{name}: the mass still moves at the end, with {:.0} % of its largest kinetic energy, so that \
                 the run-out is not final. Give the last stage a longer duration",
                100.0 * last / largest
            );
            Warning::new("run-out-not-final", text)
        })
    }

    /// Probes that no point has reached.
    fn probes_without_points(&self) -> Vec<Warning> {
        let sees = |name: &str| {
            let own = |column: &str| column.strip_prefix(name).is_some_and(|rest| rest.starts_with('.'));
            let own: Vec<usize> =
                (0..self.table.columns.len()).filter(|&k| own(&self.table.columns[k].0)).collect();
            self.table.rows.iter().any(|row| own.iter().any(|&k| row[k].is_finite()))
        };
        let probes = self.case.measures.iter().filter(|(_, measure)| measure.has_empty_radius());
        let blind = probes.filter(|(name, _)| !sees(name));
        let cure = "Move the probe, or give a larger radius";
        let text = |name: &String| format!("measures.{name}: no point came within its radius. {cure}");
        blind.map(|(name, _)| Warning::new("probe-without-points", text(name))).collect()
    }
}
