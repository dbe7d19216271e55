//! Reading and checking of a [`Case`], and its properties that all methods use.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use colluvium_terrain::CoordinateReferenceSystem;
use schemars::{JsonSchema, Schema};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::bodies::point_file::PointFile;
use crate::bodies::terrain_layers;
use crate::description::{Body, Boundary, Domain, Measure, ObstacleRegion, PrescribedMotion, Velocity};
use crate::files::json;
use crate::output::FileChecksum;
use crate::{Case, CaseError, CaseErrors, validate};

impl Case {
    /// Reads and checks a case.
    ///
    /// # Errors
    /// All errors, each with its JSON path.
    pub fn from_json(text: &str) -> Result<Self, CaseErrors> {
        let mut case: Self = json::read(text)?;
        case.default_gravity();
        case.validate()?;
        case.subtract_origin()?;
        case.with_layers()
    }

    /// Checks all rules beyond the schema: for cases that are built in code.
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
    pub fn load(path: &Path) -> Result<Self, CaseErrors> {
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

    /// Sets gravity to zero in a case without gravity.
    fn default_gravity(&mut self) {
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
                let problem = format!("{}: is not a regular file", path.display());
                return Err(CaseError::new(path_of_text(value, file).unwrap_or_default(), problem).into());
            }
            if let Some(system) = colluvium_terrain::read_reference_system(&path) {
                if let Some((other, known)) = systems.iter().find(|(_, known)| known.differs(&system)) {
                    let problem = format!(
                        "{}: is in another coordinate reference system ({system}) than {other} ({known}). \
                         Project one file to the system of the other",
                        path.display()
                    );
                    return Err(CaseError::new(path_of_text(value, file).unwrap_or_default(), problem).into());
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

    /// Fingerprint with given checksums of the files that the case names, which are not read again.
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
        fnv1a(serde_json::to_string(&case).expect("plain data always serialises").as_bytes())
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

    /// Number of coordinates of the space.
    pub fn dimension(&self) -> usize {
        self.space.dimension()
    }

    /// Approximate number of points `spacing` (m) apart in each body; for a file of points, their number.
    pub fn point_counts(&self, spacing: f64) -> Vec<f64> {
        let dimension = self.dimension();
        let filled = |body: &Body| body.shape.volume(dimension, false) / spacing.powi(dimension as i32);
        let count = |body: &Body| body.points.as_ref().map_or_else(|| filled(body), PointFile::count);
        self.bodies.iter().map(count).collect()
    }

    /// Gravity with three components (m/s²).
    pub fn gravity3(&self) -> [f64; 3] {
        spatial(&self.gravity)
    }

    /// Magnitude of gravity (m/s²).
    pub fn gravity_magnitude(&self) -> f64 {
        self.gravity.iter().map(|g| g * g).sum::<f64>().sqrt()
    }

    /// Sum of the durations of the stages (s).
    pub fn end_time(&self) -> f64 {
        self.stages.iter().map(|stage| stage.duration).sum()
    }

    /// Walls that are present in stage number `stage`, with their number in `boundaries`; beyond the last stage, those at its end.
    pub fn active_boundaries(&self, stage: usize) -> Vec<(usize, &Boundary)> {
        let removed = |boundary: &Boundary| {
            self.stages
                .iter()
                .take(stage.saturating_add(1))
                .any(|s| s.remove_boundaries.iter().any(|name| name == boundary.name()))
        };
        self.boundaries.iter().enumerate().filter(|(_, boundary)| !removed(boundary)).collect()
    }

    /// Duration of each boundary (s), in their order: until the stage that removes it.
    pub fn boundary_durations(&self) -> Vec<f64> {
        let mut left: HashMap<&str, f64> = HashMap::new();
        let mut time = 0.0;
        for stage in &self.stages {
            stage.remove_boundaries.iter().for_each(|name| {
                left.entry(name).or_insert(time);
            });
            time += stage.duration;
        }
        let stands = |boundary: &Boundary| left.get(boundary.name()).copied().unwrap_or(time);
        self.boundaries.iter().map(stands).collect()
    }

    /// Whether the bodies have no external actions in stage number `stage` except constant gravity along an axis that is not periodic.
    pub fn is_isolated(&self, stage: usize) -> bool {
        let moves =
            |velocity: &Option<Vec<f64>>| velocity.as_ref().is_some_and(|v| v.iter().any(|c| *c != 0.0));
        let falls_through = self.domain.periodic.iter().any(|axis| self.gravity[axis.number()] != 0.0);
        let stages = self.stages.iter().take(stage + 1);
        self.loads.is_empty()
            && self.patches.is_empty()
            && self.removal_shapes.is_empty()
            && !falls_through
            && !self.bodies.iter().any(|body| body.rigid || body.pore_fluid.is_some())
            && !self.boundaries.iter().any(|boundary| moves(&boundary.velocity))
            && !self.obstacles.iter().any(|obstacle| obstacle.motion.is_some())
            && stages.clone().all(|stage| stage.motions.is_empty())
            && self.stages.get(stage).is_some_and(|stage| stage.gravity_ramp == 0.0)
    }

    /// Whether the body of that name has been removed by the end of stage number `stage`.
    pub fn is_removed(&self, body: &str, stage: usize) -> bool {
        self.stages
            .iter()
            .take(stage.saturating_add(1))
            .any(|s| s.remove_bodies.iter().any(|name| name == body))
    }

    /// Whether the rigid body of that name moves freely in any stage.
    pub fn moves_freely(&self, body: &str) -> bool {
        self.stages.iter().filter_map(|stage| stage.motion_of(body)).any(PrescribedMotion::is_free)
    }

    /// Young's modulus of the material of that name (Pa), where it has one; wrapped materials are not considered.
    pub fn youngs_modulus(&self, material: &str) -> Option<f64> {
        serde_json::to_value(self.materials.get(material)?).ok()?.get("youngs_modulus")?.as_f64()
    }

    /// Options of method `name`, its defaults where the case has none.
    ///
    /// # Errors
    /// When they are invalid, with the path from the root of the case.
    pub fn method_options<T: DeserializeOwned + JsonSchema>(&self, name: &str) -> Result<T, CaseError> {
        let empty = json!({});
        let value = self.methods.get(name).unwrap_or(&empty);
        json::from_value(value, &format!("methods.{name}")).map_err(|errors| errors.first().clone())
    }

    /// Whether dissipated energy is measured.
    pub fn measures_dissipation(&self) -> bool {
        self.measures.values().any(|measure| matches!(measure, Measure::Dissipation {}))
    }
}

/// File names in the options of a method.
fn files_of_options(options: &mut Value) -> Vec<&mut String> {
    let mut files = Vec::new();
    for (key, value) in options.as_object_mut().into_iter().flatten() {
        let named: Vec<&mut Value> = match key.as_str() {
            "mesh" => value.get_mut("file").into_iter().collect(),
            "erodible_depth_raster" | "specimen" => vec![value],
            "regions" => parts_of(value).flat_map(files_of_region).collect(),
            "inflows" => parts_of(value).filter_map(|part| part.get_mut("hydrograph")).collect(),
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
fn parts_of(value: &mut Value) -> impl Iterator<Item = &mut Value> {
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
            .find_map(|(number, part)| Some(format!("[{number}]{}", path_within(part, wanted)?))),
        Value::Object(parts) => {
            parts.iter().find_map(|(key, part)| Some(format!("{key}{}", path_within(part, wanted)?)))
        }
        _ => None,
    }
}

/// Path of a text below a key or an index, with the separating point.
fn path_within(value: &Value, wanted: &str) -> Option<String> {
    let place = path_of_text(value, wanted)?;
    Some(if place.is_empty() || place.starts_with('[') { place } else { format!(".{place}") })
}

/// Checksum of the contents of a file and its sidecar files; `None` where it cannot be read.
fn file_checksum(file: &str) -> Option<String> {
    let mut mark = format!("{:016x}", fnv1a(&std::fs::read(file).ok()?));
    for beside in colluvium_terrain::sidecar_files(Path::new(file)) {
        let ending = beside.extension().unwrap_or_default().to_string_lossy().into_owned();
        let content = std::fs::read(&beside).unwrap_or_default();
        mark += &format!(" {ending} {:016x}", fnv1a(&content));
    }
    Some(mark)
}

/// FNV-1a hash of bytes.
pub(crate) fn fnv1a(bytes: &[u8]) -> u64 {
    FileChecksum::of_bytes(bytes).fnv1a
}

/// Vector in space of one to three components; missing components are zero.
#[inline]
pub fn spatial(vector: &[f64]) -> [f64; 3] {
    std::array::from_fn(|c| vector.get(c).copied().unwrap_or(0.0))
}

/// First mode shape of a cantilever at the share `x` of its length; the root is that of `cos kL cosh kL = -1`.
fn cantilever_mode(x: f64) -> f64 {
    const ROOT: f64 = 1.875_104_068_711_961_3;
    let (k, kx) = (ROOT, ROOT * x);
    (k.cos() + k.cosh()) * (kx.cosh() - kx.cos()) + (k.sin() - k.sinh()) * (kx.sinh() - kx.sin())
}

impl Velocity {
    /// Velocity at `x` (m/s).
    #[inline]
    pub fn at(&self, x: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Rest => [0.0; 3],
            Self::Uniform { value } => spatial(value),
            Self::Linear { value, origin, gradient } => {
                let (base, from) = (spatial(value), spatial(origin));
                std::array::from_fn(|i| {
                    let row = gradient.get(i).map_or([0.0; 3], |row| spatial(row));
                    base[i] + (0..3).map(|j| row[j] * (x[j] - from[j])).sum::<f64>()
                })
            }
            Self::Sine { amplitude, wave_vector, phase } => {
                let k = spatial(wave_vector);
                let angle = k[0] * x[0] + k[1] * x[1] + k[2] * x[2] + phase.to_radians();
                spatial(amplitude).map(|a| a * angle.sin())
            }
            Self::Formula { value } => {
                std::array::from_fn(|c| value.get(c).map_or(0.0, |formula| formula.at(x)))
            }
            Self::Bending { along, across, clamp, length, tip } => {
                let place = ((x[*along] - clamp) / length).max(0.0);
                let value = tip * cantilever_mode(place) / cantilever_mode(1.0);
                std::array::from_fn(|c| if c == *across { value } else { 0.0 })
            }
        }
    }
}

impl Boundary {
    /// Name, or that of its side.
    pub fn name(&self) -> &str {
        self.name.as_deref().unwrap_or(self.side.name())
    }

    /// Coordinate of the wall's face (m).
    pub fn position(&self, domain: &Domain) -> f64 {
        let axis = self.side.axis();
        self.position.unwrap_or(if self.side.is_max() { domain.max[axis] } else { domain.min[axis] })
    }
}
