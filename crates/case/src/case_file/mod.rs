//! Case files: reading and checking of a [`Case`], its schema and fingerprint, and the origin of map coordinates.
//!
//! The folder knows all rules of a case, no method.

mod map_coordinates;

use std::collections::BTreeMap;
use std::path::Path;

use crate::files::terrain_files;
use crate::files::terrain_files::CoordinateReferenceSystem;
use schemars::Schema;
use serde_json::{Value, json};

use crate::bodies::terrain_layers;
use crate::description::{Body, ObstacleRegion};
use crate::files::checksum::FileChecksum;
use crate::files::json;
use crate::{Case, CaseError, CaseErrorKind, CaseErrors, validate};

impl Case {
    /// Reads a case from JSON text and checks it. Its file names are relative to the current folder.
    ///
    /// # Errors
    /// All errors, each with its JSON path.
    pub fn from_json(text: &str) -> Result<Self, CaseErrors> {
        Self::from_value(&json::parse(text).map_err(CaseErrors::from_error)?, Path::new(""))
    }

    /// Checks the rules of a case that its schema does not contain. Cases that are built in code need this check.
    ///
    /// # Errors
    /// All errors, each with its JSON path.
    pub fn validate(&self) -> Result<(), CaseErrors> {
        validate::validate(self)
    }

    /// Reads and checks a case file.
    ///
    /// # Errors
    /// When the file cannot be read; see [`Case::from_json`].
    pub fn from_file(path: &Path) -> Result<Self, CaseErrors> {
        Self::from_value(&json::value(path)?, path.parent().unwrap_or(Path::new("")))
    }

    /// Reads the copy of a case in a run folder, which was checked when the run began. Files that the case names are not read: they may no
    /// longer exist.
    ///
    /// # Errors
    /// When the file cannot be read, or is not a case.
    pub fn load_without_files(path: &Path) -> Result<Self, CaseErrors> {
        let mut case: Self = json::from_value(&json::value(path)?, "")?;
        case.default_gravity();
        case.subtract_origin()?;
        Ok(case)
    }

    /// Reads and checks a case from a JSON value; its file names are relative to `folder`.
    ///
    /// # Errors
    /// See [`Case::from_json`].
    pub fn from_value(value: &Value, folder: &Path) -> Result<Self, CaseErrors> {
        let mut case: Self = json::from_value(value, "")?;
        case.default_gravity();
        case.validate()?;
        case.subtract_origin()?;
        case.resolve_files(folder, value)?;
        case.with_layers()
    }

    /// Checks a case that a program describes, as its file would be: positions are relative to the origin of the domain, file names to
    /// `folder`.
    ///
    /// # Errors
    /// All errors, each with its JSON path.
    pub fn checked(mut self, folder: &Path) -> Result<Self, CaseErrors> {
        self.default_gravity();
        self.validate()?;
        let value = serde_json::to_value(&self).expect("plain data always serialises");
        self.resolve_files(folder, &value)?;
        self.with_layers()
    }

    /// Sets gravity to zero in a case without gravity.
    pub(crate) fn default_gravity(&mut self) {
        if self.gravity.is_empty() {
            self.gravity = vec![0.0; self.dimension()];
        }
    }

    /// Case with the data of the files of its layers, checked.
    fn with_layers(mut self) -> Result<Self, CaseErrors> {
        let layered = self.load_layers()?;
        validate::validate_layers(&self, &layered)?;
        Ok(self)
    }

    /// Makes file names relative to the case folder absolute, so that a copy of the case in a run folder refers to the same files. Rejects
    /// paths that are not files, as a device or a pipe, whose reading may never end, and map files in different coordinate reference
    /// systems. `value` is the case as written.
    fn resolve_files(&mut self, folder: &Path, value: &Value) -> Result<(), CaseErrors> {
        let mut systems: Vec<(String, CoordinateReferenceSystem)> = Vec::new();
        for file in self.files() {
            let path = folder.join(&*file);
            if std::fs::metadata(&path).is_ok_and(|about| !about.is_file() && !about.is_dir()) {
                let kind = CaseErrorKind::coded_file(path, "unreadable-file", "is not a regular file");
                return Err(CaseError::new(path_of_text(value, file).unwrap_or_default(), kind).into());
            }
            if let Some(system) = terrain_files::read_reference_system(&path) {
                if let Some((other, known)) = systems.iter().find(|(_, known)| known.differs(&system)) {
                    let problem = format!(
                        "is in another coordinate reference system ({system}) than {other} ({known}). \
                         Project one file to the system of the other"
                    );
                    let kind = CaseErrorKind::coded_file(path, "crs-different", problem);
                    return Err(CaseError::new(path_of_text(value, file).unwrap_or_default(), kind).into());
                }
                systems.push((file.clone(), system));
            }
            *file = std::path::absolute(&path).unwrap_or(path).display().to_string();
        }
        Ok(())
    }

    /// Names of the files of bodies, layers, obstacles and options of methods: `mesh.file`, `regions[].outline`,
    /// `regions[].raster.file`, `inflows[].hydrograph`, `erodible_depth_raster`, `specimen`.
    pub(crate) fn files(&mut self) -> impl Iterator<Item = &mut String> {
        let bodies = self.bodies.iter_mut().flat_map(|body| {
            let Body { shape, points, .. } = body;
            points.iter_mut().map(|points| &mut points.file).chain(terrain_layers::layer_files(shape))
        });
        let surfaces = self.obstacles.iter_mut().flat_map(|obstacle| {
            let regions = obstacle.regions.iter_mut();
            let places = regions.flat_map(|ObstacleRegion { outline, raster, .. }| {
                outline.iter_mut().chain(raster.iter_mut().map(|raster| &mut raster.file))
            });
            obstacle.shape.file_mut().into_iter().chain(places)
        });
        let mapped = self.output.rasters.iter_mut().filter_map(|rasters| rasters.mapped_outline.as_mut());
        bodies.chain(surfaces).chain(mapped).chain(self.methods.values_mut().flat_map(files_of_options))
    }

    /// Case as JSON text, with map coordinates.
    pub fn to_json(&self) -> String {
        let mut case = self.clone();
        case.add_origin();
        serde_json::to_string_pretty(&case).expect("plain data always serialises")
    }

    /// Fingerprint of the case: it differs between cases with different results. Of the files that it names the contents count, not their
    /// paths.
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint_with(&self.file_checksums())
    }

    /// Fingerprint of the case, with known checksums of the files that the case names.
    pub(crate) fn fingerprint_with(&self, marks: &BTreeMap<String, String>) -> u64 {
        let mut case = self.clone();
        case.schema = None;
        case.notes.clear();
        case.output.checkpoint = 1.0;
        for file in case.files() {
            if let Some(mark) = marks.get(file) {
                file.clone_from(mark);
            }
        }
        FileChecksum::of_bytes(serde_json::to_string(&case).expect("plain data always serialises").as_bytes())
            .fnv1a
    }

    /// Checksums of the files that the case names, by their paths, including their sidecar files.
    pub fn file_checksums(&self) -> BTreeMap<String, String> {
        self.clone().files().filter_map(|file| Some((file.clone(), file_checksum(file)?))).collect()
    }

    /// JSON Schema of a case file with the options of the given methods.
    pub fn schema(methods: &[(&str, Schema)]) -> Value {
        let mut schema = schemars::schema_for!(Self).to_value();
        let mut properties = serde_json::Map::new();
        for (name, options) in methods {
            let mut options = options.clone().to_value();
            let object = options.as_object_mut().expect("options are an object");
            object.remove("$schema");
            if let Some(Value::Object(defs)) = object.remove("$defs") {
                let all = schema["$defs"].as_object_mut().expect("a case has definitions");
                for (type_name, definition) in defs {
                    let before = all.insert(type_name.clone(), definition);
                    assert!(
                        before.is_none_or(|before| before == all[&type_name]),
                        "two types are called {type_name} in the schema of a case"
                    );
                }
            }
            properties.insert((*name).to_owned(), options);
        }
        schema["properties"]["methods"] = json!({
            "description": "Options per method.",
            "type": "object",
            "properties": properties,
            "additionalProperties": false,
        });
        schema
    }
}

/// File names in the options of a method.
fn files_of_options(options: &mut Value) -> Vec<&mut String> {
    let mut files = Vec::new();
    for (key, value) in options.as_object_mut().into_iter().flatten() {
        let named: Vec<&mut Value> = match key.as_str() {
            "mesh" => value.get_mut("file").into_iter().collect(),
            "erodible_depth_raster" | "specimen" => vec![value],
            "regions" => list_entries(value).flat_map(files_of_region).collect(),
            "inflows" => list_entries(value).filter_map(|part| part.get_mut("hydrograph")).collect(),
            _ => Vec::new(),
        };
        files.extend(named.into_iter().filter_map(|value| match value {
            Value::String(file) => Some(file),
            _ => None,
        }));
    }
    files
}

/// Entries of a list; empty for other values.
fn list_entries(value: &mut Value) -> impl Iterator<Item = &mut Value> {
    value.as_array_mut().into_iter().flatten()
}

/// File names in the definition of a region.
fn files_of_region(region: &mut Value) -> Vec<&mut Value> {
    let keys = region.as_object_mut().into_iter().flatten();
    keys.filter_map(|(key, value)| match key.as_str() {
        "outline" => Some(value),
        "raster" => value.get_mut("file"),
        _ => None,
    })
    .collect()
}

/// Path of the first occurrence of the text `wanted` in a JSON value.
fn path_of_text(value: &Value, wanted: &str) -> Option<String> {
    match value {
        Value::String(text) => (text == wanted).then(String::new),
        Value::Array(parts) => parts
            .iter()
            .enumerate()
            .find_map(|(number, part)| Some(format!("[{number}]{}", path_below(part, wanted)?))),
        Value::Object(parts) => {
            parts.iter().find_map(|(key, part)| Some(format!("{key}{}", path_below(part, wanted)?)))
        }
        _ => None,
    }
}

/// Path of a text below a key or an index, with the separating point.
fn path_below(value: &Value, wanted: &str) -> Option<String> {
    let place = path_of_text(value, wanted)?;
    Some(if place.is_empty() || place.starts_with('[') { place } else { format!(".{place}") })
}

/// Checksum of the contents of a file and its sidecar files; `None` where it cannot be read.
fn file_checksum(file: &str) -> Option<String> {
    let mut mark = format!("{:016x}", FileChecksum::of_bytes(&std::fs::read(file).ok()?).fnv1a);
    for beside in terrain_files::sidecar_files(Path::new(file)) {
        let ending = beside.extension().unwrap_or_default().to_string_lossy().into_owned();
        let content = std::fs::read(&beside).unwrap_or_default();
        mark += &format!(" {ending} {:016x}", FileChecksum::of_bytes(&content).fnv1a);
    }
    Some(mark)
}
