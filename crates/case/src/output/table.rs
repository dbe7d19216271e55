//! Tables of numbers: the measures of a run in time.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{OutputError, write_atomically};

/// Columns with names and units, rows of numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// Name and unit of each column.
    pub columns: Vec<(String, String)>,
    /// The rows; each has one number per column.
    pub rows: Vec<Vec<f64>>,
}

impl Table {
    /// The values of a column, or `None` where there is none of that name.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let index = self.columns.iter().position(|(column, _)| column == name)?;
        Some(self.rows.iter().map(|row| row[index]).collect())
    }

    /// Pairs of two columns, for plots.
    pub fn pairs(&self, x: &str, y: &str) -> Option<Vec<(f64, f64)>> {
        Some(self.column(x)?.into_iter().zip(self.column(y)?).collect())
    }

    /// Last value of a column.
    pub fn last(&self, name: &str) -> Option<f64> {
        self.column(name)?.last().copied()
    }

    /// The table as CSV; lines that start with `#` say what it is. Numbers are written so that they
    /// read back to the last bit.
    pub fn to_csv(&self, about: &str) -> String {
        let mut text = String::new();
        for line in about.lines() {
            text.push_str(&format!("# {line}\n"));
        }
        let head: Vec<String> = self
            .columns
            .iter()
            .map(|(name, unit)| if unit.is_empty() { name.clone() } else { format!("{name} ({unit})") })
            .collect();
        text.push_str(&head.join(","));
        text.push('\n');
        for row in &self.rows {
            let values: Vec<String> = row.iter().map(|value| format!("{value:e}")).collect();
            text.push_str(&values.join(","));
            text.push('\n');
        }
        text
    }

    /// Writes the table as CSV.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn write(&self, path: &Path, about: &str) -> Result<(), OutputError> {
        write_atomically(path, self.to_csv(about).as_bytes())
    }

    /// Reads a table that [`Table::write`] wrote.
    ///
    /// # Errors
    /// When the file cannot be read or is not such a table.
    pub fn read(path: &Path) -> Result<Self, OutputError> {
        let fail = |problem: String| OutputError::new(path, problem);
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .from_path(path)
            .map_err(|error| fail(error.to_string()))?;
        let heads = reader.headers().map_err(|error| fail(error.to_string()))?.clone();
        let column = |head: &str| match head.split_once(" (") {
            Some((name, unit)) => (name.to_owned(), unit.trim_end_matches(')').to_owned()),
            None => (head.to_owned(), String::new()),
        };
        let mut table = Self { columns: heads.iter().map(column).collect(), rows: Vec::new() };
        for record in reader.records() {
            let record = record.map_err(|error| fail(error.to_string()))?;
            let row: Result<Vec<f64>, _> = record.iter().map(str::parse).collect();
            table.rows.push(row.map_err(|_| fail(format!("row {} is not numbers", table.rows.len() + 1)))?);
        }
        Ok(table)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_reads_back_to_the_last_bit() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.csv");
        let columns = vec![("time".to_owned(), "s".to_owned()), ("front".to_owned(), "m".to_owned())];
        let rows = vec![vec![0.1, 1.0 / 3.0], vec![-1e-300, f64::NAN], vec![2e22, f64::INFINITY]];
        let table = Table { columns, rows };
        table.write(&path, "two lines\nof head").unwrap();
        let back = Table::read(&path).unwrap();
        assert_eq!(back.columns, table.columns);
        let bits = |t: &Table| -> Vec<u64> { t.rows.iter().flatten().map(|v| v.to_bits()).collect() };
        assert_eq!(bits(&back), bits(&table));
        assert_eq!(back.last("time"), Some(2e22));
    }
}
