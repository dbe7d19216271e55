//! Names of files: every name from a user or a file becomes a path by [`named_file`].

use std::path::{Path, PathBuf};

use crate::output::OutputError;

/// Largest length of a name that becomes a column and a file (characters); two names and an ending fit into any file name.
const MAX_PLAIN: usize = 100;
/// Largest length of a file name (bytes), with room for the endings of temporary files.
const MAX_BYTES: usize = 240;

/// Rule for a name that becomes a column and a file.
pub const PLAIN_NAME_RULE: &str =
    "a name is made of up to 100 letters, digits, _ and -: it becomes a column and a file";

/// Whether a name is valid as a column of a table and in the name of a file: see [`PLAIN_NAME_RULE`].
pub fn is_plain(name: &str) -> bool {
    let known = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    (1..=MAX_PLAIN).contains(&name.len()) && name.chars().all(known)
}

/// Path of the file with this stem and ending in a folder. The stem may contain dots after its first character, spaces and letters of any
/// language, but no character that changes the folder, hides the file or cannot be displayed.
///
/// # Errors
/// When the stem contains another character, or is too long.
pub fn named_file(folder: &Path, stem: &str, ending: &str) -> Result<PathBuf, OutputError> {
    let harmless = |c: char| !c.is_control() && !r#"/\:*?"<>|"#.contains(c);
    let whole = stem.starts_with(|c: char| c.is_alphanumeric() || c == '_' || c == '-');
    let name = format!("{stem}.{ending}");
    if whole && stem.chars().all(harmless) && name.len() <= MAX_BYTES {
        return Ok(folder.join(name));
    }
    Err(OutputError::new(folder, format!("{stem:?} cannot be the name of a file")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_cannot_leave_their_folder() {
        let file = |stem: &str| named_file(Path::new("out"), stem, "csv");
        for stem in ["front", "toe.x", "-1", "Höhe der Böschung", "a..b"] {
            assert_eq!(file(stem).unwrap(), Path::new("out").join(format!("{stem}.csv")));
        }
        let long = "x".repeat(300);
        for stem in
            ["../../x", "..", "", ".hidden", "a/b", "a\\b", "C:x", "/etc/x", "a\nb", "a\u{1b}[2J", &long]
        {
            let problem = file(stem).unwrap_err().to_string();
            assert!(!problem.contains('\n') && !problem.contains('\u{1b}'), "{problem}");
        }
    }
}
