//! Raster files.

use std::fmt::Write as _;
use std::path::Path;

/// Writes an ESRI ASCII grid of `level(x, y)` (m) at the cell centres `low + spacing · (column, row)`. NaN is written as no data.
///
/// # Panics
/// When the file cannot be written.
pub fn write_ascii_grid(
    file: &Path,
    low: [f64; 2],
    counts: [usize; 2],
    spacing: f64,
    level: impl Fn(f64, f64) -> f64,
) {
    let [columns, rows] = counts;
    let mut text = format!(
        "ncols {columns}\nnrows {rows}\nxllcenter {}\nyllcenter {}\ncellsize {spacing}\nnodata_value -9999\n",
        low[0], low[1]
    );
    // The first row is that of the largest y.
    for row in (0..rows).rev() {
        for column in 0..columns {
            let level = level(low[0] + column as f64 * spacing, low[1] + row as f64 * spacing);
            write!(text, "{:?} ", if level.is_finite() { level } else { -9999.0 }).expect("a string grows");
        }
        text.push('\n');
    }
    std::fs::write(file, text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
}
