//! Terrain layers of a case, built from their files.

use std::path::Path;

use colluvium_points::{
    LayerThickness, Outline, OutlineFeature, Raster, Ring, Shape, TerrainLayer, ThicknessAttribute,
    ThicknessData,
};

use crate::bodies::arc_layer;
use crate::files::decimal_sum::relative_to_origin;
use crate::files::terrain_files;
use crate::{Case, CaseError, CaseErrorKind};
use colluvium_constitutive::Warning;

/// File names in the layers of a shape.
pub fn layer_files(shape: &mut Shape) -> Vec<&mut String> {
    let mut files = Vec::new();
    for (_, layer) in shape.layers_mut(String::new()) {
        let Shape::Layer { outline, thickness, .. } = layer else { continue };
        files.extend(outline);
        if let LayerThickness::Raster(file) = thickness {
            files.push(file);
        }
    }
    files
}

impl Case {
    /// Reads the files of layers; returns the numbers of the bodies with layers.
    pub(crate) fn load_layers(&mut self) -> Result<Vec<usize>, CaseError> {
        self.reject_misplaced_layers()?;
        let mut layered = Vec::new();
        for number in 0..self.bodies.len() {
            let mut shape = self.bodies[number].shape.clone();
            let alone = matches!(shape, Shape::Layer { .. } | Shape::ArcLayer { .. });
            for (path, layer) in shape.layers_mut(format!("bodies[{number}].shape")) {
                if layer.follows_terrain() && !alone {
                    let problem = "rows along the terrain need a layer that is the whole shape of its body";
                    return Err(CaseError::new(format!("{path}.rows"), problem));
                }
                self.load_layer(layer, &path)?;
                layered.push(number);
            }
            self.bodies[number].shape = shape;
        }
        layered.dedup();
        Ok(layered)
    }

    /// Outline in a file (GeoJSON or shapefile), relative to `domain.origin`.
    ///
    /// # Errors
    /// When the file cannot be read or contains no outline.
    pub fn outline(&self, file: &str) -> Result<Outline, CaseErrorKind> {
        let read = terrain_files::read_outlines(Path::new(file))?;
        self.relative_outline(&read).map_err(|problem| CaseErrorKind::file(file, problem))
    }

    /// Outline in map coordinates, relative to `domain.origin`.
    fn relative_outline(&self, read: &Outline) -> Result<Outline, String> {
        let origin = self.origin();
        let ring = |ring: &Ring| ring.iter().map(|x| shift(*x, &origin)).collect();
        Outline::new(read.polygons().iter().map(|rings| rings.iter().map(ring).collect()).collect())
    }

    /// Features of the outline in a file, each with the thickness (m) that the attribute gives it.
    fn features_of(&self, file: &str, attribute: &str) -> Result<Vec<OutlineFeature>, CaseErrorKind> {
        let read = terrain_files::read_features(Path::new(file), attribute)?;
        let shifted = |feature: &OutlineFeature| {
            Ok(OutlineFeature { outline: self.relative_outline(&feature.outline)?, ..feature.clone() })
        };
        let shifted = read.iter().map(shifted).collect::<Result<_, String>>();
        shifted.map_err(|problem| CaseErrorKind::file(file, problem))
    }

    /// Warns of overlapping features of an outline with different thicknesses.
    pub(crate) fn warn_of_overlaps(&self, warnings: &mut Vec<Warning>) {
        for (number, body) in self.bodies.iter().enumerate() {
            for (path, layer) in body.shape.clone().layers_mut(format!("bodies[{number}].shape")) {
                let Shape::Layer { outline: Some(file), laid, .. } = layer else { continue };
                let overlaps = laid.layer().map(TerrainLayer::overlaps).unwrap_or_default();
                let Some(first) = overlaps.first() else { continue };
                let [below, above] = first.features;
                let others = match overlaps.len() - 1 {
                    0 => String::new(),
                    1 => " (so does another pair of features)".to_owned(),
                    more => format!(" (so do {more} other pairs of features)"),
                };
                warnings.push(Warning::new("overlapping-features", format!(
                    "{path}.outline: {file}: features {below} and {above} overlap in {} m²{others}. There \
                     the thickness of the later feature is used, here that of feature {above}. To add the \
                     thicknesses, or to use the earlier feature, cut one out of the other",
                    (1e6 * first.area).round() / 1e6
                )));
            }
        }
    }

    /// Raster of thicknesses or depths in plan from a file (ESRI ASCII grid or GeoTIFF), relative to `domain.origin`, with unchanged
    /// values.
    ///
    /// # Errors
    /// When the file cannot be read, and when numbers in it seem to stand for no data without a declared no-data value.
    pub fn plan_raster(&self, file: &str) -> Result<Raster, CaseErrorKind> {
        let raster = self.raster_of_classes(file)?;
        match raster.undeclared_no_data_warning() {
            Some(doubt) => Err(CaseErrorKind::file(file, doubt)),
            None => Ok(raster),
        }
    }

    /// Raster in plan from a file, relative to `domain.origin`, with any values.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub(crate) fn raster_of_classes(&self, file: &str) -> Result<Raster, CaseErrorKind> {
        let raster = terrain_files::read_raster(Path::new(file))?;
        Ok(Raster { origin: shift(raster.origin, &self.origin()), ..raster })
    }

    /// Reports an error where a terrain layer is the shape of anything other than a body.
    fn reject_misplaced_layers(&mut self) -> Result<(), CaseError> {
        let patches = self.patches.iter_mut().enumerate();
        let patches = patches.map(|(number, patch)| (format!("patches[{number}].region"), &mut patch.region));
        let cuts = self.removal_shapes.iter_mut().enumerate();
        let cuts = cuts.map(|(number, cut)| (format!("removal_shapes[{number}].shape"), &mut cut.shape));
        let stages = self.stages.iter_mut().enumerate().flat_map(|(stage, of)| {
            let regions = of.excavate.iter_mut().enumerate();
            regions.map(move |(number, region)| (format!("stages[{stage}].excavate[{number}]"), region))
        });
        for (path, region) in patches.chain(cuts).chain(stages) {
            if let Some((path, _)) = region.layers_mut(path).into_iter().next() {
                return Err(CaseError::new(path, "a layer can only be the shape of a body"));
            }
        }
        Ok(())
    }

    /// Builds the outline of a layer along the line of an obstacle; `path` is the path of the layer.
    fn load_arc_layer(&self, layer: &mut Shape, path: &str) -> Result<(), CaseError> {
        let Shape::ArcLayer { on, start, end, from, to, outline, .. } = layer else { return Ok(()) };
        let obstacle = self.obstacles.iter().find(|obstacle| obstacle.name == *on).ok_or_else(|| {
            CaseError::new(format!("{path}.on"), CaseErrorKind::other_name(on, "the name of an obstacle"))
        })?;
        *outline = arc_layer::outline(&obstacle.shape, [*start, *end], [*from, *to])
            .map_err(|(key, problem)| CaseError::new(format!("{path}.{key}"), problem))?
            .into();
        Ok(())
    }

    /// Reads the files of one layer; `path` is the path of the layer.
    fn load_layer(&self, layer: &mut Shape, path: &str) -> Result<(), CaseError> {
        if let Shape::ArcLayer { .. } = layer {
            return self.load_arc_layer(layer, path);
        }
        let Shape::Layer { on, outline, thickness, measured, laid, .. } = layer else { return Ok(()) };
        let wrong = |key: &str, kind: CaseErrorKind| CaseError::new(format!("{path}.{key}"), kind);
        let number = self.obstacles.iter().position(|obstacle| obstacle.name == *on);
        let number =
            number.ok_or_else(|| wrong("on", CaseErrorKind::other_name(on, "the name of an obstacle")))?;
        let ground = self.heights(number)?.ok_or_else(|| {
            wrong(
                "on",
                CaseErrorKind::coded("needs-other-key", format!(
                    "the shape of the obstacle {on:?} is not a raster, but a layer needs a raster below it"
                )),
            )
        })?;
        let origin = self.origin();
        let depths = match (&*thickness, &*outline) {
            (LayerThickness::Uniform(depth), _) => ThicknessData::Uniform(*depth),
            (LayerThickness::Raster(file), _) => {
                ThicknessData::Raster(self.plan_raster(file).map_err(|problem| wrong("thickness", problem))?)
            }
            (LayerThickness::Attribute(ThicknessAttribute { attribute }), Some(outline)) => {
                ThicknessData::Features(
                    self.features_of(outline, attribute).map_err(|problem| wrong("thickness", problem))?,
                )
            }
            (LayerThickness::Attribute(_), None) => ThicknessData::Features(Vec::new()),
        };
        let area = match (&*outline, &depths) {
            (Some(file), _) => self.outline(file).map_err(|problem| wrong("outline", problem))?,
            (None, ThicknessData::Raster(raster)) => TerrainLayer::outline_of_thickness(raster, &ground)
                .map_err(|problem| wrong("thickness", problem.into()))?,
            (None, _) => {
                let problem = "is missing: only with a raster of thickness the outline can be left out";
                return Err(wrong("outline", CaseErrorKind::coded("needs-other-key", problem)));
            }
        };
        let made = TerrainLayer::new(ground, area, depths, *measured, [origin[0], origin[1]]);
        *laid = made
            .map_err(|error| {
                let file = match (error.key, &*thickness) {
                    ("outline", _) | ("thickness", LayerThickness::Attribute(_)) => outline.as_ref(),
                    ("thickness", LayerThickness::Raster(file)) => Some(file),
                    _ => None,
                };
                let problem = error.problem;
                wrong(
                    error.key,
                    match file {
                        Some(file) => CaseErrorKind::file(file, problem),
                        None => problem.into(),
                    },
                )
            })?
            .into();
        Ok(())
    }
}

/// Position in plan relative to the origin of the domain (m).
fn shift(x: [f64; 2], origin: &[f64; 3]) -> [f64; 2] {
    std::array::from_fn(|c| relative_to_origin(x[c], origin[c]))
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    /// Case with a layer of 2 m on a slope, 10 m by 20 m, at map coordinates.
    fn layer_case() -> Value {
        json!({
            "title": "layer", "space": "3d", "gravity": [0, 0, -9.81],
            "domain": { "min": [600000, 5000000, 0], "max": [600040, 5000040, 100], "origin": [600000, 5000000, 0] },
            "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [{ "name": "release", "material": "m", "shape": {
                "kind": "layer", "on": "slope", "outline": "release.geojson", "thickness": 2 } }],
            "obstacles": [{ "name": "slope", "shape": { "kind": "raster", "file": "slope.asc" }, "wall": { "kind": "rough" } }],
            "stages": [{ "name": "s", "duration": 1 }]
        })
    }

    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let raster =
            Raster::from_function([21, 21], [600_000.0, 5e6], [2.0; 2], |x, _| 50.0 + 0.75 * (x - 600_000.0));
        colluvium_terrain::write_raster(&folder.path().join("slope.asc"), &raster).unwrap();
        outline(folder.path(), [[10.0, 10.0], [20.0, 10.0], [20.0, 30.0], [10.0, 30.0]]);
        folder
    }

    fn outline(folder: &Path, corners: [[f64; 2]; 4]) {
        let mut ring: Vec<[f64; 2]> = corners.map(|[x, y]| [600_000.0 + x, 5e6 + y]).to_vec();
        ring.push(ring[0]);
        let text = json!({ "type": "Polygon", "coordinates": [ring] }).to_string();
        std::fs::write(folder.join("release.geojson"), text).unwrap();
    }

    #[test]
    fn a_layer_on_a_map_is_read_with_its_files() {
        let folder = folder();
        let mut value = layer_case();
        let case = Case::from_value(&value, folder.path()).unwrap();
        let volume = |case: &Case| case.bodies[0].shape.measure(3).unwrap();
        assert!((volume(&case) - 400.0).abs() < 1e-9);
        assert!(case.bodies[0].shape.contains(&[15.0, 20.0, 50.0 + 11.25 + 1.9]));
        assert!(
            (volume(&Case::from_json(&case.to_json()).unwrap()) - 400.0).abs() < 1e-9,
            "as a run keeps it"
        );
        value["bodies"][0]["shape"]["measured"] = json!("normal");
        let normal = Case::from_value(&value, folder.path()).unwrap();
        assert!((volume(&normal) - 500.0).abs() < 1e-9);
        assert_ne!(case.fingerprint(), normal.fingerprint());
        let before = normal.fingerprint();
        outline(folder.path(), [[10.0, 10.0], [21.0, 10.0], [21.0, 30.0], [10.0, 30.0]]);
        let outlined = Case::from_value(&value, folder.path()).unwrap();
        assert_ne!(before, outlined.fingerprint());
        // A sidecar file of the raster.
        let (before, marks) = (outlined.fingerprint(), outlined.file_checksums());
        std::fs::write(folder.path().join("slope.asc.aux.xml"), "<PAMDataset></PAMDataset>").unwrap();
        assert_ne!(before, outlined.fingerprint());
        let changed: Vec<String> = outlined
            .file_checksums()
            .into_iter()
            .filter(|(path, mark)| marks[path] != *mark)
            .map(|(path, _)| path)
            .collect();
        assert!(matches!(&changed[..], [path] if path.ends_with("slope.asc")), "{changed:?}");
    }

    /// A deposit of 1.5 m at 15 by 15 nodes of the raster, without data elsewhere.
    #[test]
    fn a_layer_without_an_outline_lies_where_its_raster_is_above_zero() {
        let folder = folder();
        let deposit = |low: f64, high: f64, dry: f64| {
            let is_in = move |x: f64| (low..=high).contains(&x);
            let raster = Raster::from_function([21, 21], [600_000.0, 5e6], [2.0; 2], |x, y| {
                if is_in(x - 6e5) && is_in(y - 5e6) { 1.5 } else { dry }
            });
            colluvium_terrain::write_raster(&folder.path().join("deposit.asc"), &raster).unwrap();
        };
        let mut value = layer_case();
        value["bodies"][0]["shape"].as_object_mut().unwrap().remove("outline");
        value["bodies"][0]["shape"]["thickness"] = json!("deposit.asc");
        let read = || Case::from_value(&value, folder.path());
        deposit(6.0, 34.0, f64::NAN);
        let case = read().unwrap();
        let volume = case.bodies[0].shape.measure(3).unwrap();
        assert!((volume - 225.0 * 1.5 * 4.0).abs() < 1e-6, "the nodes' {volume} m³");
        assert!(case.bodies[0].shape.contains(&[15.0, 20.0, 50.0 + 11.25 + 1.4]));
        assert!(!case.bodies[0].shape.contains(&[3.0, 20.0, 50.0 + 2.25 + 0.1]));
        assert_eq!(Case::from_json(&case.to_json()).unwrap().fingerprint(), case.fingerprint());
        deposit(50.0, 60.0, 0.0);
        let refused = read().unwrap_err().to_string();
        assert!(refused.starts_with("bodies[0].shape.thickness: is above zero nowhere"), "{refused}");
        value["bodies"][0]["shape"]["thickness"] = json!(2);
        let refused = Case::from_value(&value, folder.path()).unwrap_err().to_string();
        assert!(refused.starts_with("bodies[0].shape.outline: is missing"), "{refused}");
    }

    #[test]
    fn each_feature_of_an_outline_is_as_thick_as_its_attribute_says() {
        let folder = folder();
        let feature = |low: f64, depth: Value| {
            let at = |x: f64, y: f64| [600_000.0 + x, 5e6 + y];
            let ring =
                [at(low, 10.0), at(low + 10.0, 10.0), at(low + 10.0, 30.0), at(low, 30.0), at(low, 10.0)];
            json!({ "type": "Feature", "properties": { "depth": depth },
                    "geometry": { "type": "Polygon", "coordinates": [ring] } })
        };
        let write = |second: Value| {
            let all = [feature(5.0, json!(1.0)), feature(20.0, second)];
            let text = json!({ "type": "FeatureCollection", "features": all }).to_string();
            std::fs::write(folder.path().join("release.geojson"), text).unwrap();
        };
        let mut value = layer_case();
        value["bodies"][0]["shape"]["thickness"] = json!({ "attribute": "depth" });
        let read = || Case::from_value(&value, folder.path());
        write(json!(3.0));
        let case = read().unwrap();
        assert!((case.bodies[0].shape.measure(3).unwrap() - 200.0 * (1.0 + 3.0)).abs() < 1e-6);
        assert!(case.bodies[0].shape.contains(&[25.0, 20.0, 50.0 + 18.75 + 2.9]));
        assert!(!case.bodies[0].shape.contains(&[10.0, 20.0, 50.0 + 7.5 + 1.1]));
        assert_eq!(Case::from_json(&case.to_json()).unwrap().fingerprint(), case.fingerprint());
        // The second feature over the first, up to 5 m.
        let over = [feature(5.0, json!(1.0)), feature(10.0, json!(3.0))];
        let text = json!({ "type": "FeatureCollection", "features": over }).to_string();
        std::fs::write(folder.path().join("release.geojson"), text).unwrap();
        let over = read().unwrap();
        assert!((over.bodies[0].shape.measure(3).unwrap() / (100.0 * (1.0 + 2.0 * 3.0)) - 1.0).abs() < 0.02);
        let overlap_warnings: Vec<Warning> =
            over.warnings().into_iter().filter(|w| w.text.contains("overlap")).collect();
        assert!(
            overlap_warnings.len() == 1
                && overlap_warnings[0].text.starts_with("bodies[0].shape.outline: ")
                && overlap_warnings[0].text.contains(
                    "release.geojson: features 1 and 2 overlap in 100 m². There the thickness of the later \
                     feature is used, here that of feature 2"
                ),
            "{overlap_warnings:?}"
        );
        write(json!("deep"));
        let refused = read().unwrap_err().to_string();
        assert!(refused.starts_with("bodies[0].shape.thickness: /"), "{refused}");
        assert!(
            refused.contains("release.geojson: feature 2 has no number in the attribute \"depth\""),
            "{refused}"
        );
        write(json!(-1));
        let refused = read().unwrap_err().to_string();
        assert!(refused.contains("release.geojson: -1 m is negative at"), "{refused}");
    }

    #[test]
    fn thickness_values_that_resemble_no_data_marks_are_refused() {
        let folder = folder();
        let mut value = layer_case();
        value["bodies"][0]["shape"]["thickness"] = json!("thick.asc");
        for mark in ["-99999", "-32768", "9999", "1e38", "3.4028235e38"] {
            let row = format!("{}{mark} {mark}\n", "2 ".repeat(19));
            let text = format!(
                "ncols 21\nnrows 21\nxllcenter 600000\nyllcenter 5000000\ncellsize 2\n{}",
                row.repeat(21)
            );
            std::fs::write(folder.path().join("thick.asc"), &text).unwrap();
            let refused = Case::from_value(&value, folder.path()).unwrap_err().to_string();
            let start = refused.starts_with("bodies[0].shape.thickness: /");
            assert!(start && refused.contains("thick.asc: 42 of its values are"), "{mark}: {refused}");
            assert!(refused.contains("NODATA_value"), "{mark}: {refused}");
            let named = text.replace("cellsize 2\n", &format!("cellsize 2\nNODATA_value {mark}\n"));
            std::fs::write(folder.path().join("thick.asc"), named).unwrap();
            Case::from_value(&value, folder.path()).unwrap();
        }
    }

    #[test]
    fn adjoining_features_are_one_layer_and_files_in_other_systems_are_refused() {
        let folder = folder();
        let feature = |x: [f64; 2]| {
            let at = |x: f64, y: f64| [600_000.0 + x, 5e6 + y];
            let ring = [at(x[0], 10.0), at(x[1], 10.0), at(x[1], 30.0), at(x[0], 30.0), at(x[0], 10.0)];
            json!({ "type": "Feature", "properties": {}, "geometry": { "type": "Polygon", "coordinates": [ring] } })
        };
        let write = |crs: &str| {
            let text = json!({ "type": "FeatureCollection", "features": [feature([10.0, 14.0]), feature([14.0, 20.0])],
                               "crs": { "type": "name", "properties": { "name": crs } } });
            std::fs::write(folder.path().join("release.geojson"), text.to_string()).unwrap();
        };
        let mut raster = colluvium_terrain::read_raster(&folder.path().join("slope.asc")).unwrap();
        raster.reference.epsg = Some(26910);
        colluvium_terrain::write_raster(&folder.path().join("slope.tif"), &raster).unwrap();
        let mut value = layer_case();
        value["obstacles"][0]["shape"]["file"] = json!("slope.tif");
        let read = || Case::from_value(&value, folder.path());
        write("urn:ogc:def:crs:EPSG::26910");
        assert!((read().unwrap().bodies[0].shape.measure(3).unwrap() - 400.0).abs() < 1e-9);
        write("EPSG:31254");
        let refused = read().unwrap_err().to_string();
        assert!(refused.starts_with("obstacles[0].shape.file: /"), "{refused}");
        for name in
            ["(EPSG:26910, NAD83 / UTM zone 10N)", "release.geojson (EPSG:31254, MGI / Austria GK West)"]
        {
            assert!(refused.contains(name), "{refused}");
        }
        write("grid of the site");
        let unknown = |warning: &Warning| {
            warning.text.contains("grid of the site") && warning.text.contains("cannot decide")
        };
        assert!(read().unwrap().warnings().iter().any(unknown));
        write("urn:ogc:def:crs:OGC:1.3:CRS84");
        assert!(read().unwrap_err().to_string().contains("degrees"));
    }

    #[test]
    fn errors_in_layers_name_the_json_path_and_the_file() {
        let folder = folder();
        let refused = |change: &dyn Fn(&mut Value)| {
            let mut value = layer_case();
            change(&mut value);
            Case::from_value(&value, folder.path()).unwrap_err().to_string()
        };
        let shape =
            |key: &'static str, to: Value| move |v: &mut Value| v["bodies"][0]["shape"][key] = to.clone();
        let starts = |text: String, start: &str| assert!(text.starts_with(start), "{text}");
        starts(refused(&shape("on", json!("slop"))), "bodies[0].shape.on: \"slop\" is not the name");
        starts(refused(&shape("outline", json!("none.geojson"))), "bodies[0].shape.outline: /");
        starts(refused(&shape("thickness", json!("none.asc"))), "bodies[0].shape.thickness: /");
        starts(refused(&shape("thickness", json!(-1))), "bodies[0].shape.thickness: -1 must be");
        starts(refused(&shape("thickness", json!([1]))), "bodies[0].shape.thickness: ");
        starts(refused(&|v| v["domain"]["max"][2] = json!(66)), "bodies[0].shape: reaches from 57");
        let region = layer_case()["bodies"][0]["shape"].clone();
        starts(
            refused(&|v| v["stages"][0]["excavate"] = json!([region])),
            "stages[0].excavate[0]: a layer can only be",
        );
        let other = json!({ "name": "other", "material": "m",
            "shape": { "kind": "box", "min": [600012, 5000012, 55], "max": [600014, 5000020, 70] } });
        starts(
            refused(&|v| v["bodies"].as_array_mut().unwrap().push(other.clone())),
            "bodies[1].shape: overlaps",
        );
        outline(folder.path(), [[10.0, 10.0], [60.0, 10.0], [60.0, 30.0], [10.0, 30.0]]);
        let text = refused(&|_| {});
        starts(text.clone(), "bodies[0].shape.outline: /");
        assert!(text.contains("release.geojson: reaches from [600010.0, 5000010.0]"), "{text}");
        outline(folder.path(), [[10.0, 10.0], [20.0, 30.0], [20.0, 10.0], [10.0, 30.0]]);
        let text = refused(&|_| {});
        assert!(text.contains("release.geojson: ring 1: ") && text.contains("cross"), "{text}");
    }
}
