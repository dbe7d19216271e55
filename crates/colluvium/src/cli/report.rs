//! `colluvium report`.

use std::path::PathBuf;

use crate::output::run_pictures::view_plane;
use crate::report::{self, Report, ReportError, ReportOptions};
use clap::Args;

use super::{CommandError, LibraryArguments, print_warning};

#[derive(Args)]
#[command(after_help = "Usual call:\n  colluvium report slope-mpm")]
pub struct ReportArguments {
    /// Folder of a run, complete or not.
    folder: PathBuf,
    /// Field that colours the points; may be given several times. By default displacement and velocity.
    #[arg(long)]
    field: Vec<String>,
    /// Number of frames that are shown.
    #[arg(long, default_value_t = 4)]
    frames: usize,
    /// Axes of the view; by default xy, and xz in three dimensions with gravity along z.
    #[arg(long, value_parser = ["xy", "xz", "yz"])]
    view: Option<String>,
    /// Replace a `report.html` that no report wrote.
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    pub library: LibraryArguments,
}

/// Writes the report of a run.
pub fn run(arguments: &ReportArguments) -> Result<(), CommandError> {
    let options = ReportOptions {
        fields: arguments.field.clone(),
        frames: arguments.frames,
        plane: view_plane(&arguments.folder, arguments.view.as_deref())?,
        overwrite: arguments.overwrite,
    };
    let Report { file, missing_files: missing } =
        report::write(&arguments.folder, &options).map_err(|error| match error {
            ReportError::Output(error) => CommandError::Output(error),
            ReportError::NoRun(_) => CommandError::usage("not-a-run-folder", error.to_string()),
            ReportError::Field { .. } => CommandError::usage("field-missing", error.to_string()),
            other => CommandError::message(other.code(), other.to_string()),
        })?;
    missing.iter().for_each(print_warning);
    print_line!("wrote {}", file.display());
    Ok(())
}
