//! Frames and tables as archives of arrays (NPZ), for scripts.

use std::io::{Cursor, Read, Write};
use std::path::Path;

use npyz::WriterBuilder;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::{OutputError, Table, write_atomically};
use crate::{FieldData, Snapshot};

/// Values of an [`NpzArray`], with the last axis varying fastest.
#[derive(Clone, Debug, PartialEq)]
pub enum NpzValues {
    /// Floating-point numbers.
    Float(Vec<f64>),
    /// Integers.
    Integer(Vec<i64>),
}

/// Array of an NPZ archive, with its key.
#[derive(Clone, Debug, PartialEq)]
pub struct NpzArray {
    /// Key of the array in the archive.
    pub name: String,
    /// Length of each axis; empty for a single number.
    pub shape: Vec<u64>,
    /// Values of the array.
    pub values: NpzValues,
}

impl NpzArray {
    /// Array of floating-point numbers.
    fn floats(name: &str, shape: &[u64], values: Vec<f64>) -> Self {
        Self { name: name.to_owned(), shape: shape.to_vec(), values: NpzValues::Float(values) }
    }

    /// Writes the array in the NPY format.
    fn write(&self, to: impl Write) -> std::io::Result<()> {
        match &self.values {
            NpzValues::Float(values) => numbers(to, &self.shape, values),
            NpzValues::Integer(values) => numbers(to, &self.shape, values),
        }
    }
}

/// Writes numbers as an array of a given shape in the NPY format.
fn numbers<T: npyz::AutoSerialize + Copy>(
    to: impl Write,
    shape: &[u64],
    values: &[T],
) -> std::io::Result<()> {
    let mut writer = npyz::WriteOptions::new().default_dtype().shape(shape).writer(to).begin_nd()?;
    writer.extend(values.iter().copied())?;
    writer.finish()
}

/// Replaces non-finite values of an array by zero, and adds an array `<name>.mask` with ones at these values, as in the masked arrays of
/// NumPy.
fn with_masks(arrays: Vec<NpzArray>) -> Vec<NpzArray> {
    let mut all = Vec::with_capacity(arrays.len());
    for mut array in arrays {
        let mut mask = None;
        if let NpzValues::Float(values) = &mut array.values
            && values.iter().any(|value| !value.is_finite())
        {
            let none = values.iter().map(|value| i64::from(!value.is_finite())).collect();
            values.iter_mut().filter(|value| !value.is_finite()).for_each(|value| *value = 0.0);
            mask = Some(NpzArray {
                name: format!("{}.mask", array.name),
                shape: array.shape.clone(),
                values: NpzValues::Integer(none),
            });
        }
        all.push(array);
        all.extend(mask);
    }
    all
}

/// Arrays of a frame: `time` (s), `id`, `body`, `position` and `extent` (m), and each field by its name. An array `NAME.mask` marks the
/// values of a field that are not finite.
pub fn frame_arrays(snapshot: &Snapshot) -> Vec<NpzArray> {
    let count = snapshot.ids.len() as u64;
    let whole = |name: &str, values: Vec<i64>| NpzArray {
        name: name.to_owned(),
        shape: vec![count],
        values: NpzValues::Integer(values),
    };
    let of_points = [("position", &snapshot.positions), ("extent", &snapshot.extents)];
    let fields = snapshot.fields.iter().map(|field| match &field.data {
        FieldData::Integer(values) => whole(&field.name, values.clone()),
        FieldData::Scalar(values) => NpzArray::floats(&field.name, &[count], values.clone()),
        FieldData::Vector(values) => {
            NpzArray::floats(&field.name, &[count, 3], values.as_flattened().to_vec())
        }
        FieldData::Tensor(values) => {
            NpzArray::floats(&field.name, &[count, 6], values.iter().flat_map(|tensor| tensor.0).collect())
        }
    });
    let mut arrays = vec![
        NpzArray::floats("time", &[], vec![snapshot.time]),
        whole("id", snapshot.ids.iter().map(|id| *id as i64).collect()),
        whole("body", snapshot.bodies.iter().map(|body| i64::from(*body)).collect()),
    ];
    arrays.extend(
        of_points.map(|(name, values)| NpzArray::floats(name, &[count, 3], values.as_flattened().to_vec())),
    );
    arrays.extend(fields);
    with_masks(arrays)
}

/// Arrays of the columns of a table, with a mask where a cell is empty.
pub fn table_arrays(table: &Table) -> Vec<NpzArray> {
    let column = |(index, (name, _)): (usize, &(String, String))| {
        let values: Vec<f64> = table.rows.iter().map(|row| row[index]).collect();
        NpzArray::floats(name, &[values.len() as u64], values)
    };
    with_masks(table.columns.iter().enumerate().map(column).collect())
}

/// Writes arrays as an uncompressed archive for `numpy.load`.
///
/// # Errors
/// When the file cannot be written.
pub fn write_npz(path: &Path, arrays: &[NpzArray]) -> Result<(), OutputError> {
    let archive = || -> Result<Vec<u8>, zip::result::ZipError> {
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        for array in arrays {
            let bytes = 8 * array.shape.iter().product::<u64>();
            let options = SimpleFileOptions::default()
                .compression_method(CompressionMethod::Stored)
                .large_file(bytes > u64::from(u32::MAX) / 2);
            archive.start_file(npyz::npz::file_name_from_array_name(&array.name), options)?;
            array.write(&mut archive)?;
        }
        Ok(archive.finish()?.into_inner())
    };
    let bytes = archive().map_err(|error| OutputError::new(path, error))?;
    write_atomically(path, &bytes)
}

/// Reads an archive of arrays of 8-byte numbers.
///
/// # Errors
/// When the file cannot be read, or contains other data.
pub fn read_npz(path: &Path) -> Result<Vec<NpzArray>, OutputError> {
    let fail = |problem: &dyn std::fmt::Display| OutputError::new(path, problem);
    let file = std::fs::File::open(path).map_err(|error| fail(&error))?;
    let mut archive = ZipArchive::new(file).map_err(|error| fail(&error))?;
    let mut arrays = Vec::new();
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).map_err(|error| fail(&error))?;
        let entry_name = entry.name().map_err(|error| fail(&error))?.into_owned();
        let Some(name) = npyz::npz::array_name_from_file_name(&entry_name) else { continue };
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).map_err(|error| fail(&error))?;
        arrays.push(read(name, &bytes).map_err(|error| fail(&format!("{name}: {error}")))?);
    }
    Ok(arrays)
}

/// Reads an array in the NPY format, of integers or of floating-point numbers.
fn read(name: &str, bytes: &[u8]) -> std::io::Result<NpzArray> {
    let file = npyz::NpyFile::new(bytes)?;
    let shape = file.shape().to_vec();
    let values = match file.try_data::<i64>() {
        Ok(values) => NpzValues::Integer(values.collect::<Result<_, _>>()?),
        Err(file) => NpzValues::Float(file.into_vec::<f64>()?),
    };
    Ok(NpzArray { name: name.to_owned(), shape, values })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Field;
    use colluvium_constitutive::SymTensor;

    #[test]
    fn frames_and_tables_are_read_back_bit_identically_from_an_archive() {
        let field = |name: &str, data| Field { name: name.into(), unit: "", data };
        let snapshot = Snapshot {
            time: 0.1 + 0.2,
            step: 7,
            ids: vec![3, 5],
            bodies: vec![0, 1],
            positions: vec![[0.1, 0.2, 0.0], [1.0 / 3.0, -2.0, 1e-30]],
            extents: vec![[0.05; 3], [0.1; 3]],
            fields: vec![
                field("mass", FieldData::Scalar(vec![0.7, 5e-324])),
                field("velocity", FieldData::Vector(vec![[1.0, 2.0, 3.0], [-0.0, f64::INFINITY, 6.0]])),
                field("stress", FieldData::Tensor(vec![SymTensor([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]); 2])),
            ],
        };
        let arrays = frame_arrays(&snapshot);
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("frame.npz");
        write_npz(&path, &arrays).unwrap();
        let back = read_npz(&path).unwrap();
        assert_eq!(back, arrays);
        let get = |name: &str| back.iter().find(|array| array.name == name).unwrap();
        assert_eq!(get("time").values, NpzValues::Float(vec![0.1 + 0.2]));
        assert!(get("time").shape.is_empty());
        assert_eq!(get("id").values, NpzValues::Integer(vec![3, 5]));
        assert_eq!(get("position").shape, [2, 3]);
        assert_eq!(get("stress").shape, [2, 6]);
        let NpzValues::Float(velocity) = &get("velocity").values else { panic!("numbers") };
        assert_eq!(velocity[3].to_bits(), (-0.0f64).to_bits());
        let columns =
            vec![("time".to_owned(), "s".to_owned()), ("momentum.x".to_owned(), "kg m/s".to_owned())];
        let table = Table { columns, rows: vec![vec![0.0, f64::NAN], vec![0.1, 1.0 / 3.0]] };
        write_npz(&path, &table_arrays(&table)).unwrap();
        let back = read_npz(&path).unwrap();
        assert_eq!((back[1].name.as_str(), &back[1].shape[..]), ("momentum.x", &[2][..]));
        assert_eq!(back[1].values, NpzValues::Float(vec![0.0, 1.0 / 3.0]));
        assert_eq!(
            (back[2].name.as_str(), &back[2].values),
            ("momentum.x.mask", &NpzValues::Integer(vec![1, 0]))
        );
        std::fs::write(&path, "no archive").unwrap();
        assert!(read_npz(&path).is_err());
    }
}
