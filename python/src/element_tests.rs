//! Element tests.

use colluvium::constitutive::driver::{DriverError, TestTrace};
use pyo3::prelude::*;

use crate::errors::{case_error, failure};
use crate::runs::{TableArray, table_array};

/// Checks an element test.
///
/// # Errors
/// `CaseError` with all problems of the test.
#[pyfunction]
pub fn check_element_test(py: Python<'_>, text: &str) -> PyResult<()> {
    py.detach(|| colluvium::element_test(text)).map(drop).map_err(|errors| case_error(&errors))
}

/// Result of an element test: columns and rows of its path, the row with which each stage begins, and the error that ended it.
type TestResult<'py> = (TableArray<'py>, Vec<usize>, Option<PyErr>);

/// Runs an element test.
///
/// # Errors
/// `CaseError` with the problems of the test.
#[pyfunction]
pub fn run_element_test<'py>(py: Python<'py>, text: &str) -> PyResult<TestResult<'py>> {
    let traced = py.detach(|| colluvium::element_test(text).map(|test| test.trace()));
    let trace = traced.map_err(|errors| case_error(&errors))?;
    let TestTrace { path, stop_reason, stage_rows, .. } = trace.map_err(|error| driver_error(&error))?;
    let columns = path.columns.iter().map(|(name, unit)| ((*name).to_owned(), (*unit).to_owned()));
    let table = table_array(py, columns.collect(), &path.rows)?;
    Ok((table, stage_rows, stop_reason.as_ref().map(driver_error)))
}

/// Exception of a test that failed.
fn driver_error(error: &DriverError) -> PyErr {
    failure(error.to_string(), None)
}
