//! ESRI ASCII grids: reader and writer.

use std::fmt::Write;
use std::str::SplitAsciiWhitespace;

use colluvium_points::{Georeference, Raster};

use crate::Problem;
use crate::raster_band::{BandMetadata, parse_number};

/// Header of an ESRI ASCII grid.
#[derive(Default)]
struct AsciiHeader {
    columns: Option<usize>,
    rows: Option<usize>,
    /// Corner or centre of the first cell, per axis, and whether it is a corner.
    origin: [Option<(f64, bool)>; 2],
    spacing: [Option<f64>; 2],
    no_data: Option<f64>,
}

impl AsciiHeader {
    /// Sets a key of the header; an error where it is given twice or is not a number.
    fn set_value(&mut self, key: &str, value: &str) -> Result<(), String> {
        let number = || parse_number(value).ok_or_else(|| format!("{key} is {value:?}, not a number"));
        let count = || value.parse::<usize>().map_err(|_| format!("{key} is {value:?}, not a count"));
        let key = key.to_ascii_lowercase();
        let is_given = match key.as_str() {
            "ncols" => self.columns.is_some(),
            "nrows" => self.rows.is_some(),
            "xllcorner" | "xllcenter" | "xllcentre" => self.origin[0].is_some(),
            "yllcorner" | "yllcenter" | "yllcentre" => self.origin[1].is_some(),
            "cellsize" | "dx" => self.spacing[0].is_some(),
            "dy" => self.spacing[1].is_some(),
            "nodata_value" | "nodata" => self.no_data.is_some(),
            _ => false,
        };
        if is_given {
            return Err(format!("{key} is given twice"));
        }
        match key.as_str() {
            "ncols" => self.columns = Some(count()?),
            "nrows" => self.rows = Some(count()?),
            "xllcorner" => self.origin[0] = Some((number()?, true)),
            "yllcorner" => self.origin[1] = Some((number()?, true)),
            "xllcenter" | "xllcentre" => self.origin[0] = Some((number()?, false)),
            "yllcenter" | "yllcentre" => self.origin[1] = Some((number()?, false)),
            "cellsize" => self.spacing = [Some(number()?); 2],
            "dx" => self.spacing[0] = Some(number()?),
            "dy" => self.spacing[1] = Some(number()?),
            "nodata_value" | "nodata" => self.no_data = Some(number()?),
            _ => return Err(format!("{key:?} is not a key of an ESRI ASCII grid")),
        }
        Ok(())
    }
}

/// Value of a key that a header must have.
fn required<T>(value: Option<T>, key: &str) -> Result<T, String> {
    value.ok_or_else(|| format!("the key {key} is missing"))
}

/// No-data value of a grid that names none, by the definition of the format.
const NO_DATA: f64 = -9999.0;

/// Parses the text of a grid, whose rows run from north to south. `beside` is the band metadata of the sidecar file. Lines that begin with
/// `#` are comments.
pub(crate) fn parse(text: &str, beside: BandMetadata) -> Result<Raster, Problem> {
    if text.trim().is_empty() {
        return Err(Problem::coded("truncated-file")("is empty".to_owned()));
    }
    let without;
    let text = if text.contains('#') {
        let lines = text.lines().filter(|line| !line.trim_start().starts_with('#'));
        without = lines.collect::<Vec<_>>().join("\n");
        &without
    } else {
        text
    };
    if ["DSAA", "DSBB", "DSRB"].iter().any(|start| text.starts_with(start)) {
        let problem = "is a grid of Surfer: write it as an ESRI ASCII grid";
        return Err(Problem::coded("unsupported-format")(problem.to_owned()));
    }
    let mut words = text.split_ascii_whitespace();
    let (mut head, mut first) = (AsciiHeader::default(), None);
    while let Some(word) = words.next() {
        if word.starts_with(|c: char| c.is_ascii_alphabetic()) && parse_number(word).is_none() {
            let value = words.next().ok_or_else(|| format!("{word} has no value"))?;
            head.set_value(word.trim_end_matches([':', '=']), value)?;
        } else {
            first = Some(word);
            break;
        }
    }
    let (columns, rows) = (required(head.columns, "ncols")?, required(head.rows, "nrows")?);
    let (x, corner) = required(head.origin[0], "xllcorner or xllcenter")?;
    let (y, other) = required(head.origin[1], "yllcorner or yllcenter")?;
    if corner != other {
        let problem = "has a corner along one axis and a centre along the other";
        return Err(Problem::coded("no-georeference")(problem.to_owned()));
    }
    let spacing =
        [required(head.spacing[0], "cellsize or dx")?, required(head.spacing[1], "cellsize or dy")?];
    let values = values(first, words, columns, rows)?;
    let shift = if corner { 0.5 } else { 0.0 };
    let mut raster = Raster {
        columns,
        rows,
        origin: [x + shift * spacing[0], y + shift * spacing[1]],
        spacing,
        values,
        reference: Georeference { pixel_is_area: corner, ..Georeference::default() },
    };
    let own = BandMetadata::with_no_data(head.no_data);
    let band = own.completed_by(beside).completed_by(BandMetadata::with_no_data(Some(NO_DATA)));
    band.apply(&mut raster, None)?;
    Ok(raster)
}

/// Reads the heights of all nodes.
fn values(
    first: Option<&str>,
    rest: SplitAsciiWhitespace<'_>,
    columns: usize,
    rows: usize,
) -> Result<Vec<f64>, Problem> {
    let count = columns.checked_mul(rows).filter(|count| *count < 1 << 32);
    let count = count.ok_or_else(|| format!("{columns} columns and {rows} rows are too many"))?;
    let mut values = Vec::with_capacity(count.min(1 << 24));
    for word in first.into_iter().chain(rest) {
        let at = values.len();
        let value = parse_number(word).ok_or_else(|| {
            let (row, column) = (at / columns.max(1) + 1, at % columns.max(1) + 1);
            if let Some(sign) = separator(word) {
                return format!(
                    "the numbers in row {row} are separated by {sign:?}: separate them by spaces"
                );
            }
            let cure = if word.contains(',') { ": write it with a decimal point" } else { "" };
            let start: String = word.chars().take(30).collect();
            format!("{start:?} in row {row}, column {column} is not a number{cure}")
        })?;
        values.push(value);
        if values.len() > count {
            break;
        }
    }
    if values.len() != count {
        let found = if values.len() > count { "more".to_owned() } else { values.len().to_string() };
        let problem = format!("{columns} columns and {rows} rows make {count} values, but there are {found}");
        return Err(Problem::coded("truncated-file")(problem));
    }
    // In memory the row with the smallest y comes first.
    Ok(values.chunks(columns.max(1)).rev().flatten().copied().collect())
}

/// Separator of the numbers in a word that contains several. A single comma may be a decimal comma.
fn separator(word: &str) -> Option<char> {
    let holds = |sign: char, count: usize| {
        let pieces: Vec<&str> = word.split(sign).filter(|piece| !piece.is_empty()).collect();
        let are_numbers = pieces.iter().all(|piece| parse_number(&piece.replace(',', ".")).is_some());
        word.contains(sign) && are_numbers && (pieces.len() >= count || word.ends_with(sign))
    };
    let with_points = word.contains(',') && word.contains('.');
    if holds(';', 1) {
        return Some(';');
    }
    holds(',', if with_points { 2 } else { 3 }).then_some(',')
}

/// Text of an ESRI ASCII grid.
pub(crate) fn format(raster: &Raster) -> String {
    let Raster { columns, rows, origin, spacing: [dx, dy], reference, .. } = raster;
    let no_data = reference.no_data.unwrap_or(NO_DATA);
    let (name, shift) = if reference.pixel_is_area { ("corner", 0.5) } else { ("center", 0.0) };
    let mut text = format!("ncols {columns}\nnrows {rows}\n");
    let corner = [origin[0] - shift * dx, origin[1] - shift * dy];
    let _ = write!(text, "xll{name} {}\nyll{name} {}\n", corner[0], corner[1]);
    let _ = if dx == dy { writeln!(text, "cellsize {dx}") } else { writeln!(text, "dx {dx}\ndy {dy}") };
    let _ = writeln!(text, "NODATA_value {no_data}");
    for row in raster.values.chunks(*columns).rev() {
        for (column, value) in row.iter().enumerate() {
            let value = if value.is_finite() { *value } else { no_data };
            let _ = write!(text, "{}{value}", if column == 0 { "" } else { " " });
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Raster, String> {
        super::parse(text, BandMetadata::default()).map_err(|problem| problem.text)
    }

    const CORNER: &str =
        "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -9999\n1 2 3\n4 -9999 6\n";

    #[test]
    fn rows_begin_in_the_north_and_values_are_at_cell_centres() {
        let raster = parse(CORNER).unwrap();
        assert_eq!((raster.columns, raster.rows, raster.origin), (3, 2, [105.0, 205.0]));
        assert_eq!((raster.value(0, 0), raster.value(2, 1)), (4.0, 3.0));
        assert!(raster.value(1, 0).is_nan());
        assert_eq!(parse(&format(&raster)).map(|back| format(&back)), Ok(format(&raster)));
        assert!(format(&raster).contains("xllcorner 100\n") && format(&raster).contains("4 -9999 6"));
    }

    #[test]
    fn centres_and_unequal_spacings_are_read_and_written_back() {
        let text = "NCOLS 2\nNROWS 2\nXLLCENTER 1.5\nYLLCENTER -2\nDX 0.1\nDY 0.3\n0.1 1e3\n-2.5 7\n";
        let raster = parse(text).unwrap();
        assert_eq!((raster.origin, raster.spacing), ([1.5, -2.0], [0.1, 0.3]));
        let back = parse(&format(&raster)).unwrap();
        assert_eq!(
            (back.origin, back.spacing, &back.values),
            (raster.origin, raster.spacing, &raster.values)
        );
    }

    #[test]
    fn errors_in_ascii_grids_name_the_key_or_the_cell() {
        let problem = |from: &str, to: &str| parse(&CORNER.replace(from, to)).unwrap_err();
        assert!(problem("nrows 2\n", "").contains("nrows is missing"));
        assert!(problem("cellsize 10", "cellsize ten").contains("not a number"));
        assert!(problem("4 -9999 6", "4 -9999").contains("make 6 values, but there are 5"));
        assert!(problem("4 -9999 6", "4 -9999 6 7").contains("more"));
        assert!(problem("yllcorner", "yllcenter").contains("corner along one axis"));
        assert!(problem("1 2 3", "1 x 3").contains("row 1, column 2"));
        for (row, sign) in [
            ("1;2;3", ';'),
            ("1,0;2,0;3,0", ';'),
            ("1; 2; 3", ';'),
            ("1,2,3", ','),
            ("1.5,2.5 3", ','),
            ("1, 2, 3", ','),
        ] {
            assert!(problem("1 2 3", row).contains(&format!("in row 1 are separated by {sign:?}")), "{row}");
        }
        assert!(problem("1 2 3", "1,5 2 3").contains("write it with a decimal point"));
        assert!(problem("ncols 3", "rotation 3").contains("not a key"));
        assert!(problem("cellsize 10", "cellsize 5\nCELLSIZE 10").contains("cellsize is given twice"));
        assert!(problem("cellsize 10", "cellsize 5\ndx 10").contains("dx is given twice"));
        assert_eq!(parse(" \n"), Err("is empty".to_owned()));
        assert!(
            parse("ncols 99999999999\nnrows 99999999999\nxllcorner 0\nyllcorner 0\ncellsize 1\n1").is_err()
        );
    }
}
