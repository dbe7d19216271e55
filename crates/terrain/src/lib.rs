//! Readers and writers of terrain: rasters (ESRI ASCII grid, GeoTIFF), closed triangle meshes (STL, OBJ) and outlines in plan
//! (GeoJSON, shapefile). What a file holds is told by the ending of its name.
//!
//! Of the workspace it knows [`colluvium_points`] only, and only what reads case files knows it.

mod ascii_grid;
mod geotiff;
mod mesh;
mod outline;
mod prj;

use std::path::{Path, PathBuf};

use colluvium_points::Raster;
use colluvium_points::surface::Facetted;
use thiserror::Error;

pub use outline::{read_features, read_outlines};

/// What is wrong with a file, in a line.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}: {problem}", file.display())]
pub struct FileError {
    /// The file.
    pub file: PathBuf,
    /// What is wrong with it.
    pub problem: String,
}

/// Names the file of a problem.
fn of(file: &Path) -> impl Fn(String) -> FileError {
    move |problem| FileError { file: file.to_owned(), problem }
}

/// Mark of byte order, with which some editors begin a file.
const BYTE_ORDER: char = '\u{feff}';

fn text(file: &Path) -> Result<String, FileError> {
    std::fs::read_to_string(file).map_err(|e| of(file)(format!("cannot be read: {e}")))
}

/// The ending of a file's name, in small letters.
fn ending(file: &Path) -> String {
    file.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default()
}

fn unknown(file: &Path, known: &str) -> FileError {
    of(file)(format!(
        "a name that ends in {:?} does not tell what it holds: it must be {known}",
        ending(file)
    ))
}

/// Reads heights or other numbers on a grid in plan: an ESRI ASCII grid (`.asc`, `.grd`, `.txt`) or a GeoTIFF (`.tif`, `.tiff`).
///
/// # Errors
/// When the file cannot be read, is not such a raster, is rotated, is empty, or lies in degrees or in units that are not known: by
/// the keys of a GeoTIFF, or by a `.prj` beside an ASCII grid.
pub fn read_raster(file: &Path) -> Result<Raster, FileError> {
    let raster = match ending(file).as_str() {
        "asc" | "grd" | "txt" => ascii_grid::parse(text(file)?.trim_start_matches(BYTE_ORDER)),
        "tif" | "tiff" => {
            let bytes = std::fs::read(file).map_err(|e| of(file)(format!("cannot be read: {e}")))?;
            geotiff::parse(&bytes)
        }
        _ => return Err(unknown(file, ".asc, .grd or .txt (ESRI ASCII grid), .tif or .tiff (GeoTIFF)")),
    };
    let raster = raster.map_err(of(file))?;
    raster.validate().map_err(|error| of(file)(error.to_string()))?;
    // A GeoTIFF tells its units itself.
    if !ending(file).starts_with("tif") {
        prj::check(file).map_err(of(file))?;
    }
    Ok(raster)
}

/// Writes a raster with its georeference: an ESRI ASCII grid (`.asc`) or a GeoTIFF (`.tif`, `.tiff`). Numbers keep all their
/// digits. An ASCII grid cannot name a coordinate reference system.
///
/// # Errors
/// When the raster is none, or the file cannot be written.
pub fn write_raster(file: &Path, raster: &Raster) -> Result<(), FileError> {
    raster.validate().map_err(|error| of(file)(error.to_string()))?;
    let bytes = match ending(file).as_str() {
        "asc" => ascii_grid::format(raster).into_bytes(),
        "tif" | "tiff" => geotiff::bytes(raster).map_err(of(file))?,
        _ => return Err(unknown(file, ".asc (ESRI ASCII grid), .tif or .tiff (GeoTIFF)")),
    };
    std::fs::write(file, bytes).map_err(|error| of(file)(format!("cannot be written: {error}")))
}

/// Reads a closed triangle mesh: STL (`.stl`, text or binary) or Wavefront OBJ (`.obj`). `placed` makes a coordinate of the
/// mesh (m) of an axis and of that in the file.
///
/// # Errors
/// When the file cannot be read or is not such a mesh; when an STL file lies so far from its origin that its seven digits do not
/// tell its corners apart; when the surface is open, with the place.
pub fn read_mesh(file: &Path, placed: &dyn Fn(usize, f64) -> f64) -> Result<Facetted<3>, FileError> {
    let mesh = match ending(file).as_str() {
        "stl" => mesh::stl(file, placed),
        "obj" => mesh::obj(file, placed),
        _ => return Err(unknown(file, ".stl or .obj")),
    };
    mesh.map_err(of(file))
}
