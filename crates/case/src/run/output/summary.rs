//! Summary of a run.

use std::collections::BTreeMap;
use std::fs;

use serde_json::json;

use crate::description::Stage;
use crate::output::{OutputError, write_atomically, write_in_place};
use crate::run::checkpoint::checkpoint_error;
use crate::run::output::recorder::RunRecorder;
use crate::run::output::run_folder::{CHECKPOINT, SUMMARY};
use crate::run::progress::{RunProgress, StepBoundCount};
use crate::run::{RunError, SafetyResult, verify};
use crate::{Budget, Solver};
use colluvium_constitutive::Warning;

impl RunRecorder {
    /// JSON objects of the limits of the time step.
    fn step_limits(&self, progress: &RunProgress) -> Vec<serde_json::Value> {
        progress.step_bounds.iter().map(|bound| bound_to_json(bound, self.case.origin())).collect()
    }

    /// Writes the summary, with wall-clock time (s), factors of safety and warnings about the state.
    pub(crate) fn summary(
        &self,
        status: &str,
        reason: Option<&str>,
        solver: &dyn Solver,
        progress: &RunProgress,
        (wall, safety, remarks): (f64, &BTreeMap<String, SafetyResult>, &[Warning]),
    ) -> Result<(), RunError> {
        let names = self.table.columns.iter().map(|(name, _)| name.clone());
        let last = self.table.rows.last().cloned().unwrap_or_default();
        let measures: serde_json::Map<String, serde_json::Value> =
            names.zip(last).map(|(name, value)| (name, json!(value))).collect();
        let completed = status == "completed";
        let mut summary = json!({
            "status": status,
            "reason": reason,
            "title": self.case.title,
            "method": self.options.method,
            "version": env!("CARGO_PKG_VERSION"),
            "commit": self.options.commit,
            "fingerprint": self.case_fingerprint(),
            "inputs": self.files,
            "wall_time": wall,
            "steps": solver.step_count(),
            "time": solver.time(),
            "points": solver.point_count(),
            "warnings": self.options.warnings,
            "remarks": remarks,
            "facts": solver.notes(),
            "stages": self.stages(progress),
            "time_step_limits": self.step_limits(progress),
            "start": progress.start.map(budget_to_json),
            "measures": measures,
            "case": *self.case,
        });
        if !safety.is_empty() {
            let found: serde_json::Map<String, serde_json::Value> =
                safety.iter().map(|(name, safety)| (name.clone(), safety.to_json())).collect();
            summary["factors_of_safety"] = found.into();
        }
        if completed {
            let tables = self.tables.sync()?;
            if let Some(out) = &self.options.output_folder {
                self.keep_case(out)?;
                let run_checksums = progress.frame_checksums.clone().into_iter().chain(tables).collect();
                summary["files"] =
                    verify::to_json(&verify::file_checksums(out, run_checksums, &self.rasters)?);
            }
            summary["end"] = json!(solver.budget().map(budget_to_json));
            summary["snapshot_hash"] = json!(format!("{:016x}", solver.snapshot().hash()));
        }
        self.write_summary(&summary)?;
        // Removed only now: a run that is killed before resumes from the checkpoint, or is known to be complete.
        let checkpoint = self.options.output_folder.as_ref().map(|out| out.join(CHECKPOINT));
        let over = completed && !solver.has_specimen();
        if let Some(checkpoint) = checkpoint.filter(|checkpoint| over && checkpoint.exists()) {
            fs::remove_file(&checkpoint).map_err(|error| OutputError::new(&checkpoint, error))?;
        }
        Ok(())
    }

    /// Stages that have begun, with the end times of those that have ended.
    fn stages(&self, progress: &RunProgress) -> Vec<serde_json::Value> {
        let stages = self.case.stages.iter().zip(&progress.stages.starts).enumerate();
        let record = |(number, (stage, start)): (usize, (&Stage, &f64))| {
            let end = progress.stage_ends.get(number);
            let rests = stage.equilibrium.is_some()
                && !progress.missed_equilibria.iter().any(|(own, _)| *own == number);
            let ended = if rests { "at rest" } else { "duration over" };
            json!({ "name": stage.name, "start": start, "end": end, "ended": end.map(|_| ended) })
        };
        stages.map(record).collect()
    }

    /// Writes the summary of a run into its folder.
    pub(crate) fn write_summary(&self, summary: &serde_json::Value) -> Result<(), RunError> {
        let Some(out) = &self.options.output_folder else { return Ok(()) };
        let text = serde_json::to_string_pretty(summary)
            .map_err(|error| checkpoint_error(out, "output", error.to_string()))?;
        let path = out.join(SUMMARY);
        let written = write_atomically(&path, text.as_bytes());
        if written.is_err() && summary["status"] == "failed" {
            // On a full disk the summary overwrites the one with the status `running`.
            let _ = write_in_place(&path, &minimal_summary(summary));
        }
        Ok(written?)
    }
}

/// Largest length of the reason in [`minimal_summary`] (characters).
const MAX_REASON: usize = 200;

/// Shortest possible summary, for a run that fails on a full disk.
fn minimal_summary(summary: &serde_json::Value) -> String {
    let reason: String = summary["reason"].as_str().unwrap_or_default().chars().take(MAX_REASON).collect();
    let [method, fingerprint] = ["method", "fingerprint"].map(|key| &summary[key]);
    json!({ "status": "failed", "reason": reason, "method": method, "fingerprint": fingerprint }).to_string()
}

/// JSON object with mass, momentum and energies of the bodies and of their pore liquid.
fn budget_to_json(budget: Budget) -> serde_json::Value {
    let mut all = json!({
        "mass": budget.mass, "momentum": budget.momentum, "angular_momentum": budget.angular_momentum,
        "kinetic_energy": budget.kinetic, "elastic_energy": budget.elastic, "potential_energy": budget.potential,
    });
    if let Some(liquid) = budget.liquid {
        all["liquid"] = json!({
            "mass": liquid.mass, "momentum": liquid.momentum, "kinetic_energy": liquid.kinetic,
            "elastic_energy": liquid.elastic, "potential_energy": liquid.potential,
        });
    }
    all
}

/// JSON object of a limit of the time step: its smallest step, number of steps and point.
fn bound_to_json(bound: &StepBoundCount, origin: [f64; 3]) -> serde_json::Value {
    let StepBoundCount { steps, min_step: smallest, time } = bound;
    let on_map = std::array::from_fn::<f64, 3, _>(|axis| smallest.position[axis] + origin[axis]);
    let place = smallest.point.map(|_| on_map);
    json!({
        "limit": smallest.limit.to_string(), "steps": steps, "least": smallest.dt, "time": time, "point": smallest.point,
        "position": place,
    })
}
