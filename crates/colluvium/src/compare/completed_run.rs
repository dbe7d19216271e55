//! Results of a completed run, read from the files of its folder, whenever they were written.

use std::path::Path;

use serde_json::Value;

use crate::case::Warning;
use crate::case::output::{Collection, OutputError, Table, read_json};
use crate::case::run::SearchOutcome;
use crate::case::run::recorded_warnings;
use crate::case::{Case, RunReport, Snapshot};
use crate::output::run_pictures;

/// Results of a run that reached its end.
#[derive(Clone, Debug)]
pub struct CompletedRun {
    /// Measures over time.
    pub measures: Table,
    /// Frames, at least of the first and the last state.
    pub frames: Vec<Snapshot>,
    /// Number of steps.
    pub steps: u64,
    /// Number of points at the end.
    pub points: u64,
    /// Wall-clock time of all sessions (s).
    pub wall_time: f64,
    /// Kinetic energy at the end (J).
    pub kinetic_energy: f64,
    /// Warnings of the run.
    pub warnings: Vec<Warning>,
    /// Factors of safety by the names of their measures. Each has the largest stable factor, the least failing factor, and whether the
    /// search was undecided between them.
    pub safety_factors: Vec<(String, [f64; 2], bool)>,
    /// Hash of all bits of the state at the end.
    pub state_hash: String,
}

/// Progress of the run in a folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RunFolderState {
    /// No run, or that of another case.
    NoMatchingRun,
    /// A run that has begun.
    Incomplete,
    /// A complete run.
    Complete,
}

impl RunFolderState {
    /// Progress of the run of `case` in `folder`.
    pub(super) fn of_folder(folder: &Path, case: &Case) -> Self {
        let Ok(summary) = read_json(&folder.join("summary.json")) else { return Self::NoMatchingRun };
        match summary["status"].as_str() {
            _ if summary["fingerprint"] != format!("{:016x}", case.fingerprint()).as_str() => {
                Self::NoMatchingRun
            }
            Some("completed") => Self::Complete,
            _ => Self::Incomplete,
        }
    }
}

impl CompletedRun {
    /// Results from the report of a run that kept its frames.
    pub fn from_report(report: &RunReport) -> Self {
        let safety = report.safety.iter();
        Self {
            measures: report.table.clone(),
            frames: report.frames.clone(),
            steps: report.steps,
            points: report.snapshot.ids.len() as u64,
            wall_time: report.wall,
            kinetic_energy: report.end.kinetic,
            warnings: report.warnings_at_end.clone(),
            safety_factors: safety
                .map(|(name, found)| {
                    (
                        name.clone(),
                        [found.stable_factor, found.failing_factor],
                        found.outcome() == SearchOutcome::Undecided,
                    )
                })
                .collect(),
            state_hash: format!("{:016x}", report.snapshot.hash()),
        }
    }

    /// Reads the folder of a run.
    ///
    /// # Errors
    /// When a file is missing or unreadable.
    pub fn read(folder: &Path) -> Result<Self, OutputError> {
        let summary: Value = read_json(&folder.join("summary.json"))?;
        let collection = Collection::read(&folder.join("frames.pvd"))?;
        let frames: Result<Vec<Snapshot>, OutputError> = collection
            .frames
            .iter()
            .map(|frame| run_pictures::read_collection_frame(folder, frame))
            .collect();
        let bounds = |found: &Value| {
            [found["stable"].as_f64().unwrap_or(0.0), found["failed"].as_f64().unwrap_or(f64::INFINITY)]
        };
        let safety = summary["factors_of_safety"].as_object().into_iter().flatten();
        Ok(Self {
            measures: Table::read(&folder.join("measures.csv"))?,
            frames: frames?,
            steps: summary["steps"].as_u64().unwrap_or(0),
            points: summary["points"].as_u64().unwrap_or(0),
            wall_time: summary["wall_time"].as_f64().unwrap_or(f64::NAN),
            kinetic_energy: summary["end"]["kinetic_energy"].as_f64().unwrap_or(f64::NAN),
            warnings: recorded_warnings(&summary["remarks"]),
            safety_factors: safety
                .map(|(name, found)| (name.clone(), bounds(found), found["outcome"] == "undecided"))
                .collect(),
            state_hash: summary["snapshot_hash"].as_str().unwrap_or_default().to_owned(),
        })
    }

    /// Time from which the kinetic energy stays below a hundredth of its largest value (s). `None` where the run keeps moving or never
    /// moved.
    pub fn time_at_rest(&self) -> Option<f64> {
        let energy = self.measures.pairs("time", "kinetic_energy")?;
        let largest = energy.iter().map(|(_, energy)| *energy).fold(0.0, f64::max);
        let moving = energy.iter().rposition(|(_, energy)| *energy > 0.01 * largest)?;
        energy.get(moving + 1).map(|(time, _)| *time)
    }

    /// Point-updates per second of wall-clock time.
    pub fn updates_per_second(&self) -> f64 {
        self.points as f64 * self.steps as f64 / self.wall_time
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_at_rest_when_its_energy_remains_low_to_the_end() {
        let ran = |energy: [f64; 5]| CompletedRun {
            measures: Table {
                columns: [("time", "s"), ("kinetic_energy", "J")]
                    .map(|(name, unit)| (name.to_owned(), unit.to_owned()))
                    .to_vec(),
                rows: energy.iter().enumerate().map(|(k, energy)| vec![k as f64, *energy]).collect(),
            },
            frames: Vec::new(),
            steps: 0,
            points: 0,
            wall_time: 0.0,
            kinetic_energy: 0.0,
            warnings: Vec::new(),
            safety_factors: Vec::new(),
            state_hash: String::new(),
        };
        assert_eq!(ran([0.0, 5.0, 0.01, 1.0, 0.01]).time_at_rest(), Some(4.0));
        assert_eq!(ran([0.0, 5.0, 0.01, 0.0, 0.2]).time_at_rest(), None);
        assert_eq!(ran([0.0; 5]).time_at_rest(), None);
    }
}
