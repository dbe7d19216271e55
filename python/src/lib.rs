//! Native part of the Python package `colluvium`: cases, runs and their results.
//!
//! Cases cross the border as JSON text, arrays as memory of a frame without a copy. What is convenient is in the Python modules beside
//! this crate.

mod errors;
mod frames;
mod runs;

use std::path::{Path, PathBuf};

use colluvium::case::Case;
use colluvium::case::files::json;
use pyo3::prelude::*;

use crate::errors::{case_error, value_error};

/// Case from its JSON text; relative file names in it start at `folder`.
fn read_case(text: &str, folder: &Path) -> PyResult<Case> {
    let value = json::parse(text).map_err(|error| case_error(&colluvium::case::CaseErrors::from_error(error)))?;
    Case::from_value(&value, folder).map_err(|errors| case_error(&errors))
}

/// Checks a case.
///
/// # Errors
/// `CaseError` with all problems of the case.
#[pyfunction]
fn check(py: Python<'_>, text: &str, folder: PathBuf) -> PyResult<()> {
    py.detach(|| read_case(text, &folder)).map(drop)
}

/// JSON object of the plan of a case: points, steps, time step (s), memory (bytes) and warnings.
///
/// # Errors
/// `CaseError` with the problems of the case, or what the method does not support.
#[pyfunction]
fn plan(py: Python<'_>, text: &str, folder: PathBuf, method: Option<&str>) -> PyResult<String> {
    py.detach(|| {
        let case = read_case(text, &folder)?;
        let method = colluvium::select_method(&case, method).map_err(|error| value_error(&error))?;
        let plan = method.plan(&case).map_err(|error| case_error(&colluvium::case::CaseErrors::from_error(error)))?;
        let warnings: Vec<_> = plan
            .all_warnings(&case)
            .into_iter()
            .map(|warning| serde_json::json!({ "code": warning.code, "text": warning.text }))
            .collect();
        let found = serde_json::json!({
            "method": method.name(), "points": plan.points, "steps": plan.steps, "time_step": plan.time_step.dt,
            "memory": plan.memory, "warnings": warnings,
        });
        Ok(found.to_string())
    })
}

/// Name and summary of each template of a case.
#[pyfunction]
fn templates() -> Vec<(&'static str, &'static str)> {
    let cases = colluvium::TEMPLATES.iter().filter(|own| own.kind == colluvium::TemplateKind::Case);
    cases.map(|own| (own.name, own.summary)).collect()
}

/// JSON text of a template of a case.
///
/// # Errors
/// `ValueError` for another name.
#[pyfunction]
fn template(name: &str) -> PyResult<&'static str> {
    if !colluvium::template_names().contains(&name) {
        let known = colluvium::template_names().join(", ");
        return Err(value_error(&format!("{name:?} is not a template of a case; there are {known}")));
    }
    colluvium::template(name).ok_or_else(|| value_error(&name))
}

/// Names of the files that a template needs beside it.
#[pyfunction]
fn template_files(name: &str) -> Vec<&'static str> {
    colluvium::template_files(name)
}

/// Writes the files that a template needs into a folder.
///
/// # Errors
/// `OutputError` when a file cannot be written.
#[pyfunction]
fn write_template_files(name: &str, folder: PathBuf) -> PyResult<()> {
    colluvium::write_template_files(name, &folder).map_err(|error| crate::errors::output_error(&error))
}

/// JSON Schema of a case.
#[pyfunction]
fn schema() -> String {
    colluvium::case_schema().to_string()
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<frames::Frame>()?;
    module.add_class::<runs::RunTask>()?;
    module.add_class::<runs::RunData>()?;
    module.add_function(wrap_pyfunction!(check, module)?)?;
    module.add_function(wrap_pyfunction!(plan, module)?)?;
    module.add_function(wrap_pyfunction!(templates, module)?)?;
    module.add_function(wrap_pyfunction!(template, module)?)?;
    module.add_function(wrap_pyfunction!(template_files, module)?)?;
    module.add_function(wrap_pyfunction!(write_template_files, module)?)?;
    module.add_function(wrap_pyfunction!(schema, module)?)?;
    Ok(())
}
