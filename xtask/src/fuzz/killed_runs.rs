//! Killed runs: their folders never look complete, and after a restart they end as if uninterrupted.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use colluvium::case::output::{Collection, read_json};
use colluvium::case::run::verify;
use colluvium::case::{Case, RunOptions};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::fuzz::Fallible;

/// Approximate wall-clock time of a whole run (s), on one thread of a release build.
const WALL_TIME: f64 = 0.5;

/// Number of frames of a whole run.
const FRAMES: f64 = 8.0;
/// Number of rows of measures of a whole run.
const ROWS: f64 = 40.0;

/// Largest number of times that one run is killed.
const MAX_KILLS: u64 = 4;

/// Kills and resumes runs, `times` in all, and prints the failures.
///
/// # Errors
/// When scratch files cannot be written.
pub fn run(times: u64, seed: u64) -> Fallible<bool> {
    let scratch = crate::root().join("target/fuzz-kill");
    if scratch.exists() {
        fs::remove_dir_all(&scratch)?;
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut runs = Vec::new();
    for name in colluvium::template_names() {
        let folder = scratch.join(name);
        fs::create_dir_all(&folder)?;
        runs.push(ReferenceRun::complete(name, &folder)?);
    }
    let (mut killed, mut failures) = (0, 0);
    while killed < times {
        for whole in &runs {
            let (kills, problem) = whole.kill_and_resume(&mut random)?;
            killed += kills;
            if let Some(problem) = problem {
                failures += 1;
                println!("{}: {problem}", whole.name);
            }
        }
        println!("killed {killed} times, {failures} failures");
    }
    Ok(failures == 0)
}

/// Runs one case in a folder, from its checkpoint if there is one.
///
/// # Errors
/// When the run fails.
pub fn run_one(case: &Case, out: &Path) -> Fallible<bool> {
    let name = case.methods.keys().next().ok_or("no method")?;
    let method = colluvium::method(name).ok_or("unknown method")?;
    let resume = out.join("summary.json").exists() || out.join("checkpoint.bin").exists();
    let options = RunOptions {
        method: name.clone(),
        output_folder: Some(out.to_owned()),
        resume,
        ..RunOptions::default()
    };
    colluvium::case::run::run_method(method, case, &options)?;
    Ok(true)
}

/// Run without interruption.
struct ReferenceRun {
    name: &'static str,
    case: PathBuf,
    folder: PathBuf,
    wall: Duration,
    files: BTreeMap<PathBuf, Vec<u8>>,
}

impl ReferenceRun {
    /// Runs a template without interruption, shortened to a wall time of [`WALL_TIME`].
    fn complete(name: &'static str, folder: &Path) -> Fallible<Self> {
        colluvium::write_template_files(name, folder)?;
        let case = folder.join("case.json");
        fs::write(&case, colluvium::template(name).unwrap_or_default())?;
        let mut short = Case::from_file(&case)?;
        short.methods = short.methods.into_iter().take(1).collect();
        let method =
            short.methods.keys().next().and_then(|name| colluvium::method(name)).ok_or("no method")?;
        let share = (WALL_TIME / method.plan(&short)?.seconds()).min(1.0);
        for stage in &mut short.stages {
            stage.duration *= share;
            stage.gravity_ramp *= share;
            stage.equilibrium = None;
        }
        let end = short.end_time();
        (short.output.frames, short.output.measures) = (Some(end / FRAMES), Some(end / ROWS));
        short.output.checkpoint = 1e-3;
        fs::write(&case, short.to_json())?;
        let whole = folder.join("whole");
        let begun = Instant::now();
        let done = spawn_run(&case, &whole)?.wait()?;
        if !done.success() {
            return Err(format!("{name}: the undisturbed run fails").into());
        }
        let wall = begun.elapsed();
        println!("{name}: {:.1} s", wall.as_secs_f64());
        Ok(Self { name, case, folder: folder.to_owned(), wall, files: folder_files(&whole)? })
    }

    /// Kills and resumes a run several times and lets it end. Returns the number of kills and the problem, if there is one.
    fn kill_and_resume(&self, random: &mut ChaCha8Rng) -> Fallible<(u64, Option<String>)> {
        let out = self.folder.join("killed");
        if out.exists() {
            fs::remove_dir_all(&out)?;
        }
        let mut kills = 0;
        for _ in 0..MAX_KILLS {
            let mut run = spawn_run(&self.case, &out)?;
            std::thread::sleep(self.wall.mul_f64(random.random_range(0.0..1.0)));
            run.kill()?;
            let ended = run.wait()?;
            kills += u64::from(!ended.success());
            if let Some(problem) = folder_problem(&out) {
                return Ok((kills, Some(problem)));
            }
            if ended.success() {
                break;
            }
        }
        let complete =
            |out: &Path| read_json(&out.join("summary.json")).is_ok_and(|s| s["status"] == "completed");
        if !complete(&out) && !spawn_run(&self.case, &out)?.wait()?.success() {
            return Ok((kills, Some("cannot be resumed to its end".to_owned())));
        }
        if let Some(problem) = folder_problem(&out) {
            return Ok((kills, Some(problem)));
        }
        let files = folder_files(&out)?;
        let differs = self.files.iter().find(|(name, bytes)| files.get(*name) != Some(*bytes));
        let more = files.keys().find(|name| !self.files.contains_key(*name));
        let problem = differs.map(|(name, _)| name).or(more);
        Ok((
            kills,
            problem.map(|name| format!("{} differs from that of the undisturbed run", name.display())),
        ))
    }
}

/// Starts a run in a process of its own.
fn spawn_run(case: &Path, out: &Path) -> std::io::Result<std::process::Child> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args(["fuzz", "--one"]).arg(case).arg(out).stdout(Stdio::null()).stderr(Stdio::null()).spawn()
}

/// Problem in the folder of a run that may have been killed. A complete run has all its files, and every file in its list of frames exists.
fn folder_problem(out: &Path) -> Option<String> {
    let summary = out.join("summary.json");
    if !summary.exists() {
        return None;
    }
    let status = match read_json(&summary) {
        Ok(summary) => summary["status"].as_str().unwrap_or("none").to_owned(),
        Err(error) => return Some(error.to_string()),
    };
    let collection = out.join("frames.pvd");
    if collection.exists() {
        match Collection::read(&collection) {
            Err(error) => return Some(error.to_string()),
            Ok(found) => {
                if let Some((_, gone)) = found.frames.iter().find(|(_, name)| !out.join(name).exists()) {
                    return Some(format!("frames.pvd refers to {gone}, which is missing"));
                }
            }
        }
    }
    match (status.as_str(), verify(out)) {
        ("completed", Ok(verified)) => verified.problems.first().cloned(),
        ("completed", Err(error)) => Some(error.to_string()),
        ("running", Ok(_)) => Some("passes `verify` while it runs".to_owned()),
        ("running", Err(_)) => None,
        (other, _) => Some(format!("has the status {other:?}")),
    }
}

/// Files in a folder and below, except the summary, which has wall-clock times.
fn folder_files(folder: &Path) -> std::io::Result<BTreeMap<PathBuf, Vec<u8>>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(place) = folders.pop() {
        for entry in fs::read_dir(&place)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.file_name() != Some("summary.json".as_ref()) {
                let name = path.strip_prefix(folder).unwrap_or(&path).to_owned();
                files.insert(name, fs::read(&path)?);
            }
        }
    }
    Ok(files)
}
