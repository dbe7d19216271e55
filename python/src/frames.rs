//! Frames: datasets with their fields, as NumPy arrays that share the memory of the frame, and rasters.

use colluvium::case::{Dataset, DatasetGeometry, FieldData, Frame};
use colluvium::points::Raster;
use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{Element, PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyAny;

/// State of a run at one time.
#[pyclass(frozen, module = "colluvium._native")]
pub struct FrameData {
    /// Time (s).
    #[pyo3(get)]
    time: f64,
    /// Number of steps.
    #[pyo3(get)]
    step: u64,
    /// Datasets of the frame.
    datasets: Vec<Py<DatasetData>>,
}

impl FrameData {
    /// Frame of the library, which is moved.
    pub fn new(py: Python<'_>, frame: Frame) -> PyResult<Py<Self>> {
        let Frame { time, step, datasets } = frame;
        let datasets = datasets.into_iter().map(|dataset| Py::new(py, DatasetData { dataset }));
        Py::new(py, Self { time, step, datasets: datasets.collect::<PyResult<_>>()? })
    }
}

#[pymethods]
impl FrameData {
    /// Datasets of the frame.
    #[getter]
    fn datasets(&self, py: Python<'_>) -> Vec<Py<DatasetData>> {
        self.datasets.iter().map(|dataset| dataset.clone_ref(py)).collect()
    }
}

/// Fields on a common geometry. Arrays share its memory and keep it alive; they cannot be written.
#[pyclass(frozen, module = "colluvium._native")]
pub struct DatasetData {
    dataset: Dataset,
}

/// Array of one number per point on the memory of a dataset.
fn column<'py, T: Element>(owner: &Bound<'py, DatasetData>, values: &[T]) -> Bound<'py, PyAny> {
    let view = ArrayView1::from(values);
    // SAFETY: the dataset owns the memory, never changes it, and is kept alive by the array.
    #[allow(unsafe_code, reason = "arrays share the memory of a frame")]
    let array = unsafe { PyArray1::borrow_from_array(&view, owner.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    array.into_any()
}

/// Array of `width` numbers per point on the memory of a dataset.
fn rows<'py>(owner: &Bound<'py, DatasetData>, values: &[f64], width: usize) -> PyResult<Bound<'py, PyAny>> {
    let view = ArrayView2::from_shape((values.len() / width, width), values)
        .map_err(|error| crate::errors::value_error(&error))?;
    // SAFETY: as for columns.
    #[allow(unsafe_code, reason = "arrays share the memory of a frame")]
    let array = unsafe { PyArray2::borrow_from_array(&view, owner.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    Ok(array.into_any())
}

impl DatasetData {
    /// Error for a part that the geometry does not have.
    fn missing(&self, part: &str) -> PyErr {
        PyValueError::new_err(format!(
            "the dataset {:?} is on {} and has no {part}",
            self.dataset.name,
            self.kind()
        ))
    }
}

#[pymethods]
impl DatasetData {
    /// Name of the dataset.
    #[getter]
    fn name(&self) -> &str {
        &self.dataset.name
    }

    /// Geometry: `points`, `lattice`, `raster` or `mesh`.
    #[getter]
    fn kind(&self) -> &'static str {
        match self.dataset.geometry {
            DatasetGeometry::Points(_) => "points",
            DatasetGeometry::Lattice { .. } => "lattice",
            DatasetGeometry::Raster(_) => "raster",
            DatasetGeometry::Mesh(_) => "mesh",
        }
    }

    /// Names of the fields with their units.
    #[getter]
    fn fields(&self) -> Vec<(String, String)> {
        self.dataset.fields.iter().map(|field| (field.name.clone(), field.unit.to_owned())).collect()
    }

    /// Ids of the points, ascending.
    #[getter]
    fn ids<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        match &slf.get().dataset.geometry {
            DatasetGeometry::Points(points) => Ok(column(slf, &points.ids)),
            _ => Err(slf.get().missing("points")),
        }
    }

    /// Number of the body of each point.
    #[getter]
    fn bodies<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        match &slf.get().dataset.geometry {
            DatasetGeometry::Points(points) => Ok(column(slf, &points.bodies)),
            _ => Err(slf.get().missing("points")),
        }
    }

    /// Positions of points, or of the vertices of a mesh (m): one row of x, y, z each.
    #[getter]
    fn positions<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        match &slf.get().dataset.geometry {
            DatasetGeometry::Points(points) => rows(slf, points.positions.as_flattened(), 3),
            DatasetGeometry::Mesh(mesh) => rows(slf, mesh.vertices.as_flattened(), 3),
            _ => Err(slf.get().missing("positions")),
        }
    }

    /// Full widths of the points (m), one row of x, y, z per point.
    #[getter]
    fn extents<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        match &slf.get().dataset.geometry {
            DatasetGeometry::Points(points) => rows(slf, points.extents.as_flattened(), 3),
            _ => Err(slf.get().missing("points")),
        }
    }

    /// Numbers of the vertices of all cells of a mesh, one cell after the other.
    #[getter]
    fn corners<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        match &slf.get().dataset.geometry {
            DatasetGeometry::Mesh(mesh) => Ok(column(slf, &mesh.corners)),
            _ => Err(slf.get().missing("cells")),
        }
    }

    /// End of each cell of a mesh in `corners`.
    #[getter]
    fn ends<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        match &slf.get().dataset.geometry {
            DatasetGeometry::Mesh(mesh) => Ok(column(slf, &mesh.ends)),
            _ => Err(slf.get().missing("cells")),
        }
    }

    /// First node (m), distance of the nodes along each axis (m) and number of nodes along each axis of a lattice or raster. Values of nodes
    /// are in the order with x fastest.
    #[getter]
    fn nodes(&self) -> PyResult<([f64; 3], [f64; 3], [usize; 3])> {
        match &self.dataset.geometry {
            DatasetGeometry::Lattice { nodes, .. } => Ok((nodes.low, [nodes.spacing; 3], nodes.count)),
            DatasetGeometry::Raster(nodes) => Ok((
                [nodes.origin[0], nodes.origin[1], 0.0],
                [nodes.spacing[0], nodes.spacing[1], 0.0],
                [nodes.columns, nodes.rows, 1],
            )),
            _ => Err(self.missing("nodes")),
        }
    }

    /// EPSG code of a raster.
    #[getter]
    fn epsg(&self) -> Option<u32> {
        match &self.dataset.geometry {
            DatasetGeometry::Raster(nodes) => nodes.reference.epsg,
            _ => None,
        }
    }

    /// Whether each node of a lattice has data; empty where all have.
    #[getter]
    fn mask(&self) -> PyResult<Vec<bool>> {
        match &self.dataset.geometry {
            DatasetGeometry::Lattice { mask, .. } => Ok(mask.clone()),
            _ => Err(self.missing("mask")),
        }
    }

    /// Values of a field: one number each, a row of x, y, z, or a row of xx, yy, zz, xy, yz, zx (tension-positive stress).
    fn field<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let dataset = &slf.get().dataset;
        let field = dataset.fields.iter().find(|field| field.name == name).ok_or_else(|| {
            let known: Vec<&str> = dataset.fields.iter().map(|field| field.name.as_str()).collect();
            PyKeyError::new_err(format!(
                "{name:?} is not a field of {:?}; there are {}",
                dataset.name,
                known.join(", ")
            ))
        })?;
        match &field.data {
            FieldData::Integer(values) => Ok(column(slf, values)),
            FieldData::Scalar(values) => Ok(column(slf, values)),
            FieldData::Vector(values) => rows(slf, values.as_flattened(), 3),
            FieldData::Tensor(values) => {
                // SAFETY: a tensor has the memory layout of its six components.
                #[allow(unsafe_code, reason = "arrays share the memory of a frame")]
                let components =
                    unsafe { std::slice::from_raw_parts(values.as_ptr().cast::<f64>(), 6 * values.len()) };
                rows(slf, components, 6)
            }
        }
    }
}

/// Raster with its name and unit.
#[pyclass(frozen, module = "colluvium._native")]
#[derive(Clone)]
pub struct RasterData {
    name: String,
    unit: String,
    raster: Raster,
}

impl RasterData {
    /// Raster of a quantity.
    pub fn new(name: &str, unit: &str, raster: Raster) -> Self {
        Self { name: name.to_owned(), unit: unit.to_owned(), raster }
    }

    /// Raster of the library.
    pub fn raster(&self) -> &Raster {
        &self.raster
    }
}

#[pymethods]
impl RasterData {
    /// Name in snake case.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// SI unit.
    #[getter]
    fn unit(&self) -> &str {
        &self.unit
    }

    /// First node (m) and distance of the nodes (m) along x and y.
    #[getter]
    fn nodes(&self) -> ([f64; 2], [f64; 2]) {
        (self.raster.origin, self.raster.spacing)
    }

    /// EPSG code of the coordinate reference system.
    #[getter]
    fn epsg(&self) -> Option<u32> {
        self.raster.reference.epsg
    }

    /// Name or text of the coordinate reference system.
    #[getter]
    fn crs(&self) -> Option<String> {
        self.raster.reference.crs.clone()
    }

    /// Values, one row per y from the smallest; NaN where there is none.
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let shape = [self.raster.rows, self.raster.columns];
        PyArray1::from_slice(py, &self.raster.values).reshape(shape)
    }
}
