//! Verification of the files of a run by their checksums.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::Case;
use crate::output::{FileChecksum, OutputError, read_json};
use crate::run::output::run_folder;
use crate::run::output::run_folder::{CASE, FRAMES, RASTERS, SUMMARY};

/// Checksums of all files of a run in `out` except its summary, by name. They are `run_checksums`, which the run has computed, and those of
/// the files written at its end, including `rasters`.
pub(super) fn file_checksums(
    out: &Path,
    run_checksums: BTreeMap<String, FileChecksum>,
    rasters: &[String],
) -> Result<BTreeMap<String, FileChecksum>, OutputError> {
    let mut names = run_folder::collections(out)?;
    names.push(CASE.to_owned());
    names.extend(
        run_folder::names(out)?
            .into_iter()
            .filter(|name| run_folder::is_trials(name) || run_folder::is_failing(name)),
    );
    names.extend_from_slice(rasters);
    let mut checksums = run_checksums;
    for name in names {
        let path = out.join(&name);
        if path.exists() {
            checksums.insert(name, FileChecksum::of_file(&path, None)?);
        }
    }
    Ok(checksums)
}

/// Checksums as JSON for a summary.
pub(super) fn to_json(checksums: &BTreeMap<String, FileChecksum>) -> Value {
    let one = |(name, checksum): (&String, &FileChecksum)| {
        (name.clone(), json!({ "bytes": checksum.bytes, "fnv1a": format!("{:016x}", checksum.fnv1a) }))
    };
    Value::Object(checksums.iter().map(one).collect())
}

/// Result of the verification of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VerificationResult {
    /// Number of verified files.
    pub files: usize,
    /// Files that differ from their checksums, one line each.
    pub problems: Vec<String>,
}

/// Verifies the files of a complete run in `out` by the checksums in its summary.
///
/// # Errors
/// When there is no summary, when the run is not complete, or when the summary names no files, as in runs of older versions.
pub fn verify(out: &Path) -> Result<VerificationResult, OutputError> {
    let path = out.join(SUMMARY);
    let summary = read_json(&path)?;
    let fail = |problem: String| OutputError::coded(&path, "verify-mismatch", problem);
    let status = summary["status"].as_str().unwrap_or("unknown");
    if status != "completed" {
        return Err(fail(format!("the run is not complete ({status}): only complete runs have checksums")));
    }
    let Some(files) = summary["files"].as_object() else {
        return Err(fail("lists no files: a version of the program without checksums wrote it".to_owned()));
    };
    let mut problems = Vec::new();
    if !files.contains_key(CASE) {
        problems.push(format!("{CASE}: was missing when the run ended. `run --overwrite` writes it"));
    }
    for (name, checksum) in files {
        let (bytes, hash) = (checksum["bytes"].as_u64(), checksum["fnv1a"].as_str());
        let path = out.join(name);
        let found = match fs::metadata(&path) {
            Ok(about) if Some(about.len()) != bytes => {
                let was = bytes.unwrap_or(0);
                problems.push(format!("{name}: has {} bytes, but the run wrote {was}", about.len()));
                continue;
            }
            Ok(_) => FileChecksum::of_file(&path, None)?,
            Err(error) => {
                problems.push(format!("{name}: {error}"));
                continue;
            }
        };
        if Some(format!("{:016x}", found.fnv1a).as_str()) != hash {
            problems.push(format!("{name}: was changed since the run wrote it"));
        }
    }
    let foreign = results(out)?.into_iter().filter(|name| !files.contains_key(name));
    problems.extend(
        foreign.map(|name| {
            format!("{name}: has the name of a result, but the run did not write it. Move it away")
        }),
    );
    Ok(VerificationResult { files: files.len(), problems })
}

/// Names of the files in the folder of a run that have names of results.
fn results(out: &Path) -> Result<Vec<String>, OutputError> {
    let within = |folder: &str, is_own: fn(&str) -> bool| {
        let mut names = run_folder::names(&out.join(folder))?;
        names.retain(|name| is_own(name));
        names.sort();
        Ok::<_, OutputError>(names.into_iter().map(|name| format!("{folder}/{name}")).collect::<Vec<_>>())
    };
    let mut names = within(FRAMES, run_folder::is_frame)?;
    // The map is drawn from the rasters after the end of the run.
    names.extend(within(RASTERS, |name| run_folder::is_map(name) && name != run_folder::MAP)?);
    Ok(names)
}

/// Paths of the input files of a case that have changed since the start of the run, or are missing.
///
/// # Errors
/// When there is no summary.
pub fn changed_inputs(out: &Path, case: &Case) -> Result<Vec<String>, OutputError> {
    Ok(changed_files(&read_json(&out.join(SUMMARY))?, &case.file_checksums()))
}

/// Paths of the input files of a summary whose checksums have changed, or which are missing.
pub(super) fn changed_files(summary: &Value, now: &BTreeMap<String, String>) -> Vec<String> {
    let then = summary["inputs"].as_object().into_iter().flatten();
    let changed = then.filter(|(path, mark)| now.get(*path).map(String::as_str) != mark.as_str());
    changed.map(|(path, _)| path.clone()).collect()
}
