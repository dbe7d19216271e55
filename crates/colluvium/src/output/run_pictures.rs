//! Pictures of the files in the folder of a run.

use std::path::Path;

use serde_json::Value;

use crate::case::output::{OutputError, Table, column_heading, read_frame, read_json};
use crate::case::{Dataset, Field, Snapshot};
use crate::plots::{ForceChains, LineChart, PointCloud, Series, Style};

/// Columns of the measures that are not results.
const COUNT_COLUMNS: [&str; 2] = ["time", "step"];

/// Charts over time of the columns of the measures, by name; columns without values are left out.
pub fn charts(table: &Table) -> Vec<(String, LineChart)> {
    let columns = table.columns.iter().filter(|(name, _)| !COUNT_COLUMNS.contains(&name.as_str()));
    let chart = |(name, unit): &(String, String)| {
        let points = table.pairs("time", name)?;
        let has_values = points.iter().any(|(_, value)| value.is_finite());
        has_values.then(|| (name.clone(), time_chart(name, &column_heading(name, unit), points)))
    };
    columns.filter_map(chart).collect()
}

/// Chart of a measure over time.
fn time_chart(name: &str, label: &str, points: Vec<(f64, f64)>) -> LineChart {
    LineChart {
        title: name.replace('_', " "),
        x_label: "time (s)".to_owned(),
        y_label: label.replace('_', " "),
        series: vec![Series::new("", points, Style::Line)],
        ..LineChart::default()
    }
}

/// Share of the largest value below which a change is rounding noise.
const ROUNDING_SHARE: f64 = 1e-9;

/// Whether a series changes by more than rounding noise.
pub fn is_changing(points: &[(f64, f64)]) -> bool {
    let values = || points.iter().map(|p| p.1).filter(|value| value.is_finite());
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    high - low > ROUNDING_SHARE * high.abs().max(low.abs())
}

/// Sets rounding noise in a table to zero: values below a billionth of the largest of all columns of the same unit. A momentum is also
/// compared with that of the whole mass at the largest kinetic energy.
pub(crate) fn without_rounding_noise(mut table: Table) -> Table {
    let reach =
        |k: usize| table.rows.iter().map(|row| row[k].abs()).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let named = |wanted: &str| table.columns.iter().position(|(name, _)| name == wanted).map(reach);
    let momentum = match (named("mass"), named("kinetic_energy")) {
        (Some(mass), Some(energy)) => (2.0 * mass * energy).sqrt(),
        _ => 0.0,
    };
    let smallest = |k: usize| {
        let (name, unit) = &table.columns[k];
        let of_kind = |j: &usize| table.columns[*j].1 == *unit && !unit.is_empty();
        let kind = (0..table.columns.len()).filter(of_kind).map(reach).fold(reach(k), f64::max);
        ROUNDING_SHARE * if name.starts_with("momentum") { kind.max(momentum) } else { kind }
    };
    // A time is not rounding noise of a longer one.
    let smallest: Vec<f64> =
        (0..table.columns.len()).map(|k| if table.columns[k].1 == "s" { 0.0 } else { smallest(k) }).collect();
    for row in &mut table.rows {
        for (value, smallest) in row.iter_mut().zip(&smallest) {
            if value.abs() < *smallest {
                *value = 0.0;
            }
        }
    }
    table
}

/// Reads a frame of a run from its time (s) and file, as the collection lists them.
///
/// # Errors
/// When the file cannot be read.
pub fn read_collection_frame(folder: &Path, (time, file): &(f64, String)) -> Result<Snapshot, OutputError> {
    read_frame(&folder.join(file), *time)
}

/// Sets the units of forces in frames of a case: N, or N/m in plane strain, where forces are per metre of thickness.
pub fn set_force_units(fields: &mut [Field], case: &Value) {
    let of_thickness = case["space"] == "plane-strain";
    for field in fields.iter_mut().filter(|field| of_thickness && field.unit == "N") {
        field.unit = "N/m";
    }
}

/// Picture of the points of a frame coloured by a field, with the name of the field: the requested one, or `displacement`, or the first
/// one.
///
/// # Errors
/// The names of the available fields, where the requested one is not among them.
pub fn point_picture(
    snapshot: &Snapshot,
    field: Option<&str>,
    plane: [usize; 2],
) -> Result<(String, PointCloud), String> {
    let names: Vec<&str> = snapshot.fields.iter().map(|field| field.name.as_str()).collect();
    let usual = names.iter().find(|name| **name == "displacement").or(names.first()).copied();
    let name = field.or(usual).unwrap_or_default();
    let cloud = PointCloud::from_snapshot(snapshot, name, plane);
    cloud.map(|cloud| (name.to_owned(), cloud)).ok_or_else(|| names.join(", "))
}

/// Picture of the lines of a frame, as of contacts, between the grains at its time, as wide as a field is large, with the name of the
/// field: the requested one, or `force`, or the first one.
///
/// # Errors
/// The names of the available fields, where the requested one is not among them.
pub fn line_picture(
    contacts: &Dataset,
    grains: &Snapshot,
    field: Option<&str>,
    plane: [usize; 2],
) -> Result<(String, ForceChains), String> {
    let names: Vec<&str> = contacts.fields.iter().map(|field| field.name.as_str()).collect();
    let usual = names.iter().find(|name| **name == "force").or(names.first()).copied();
    let name = field.or(usual).unwrap_or_default();
    let chains = ForceChains::from_dataset(contacts, grains, name, plane);
    chains.map(|chains| (name.to_owned(), chains)).ok_or_else(|| names.join(", "))
}

/// Axes of a view: of `requested`, `xy`, `xz` or `yz`; else x and y, or x and z in three dimensions with gravity along z, from the case in the
/// folder of the run.
///
/// # Errors
/// When the case cannot be read; a missing one is no error.
pub fn view_plane(folder: &Path, requested: Option<&str>) -> Result<[usize; 2], OutputError> {
    let gravity = if requested.is_none() { gravity_along_z(folder)? } else { None };
    Ok(view_plane_for_gravity(gravity, requested))
}

/// Axes of a view, as in [`view_plane`], where gravity along z is known (m/s²; `None` without z axis).
pub fn view_plane_for_gravity(gravity: Option<f64>, requested: Option<&str>) -> [usize; 2] {
    match requested {
        Some("xz") => [0, 2],
        Some("yz") => [1, 2],
        None if gravity.is_some_and(|along_z| along_z != 0.0) => [0, 2],
        _ => [0, 1],
    }
}

/// Gravity along z (m/s²) of the case in the folder of a run.
fn gravity_along_z(folder: &Path) -> Result<Option<f64>, OutputError> {
    Ok(read_case_value(folder)?["gravity"][2].as_f64())
}

/// Case in the folder of a run as JSON; null where there is none.
///
/// # Errors
/// When the file cannot be read.
pub fn read_case_value(folder: &Path) -> Result<Value, OutputError> {
    let path = folder.join("case.json");
    if path.exists() { read_json(&path) } else { Ok(Value::Null) }
}

#[cfg(test)]
mod tests {
    use super::{view_plane, without_rounding_noise};
    use crate::case::output::Table;

    #[test]
    fn values_at_rounding_level_become_zero_and_small_results_remain() {
        let columns = [
            ("time", "s"),
            ("mass", "kg"),
            ("kinetic_energy", "J"),
            ("momentum.x", "kg m/s"),
            ("front", "m"),
            ("rise", "m"),
        ];
        let table = Table {
            columns: columns.iter().map(|(name, unit)| ((*name).into(), (*unit).into())).collect(),
            rows: vec![vec![1e-12, 20.0, 0.0, -5.6e-17, 0.1, 1e-17], vec![0.2, 20.0, 40.0, 3e-15, 0.3, 1e-6]],
        };
        let rows = without_rounding_noise(table).rows;
        assert_eq!(rows[0], [1e-12, 20.0, 0.0, 0.0, 0.1, 0.0]);
        assert_eq!(rows[1], [0.2, 20.0, 40.0, 0.0, 0.3, 1e-6]);
    }

    #[test]
    fn cases_with_gravity_along_z_are_drawn_in_the_xz_plane() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(view_plane(folder.path(), None).unwrap(), [0, 1]);
        let axes = |gravity: &str, requested: Option<&str>| {
            std::fs::write(folder.path().join("case.json"), format!("{{ \"gravity\": {gravity} }}")).unwrap();
            view_plane(folder.path(), requested).unwrap()
        };
        assert_eq!(axes("[0, -9.81]", None), [0, 1]);
        assert_eq!(axes("[0, -9.81, 0]", None), [0, 1]);
        assert_eq!(axes("[0, 0, -9.81]", None), [0, 2]);
        assert_eq!(axes("[0, 0, -9.81]", Some("xy")), [0, 1]);
        assert_eq!(axes("[0, 0, 0]", Some("yz")), [1, 2]);
        std::fs::write(folder.path().join("case.json"), "{\n  \"gravity\": [0, 0,").unwrap();
        let error = view_plane(folder.path(), None).unwrap_err().to_string();
        assert!(error.contains("case.json: line 2, column 19: EOF"), "{error}");
    }
}
