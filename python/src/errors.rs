//! Python exceptions from errors of the library.

use std::fmt::Display;

use colluvium::MethodChoiceError;
use colluvium::case::output::{OutputError, Table};
use colluvium::case::run::RunError;
use colluvium::case::{CaseError, CaseErrors, SolverError};
use colluvium::compare::CompareError;
use colluvium::sweep::SweepError;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::law_errors;
use crate::tables::table_array;

/// Error of a run, a sweep or a comparison.
pub enum TaskError {
    /// The case is wrong.
    Case(CaseErrors),
    /// The run failed.
    Run(RunError),
    /// The run failed after its start, with its measures and its number of steps.
    Stopped(Box<RunError>, Box<(Table, u64)>),
    /// The sweep could not go on.
    Sweep(SweepError),
    /// There is no comparison.
    Compare(CompareError),
    /// The method is unknown or missing.
    Method(MethodChoiceError),
}

impl From<CaseErrors> for TaskError {
    fn from(errors: CaseErrors) -> Self {
        Self::Case(errors)
    }
}

impl From<CaseError> for TaskError {
    fn from(error: CaseError) -> Self {
        Self::Case(error.into())
    }
}

impl From<RunError> for TaskError {
    fn from(error: RunError) -> Self {
        Self::Run(error)
    }
}

impl From<OutputError> for TaskError {
    fn from(error: OutputError) -> Self {
        Self::Run(RunError::Output(error))
    }
}

impl From<SweepError> for TaskError {
    fn from(error: SweepError) -> Self {
        Self::Sweep(error)
    }
}

impl From<CompareError> for TaskError {
    fn from(error: CompareError) -> Self {
        Self::Compare(error)
    }
}

impl From<MethodChoiceError> for TaskError {
    fn from(error: MethodChoiceError) -> Self {
        Self::Method(error)
    }
}

impl TaskError {
    /// Exception of the error.
    pub fn into_exception(self) -> PyErr {
        match &self {
            Self::Case(errors) => case_error(errors),
            Self::Run(error) => run_error(error),
            Self::Stopped(error, part) => with_part(run_error(error), part),
            Self::Sweep(SweepError::Output(error)) => output_error(error),
            Self::Sweep(error @ SweepError::Folder { path, .. }) => folder_error(error, path),
            Self::Sweep(error) => value_error(error),
            Self::Compare(CompareError::Output(error)) => output_error(error),
            Self::Compare(error) => value_error(error),
            Self::Method(MethodChoiceError::Case(error)) => case_error(&error.clone().into()),
            Self::Method(error) => value_error(error),
        }
    }
}

/// Exception with the measures and the number of steps of the run before it.
fn with_part(error: PyErr, (table, steps): &(Table, u64)) -> PyErr {
    Python::attach(|py| {
        let set = || -> PyResult<()> {
            let value = error.value(py);
            value.setattr("_part", (table_array(py, table.columns.clone(), &table.rows)?, *steps))
        };
        set().map_or_else(|failed| failed, |()| error.clone_ref(py))
    })
}

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
    let mut cause = None;
    let mut problem = |error: &CaseError| {
        let text = error.kind.to_string();
        cause = cause.take().or_else(|| law_errors::take_cause(&text));
        (error.path.clone(), text)
    };
    let problems: Vec<(String, String)> = errors.0.iter().map(&mut problem).collect();
    let error = exception("CaseError", |py| Ok((problems,).into_pyobject(py)?.unbind()));
    Python::attach(|py| error.set_cause(py, cause));
    error
}

/// `ValueError` with a text.
pub fn value_error(problem: &dyn Display) -> PyErr {
    PyValueError::new_err(problem.to_string())
}

/// `OutputError` about a file or a folder.
pub fn output_error(error: &OutputError) -> PyErr {
    folder_error(error, &error.path)
}

/// `OutputError` with a text and a path.
pub fn folder_error(problem: &dyn Display, path: &std::path::Path) -> PyErr {
    let (path, text) = (path.to_owned(), problem.to_string());
    exception("OutputError", |py| Ok((text, path).into_pyobject(py)?.unbind()))
}

/// `SolverError` with step, time (s), point and position (m), where they are known; its cause is the exception of a law in Python.
pub fn failure(text: String, code: &str, state: Option<(u64, f64, u64, [f64; 3])>) -> PyErr {
    let cause = law_errors::take_cause(&text);
    let (step, time, point, position) = match state {
        Some((step, time, point, position)) => (Some(step), Some(time), Some(point), Some(position)),
        None => (None, None, None, None),
    };
    let error = exception("SolverError", |py| {
        Ok((text, step, time, point, position, code).into_pyobject(py)?.unbind())
    });
    Python::attach(|py| error.set_cause(py, cause));
    error
}

/// Exception of a failed solver.
fn solver_error(error: &SolverError, code: &str, text: String) -> PyErr {
    let state = match error {
        SolverError::Point { step, time, point, position, .. } => Some((*step, *time, *point, *position)),
        _ => None,
    };
    failure(text, code, state)
}

/// Exception of a failed run.
fn run_error(error: &RunError) -> PyErr {
    match error {
        RunError::Case(errors) => case_error(errors),
        RunError::Output(error) => output_error(error),
        RunError::Folder { path, problem, .. } => {
            folder_error(&format!("{}: {problem}", path.display()), path)
        }
        RunError::Solver(source) | RunError::Stopped { source, .. } => {
            solver_error(source, error.code(), error.to_string())
        }
        other => failure(other.to_string(), other.code(), None),
    }
}
