//! Dependency rules of `docs/architecture.md`: the allowed dependencies of each crate, inside and outside the workspace.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::tidy::RuleViolation;

/// Name of the rule.
const RULE_NAME: &str = "crate graph";

/// Dependencies of a package of the workspace, from `cargo metadata`.
struct PackageDependencies {
    folder: String,
    normal: BTreeSet<String>,
    dev: BTreeSet<String>,
}

/// Packages of the workspace by name.
type Packages = BTreeMap<String, PackageDependencies>;

/// Violations of the rules of dependencies: upward, sideways or excluded ones, and names and lints other than those of the workspace.
///
/// # Errors
///
/// `cargo metadata` cannot be run.
pub fn crate_graph(root: &Path) -> Result<Vec<RuleViolation>, String> {
    let packages = packages(root)?;
    let mut findings = Vec::new();
    for (name, package) in &packages {
        let manifest = if package.folder == "xtask" {
            "xtask/Cargo.toml".to_owned()
        } else {
            format!("crates/{}/Cargo.toml", package.folder)
        };
        for message in dependency_violations(name, package, &packages) {
            findings.push(RuleViolation::new(RULE_NAME, &manifest, 0, message));
        }
        let text =
            fs::read_to_string(root.join(&manifest)).map_err(|error| format!("{manifest}: {error}"))?;
        if !text.contains("[lints]\nworkspace = true") {
            findings.push(RuleViolation::new(RULE_NAME, &manifest, 0, "has lints of its own".to_owned()));
        }
    }
    findings.extend(python_dependencies(root)?);
    Ok(findings)
}

/// Violations of the Python package, whose workspace is its own: it depends on the facade alone.
fn python_dependencies(root: &Path) -> Result<Vec<RuleViolation>, String> {
    let manifest = "python/Cargo.toml";
    let text = fs::read_to_string(root.join(manifest)).map_err(|error| format!("{manifest}: {error}"))?;
    let lines = text.lines().zip(1..);
    let others = lines.filter(|(line, _)| line.starts_with("colluvium-") && line.contains("path ="));
    let violation = |(line, number): (&str, usize)| {
        let name = line.split_whitespace().next().unwrap_or_default();
        RuleViolation::new(RULE_NAME, manifest, number, format!("depends on {name}, not on the facade alone"))
    };
    Ok(others.map(violation).collect())
}

/// Violations by dependencies that users of the methods as libraries would build without need.
///
/// # Errors
///
/// `cargo tree` cannot be run.
pub fn unneeded_dependencies(root: &Path) -> Result<Vec<RuleViolation>, String> {
    let mut findings = Vec::new();
    for (name, package) in packages(root)? {
        let arguments: &[&str] = match package.folder.as_str() {
            "plots" | "xtask" => continue,
            "colluvium" => &["--no-default-features"],
            _ if package.normal.contains("colluvium-case") => &[],
            _ => continue,
        };
        let built = built_packages(root, &name, arguments)?;
        for program in PROGRAM_DEPENDENCIES.into_iter().filter(|program| built.contains(*program)) {
            let manifest = format!("crates/{}/Cargo.toml", package.folder);
            findings.push(RuleViolation::new(
                RULE_NAME,
                &manifest,
                0,
                format!("the library without its program depends on {program}"),
            ));
        }
    }
    Ok(findings)
}

/// Names of all packages that a library user of a package builds.
fn built_packages(root: &Path, package: &str, arguments: &[&str]) -> Result<BTreeSet<String>, String> {
    let fixed = ["tree", "--offline", "--edges", "normal,build", "--prefix", "none", "--package", package];
    let tree = cargo(root, &[&fixed, arguments].concat())?;
    Ok(tree.lines().filter_map(|line| Some(line.split_whitespace().next()?.to_owned())).collect())
}

/// Standard output of a `cargo` command.
fn cargo(root: &Path, arguments: &[&str]) -> Result<String, String> {
    let output = Command::new(std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned()))
        .args(arguments)
        .current_dir(root)
        .output()
        .map_err(|error| format!("cargo {}: {error}", arguments[0]))?;
    if !output.status.success() {
        return Err(format!("cargo {}: {}", arguments[0], String::from_utf8_lossy(&output.stderr)));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Text of a JSON string; empty for another value.
fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

/// Packages of the workspace with their dependencies.
fn packages(root: &Path) -> Result<Packages, String> {
    let described = cargo(root, &["metadata", "--no-deps", "--offline", "--format-version", "1"])?;
    let metadata: Value = serde_json::from_str(&described).map_err(|error| error.to_string())?;
    let entries = metadata["packages"].as_array().ok_or("cargo metadata lists no packages")?;
    Ok(entries.iter().map(package).collect())
}

/// Name and dependencies of a package.
fn package(entry: &Value) -> (String, PackageDependencies) {
    let dependencies = entry["dependencies"].as_array().map(Vec::as_slice).unwrap_or_default();
    let of = |wanted: fn(&Value) -> bool| {
        dependencies.iter().filter(|d| wanted(&d["kind"])).map(|d| text(&d["name"])).collect()
    };
    let folder =
        Path::new(entry["manifest_path"].as_str().unwrap_or_default()).parent().and_then(Path::file_name);
    let package = PackageDependencies {
        folder: folder.unwrap_or_default().to_string_lossy().into_owned(),
        normal: of(Value::is_null),
        dev: of(|kind| !kind.is_null()),
    };
    (text(&entry["name"]), package)
}

/// Crates of the workspace that the one in `folder` may depend on; `None` where it may depend on all.
fn allowed_dependencies(folder: &str) -> Option<&'static [&'static str]> {
    match folder {
        "colluvium" | "xtask" => None,
        "constitutive" | "points" | "grid" => Some(&[]),
        "umat" => Some(&["colluvium-constitutive"]),
        "terrain" => Some(&["colluvium-points"]),
        "case" => Some(&["colluvium-constitutive", "colluvium-points", "colluvium-terrain"]),
        "plots" => Some(&["colluvium-case", "colluvium-constitutive"]),
        // The others are methods, or the shared test code of methods.
        _ => Some(&["colluvium-case", "colluvium-constitutive", "colluvium-grid", "colluvium-points"]),
    }
}

/// External dependencies that at most one crate below the facade may have. Output belongs to `case`, pictures to `plots`, and the command
/// line to the facade.
const EXCLUSIVE_DEPENDENCIES: [(&str, Option<&str>); 6] = [
    ("clap", None),
    ("pyo3", None),
    ("plotters", Some("plots")),
    ("vtkio", Some("case")),
    ("csv", Some("case")),
    ("indicatif", Some("case")),
];

/// Dependencies of programs that a library user of a method does not build.
const PROGRAM_DEPENDENCIES: [&str; 7] = ["clap", "ctrlc", "gif", "plotters", "png", "pyo3", "sysinfo"];

/// All allowed dependencies of the constitutive core: a finite-element code uses it alone.
const CORE_DEPENDENCIES: [&str; 7] =
    ["libloading", "nalgebra", "postcard", "schemars", "serde", "serde_json", "thiserror"];

/// Messages about dependencies of a package that the rules exclude.
fn dependency_violations(name: &str, package: &PackageDependencies, packages: &Packages) -> Vec<String> {
    let mut messages = Vec::new();
    let above_all = package.folder == "colluvium" || package.folder == "xtask";
    if package.normal.contains("xtask") || package.dev.contains("xtask") {
        messages.push("depends on xtask".to_owned());
    }
    if package.normal.contains("colluvium-testkit")
        && !["testkit", "xtask"].contains(&package.folder.as_str())
    {
        messages.push("depends on colluvium-testkit outside of tests".to_owned());
    }
    for dependency in package.normal.union(&package.dev).filter(|d| packages.contains_key(*d)) {
        let may =
            allowed_dependencies(&package.folder).is_none_or(|names| names.contains(&dependency.as_str()));
        if !may && dependency != "colluvium-testkit" {
            messages.push(format!("must not depend on {dependency}"));
        }
    }
    for (dependency, owner) in EXCLUSIVE_DEPENDENCIES {
        if !above_all && package.normal.contains(dependency) && owner != Some(package.folder.as_str()) {
            messages.push(format!("must not depend on {dependency}"));
        }
    }
    if package.folder == "constitutive" {
        let extra = package.normal.iter().filter(|d| !CORE_DEPENDENCIES.contains(&d.as_str()));
        messages.extend(extra.map(|d| format!("the constitutive core must not have the new dependency {d}")));
    }
    let expected = if above_all { package.folder.clone() } else { format!("colluvium-{}", package.folder) };
    if name != expected {
        messages.push(format!("is named {name}, not {expected}"));
    }
    messages
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test_package(folder: &str, normal: &[&str], dev: &[&str]) -> PackageDependencies {
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        PackageDependencies { folder: folder.to_owned(), normal: names(normal), dev: names(dev) }
    }

    #[test]
    fn methods_may_depend_on_lower_crates_but_not_on_each_other() {
        let mut packages = Packages::new();
        for folder in ["constitutive", "points", "grid", "case", "mpm", "sph", "testkit"] {
            packages.insert(format!("colluvium-{folder}"), test_package(folder, &[], &[]));
        }
        let found = |folder: &str, normal: &[&str], dev: &[&str]| {
            dependency_violations(
                &format!("colluvium-{folder}"),
                &test_package(folder, normal, dev),
                &packages,
            )
        };
        assert!(
            found("sph", &["colluvium-case", "colluvium-points", "rayon"], &["colluvium-testkit"]).is_empty()
        );
        assert_eq!(found("sph", &["colluvium-mpm"], &[]), ["must not depend on colluvium-mpm"]);
        assert_eq!(found("sph", &[], &["colluvium-mpm"]), ["must not depend on colluvium-mpm"]);
        assert_eq!(found("grid", &["colluvium-points"], &[]), ["must not depend on colluvium-points"]);
        assert_eq!(found("mpm", &["csv"], &[]), ["must not depend on csv"]);
        assert_eq!(found("case", &["csv", "plotters"], &[]), ["must not depend on plotters"]);
        assert_eq!(found("constitutive", &["rayon"], &[]).len(), 1);
        assert_eq!(
            dependency_violations("sph", &test_package("sph", &[], &[]), &packages),
            ["is named sph, not colluvium-sph"]
        );
    }
}
