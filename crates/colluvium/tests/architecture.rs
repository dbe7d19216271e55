//! The invariants of `docs/architecture.md` that a machine can check: which crate may depend on which.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// A package of this workspace as `cargo metadata` describes it.
struct Package {
    folder: String,
    normal: BTreeSet<String>,
    all: BTreeSet<String>,
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

fn packages() -> BTreeMap<String, Package> {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../Cargo.toml");
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1", "--manifest-path"])
        .arg(manifest)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let package = |entry: &Value| {
        let dependencies = entry["dependencies"].as_array().unwrap();
        let folder = Path::new(entry["manifest_path"].as_str().unwrap()).parent().unwrap().file_name();
        let package = Package {
            folder: folder.unwrap().to_string_lossy().into_owned(),
            normal: dependencies.iter().filter(|d| d["kind"].is_null()).map(|d| text(&d["name"])).collect(),
            all: dependencies.iter().map(|d| text(&d["name"])).collect(),
        };
        (text(&entry["name"]), package)
    };
    metadata["packages"].as_array().unwrap().iter().map(package).collect()
}

/// Workspace crates that the crate in `folder` may name.
fn allowed(folder: &str) -> &'static [&'static str] {
    match folder {
        "constitutive" | "points" | "grid" => &[],
        "umat" => &["colluvium-constitutive"],
        "case" => &["colluvium-constitutive", "colluvium-points"],
        // What remains is a method.
        _ => &["colluvium-case", "colluvium-constitutive", "colluvium-grid", "colluvium-points"],
    }
}

#[test]
fn every_dependency_within_the_workspace_points_down() {
    let packages = packages();
    assert!(packages.len() >= 7, "found only {:?}", packages.keys());
    for (name, package) in &packages {
        if name == "colluvium" {
            assert!(!package.all.contains("xtask"), "the facade depends on xtask");
        } else if name != "xtask" {
            let workspace = package.all.iter().filter(|d| packages.contains_key(*d));
            let above: Vec<_> =
                workspace.filter(|d| !allowed(&package.folder).contains(&d.as_str())).collect();
            assert!(above.is_empty(), "{name} must not depend on {above:?}");
        }
    }
}

#[test]
fn constitutive_core_keeps_its_short_list_of_dependencies() {
    let short: BTreeSet<String> =
        ["libloading", "nalgebra", "postcard", "schemars", "serde", "serde_json", "thiserror"]
            .map(str::to_owned)
            .into_iter()
            .collect();
    let extra: Vec<String> =
        packages()["colluvium-constitutive"].normal.difference(&short).cloned().collect();
    assert!(extra.is_empty(), "new dependencies of the constitutive core: {extra:?}");
}

#[test]
fn nothing_below_the_facade_draws_parses_arguments_or_writes_files_of_its_own() {
    for (name, package) in packages() {
        if name == "colluvium" || name == "xtask" {
            continue;
        }
        assert!(!package.normal.contains("clap"), "{name} parses a command line");
        if package.folder != "case" {
            for output in ["plotters", "vtkio", "csv", "indicatif"] {
                assert!(!package.normal.contains(output), "{name} depends on {output}; output is case's");
            }
        }
    }
}

#[test]
fn packages_are_named_after_their_folders() {
    for (name, package) in packages() {
        let expected = match package.folder.as_str() {
            "colluvium" | "xtask" => package.folder.clone(),
            folder => format!("colluvium-{folder}"),
        };
        assert_eq!(name, expected);
    }
}

#[test]
fn every_crate_inherits_the_lints_of_the_workspace() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for package in packages().values() {
        let folder = if package.folder == "xtask" { root.clone() } else { root.join("crates") };
        let manifest = std::fs::read_to_string(folder.join(&package.folder).join("Cargo.toml")).unwrap();
        assert!(manifest.contains("[lints]\nworkspace = true"), "{} has its own lints", package.folder);
    }
}
