//! The commands, one file each.

/// Prints a line and passes a failure on.
macro_rules! say {
    ($($part:tt)*) => { $crate::commands::print(format_args!($($part)*))? };
}

pub mod check;
pub mod element_test;
pub mod new;
pub mod plot;
pub mod run;
pub mod schema;

use std::io::Write;
use std::path::Path;

use colluvium::case::output::OutputError;
use colluvium::case::{Case, CaseError, CaseErrors, Method, RunError};
use thiserror::Error;

/// Prints a line. Where nobody reads on, as behind `head`, the program ends without a word.
fn print(line: std::fmt::Arguments<'_>) -> Result<(), Failure> {
    match writeln!(std::io::stdout().lock(), "{line}") {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => std::process::exit(0),
        written => written.map_err(|error| Failure::Other(format!("standard output: {error}"))),
    }
}

/// Why a command ends without success.
#[derive(Debug, Error)]
pub enum Failure {
    /// The case file is wrong.
    #[error(transparent)]
    Case(#[from] CaseErrors),
    /// The run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A file could not be written or read.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The arguments do not make sense.
    #[error("{0}")]
    Usage(String),
    /// Anything else that went wrong while running.
    #[error("{0}")]
    Other(String),
    /// The run was interrupted.
    #[error("interrupted; continue with --resume")]
    Interrupted,
}

impl From<CaseError> for Failure {
    fn from(error: CaseError) -> Self {
        Self::Case(error.into())
    }
}

impl Failure {
    /// The exit code.
    pub fn code(&self) -> u8 {
        match self {
            Self::Case(_) | Self::Run(RunError::Case(_)) => 3,
            Self::Run(_) | Self::Output(_) | Self::Other(_) => 1,
            Self::Usage(_) => 2,
            Self::Interrupted => 4,
        }
    }
}

/// The method to run a case with: the one asked for, or the only one the case has options for.
fn choose(case: &Case, asked: Option<&str>) -> Result<&'static dyn Method, Failure> {
    let known: Vec<&str> = colluvium::methods().iter().map(|method| method.name()).collect();
    for name in case.methods.keys() {
        if !known.contains(&name.as_str()) {
            let problem = format!("is not a method; there are: {}", known.join(", "));
            return Err(CaseError::new(format!("methods.{name}"), problem).into());
        }
    }
    let name = match (asked, case.methods.len()) {
        (Some(name), _) => name,
        (None, 1) => case.methods.keys().next().map_or("", String::as_str),
        (None, 0) => {
            return Err(CaseError::new("methods", "names no method: choose one with --method").into());
        }
        (None, _) => {
            return Err(Failure::Usage("the case has several methods: choose one with --method".into()));
        }
    };
    colluvium::method(name)
        .ok_or_else(|| Failure::Usage(format!("{name:?} is not a method; there are: {}", known.join(", "))))
}

/// `folder/case.json` with `mpm` gives `case-mpm`.
fn default_out(case: &Path, method: &str) -> std::path::PathBuf {
    let stem = case.file_stem().unwrap_or_default().to_string_lossy();
    format!("{stem}-{method}").into()
}
