//! Kinds of files that commands take.

use std::path::Path;

use crate::case::files::json;
use crate::case::{CaseError, CaseErrorKind};
use crate::constitutive::driver::incremental;
use serde_json::Value;

use crate::cli::CommandError;

/// Kind of a file that a user names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A case.
    Case,
    /// A test of a single material point.
    ElementTest,
    /// A sweep over parameters of a case.
    Sweep,
    /// A fit of a material to tests.
    Fit,
}

impl FileKind {
    /// Kind of a JSON value, by keys that only one kind has; `None` where these keys are missing or ambiguous.
    fn from_keys(value: &Value) -> Option<Self> {
        let has = |key: &str| value.get(key).is_some();
        let case = ["space", "domain", "bodies", "materials", "methods"].into_iter().any(has);
        let fit = has("tests");
        let test = (has("material") || has("initial_stress")) && !fit;
        let sweep = has("parameters") && has("case");
        match [case, test, sweep, fit] {
            [true, false, false, false] => Some(Self::Case),
            [false, true, false, false] => Some(Self::ElementTest),
            [false, false, true, false] => Some(Self::Sweep),
            [false, false, false, true] => Some(Self::Fit),
            _ => None,
        }
    }

    /// Name of the kind, and the command that reads such files.
    fn name_and_command(self) -> (&'static str, &'static str) {
        match self {
            Self::Case => ("a case", "colluvium check"),
            Self::ElementTest => ("an element test", "colluvium element-test"),
            Self::Sweep => ("a sweep", "colluvium sweep"),
            Self::Fit => ("a fit", "colluvium fit"),
        }
    }
}

/// Hint for files of terrain and tables, which a case names.
const REFERENCED_BY_CASE: &str = "name it in a case file; `colluvium new debris-flow` writes an example";

/// Kind of a file from its extension, and a hint how to use it.
fn from_extension(file: &Path) -> Option<(&'static str, &'static str)> {
    let ending = file.extension()?.to_string_lossy().to_lowercase();
    Some(match ending.as_str() {
        "asc" | "grd" | "tif" | "tiff" => ("a raster", REFERENCED_BY_CASE),
        "shp" | "geojson" | "gpkg" | "kml" => ("an outline", REFERENCED_BY_CASE),
        "csv" => ("a table", REFERENCED_BY_CASE),
        "stl" | "obj" | "msh" => ("a mesh", REFERENCED_BY_CASE),
        "vtu" | "pvd" => ("a frame of results", "give the folder of the run to `colluvium plot`"),
        _ => return None,
    })
}

/// Reports an error for a file that is clearly of another kind than the command reads, and names the command for it. An unreadable file is
/// refused later, where it is read.
pub fn require_kind(file: &Path, wanted: FileKind) -> Result<(), CommandError> {
    let wrong = |is: &str, cure: String| {
        let problem = format!("is {is}, and not {}: {cure}", wanted.name_and_command().0);
        Err(CaseError::new(file.display().to_string(), CaseErrorKind::coded("wrong-file-kind", problem))
            .into())
    };
    if file.is_dir() {
        let run = file.join("summary.json").exists();
        let test = file.join(incremental::TEST).exists() && wanted != FileKind::ElementTest;
        let name = file.display();
        return match (run, test) {
            (true, _) => wrong("the folder of a run", format!("`colluvium report {name}` writes its report")),
            (false, true) => wrong(
                "the folder of an incrementalDriver",
                format!("`colluvium element-test {name} --material FILE` runs it"),
            ),
            (false, false) if file.join("sweep.json").exists() => {
                let tables = format!(
                    "its results are in {name}/runs.csv, and `colluvium sweep SWEEP --out {name} --resume` continues it"
                );
                wrong("the folder of a sweep", tables)
            }
            (false, false) if file.join("fit.json").exists() && file.join("material.json").exists() => {
                wrong("the folder of a fit", format!("its results are in {name}/fit.csv"))
            }
            (false, false) if wanted != FileKind::ElementTest => {
                wrong("a folder", "give the path of the file".to_owned())
            }
            (false, false) => Ok(()),
        };
    }
    if let Some((is, cure)) = from_extension(file).filter(|_| file.is_file()) {
        return wrong(is, cure.to_owned());
    }
    let Ok(value) = json::value(file) else { return Ok(()) };
    let has = |key: &&str| value.get(*key).is_some();
    let geometry = ["features", "coordinates", "geometries", "geometry"];
    if value.get("type").is_some_and(Value::is_string) && geometry.iter().any(has) {
        return wrong("an outline", REFERENCED_BY_CASE.to_owned());
    }
    if ["fingerprint", "status", "method"].iter().all(has) {
        return wrong("the summary of a run", "give the folder of the run to `colluvium report`".to_owned());
    }
    match FileKind::from_keys(&value).filter(|found| *found != wanted) {
        Some(found) => {
            let (is, command) = found.name_and_command();
            wrong(is, format!("use `{command} {}`", file.display()))
        }
        None => Ok(()),
    }
}
