//! The command line, run as a user runs it.

mod checks;
mod element_tests;
mod fits;
mod outputs;
mod runs;

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

/// Small column that collapses.
pub fn column() -> Value {
    json!({
        "title": "small column", "space": "plane-strain",
        "domain": { "min": [0, 0], "max": [0.4, 0.12] }, "gravity": [0, -9.81],
        "materials": { "sand": {
            "model": "mohr-coulomb", "density": 1925, "youngs_modulus": 1e6, "poissons_ratio": 0.23, "friction_angle": 31
        } },
        "bodies": [{ "name": "column", "material": "sand", "shape": { "kind": "box", "min": [0, 0], "max": [0.1, 0.1] } }],
        "boundaries": [
            { "side": "x-min", "wall": { "kind": "smooth" } }, { "side": "x-max", "wall": { "kind": "smooth" } },
            { "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": 0.6 } }
        ],
        "stages": [
            { "name": "hold", "duration": 0.02, "damping": 0.5 },
            { "name": "go", "duration": 0.1, "reset": ["velocity"] }
        ],
        "output": { "frames": 0.02, "measures": 0.005, "checkpoint": 0.02 },
        "measures": {
            "front": { "kind": "front", "side": "x-max" },
            "surface": { "kind": "profile", "axis": 0, "height": 1, "bin": 0.02 }
        },
        "methods": { "mpm": { "cell_size": 0.01, "courant": 0.3 } }
    })
}

pub fn write(folder: &Path, name: &str, case: &Value) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, case.to_string()).expect("a file in a temporary folder");
    path
}

fn summary(out: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(out.join("summary.json")).expect("a summary")).expect("JSON")
}

/// Output files of a finished run except the wall time, by name.
fn results(out: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<(String, Vec<u8>)> = [out.to_owned(), out.join("frames")]
        .iter()
        .flat_map(|folder| {
            fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path())
        })
        .filter(|path| path.is_file() && !path.ends_with("summary.json"))
        .map(|path| {
            (
                path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                fs::read(&path).expect("a file"),
            )
        })
        .collect();
    files.sort();
    files
}

/// Column with cohesion for a search of its strength.
fn searched() -> Value {
    let mut case = column();
    case["materials"]["sand"]["cohesion"] = json!(2000);
    case["stages"] = json!([{ "name": "rest", "duration": 0.01, "damping": 0.5 }]);
    case["measures"] = json!({ "safety": {
        "kind": "factor-of-safety", "after": "rest", "duration": 0.1, "height": 0.1, "damping": 0.5,
        "range": [0.5, 20], "tolerance": 0.1
    } });
    case
}

/// Sorted names in a folder.
fn names_in(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Sets a value at a JSON pointer.
fn set(json: &mut Value, pointer: &str, value: Value) {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match json.pointer_mut(parent).unwrap() {
        Value::Object(map) => {
            map.insert(key.to_owned(), value);
        }
        other => other[key.parse::<usize>().unwrap()] = value,
    }
}
