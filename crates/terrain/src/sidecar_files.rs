//! Files beside a file of terrain that say more of it.

use std::path::{Path, PathBuf};

use crate::raster::world_file::EXTENSIONS;

/// Endings that take the place of a file's own, beside those of world files: systems of coordinates, attributes and index of shapes.
const REPLACING_EXTENSIONS: [&str; 6] = ["prj", "PRJ", "dbf", "DBF", "shx", "SHX"];

/// Endings that come after it: meaning and mask of a raster, as GDAL writes them.
const APPENDED_EXTENSIONS: [&str; 2] = ["aux.xml", "msk"];

/// Files beside a raster or an outline that are read with it, where they are.
pub fn sidecar_files(file: &Path) -> Vec<PathBuf> {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let after = APPENDED_EXTENSIONS.iter().map(|ending| file.with_file_name(format!("{name}.{ending}")));
    let in_place = REPLACING_EXTENSIONS.iter().chain(&EXTENSIONS).map(|ending| file.with_extension(ending));
    in_place.chain(after).filter(|path| path != file && path.is_file()).collect()
}
