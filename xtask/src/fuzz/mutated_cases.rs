//! Broken case files: none may make the program panic, hang or write values that are not numbers.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::ops::Range;
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use colluvium::case::{Case, CaseErrors, Method};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use crate::fuzz::Fallible;
use crate::fuzz::mutate::mutate;

/// Longest time for one file.
const FILE_TIME_LIMIT: Duration = Duration::from_secs(30);

/// Largest memory of a problem that is built (bytes).
const MEMORY: f64 = 5e8;
/// Largest number of points of a problem that is run.
const MAX_POINTS_PER_CASE: usize = 4000;

/// Largest number of grains of a case that is planned. Planning generates the specimen, which takes long.
const MAX_PLANNED_GRAINS: f64 = 30_000.0;

/// Largest length of a readable message (characters).
const LINE: usize = 1500;

/// Number of steps that a valid case is run.
const STEPS: usize = 3;

/// File from which mutations begin, and the folder with the files that it names, in which it is tried.
struct SeedFile {
    name: String,
    value: Value,
    folder: PathBuf,
}

/// Outcome of a mutated file. A file that is too large to be tried counts as refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FuzzOutcome {
    /// The file is rejected with an error message, or is too large.
    Refused,
    /// The file is read or planned, but the case is not run to its last step.
    Planned,
    /// All steps are made.
    Run,
}

/// Tries the mutated files of these numbers, from all cases or those of a method. Failures are printed, and their files are written to
/// `target/fuzz`.
///
/// # Errors
/// When scratch files cannot be written, or no case is of that method.
pub fn run(numbers: Range<u64>, seed: u64, method: Option<&str>) -> Fallible<bool> {
    let files = numbers.end - numbers.start;
    let folder = crate::root().join("target/fuzz");
    let mut origins = origins(&folder.join(format!("tried-{seed}")))?;
    let parts: Vec<Value> = origins.iter().map(|origin| origin.value.clone()).collect();
    retain_method(&mut origins, method)?;
    let mut outcomes: BTreeMap<FuzzOutcome, u64> = BTreeMap::new();
    let mut failures = KindsOfFailure { folder, seed, kinds: BTreeSet::new() };
    let watched = start_watchdog();
    let panic_text = capture_panics();
    let begun = Instant::now();
    for number in numbers {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(number);
        let origin = &origins[random.random_range(0..origins.len())];
        let mut value = origin.value.clone();
        mutate(&mut value, &parts, &mut random);
        let path = origin.folder.join("case.json");
        fs::write(&path, serde_json::to_string_pretty(&value)?)?;
        if let Ok(mut watched) = watched.lock() {
            *watched = Some((Instant::now(), path.clone()));
        }
        let element = origin.value.get("material").is_some();
        let outcome =
            panic::catch_unwind(AssertUnwindSafe(|| try_file(&path, element))).unwrap_or_else(|_| {
                Err(panic_text.lock().map_or_else(|_| "panic".to_owned(), |text| text.clone()))
            });
        if let Ok(mut watched) = watched.lock() {
            *watched = None;
        }
        match outcome {
            Ok(outcome) => *outcomes.entry(outcome).or_default() += 1,
            Err(problem) => failures.keep_file(number, &path, origin, &problem)?,
        }
        if number % 10_000 == 9999 {
            println!("{} files in {:.0} s", number + 1, begun.elapsed().as_secs_f64());
        }
    }
    drop(panic::take_hook());
    let count = |outcome| outcomes.get(&outcome).copied().unwrap_or(0);
    println!(
        "{files} files, seed {seed}: {} refused, {} planned, {} run for {STEPS} steps, {} failures of {} kinds, {:.0} s",
        count(FuzzOutcome::Refused),
        count(FuzzOutcome::Planned),
        count(FuzzOutcome::Run),
        files - outcomes.values().sum::<u64>(),
        failures.kinds.len(),
        begun.elapsed().as_secs_f64(),
    );
    Ok(failures.kinds.is_empty())
}

/// Kinds of failure so far, and the folder for files that fail.
struct KindsOfFailure {
    folder: PathBuf,
    seed: u64,
    kinds: BTreeSet<String>,
}

impl KindsOfFailure {
    /// Writes a file that fails to the folder, and prints the first problem of each kind.
    fn keep_file(&mut self, number: u64, path: &Path, origin: &SeedFile, problem: &str) -> Fallible<()> {
        let kept = self.folder.join(format!("failed-{}-{number}.json", self.seed));
        fs::copy(path, &kept)?;
        // One of each kind of problem is enough.
        let kind: String = problem.chars().filter(|c| !c.is_ascii_digit()).take(120).collect();
        if self.kinds.insert(kind) {
            println!("file {number}, from {}, kept as {}: {problem}", origin.name, kept.display());
        }
        Ok(())
    }
}

/// Removes the cases of other methods, where a method is given.
fn retain_method(origins: &mut Vec<SeedFile>, method: Option<&str>) -> Fallible<()> {
    let Some(method) = method else { return Ok(()) };
    origins.retain(|origin| origin.value["methods"].get(method).is_some());
    if origins.is_empty() { Err(format!("no initial case has the method {method:?}").into()) } else { Ok(()) }
}

/// Reads all starting cases, benchmark cases, element tests and fuzz cases (`validation/fuzz`), each with a folder of its own.
fn origins(scratch: &Path) -> Fallible<Vec<SeedFile>> {
    if scratch.exists() {
        fs::remove_dir_all(scratch)?;
    }
    let mut origins = Vec::new();
    let mut add = |name: String, text: &str, files: &dyn Fn(&Path) -> Fallible<()>| {
        let folder = scratch.join(format!("{}", origins.len()));
        fs::create_dir_all(&folder)?;
        files(&folder)?;
        let value: Value = serde_json::from_str(text)?;
        // Cells of grains need up to two million steps to reach their stress.
        let ready = !text.contains("granular-cell");
        if value.get("stages").is_some() && ready {
            origins.push(SeedFile { name, value, folder });
        }
        Fallible::Ok(())
    };
    for name in colluvium::template_names() {
        let text = colluvium::template(name).unwrap_or_default();
        add(name.to_owned(), text, &|folder| Ok(colluvium::write_template_files(name, folder)?))?;
    }
    for path in json_files(&crate::root().join("validation"))? {
        let text = fs::read_to_string(&path)?;
        let beside = |folder: &Path| {
            for entry in fs::read_dir(path.parent().unwrap_or(&path))? {
                let file = entry?.path();
                if file.is_file() && file.extension().is_none_or(|kind| kind != "json") {
                    fs::copy(&file, folder.join(file.file_name().unwrap_or_default()))?;
                }
            }
            Ok(())
        };
        add(path.display().to_string(), &text, &beside)?;
    }
    Ok(origins)
}

/// JSON files in a folder and below, in the order of their names.
fn json_files(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut entries: Vec<PathBuf> =
        fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>()?;
    entries.sort();
    let mut files = Vec::new();
    for path in entries {
        if path.is_dir() {
            files.extend(json_files(&path)?);
        } else if path.extension().is_some_and(|kind| kind == "json")
            && path.file_name() != Some("open-defects.json".as_ref())
        {
            files.push(path);
        }
    }
    Ok(files)
}

/// Loads a file, and tries its case with each method for which it has options.
fn try_file(path: &Path, element: bool) -> Result<FuzzOutcome, String> {
    if element {
        return match colluvium::load_element_test(path) {
            Err(errors) => check_messages(&errors),
            Ok(_) => Ok(FuzzOutcome::Planned),
        };
    }
    let case = match Case::from_file(path) {
        Err(errors) => return check_messages(&errors),
        Ok(case) => case,
    };
    let mut outcome = FuzzOutcome::Refused;
    for name in case.methods.keys() {
        let Some(method) = colluvium::method(name) else { continue };
        outcome = outcome.max(try_method(method, &case)?);
    }
    Ok(outcome)
}

/// Plans, builds and runs a case with a method, as far as its size allows.
fn try_method(method: &dyn Method, case: &Case) -> Result<FuzzOutcome, String> {
    let sized = method.problem_size(case).and_then(|size| size.check_memory(MEMORY).map(|()| size.points));
    let planned = match sized {
        Ok(points) if method.name() == "dem" && points > MAX_PLANNED_GRAINS => {
            return Ok(FuzzOutcome::Refused);
        }
        Ok(_) => method.plan(case),
        Err(error) => Err(error),
    };
    let plan = match planned {
        Err(error) => return check_messages(&CaseErrors::from_error(error)),
        Ok(plan) => plan,
    };
    for warning in plan.all_warnings(case) {
        check_readable(&warning.text)?;
    }
    let step = plan.time_step.dt;
    if !(step.is_finite() && step > 0.0) {
        return Err(format!("{}: a planned time step of {step} s", method.name()));
    }
    if plan.points > MAX_POINTS_PER_CASE {
        return Ok(FuzzOutcome::Planned);
    }
    let mut solver = match method.build(case) {
        Err(error) => return check_messages(&CaseErrors::from_error(error)),
        Ok(solver) => solver,
    };
    if solver.begin_stage(0, 0.0).is_err() {
        return Ok(FuzzOutcome::Planned);
    }
    for _ in 0..STEPS {
        let dt = solver.limit().dt;
        if !dt.is_finite() || solver.step(dt).is_err() {
            return Ok(FuzzOutcome::Planned);
        }
    }
    let snapshot = solver.snapshot();
    match snapshot.positions.iter().flatten().find(|x| !x.is_finite()) {
        Some(x) => Err(format!("{}: a point at {x} after {STEPS} steps", method.name())),
        None => Ok(FuzzOutcome::Run),
    }
}

/// Checks that the messages of a refusal are readable.
fn check_messages(errors: &CaseErrors) -> Result<FuzzOutcome, String> {
    for error in &errors.0 {
        check_readable(&error.to_string())?;
    }
    if errors.0.is_empty() {
        Err("is refused without a message".to_owned())
    } else {
        Ok(FuzzOutcome::Refused)
    }
}

/// Checks that a message is not too long, not empty and without NaN.
fn check_readable(line: &str) -> Result<(), String> {
    let printed = colluvium::case::printable(line);
    if printed.chars().count() > LINE {
        let start: String = printed.chars().take(200).collect();
        return Err(format!("a message of {} characters: {start} …", printed.chars().count()));
    }
    if line.contains("NaN") || line.trim().is_empty() {
        return Err(format!("a message without content: {line:?}"));
    }
    Ok(())
}

/// Starts a thread that ends the program where one file takes too long.
fn start_watchdog() -> Arc<Mutex<Option<(Instant, PathBuf)>>> {
    let watched: Arc<Mutex<Option<(Instant, PathBuf)>>> = Arc::default();
    let current = watched.clone();
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_secs(1));
            let Ok(current) = current.lock() else { return };
            if let Some((since, path)) = &*current
                && since.elapsed() > FILE_TIME_LIMIT
            {
                println!("{}: takes more than {} s", path.display(), FILE_TIME_LIMIT.as_secs());
                std::process::exit(1);
            }
        }
    });
    watched
}

/// Redirects the messages of panics from standard error to a buffer.
fn capture_panics() -> Arc<Mutex<String>> {
    let panic_text: Arc<Mutex<String>> = Arc::default();
    let heard = panic_text.clone();
    panic::set_hook(Box::new(move |about| {
        if let Ok(mut heard) = heard.lock() {
            *heard = format!("panic: {about}").replace('\n', " ");
        }
    }));
    panic_text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_hundred_broken_files_are_refused_or_run() {
        assert!(run(0..500, 7, None).unwrap());
    }

    #[test]
    fn cases_written_for_the_fuzz_test_are_valid() {
        let files = json_files(&crate::root().join("validation/fuzz")).unwrap();
        assert!(!files.is_empty());
        for path in files {
            let outcome = try_file(&path, false).unwrap();
            assert_eq!(outcome, FuzzOutcome::Run, "{}", path.display());
        }
    }
}
