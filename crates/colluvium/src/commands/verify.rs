//! `colluvium verify`.

use std::path::PathBuf;

use clap::Args;
use colluvium::case::run::verify;

use super::run::{MAP, lacks_map};
use super::{Failure, a_run};

#[derive(Args)]
pub struct Arguments {
    /// Folder of a complete run.
    folder: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = &arguments.folder;
    a_run(folder)?;
    let mut verified = verify(folder)?;
    // The runs of a sweep have no maps of their own.
    let in_sweep = folder.parent().is_some_and(|sweep| sweep.join("sweep.json").exists());
    if !in_sweep && lacks_map(folder) {
        verified.problems.push(format!("{MAP}: the run ended without it: `run --resume` draws it"));
    }
    for problem in &verified.problems {
        complain!("error: {}/{problem}", folder.display());
    }
    let (files, wrong) = (verified.files, verified.problems.len());
    if wrong > 0 {
        return Err(Failure::Other(format!("{wrong} of {files} files are not as the run left them")));
    }
    say!("{}: {files} files are as the run left them", folder.display());
    Ok(())
}
