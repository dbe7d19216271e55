//! Tables of numbers: the measures of a run over time.

use std::fs::{File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use colluvium_constitutive::driver::cell;
use serde::{Deserialize, Serialize};

use super::{FileChecksum, OutputError, write_atomically};

/// Table of numbers with names and units of the columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// Name and unit of each column.
    pub columns: Vec<(String, String)>,
    /// Rows with one number per column.
    pub rows: Vec<Vec<f64>>,
}

impl Table {
    /// Values of a column; `None` without a column of that name.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let index = self.columns.iter().position(|(column, _)| column == name)?;
        Some(self.rows.iter().map(|row| row[index]).collect())
    }

    /// Pairs of the values of two columns, for plots.
    pub fn pairs(&self, x: &str, y: &str) -> Option<Vec<(f64, f64)>> {
        Some(self.column(x)?.into_iter().zip(self.column(y)?).collect())
    }

    /// Last value of a column.
    pub fn last(&self, name: &str) -> Option<f64> {
        self.column(name)?.last().copied()
    }

    /// Formats the table as CSV; lines that start with `#` describe it. Numbers read back to the last bit. Not-a-number and infinity are
    /// empty cells, which read back as not-a-number.
    pub fn to_csv(&self, about: &str) -> String {
        head(about, &self.columns) + &lines(&self.rows)
    }

    /// Writes the table as CSV.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path, about: &str) -> Result<(), OutputError> {
        write_atomically(path, self.to_csv(about).as_bytes())
    }

    /// Reads a table written by [`Table::write`] or [`TableFile`]. A last line without a line end, which a killed run may leave, is
    /// ignored.
    ///
    /// # Errors
    /// When the file cannot be read or is not such a table.
    pub fn read(path: &Path) -> Result<Self, OutputError> {
        let fail = |problem: String| OutputError::new(path, problem);
        let text = std::fs::read_to_string(path).map_err(|error| fail(error.to_string()))?;
        let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(whole.as_bytes());
        let heads = reader.headers().map_err(|error| fail(error.to_string()))?.clone();
        let column = |head: &str| match head.split_once(" (") {
            Some((name, unit)) => (name.to_owned(), unit.strip_suffix(')').unwrap_or(unit).to_owned()),
            None => (head.to_owned(), String::new()),
        };
        let mut table = Self { columns: heads.iter().map(column).collect(), rows: Vec::new() };
        for record in reader.records() {
            let record = record.map_err(|error| fail(error.to_string()))?;
            let number = |cell: &str| if cell.is_empty() { Ok(f64::NAN) } else { cell.parse() };
            let row: Result<Vec<f64>, std::num::ParseFloatError> = record.iter().map(number).collect();
            table.rows.push(row.map_err(|_| {
                fail(format!("row {} contains cells that are not numbers", table.rows.len() + 1))
            })?);
        }
        Ok(table)
    }
}

/// Name with its unit, if there is one: `front (m)`.
pub fn column_heading(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} ({unit})") }
}

/// Head of a table: comment lines, and the line of headings.
fn head(about: &str, columns: &[(String, String)]) -> String {
    let about: String = about.lines().map(|line| format!("# {line}\n")).collect();
    let names: Vec<String> = columns.iter().map(|(name, unit)| column_heading(name, unit)).collect();
    format!("{about}{}\n", names.join(","))
}

/// Lines of the rows of a table, values separated by commas.
fn lines(rows: &[Vec<f64>]) -> String {
    let line = |row: &Vec<f64>| {
        let values: Vec<String> = row.iter().map(|value| cell(*value)).collect();
        values.join(",") + "\n"
    };
    rows.iter().map(line).collect()
}

/// Table on disk to which rows are appended, in the format of [`Table::to_csv`]. A killed run may leave a partial last row: the checksum at
/// a checkpoint gives the valid length, and shows whether that part has changed.
#[derive(Debug)]
pub struct TableFile {
    path: PathBuf,
    file: File,
    checksum: FileChecksum,
}

impl TableFile {
    /// Creates a table without rows.
    ///
    /// # Errors
    /// When the file cannot be created or written.
    pub fn create(path: &Path, about: &str, columns: &[(String, String)]) -> Result<Self, OutputError> {
        let file = File::create(path).map_err(|error| OutputError::new(path, error))?;
        let mut table = Self { path: path.to_owned(), file, checksum: FileChecksum::default() };
        table.write(&head(about, columns))?;
        Ok(table)
    }

    /// Opens a table whose beginning has a checksum. The file is unchanged before [`TableFile::truncate`].
    ///
    /// # Errors
    /// When the file cannot be opened, is shorter than that part or has been changed.
    pub fn open(path: &Path, checksum: FileChecksum) -> Result<Self, OutputError> {
        let fail = |problem: &dyn std::fmt::Display| OutputError::new(path, problem);
        let file = OpenOptions::new().write(true).open(path).map_err(|error| fail(&error))?;
        let found = file.metadata().map_err(|error| fail(&error))?.len();
        if found < checksum.bytes {
            let had = checksum.bytes;
            let problem = format!("has {found} bytes, but had {had} when the checkpoint was written");
            return Err(OutputError::coded(path, "table-changed", problem));
        }
        if FileChecksum::of_file(path, Some(checksum.bytes))? != checksum {
            return Err(OutputError::coded(
                path,
                "table-changed",
                "was changed since the checkpoint: run the case anew",
            ));
        }
        Ok(Self { path: path.to_owned(), file, checksum })
    }

    /// Removes everything after the part that the checksum covers.
    ///
    /// # Errors
    /// When the file cannot be changed.
    pub fn truncate(&mut self) -> Result<(), OutputError> {
        let length = self.checksum.bytes;
        let cut = self.file.set_len(length).and_then(|()| self.file.seek(SeekFrom::Start(length)));
        cut.map(|_| ()).map_err(|error| OutputError::new(&self.path, error))
    }

    /// Adds rows.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn append(&mut self, rows: &[Vec<f64>]) -> Result<(), OutputError> {
        self.write(&lines(rows))
    }

    /// Appends a text to the file, and adds it to the checksum.
    fn write(&mut self, text: &str) -> Result<(), OutputError> {
        self.file.write_all(text.as_bytes()).map_err(|error| OutputError::new(&self.path, error))?;
        self.checksum.add(text.as_bytes());
        Ok(())
    }

    /// Synchronises all rows to the disk; returns the checksum of the file.
    ///
    /// # Errors
    /// When the rows cannot be synchronised.
    pub fn sync(&self) -> Result<FileChecksum, OutputError> {
        self.file.sync_all().map_err(|error| OutputError::new(&self.path, error))?;
        Ok(self.checksum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_read_back_bit_identically() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.csv");
        let columns = vec![("time".to_owned(), "s".to_owned()), ("front".to_owned(), "m".to_owned())];
        let rows = vec![vec![0.1, 1.0 / 3.0], vec![-1e-300, f64::NAN], vec![2e22, f64::INFINITY]];
        let mut table = Table { columns, rows };
        table.write(&path, "two lines\nof head").unwrap();
        assert!(
            std::fs::read_to_string(&path).unwrap().ends_with("-1e-300,\n2e22,\n"),
            "values that are not numbers"
        );
        let back = Table::read(&path).unwrap();
        table.rows[2][1] = f64::NAN;
        assert_eq!(back.columns, table.columns);
        let bits = |t: &Table| -> Vec<u64> { t.rows.iter().flatten().map(|v| v.to_bits()).collect() };
        assert_eq!(bits(&back), bits(&table));
        assert_eq!(back.last("time"), Some(2e22));
    }

    #[test]
    fn a_table_file_appends_rows_and_continues_at_the_checkpointed_row() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.csv");
        let columns = vec![("time".to_owned(), "s".to_owned()), ("front".to_owned(), "m".to_owned())];
        let rows: Vec<Vec<f64>> = (0..5).map(|i| vec![f64::from(i), 1.0 / f64::from(i + 1)]).collect();
        let mut file = TableFile::create(&path, "about", &columns).unwrap();
        file.append(&rows[..2]).unwrap();
        let checksum = file.sync().unwrap();
        file.append(&rows[3..]).unwrap();
        drop(file);
        OpenOptions::new().append(true).open(&path).unwrap().write_all(b"7e0,1.2").unwrap();
        assert_eq!(Table::read(&path).unwrap().rows.len(), 4, "a torn row does not count");
        let mut file = TableFile::open(&path, checksum).unwrap();
        file.truncate().unwrap();
        file.append(&rows[2..3]).unwrap();
        file.append(&rows[3..]).unwrap();
        let table = Table { columns, rows };
        assert_eq!(std::fs::read_to_string(&path).unwrap(), table.to_csv("about"));
        assert!(
            TableFile::open(&path, FileChecksum { bytes: 1_000_000, ..checksum }).is_err(),
            "rows are missing"
        );
        let edited = std::fs::read_to_string(&path).unwrap().replacen("about", "About", 1);
        std::fs::write(&path, edited).unwrap();
        let error = TableFile::open(&path, checksum).unwrap_err().to_string();
        assert!(error.contains("was changed since the checkpoint"), "{error}");
    }
}
