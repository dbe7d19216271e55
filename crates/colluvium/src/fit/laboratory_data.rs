//! Data of laboratory tests: measured curves in tables with units.

use std::path::Path;

use crate::case::files::column_file::{ColumnFile, Quantity};
use crate::case::{CaseError, CaseErrorKind, CaseErrors};
use crate::fit::{DataFile, RELATIVE_TOLERANCE};

/// Measured value of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredValue {
    /// Line of the file.
    pub line: u64,
    /// Abscissa (SI units).
    pub x: f64,
    /// Value (SI units, sign of the element test).
    pub y: f64,
}

/// Measured curve of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredCurve {
    /// Name of the column of the element test.
    pub name: String,
    /// Unit of the values; empty without one.
    pub unit: &'static str,
    /// Uncertainty of a value.
    pub tolerance: f64,
    /// Values, in the order of the file; rows with an empty cell are left out.
    pub values: Vec<MeasuredValue>,
}

/// Data of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct LaboratoryData {
    /// Number of rows of the file.
    pub rows: usize,
    /// Headings of columns that are not used.
    pub unused: Vec<String>,
    /// Unit of the abscissa; empty without one.
    pub over_unit: &'static str,
    /// Measured curves, in the order of their names.
    pub curves: Vec<MeasuredCurve>,
}

/// Column of a file of data.
struct DataColumn {
    index: usize,
    factor: f64,
}

impl LaboratoryData {
    /// Reads the data of a test whose element test has the given columns, each with its unit. `at` is the path of the object `data`.
    ///
    /// # Errors
    /// All missing columns, and the first error of the file with its line.
    pub fn read(
        data: &DataFile,
        columns: &[(&'static str, &'static str)],
        folder: &Path,
        at: &str,
    ) -> Result<Self, CaseErrors> {
        let in_file = |kind: CaseErrorKind| CaseError::new(format!("{at}.file"), kind.in_table(&data.file));
        let table = ColumnFile::read(&folder.join(&data.file)).map_err(in_file)?;
        let heads = table.headings().map(<[String]>::to_vec);
        let heads = heads.ok_or_else(|| {
            in_file(CaseErrorKind::coded(
                "wrong-column",
                "has no headings: name its columns in the first line, as \"axial_compression (%), q (kPa)\"",
            ))
        })?;
        let find = |name: &str, key: String| {
            let head = data.columns.get(name).map(|head| (head, format!("{at}.columns.{name}")));
            find_column(name, head, (key, &data.file), &heads, columns)
        };
        let over = find(&data.over, format!("{at}.over"));
        let curves: Vec<_> =
            data.curves.keys().map(|name| find(name, format!("{at}.curves.{name}"))).collect();
        let errors: Vec<CaseError> =
            [&over].into_iter().chain(&curves).filter_map(|found| found.as_ref().err().cloned()).collect();
        let (Ok(over), true) = (over, errors.is_empty()) else { return Err(CaseErrors(errors)) };
        let curves: Vec<DataColumn> = curves.into_iter().flatten().collect();
        let unit =
            |name: &str| columns.iter().find(|(known, _)| *known == name).map_or("", |(_, unit)| *unit);
        let (rows, values) = read_rows(&table, &over, &curves).map_err(|problem| in_file(problem.into()))?;
        let is_used = |index: &usize| *index == over.index || curves.iter().any(|own| own.index == *index);
        let mut read = Self {
            rows,
            unused: (0..heads.len()).filter(|k| !is_used(k)).map(|k| heads[k].clone()).collect(),
            over_unit: unit(&data.over),
            curves: Vec::new(),
        };
        for ((name, settings), mut values) in data.curves.iter().zip(values) {
            values.iter_mut().for_each(|value| value.y *= settings.factor);
            let largest = values.iter().fold(0.0, |largest: f64, value| largest.max(value.y.abs()));
            let tolerance = settings.tolerance.unwrap_or(RELATIVE_TOLERANCE * largest);
            if values.is_empty() {
                return Err(CaseError::new(
                    format!("{at}.curves.{name}"),
                    format!("has no value in {}", data.file),
                )
                .into());
            }
            if tolerance == 0.0 {
                let problem = "is required, because all values of the curve are 0";
                return Err(CaseError::new(format!("{at}.curves.{name}.tolerance"), problem).into());
            }
            read.curves.push(MeasuredCurve { name: name.clone(), unit: unit(name), tolerance, values });
        }
        Ok(read)
    }
}

/// Column of a file for a column of the element test. `head` is its heading in the file with the path of the setting, if it has another
/// name there; `place` is the path of the name and the name of the file.
fn find_column(
    name: &str,
    head: Option<(&String, String)>,
    (key, file): (String, &str),
    heads: &[String],
    columns: &[(&'static str, &'static str)],
) -> Result<DataColumn, CaseError> {
    let Some((_, unit)) = columns.iter().find(|(known, _)| *known == name) else {
        let known: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
        let rule = format!("a column of the element test ({})", known.join(", "));
        return Err(CaseError::new(key, CaseErrorKind::unknown_name(name, &known, rule)));
    };
    let (wanted, key) = head.map_or((name, key), |(head, key)| (head.as_str(), key));
    let is_wanted = |head: &String| head.trim() == wanted.trim() || ColumnFile::name(head) == wanted.trim();
    let found: Vec<usize> = (0..heads.len()).filter(|k| is_wanted(&heads[*k])).collect();
    match found[..] {
        [index] => Ok(DataColumn {
            index,
            factor: unit_factor(&heads[index], unit)
                .map_err(|problem| CaseError::new(key, format!("{file}: {problem}")))?,
        }),
        [] => {
            let names: Vec<&str> = heads.iter().map(|head| ColumnFile::name(head)).collect();
            let cure = "; `columns` gives the heading of a column with another name";
            let rule = format!("a column of {file} ({}){cure}", heads.join(", "));
            Err(CaseError::new(key, CaseErrorKind::unknown_name(wanted, &names, rule)))
        }
        _ => Err(CaseError::new(key, format!("{file} has {} columns {wanted:?}", found.len()))),
    }
}

/// Factor to SI units of a column with the heading `head`, whose values have the SI unit `unit`. Outputs of laws have none: they may be
/// ratios or stresses.
fn unit_factor(head: &str, unit: &str) -> Result<f64, CaseErrorKind> {
    let quantity = match unit {
        "s" => Quantity::Time,
        "Pa" => Quantity::Stress,
        "rad" => Quantity::Angle,
        "J/m3" => Quantity::EnergyDensity,
        "m/s" => Quantity::Velocity,
        _ => {
            let of = |quantity| ColumnFile::factor(head, quantity);
            return of(Quantity::Ratio).or_else(|problem| of(Quantity::Stress).map_err(|_| problem));
        }
    };
    ColumnFile::factor(head, quantity)
}

/// Number of rows, and the values of each curve.
fn read_rows(
    table: &ColumnFile,
    over: &DataColumn,
    curves: &[DataColumn],
) -> Result<(usize, Vec<Vec<MeasuredValue>>), String> {
    let (mut rows, mut values) = (0, vec![Vec::new(); curves.len()]);
    for row in table.rows() {
        let row = row?;
        let number = |cell: &str| {
            table.number(cell).ok_or_else(|| format!("line {}: {cell:?} is not a finite number", row.line))
        };
        let x = over.factor * number(&row.cells[over.index])?;
        for (curve, values) in curves.iter().zip(&mut values) {
            let cell = &row.cells[curve.index];
            if !cell.is_empty() {
                values.push(MeasuredValue { line: row.line, x, y: curve.factor * number(cell)? });
            }
        }
        rows += 1;
    }
    Ok((rows, values))
}
