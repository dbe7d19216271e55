//! The command line: [`main`], and the commands, one file each.

/// Prints a line and passes a failure on.
macro_rules! print_line {
    ($($part:tt)*) => { $crate::cli::write_stdout(format_args!($($part)*))? };
}

/// Prints a line on standard error. A failure to print is ignored.
macro_rules! print_error_line {
    ($($part:tt)*) => { $crate::cli::write_stderr(format_args!($($part)*)) };
}

mod check;
mod command_line;
mod compare;
mod completions;
mod element_test;
mod explain;
mod export;
mod file_kind;
mod fit;
mod new;
mod plot;
mod report;
mod run;
mod schema;
mod specimen;
mod sweep;
mod verify;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

pub use crate::cli::command_line::{exit_code, main};

use crate::MethodChoiceError;
use crate::case::output::OutputError;
use crate::case::{CaseError, CaseErrors, RunError, Warning};
use crate::case::{printable, shortened};
use crate::compare::CompareError;
use crate::fit::FitError;
use crate::machine;
use crate::sweep::SweepError;
use clap::Args;
use thiserror::Error;

/// Prints a line, with control characters and colours escaped. Ends the program silently where nobody reads on, as behind `head`.
fn write_stdout(line: std::fmt::Arguments<'_>) -> Result<(), CommandError> {
    match writeln!(std::io::stdout().lock(), "{}", escape_lines(&line.to_string())) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => std::process::exit(0),
        written => {
            written.map_err(|error| CommandError::message("output", format!("standard output: {error}")))
        }
    }
}

/// Text with control characters escaped for a terminal.
fn escape_lines(text: &str) -> String {
    text.split('\n').map(printable).collect::<Vec<_>>().join("\n")
}

/// Prints a line on standard error, if possible. Control characters and colours are escaped; the middle of an overlong line is left out.
pub fn write_stderr(line: std::fmt::Arguments<'_>) {
    let _ = writeln!(std::io::stderr().lock(), "{}", shortened(&printable(&line.to_string())));
}

/// Prints a warning with its code on standard error.
pub fn print_warning(warning: &Warning) {
    print_error_line!("{}", warning.line("warning"));
}

/// Prints a note with its code on standard error.
fn print_note(note: &Warning) {
    print_error_line!("{}", note.line("note"));
}

/// Failure of a command, which determines its exit code.
#[derive(Debug, Error)]
pub enum CommandError {
    /// The case file is wrong.
    #[error(transparent)]
    Case(#[from] CaseErrors),
    /// The run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The sweep could not go on.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// The results of a fit could not be written.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// There is no comparison.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// A file could not be written or read.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The arguments do not make sense.
    #[error("{text}")]
    Usage {
        /// Code of the problem.
        code: &'static str,
        /// Description of the problem.
        text: String,
    },
    /// Anything else that went wrong while running.
    #[error("{text}")]
    Message {
        /// Code of the problem.
        code: &'static str,
        /// Description of the problem.
        text: String,
    },
    /// The run was interrupted.
    #[error("interrupted; continue with --resume")]
    Interrupted,
}

impl From<CaseError> for CommandError {
    fn from(error: CaseError) -> Self {
        Self::Case(error.into())
    }
}

impl From<MethodChoiceError> for CommandError {
    fn from(error: MethodChoiceError) -> Self {
        match error {
            MethodChoiceError::Case(error) => error.into(),
            MethodChoiceError::Several { .. } => Self::usage(error.code(), format!("{error} with --method")),
            MethodChoiceError::Unknown { .. } => Self::usage(error.code(), error.to_string()),
        }
    }
}

impl CommandError {
    /// Wrong arguments, with the code of the problem.
    pub fn usage(code: &'static str, text: impl Into<String>) -> Self {
        Self::Usage { code, text: text.into() }
    }

    /// Failure while running, with its code.
    pub fn message(code: &'static str, text: impl Into<String>) -> Self {
        Self::Message { code, text: text.into() }
    }

    /// Codes and texts of the errors, one line each.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        if let Self::Case(errors) | Self::Run(RunError::Case(errors)) = self {
            return errors.0.iter().map(|error| (error.code(), error.to_string())).collect();
        }
        let code = match self {
            Self::Case(errors) => errors.first().code(),
            Self::Run(error) => error.code(),
            Self::Sweep(error) => error.code(),
            Self::Compare(error) => error.code(),
            Self::Fit(error) => error.code(),
            Self::Output(error) => error.code,
            Self::Usage { code, .. } | Self::Message { code, .. } => code,
            Self::Interrupted => "interrupted",
        };
        self.to_string().lines().map(|line| (code, line.to_owned())).collect()
    }

    /// The exit code.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Case(_) | Self::Run(RunError::Case(_)) | Self::Compare(CompareError::NoMethod(_)) => 3,
            Self::Usage { .. } | Self::Compare(CompareError::UnknownMethod { .. }) => 2,
            Self::Run(_)
            | Self::Sweep(_)
            | Self::Fit(_)
            | Self::Compare(_)
            | Self::Output(_)
            | Self::Message { .. } => 1,
            Self::Interrupted => 4,
        }
    }
}

/// Returns the flag that Ctrl-C sets, so that a run stops with a checkpoint.
fn stop_on_interrupt() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let handler = stop.clone();
    // Without a handler Ctrl-C ends the run at once; the checkpoint on disk is valid either way.
    let _ = ctrlc::set_handler(move || handler.store(true, Ordering::Relaxed));
    stop
}

/// Content of a file of a run; where it cannot be read, the default value with a warning. For an unreadable file, prints a warning with the
/// consequence `without` and returns the default.
fn or_default_with_warning<T: Default>(read: Result<T, OutputError>, without: &str) -> T {
    read.unwrap_or_else(|error| {
        print_warning(&Warning::new("results-missing", format!("{error}: {without}")));
        T::default()
    })
}

/// Reports an error for a folder that is not the folder of a run.
fn check_run_folder(folder: &Path) -> Result<(), CommandError> {
    if folder.join("summary.json").exists() {
        return Ok(());
    }
    let name = folder.display();
    if folder.join("sweep.json").exists() {
        let problem = format!(
            "{name}: is the folder of a sweep: give the folder of one of its runs, such as {name}/run-0001"
        );
        return Err(CommandError::usage("not-a-run-folder", problem));
    }
    if folder.join("fit.json").exists() && folder.join("material.json").exists() {
        let problem = format!(
            "{name}: is the folder of a fit: its results are in {name}/fit.csv and the pictures beside it"
        );
        return Err(CommandError::usage("not-a-run-folder", problem));
    }
    Err(CommandError::usage("not-a-run-folder", format!("{name}: contains no run (summary.json is missing)")))
}

/// A duration in words.
fn duration_text(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => "a second".to_owned(),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s if s.is_finite() => format!("{:.1} h", s / 3600.0),
        _ => "an unknown time".to_owned(),
    }
}

/// Number with its noun.
fn count_text(number: usize, noun: &str) -> String {
    if number == 1 { format!("1 {noun}") } else { format!("{number} {noun}s") }
}

/// Thread pool of a run; all cores where no number is given.
fn thread_pool(threads: Option<u16>) -> Result<rayon::ThreadPool, CommandError> {
    machine::thread_pool(threads.map(usize::from))
        .map_err(|error| CommandError::message("no-threads", format!("threads: {error}")))
}

/// Option of commands that read cases, whose materials may be foreign libraries.
#[derive(Args)]
#[command(next_help_heading = "Foreign code")]
pub struct LibraryArguments {
    /// Load the shared libraries of materials of the model `umat`. A library runs with your rights: use this option only for files that you
    /// trust. The environment variable COLLUVIUM_ALLOW_LIBRARY=1 has the same effect.
    #[arg(long)]
    pub allow_library: bool,
}

/// Folder of the results, and how earlier results in it are treated.
#[derive(Args)]
#[command(next_help_heading = "Results")]
pub struct OutputArguments {
    /// Folder for the results; by default `<file>-<method>`, and `<file>-compare` for `compare`.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Continue interrupted runs; complete runs are kept.
    #[arg(long)]
    resume: bool,
    /// Replace earlier results.
    #[arg(long, conflicts_with = "resume")]
    overwrite: bool,
    /// Print nothing but errors.
    #[arg(long, short)]
    quiet: bool,
}

impl OutputArguments {
    /// Folder of the results of `method` for a file: `folder/case.json` with `mpm` gives `case-mpm`.
    fn output_folder(&self, file: &Path, method: &str) -> PathBuf {
        let stem = || file.file_stem().unwrap_or_default().to_string_lossy();
        self.out.clone().unwrap_or_else(|| format!("{}-{method}", stem()).into())
    }
}
