//! Reports, maps, rasters and runs of folders.

use std::path::PathBuf;

use colluvium::case::run::{self, RunStatus};
use colluvium::output::raster_maps;
use colluvium::output::run_pictures::view_plane;
use colluvium::plots::Picture;
use colluvium::points::{Georeference, Raster};
use colluvium::report::{self, ReportError, ReportOptions};
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::cases::read_case;
use crate::errors::{case_error, folder_error, output_error, value_error};
use crate::frames::{FrameData, RasterData};
use crate::pool::in_pool;
use crate::tables::{TableArray, table_array};

/// Writes the report of a run, and returns its file with the codes and texts of its warnings.
///
/// # Errors
/// `OutputError` when the folder has no run or a file cannot be written; `ValueError` for an unknown field.
#[pyfunction]
pub fn write_report(
    py: Python<'_>,
    folder: PathBuf,
    fields: Vec<String>,
    frames: usize,
    view: Option<String>,
    overwrite: bool,
) -> PyResult<(PathBuf, Vec<(String, String)>)> {
    if let Some(view) = view.as_deref().filter(|view| !["xy", "xz", "yz"].contains(view)) {
        return Err(value_error(&format!("view: {view:?} is none of xy, xz, yz")));
    }
    let plane = view_plane(&folder, view.as_deref()).map_err(|error| output_error(&error))?;
    let options = ReportOptions { fields, frames, plane, overwrite };
    let written = in_pool(py, || report::write(&folder, &options))?.map_err(|error| match &error {
        ReportError::Output(error) => output_error(error),
        ReportError::NoRun(_) => folder_error(&error, &folder),
        other => value_error(other),
    })?;
    let warnings = written.missing_files.iter().map(|one| (one.code.to_string(), one.text.clone()));
    Ok((written.file, warnings.collect()))
}

/// Reads a raster: an ESRI ASCII grid or a GeoTIFF, as terrain and results are.
///
/// # Errors
/// `OutputError` when the file cannot be read.
#[pyfunction]
pub fn read_raster(py: Python<'_>, file: PathBuf) -> PyResult<RasterData> {
    let raster =
        py.detach(|| colluvium::terrain::read_raster(&file)).map_err(|error| folder_error(&error, &file))?;
    let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(RasterData::new(&name, "", raster))
}

/// Writes a raster as an ESRI ASCII grid or a GeoTIFF, by the ending of the name.
///
/// # Errors
/// `OutputError` when the file cannot be written.
#[pyfunction]
#[pyo3(signature = (file, values, origin, spacing, epsg))]
pub fn write_raster(
    file: PathBuf,
    values: PyReadonlyArray2<'_, f64>,
    origin: [f64; 2],
    spacing: [f64; 2],
    epsg: Option<u32>,
) -> PyResult<()> {
    let raster = raster_of(&values, origin, spacing, epsg);
    colluvium::terrain::write_raster(&file, &raster).map_err(|error| folder_error(&error, &file))
}

/// Quantity of a raster of results with its unit; `None` for other names.
#[pyfunction]
pub fn raster_label(name: &str) -> Option<&'static str> {
    raster_maps::raster_label(name)
}

/// Raster of an array with one row per y, from the smallest.
fn raster_of(
    values: &PyReadonlyArray2<'_, f64>,
    origin: [f64; 2],
    spacing: [f64; 2],
    epsg: Option<u32>,
) -> Raster {
    let (rows, columns) = (values.shape()[0], values.shape()[1]);
    let reference = Georeference { epsg, no_data: Some(-9999.0), ..Georeference::default() };
    Raster { columns, rows, origin, spacing, values: values.as_array().iter().copied().collect(), reference }
}

/// Draws a raster over the terrain and the outlines of a case.
///
/// # Errors
/// `CaseError` for the case, `OutputError` for the file.
#[pyfunction]
#[pyo3(signature = (file, text, folder, values, origin, spacing, title, label))]
#[allow(clippy::too_many_arguments, reason = "the signature of the Python call")]
pub fn draw_map(
    py: Python<'_>,
    file: PathBuf,
    text: &str,
    folder: PathBuf,
    values: PyReadonlyArray2<'_, f64>,
    origin: [f64; 2],
    spacing: [f64; 2],
    title: &str,
    label: &str,
) -> PyResult<()> {
    let raster = raster_of(&values, origin, spacing, None);
    let case = in_pool(py, || read_case(text, &folder))?.map_err(|errors| case_error(&errors))?;
    let map =
        raster_maps::raster_map(&case, raster, title, label).map_err(|error| case_error(&error.into()))?;
    py.detach(|| map.write(&file)).map_err(|error| output_error(&error))
}

/// Run in a folder.
#[pyclass(frozen, module = "colluvium._native")]
pub struct RecordedData {
    recorded: run::RecordedRun,
}

/// Opens the run in a folder.
///
/// # Errors
/// `OutputError` when the folder contains no run, or a file of it cannot be read.
#[pyfunction]
pub fn open_run(folder: PathBuf) -> PyResult<RecordedData> {
    run::open(&folder).map(|recorded| RecordedData { recorded }).map_err(|error| output_error(&error))
}

#[pymethods]
impl RecordedData {
    /// Name of the method.
    #[getter]
    fn method(&self) -> &str {
        self.recorded.method()
    }

    /// Status, `running`, `completed`, `interrupted` or `failed`, and the reason of a failure.
    #[getter]
    fn status(&self) -> (&'static str, Option<&str>) {
        match self.recorded.status() {
            RunStatus::Running => ("running", None),
            RunStatus::Completed => ("completed", None),
            RunStatus::Interrupted => ("interrupted", None),
            RunStatus::Failed { reason } => ("failed", Some(reason)),
        }
    }

    /// Codes and texts of the warnings.
    #[getter]
    fn warnings(&self) -> Vec<(String, String)> {
        self.recorded.warnings().iter().map(|one| (one.code.to_string(), one.text.clone())).collect()
    }

    /// Names and units of the columns of the measures, and their rows.
    fn measures<'py>(&self, py: Python<'py>) -> PyResult<TableArray<'py>> {
        let table = self.recorded.table();
        table_array(py, table.columns.clone(), &table.rows)
    }

    /// Times of the frames (s).
    #[getter]
    fn frame_times(&self) -> Vec<f64> {
        self.recorded.frame_times().collect()
    }

    /// Reads a frame.
    ///
    /// # Errors
    /// `OutputError` when its file cannot be read; `ValueError` for another number.
    fn frame(&self, py: Python<'_>, number: usize) -> PyResult<Py<FrameData>> {
        let found = py.detach(|| self.recorded.frame(number)).map_err(|error| output_error(&error))?;
        let frame = found.ok_or_else(|| value_error(&format!("the run has no frame {number}")))?;
        FrameData::new(py, frame.into())
    }
}
