//! Regions of a surface in plan.

use std::sync::Arc;

use colluvium_points::{Outline, Raster, Shape};

use crate::description::RasterCellSelection;
use crate::{Case, CaseErrorKind};

/// Largest number of raster values in a message.
const MAX_LISTED_VALUES: usize = 12;

/// Region in plan: a shape, an outline, or cells of a raster.
#[derive(Clone, Debug)]
pub enum PlanRegion {
    /// Shape in plan coordinates.
    Shape(Shape),
    /// Outline in plan.
    Outline(Arc<Outline>),
    /// Cells of a raster in plan.
    Cells(Arc<RasterCells>),
}

impl PlanRegion {
    /// Whether the region contains a position in plan (m).
    #[inline]
    pub fn contains(&self, place: &[f64]) -> bool {
        match self {
            Self::Shape(shape) => shape.contains(place),
            Self::Outline(outline) => matches!(place, [x, y] if outline.contains([*x, *y])),
            Self::Cells(cells) => matches!(place, [x, y] if cells.contain([*x, *y])),
        }
    }
}

/// Selected cells of a raster, each extending half a spacing to all sides of its node.
#[derive(Clone, Debug)]
pub struct RasterCells {
    counts: [usize; 2],
    low: [f64; 2],
    spacing: [f64; 2],
    is_selected: Vec<bool>,
}

impl RasterCells {
    /// Cells of a raster with the value `value`, or with any number.
    fn from_raster(raster: &Raster, value: Option<f64>) -> Self {
        let is_chosen = |held: &f64| value.map_or(held.is_finite(), |value| *held == value);
        Self {
            counts: [raster.columns, raster.rows],
            low: std::array::from_fn(|c| raster.origin[c] - 0.5 * raster.spacing[c]),
            spacing: raster.spacing,
            is_selected: raster.values.iter().map(is_chosen).collect(),
        }
    }

    /// Whether a position in plan (m) lies in one of the cells. A position on a common edge belongs to the cell with the larger coordinate.
    #[inline]
    fn contain(&self, place: [f64; 2]) -> bool {
        let [x, y] = std::array::from_fn(|c| (place[c] - self.low[c]) / self.spacing[c]);
        let beyond = x < 0.0 || y < 0.0 || x >= self.counts[0] as f64 || y >= self.counts[1] as f64;
        !beyond
            && self.is_selected.get(y as usize * self.counts[0] + x as usize).is_some_and(|chosen| *chosen)
    }

    /// Whether one of the cells overlaps a box between two corners in plan (m).
    fn intersect_box(&self, low: &[f64], high: &[f64]) -> bool {
        let chosen = self.is_selected.iter().enumerate().filter(|(_, chosen)| **chosen);
        chosen.map(|(number, _)| [number % self.counts[0], number / self.counts[0]]).any(|cell| {
            (0..2).all(|c| {
                let from = self.low[c] + cell[c] as f64 * self.spacing[c];
                from < high[c] && from + self.spacing[c] > low[c]
            })
        })
    }
}

impl Case {
    /// Region in plan of a definition, which is a shape, an outline in a file, or cells of a raster.
    ///
    /// # Errors
    /// The key `shape`, `outline` or `raster` with the path below it, and a description: none or several keys are given; a shape that is
    /// invalid in plan; an outline or a raster where the plan is a line, or whose file cannot be read; a value without a cell; a region
    /// outside the domain.
    pub fn plan_region(
        &self,
        shape: Option<Shape>,
        outline: Option<&str>,
        raster: Option<&RasterCellSelection>,
    ) -> Result<PlanRegion, (String, CaseErrorKind)> {
        let wrong = |key: &str, kind: CaseErrorKind| Err((key.to_owned(), kind));
        match (shape, outline, raster) {
            (Some(shape), None, None) => match shape.validate(self.dimension() - 1) {
                Ok(()) => {
                    let (low, high) = shape.bounds(self.dimension() - 1);
                    match self.outside_domain_problem(&low, &high) {
                        Some(problem) => wrong("shape", problem.into()),
                        None => Ok(PlanRegion::Shape(shape)),
                    }
                }
                Err(error) => wrong(&format!("shape.{}", error.path), error.problem.into()),
            },
            (None, Some(_), None) if self.dimension() != 3 => wrong(
                "outline",
                CaseErrorKind::coded(
                    "needs-other-key",
                    "an outline in plan needs a space of 3d: give a shape",
                ),
            ),
            (None, Some(file), None) => match self.outline(file) {
                Ok(outline) => {
                    let (low, high) = outline.bounds();
                    match self.outside_domain_problem(&low, &high) {
                        Some(problem) => {
                            wrong("outline", CaseErrorKind::coded_file(file, "outside-domain", problem))
                        }
                        None => Ok(PlanRegion::Outline(Arc::new(outline))),
                    }
                }
                Err(problem) => wrong("outline", problem),
            },
            (None, None, Some(_)) if self.dimension() != 3 => wrong(
                "raster",
                CaseErrorKind::coded(
                    "needs-other-key",
                    "a raster over a plan needs a space of 3d: give a shape",
                ),
            ),
            (None, None, Some(raster)) => self
                .cells_of(raster)
                .map(|cells| PlanRegion::Cells(Arc::new(cells)))
                .map_err(|(key, problem)| (format!("raster.{key}"), problem)),
            _ => wrong(
                "shape",
                CaseErrorKind::coded("conflicting-keys", "give one of a shape, an outline and a raster"),
            ),
        }
    }

    /// Cells of a raster file with the selected value. The error is the key below that of the raster, with a description.
    fn cells_of(&self, of: &RasterCellSelection) -> Result<RasterCells, (&'static str, CaseErrorKind)> {
        let RasterCellSelection { file, value } = of;
        // A class is selected by its number; the selection of any number needs a declared no-data value.
        let raster = match value {
            Some(_) => self.raster_of_classes(file),
            None => self.plan_raster(file),
        };
        let raster = raster.map_err(|problem| ("file", problem))?;
        let half = raster.spacing.map(|spacing| 0.5 * spacing);
        let low: [f64; 2] = std::array::from_fn(|c| raster.origin[c] - half[c]);
        let high: [f64; 2] = std::array::from_fn(|c| raster.last_node_position()[c] + half[c]);
        if let Some(problem) = self.outside_domain_problem(&low, &high) {
            return Err(("file", CaseErrorKind::coded_file(file, "no-data", problem)));
        }
        let cells = RasterCells::from_raster(&raster, *value);
        let what = value.map_or("data".to_owned(), |value| value.to_string());
        if !cells.is_selected.contains(&true) {
            let problem = format!("no cell of {file} has {what}: {}", values_text(&raster));
            return Err(("value", CaseErrorKind::coded("no-data", problem)));
        }
        if !cells.intersect_box(&self.domain.min, &self.domain.max) {
            let key = if value.is_some() { "value" } else { "file" };
            let problem = format!("none of the cells of {file} that have {what} lies in the domain");
            return Err((key, CaseErrorKind::coded("no-data", problem)));
        }
        Ok(cells)
    }

    /// Error text for a box (m, relative to `domain.origin`) outside the domain; `None` where they overlap.
    pub fn outside_domain_problem(&self, low: &[f64], high: &[f64]) -> Option<String> {
        let apart = self.outside_extent(low, high, true)?;
        Some(format!("lies outside the domain: it reaches {apart}"))
    }

    /// Text with the extents of a box and of the domain along the first axis along which the box lies outside. With `touches`, a box that
    /// only touches the domain counts as outside.
    pub(crate) fn outside_extent(&self, low: &[f64], high: &[f64], touches: bool) -> Option<String> {
        let (origin, domain) = (self.origin(), &self.domain);
        let c = (0..low.len()).find(|&c| {
            let gap = (domain.min[c] - high[c]).max(low[c] - domain.max[c]);
            gap > 0.0 || touches && gap == 0.0
        })?;
        let [from, to, min, max] = [low[c], high[c], domain.min[c], domain.max[c]].map(|x| x + origin[c]);
        let axis = ["x", "y", "z"][c];
        Some(format!("from {from} to {to} m along {axis}, the domain from {min} to {max} m"))
    }
}

/// Text of the first values of a raster, for a message.
fn values_text(raster: &Raster) -> String {
    let mut values: Vec<f64> = raster.values.iter().copied().filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let shown: Vec<String> = values.iter().take(MAX_LISTED_VALUES).map(f64::to_string).collect();
    let more = if values.len() > MAX_LISTED_VALUES {
        format!(" and {} more", values.len() - MAX_LISTED_VALUES)
    } else {
        String::new()
    };
    format!("the values are {}{more}", shown.join(", "))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::{Value, json};

    use super::*;

    /// Land cover at map coordinates: 1 in the west, 3 in the east, and no data in the north.
    fn write_land_cover(folder: &Path, name: &str) {
        let value = |x: f64, y: f64| match (x, y) {
            (_, y) if y > 5_000_016.0 => f64::NAN,
            (x, _) if x > 600_010.0 => 3.0,
            _ => 1.0,
        };
        let mut raster = Raster::from_function([10, 10], [600_001.0, 5_000_001.0], [2.0; 2], value);
        raster.reference.no_data = Some(-9999.0);
        raster.reference.pixel_is_area = true;
        colluvium_terrain::write_raster(&folder.join(name), &raster).unwrap();
    }

    fn case(folder: &Path) -> Case {
        let value = json!({
            "title": "t", "space": "3d", "gravity": [0, 0, -10],
            "domain": { "min": [600_000, 5_000_000, 0], "max": [600_040, 5_000_020, 9], "origin": [600_000, 5_000_000, 0] },
            "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m",
                "shape": { "kind": "box", "min": [600_001, 5_000_001, 5], "max": [600_002, 5_000_002, 6] } }],
            "obstacles": [{ "name": "ground", "wall": { "kind": "smooth" },
                "shape": { "kind": "plane", "point": [600_000, 5_000_000, 4], "normal": [0, 0, 1] } }],
            "stages": [{ "name": "s", "duration": 1 }]
        });
        Case::from_value(&value, folder).unwrap()
    }

    fn land_cover_region(
        folder: &Path,
        name: &str,
        value: Option<f64>,
    ) -> Result<PlanRegion, (String, String)> {
        let file = folder.join(name).display().to_string();
        let region = case(folder).plan_region(None, None, Some(&RasterCellSelection { file, value }));
        region.map_err(|(key, kind)| (key, kind.to_string()))
    }

    #[test]
    fn raster_cells_of_a_value_or_of_any_value_form_a_region() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["cover.asc", "cover.tif"] {
            write_land_cover(folder.path(), name);
            let class = land_cover_region(folder.path(), name, Some(3.0)).unwrap();
            let any = land_cover_region(folder.path(), name, None).unwrap();
            // Cells extend half a spacing beyond their centres.
            for (place, in_class, in_any) in [
                ([10.1, 15.9], true, true),
                ([9.9, 15.9], false, true),
                ([19.9, 0.1], true, true),
                ([20.1, 0.1], false, false),
                ([0.1, 0.1], false, true),
                ([15.0, 16.1], false, false),
                ([-0.1, 5.0], false, false),
            ] {
                assert_eq!(
                    (class.contains(&place), any.contains(&place)),
                    (in_class, in_any),
                    "{name} {place:?}"
                );
            }
        }
    }

    #[test]
    fn undeclared_no_data_marks_are_refused_in_regions_of_any_value() {
        let folder = tempfile::tempdir().unwrap();
        for mark in [-99999.0, -32768.0, 9999.0, 1e38, -3.4e38] {
            let value = |x: f64, _: f64| if x > 600_010.0 { 3.0 } else { mark };
            let raster = Raster::from_function([10, 10], [600_001.0, 5_000_001.0], [2.0; 2], value);
            let text = folder.path().join("cover.asc");
            colluvium_terrain::write_raster(&text, &raster).unwrap();
            // Without a line for the no-data value.
            let lines = std::fs::read_to_string(&text).unwrap();
            let silent: Vec<&str> = lines.lines().filter(|line| !line.starts_with("NODATA")).collect();
            std::fs::write(&text, silent.join("\n")).unwrap();
            let (key, problem) = land_cover_region(folder.path(), "cover.asc", None).unwrap_err();
            assert!(key == "raster.file" && problem.contains("NODATA_value"), "{mark}: {problem}");
            assert!(land_cover_region(folder.path(), "cover.asc", Some(3.0)).is_ok(), "{mark}");
        }
    }

    #[test]
    fn region_rasters_without_the_value_in_the_domain_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        write_land_cover(folder.path(), "cover.asc");
        let refused = |name: &str, value| land_cover_region(folder.path(), name, value).unwrap_err();
        let (key, problem) = refused("cover.asc", Some(4.0));
        assert!(
            key == "raster.value" && problem.ends_with("cover.asc has 4: the values are 1, 3"),
            "{problem}"
        );
        let (key, problem) = refused("none.asc", Some(3.0));
        assert!(key == "raster.file" && problem.contains("none.asc: cannot be read"), "{problem}");
        let write = |name: &str, x: f64, value: &dyn Fn(f64, f64) -> f64| {
            let raster = Raster::from_function([10, 10], [x, 5_000_001.0], [2.0; 2], value);
            colluvium_terrain::write_raster(&folder.path().join(name), &raster).unwrap();
        };
        write("apart.asc", 600_101.0, &|_, _| 1.0);
        let (key, problem) = refused("apart.asc", None);
        assert!(
            key == "raster.file" && problem.contains("reaches from 600100 to 600120 m along x"),
            "{problem}"
        );
        // The class exists, but west of the domain.
        write("west.asc", 599_991.0, &|x, _| if x < 600_000.0 { 7.0 } else { 8.0 });
        let (key, problem) = refused("west.asc", Some(7.0));
        assert!(key == "raster.value" && problem.ends_with("have 7 lies in the domain"), "{problem}");
        assert!(land_cover_region(folder.path(), "west.asc", Some(8.0)).is_ok());
    }

    #[test]
    fn the_fingerprint_and_the_laws_follow_the_raster_file_of_a_region() {
        let folder = tempfile::tempdir().unwrap();
        write_land_cover(folder.path(), "cover.asc");
        let mut value: Value = serde_json::from_str(&case(folder.path()).to_json()).unwrap();
        let region = json!({ "raster": { "file": "cover.asc", "value": 3 }, "wall": { "kind": "rough" } });
        value["obstacles"][0]["regions"] = json!([region]);
        value["methods"]["depth-sph"] =
            json!({ "spacing": 1, "regions": [{ "raster": { "file": "cover.asc", "value": 3 } }] });
        let read = Case::from_value(&value, folder.path()).unwrap();
        let whole = folder.path().join("cover.asc").display().to_string();
        assert_eq!(read.methods["depth-sph"]["regions"][0]["raster"]["file"], json!(whole));
        let laws = &read.placed_obstacles::<3>().unwrap()[0].laws;
        assert!(
            laws.law_at(&[15.0, 5.0, 4.0]).friction().is_infinite()
                && laws.law_at(&[5.0, 5.0, 4.0]).friction() == 0.0
        );
        let before = read.fingerprint();
        std::fs::write(
            folder.path().join("cover.asc"),
            std::fs::read_to_string(&whole).unwrap().replace('3', "5"),
        )
        .unwrap();
        assert_ne!(read.fingerprint(), before);
    }
}
