//! Conversion of nodes and cells to points, for code that reads values at positions.

use crate::solver::frame::{Dataset, DatasetGeometry, Frame, FramePoints, Lattice, PlanNodes};
use crate::solver::snapshot::{Field, FieldData, Snapshot};

impl FieldData {
    /// Subset of the points with the numbers `kept`.
    #[must_use]
    pub fn subset(&self, kept: &[usize]) -> Self {
        /// Values at the indices `kept`.
        fn select<T: Copy>(values: &[T], kept: &[usize]) -> Vec<T> {
            kept.iter().map(|&k| values[k]).collect()
        }
        match self {
            Self::Integer(values) => Self::Integer(select(values, kept)),
            Self::Scalar(values) => Self::Scalar(select(values, kept)),
            Self::Vector(values) => Self::Vector(select(values, kept)),
            Self::Tensor(values) => Self::Tensor(select(values, kept)),
        }
    }

    /// Whether entry `k` has a value, i.e. is not NaN.
    fn is_defined(&self, k: usize) -> bool {
        match self {
            Self::Integer(_) => true,
            Self::Scalar(values) => !values[k].is_nan(),
            Self::Vector(values) => values[k].iter().any(|value| !value.is_nan()),
            Self::Tensor(values) => values[k].0.iter().any(|value| !value.is_nan()),
        }
    }
}

impl Dataset {
    /// Converts a dataset to points. Nodes with data have extents of the node spacing; cells become points at the mean of their corners,
    /// without extents. Numbers of nodes and cells become ids.
    #[must_use]
    pub fn into_points(self, time: f64, step: u64) -> Snapshot {
        let Self { geometry: support, fields, .. } = self;
        let along = |low: f64, spacing: f64, count: usize| -> Vec<f64> {
            (0..count).map(|node| low + spacing * node as f64).collect()
        };
        let (points, fields) = match support {
            DatasetGeometry::Points(points) => (points, fields),
            DatasetGeometry::Lattice { nodes: Lattice { low, spacing, count }, mask } => {
                let axes = std::array::from_fn(|c| along(low[c], spacing, count[c]));
                on_nodes(&axes, &mask, fields)
            }
            DatasetGeometry::Raster(PlanNodes { columns, rows, origin, spacing, .. }) => {
                let axes =
                    [along(origin[0], spacing[0], columns), along(origin[1], spacing[1], rows), vec![0.0]];
                on_nodes(&axes, &[], fields)
            }
            DatasetGeometry::Mesh(mesh) => {
                let middle = |corners: Vec<[f64; 3]>| {
                    let share = 1.0 / corners.len() as f64;
                    std::array::from_fn(|c| corners.iter().map(|x| x[c]).sum::<f64>() * share)
                };
                let positions: Vec<[f64; 3]> = mesh.cells().map(middle).collect();
                let ids = (0..positions.len() as u64).collect();
                (FramePoints { ids, positions, ..FramePoints::default() }, fields)
            }
        };
        let FramePoints { ids, mut bodies, positions, mut extents } = points;
        bodies.resize(ids.len(), Snapshot::NO_BODY);
        extents.resize(ids.len(), [0.0; 3]);
        Snapshot { time, step, ids, bodies, positions, extents, fields }
    }
}

/// Points at the nodes of coordinates `axes` (m) that are in `mask` (all where it is empty) and have a value.
pub(crate) fn on_nodes(axes: &[Vec<f64>; 3], mask: &[bool], fields: Vec<Field>) -> (FramePoints, Vec<Field>) {
    let [nx, ny, nz] = [0, 1, 2].map(|c| axes[c].len());
    let bears = |k: &usize| {
        let is_in = mask.get(*k).copied().unwrap_or(true);
        is_in && (fields.is_empty() || fields.iter().any(|field| field.data.is_defined(*k)))
    };
    let kept: Vec<usize> = (0..nx * ny * nz).filter(bears).collect();
    let width = [0, 1, 2].map(|c| axes[c].get(1).map_or(0.0, |next| next - axes[c][0]));
    let place = |&k: &usize| [axes[0][k % nx], axes[1][k / nx % ny], axes[2][k / (nx * ny)]];
    let points = FramePoints {
        ids: kept.iter().map(|&k| k as u64).collect(),
        bodies: Vec::new(),
        positions: kept.iter().map(place).collect(),
        extents: vec![width; kept.len()],
    };
    let fields = fields.into_iter().map(|field| Field { data: field.data.subset(&kept), ..field }).collect();
    (points, fields)
}

impl Frame {
    /// First dataset as points; `None` without datasets.
    #[must_use]
    pub fn first_as_points(&self) -> Option<Snapshot> {
        Some(self.datasets.first()?.clone().into_points(self.time, self.step))
    }

    /// Points on which measures are evaluated: the dataset on points, or else the first dataset as points.
    #[must_use]
    pub fn into_measured_points(mut self) -> Snapshot {
        let (time, step) = (self.time, self.step);
        let found = self.take_points().or_else(|| self.first_as_points());
        found.unwrap_or_else(|| Snapshot { time, step, ..Snapshot::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::PolygonMesh;

    fn scalars(values: Vec<f64>) -> Vec<Field> {
        vec![Field { name: "depth".into(), unit: "m", data: FieldData::Scalar(values) }]
    }

    #[test]
    fn active_nodes_become_points_with_the_lattice_spacing_as_extent() {
        let nodes = Lattice { low: [1.0, 4.0, 0.0], spacing: 0.5, count: [3, 2, 1] };
        let support = DatasetGeometry::Lattice { nodes, mask: vec![true, true, false, true, true, true] };
        let fields = scalars(vec![0.0, 1.0, 2.0, 3.0, f64::NAN, 5.0]);
        let found = Dataset { name: "fluid".into(), geometry: support, fields }.into_points(2.0, 7);
        assert_eq!((found.time, found.step, &found.ids[..]), (2.0, 7, &[0, 1, 3, 5][..]));
        assert_eq!(found.positions[2..], [[1.0, 4.5, 0.0], [2.0, 4.5, 0.0]]);
        assert_eq!(found.extents, vec![[0.5, 0.5, 0.0]; 4]);
        assert_eq!(found.scalars("depth"), Some(&[0.0, 1.0, 3.0, 5.0][..]));
        assert_eq!(found.bodies, [Snapshot::NO_BODY; 4]);
    }

    #[test]
    fn cells_of_a_mesh_become_points_at_their_centres() {
        let lines = PolygonMesh::of_lines(&[[[0.0; 3], [1.0, 2.0, 0.0]], [[1.0; 3], [3.0; 3]]]);
        let set = Dataset {
            name: "ribs".into(),
            geometry: DatasetGeometry::Mesh(lines),
            fields: scalars(vec![7.0, 8.0]),
        };
        let found = Frame { datasets: vec![set], ..Frame::default() }.first_as_points().unwrap();
        assert_eq!(found.positions, [[0.5, 1.0, 0.0], [2.0; 3]]);
        assert_eq!((found.ids, found.extents), (vec![0, 1], vec![[0.0; 3]; 2]));
    }
}
