//! Pictures of what a run has left in its folder.

use std::path::Path;

use crate::case::Snapshot;
use crate::case::output::{OutputError, Table, heading, read_frame, read_json};
use crate::plots::{LineChart, PointCloud, Series, Style};

/// Columns of the measures that are no result.
const COUNTS: [&str; 2] = ["time", "step"];

/// A chart in time of each column of the measures, by its name; those that never have a value are left out.
pub fn charts(table: &Table) -> Vec<(String, LineChart)> {
    let columns = table.columns.iter().filter(|(name, _)| !COUNTS.contains(&name.as_str()));
    let chart = |(name, unit): &(String, String)| {
        let points = table.pairs("time", name)?;
        let seen = points.iter().any(|(_, value)| value.is_finite());
        seen.then(|| (name.clone(), in_time(&heading(name, unit), points)))
    };
    columns.filter_map(chart).collect()
}

fn in_time(label: &str, points: Vec<(f64, f64)>) -> LineChart {
    LineChart {
        x_label: "time (s)".to_owned(),
        y_label: label.replace('_', " "),
        series: vec![Series::new("", points, Style::Line)],
        ..LineChart::default()
    }
}

/// A frame of a run: its time (s) and file, as its collection has them.
///
/// # Errors
/// When the file cannot be read.
pub fn frame(folder: &Path, (time, file): &(f64, String)) -> Result<Snapshot, OutputError> {
    read_frame(&folder.join(file), *time)
}

/// The points of a frame coloured by a field, with the name of the field: the one asked for, or `displacement`, or the
/// first there is.
///
/// # Errors
/// The names of the fields there are, where the one asked for is not among them.
pub fn cloud(
    snapshot: &Snapshot,
    field: Option<&str>,
    plane: [usize; 2],
) -> Result<(String, PointCloud), String> {
    let names: Vec<&str> = snapshot.fields.iter().map(|field| field.name.as_str()).collect();
    let usual = names.iter().find(|name| **name == "displacement").or(names.first()).copied();
    let name = field.or(usual).unwrap_or_default();
    let cloud = PointCloud::of(snapshot, name, plane);
    cloud.map(|cloud| (name.to_owned(), cloud)).ok_or_else(|| names.join(", "))
}

/// The two axes seen: of the view `asked` for, `xy`, `xz` or `yz`; else x and y, and in three dimensions with gravity along z
/// x and z, as the case in the folder of the run has it.
///
/// # Errors
/// When that case cannot be read; none need be there.
pub fn plane(folder: &Path, asked: Option<&str>) -> Result<[usize; 2], OutputError> {
    let gravity = if asked.is_none() { gravity(folder)? } else { None };
    Ok(plane_under(gravity, asked))
}

/// The two axes seen, as [`plane`] has them, where gravity along z is known (m/s²; `None` where there is no z).
pub fn plane_under(gravity: Option<f64>, asked: Option<&str>) -> [usize; 2] {
    match asked {
        Some("xz") => [0, 2],
        Some("yz") => [1, 2],
        None if gravity.is_some_and(|along_z| along_z != 0.0) => [0, 2],
        _ => [0, 1],
    }
}

/// Gravity along z of the case in the folder of a run.
fn gravity(folder: &Path) -> Result<Option<f64>, OutputError> {
    let path = folder.join("case.json");
    let case = if path.exists() { read_json(&path)? } else { serde_json::Value::Null };
    Ok(case["gravity"][2].as_f64())
}

#[cfg(test)]
mod tests {
    use super::plane;

    #[test]
    fn what_stands_along_z_is_seen_from_its_side() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(plane(folder.path(), None).unwrap(), [0, 1]);
        let axes = |gravity: &str, asked: Option<&str>| {
            std::fs::write(folder.path().join("case.json"), format!("{{ \"gravity\": {gravity} }}")).unwrap();
            plane(folder.path(), asked).unwrap()
        };
        assert_eq!(axes("[0, -9.81]", None), [0, 1]);
        assert_eq!(axes("[0, -9.81, 0]", None), [0, 1]);
        assert_eq!(axes("[0, 0, -9.81]", None), [0, 2]);
        assert_eq!(axes("[0, 0, -9.81]", Some("xy")), [0, 1]);
        assert_eq!(axes("[0, 0, 0]", Some("yz")), [1, 2]);
        std::fs::write(folder.path().join("case.json"), "{\n  \"gravity\": [0, 0,").unwrap();
        let error = plane(folder.path(), None).unwrap_err().to_string();
        assert!(error.contains("case.json: line 2, column 19: EOF"), "{error}");
    }
}
