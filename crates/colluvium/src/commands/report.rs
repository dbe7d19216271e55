//! `colluvium report`.

use std::path::PathBuf;

use clap::Args;
use colluvium::pictures::plane;
use colluvium::report::{self, Report, ReportError, ReportOptions};

use super::Failure;

#[derive(Args)]
pub struct Arguments {
    /// Folder of a run, complete or not.
    folder: PathBuf,
    /// Field that colours the points; may be given several times. Displacement and velocity when absent.
    #[arg(long)]
    field: Vec<String>,
    /// Number of frames that are shown.
    #[arg(long, default_value_t = 4)]
    frames: usize,
    /// The two axes seen; xy when absent, and xz in three dimensions with gravity along z.
    #[arg(long, value_parser = ["xy", "xz", "yz"])]
    view: Option<String>,
    /// Replace a `report.html` that no report wrote.
    #[arg(long)]
    overwrite: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let options = ReportOptions {
        fields: arguments.field.clone(),
        frames: arguments.frames,
        plane: plane(&arguments.folder, arguments.view.as_deref())?,
        overwrite: arguments.overwrite,
    };
    let Report { file, missing } =
        report::write(&arguments.folder, &options).map_err(|error| match error {
            ReportError::Output(error) => Failure::Output(error),
            ReportError::NoRun(_) | ReportError::Field { .. } => Failure::Usage(error.to_string()),
            other => Failure::Other(other.to_string()),
        })?;
    for file in missing {
        complain!("warning: {file}");
    }
    say!("wrote {}", file.display());
    Ok(())
}
