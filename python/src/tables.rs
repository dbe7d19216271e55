//! Tables as arrays.

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

/// Names, units and rows of a table.
pub type TableArray<'py> = (Vec<(String, String)>, Bound<'py, PyArray2<f64>>);

/// Table as an array of its rows.
pub fn table_array<'py>(
    py: Python<'py>,
    columns: Vec<(String, String)>,
    rows: &[Vec<f64>],
) -> PyResult<TableArray<'py>> {
    let values: Vec<f64> = rows.iter().flatten().copied().collect();
    let array = PyArray1::from_vec(py, values).reshape([rows.len(), columns.len()])?;
    Ok((columns, array))
}
