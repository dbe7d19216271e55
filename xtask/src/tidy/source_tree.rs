//! Text files of the repository.

use std::fs;
use std::path::Path;

/// Extensions of the files that are read.
const EXTENSIONS: [&str; 6] = ["rs", "md", "json", "csv", "toml", "py"];

/// Folders that are read, beside the files at the root.
const FOLDERS: [&str; 5] = ["crates", "docs", "python", "validation", "xtask"];

/// Text file of the repository.
pub struct SourceFile {
    /// Path from the root, with `/`.
    pub path: String,
    /// Text of the file.
    pub text: String,
}

impl SourceFile {
    /// Extension of the file.
    pub fn extension(&self) -> &str {
        self.path.rsplit_once('.').map_or("", |(_, ending)| ending)
    }
}

/// Text files of the repository, in the order of their paths.
pub struct SourceTree {
    /// Files that were read.
    pub files: Vec<SourceFile>,
}

impl SourceTree {
    /// Reads the files in the folders of the repository. Build and result folders, which begin with a dot or are named `dist` or `target`,
    /// are left out.
    ///
    /// # Errors
    ///
    /// A file that cannot be read.
    pub fn read(root: &Path) -> Result<Self, String> {
        let mut files = Vec::new();
        for name in ["README.md", "CHANGELOG.md"] {
            if root.join(name).is_file() {
                files.push(read(root, name)?);
            }
        }
        for folder in FOLDERS {
            visit(root, folder, &mut files)?;
        }
        files.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(Self { files })
    }

    /// Tree of these files, for tests.
    #[cfg(test)]
    pub fn from_files(files: &[(&str, &str)]) -> Self {
        let file =
            |(path, text): &(&str, &str)| SourceFile { path: (*path).to_owned(), text: (*text).to_owned() };
        Self { files: files.iter().map(file).collect() }
    }

    /// Sources of all crates, tests and benches included.
    pub fn sources(&self) -> impl Iterator<Item = &SourceFile> {
        self.files.iter().filter(|file| file.extension() == "rs")
    }

    /// Pages of the documentation and those at the root.
    pub fn pages(&self) -> impl Iterator<Item = &SourceFile> {
        self.files.iter().filter(|file| file.extension() == "md")
    }

    /// File at `path`; `None` where it does not exist.
    pub fn get(&self, path: &str) -> Option<&SourceFile> {
        self.files.iter().find(|file| file.path == path)
    }
}

/// Reads a text file.
fn read(root: &Path, path: &str) -> Result<SourceFile, String> {
    let text = fs::read_to_string(root.join(path)).map_err(|error| format!("{path}: {error}"))?;
    Ok(SourceFile { path: path.to_owned(), text })
}

/// Adds the text files of a folder and its subfolders.
fn visit(root: &Path, folder: &str, files: &mut Vec<SourceFile>) -> Result<(), String> {
    let entries = fs::read_dir(root.join(folder)).map_err(|error| format!("{folder}: {error}"))?;
    for entry in entries {
        let entry = entry.map_err(|error| format!("{folder}: {error}"))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let path = format!("{folder}/{name}");
        if name.starts_with('.') || ["dist", "target"].contains(&name.as_str()) {
            continue;
        }
        if entry.path().is_dir() {
            visit(root, &path, files)?;
        } else if EXTENSIONS.iter().any(|ending| name.ends_with(&format!(".{ending}"))) {
            files.push(read(root, &path)?);
        }
    }
    Ok(())
}
