//! Names that become files: every name that a user or a file gives goes to a path through [`named_file`].

use std::path::{Path, PathBuf};

use crate::output::OutputError;

/// Most characters of a name that becomes a column and a file; two of them and an ending fit into a file's name anywhere.
const MAX_PLAIN: usize = 100;
/// Most bytes of a file's name, with room for the endings of temporary files.
const MAX_BYTES: usize = 240;

/// What a name must be that becomes a column and a file.
pub const PLAIN_NAME_RULE: &str =
    "a name is made of up to 100 letters, digits, _ and -: it becomes a column and a file";

/// Whether a name can stand in the head of a table and in the name of a file: see [`PLAIN_NAME_RULE`].
pub fn is_plain(name: &str) -> bool {
    let known = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    (1..=MAX_PLAIN).contains(&name.len()) && name.chars().all(known)
}

/// The file `stem.ending` in a folder. The stem may have dots within, spaces and letters of any language; nothing that
/// leads to another folder, hides the file or cannot be shown.
///
/// # Errors
/// When the stem has something else, or is too long.
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
    fn names_stay_in_their_folder() {
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
