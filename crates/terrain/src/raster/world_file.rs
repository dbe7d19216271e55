//! World files: the placement of a raster beside it, as six numbers (`.tfw`, `.tifw`, `.wld`).

use std::path::{Path, PathBuf};

/// Placement of a raster in plan. The first pixel is the north-western one where rows run south.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WorldFile {
    /// Centre of the first pixel (m).
    pub(crate) first: [f64; 2],
    /// Steps per column and row (m). Negative steps run west and south.
    pub(crate) step: [f64; 2],
}

impl WorldFile {
    /// Parses the text of a world file.
    fn from_text(text: &str) -> Result<Self, String> {
        let problem = || "must hold six numbers in lines of their own".to_owned();
        let numbers: Vec<f64> = text
            .split_whitespace()
            .map(|word| word.parse().map_err(|_| problem()))
            .collect::<Result<_, _>>()?;
        let [east, down, right, north, x, y] = numbers[..] else { return Err(problem()) };
        if numbers.iter().any(|number| !number.is_finite()) {
            return Err(problem());
        }
        if down != 0.0 || right != 0.0 {
            return Err("rotates the raster: resample it to a grid along east and north".to_owned());
        }
        Ok(Self { first: [x, y], step: [east, north] })
    }

    /// Reads the world file beside a raster, where there is one.
    pub(crate) fn sidecar_of(file: &Path) -> Result<Option<Self>, String> {
        let Some(path) = path(file) else { return Ok(None) };
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&path)
            .map_err(|error| format!("{name} beside it cannot be read: {error}"))?;
        Self::from_text(&text).map(Some).map_err(|problem| format!("{name} beside it {problem}"))
    }
}

/// Extensions of world files.
pub(crate) const EXTENSIONS: [&str; 7] = ["tfw", "tifw", "tiffw", "wld", "TFW", "TIFW", "WLD"];

/// Path of the world file beside a raster.
fn path(file: &Path) -> Option<PathBuf> {
    EXTENSIONS.iter().map(|ending| file.with_extension(ending)).find(|path| path.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn world_files_have_six_numbers_and_rotated_ones_are_refused() {
        let world = WorldFile::from_text("5.0\n0\n0.0\n-4e0\r\n1002.5\n2202.5\n").unwrap();
        assert_eq!(world, WorldFile { first: [1002.5, 2202.5], step: [5.0, -4.0] });
        assert!(WorldFile::from_text("5\n0.1\n0\n-5\n1\n2\n").unwrap_err().contains("rotates"));
        for text in ["5 0 0 -5 1", "5 0 0 -5 1 2 3", "5 0 0 x 1 2", "5 0 0 nan 1 2"] {
            assert!(WorldFile::from_text(text).unwrap_err().contains("six numbers"), "{text}");
        }
    }
}
