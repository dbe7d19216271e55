//! Python exceptions from errors of the library.

use std::fmt::Display;

use colluvium::case::output::OutputError;
use colluvium::case::run::RunError;
use colluvium::case::{CaseErrors, SolverError};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// Exception of a class of `colluvium.errors`; an import error where the class is missing.
fn exception(class: &str, arguments: impl FnOnce(Python<'_>) -> PyResult<Py<PyTuple>>) -> PyErr {
    Python::attach(|py| {
        let made = || -> PyResult<PyErr> {
            let class = py.import("colluvium.errors")?.getattr(class)?;
            Ok(PyErr::from_value(class.call1(arguments(py)?.bind(py))?))
        };
        made().unwrap_or_else(|error| error)
    })
}

/// `CaseError` with the path and the text of each problem.
pub fn case_error(errors: &CaseErrors) -> PyErr {
    let problems: Vec<(String, String)> =
        errors.0.iter().map(|error| (error.path.clone(), error.kind.to_string())).collect();
    exception("CaseError", |py| Ok((problems,).into_pyobject(py)?.unbind()))
}

/// `ValueError` with a text.
pub fn value_error(problem: &dyn Display) -> PyErr {
    PyValueError::new_err(problem.to_string())
}

/// `OutputError` about a file or a folder.
pub fn output_error(error: &OutputError) -> PyErr {
    let (path, text) = (error.path.display().to_string(), error.to_string());
    exception("OutputError", |py| Ok((text, path).into_pyobject(py)?.unbind()))
}

/// `SolverError` with step, time (s), point and position (m), where they are known.
fn solver_error(error: &SolverError, text: String) -> PyErr {
    let (step, time, point, position) = match error {
        SolverError::Point { step, time, point, position, .. } => {
            (Some(*step), Some(*time), Some(*point), Some(*position))
        }
        _ => (None, None, None, None),
    };
    exception("SolverError", |py| Ok((text, step, time, point, position).into_pyobject(py)?.unbind()))
}

/// Exception of a failed run.
pub fn run_error(error: &RunError) -> PyErr {
    match error {
        RunError::Case(errors) => case_error(errors),
        RunError::Output(error) => output_error(error),
        RunError::Folder { path, problem, .. } => {
            let (path, text) = (path.display().to_string(), problem.clone());
            exception("OutputError", |py| Ok((text, path).into_pyobject(py)?.unbind()))
        }
        RunError::Solver(source) | RunError::Stopped { source, .. } => solver_error(source, error.to_string()),
        other => exception("SolverError", |py| {
            Ok((other.to_string(), None::<u64>, None::<f64>, None::<u64>, None::<[f64; 3]>).into_pyobject(py)?.unbind())
        }),
    }
}
