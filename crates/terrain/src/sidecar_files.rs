//! Sidecar files of a terrain file.

use std::path::{Path, PathBuf};

use crate::raster::world_file::EXTENSIONS;

/// Extensions of sidecar files that replace the extension of a file: reference system, attributes and index of shapes.
const REPLACING_EXTENSIONS: [&str; 6] = ["prj", "PRJ", "dbf", "DBF", "shx", "SHX"];

/// Extensions of sidecar files that are appended to a file name: band metadata and mask of a raster, as GDAL writes them.
const APPENDED_EXTENSIONS: [&str; 2] = ["aux.xml", "msk"];

/// Existing sidecar files that are read with a raster or an outline.
pub fn sidecar_files(file: &Path) -> Vec<PathBuf> {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let after = APPENDED_EXTENSIONS.iter().map(|ending| file.with_file_name(format!("{name}.{ending}")));
    let in_place = REPLACING_EXTENSIONS.iter().chain(&EXTENSIONS).map(|ending| file.with_extension(ending));
    in_place.chain(after).filter(|path| path != file && path.is_file()).collect()
}
