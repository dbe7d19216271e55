//! Readers and writers of terrain: rasters (ESRI ASCII grid, GeoTIFF), closed triangle meshes (STL, OBJ) and outlines in plan
//! (GeoJSON, shapefile). The extension of the file name determines the format.
//!
//! ```
//! use colluvium_points::{Raster, Terrain};
//! use colluvium_terrain::{read_raster, write_raster};
//!
//! // Heights at 40 × 30 nodes 5 m apart: a plane that falls by 0.3 along x.
//! let slope = Raster::from_function([40, 30], [600_000.0, 5_200_000.0], [5.0, 5.0], |x, _| 900.0 - 0.3 * (x - 600_000.0));
//! let folder = tempfile::tempdir()?;
//! let file = folder.path().join("slope.tif");
//! write_raster(&file, &slope)?;
//! let terrain = Terrain::new(read_raster(&file)?, 0)?;
//! let sample = terrain.sample_at(600_050.0, 5_200_050.0).expect("a position on the raster");
//! assert!((sample.height - 885.0).abs() < 1e-9);
//! assert!((sample.gradient[0] + 0.3).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Positions and heights are in metres. Files in degrees are refused, heights in feet are converted, and numbers that are not
//! data become NaN. The crate depends only on [`colluvium_points`] in the workspace; only crates that read case files depend on it.

mod mesh;
mod outline;
mod projection;
mod raster;
pub(crate) mod raster_band;
mod reference_system;
mod sidecar_files;

use std::path::{Path, PathBuf};

use colluvium_points::Raster;
use colluvium_points::surface::FacettedSurface;
use thiserror::Error;

pub use crate::outline::outline_files::{read_features, read_outlines};
pub use crate::reference_system::{CoordinateReferenceSystem, read_reference_system};
pub use crate::sidecar_files::sidecar_files;

use crate::raster::world_file::WorldFile;

/// Error of a file, in one line.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}: {problem}", file.display())]
pub struct FileError {
    /// Path of the file.
    pub file: PathBuf,
    /// Stable code of the problem, which `docs/messages.md` of the repository explains.
    pub code: &'static str,
    /// Description of the error.
    pub problem: String,
}

/// Function that makes an error of a file from a description.
fn error_in_file<P: Into<Problem>>(file: &Path) -> impl Fn(P) -> FileError {
    move |problem| {
        let Problem { code, text } = problem.into();
        FileError { file: file.to_owned(), code, problem: text }
    }
}

/// Problem of the content of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Problem {
    /// Stable code.
    code: &'static str,
    /// Description.
    text: String,
}

impl Problem {
    /// Function that makes a problem of the code `code` from a description.
    fn coded(code: &'static str) -> impl Fn(String) -> Self {
        move |text| Self { code, text }
    }
}

impl From<String> for Problem {
    fn from(text: String) -> Self {
        Self { code: "unreadable-file", text }
    }
}

/// Byte order mark, with which some editors begin a file.
const BYTE_ORDER: char = '\u{feff}';

/// Reads a text file: UTF-8, or UTF-16 with a byte order mark, as some spreadsheets write it. Other texts are read as Latin-1, in which
/// units such as m³ are written; such letters occur in names and comments, not in numbers.
///
/// # Errors
/// When the file cannot be read, or contains bytes that no text has.
pub fn read_text(file: &Path) -> Result<String, FileError> {
    let bytes = std::fs::read(file).map_err(|e| error_in_file(file)(format!("cannot be read: {e}")))?;
    decode_text(bytes).map_err(error_in_file(file))
}

/// Decodes the text of a file in UTF-8 or UTF-16.
fn decode_text(bytes: Vec<u8>) -> Result<String, String> {
    let pairs = |order: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|pair| order([pair[0], pair[1]])).collect();
        String::from_utf16(&units)
            .map_err(|_| "is not valid UTF-16, although its first two bytes are those of UTF-16".to_owned())
    };
    match bytes.as_slice() {
        [0xff, 0xfe, ..] => return pairs(u16::from_le_bytes),
        [0xfe, 0xff, ..] => return pairs(u16::from_be_bytes),
        _ => {}
    }
    if bytes.contains(&0) {
        return Err("is not text: it contains zero bytes".to_owned());
    }
    let text = String::from_utf8(bytes);
    let text = text.unwrap_or_else(|error| error.as_bytes().iter().map(|byte| char::from(*byte)).collect());
    Ok(text.trim_start_matches(BYTE_ORDER).to_owned())
}

/// Extension of a file name, in lower case.
fn extension(file: &Path) -> String {
    file.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Error of a file whose extension is not supported; `known` lists the supported ones.
fn unknown_format(file: &Path, known: &str) -> FileError {
    error_in_file(file)(Problem::coded("unsupported-format")(format!(
        "the ending {:?} of the name is not supported: it must be {known}",
        extension(file)
    )))
}

/// Reads heights or other numbers on a grid in plan: an ESRI ASCII grid (`.asc`, `.grd`, `.txt`) or a GeoTIFF (`.tif`, `.tiff`). Scale,
/// offset and unit of the band are applied, and heights in feet become metres. Values without data, by the no-data value or mask of the
/// file, and values that are not finite become NaN.
///
/// # Errors
/// When the file cannot be read, is not such a raster, is rotated, is empty, or lies in degrees or in units that are not known: by
/// the keys of a GeoTIFF, or by a `.prj` or `.aux.xml` beside an ASCII grid.
pub fn read_raster(file: &Path) -> Result<Raster, FileError> {
    let beside = raster_band::sidecar_band(file).map_err(error_in_file(file))?;
    let is_beside = beside.crs.is_some();
    let raster = match extension(file).as_str() {
        "asc" | "grd" | "txt" => {
            let system = projection::prj_file::read_text(file)
                .map_err(Problem::coded("crs-unreadable"))
                .map_err(error_in_file(file))?
                .or_else(|| beside.crs.clone());
            let mut raster = raster::ascii_grid::parse(&read_text(file)?, beside);
            raster.iter_mut().for_each(|raster| {
                projection::prj_file::set_georeference(&mut raster.reference, system.clone());
            });
            raster
        }
        "tif" | "tiff" => {
            let bytes = |path: &Path| {
                std::fs::read(path).map_err(|e| error_in_file(path)(format!("cannot be read: {e}")))
            };
            let name = format!("{}.msk", file.file_name().unwrap_or_default().to_string_lossy());
            let mask = file.with_file_name(name);
            let mask = mask.is_file().then(|| bytes(&mask)).transpose()?;
            let world = WorldFile::sidecar_of(file)
                .map_err(Problem::coded("no-georeference"))
                .map_err(error_in_file(file))?;
            raster::geotiff::parse(
                &bytes(file)?,
                raster::geotiff::GeotiffSidecars { band: beside, mask, world },
            )
        }
        _ => {
            return Err(unknown_format(
                file,
                ".asc, .grd or .txt (ESRI ASCII grid), .tif or .tiff (GeoTIFF)",
            ));
        }
    };
    let mut raster = raster.map_err(error_in_file(file))?;
    raster
        .validate()
        .map_err(|error| error_in_file(file)(Problem::coded(error.code())(error.to_string())))?;
    let is_nameless = raster.reference.epsg.is_none() && raster.reference.crs.is_none();
    if is_nameless {
        projection::prj_file::set_georeference(
            &mut raster.reference,
            projection::prj_file::read_text(file)
                .map_err(Problem::coded("crs-unreadable"))
                .map_err(error_in_file(file))?,
        );
    }
    // A GeoTIFF states its units itself, but an `.aux.xml` of GDAL beside it takes precedence.
    if is_nameless || is_beside || !extension(file).starts_with("tif") {
        projection::prj_file::check_metres(file)
            .map_err(Problem::coded("crs-not-metres"))
            .map_err(error_in_file(file))?;
    }
    Ok(raster)
}

/// Writes a raster with its georeference: an ESRI ASCII grid (`.asc`) or a GeoTIFF (`.tif`, `.tiff`). Numbers are written with all digits.
/// An ASCII grid cannot name a coordinate reference system: a `.prj` beside it does, where the raster has one.
///
/// # Errors
/// When the raster is invalid, or the file cannot be written.
pub fn write_raster(file: &Path, raster: &Raster) -> Result<(), FileError> {
    raster
        .validate()
        .map_err(|error| error_in_file(file)(Problem::coded(error.code())(error.to_string())))?;
    let bytes = match extension(file).as_str() {
        "asc" => raster::ascii_grid::format(raster).into_bytes(),
        "tif" | "tiff" => raster::geotiff::encode(raster).map_err(error_in_file(file))?,
        _ => return Err(unknown_format(file, ".asc (ESRI ASCII grid), .tif or .tiff (GeoTIFF)")),
    };
    let write = |file: &Path, bytes: &[u8]| {
        std::fs::write(file, bytes).map_err(|error| {
            error_in_file(file)(Problem::coded("output")(format!("cannot be written: {error}")))
        })
    };
    write(file, &bytes)?;
    match projection::map_projection::georeference_well_known_text(&raster.reference)
        .filter(|_| extension(file) == "asc")
    {
        Some(system) => write(&file.with_extension("prj"), system.as_bytes()),
        None => Ok(()),
    }
}

/// Reads a closed triangle mesh from a file: STL (`.stl`, text or binary) or Wavefront OBJ (`.obj`). `placed` maps an axis and a coordinate
/// of the file to a coordinate of the mesh (m).
///
/// # Errors
/// When the file cannot be read or is not such a mesh; when an STL file lies so far from its origin that its seven digits do not separate
/// its vertices; when the surface is open, with the position.
pub fn read_mesh(file: &Path, placed: &dyn Fn(usize, f64) -> f64) -> Result<FacettedSurface<3>, FileError> {
    let mesh = match extension(file).as_str() {
        "stl" => mesh::mesh_files::read_stl(file, placed),
        "obj" => mesh::mesh_files::read_obj(file, placed),
        _ => return Err(unknown_format(file, ".stl or .obj")),
    };
    mesh.map_err(Problem::coded("invalid-surface")).map_err(error_in_file(file))
}
