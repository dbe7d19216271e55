//! Checks of raster heights that probably stand for no data.

use colluvium_points::Raster;

use crate::Case;
use crate::description::ObstacleShape;
use colluvium_constitutive::Warning;

/// Advice on the declaration of a no-data value.
const NO_DATA_ADVICE: &str = "declare it in the file, as NODATA_value or in the GDAL tag";

/// Height (m) below any ground on Earth with flows: lower values probably stand for no data.
const MIN_HEIGHT: f64 = -9000.0;

/// Slope above which the boundary of a level part of a raster is probably not that of ground.
const MIN_RIM_SLOPE: f64 = 5.0;

impl Case {
    /// Warns of heights that are not finite, and of heights that probably stand for an undeclared no-data value. Files that cannot be read
    /// are rejected elsewhere.
    pub(crate) fn warn_of_heights(&self, warnings: &mut Vec<Warning>) {
        for (number, obstacle) in self.obstacles.iter().enumerate() {
            let ObstacleShape::Raster { file, .. } = &obstacle.shape else { continue };
            let Ok(Some(raster)) = self.heights(number) else { continue };
            let unmarked = raster.reference.undeclared_no_data;
            if unmarked > 0 {
                warnings.push(Warning::new("doubtful-no-data", format!(
                    "obstacles[{number}].shape.file: {file}: {unmarked} of its values are not finite and are \
                     not the declared no-data value. There is no ground at these values. Fill them where \
                     ground is needed"
                )));
            }
            let low = |height: &f64| height + self.origin()[2] < MIN_HEIGHT;
            let count = raster.values.iter().filter(|height| low(height)).count();
            if count > 0 {
                let lowest = raster.values.iter().copied().fold(f64::INFINITY, f64::min) + self.origin()[2];
                warnings.push(Warning::new("doubtful-no-data", format!(
                    "obstacles[{number}].shape.file: {file}: {count} of its heights are below {MIN_HEIGHT} \
                     m, the lowest {lowest} m. If that value stands for no data, {NO_DATA_ADVICE}"
                )));
                continue;
            }
            for IsolatedLevel { level, count, height_difference } in isolated_levels(&raster) {
                let (level, side) =
                    (level + self.origin()[2], if height_difference > 0.0 { "above" } else { "below" });
                warnings.push(Warning::new("doubtful-no-data", format!(
                    "obstacles[{number}].shape.file: {file}: {count} of its heights are {level} m, and all \
                     adjacent heights are at least {:.1} m {side}. If that value stands for no data, \
                     {NO_DATA_ADVICE}",
                    height_difference.abs()
                )));
            }
        }
    }
}

/// Lowest or highest nodes of a raster, which a step separates from all others.
struct IsolatedLevel {
    /// Common height (m).
    level: f64,
    /// Number of nodes.
    count: usize,
    /// Smallest height of the adjacent nodes over theirs, with its sign (m).
    height_difference: f64,
}

/// Lowest and highest nodes with a steep boundary all around.
fn isolated_levels(raster: &Raster) -> Vec<IsolatedLevel> {
    let known = || raster.values.iter().copied().filter(|height| height.is_finite());
    let ends = [known().fold(f64::INFINITY, f64::min), known().fold(f64::NEG_INFINITY, f64::max)];
    let level = |level: f64, side: f64| {
        let (mut count, mut rim) = (0, f64::INFINITY);
        for (number, _) in raster.values.iter().enumerate().filter(|(_, height)| **height == level) {
            let (column, row) = (number % raster.columns, number / raster.columns);
            count += 1;
            let beside = [
                (column > 0).then(|| number - 1),
                (column + 1 < raster.columns).then_some(number + 1),
                (row > 0).then(|| number - raster.columns),
                (row + 1 < raster.rows).then_some(number + raster.columns),
            ];
            let others = beside.into_iter().flatten().map(|other| raster.values[other]);
            let apart = others.filter(|other| *other != level).map(|other| side * (other - level));
            rim = apart.fold(rim, f64::min);
        }
        let upright = MIN_RIM_SLOPE * raster.spacing[0].max(raster.spacing[1]);
        // Of two levels the one of fewer nodes is doubtful.
        let is_few = 2 * count < raster.values.len();
        (is_few && rim.is_finite() && rim > upright).then_some(IsolatedLevel {
            level,
            count,
            height_difference: side * rim,
        })
    };
    let of_ends = [(ends[0], 1.0), (ends[1], -1.0)].map(|(end, side)| level(end, side));
    of_ends.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use colluvium_points::Raster;
    use serde_json::json;

    use crate::Case;

    fn warnings(folder: &Path, height: impl Fn(f64, f64) -> f64, as_text: bool) -> Vec<String> {
        let raster = Raster::from_function([5, 5], [0.0; 2], [1.0; 2], height);
        let name = if as_text { "ground.asc" } else { "ground.tif" };
        colluvium_terrain::write_raster(&folder.join(name), &raster).unwrap();
        if as_text {
            let text = std::fs::read_to_string(folder.join(name)).unwrap().replace("-7777", "nan");
            std::fs::write(folder.join(name), text).unwrap();
        }
        let case = json!({
            "title": "t", "space": "3d", "domain": { "min": [0, 0, 0], "max": [4, 4, 9] }, "gravity": [0, 0, -10],
            "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [1, 1, 5], "max": [2, 2, 6] } }],
            "obstacles": [{ "name": "ground", "wall": { "kind": "rough" }, "shape": { "kind": "raster", "file": name } }],
            "stages": [{ "name": "s", "duration": 1 }]
        });
        let warnings = Case::from_value(&case, folder).unwrap().warnings();
        let mut warnings: Vec<String> = warnings.into_iter().map(|warning| warning.text).collect();
        warnings.retain(|warning| warning.starts_with("obstacles[0].shape.file"));
        warnings
    }

    #[test]
    fn non_finite_heights_and_undeclared_no_data_marks_are_reported_with_their_count() {
        let folder = tempfile::tempdir().unwrap();
        let corner = |mark: f64| move |x: f64, y: f64| if x + y < 1.5 { mark } else { 1.0 };
        assert_eq!(warnings(folder.path(), corner(1.0), true), Vec::<String>::new());
        assert_eq!(warnings(folder.path(), corner(-9999.0), true), Vec::<String>::new());
        let found = warnings(folder.path(), corner(-7777.0), true);
        assert!(
            found.len() == 1 && found[0].contains("ground.asc: 3 of its values are not finite"),
            "{found:?}"
        );
        let found = warnings(folder.path(), corner(-32768.0), false);
        assert!(
            found.len() == 1 && found[0].contains("3 of its heights are below -9000 m, the lowest -32768 m"),
            "{found:?}"
        );
        for (mark, side) in [(-99.99, "above"), (1e20, "below"), (9999.0, "below")] {
            let found = warnings(folder.path(), corner(mark), false);
            let expected = format!("3 of its heights are {mark} m, and all adjacent heights are at least");
            assert!(found.len() == 1 && found[0].contains(&expected) && found[0].contains(side), "{found:?}");
        }
        // A lake, and a summit.
        let valley = |x: f64, y: f64| (x - 2.0).abs().max((y - 2.0).abs()).max(1.0);
        assert_eq!(warnings(folder.path(), valley, false), Vec::<String>::new());
        assert_eq!(warnings(folder.path(), |x, y| -valley(x, y), false), Vec::<String>::new());
    }
}
