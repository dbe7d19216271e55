//! Files that commands derive from the results of a run: images, archives, lists of points, reports.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::output::{FileChecksum, OutputError};

/// Name of the list of derived files in their folder.
pub const DERIVED: &str = "derived.txt";

/// Files in a folder that commands derive from a run, with their checksums. A line `hash bytes name` of the list stands for a file; the
/// last line of a name counts. A file with the same name that is not in the list, or has changed, is not replaced.
#[derive(Debug)]
pub struct DerivedFiles {
    folder: PathBuf,
    checksums: BTreeMap<String, FileChecksum>,
    overwrite: bool,
}

impl DerivedFiles {
    /// Reads the list of a folder, empty without one. With `overwrite` any file is replaced.
    ///
    /// # Errors
    /// When the list cannot be read.
    pub fn open(folder: &Path, overwrite: bool) -> Result<Self, OutputError> {
        let path = folder.join(DERIVED);
        let text = match fs::read(&path) {
            Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(OutputError::new(&path, error)),
        };
        Ok(Self { folder: folder.to_owned(), checksums: text.lines().filter_map(entry).collect(), overwrite })
    }

    /// Whether a file in the folder is one that a command wrote and that is unchanged since.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn is_own(&self, name: &str) -> Result<bool, OutputError> {
        let path = self.folder.join(name);
        match self.checksums.get(name) {
            Some(checksum) if path.is_file() => Ok(FileChecksum::of_file(&path, None)? == *checksum),
            _ => Ok(false),
        }
    }

    /// Removes all files of the list that are unchanged, and the list. Other files remain.
    ///
    /// # Errors
    /// When a file cannot be read or removed.
    pub fn remove_own(&mut self) -> Result<(), OutputError> {
        let remove = |path: PathBuf| fs::remove_file(&path).map_err(|error| OutputError::new(&path, error));
        for name in self.checksums.keys().filter(|name| !name.contains(['/', '\\'])) {
            if self.is_own(name)? {
                remove(self.folder.join(name))?;
            }
        }
        self.checksums.clear();
        let list = self.folder.join(DERIVED);
        if list.exists() { remove(list) } else { Ok(()) }
    }

    /// Rejects the replacement of a file that no command wrote.
    ///
    /// # Errors
    /// When the file exists, no command wrote it in this state, and `overwrite` is not set.
    pub fn check(&self, name: &str) -> Result<(), OutputError> {
        let path = self.folder.join(name);
        if self.overwrite || path.symlink_metadata().is_err() || self.is_own(name)? {
            return Ok(());
        }
        let problem = "would be overwritten, but colluvium did not write it with these contents. Move it \
                       away, or give --overwrite";
        Err(OutputError::coded(&path, "would-be-overwritten", problem))
    }

    /// Writes a file in the folder and adds it to the list.
    ///
    /// # Errors
    /// When it would replace a file that no command wrote, and when `write` or the disk fails.
    pub fn write<E: From<OutputError>>(
        &mut self,
        name: &str,
        write: impl FnOnce(&Path) -> Result<(), E>,
    ) -> Result<(), E> {
        self.check(name)?;
        let path = self.folder.join(name);
        write(&path)?;
        let checksum = FileChecksum::of_file(&path, None)?;
        self.checksums.insert(name.to_owned(), checksum);
        let list = self.folder.join(DERIVED);
        let added = File::options()
            .create(true)
            .append(true)
            .open(&list)
            .and_then(|mut file| writeln!(file, "{:016x} {} {name}", checksum.fnv1a, checksum.bytes));
        added.map_err(|error| OutputError::new(&list, error).into())
    }
}

/// Name and checksum in a line of the list.
fn entry(line: &str) -> Option<(String, FileChecksum)> {
    let mut parts = line.splitn(3, ' ');
    let fnv1a = u64::from_str_radix(parts.next()?, 16).ok()?;
    let bytes = parts.next()?.parse().ok()?;
    Some((parts.next()?.to_owned(), FileChecksum { bytes, fnv1a }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(folder: &Path, overwrite: bool, text: &str) -> Result<(), OutputError> {
        let mut files = DerivedFiles::open(folder, overwrite)?;
        files.write("a b.png", |path| crate::output::write_atomically(path, text.as_bytes()))
    }

    #[test]
    fn only_unchanged_files_of_the_list_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), false, "first").unwrap();
        let mut files = DerivedFiles::open(folder.path(), false).unwrap();
        files.write("c.csv", |path| crate::output::write_atomically(path, b"1")).unwrap();
        fs::write(folder.path().join("c.csv"), "edited").unwrap();
        fs::write(folder.path().join("mine"), "").unwrap();
        files.remove_own().unwrap();
        let left = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
        let mut left: Vec<_> = left.collect();
        left.sort();
        assert_eq!(left, ["c.csv", "mine"]);
    }

    #[test]
    fn files_of_other_origin_are_replaced_only_with_the_overwrite_option() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a b.png");
        fs::write(&path, "mine").unwrap();
        let refused = write(folder.path(), false, "first").unwrap_err().to_string();
        assert!(refused.contains("a b.png: would be overwritten") && refused.contains("--overwrite"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "mine");
        write(folder.path(), true, "first").unwrap();
        write(folder.path(), false, "second").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "second");
        // A file that has been changed since is the work of a user.
        fs::write(&path, "drawn on").unwrap();
        write(folder.path(), false, "third").unwrap_err();
        assert_eq!(fs::read_to_string(&path).unwrap(), "drawn on");
    }
}
