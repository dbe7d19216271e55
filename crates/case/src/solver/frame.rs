//! Output frames: named datasets on points, lattices, plan rasters or meshes.

use colluvium_points::{Georeference, Raster};

use super::{Field, FieldData, Snapshot};

/// State of a solver at an instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Time of the state (s).
    pub time: f64,
    /// Number of steps.
    pub step: u64,
    /// Datasets, each with its own name.
    pub datasets: Vec<Dataset>,
}

/// Fields on a common geometry.
#[derive(Clone, Debug, PartialEq)]
pub struct Dataset {
    /// Name in lower case, with which its files begin.
    pub name: String,
    /// Geometry of the fields.
    pub geometry: DatasetGeometry,
    /// One value for each point, node or cell.
    pub fields: Vec<Field>,
}

/// Geometry on which the fields of a [`Dataset`] are defined.
#[derive(Clone, Debug, PartialEq)]
pub enum DatasetGeometry {
    /// Points.
    Points(FramePoints),
    /// Nodes of a regular lattice.
    Lattice {
        /// The nodes.
        nodes: Lattice,
        /// Whether each node has data; empty where all have.
        mask: Vec<bool>,
    },
    /// Nodes in plan, with their georeference. Fields are NaN at nodes without data.
    Raster(PlanNodes),
    /// Lines and polygons; fields are per cell.
    Mesh(PolygonMesh),
}

/// Points of a frame, sorted by id. Points may be created and removed; an id always belongs to the same point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FramePoints {
    /// Permanent numbers of the points, ascending.
    pub ids: Vec<u64>,
    /// Index into `Case::bodies` of each point; empty for methods without bodies.
    pub bodies: Vec<u32>,
    /// Positions (m); unused components are zero.
    pub positions: Vec<[f64; 3]>,
    /// Full widths of the domains of the points (m); empty for points without widths.
    pub extents: Vec<[f64; 3]>,
}

/// Nodes of a regular lattice, with the index along the first axis varying fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// First node (m).
    pub low: [f64; 3],
    /// Distance of the nodes along each axis (m).
    pub spacing: f64,
    /// Number of nodes along each axis; one along axes that the space does not have.
    pub count: [usize; 3],
}

/// Nodes of a raster, in the order of [`Raster::values`].
#[derive(Clone, Debug, PartialEq)]
pub struct PlanNodes {
    /// Number of nodes along x.
    pub columns: usize,
    /// Number of nodes along y.
    pub rows: usize,
    /// Node with the smallest x and y (m).
    pub origin: [f64; 2],
    /// Distance of the nodes along x and y (m).
    pub spacing: [f64; 2],
    /// Georeference of the raster.
    pub reference: Georeference,
}

/// Lines and polygons between vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolygonMesh {
    /// Positions of the vertices (m).
    pub vertices: Vec<[f64; 3]>,
    /// Vertex numbers of the cells, one cell after the other: two for a line, those of a polygon in order.
    pub corners: Vec<u64>,
    /// End of each cell in `corners`.
    pub ends: Vec<u64>,
}

/// Raster of a quantity in plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanRaster {
    /// Name in snake case, as in its file names.
    pub name: String,
    /// SI unit of the values.
    pub unit: &'static str,
    /// Values; NaN where there is none.
    pub raster: Raster,
}

/// Role of a field, independent of the method. A field with a role has its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldRole {
    /// Mass (kg).
    Mass,
    /// Volume (m³; m² × 1 m in the plane, per radian in axisymmetry).
    Volume,
    /// Velocity (m/s).
    Velocity,
    /// Depth of a flow over its bed (m).
    Depth,
    /// Height of the bed (m).
    Bed,
}

impl FieldRole {
    /// All roles.
    const ALL: [Self; 5] = [Self::Mass, Self::Volume, Self::Velocity, Self::Depth, Self::Bed];

    /// Name of fields with this role.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mass => "mass",
            Self::Volume => "volume",
            Self::Velocity => "velocity",
            Self::Depth => "depth",
            Self::Bed => "bed",
        }
    }

    /// SI unit of fields with this role.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Mass => "kg",
            Self::Volume => "m3",
            Self::Velocity => "m/s",
            Self::Depth | Self::Bed => "m",
        }
    }

    /// Whether the quantity is extensive: a sum over points has a meaning, an average has none.
    #[must_use]
    pub const fn is_amount(self) -> bool {
        matches!(self, Self::Mass | Self::Volume)
    }

    /// Role of fields with a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|role| role.name() == name)
    }
}

/// Datasets and fields of a frame that a caller requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameRequest<'a> {
    /// Points with all fields, or the first dataset of the method in place of them.
    Measured,
    /// All datasets that the case requests for its frames.
    Requested,
    /// Dataset of [`FrameRequest::Measured`] with the fields of these names only; ids, bodies, positions and extents are always there.
    Fields(&'a [&'a str]),
}

impl FrameRequest<'_> {
    /// Whether the request includes a field.
    #[must_use]
    pub fn includes(&self, field: &str) -> bool {
        match self {
            Self::Measured | Self::Requested => true,
            Self::Fields(names) => names.contains(&field),
        }
    }
}

impl Dataset {
    /// Name of the dataset on points.
    pub const POINTS: &'static str = "points";
    /// Name of the dataset on the nodes of `output.grid`.
    pub const GRID: &'static str = "grid";
    /// Name of the dataset on the contacts of `output.contacts`.
    pub const CONTACTS: &'static str = "contacts";

    /// Dataset of a raster.
    #[must_use]
    pub fn of_raster(PlanRaster { name, unit, raster }: PlanRaster) -> Self {
        let Raster { columns, rows, origin, spacing, values, reference } = raster;
        let support = DatasetGeometry::Raster(PlanNodes { columns, rows, origin, spacing, reference });
        let field = Field { name: name.clone(), unit, data: FieldData::Scalar(values) };
        Self { name, geometry: support, fields: vec![field] }
    }

    /// Scalar fields as rasters; empty for other geometries.
    pub fn rasters(&self) -> impl Iterator<Item = PlanRaster> {
        let nodes = match &self.geometry {
            DatasetGeometry::Raster(nodes) => Some(nodes),
            _ => None,
        };
        nodes.into_iter().flat_map(|nodes| {
            self.fields.iter().filter_map(move |field| {
                let FieldData::Scalar(values) = &field.data else { return None };
                let raster = nodes.with_values(values.clone());
                Some(PlanRaster { name: field.name.clone(), unit: field.unit, raster })
            })
        })
    }
}

impl PlanNodes {
    /// Raster of these values.
    #[must_use]
    pub fn with_values(&self, values: Vec<f64>) -> Raster {
        let Self { columns, rows, origin, spacing, ref reference } = *self;
        Raster { columns, rows, origin, spacing, values, reference: reference.clone() }
    }
}

impl PolygonMesh {
    /// Lines between pairs of positions (m).
    #[must_use]
    pub fn of_lines(lines: &[[[f64; 3]; 2]]) -> Self {
        Self {
            vertices: lines.as_flattened().to_vec(),
            corners: (0..2 * lines.len() as u64).collect(),
            ends: (1..=lines.len() as u64).map(|line| 2 * line).collect(),
        }
    }

    /// Corner positions of each cell (m).
    pub fn cells(&self) -> impl Iterator<Item = Vec<[f64; 3]>> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, end)| {
            let corners = &self.corners[start as usize..*end as usize];
            corners.iter().map(|corner| self.vertices[*corner as usize]).collect()
        })
    }
}

impl Frame {
    /// Dataset with the name `name`.
    #[must_use]
    pub fn dataset(&self, name: &str) -> Option<&Dataset> {
        self.datasets.iter().find(|dataset| dataset.name == name)
    }

    /// Frame with an additional dataset.
    #[must_use]
    pub fn with_dataset(mut self, dataset: Dataset) -> Self {
        self.datasets.push(dataset);
        self
    }

    /// Removes the dataset on points and returns it.
    #[must_use]
    pub fn take_points(&mut self) -> Option<Snapshot> {
        let on_points = |dataset: &Dataset| matches!(dataset.geometry, DatasetGeometry::Points(_));
        let number = self.datasets.iter().position(on_points)?;
        Some(self.datasets.remove(number).into_points(self.time, self.step))
    }

    /// Inserts a dataset on points before the other datasets.
    #[cfg(feature = "output")]
    pub(crate) fn insert_points(&mut self, points: Snapshot) {
        self.datasets.splice(0..0, Self::from(points).datasets);
    }
}

impl From<Snapshot> for Frame {
    fn from(snapshot: Snapshot) -> Self {
        let Snapshot { time, step, ids, bodies, positions, extents, fields } = snapshot;
        let support = DatasetGeometry::Points(FramePoints { ids, bodies, positions, extents });
        Self {
            time,
            step,
            datasets: vec![Dataset { name: Dataset::POINTS.to_owned(), geometry: support, fields }],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn snapshot() -> Snapshot {
        Snapshot {
            time: 2.0,
            step: 5,
            ids: vec![3, 8],
            bodies: vec![1, 0],
            positions: vec![[1.0; 3], [2.0; 3]],
            extents: vec![[0.5; 3]; 2],
            fields: vec![Field { name: "kind".into(), unit: "", data: FieldData::Integer(vec![-1, 7]) }],
        }
    }

    #[test]
    fn points_taken_out_of_a_frame_are_unchanged_and_other_datasets_remain() {
        let lines = PolygonMesh::of_lines(&[[[0.0; 3], [1.0; 3]]]);
        let contacts =
            Dataset { name: "contacts".into(), geometry: DatasetGeometry::Mesh(lines), fields: Vec::new() };
        let mut frame = Frame::from(snapshot()).with_dataset(contacts.clone());
        assert_eq!(frame.take_points(), Some(snapshot()));
        assert_eq!(frame.take_points(), None);
        assert_eq!(frame.datasets, [contacts]);
    }

    #[test]
    fn points_may_be_of_no_body_and_have_no_width() {
        let mut frame = Frame::from(snapshot());
        let DatasetGeometry::Points(points) = &mut frame.datasets[0].geometry else { panic!("points") };
        (points.bodies, points.extents) = (Vec::new(), Vec::new());
        let snapshot = frame.take_points().unwrap();
        assert_eq!((snapshot.bodies, snapshot.extents), (vec![Snapshot::NO_BODY; 2], vec![[0.0; 3]; 2]));
    }

    #[test]
    fn rasters_are_recovered_from_a_dataset() {
        let raster = Raster {
            columns: 2,
            rows: 1,
            origin: [3.0, 4.0],
            spacing: [1.0, 2.0],
            values: vec![5.0, 6.0],
            reference: Georeference { epsg: Some(2056), ..Georeference::default() },
        };
        let own = PlanRaster { name: "peak".into(), unit: "m", raster };
        let dataset = Dataset::of_raster(own.clone());
        assert_eq!(dataset.rasters().collect::<Vec<_>>(), [own]);
        assert_eq!(Frame::from(snapshot()).datasets[0].rasters().count(), 0);
    }

    #[test]
    fn cells_of_a_mesh_have_their_corners() {
        let places = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = PolygonMesh { vertices: places.clone(), corners: vec![0, 2, 0, 1, 2], ends: vec![2, 5] };
        assert_eq!(mesh.cells().collect::<Vec<_>>(), [vec![places[0], places[2]], places]);
    }
}
