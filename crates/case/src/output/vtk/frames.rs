//! Frames: points with their fields as VTU files, and the collection with the times of the frames.

use std::io::BufReader;
use std::path::Path;

use colluvium_constitutive::SymTensor;
use serde::{Deserialize, Serialize};
use vtkio::model::{
    Attribute, CellType, Coordinates, DataArray, DataSet, IOBuffer, RectilinearGridPiece,
    UnstructuredGridPiece, VertexNumbers, Vtk,
};

use crate::description::Compression;
use crate::output::vtk::xml::{VtkArray, VtkGeometry, write_unstructured};
use crate::output::{FileChecksum, OutputError, write_atomically};
use crate::solver::{Dataset, DatasetGeometry, FieldRole, PolygonMesh, on_nodes};
use crate::{Field, FieldData, Snapshot};

/// Points to be written to a file, with their fields.
pub(crate) struct WrittenPoints<'a> {
    /// Permanent numbers of the points.
    pub(crate) ids: &'a [u64],
    /// Indices of the bodies of the points; empty for methods without bodies.
    pub(crate) bodies: &'a [u32],
    /// Positions of the points (m).
    pub(crate) positions: &'a [[f64; 3]],
    /// Full widths (m); empty for points without widths.
    pub(crate) extents: &'a [[f64; 3]],
    /// Fields of the points, one value each.
    pub(crate) fields: Vec<&'a Field>,
}

/// Fields of a frame to be written, and their compression.
#[derive(Clone, Copy, Debug, Default)]
pub struct WriteOptions<'a> {
    /// Names of the fields; `None` for all.
    pub field_names: Option<&'a [String]>,
    /// Compression of the files.
    pub compression: Compression,
}

/// Writes a snapshot as a VTU file for ParaView, with one vertex per point. Its positions are shifted by `origin` (m). Ids, bodies and
/// extents are always included. Returns the checksum of the file.
///
/// # Errors
/// When the file cannot be written.
pub fn write_frame(
    path: &Path,
    snapshot: &Snapshot,
    origin: [f64; 3],
    written: WriteOptions<'_>,
) -> Result<FileChecksum, OutputError> {
    let Snapshot { ids, bodies, positions, extents, fields, .. } = snapshot;
    let wanted = |field: &&Field| written.field_names.is_none_or(|names| names.contains(&field.name));
    let fields = fields.iter().filter(wanted).collect();
    write_points(path, WrittenPoints { ids, bodies, positions, extents, fields }, origin, written.compression)
}

/// Writes points with their fields as a VTU file for ParaView, and returns the checksum of the file. Positions are shifted by `origin` (m).
pub(crate) fn write_points(
    path: &Path,
    shown: WrittenPoints<'_>,
    origin: [f64; 3],
    compression: Compression,
) -> Result<FileChecksum, OutputError> {
    let WrittenPoints { ids, bodies, positions, extents, fields } = shown;
    let count = ids.len();
    let mut point: Vec<VtkArray<'_>> = fields.into_iter().map(VtkArray::from_field).collect();
    point.push(VtkArray::new("extent", 3, || match extents {
        [] => vec![0.0; 3 * count],
        _ => extents.as_flattened().to_vec(),
    }));
    point.push(VtkArray::new("id", 1, || ids.iter().map(|id| *id as i64).collect::<Vec<_>>()));
    point.push(VtkArray::new("body", 1, || match bodies {
        [] => vec![i64::from(Snapshot::NO_BODY); count],
        _ => bodies.iter().map(|body| i64::from(*body)).collect(),
    }));
    let arrays = [
        VtkArray::new("Points", 3, || shifted_coordinates(positions, origin)),
        VtkArray::new("connectivity", 1, || (0..count as u64).collect::<Vec<_>>()),
        VtkArray::new("offsets", 1, || (1..=count as u64).collect::<Vec<_>>()),
        VtkArray::new("types", 1, || vec![CellType::Vertex as u8; count]),
    ];
    write_unstructured(
        path,
        VtkGeometry { point_count: count, cells: count, arrays },
        (point, Vec::new()),
        compression,
    )
}

/// Coordinates of positions shifted by `origin` (m), in one array.
fn shifted_coordinates(places: &[[f64; 3]], origin: [f64; 3]) -> Vec<f64> {
    let mut all = places.as_flattened().to_vec();
    if origin != [0.0; 3] {
        all.iter_mut().zip(origin.into_iter().cycle()).for_each(|(x, by)| *x += by);
    }
    all
}

/// Writes a mesh with fields on its cells as a VTU file for ParaView, and returns the checksum of the file. Vertices are shifted by
/// `origin` (m).
pub(crate) fn write_mesh(
    path: &Path,
    mesh: &PolygonMesh,
    origin: [f64; 3],
    fields: &[Field],
    compression: Compression,
) -> Result<FileChecksum, OutputError> {
    let kinds = || {
        let starts = std::iter::once(0).chain(mesh.ends.iter().copied());
        let kind = |(start, end): (u64, &u64)| match end - start {
            1 => CellType::Vertex,
            2 => CellType::Line,
            _ => CellType::Polygon,
        };
        starts.zip(&mesh.ends).map(kind).map(|kind| kind as u8).collect::<Vec<_>>()
    };
    let arrays = [
        VtkArray::new("Points", 3, || shifted_coordinates(&mesh.vertices, origin)),
        VtkArray::new("connectivity", 1, || mesh.corners.clone()),
        VtkArray::new("offsets", 1, || mesh.ends.clone()),
        VtkArray::new("types", 1, kinds),
    ];
    let geometry = VtkGeometry { point_count: mesh.vertices.len(), cells: mesh.ends.len(), arrays };
    write_unstructured(
        path,
        geometry,
        (Vec::new(), fields.iter().map(VtkArray::from_field).collect()),
        compression,
    )
}

/// Reads the lines in a frame file, such as contacts, with their fields; `None` where the file contains no lines.
///
/// # Errors
/// When the file cannot be read or is not a frame.
pub fn read_lines(path: &Path) -> Result<Option<Dataset>, OutputError> {
    let DataSet::UnstructuredGrid { pieces, .. } = read(path)? else { return Ok(None) };
    let Some(piece) = pieces.into_iter().next() else { return Ok(None) };
    let piece = piece.into_loaded_piece_data(None).map_err(|error| OutputError::new(path, error))?;
    if piece.cells.types.iter().any(|kind| *kind != CellType::Line) {
        return Ok(None);
    }
    let fields = Arrays::from_attributes(piece.data.cell).fields;
    let mesh =
        mesh(&piece.points, piece.cells.cell_verts).map_err(|problem| OutputError::new(path, problem))?;
    Ok(Some(Dataset { name: String::new(), geometry: DatasetGeometry::Mesh(mesh), fields }))
}

/// Reads the dataset of a file.
fn read(path: &Path) -> Result<DataSet, OutputError> {
    let file = std::fs::File::open(path).map_err(|error| OutputError::new(path, error))?;
    let vtk = Vtk::parse_xml(BufReader::new(file)).map_err(|error| OutputError::new(path, error))?;
    Ok(vtk.data)
}

/// Reads a frame file at the given time as points. Nodes of a lattice or a raster with values, and centres of the cells of a mesh, become
/// points too ([`Dataset::into_points`]).
///
/// # Errors
/// When the file cannot be read or is not such a frame.
pub fn read_frame(path: &Path, time: f64) -> Result<Snapshot, OutputError> {
    let fail = |problem: &str| OutputError::new(path, problem);
    match read(path)? {
        DataSet::UnstructuredGrid { pieces, .. } => {
            let piece = pieces.into_iter().next().ok_or_else(|| fail("has no piece"))?;
            let piece = piece.into_loaded_piece_data(None).map_err(|error| OutputError::new(path, error))?;
            read_cells(piece, time).map_err(fail)
        }
        DataSet::RectilinearGrid { pieces, .. } => {
            let piece = pieces.into_iter().next().ok_or_else(|| fail("has no piece"))?;
            let piece = piece.into_loaded_piece_data(None).map_err(|error| OutputError::new(path, error))?;
            read_nodes(piece, time).map_err(fail)
        }
        _ => Err(fail("is neither points, cells nor nodes")),
    }
}

/// Reads points, or the cells of a mesh, as a snapshot.
fn read_cells(piece: UnstructuredGridPiece, time: f64) -> Result<Snapshot, &'static str> {
    if piece.cells.types.iter().any(|kind| *kind != CellType::Vertex) {
        let support = DatasetGeometry::Mesh(mesh(&piece.points, piece.cells.cell_verts)?);
        let fields = Arrays::from_attributes(piece.data.cell).fields;
        return Ok(Dataset { name: String::new(), geometry: support, fields }.into_points(time, 0));
    }
    let places = positions(&piece.points)?;
    let Arrays { fields, ids, bodies, extents, .. } = Arrays::from_attributes(piece.data.point);
    let count = places.len();
    Ok(Snapshot {
        time,
        step: 0,
        ids: ids.unwrap_or_else(|| (0..count as u64).collect()),
        bodies: bodies.unwrap_or_else(|| vec![0; count]),
        extents: extents.unwrap_or_else(|| vec![[0.0; 3]; count]),
        positions: places,
        fields,
    })
}

/// Positions of points read from a file (m).
fn positions(points: &IOBuffer) -> Result<Vec<[f64; 3]>, &'static str> {
    let points = points.cast_into::<f64>().ok_or("has no positions")?;
    Ok(points.as_chunks().0.to_vec())
}

/// Polygon mesh from the vertices and cells of a file.
fn mesh(points: &IOBuffer, cells: VertexNumbers) -> Result<PolygonMesh, &'static str> {
    let VertexNumbers::XML { connectivity: corners, offsets: ends } = cells else {
        return Err("has cells of the old format");
    };
    Ok(PolygonMesh { vertices: positions(points)?, corners, ends })
}

/// Reads the nodes of a lattice or of a raster as a snapshot.
fn read_nodes(piece: RectilinearGridPiece, time: f64) -> Result<Snapshot, &'static str> {
    let Coordinates { x, y, z } = piece.coords;
    let axis = |values: IOBuffer| values.cast_into::<f64>().ok_or("has no coordinates");
    let Arrays { fields, mask, .. } = Arrays::from_attributes(piece.data.point);
    let (points, fields) = on_nodes(&[axis(x)?, axis(y)?, axis(z)?], &mask, fields);
    Ok(Dataset { name: String::new(), geometry: DatasetGeometry::Points(points), fields }
        .into_points(time, 0))
}

/// Arrays read from a file: ids, bodies and widths of the points, and fields.
#[derive(Default)]
struct Arrays {
    fields: Vec<Field>,
    ids: Option<Vec<u64>>,
    bodies: Option<Vec<u32>>,
    extents: Option<Vec<[f64; 3]>>,
    /// Whether each node is shown; empty where all are.
    mask: Vec<bool>,
}

impl Arrays {
    /// Sorts the data arrays of a file into permanent numbers, bodies, widths and fields.
    fn from_attributes(attributes: Vec<Attribute>) -> Self {
        let mut arrays = Self::default();
        for attribute in attributes {
            let Attribute::DataArray(array) = attribute else { continue };
            arrays.add(&array);
        }
        arrays
    }

    /// Adds a data array of a file, by its name and number of components.
    fn add(&mut self, array: &DataArray) {
        let components = array.elem.num_comp();
        let name = array.name.as_str();
        let mut push =
            |data: FieldData| self.fields.push(Field { name: name.to_owned(), unit: unit_of(name), data });
        if let (IOBuffer::I64(values), false) = (&array.data, ["id", "body"].contains(&name)) {
            push(FieldData::Integer(values.clone()));
            return;
        }
        let Some(values) = array.data.cast_into::<f64>() else { return };
        match (name, components) {
            ("id", _) => self.ids = Some(values.iter().map(|v| *v as u64).collect()),
            ("body", _) => self.bodies = Some(values.iter().map(|v| *v as u32).collect()),
            ("extent", _) => self.extents = Some(values.as_chunks().0.to_vec()),
            (crate::output::dataset_files::GHOSTS, _) => {
                self.mask = values.iter().map(|v| *v == 0.0).collect();
            }
            (_, 3) => push(FieldData::Vector(values.as_chunks().0.to_vec())),
            (_, 9) => {
                let symmetric = |c: &[f64; 9]| SymTensor([c[0], c[4], c[8], c[1], c[5], c[6]]);
                push(FieldData::Tensor(values.as_chunks().0.iter().map(symmetric).collect()));
            }
            _ => push(FieldData::Scalar(values)),
        }
    }
}

/// Unit of a field that every method has; files do not contain units.
fn unit_of(name: &str) -> &'static str {
    if let Some(role) = FieldRole::from_name(name) {
        return role.unit();
    }
    match name {
        "displacement" | "height" | "radius" | "smoothing_length" | "overlap" => "m",
        "force" | "normal_force" | "tangential_force" => "N",
        "stress" | "pressure" | "deviatoric_stress" | "pore_pressure" | "excess_pore_pressure" => "Pa",
        "density" => "kg/m3",
        _ => "",
    }
}

/// List of the frame files of a run with their times: a PVD file for ParaView.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Collection {
    /// Time (s) and file name, relative to the collection, of each frame.
    pub frames: Vec<(f64, String)>,
}

impl Collection {
    /// Prefix of the names of point files.
    pub const POINTS: &'static str = "frame";

    /// Times (s) and file names of the point frames; empty for methods without points.
    #[must_use]
    pub fn of_points(self) -> Vec<(f64, String)> {
        let mut frames = self.frames;
        frames.retain(|(_, file)| {
            let name = file.rsplit_once('/').map_or(&**file, |(_, name)| name);
            name.strip_prefix(Self::POINTS).is_some_and(|rest| rest.starts_with('-'))
        });
        frames
    }

    /// Writes the collection.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n  <Collection>\n",
        );
        for (time, file) in &self.frames {
            text.push_str(&format!("    <DataSet timestep=\"{time:?}\" part=\"0\" file=\"{file}\"/>\n"));
        }
        text.push_str("  </Collection>\n</VTKFile>\n");
        write_atomically(path, text.as_bytes())
    }

    /// Reads a collection written by [`Collection::write`].
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn read(path: &Path) -> Result<Self, OutputError> {
        let text = std::fs::read_to_string(path).map_err(|error| OutputError::new(path, error))?;
        let attribute = |line: &str, name: &str| {
            let start = line.find(&format!("{name}=\""))? + name.len() + 2;
            Some(line[start..].split('"').next()?.to_owned())
        };
        let frame = |line: &str| Some((attribute(line, "timestep")?.parse().ok()?, attribute(line, "file")?));
        let sets = text.lines().filter(|line| line.contains("<DataSet"));
        let frames: Option<Vec<_>> = sets.map(frame).collect();
        match frames.filter(|_| text.contains("<Collection") && text.contains("</Collection>")) {
            Some(frames) => Ok(Self { frames }),
            None => Err(OutputError::new(path, "is not a complete list of frames")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_read_back_bit_identically() {
        let snapshot = Snapshot {
            time: 0.25,
            step: 0,
            ids: vec![3, 5],
            bodies: vec![0, 1],
            positions: vec![[0.1, 0.2, 0.0], [1.0 / 3.0, -2.0, 1e-30]],
            extents: vec![[0.05; 3], [0.1; 3]],
            fields: vec![
                Field {
                    name: "velocity".into(),
                    unit: "m/s",
                    data: FieldData::Vector(vec![[1.0, 2.0, 3.0]; 2]),
                },
                Field { name: "plastic_strain".into(), unit: "", data: FieldData::Scalar(vec![0.7, 1e-9]) },
                Field { name: "grains".into(), unit: "", data: FieldData::Integer(vec![-3, 1 << 60]) },
                Field {
                    name: "stress".into(),
                    unit: "Pa",
                    data: FieldData::Tensor(vec![SymTensor([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]); 2]),
                },
            ],
        };
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("frame.vtu");
        write_frame(&path, &snapshot, [0.0; 3], WriteOptions::default()).unwrap();
        assert_eq!(read_frame(&path, 0.25).unwrap(), snapshot);
        for compression in [Compression::None, Compression::Best] {
            write_frame(&path, &snapshot, [0.0; 3], WriteOptions { compression, ..WriteOptions::default() })
                .unwrap();
            assert_eq!(read_frame(&path, 0.25).unwrap(), snapshot);
        }
        let stress = WriteOptions { field_names: Some(&["stress".to_owned()]), ..WriteOptions::default() };
        write_frame(&path, &snapshot, [0.0; 3], stress).unwrap();
        assert_eq!(read_frame(&path, 0.25).unwrap().fields.len(), 1);
    }

    #[test]
    fn a_collection_keeps_times_and_files() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("frames.pvd");
        let frames = vec![(0.0, "frames/a.vtu".to_owned()), (0.1, "frames/b.vtu".to_owned())];
        let collection = Collection { frames };
        collection.write(&path).unwrap();
        assert_eq!(Collection::read(&path).unwrap(), collection);
        let of_lattice = (0.2, "frames/fluid-00002.vtr".to_owned());
        let of_points = (0.3, "frames/frame-00003.vtu".to_owned());
        assert_eq!(Collection { frames: vec![of_lattice, of_points.clone()] }.of_points(), [of_points]);
    }
}
