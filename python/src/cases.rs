//! Cases: checks, plans, templates and schemas.

use std::path::{Path, PathBuf};

use colluvium::case::files::json;
use colluvium::case::{Case, CaseErrors};
use colluvium::output::raster_maps::{Ring, case_outlines};
use pyo3::prelude::*;
use serde_json::json;

use crate::errors::{TaskError, case_error, output_error, value_error};
use crate::pool::in_pool;

/// Case from its JSON text; relative file names in it start at `folder`.
pub fn read_case(text: &str, folder: &Path) -> Result<Case, CaseErrors> {
    colluvium::register_materials();
    let value = json::parse(text).map_err(CaseErrors::from_error)?;
    Case::from_value(&value, folder)
}

/// Checks a case.
///
/// # Errors
/// `CaseError` with all problems of the case.
#[pyfunction]
pub fn check(py: Python<'_>, text: &str, folder: PathBuf) -> PyResult<()> {
    in_pool(py, || read_case(text, &folder))?.map(drop).map_err(|errors| case_error(&errors))
}

/// JSON list of the warnings about a case, which hold for every method.
///
/// # Errors
/// As `check`.
#[pyfunction]
pub fn case_warnings(py: Python<'_>, text: &str, folder: PathBuf) -> PyResult<String> {
    let case = in_pool(py, || read_case(text, &folder))?.map_err(|errors| case_error(&errors))?;
    let warnings = case.warnings();
    let list: Vec<_> = warnings.iter().map(|one| json!({ "code": one.code, "text": one.text })).collect();
    Ok(json!(list).to_string())
}

/// JSON object of the plan of a case: points, steps, time step (s), memory (bytes) and warnings.
///
/// # Errors
/// `CaseError` with the problems of the case, or what the method does not support.
#[pyfunction]
pub fn plan(py: Python<'_>, text: &str, folder: PathBuf, method: Option<&str>) -> PyResult<String> {
    let found = in_pool(py, || -> Result<String, TaskError> {
        let case = read_case(text, &folder)?;
        let method = colluvium::select_method(&case, method)?;
        let plan = method.plan(&case)?;
        let warnings = plan.all_warnings(&case);
        let warnings: Vec<_> =
            warnings.iter().map(|warning| json!({ "code": warning.code, "text": warning.text })).collect();
        let found = json!({
            "method": method.name(), "points": plan.points, "steps": plan.steps, "time_step": plan.time_step.dt,
            "memory": plan.memory, "warnings": warnings,
        });
        Ok(found.to_string())
    })?;
    found.map_err(TaskError::into_exception)
}

/// Rings of the outlines of a case (m, on the map): those of the layers of its bodies, and those of the observed event.
///
/// # Errors
/// As `check`.
#[pyfunction]
pub fn outlines(py: Python<'_>, text: &str, folder: PathBuf) -> PyResult<[Vec<Ring>; 2]> {
    let case = in_pool(py, || read_case(text, &folder))?.map_err(|errors| case_error(&errors))?;
    Ok(case_outlines(&case))
}

/// Names of the methods.
#[pyfunction]
pub fn methods() -> Vec<&'static str> {
    colluvium::methods().iter().map(|method| method.name()).collect()
}

/// Name and summary of each template of a case.
#[pyfunction]
pub fn templates() -> Vec<(&'static str, &'static str)> {
    let cases = colluvium::TEMPLATES.iter().filter(|own| own.kind == colluvium::TemplateKind::Case);
    cases.map(|own| (own.name, own.summary)).collect()
}

/// JSON text of a template.
///
/// # Errors
/// `ValueError` for another name.
#[pyfunction]
pub fn template(name: &str) -> PyResult<&'static str> {
    colluvium::template(name).ok_or_else(|| {
        let known = colluvium::template_names().join(", ");
        value_error(&format!("{name:?} is not a template of a case; there are {known}"))
    })
}

/// Names of the files that a template needs beside it.
#[pyfunction]
pub fn template_files(name: &str) -> Vec<&'static str> {
    colluvium::template_files(name)
}

/// Writes the files that a template needs into a folder.
///
/// # Errors
/// `OutputError` when a file cannot be written.
#[pyfunction]
pub fn write_template_files(name: &str, folder: PathBuf) -> PyResult<()> {
    colluvium::write_template_files(name, &folder).map_err(|error| output_error(&error))
}

/// JSON Schema of a case.
#[pyfunction]
pub fn schema() -> String {
    colluvium::case_schema().to_string()
}
