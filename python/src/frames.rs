//! Frames: points with their fields, as NumPy arrays that share the memory of the frame.

use colluvium::case::{FieldData, Snapshot};
use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{Element, PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyAny;

/// Points of a run at one time. Arrays share its memory and keep it alive; they cannot be written.
#[pyclass(frozen, module = "colluvium")]
pub struct Frame {
    snapshot: Snapshot,
}

impl Frame {
    /// Frame of a snapshot.
    pub fn new(snapshot: Snapshot) -> Self {
        Self { snapshot }
    }
}

/// Array of one number per point on the memory of a frame.
fn column<'py, T: Element>(frame: &Bound<'py, Frame>, values: &[T]) -> Bound<'py, PyAny> {
    let view = ArrayView1::from(values);
    // SAFETY: the frame owns the memory, never changes it, and is kept alive by the array.
    #[allow(unsafe_code, reason = "arrays share the memory of a frame")]
    let array = unsafe { PyArray1::borrow_from_array(&view, frame.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    array.into_any()
}

/// Array of `N` numbers per point on the memory of a frame.
fn rows<'py, const N: usize>(frame: &Bound<'py, Frame>, values: &[[f64; N]]) -> PyResult<Bound<'py, PyAny>> {
    let view = ArrayView2::from_shape((values.len(), N), values.as_flattened())
        .map_err(|error| crate::errors::value_error(&error))?;
    // SAFETY: as for columns.
    #[allow(unsafe_code, reason = "arrays share the memory of a frame")]
    let array = unsafe { PyArray2::borrow_from_array(&view, frame.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    Ok(array.into_any())
}

#[pymethods]
impl Frame {
    /// Time (s).
    #[getter]
    fn time(&self) -> f64 {
        self.snapshot.time
    }

    /// Number of steps.
    #[getter]
    fn step(&self) -> u64 {
        self.snapshot.step
    }

    /// Number of points.
    fn __len__(&self) -> usize {
        self.snapshot.positions.len()
    }

    /// Ids of the points, ascending.
    #[getter]
    fn ids<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyAny> {
        column(slf, &slf.get().snapshot.ids)
    }

    /// Number of the body of each point.
    #[getter]
    fn bodies<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyAny> {
        column(slf, &slf.get().snapshot.bodies)
    }

    /// Positions (m), one row of x, y, z per point.
    #[getter]
    fn positions<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        rows(slf, &slf.get().snapshot.positions)
    }

    /// Full widths of the points (m), one row of x, y, z per point.
    #[getter]
    fn extents<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        rows(slf, &slf.get().snapshot.extents)
    }

    /// Names of the fields with their units.
    #[getter]
    fn fields(&self) -> Vec<(String, String)> {
        self.snapshot.fields.iter().map(|field| (field.name.clone(), field.unit.to_owned())).collect()
    }

    /// Values of a field: one number per point, a row of x, y, z, or a row of xx, yy, zz, xy, yz, xz (tension-positive stress).
    fn field<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let snapshot = &slf.get().snapshot;
        let field = snapshot.field(name).ok_or_else(|| {
            let known: Vec<&str> = snapshot.fields.iter().map(|field| field.name.as_str()).collect();
            PyKeyError::new_err(format!("{name:?} is not a field of the frame; there are {}", known.join(", ")))
        })?;
        match &field.data {
            FieldData::Integer(values) => Ok(column(slf, values)),
            FieldData::Scalar(values) => Ok(column(slf, values)),
            FieldData::Vector(values) => rows(slf, values),
            FieldData::Tensor(values) => {
                let rows: Vec<Vec<f64>> = values.iter().map(|tensor| tensor.0.to_vec()).collect();
                let array = PyArray2::from_vec2(slf.py(), &rows).map_err(|error| crate::errors::value_error(&error))?;
                Ok(array.into_any())
            }
        }
    }
}
