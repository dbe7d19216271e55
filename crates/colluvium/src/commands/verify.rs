//! `colluvium verify`.

use std::path::PathBuf;

use clap::Args;
use colluvium::case::run::verify;

use super::{Failure, a_run};

#[derive(Args)]
pub struct Arguments {
    /// Folder of a complete run.
    folder: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = &arguments.folder;
    a_run(folder)?;
    let verified = verify(folder)?;
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
