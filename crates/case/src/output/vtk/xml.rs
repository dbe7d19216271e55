//! Compressed XML files of VTK, written with one array at a time in memory.

use std::io::{self, Write};
use std::path::Path;

use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataArray, DataSet, ElementType, IOBuffer,
    UnstructuredGridPiece, Version, VertexNumbers, Vtk,
};
use vtkio::xml::{self, Compressor, DataArrayFormat, se};

use crate::description::Compression;
use crate::output::atomic_files::write_stream_atomically;
use crate::output::vtk::encoding;
use crate::output::{ChecksumWriter, FileChecksum, OutputError};
use crate::{Field, FieldData};

/// Array of a VTK file, whose values are computed only when they are written.
pub(crate) struct VtkArray<'a> {
    name: &'a str,
    components: u32,
    values: Box<dyn Fn() -> IOBuffer + 'a>,
}

impl<'a> VtkArray<'a> {
    /// Creates an array of the values that `values` returns.
    pub(crate) fn new<V>(name: &'a str, components: u32, values: impl Fn() -> V + 'a) -> Self
    where
        V: Into<IOBuffer>,
    {
        Self { name, components, values: Box::new(move || values().into()) }
    }

    /// Creates an array of the values of a field; tensors become full 3×3 components, row by row, as ParaView expects them.
    pub(crate) fn from_field(field: &'a Field) -> Self {
        let name = &field.name;
        match &field.data {
            FieldData::Integer(values) => Self::new(name, 1, || values.clone()),
            FieldData::Scalar(values) => Self::new(name, 1, || values.clone()),
            FieldData::Vector(values) => Self::new(name, 3, || values.as_flattened().to_vec()),
            FieldData::Tensor(values) => Self::new(name, 9, || {
                let mut all = Vec::with_capacity(9 * values.len());
                for [xx, yy, zz, xy, yz, zx] in values.iter().map(|tensor| tensor.0) {
                    all.extend([xx, xy, zx, xy, yy, yz, zx, yz, zz]);
                }
                all
            }),
        }
    }

    /// Data array with the name and the number of components of this one.
    fn with_data(&self, data: IOBuffer) -> DataArray {
        let elem = ElementType::Scalars { num_comp: self.components, lookup_table: None };
        DataArray { name: self.name.to_owned(), elem, data }
    }

    /// Attribute of the array, without values, which are written separately.
    pub(crate) fn without_values(&self) -> Attribute {
        Attribute::DataArray(self.with_data(IOBuffer::U8(Vec::new())))
    }

    /// Writes the array as an XML element with encoded data.
    fn write(&self, compression: Compression, out: &mut dyn Write) -> io::Result<()> {
        const HEAD_END: &str = "/>";
        let values = (self.values)();
        let range = values.compute_range();
        let head = xml::DataArray {
            scalar_type: values.scalar_type().into(),
            name: self.name.to_owned(),
            num_comp: self.components,
            format: DataArrayFormat::Binary,
            offset: None,
            range_min: range.map(|(low, _)| low),
            range_max: range.map(|(_, high)| high),
            data: Vec::new(),
        };
        let head = se::to_string(&head).map_err(io::Error::other)?;
        let head =
            head.strip_suffix(HEAD_END).ok_or_else(|| io::Error::other("has an array with content"))?;
        let text = encoding::encode(&values, compression)?;
        for part in [head, ">", &text, DATA_END] {
            out.write_all(part.as_bytes())?;
        }
        Ok(())
    }
}

/// End of the element of an array.
const DATA_END: &str = "</DataArray>";

/// Points and cells on which the arrays of a file are defined.
pub(crate) struct VtkGeometry<'a> {
    /// Number of points.
    pub(crate) point_count: usize,
    /// Number of cells.
    pub(crate) cells: usize,
    /// Positions of the points; connectivity, offsets and types of the cells.
    pub(crate) arrays: [VtkArray<'a>; 4],
}

/// Writes points or cells with arrays on either as a VTU file; returns the checksum of the file.
pub(crate) fn write_unstructured(
    path: &Path,
    geometry: VtkGeometry<'_>,
    (point, cell): (Vec<VtkArray<'_>>, Vec<VtkArray<'_>>),
    compression: Compression,
) -> Result<FileChecksum, OutputError> {
    let hollow = |arrays: &[VtkArray<'_>]| arrays.iter().map(VtkArray::without_values).collect();
    let verts = VertexNumbers::XML { connectivity: Vec::new(), offsets: Vec::new() };
    let piece = UnstructuredGridPiece {
        points: IOBuffer::U8(vec![0; 3 * geometry.point_count]),
        cells: Cells { cell_verts: verts, types: vec![CellType::Vertex; geometry.cells] },
        data: Attributes { point: hollow(&point), cell: hollow(&cell) },
    };
    let arrays = point.into_iter().chain(cell).chain(geometry.arrays);
    write_xml(path, DataSet::inline(piece), arrays, compression)
}

/// Writes a VTK file and returns its checksum. `hollow` is its content without values, and `arrays` are the values in the order of the
/// file.
pub(crate) fn write_xml<'a>(
    path: &Path,
    hollow: DataSet,
    arrays: impl Iterator<Item = VtkArray<'a>>,
    compression: Compression,
) -> Result<FileChecksum, OutputError> {
    let shell = complete_text(hollow, compression).map_err(|error| OutputError::new(path, error))?;
    let mut checksum = FileChecksum::default();
    write_stream_atomically(path, |file| {
        let mut out = ChecksumWriter { writer: file, checksum };
        let mut rest = shell.as_str();
        for array in arrays {
            let (before, after) =
                split_at_first_array(rest).ok_or_else(|| io::Error::other("has an array too many"))?;
            out.write_all(before.as_bytes())?;
            array.write(compression, &mut out)?;
            rest = after;
        }
        out.write_all(rest.as_bytes())?;
        checksum = out.checksum;
        Ok(())
    })?;
    Ok(checksum)
}

/// Text of a VTK file without values.
fn complete_text(data: DataSet, compression: Compression) -> Result<String, xml::Error> {
    let title = String::new();
    let version = Version::new_xml(1, 0);
    let vtk = Vtk { version, title, byte_order: ByteOrder::LittleEndian, data, file_path: None };
    let file = vtk.try_into_xml_format(Compressor::ZLib, compression.level())?;
    Ok(se::to_string(&file)?)
}

/// Text before the first array, and after it.
fn split_at_first_array(text: &str) -> Option<(&str, &str)> {
    let (start, end) = (text.find("<DataArray")?, text.find(DATA_END)?);
    Some((&text[..start], &text[end + DATA_END.len()..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streamed_vtk_files_equal_files_written_at_once() {
        const COUNT: usize = 5000;
        let places: Vec<f64> = (0..3 * COUNT).map(|k| (k as f64 * 0.37).sin()).collect();
        let numbers: Vec<i64> = (0..COUNT as i64).map(|k| k * k - 7).collect();
        let corners: Vec<u64> = (0..COUNT as u64).collect();
        let ends: Vec<u64> = (1..=COUNT as u64).collect();
        let point =
            || vec![VtkArray::new("a<b", 3, || places.clone()), VtkArray::new("n", 1, || numbers.clone())];
        let cell = || vec![VtkArray::new("on cells", 1, || places[..COUNT].to_vec())];
        let full = |arrays: Vec<VtkArray<'_>>| {
            arrays.iter().map(|own| Attribute::DataArray(own.with_data((own.values)()))).collect()
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("all.vtu");
        for compression in [Compression::None, Compression::Fast, Compression::Best] {
            let cell_verts = VertexNumbers::XML { connectivity: corners.clone(), offsets: ends.clone() };
            let piece = UnstructuredGridPiece {
                points: IOBuffer::F64(places.clone()),
                cells: Cells { cell_verts, types: vec![CellType::Vertex; COUNT] },
                data: Attributes { point: full(point()), cell: full(cell()) },
            };
            let at_once = complete_text(DataSet::inline(piece), compression).unwrap();
            let arrays = [
                VtkArray::new("Points", 3, || places.clone()),
                VtkArray::new("connectivity", 1, || corners.clone()),
                VtkArray::new("offsets", 1, || ends.clone()),
                VtkArray::new("types", 1, || vec![CellType::Vertex as u8; COUNT]),
            ];
            let geometry = VtkGeometry { point_count: COUNT, cells: COUNT, arrays };
            let checksum = write_unstructured(&path, geometry, (point(), cell()), compression).unwrap();
            let text = std::fs::read_to_string(&path).unwrap();
            assert_eq!(checksum, FileChecksum::of_bytes(text.as_bytes()));
            let numbers_left_out = |text: &str| -> String {
                text.split('>').map(|part| part.split_once('<').map_or("", |(_, element)| element)).collect()
            };
            assert_eq!(numbers_left_out(&text), numbers_left_out(&at_once), "elements and attributes");
            let read = |text: &str| Vtk::parse_xml(text.as_bytes()).unwrap().data;
            assert_eq!(read(&text), read(&at_once));
        }
    }

    #[test]
    fn a_full_disk_is_reported_as_a_storage_error() {
        let path = Path::new("/dev/full");
        if path.exists() {
            let mut full = std::fs::File::options().write(true).open(path).unwrap();
            let error =
                VtkArray::new("a", 1, || vec![0.5; 100_000]).write(Compression::None, &mut full).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        }
    }
}
