//! A run read back from its folder.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::output::{Collection, OutputError, Table, read_frame, read_json};
use crate::run::checkpoint::last_state;
use crate::run::output::run_folder::{CASE, COLLECTION, MEASURES, SUMMARY};
use crate::run::verify::verify;
use crate::run::{RunError, VerificationResult};
use crate::{Case, Method, Snapshot, Solver};
use colluvium_constitutive::Warning;

/// Status of a run in its folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RunStatus {
    /// In progress, or killed before its end.
    Running,
    /// Complete.
    Completed,
    /// Stopped on request; it can be resumed.
    Interrupted,
    /// Ended by an error.
    Failed {
        /// Text of the error.
        reason: String,
    },
}

/// Run in a folder. Frames are read one by one, on request.
#[derive(Clone, Debug)]
pub struct RecordedRun {
    folder: PathBuf,
    case: Case,
    method: String,
    status: RunStatus,
    warnings: Vec<Warning>,
    table: Table,
    frames: Collection,
}

/// Opens the run in a folder.
///
/// # Errors
/// When the folder contains no run, or a file of it cannot be read.
pub fn open(folder: &Path) -> Result<RecordedRun, OutputError> {
    let path = folder.join(SUMMARY);
    let summary = read_json(&path)?;
    let text = |key: &str| summary[key].as_str().unwrap_or_default().to_owned();
    let status = match summary["status"].as_str() {
        Some("running") => RunStatus::Running,
        Some("completed") => RunStatus::Completed,
        Some("interrupted") => RunStatus::Interrupted,
        Some("failed") => RunStatus::Failed { reason: text("reason") },
        _ => return Err(OutputError::new(&path, "has no known status: it is not the summary of a run")),
    };
    let path = folder.join(CASE);
    let case = Case::load_without_files(&path).map_err(|errors| OutputError::new(&path, errors.first()))?;
    // A run that has just begun has no outputs.
    let table = folder.join(MEASURES);
    let frames = folder.join(COLLECTION);
    Ok(RecordedRun {
        case,
        method: text("method"),
        status,
        warnings: ["warnings", "remarks"]
            .into_iter()
            .flat_map(|key| recorded_warnings(&summary[key]))
            .collect(),
        table: if table.exists() { Table::read(&table)? } else { Table::default() },
        frames: if frames.exists() { Collection::read(&frames)? } else { Collection::default() },
        folder: folder.to_owned(),
    })
}

/// Warnings of a list in a `summary.json`. Those of an earlier version are texts: their code is empty.
pub fn recorded_warnings(list: &Value) -> Vec<Warning> {
    let warning = |value: &Value| match value.as_str() {
        Some(text) => Some(Warning::new("", text)),
        None => serde_json::from_value(value.clone()).ok(),
    };
    list.as_array().into_iter().flatten().filter_map(warning).collect()
}

impl RecordedRun {
    /// Folder of the run.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Case of the run.
    pub fn case(&self) -> &Case {
        &self.case
    }

    /// Name of the method.
    pub fn method(&self) -> &str {
        &self.method
    }

    /// Status of the run.
    pub fn status(&self) -> &RunStatus {
        &self.status
    }

    /// Warnings about the case, and then those of the run.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Measures over time.
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// Times of the frames (s).
    pub fn frame_times(&self) -> impl ExactSizeIterator<Item = f64> {
        self.frames.frames.iter().map(|(time, _)| *time)
    }

    /// Reads the points of a frame, or its first dataset as points; `None` beyond the last frame. Positions are those of the map, with the
    /// origin of the case.
    ///
    /// # Errors
    /// When the file of the frame cannot be read.
    pub fn frame(&self, number: usize) -> Result<Option<Snapshot>, OutputError> {
        let Some((time, name)) = self.frames.frames.get(number) else { return Ok(None) };
        read_frame(&self.folder.join(name), *time).map(Some)
    }

    /// Compares the files of a complete run with the checksums in its summary.
    ///
    /// # Errors
    /// As [`verify`].
    pub fn verify(&self) -> Result<VerificationResult, OutputError> {
        verify(&self.folder)
    }

    /// Solver of the run in the state of its last checkpoint, as [`last_state`].
    ///
    /// # Errors
    /// As [`last_state`].
    pub fn last_state(&self, method: &dyn Method) -> Result<Option<Box<dyn Solver>>, RunError> {
        last_state(&self.folder, method, &self.case)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn warnings_of_a_summary_have_codes_and_those_of_earlier_versions_are_texts() {
        let list = json!([{ "code": "thin-body", "text": "bodies[0].shape: is thin" }, "bodies[1]: is old"]);
        let expected =
            [Warning::new("thin-body", "bodies[0].shape: is thin"), Warning::new("", "bodies[1]: is old")];
        assert_eq!(recorded_warnings(&list), expected);
        assert!(recorded_warnings(&Value::Null).is_empty());
    }
}
