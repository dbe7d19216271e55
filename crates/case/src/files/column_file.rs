//! Tables in text files: columns of numbers, with or without a header line.

use crate::CaseErrorKind;
use crate::files::terrain_files;
use std::path::Path;

pub use crate::files::units::Quantity;

/// Table in a text file. Its columns are separated by commas, by semicolons or tabs (numbers may then have decimal commas), or by blanks
/// where there is no header. Lines that begin with `#` are comments.
pub struct ColumnFile {
    text: String,
    separator: u8,
    heads: Option<Vec<String>>,
}

/// Row of a file of columns.
pub struct ColumnRow {
    /// Line number in the file, from 1.
    pub line: u64,
    /// Texts of the cells.
    pub cells: csv::StringRecord,
}

/// Name and unit in the heading of a column. The unit is in brackets (`t (h)`), after a slash (`t/h`), after “in”, or after a blank.
fn name_and_unit(head: &str) -> (&str, Option<&str>) {
    if let Some(at) = head.find(['(', '[']) {
        let unit = head[at + 1..].trim_end().trim_end_matches([')', ']']);
        return (head[..at].trim().trim_end_matches('/').trim_end(), Some(unit.trim()));
    }
    let after_blank = || head.trim().rsplit_once(' ').filter(|(_, unit)| crate::files::units::is_known(unit));
    let parted = head.split_once(" in ").or_else(after_blank).or_else(|| head.split_once('/'));
    parted.map_or((head.trim(), None), |(name, unit)| (name.trim(), Some(unit.trim())))
}

/// Whether a line has no data: it is empty or begins with `#`.
fn is_comment(line: &str) -> bool {
    line.starts_with('#') || line.trim().is_empty()
}

/// Number with a decimal point, or with a decimal comma where the separator is not a comma.
fn number(cell: &str, separator: u8) -> Option<f64> {
    let cell = cell.trim();
    if separator != b',' && cell.contains(',') && !cell.contains('.') {
        return cell.replacen(',', ".", 1).parse().ok();
    }
    cell.parse().ok()
}

impl ColumnFile {
    /// Reads a table.
    ///
    /// # Errors
    /// Description of the error, in one line with its position.
    pub fn read(file: &Path) -> Result<Self, CaseErrorKind> {
        let text = terrain_files::read_text(file)
            .map_err(|error| CaseErrorKind::coded(error.code, error.problem))?;
        Self::from_text(text)
    }

    /// Reads a text, and determines its separator and whether its first line has headings.
    fn from_text(mut text: String) -> Result<Self, CaseErrorKind> {
        let Some(mut first) = text.lines().find(|line| !is_comment(line)).map(str::to_owned) else {
            return Ok(Self { text, separator: b',', heads: None });
        };
        // Spreadsheets may name the separator in the first line.
        let named = first.trim().strip_prefix("sep=").and_then(|rest| rest.bytes().next());
        if named.is_some() {
            text = text.replacen(&first, "#", 1);
            first = text.lines().find(|line| !is_comment(line)).unwrap_or_default().to_owned();
        }
        let found = [b';', b'\t', b','].into_iter().find(|byte| first.contains(char::from(*byte)));
        let blanks = first.split_whitespace().count() > 1
            && first.split_whitespace().all(|word| word.parse::<f64>().is_ok());
        let separator = match named.or(found) {
            Some(separator) => separator,
            None if blanks => {
                let joined = |line: &str| {
                    let words: Vec<&str> = line.split_whitespace().collect();
                    if is_comment(line) { line.to_owned() } else { words.join("\t") }
                };
                text = text.lines().map(joined).collect::<Vec<_>>().join("\n");
                b'\t'
            }
            None => b',',
        };
        if ![b',', b';', b'\t', b' ', b'|'].contains(&separator) {
            let separator = char::from(separator);
            let problem = format!("its columns are separated by {separator:?}: use commas or semicolons");
            return Err(CaseErrorKind::coded("decimal-comma", problem));
        }
        let mut table = Self { text, separator, heads: None };
        let mut rows = table.reader(csv::Trim::All);
        let head = rows.records().next().transpose().map_err(|error| table.line_problem(&error))?;
        drop(rows);
        if let Some(head) = head {
            table.heads = table.names(&head)?;
        }
        Ok(table)
    }

    /// Names in the first line; `None` where it contains numbers.
    fn names(&self, head: &csv::StringRecord) -> Result<Option<Vec<String>>, String> {
        let filled = || head.iter().filter(|cell| !cell.is_empty());
        let numbers = filled().filter(|cell| number(cell, self.separator).is_some()).count();
        if numbers == 0 {
            return Ok(Some(head.iter().map(str::to_owned).collect()));
        }
        if numbers == filled().count() {
            return Ok(None);
        }
        let line = head.position().map_or(0, |at| self.line(at));
        let first = filled().find(|cell| number(cell, self.separator).is_none()).unwrap_or_default();
        Err(format!(
            "line {line}: {first:?} is not a number, but the other cells of the line are numbers. Give names \
             of columns only, or numbers only"
        ))
    }

    /// Names of the columns; `None` where the first line contains numbers.
    pub fn headings(&self) -> Option<&[String]> {
        self.heads.as_deref()
    }

    /// CSV reader of the text, which removes blanks around cells or not.
    fn reader(&self, trim: csv::Trim) -> csv::Reader<&[u8]> {
        csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(trim)
            .delimiter(self.separator)
            .has_headers(self.heads.is_some())
            .from_reader(self.text.as_bytes())
    }

    /// Rows below the header, each with as many cells as the first.
    ///
    /// # Errors
    /// Each row with another number of cells, as a text with its position.
    pub fn rows(&self) -> impl Iterator<Item = Result<ColumnRow, String>> {
        self.reader(csv::Trim::All).into_records().map(|record| {
            let cells = record.map_err(|error| self.line_problem(&error))?;
            Ok(ColumnRow { line: cells.position().map_or(0, |at| self.line(at)), cells })
        })
    }

    /// Calls `visit` with the line number and the cells of each row, as [`ColumnFile::rows`] but with blanks around cells. All rows are
    /// read into one record: for long files, where a new one for each row takes as long as its numbers.
    ///
    /// # Errors
    /// Those of `visit`, and each row with another number of cells, as a text with its position.
    pub(crate) fn visit_rows<E: From<String>>(
        &self,
        mut visit: impl FnMut(u64, &csv::StringRecord) -> Result<(), E>,
    ) -> Result<(), E> {
        let (mut reader, mut cells) = (self.reader(csv::Trim::Headers), csv::StringRecord::new());
        while reader.read_record(&mut cells).map_err(|error| self.line_problem(&error))? {
            visit(cells.position().map_or(0, |at| self.line(at)), &cells)?;
        }
        Ok(())
    }

    /// Finite number in a cell.
    pub fn number(&self, cell: &str) -> Option<f64> {
        number(cell, self.separator).filter(|value| value.is_finite())
    }

    /// Line number of a record. `at` is the position of the comments and empty lines before it.
    fn line(&self, at: &csv::Position) -> u64 {
        let rest = self.text.get(at.byte() as usize..).unwrap_or_default();
        let passed = |line: &&str| line.starts_with('#') || line.trim_end_matches(['\r', '\n']).is_empty();
        at.line() + rest.split_inclusive('\n').take_while(passed).count() as u64
    }

    /// Error text for a line that is not a row of the table.
    fn line_problem(&self, error: &csv::Error) -> String {
        let csv::ErrorKind::UnequalLengths { pos, expected_len, len } = error.kind() else {
            return error.to_string();
        };
        let line = pos.as_ref().map_or(0, |at| self.line(at));
        let first = if self.heads.is_some() { "head" } else { "first line" };
        let cure = self.decimal_comma_advice(*len, *expected_len);
        format!("line {line}: has {len} values, the {first} has {expected_len} columns{cure}")
    }

    /// Advice for a row with `found` columns instead of `wanted`, where decimal commas may be the reason.
    fn decimal_comma_advice(&self, found: u64, wanted: u64) -> &'static str {
        if self.separator == b',' && found > wanted {
            "; with decimal commas separate the columns by semicolons"
        } else {
            ""
        }
    }

    /// Factor to SI units of the numbers in a column with this head.
    ///
    /// # Errors
    /// When a unit is unknown or of another quantity.
    pub fn factor(head: &str, quantity: Quantity) -> Result<f64, CaseErrorKind> {
        let (name, unit) = name_and_unit(head);
        // A unit alone, as `hours` or `m3/s`.
        if let Some(factor) = quantity.known_factor(head.trim()) {
            return Ok(factor);
        }
        let unnamed = || Ok(unit_after_underscore(name, quantity).unwrap_or(1.0));
        unit.map_or_else(unnamed, |unit| quantity.factor(unit))
            .map_err(|problem| CaseErrorKind::coded("unknown-unit", format!("column {head:?}: {problem}")))
    }

    /// Name of a column without its unit.
    pub fn name(head: &str) -> &str {
        name_and_unit(head).0
    }
}

/// Factor to SI units of a unit after an underscore in a name, as in `t_h`, `Q_l_s`, `q_ls` or `discharge_m3s`; `None` without such a unit.
fn unit_after_underscore(name: &str, quantity: Quantity) -> Option<f64> {
    let (_, first) = name.split_once('_')?;
    let (_, last) = name.rsplit_once('_')?;
    let per_second =
        first.strip_suffix('s').filter(|volume| !volume.is_empty()).map(|volume| format!("{volume}/s"));
    let known = |unit: &str| quantity.known_factor(unit);
    known(first)
        .or_else(|| known(&first.replace('_', "/")))
        .or_else(|| known(&per_second?))
        .or_else(|| known(last))
}

/// Index of the quantity of a column, by the words in its heading or by its unit. `None` where it is ambiguous.
fn matching_quantity(head: &str, of: &[(Quantity, &[&str]); 2]) -> Option<usize> {
    let (name, unit) = name_and_unit(head);
    let name = name.to_lowercase();
    let words: Vec<&str> = name.split(|letter: char| !letter.is_alphanumeric()).collect();
    let is_named = |k: &usize| of[*k].1.iter().any(|own| words.contains(own));
    let unit_of = |k: &usize| {
        let quantity = of[*k].0;
        let after = || {
            unit.map_or_else(|| unit_after_underscore(&name, quantity), |unit| quantity.known_factor(unit))
        };
        quantity.known_factor(head.trim()).or_else(after).is_some()
    };
    let only = |is: &dyn Fn(&usize) -> bool| {
        let found: Vec<usize> = (0..2).filter(is).collect();
        if let [one] = found[..] { Some(one) } else { None }
    };
    only(&is_named).or_else(|| only(&unit_of))
}

/// Reads two columns of numbers from a file, in SI units, with or without a header. Each quantity is given with names of its columns, the
/// first of which is used in messages; names or units of the columns determine their order.
///
/// # Errors
/// Error of the file, in one line with its position.
pub fn read_pairs(file: &str, of: [(Quantity, &[&str]); 2]) -> Result<Vec<[f64; 2]>, CaseErrorKind> {
    let table = ColumnFile::read(Path::new(file))?;
    let mut factors = [1.0; 2];
    let mut order = [0, 1];
    if let Some(heads) = table.headings() {
        if let [first, second] = heads {
            order = match (matching_quantity(first, &of), matching_quantity(second, &of)) {
                (Some(0), None | Some(1)) | (None, Some(1)) => [0, 1],
                (Some(1), None | Some(0)) | (None, Some(0)) => [1, 0],
                _ => {
                    let names = of.map(|(_, words)| words[0]);
                    return Err(CaseErrorKind::coded(
                        "wrong-column",
                        format!(
                            "its columns are called {first:?} and {second:?}, which does not define their \
                         quantities: call them {:?} and {:?}",
                            names[0], names[1]
                        ),
                    ));
                }
            };
        }
        for (wanted, (quantity, _)) in of.iter().enumerate() {
            if let Some(head) = heads.get(order[wanted]) {
                factors[wanted] = ColumnFile::factor(head, *quantity)?;
            }
        }
    }
    let mut points = Vec::new();
    for row in table.rows() {
        let ColumnRow { line, cells } = row?;
        if cells.len() != 2 {
            let found = cells.len();
            let cure = table.decimal_comma_advice(found as u64, 2);
            let problem = format!("line {line}: has {found} columns, but must have two{cure}");
            return Err(CaseErrorKind::coded(
                if cure.is_empty() { "wrong-column" } else { "decimal-comma" },
                problem,
            ));
        }
        let mut point = [0.0; 2];
        for (wanted, value) in point.iter_mut().enumerate() {
            let cell = &cells[order[wanted]];
            let found =
                table.number(cell).ok_or_else(|| format!("line {line}: {cell:?} is not a finite number"))?;
            *value = found * factors[wanted];
        }
        points.push(point);
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_identified_by_names_and_units() {
        let right = Ok(vec![[0.0, 1.5], [3600.0, 3.0]]);
        for text in [
            "flow,time\n1.5,0\n3,3600\n",
            "Abfluss,Zeit\n1.5,0\n3,3600\n",
            "discharge_m3s,time_s\n1.5,0\n3,3600\n",
            "hours,discharge\n0,1.5\n1,3\n",
            "t_h,Q_ls\n0,1500\n1,3000\n",
            "time_min,Q_l_s\n0,1500\n60,3000\n",
            "m3/s,h\n1.5,0\n3,1\n",
            "value (l/s);begin (h)\n1500;0\n3000;1\n",
            "t,value\n0,1.5\n3600,3\n",
        ] {
            assert_eq!(pairs(text.as_bytes()), right, "{text}");
        }
        for text in ["a,b\n0,1\n", "time,time\n0,1\n", "q,discharge\n0,1\n"] {
            let problem = pairs(text.as_bytes()).unwrap_err();
            assert!(problem.contains("call them \"time\" and \"discharge\""), "{problem}");
        }
    }

    fn pairs(bytes: &[u8]) -> Result<Vec<[f64; 2]>, String> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("pairs.csv");
        std::fs::write(&file, bytes).unwrap();
        let of = [
            (Quantity::Time, &["time", "t", "zeit"][..]),
            (Quantity::Discharge, &["discharge", "q", "flow", "abfluss"]),
        ];
        read_pairs(&file.display().to_string(), of).map_err(|kind| kind.to_string())
    }

    #[test]
    fn rows_are_read_with_and_without_headers_for_every_separator() {
        let right = Ok(vec![[0.0, 1.5], [2.0, 3.0]]);
        for text in [
            "0,1.5\n2,3\n",
            "t,q\n0,1.5\n2,3",
            "# remark\n\nt (s), Q [m³/s]\r\n0, 1.5\r\n2, 3\r\n",
            "t;q\n0;1,5\n2;3\n",
            "0;1,5\n2;3\n",
            "0;1.5\n2;3\n",
            "t\tq\n0\t1,5\n2\t3\n",
            "0   1.5\n 2 3\n",
            "sep=;\nt;q\n0;1,5\n2;3\n",
            "\u{feff}0,1.5\n2,3\n",
            "q (l/s), t\n1500,0\n3000,2\n",
            "time (min), discharge (m3/min)\n0,90\n0.03333333333333333,180\n",
            "\"t\",\"q\"\n\"0\",\"1.5\"\n2,3\n",
        ] {
            assert_eq!(pairs(text.as_bytes()), right, "{text:?}");
        }
        let wide: Vec<u8> = "t;q\n0;1,5\n2;3\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(pairs(&[&[0xff, 0xfe], &wide[..]].concat()), right);
        assert_eq!(pairs(b"t (s),Q (m\xb3/s)\n0,1.5\n2,3\n"), right, "Latin-1");
    }

    #[test]
    fn units_without_brackets_are_recognised() {
        let right = vec![[0.0, 1.5], [7200.0, 3.0]];
        for head in ["t/h,Q/(m3/s)", "time in hours,Q in m3/s", "t_h,Q_m3s", "time h,Q m3/s", "t [h],Q"] {
            assert_eq!(pairs(format!("{head}\n0,1.5\n2,3\n").as_bytes()).unwrap(), right, "{head}");
        }
        let plain = vec![[0.0, 1.5], [2.0, 3.0]];
        assert_eq!(name_and_unit("axial_compression (%)"), ("axial_compression", Some("%")));
        assert_eq!(name_and_unit("void_ratio %"), ("void_ratio", Some("%")));
        for head in ["t_0,Q_in", "time,discharge of the gauge", "t s,Q"] {
            assert_eq!(pairs(format!("{head}\n0,1.5\n2,3\n").as_bytes()).unwrap(), plain, "{head}");
        }
        assert!(
            pairs(b"t/yr,Q\n0,1\n")
                .unwrap_err()
                .starts_with("column \"t/yr\": the unit must be one of a time")
        );
    }

    #[test]
    fn unreadable_columns_are_refused_with_line_and_remedy() {
        let problem = |text: &str| pairs(text.as_bytes()).unwrap_err();
        assert_eq!(
            problem("t,q\n0,1,5\n"),
            "line 2: has 3 values, the head has 2 columns; with decimal commas separate the columns by semicolons"
        );
        assert!(problem("0,0,1,5\n").starts_with("line 1: has 4 columns, but must have two; with decimal"));
        assert_eq!(problem("t,q\n0,x\n"), "line 2: \"x\" is not a finite number");
        assert_eq!(problem("0,nan\n"), "line 1: \"nan\" is not a finite number");
        assert!(problem("0,q\n1,2\n").starts_with("line 1: \"q\" is not a number, but the other"));
        assert!(problem("t (yr),q\n0,1\n").starts_with("column \"t (yr)\": the unit must be one of a time"));
        assert_eq!(problem("t;q\n0;1.000,5\n"), "line 2: \"1.000,5\" is not a finite number");
    }
}
