//! Checkpoint of a run: the file from which an interrupted run continues.

use std::io::Read;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::RunError;
use super::progress::RunProgress;
use crate::output::FileChecksum;
use crate::run::output::run_folder;
use crate::run::output::run_folder::CHECKPOINT;
use crate::solver::restore_value;
use crate::{Case, CaseErrors, Method, Solver};

/// Data of a run in a checkpoint, which precede the state of the solver.
#[derive(Serialize, Deserialize)]
pub(super) struct Checkpoint {
    /// Version of the program that wrote the checkpoint.
    pub(super) version: String,
    /// Hash of the case, which must be unchanged in a restart.
    pub(super) fingerprint: u64,
    /// Name of the method.
    pub(super) method: String,
    /// Progress of the run.
    pub(super) progress: RunProgress,
    /// Checksums of the tables on disk; rows beyond them are written again.
    pub(super) tables: Vec<(String, FileChecksum)>,
}

/// Error about the checkpoint in a folder.
pub(super) fn checkpoint_error(out: &Path, code: &'static str, problem: String) -> RunError {
    RunError::Folder { path: out.join(CHECKPOINT), code, problem }
}

/// Reads the checkpoint of a run. Returns the data of the run and a reader that is positioned at the state of the solver; `None` without a
/// checkpoint.
pub(super) fn read_checkpoint(
    out: &Path,
    (fingerprint, method): (u64, &str),
) -> Result<Option<(Checkpoint, impl Read + use<>)>, RunError> {
    let path = out.join(CHECKPOINT);
    if !path.exists() {
        return Ok(None);
    }
    let mut file = run_folder::read_state(&path)?;
    let checkpoint: Checkpoint =
        restore_value(&mut file).map_err(|error| checkpoint_error(out, error.code(), error.to_string()))?;
    if checkpoint.fingerprint != fingerprint {
        return Err(checkpoint_error(
            out,
            "other-case-checkpoint",
            "was written for another case".to_owned(),
        ));
    }
    if checkpoint.method != method || checkpoint.version != env!("CARGO_PKG_VERSION") {
        let problem = format!("was written by {} of version {}", checkpoint.method, checkpoint.version);
        return Err(checkpoint_error(out, "other-version-checkpoint", problem));
    }
    Ok(Some((checkpoint, file)))
}

/// Returns the solver in the state of the last checkpoint of a run. After a complete run only methods with [specimens](Solver::specimen)
/// have one, that at the end. `None` without a checkpoint.
///
/// # Errors
/// When the case cannot be built, and when the checkpoint is damaged, of another case, method or version.
pub fn last_state(out: &Path, method: &dyn Method, case: &Case) -> Result<Option<Box<dyn Solver>>, RunError> {
    let Some((checkpoint, mut state)) = read_checkpoint(out, (case.fingerprint(), method.name()))? else {
        return Ok(None);
    };
    let mut solver = method.build(case).map_err(CaseErrors::from_error)?;
    solver.restore(&mut state).map_err(|error| checkpoint_error(out, error.code(), error.to_string()))?;
    let progress = checkpoint.progress;
    if progress.has_begun {
        solver.resume_stage(progress.stages.stage, progress.stages.start())?;
    }
    Ok(Some(solver))
}
