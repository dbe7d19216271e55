//! `cargo xtask same-bits REV`: results of two revisions, compared to the last bit.
//!
//! The cases are those of `validation/same-bits`: families of a base case and factors; each pair of levels is in a row. Each revision runs
//! the rows of its own files, so that a key of a case may be renamed between them. Renamed columns and fields are in
//! `validation/same-bits/renamed.csv`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use clap::Args;
use colluvium::case::{Case, FieldData, Snapshot, output};
use colluvium_testkit::pairwise::{CaseFamily, LevelRow};
use rayon::prelude::*;
use serde_json::Value;

/// Arguments of `cargo xtask same-bits`.
#[derive(Args)]
pub struct SameBitsArguments {
    /// Git revision to compare the working tree with.
    revision: String,
    /// Only families whose name contains this text.
    filter: Option<String>,
    /// Compare release builds (a build takes several times as long).
    #[arg(long)]
    release: bool,
    /// List the levels of each case.
    #[arg(long)]
    list: bool,
}

/// Folder of the case families (a base case and the levels of its options) below the root of a tree.
const CASE_FAMILIES: &str = "validation/same-bits";

/// Longest duration of a run; most runs take less than a second.
const LIMIT: Duration = Duration::from_secs(20);

/// Source tree of a revision, and the program built from it.
struct BuiltRevision {
    tree: PathBuf,
    program: PathBuf,
}

/// Compares the results of two revisions, and returns whether all agree.
///
/// # Errors
/// When a revision cannot be built or a file cannot be read.
pub fn run(arguments: &SameBitsArguments) -> Result<bool, String> {
    let root = crate::root();
    let folder = root.join("target/same-bits");
    let old = checkout_and_build(root, &folder, arguments)?;
    let new = build(root, &root.join("target"), arguments.release)?;
    let wanted =
        |family: &CaseFamily| arguments.filter.as_ref().is_none_or(|text| family.name.contains(text));
    let families: Vec<CaseFamily> =
        CaseFamily::read_all(&root.join(CASE_FAMILIES))?.into_iter().filter(wanted).collect();
    let renamed = renamed_columns(&root.join(CASE_FAMILIES).join("renamed.csv"))?;
    let (mut count, mut differences) = (0, Vec::new());
    for family in &families {
        let file = old.tree.join(CASE_FAMILIES).join(format!("{}.json", family.name));
        let earlier = CaseFamily::read(&file)?;
        let rows = family.pairwise_rows(&is_accepted);
        println!("{}: {} cases", family.name, rows.len());
        if arguments.list {
            rows.iter().for_each(|row| println!("  {}", family.description(row)));
        }
        count += rows.len();
        let compare = |row: &LevelRow| -> Result<(Option<String>, bool), String> {
            let before = outcome(&old, &earlier.case(&earlier.row_of(family, row)))?;
            let after = outcome(&new, &family.case(row))?;
            let name = format!("{} ({})", family.name, family.description(row));
            Ok((
                difference(&before, &after, &renamed).map(|what| format!("{name}: {what}")),
                after.code == Some(0),
            ))
        };
        let found: Vec<_> = rows.par_iter().map(compare).collect::<Result<_, String>>()?;
        println!(
            "  {} ended with an error or after {LIMIT:?}",
            found.iter().filter(|(_, ended)| !ended).count()
        );
        differences.extend(found.into_iter().filter_map(|(differs, _)| differs));
    }
    differences.iter().for_each(|difference| println!("differs: {difference}"));
    println!("{count} cases, {} differ", differences.len());
    Ok(differences.is_empty())
}

/// Whether the program of the working tree accepts a case.
fn is_accepted(case: &Value) -> bool {
    let Some(method) = case["methods"].as_object().and_then(|methods| methods.keys().next()) else {
        return false;
    };
    let Ok(read) = Case::from_json(&case.to_string()) else { return false };
    colluvium::method(method).is_some_and(|method| method.plan(&read).is_ok())
}

/// Checks out and builds a revision. One tree serves all revisions, so that a build compiles only the changes.
fn checkout_and_build(
    root: &Path,
    folder: &Path,
    arguments: &SameBitsArguments,
) -> Result<BuiltRevision, String> {
    let named =
        Command::new("git").args(["rev-parse", "--short=12", &arguments.revision]).current_dir(root).output();
    let named = named.map_err(|error| format!("git: {error}"))?;
    if !named.status.success() {
        return Err(format!("{:?} is not a git revision", arguments.revision));
    }
    let commit = String::from_utf8_lossy(&named.stdout).trim().to_owned();
    let tree = folder.join("tree");
    let mut git = Command::new("git");
    if tree.join("Cargo.toml").is_file() {
        git.args(["checkout", "--quiet", "--detach", "--force", &commit]).current_dir(&tree);
    } else {
        git.args(["worktree", "add", "--detach", "--force"]).arg(&tree).arg(&commit).current_dir(root);
    }
    run_command(&mut git, "git")?;
    if !tree.join(CASE_FAMILIES).is_dir() {
        return Err(format!("revision {commit} has no folder {CASE_FAMILIES}"));
    }
    build(&tree, &folder.join("target"), arguments.release)
}

/// Builds the program of a revision.
fn build(tree: &Path, target: &Path, release: bool) -> Result<BuiltRevision, String> {
    let mut build = Command::new(env!("CARGO"));
    build
        .args(["build", "--package", "colluvium", "--bin", "colluvium"])
        .arg("--target-dir")
        .arg(target)
        .current_dir(tree);
    if release {
        build.arg("--release");
    }
    run_command(&mut build, "cargo build")?;
    let profile = if release { "release" } else { "debug" };
    Ok(BuiltRevision { tree: tree.to_owned(), program: target.join(profile).join("colluvium") })
}

/// Runs a command; an error where it fails.
fn run_command(command: &mut Command, name: &str) -> Result<(), String> {
    let status = command.status().map_err(|error| format!("{name}: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("{name} failed")) }
}

/// New names of columns of measures and fields of frames, by their old names.
fn renamed_columns(file: &Path) -> Result<BTreeMap<String, String>, String> {
    let text = std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
    let pairs = text.lines().skip(1).filter_map(|line| line.split_once(','));
    Ok(pairs.map(|(old, new)| (old.to_owned(), new.to_owned())).collect())
}

/// Output of a run: columns of measures as text, and fields of frames as bits.
#[derive(Default)]
struct RunFiles {
    /// Exit code of the program; `None` where the run takes too long.
    code: Option<i32>,
    /// Columns of the measures: heading and cells.
    columns: BTreeMap<String, Vec<String>>,
    /// Fields of all frames, one after the other: bits of the numbers.
    fields: BTreeMap<String, Vec<u64>>,
}

/// Runs a case in its own folder and reads its output.
fn outcome(revision: &BuiltRevision, case: &Value) -> Result<RunFiles, String> {
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let (file, out) = (folder.path().join("case.json"), folder.path().join("out"));
    std::fs::write(&file, case.to_string()).map_err(|error| error.to_string())?;
    let mut outcome = RunFiles { code: exit_code(revision, &file, &out)?, ..RunFiles::default() };
    read_measures(&out, &mut outcome);
    read_frames(&out, &mut outcome)?;
    Ok(outcome)
}

/// Exit code of a run; `None` when it takes longer than [`LIMIT`].
fn exit_code(revision: &BuiltRevision, file: &Path, out: &Path) -> Result<Option<i32>, String> {
    let wrong = |error: std::io::Error| format!("{}: {error}", revision.program.display());
    let mut command = Command::new(&revision.program);
    command.arg("run").arg(file).arg("--out").arg(out).stdout(Stdio::null()).stderr(Stdio::null());
    let (start, mut run) = (Instant::now(), command.spawn().map_err(wrong)?);
    loop {
        if let Some(status) = run.try_wait().map_err(wrong)? {
            return Ok(status.code());
        }
        if start.elapsed() > LIMIT {
            run.kill().and_then(|()| run.wait()).map_err(wrong)?;
            return Ok(None);
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Reads the table of measures of a run.
fn read_measures(out: &Path, outcome: &mut RunFiles) {
    let Ok(text) = std::fs::read_to_string(out.join("measures.csv")) else { return };
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let headings: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    for line in lines {
        for (heading, cell) in headings.iter().zip(line.split(',')) {
            outcome.columns.entry((*heading).to_owned()).or_default().push(cell.to_owned());
        }
    }
}

/// Reads the frames of a run.
fn read_frames(out: &Path, outcome: &mut RunFiles) -> Result<(), String> {
    let index = out.join("frames.pvd");
    if !index.is_file() {
        return Ok(());
    }
    let index = output::Collection::read(&index).map_err(|error| error.to_string())?;
    for (time, file) in index.of_points() {
        let frame = output::read_frame(&out.join(file), time).map_err(|error| error.to_string())?;
        add_fields(&frame, outcome);
    }
    Ok(())
}

/// Adds positions and fields of a frame, as bits.
fn add_fields(frame: &Snapshot, outcome: &mut RunFiles) {
    let mut add = |name: &str, values: &mut dyn Iterator<Item = f64>| {
        outcome.fields.entry(name.to_owned()).or_default().extend(values.map(f64::to_bits));
    };
    add("position", &mut frame.positions.iter().flatten().copied());
    for field in &frame.fields {
        match &field.data {
            FieldData::Integer(values) => add(&field.name, &mut values.iter().map(|value| *value as f64)),
            FieldData::Scalar(values) => add(&field.name, &mut values.iter().copied()),
            FieldData::Vector(values) => add(&field.name, &mut values.iter().flatten().copied()),
            FieldData::Tensor(values) => add(&field.name, &mut values.iter().flat_map(|value| value.0)),
        }
    }
}

/// First difference between two outcomes.
fn difference(before: &RunFiles, after: &RunFiles, renamed: &BTreeMap<String, String>) -> Option<String> {
    if before.code != after.code {
        return Some(format!("exit code {:?} before and {:?} now", before.code, after.code));
    }
    assert_equal_bits(&before.columns, &after.columns, renamed, "column")
        .or_else(|| assert_equal_bits(&before.fields, &after.fields, renamed, "field"))
}

/// Message about the first difference between two sets of named values, in all bits. `renamed` maps old names to new ones.
fn assert_equal_bits<T: PartialEq>(
    before: &BTreeMap<String, Vec<T>>,
    after: &BTreeMap<String, Vec<T>>,
    renamed: &BTreeMap<String, String>,
    kind: &str,
) -> Option<String> {
    for (name, values) in before {
        let now = renamed.get(name).unwrap_or(name);
        let Some(found) = after.get(now) else { return Some(format!("{kind} {now:?} is missing")) };
        if values != found {
            let place =
                values.iter().zip(found).position(|(a, b)| a != b).unwrap_or(values.len().min(found.len()));
            return Some(format!("{kind} {now:?}, entry {place} of {}", values.len()));
        }
    }
    let known = |name: &String| before.contains_key(name) || renamed.values().any(|new| new == name);
    after.keys().find(|name| !known(name)).map(|name| format!("{kind} {name:?} is new"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changed_bits_and_names_are_differences_except_for_renamed_fields() {
        let of = |name: &str, value: f64| BTreeMap::from([(name.to_owned(), vec![value.to_bits()])]);
        let outcome = |fields| RunFiles { fields, ..RunFiles::default() };
        let (none, table) =
            (BTreeMap::new(), BTreeMap::from([("head".to_owned(), "pore_pressure".to_owned())]));
        let before = outcome(of("head", 1.0));
        assert_eq!(difference(&before, &outcome(of("head", 1.0)), &none), None);
        assert!(difference(&before, &outcome(of("head", 1.0 + f64::EPSILON)), &none).is_some());
        assert!(difference(&before, &outcome(of("pore_pressure", 1.0)), &none).is_some());
        assert_eq!(difference(&before, &outcome(of("pore_pressure", 1.0)), &table), None);
        assert!(difference(&outcome(of("head", 0.0)), &outcome(of("head", -0.0)), &none).is_some());
    }

    #[test]
    fn families_of_the_repository_accept_their_bases() {
        let families = CaseFamily::read_all(&crate::root().join(CASE_FAMILIES)).unwrap();
        assert!(families.len() >= 6);
        for family in families {
            assert!(is_accepted(&family.case(&family.row(&[]))), "{}", family.name);
        }
    }
}
