//! Files that are either whole or not there.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// A file that could not be written or read.
#[derive(Debug, Error)]
#[error("{}: {problem}", path.display())]
pub struct OutputError {
    /// The file.
    pub path: PathBuf,
    /// What went wrong.
    pub problem: String,
}

impl OutputError {
    /// An error about `path`.
    pub fn new(path: &Path, problem: impl std::fmt::Display) -> Self {
        Self { path: path.to_owned(), problem: format!("{problem}") }
    }
}

/// The JSON value in a file that a run has left.
///
/// # Errors
/// When it cannot be read, or is no JSON: with line and column.
pub fn read_json(path: &Path) -> Result<serde_json::Value, OutputError> {
    let text = fs::read_to_string(path).map_err(|error| OutputError::new(path, error))?;
    crate::json::parse(&text).map_err(|error| OutputError::new(path, error))
}

/// Writes a file beside its place and moves it there, so that a crash leaves the old one or the new
/// one, never a part.
///
/// # Errors
/// When the disk refuses.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    write_through(path, |file| file.write_all(bytes))
}

/// As [`write_atomically`], with what `content` writes; nothing is left where it fails.
///
/// # Errors
/// When the disk refuses, or `content` does.
pub fn write_through(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), OutputError> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".tmp");
    let temporary = path.with_file_name(name);
    let write = || -> std::io::Result<()> {
        let mut file = BufWriter::new(File::create(&temporary)?);
        content(&mut file)?;
        file.into_inner()?.sync_all()?;
        fs::rename(&temporary, path)
    };
    write().map_err(|error| {
        // What is torn would keep the room that the summary needs.
        let _ = fs::remove_file(&temporary);
        OutputError::new(path, error)
    })
}
