//! `colluvium verify`.

use std::path::PathBuf;

use crate::case::run::verify;
use clap::Args;

use super::run::{MAP_FILE, is_map_missing};
use super::{CommandError, check_run_folder};

#[derive(Args)]
#[command(after_help = "Usual call:\n  colluvium verify slope-mpm")]
pub struct VerifyArguments {
    /// Folder of a complete run.
    folder: PathBuf,
}

/// Compares the files of a run with their checksums.
pub fn run(arguments: &VerifyArguments) -> Result<(), CommandError> {
    let folder = &arguments.folder;
    check_run_folder(folder)?;
    let mut verified = verify(folder)?;
    // The runs of a sweep have no maps.
    let in_sweep = folder.parent().is_some_and(|sweep| sweep.join("sweep.json").exists());
    if !in_sweep && is_map_missing(folder) {
        verified.problems.push(format!("{MAP_FILE}: is missing: `run --resume` draws it"));
    }
    for problem in &verified.problems {
        print_error_line!("error[verify-mismatch]: {}/{problem}", folder.display());
    }
    let (files, wrong) = (verified.files, verified.problems.len());
    if wrong > 0 {
        return Err(CommandError::message(
            "verify-mismatch",
            format!("{wrong} of {files} files differ from those that the run wrote"),
        ));
    }
    print_line!("{}: {files} files are unchanged since the run", folder.display());
    Ok(())
}
