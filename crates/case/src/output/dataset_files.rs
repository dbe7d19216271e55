//! Files for ParaView of datasets of all geometries: points, meshes, lattices and rasters.

use std::path::Path;

use vtkio::model::{Attributes, Coordinates, DataSet, Extent, IOBuffer, RectilinearGridPiece};

use crate::Lattice;
use crate::description::Compression;
use crate::output::vtk::frames::{WrittenPoints, write_mesh, write_points};
use crate::output::vtk::xml::{VtkArray, write_xml};
use crate::output::{FileChecksum, OutputError};
use crate::solver::{Dataset, DatasetGeometry, FramePoints, PlanNodes};

/// Flag of ParaView for a hidden node (`vtkDataSetAttributes::HIDDENPOINT`).
const HIDDEN: u8 = 2;

/// Name of the array of hidden-node flags in files for ParaView.
pub(super) const GHOSTS: &str = "vtkGhostType";

/// File extension of a dataset.
#[must_use]
pub fn file_extension(support: &DatasetGeometry) -> &'static str {
    match support {
        DatasetGeometry::Points(_) | DatasetGeometry::Mesh(_) => "vtu",
        DatasetGeometry::Lattice { .. } | DatasetGeometry::Raster(_) => "vtr",
    }
}

/// Writes a dataset as a file for ParaView: points and meshes as VTU, lattices and rasters as VTR. Its coordinates are shifted by `origin`
/// (m). Returns the checksum of the file.
///
/// # Errors
/// When the file cannot be written.
pub fn write_dataset(
    path: &Path,
    dataset: &Dataset,
    origin: [f64; 3],
    compression: Compression,
) -> Result<FileChecksum, OutputError> {
    let fields = &dataset.fields;
    match &dataset.geometry {
        DatasetGeometry::Points(FramePoints { ids, bodies, positions, extents }) => {
            let fields = fields.iter().collect();
            write_points(path, WrittenPoints { ids, bodies, positions, extents, fields }, origin, compression)
        }
        DatasetGeometry::Mesh(mesh) => write_mesh(path, mesh, origin, fields, compression),
        DatasetGeometry::Lattice { nodes: Lattice { low, spacing, count }, mask } => {
            let axis = |c: usize| node_coordinates(origin[c], low[c], *spacing, count[c]);
            let mut arrays: Vec<VtkArray<'_>> = fields.iter().map(VtkArray::from_field).collect();
            arrays.extend((!mask.is_empty()).then(|| VtkArray::new(GHOSTS, 1, || hidden_nodes(mask))));
            write_nodes(path, &[0, 1, 2].map(axis), arrays, compression)
        }
        DatasetGeometry::Raster(PlanNodes { columns, rows, origin: low, spacing, .. }) => {
            let axis = |c: usize, count: usize| node_coordinates(origin[c], low[c], spacing[c], count);
            let axes = [axis(0, *columns), axis(1, *rows), vec![0.0]];
            write_nodes(path, &axes, fields.iter().map(VtkArray::from_field).collect(), compression)
        }
    }
}

/// Coordinates of nodes along an axis (m).
fn node_coordinates(origin: f64, low: f64, spacing: f64, count: usize) -> Vec<f64> {
    (0..count).map(|node| origin + (low + spacing * node as f64)).collect()
}

/// Flags of ParaView that hide the nodes outside a mask.
fn hidden_nodes(mask: &[bool]) -> Vec<u8> {
    mask.iter().map(|bears| if *bears { 0 } else { HIDDEN }).collect()
}

/// Writes the fields at the nodes of a rectilinear grid as a VTR file.
fn write_nodes(
    path: &Path,
    axes: &[Vec<f64>; 3],
    point: Vec<VtkArray<'_>>,
    compression: Compression,
) -> Result<FileChecksum, OutputError> {
    let [nx, ny, nz] = [0, 1, 2].map(|c| axes[c].len() as i32 - 1);
    let [x, y, z] = axes.each_ref().map(|axis| IOBuffer::F64(axis.clone()));
    let piece = RectilinearGridPiece {
        extent: Extent::Ranges([0..=nx, 0..=ny, 0..=nz]),
        coords: Coordinates { x, y, z },
        data: Attributes { point: point.iter().map(VtkArray::without_values).collect(), cell: Vec::new() },
    };
    let coordinates = axes.iter().map(|axis| VtkArray::new("", 1, || axis.clone()));
    write_xml(path, DataSet::inline(piece), point.into_iter().chain(coordinates), compression)
}

#[cfg(test)]
mod tests {
    use vtkio::Vtk;

    use super::*;
    use crate::solver::PolygonMesh;
    use crate::{Field, FieldData};

    fn vtk_dataset(support: DatasetGeometry, data: FieldData) -> DataSet {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("all").with_extension(file_extension(&support));
        let fields = vec![Field { name: "depth".into(), unit: "m", data }];
        let dataset = Dataset { name: "all".into(), geometry: support, fields };
        write_dataset(&path, &dataset, [100.0, 0.0, 0.0], Compression::Fast).unwrap();
        let file = std::fs::File::open(&path).unwrap();
        Vtk::parse_xml(std::io::BufReader::new(file)).unwrap().data
    }

    #[test]
    fn rasters_and_lattices_have_their_nodes_on_the_map() {
        let plan = PlanNodes {
            columns: 3,
            rows: 2,
            origin: [1.0, 4.0],
            spacing: [0.5, 2.0],
            reference: colluvium_points::Georeference::default(),
        };
        let nodes = Lattice { low: [1.0, 4.0, 0.0], spacing: 0.5, count: [3, 2, 1] };
        let lattice = DatasetGeometry::Lattice { nodes, mask: vec![true, true, false, true, true, true] };
        let values = || FieldData::Scalar((0..6).map(f64::from).collect());
        for (support, upper, arrays) in [(DatasetGeometry::Raster(plan), 6.0, 1), (lattice, 4.5, 2)] {
            let DataSet::RectilinearGrid { pieces, .. } = vtk_dataset(support, values()) else {
                panic!("nodes")
            };
            let piece = pieces.into_iter().next().unwrap().into_loaded_piece_data(None).unwrap();
            assert_eq!(piece.coords.x.cast_into::<f64>().unwrap(), [101.0, 101.5, 102.0]);
            assert_eq!(piece.coords.y.cast_into::<f64>().unwrap(), [4.0, upper]);
            assert_eq!(piece.data.point.len(), arrays);
        }
    }

    #[test]
    fn nodes_and_cells_read_back_as_points() {
        let nodes = Lattice { low: [1.0, 4.0, 0.0], spacing: 0.5, count: [3, 2, 1] };
        let lattice = DatasetGeometry::Lattice { nodes, mask: vec![true, true, false, true, true, true] };
        let places = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = DatasetGeometry::Mesh(PolygonMesh {
            vertices: places,
            corners: vec![0, 2, 0, 1, 2],
            ends: vec![2, 5],
        });
        for (support, count) in [(lattice, 6), (mesh, 2)] {
            let values = FieldData::Scalar((0..count).map(f64::from).collect());
            let fields = vec![Field { name: "depth".into(), unit: "m", data: values }];
            let dataset = Dataset { name: "all".into(), geometry: support, fields };
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("all").with_extension(file_extension(&dataset.geometry));
            write_dataset(&path, &dataset, [0.0; 3], Compression::Fast).unwrap();
            assert_eq!(crate::output::read_frame(&path, 0.5).unwrap(), dataset.into_points(0.5, 0));
        }
    }

    #[test]
    fn lines_and_polygons_are_written_in_one_mesh() {
        let places = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = PolygonMesh { vertices: places, corners: vec![0, 2, 0, 1, 2], ends: vec![2, 5] };
        let set = vtk_dataset(DatasetGeometry::Mesh(mesh), FieldData::Integer(vec![7, -7]));
        let DataSet::UnstructuredGrid { pieces, .. } = set else { panic!("cells") };
        let piece = pieces.into_iter().next().unwrap().into_loaded_piece_data(None).unwrap();
        assert_eq!(piece.cells.types, [vtkio::model::CellType::Line, vtkio::model::CellType::Polygon]);
        assert_eq!(piece.points.cast_into::<f64>().unwrap()[..4], [100.0, 0.0, 0.0, 101.0]);
        assert_eq!(piece.data.cell.len(), 1);
    }
}
