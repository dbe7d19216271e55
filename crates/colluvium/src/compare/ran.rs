//! What a run has left in its folder: a comparison shows what the files hold, whenever they were written.

use std::path::Path;

use serde_json::Value;

use crate::case::output::{Collection, OutputError, Table, read_json};
use crate::case::run::Outcome;
use crate::case::{Case, RunReport, Snapshot};
use crate::pictures;

/// A run that came to its end.
#[derive(Clone, Debug)]
pub struct Ran {
    /// Measures in time.
    pub table: Table,
    /// The frames, at least the first and the last state.
    pub frames: Vec<Snapshot>,
    /// Steps done.
    pub steps: u64,
    /// Points at the end.
    pub points: u64,
    /// Wall-clock time of all sessions (s).
    pub wall: f64,
    /// Kinetic energy at the end (J).
    pub kinetic: f64,
    /// What of the run is worth a word.
    pub remarks: Vec<String>,
    /// Factors of safety by the names of their measures: the largest that was stable, the least that failed, and whether the search
    /// left it undecided between the two.
    pub safety: Vec<(String, [f64; 2], bool)>,
    /// Hash of all bits of the state at the end.
    pub hash: String,
}

/// How far the run of a folder has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    /// There is none, or one of another case.
    Other,
    /// It began.
    Begun,
    /// It is complete.
    Complete,
}

impl State {
    /// That of the run of `case` in `folder`.
    pub(super) fn of(folder: &Path, case: &Case) -> Self {
        let Ok(summary) = read_json(&folder.join("summary.json")) else { return Self::Other };
        match summary["status"].as_str() {
            _ if summary["fingerprint"] != format!("{:016x}", case.fingerprint()).as_str() => Self::Other,
            Some("completed") => Self::Complete,
            _ => Self::Begun,
        }
    }
}

impl Ran {
    /// The run of a report that has kept its frames.
    pub fn of(report: &RunReport) -> Self {
        let safety = report.safety.iter();
        Self {
            table: report.table.clone(),
            frames: report.frames.clone(),
            steps: report.steps,
            points: report.snapshot.ids.len() as u64,
            wall: report.wall,
            kinetic: report.end.kinetic,
            remarks: report.remarks.clone(),
            safety: safety
                .map(|(name, found)| {
                    (name.clone(), [found.stable, found.failed], found.outcome() == Outcome::Undecided)
                })
                .collect(),
            hash: format!("{:016x}", report.snapshot.hash()),
        }
    }

    /// Reads the folder of a run.
    ///
    /// # Errors
    /// When a file is not there or cannot be read.
    pub fn read(folder: &Path) -> Result<Self, OutputError> {
        let summary: Value = read_json(&folder.join("summary.json"))?;
        let collection = Collection::read(&folder.join("frames.pvd"))?;
        let frames: Result<Vec<Snapshot>, OutputError> =
            collection.frames.iter().map(|frame| pictures::frame(folder, frame)).collect();
        let texts = |value: &Value| -> Vec<String> {
            value.as_array().into_iter().flatten().filter_map(Value::as_str).map(str::to_owned).collect()
        };
        let bounds = |found: &Value| {
            [found["stable"].as_f64().unwrap_or(0.0), found["failed"].as_f64().unwrap_or(f64::INFINITY)]
        };
        let safety = summary["factors_of_safety"].as_object().into_iter().flatten();
        Ok(Self {
            table: Table::read(&folder.join("measures.csv"))?,
            frames: frames?,
            steps: summary["steps"].as_u64().unwrap_or(0),
            points: summary["points"].as_u64().unwrap_or(0),
            wall: summary["wall_time"].as_f64().unwrap_or(f64::NAN),
            kinetic: summary["end"]["kinetic_energy"].as_f64().unwrap_or(f64::NAN),
            remarks: texts(&summary["remarks"]),
            safety: safety
                .map(|(name, found)| (name.clone(), bounds(found), found["outcome"] == "undecided"))
                .collect(),
            hash: summary["snapshot_hash"].as_str().unwrap_or_default().to_owned(),
        })
    }

    /// When it came to rest (s): from then on the kinetic energy stays below a hundredth of its largest. `None` where it moves on, or never
    /// moved.
    pub fn rests(&self) -> Option<f64> {
        let energy = self.table.pairs("time", "kinetic_energy")?;
        let most = energy.iter().map(|(_, energy)| *energy).fold(0.0, f64::max);
        let moving = energy.iter().rposition(|(_, energy)| *energy > 0.01 * most)?;
        energy.get(moving + 1).map(|(time, _)| *time)
    }

    /// Point-updates per second of wall-clock time.
    pub fn updates_per_second(&self) -> f64 {
        self.points as f64 * self.steps as f64 / self.wall
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_rests_when_its_energy_stays_low_to_the_end() {
        let ran = |energy: [f64; 5]| Ran {
            table: Table {
                columns: [("time", "s"), ("kinetic_energy", "J")]
                    .map(|(name, unit)| (name.to_owned(), unit.to_owned()))
                    .to_vec(),
                rows: energy.iter().enumerate().map(|(k, energy)| vec![k as f64, *energy]).collect(),
            },
            frames: Vec::new(),
            steps: 0,
            points: 0,
            wall: 0.0,
            kinetic: 0.0,
            remarks: Vec::new(),
            safety: Vec::new(),
            hash: String::new(),
        };
        assert_eq!(ran([0.0, 5.0, 0.01, 1.0, 0.01]).rests(), Some(4.0));
        assert_eq!(ran([0.0, 5.0, 0.01, 0.0, 0.2]).rests(), None);
        assert_eq!(ran([0.0; 5]).rests(), None);
    }
}
