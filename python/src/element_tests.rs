//! Element tests.

use colluvium::constitutive::driver::{DriverError, TestTrace};
use pyo3::exceptions::PyException;
use pyo3::prelude::*;

use crate::errors::{case_error, failure};
use crate::law_errors::with_first;
use crate::tables::{TableArray, table_array};

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
    let run = || colluvium::element_test(text).map(|test| test.trace());
    let (traced, raised) = py.detach(|| with_first(run));
    // The driver tries strains that it may leave again; an exception of a law is an error in each of them.
    if let Some(error) = raised.as_ref().filter(|error| !error.is_instance_of::<PyException>(py)) {
        return Err(error.clone_ref(py));
    }
    let trace = traced.map_err(|errors| case_error(&errors))?;
    let TestTrace { path, stop_reason, stage_rows, .. } = trace.map_err(|error| driver_error(&error))?;
    let error = match raised {
        Some(raised) => {
            let failed = failure(format!("the law raised {raised}"), "test-law", None);
            failed.set_cause(py, Some(raised));
            Some(failed)
        }
        None => stop_reason.as_ref().map(driver_error),
    };
    let columns = path.columns.iter().map(|(name, unit)| ((*name).to_owned(), (*unit).to_owned()));
    let table = table_array(py, columns.collect(), &path.rows)?;
    Ok((table, stage_rows, error))
}

/// Exception of a test that failed.
fn driver_error(error: &DriverError) -> PyErr {
    failure(error.to_string(), error.code(), None)
}
