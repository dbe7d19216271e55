//! Files beside a file of terrain that say more of it.

use std::path::{Path, PathBuf};

use crate::world_file::ENDINGS;

/// Endings that take the place of a file's own, beside those of world files: systems of coordinates, attributes and index of shapes.
const IN_PLACE: [&str; 6] = ["prj", "PRJ", "dbf", "DBF", "shx", "SHX"];

/// Endings that come after it: meaning and mask of a raster, as GDAL writes them.
const AFTER: [&str; 2] = ["aux.xml", "msk"];

/// Files beside a raster or an outline that are read with it, where they are.
pub fn files_beside(file: &Path) -> Vec<PathBuf> {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let after = AFTER.iter().map(|ending| file.with_file_name(format!("{name}.{ending}")));
    let in_place = IN_PLACE.iter().chain(&ENDINGS).map(|ending| file.with_extension(ending));
    in_place.chain(after).filter(|path| path != file && path.is_file()).collect()
}
