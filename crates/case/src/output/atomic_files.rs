//! Files that are written completely or not at all.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;

use crate::error::OutputError;

/// Reads a JSON value from a file of a run.
///
/// # Errors
/// When the file cannot be read, or is no valid JSON: with line and column.
pub fn read_json(path: &Path) -> Result<serde_json::Value, OutputError> {
    let text = fs::read_to_string(path).map_err(|error| OutputError::new(path, error))?;
    crate::files::json::parse(&text).map_err(|error| OutputError::new(path, error))
}

/// Creates a folder and its missing parent folders.
///
/// # Errors
/// When the folder cannot be created, and when a file or a broken link has its name.
pub fn create_folder(path: &Path) -> Result<(), OutputError> {
    fs::create_dir_all(path).map_err(|error| {
        let in_the_way = path.ancestors().find(|part| part.symlink_metadata().is_ok() && !part.is_dir());
        let Some(part) = in_the_way else { return OutputError::new(path, error) };
        match fs::read_link(part) {
            Ok(target) if !part.exists() => {
                OutputError::new(part, format!("is a link to {}, which does not exist", target.display()))
            }
            _ => OutputError::new(part, "is a file, but a folder must be created there"),
        }
    })
}

/// Writes a temporary file and renames it, so that a crash leaves the old file or the new one, never a part.
///
/// # Errors
/// When the file cannot be written.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    write_stream_atomically(path, |file| file.write_all(bytes))
}

/// Overwrites a file with a text within the space of the file, for a full disk. A crash during the write may leave a part.
///
/// # Errors
/// When there is no such file, or the file is shorter than the text.
pub fn write_in_place(path: &Path, text: &str) -> Result<(), OutputError> {
    let write = || -> std::io::Result<()> {
        let mut file = File::options().write(true).open(path)?;
        if file.metadata()?.len() < text.len() as u64 {
            return Err(std::io::Error::from(std::io::ErrorKind::StorageFull));
        }
        file.write_all(text.as_bytes())?;
        file.set_len(text.len() as u64)?;
        file.sync_all()
    };
    write().map_err(|error| OutputError::new(path, error))
}

/// Writes the output of `content` like [`write_atomically`]; no file is left after a failure.
///
/// # Errors
/// When the file cannot be written, or `content` fails.
pub fn write_stream_atomically(
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
        // A partial file would take the space that the summary needs.
        let _ = fs::remove_file(&temporary);
        OutputError::new(path, error)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_or_a_dangling_link_in_place_of_a_folder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "text").unwrap();
        let error = create_folder(&file.join("below")).unwrap_err();
        assert_eq!((error.path, error.problem.contains("is a file")), (file.clone(), true));
        create_folder(folder.path()).unwrap();
        #[cfg(unix)]
        {
            let link = folder.path().join("link");
            std::os::unix::fs::symlink(folder.path().join("gone"), &link).unwrap();
            for place in [link.clone(), link.join("below")] {
                let error = create_folder(&place).unwrap_err().to_string();
                assert!(error.contains("link: is a link to") && error.contains("does not exist"), "{error}");
            }
        }
    }

    #[test]
    fn files_are_overwritten_in_place_by_shorter_texts_only() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("summary");
        fs::write(&path, "a long text").unwrap();
        write_in_place(&path, "short").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "short");
        write_in_place(&path, "longer").unwrap_err();
        write_in_place(&folder.path().join("none"), "").unwrap_err();
    }
}
