//! Compressed XML files of VTK, of which one array at a time is in memory.

use std::fmt;
use std::io::{self, Write};
use std::path::Path;

use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataArray, DataSet, ElementType, IOBuffer,
    UnstructuredGridPiece, Version, VertexNumbers, Vtk,
};
use vtkio::xml::{self, Compressor, EncodingInfo, ScalarType, se};

use super::files::write_through;
use super::{OutputError, Seal, Sealed};
use crate::{Field, FieldData};

/// Of zlib: a third of the time of the best for files that are hardly larger.
const LEVEL: u32 = 5;

const ENCODING: EncodingInfo = EncodingInfo {
    byte_order: ByteOrder::LittleEndian,
    header_type: ScalarType::UInt64,
    compressor: Compressor::ZLib,
    compression_level: LEVEL,
};

/// An array of a file, made when its turn comes.
pub(super) struct Array<'a> {
    name: &'a str,
    components: u32,
    values: Box<dyn Fn() -> IOBuffer + 'a>,
}

impl<'a> Array<'a> {
    /// An array of what `values` gives.
    pub(super) fn new<V>(name: &'a str, components: u32, values: impl Fn() -> V + 'a) -> Self
    where
        V: Into<IOBuffer>,
    {
        Self { name, components, values: Box::new(move || values().into()) }
    }

    /// The values of a field; of tensors full 3×3 components, row by row, as ParaView expects them.
    pub(super) fn of(field: &'a Field) -> Self {
        let name = &field.name;
        match &field.data {
            FieldData::Whole(values) => Self::new(name, 1, || values.clone()),
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

    fn with(&self, data: IOBuffer) -> DataArray {
        let elem = ElementType::Scalars { num_comp: self.components, lookup_table: None };
        DataArray { name: self.name.to_owned(), elem, data }
    }

    /// The attribute that has it, without values.
    pub(super) fn hollow(&self) -> Attribute {
        Attribute::DataArray(self.with(IOBuffer::U8(Vec::new())))
    }

    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let element = xml::DataArray::from_model_data_array(self.with((self.values)()), ENCODING);
        let element = element.map_err(io::Error::other)?;
        let mut text = Text { out, failed: None };
        let written = se::to_fmt_writer(&mut text, &element);
        text.failed.map_or(Ok(()), Err)?;
        written.map_err(io::Error::other)
    }
}

/// Text on its way to a file.
struct Text<'a> {
    out: &'a mut dyn Write,
    failed: Option<io::Error>,
}

impl fmt::Write for Text<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.out.write_all(text.as_bytes()).map_err(|error| {
            self.failed = Some(error);
            fmt::Error
        })
    }
}

/// What bears the arrays of a file of points or cells.
pub(super) struct Geometry<'a> {
    /// Number of places.
    pub(super) places: usize,
    /// Number of cells.
    pub(super) cells: usize,
    /// Places, corners, ends and kinds of cells.
    pub(super) arrays: [Array<'a>; 4],
}

/// Writes points or cells with arrays on either as a VTU file; the seal of the file.
pub(super) fn write_unstructured(
    path: &Path,
    geometry: Geometry<'_>,
    point: Vec<Array<'_>>,
    cell: Vec<Array<'_>>,
) -> Result<Seal, OutputError> {
    let hollow = |arrays: &[Array<'_>]| arrays.iter().map(Array::hollow).collect();
    let verts = VertexNumbers::XML { connectivity: Vec::new(), offsets: Vec::new() };
    let piece = UnstructuredGridPiece {
        points: IOBuffer::U8(vec![0; 3 * geometry.places]),
        cells: Cells { cell_verts: verts, types: vec![CellType::Vertex; geometry.cells] },
        data: Attributes { point: hollow(&point), cell: hollow(&cell) },
    };
    let arrays = point.into_iter().chain(cell).chain(geometry.arrays);
    write_xml(path, DataSet::inline(piece), arrays)
}

/// Writes a file of `hollow` data whose arrays, in the order of the file, have other values; the seal of the file.
pub(super) fn write_xml<'a>(
    path: &Path,
    hollow: DataSet,
    arrays: impl Iterator<Item = Array<'a>>,
) -> Result<Seal, OutputError> {
    let shell = whole(hollow).map_err(|error| OutputError::new(path, error))?;
    let mut seal = Seal::default();
    write_through(path, |file| {
        let mut out = Sealed { into: file, seal };
        let mut rest = shell.as_str();
        for array in arrays {
            let (before, after) = around(rest).ok_or_else(|| io::Error::other("has an array too many"))?;
            out.write_all(before.as_bytes())?;
            array.write(&mut out)?;
            rest = after;
        }
        out.write_all(rest.as_bytes())?;
        seal = out.seal;
        Ok(())
    })?;
    Ok(seal)
}

/// The text of a file.
fn whole(data: DataSet) -> Result<String, xml::Error> {
    let title = String::new();
    let version = Version::new_xml(1, 0);
    let vtk = Vtk { version, title, byte_order: ENCODING.byte_order, data, file_path: None };
    let file = vtk.try_into_xml_format(ENCODING.compressor, ENCODING.compression_level)?;
    Ok(se::to_string(&file)?)
}

/// What stands before the first array of a text, and after it.
fn around(text: &str) -> Option<(&str, &str)> {
    const END: &str = "</DataArray>";
    let (start, end) = (text.find("<DataArray")?, text.find(END)?);
    Some((&text[..start], &text[end + END.len()..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_written_array_by_array_is_that_of_all_arrays_at_once() {
        const COUNT: usize = 5000;
        let places: Vec<f64> = (0..3 * COUNT).map(|k| (k as f64 * 0.37).sin()).collect();
        let numbers: Vec<i64> = (0..COUNT as i64).map(|k| k * k - 7).collect();
        let corners: Vec<u64> = (0..COUNT as u64).collect();
        let ends: Vec<u64> = (1..=COUNT as u64).collect();
        let point = || vec![Array::new("a<b", 3, || places.clone()), Array::new("n", 1, || numbers.clone())];
        let cell = || vec![Array::new("on cells", 1, || places[..COUNT].to_vec())];
        let full = |arrays: Vec<Array<'_>>| {
            arrays.iter().map(|own| Attribute::DataArray(own.with((own.values)()))).collect()
        };
        let cell_verts = VertexNumbers::XML { connectivity: corners.clone(), offsets: ends.clone() };
        let at_once = whole(DataSet::inline(UnstructuredGridPiece {
            points: IOBuffer::F64(places.clone()),
            cells: Cells { cell_verts, types: vec![CellType::Vertex; COUNT] },
            data: Attributes { point: full(point()), cell: full(cell()) },
        }));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("all.vtu");
        let arrays = [
            Array::new("Points", 3, || places.clone()),
            Array::new("connectivity", 1, || corners.clone()),
            Array::new("offsets", 1, || ends.clone()),
            Array::new("types", 1, || vec![CellType::Vertex as u8; COUNT]),
        ];
        let geometry = Geometry { places: COUNT, cells: COUNT, arrays };
        let seal = write_unstructured(&path, geometry, point(), cell()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text == at_once.unwrap());
        assert_eq!(seal, Seal::of(text.as_bytes()));
    }

    #[test]
    fn a_disk_that_takes_no_more_is_what_the_error_tells() {
        let path = Path::new("/dev/full");
        if path.exists() {
            let mut full = std::fs::File::options().write(true).open(path).unwrap();
            let error = Array::new("a", 1, || vec![0.5; 100_000]).write(&mut full).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        }
    }
}
