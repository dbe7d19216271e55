//! Speed of the solvers in a program that depends on them as anybody's does.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;

use crate::root;

/// Program in the repository that is copied out of it.
const PROGRAM: &str = "examples/downstream";

/// Least speed with the defaults of Cargo over that with the profile of the repository.
const LEAST_RATIO: f64 = 0.85;

/// Least speed of a loop that reads the velocities after each step over that of the same loop without reading.
const LEAST_READING_RATIO: f64 = 0.98;

/// Crates of the methods.
const METHODS: [&str; 5] =
    ["colluvium-dem", "colluvium-depth-sph", "colluvium-mpm", "colluvium-snow-mpm", "colluvium-sph"];

/// Largest number of packages on which a method without its features may depend, itself included.
const MAX_PACKAGES: usize = 65;

/// Runs of each build, of which the median counts.
const RUNS: usize = 5;

/// Builds: name, and variables of the environment.
const BUILDS: [(&str, &[(&str, &str)]); 4] = [
    ("defaults", &[]),
    ("one codegen unit", &[("CARGO_PROFILE_RELEASE_CODEGEN_UNITS", "1")]),
    ("x86-64-v3", &[("RUSTFLAGS", "-C target-cpu=x86-64-v3")]),
    ("native", &[("RUSTFLAGS", "-C target-cpu=native")]),
];

#[derive(Args)]
pub struct DownstreamArguments {
    /// Build with the defaults of Cargo only, and run it once without a comparison.
    #[arg(long)]
    short: bool,
}

/// Result of a solver in a run: time of a step (s), and hash of its state at the end.
type StepResult = (f64, String);

/// Builds the program outside the repository, runs it, and compares the times. True where each solver has [`LEAST_RATIO`], and reading
/// [`LEAST_READING_RATIO`].
pub fn run(arguments: &DownstreamArguments) -> Result<bool, String> {
    for method in METHODS {
        check_package_count(method)?;
    }
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    copy_program(folder.path())?;
    let count = if arguments.short { 1 } else { BUILDS.len() };
    let mut programs = Vec::new();
    for (number, (name, variables)) in BUILDS.iter().take(count).enumerate() {
        println!("building: {name}");
        programs.push(build(folder.path(), number, variables)?);
    }
    let runs = if arguments.short { 1 } else { RUNS };
    let mut results: Vec<BTreeMap<String, Vec<StepResult>>> = vec![BTreeMap::new(); count];
    for _ in 0..runs {
        for (program, results) in programs.iter().zip(&mut results) {
            for (solver, result) in run_once(program)? {
                results.entry(solver).or_default().push(result);
            }
        }
    }
    let mut is_fast = true;
    for solver in results[0].keys() {
        let hash = &results[0][solver][0].1;
        for ((name, _), of_build) in BUILDS.iter().zip(&results) {
            let time = median(&of_build[solver]);
            let ratio = median(&results[1.min(count - 1)][solver]) / time;
            println!("{solver}, {name}: {:.3} ms a step, speed {ratio:.2} of one codegen unit", 1e3 * time);
            if of_build[solver].iter().any(|(_, other)| other != hash) {
                return Err(format!("{solver}: the state at the end differs between builds or runs"));
            }
        }
        if count > 1 {
            is_fast &= median(&results[1][solver]) / median(&results[0][solver]) >= LEAST_RATIO;
        }
    }
    let reading = median(&results[0]["mpm"]) / median(&results[0]["mpm-with-reading"]);
    println!("mpm, velocities read after each step: speed {reading:.3} of that without");
    Ok(is_fast && (count == 1 || reading >= LEAST_READING_RATIO))
}

/// Prints the number of packages on which a method without its features depends; an error above [`MAX_PACKAGES`].
fn check_package_count(method: &str) -> Result<(), String> {
    let mut command = Command::new("cargo");
    command.args([
        "tree",
        "--package",
        method,
        "--no-default-features",
        "--edges",
        "normal",
        "--prefix",
        "none",
    ]);
    let output = command.current_dir(root()).output().map_err(|error| format!("cargo: {error}"))?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    let text = String::from_utf8_lossy(&output.stdout);
    // A package that is listed again has a star behind its version.
    let packages: BTreeSet<&str> = text.lines().map(|line| line.trim_end_matches(" (*)")).collect();
    println!("{method} without features: {} packages", packages.len());
    if packages.len() > MAX_PACKAGES {
        return Err(format!("{method} depends on {} packages, more than {MAX_PACKAGES}", packages.len()));
    }
    Ok(())
}

/// Copies the program, with the paths of its dependencies.
fn copy_program(folder: &Path) -> Result<(), String> {
    let from = root().join(PROGRAM);
    let read = |name: &str| fs::read_to_string(from.join(name)).map_err(|error| format!("{name}: {error}"));
    let write = |name: &str, text: &str| {
        fs::write(folder.join(name), text).map_err(|error| format!("{name}: {error}"))
    };
    fs::create_dir(folder.join("src")).map_err(|error| error.to_string())?;
    write("src/main.rs", &read("src/main.rs")?)?;
    write("Cargo.toml", &read("Cargo.toml")?.replace("../..", &root().display().to_string()))?;
    // The versions of the repository.
    fs::copy(root().join("Cargo.lock"), folder.join("Cargo.lock")).map_err(|error| error.to_string())?;
    Ok(())
}

/// Builds the program with variables of the environment, in a target folder of its own, and returns its path.
fn build(folder: &Path, number: usize, variables: &[(&str, &str)]) -> Result<PathBuf, String> {
    let target = folder.join(format!("target-{number}"));
    let mut command = Command::new("cargo");
    command.args(["build", "--release", "--quiet"]).current_dir(folder).env("CARGO_TARGET_DIR", &target);
    command.env_remove("RUSTFLAGS").env_remove("CARGO_ENCODED_RUSTFLAGS").envs(variables.iter().copied());
    let status = command.status().map_err(|error| format!("cargo: {error}"))?;
    if !status.success() {
        return Err("the program does not compile".to_owned());
    }
    Ok(target.join("release/downstream"))
}

/// Runs the program on one thread, and returns the results by the name of the solver.
fn run_once(program: &Path) -> Result<Vec<(String, StepResult)>, String> {
    let output = Command::new(program).env("RAYON_NUM_THREADS", "1").output();
    let output = output.map_err(|error| format!("{}: {error}", program.display()))?;
    let text = String::from_utf8_lossy(&output.stdout);
    if !output.status.success() {
        return Err(format!("the program failed: {}", String::from_utf8_lossy(&output.stderr)));
    }
    let line = |line: &str| {
        let [solver, time, hash] = line.split(' ').collect::<Vec<_>>()[..] else { return None };
        Some((solver.to_owned(), (time.parse().ok()?, hash.to_owned())))
    };
    text.lines().map(|text| line(text).ok_or_else(|| format!("unexpected line {text:?}"))).collect()
}

/// Median of the times (s).
fn median(results: &[StepResult]) -> f64 {
    let mut times: Vec<f64> = results.iter().map(|(time, _)| *time).collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
