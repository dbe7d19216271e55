//! Comparison of several methods on one case: their runs, and one page that shows them side by side.

mod charts;
mod completed_run;
mod key_figures;
mod method_case;
mod page;
mod plan_cells;
mod reference_profiles;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

use thiserror::Error;

use crate::case::output::{OutputError, create_folder, write_atomically};
use crate::case::run::{ObservedEvent, Observer, RunEnd};
use crate::case::{Case, CaseError, Method, ProblemSize, Run, RunError, RunEvent, RunOptions};
use crate::parallel_runs::run_in_parallel;

pub use crate::compare::completed_run::CompletedRun;
pub use crate::compare::key_figures::{CaseAxes, KeyFigures};
pub use crate::compare::method_case::MethodCase;
pub use crate::compare::reference_profiles::ReferenceProfiles;
pub use page::{SECTIONS_STYLE, sections};

/// Name of the page in the folder of a comparison.
pub const PAGE_FILE: &str = "index.html";

/// Options of a comparison.
#[derive(Clone, Debug, Default)]
pub struct CompareOptions {
    /// Folder of the page; each method runs in a subfolder with its name.
    pub output_folder: PathBuf,
    /// Whether to continue interrupted runs; complete runs are kept.
    pub resume: bool,
    /// Whether to replace earlier results.
    pub overwrite: bool,
    /// Number of methods that run simultaneously, each on an equal share of the threads. With 0 or 1 they run one after the other, each on
    /// all threads.
    pub jobs: usize,
    /// Memory available to the simultaneous runs (bytes).
    pub free_memory: f64,
    /// Flag that stops the runs at the next step; another thread sets it.
    pub stop_flag: Option<Arc<AtomicBool>>,
    /// Commit of the program, recorded with the results.
    pub commit: Option<String>,
    /// Receives the events of each run; simultaneous runs call it at the same time. A warning about the size of a run comes before it.
    pub observer: Option<Observer>,
}

/// Outcome of a method.
#[derive(Debug)]
pub enum MethodOutcome {
    /// The method does not support the case; the text gives the reason.
    Refused(String),
    /// The run began and did not finish; the text gives the reason.
    Failed {
        /// Code of the error.
        code: &'static str,
        /// Text of the error.
        reason: String,
    },
    /// The run was stopped on request.
    Interrupted,
    /// The run reached its end, now or earlier.
    Completed(Box<CompletedRun>),
}

/// Method with its outcome.
#[derive(Debug)]
pub struct MethodResult {
    /// Name of the method.
    pub method: &'static str,
    /// Text with the options that the comparison chose; empty where the case has all options.
    pub chosen_options: String,
    /// Least memory that the method needs (bytes), as it estimates itself.
    pub estimated_memory: f64,
    /// Outcome of the method.
    pub outcome: MethodOutcome,
}

/// Failure of a comparison.
#[derive(Debug, Error)]
pub enum CompareError {
    /// A name is not that of a method.
    #[error("{name:?} is not a method; there are: {available}")]
    UnknownMethod {
        /// The unknown name.
        name: String,
        /// Names of the available methods.
        available: String,
    },
    /// No method supports the case.
    #[error("no method supports this case:\n{0}")]
    NoMethod(String),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The system gives no threads.
    #[error("threads: {0}")]
    Threads(String),
    /// The reference cannot be read as profiles.
    #[error("{}: {problem}", path.display())]
    Reference {
        /// Path of the file.
        path: PathBuf,
        /// Description of the problem.
        problem: String,
    },
    /// A picture could not be drawn.
    #[error("picture: {0}")]
    Picture(String),
}

impl CompareError {
    /// Stable code of the error, which `docs/messages.md` of the repository explains.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::UnknownMethod { .. } => "unknown-method",
            Self::NoMethod(_) => "no-method-supports",
            Self::Output(error) => error.code,
            Self::Threads(_) => "no-threads",
            Self::Reference { .. } => "reference-profiles",
            Self::Picture(_) => "picture",
        }
    }
}

/// Returns the methods called `names`, or all methods where `names` is empty.
///
/// # Errors
/// When a name is not that of a method.
pub fn methods_by_name(names: &[String]) -> Result<Vec<&'static dyn Method>, CompareError> {
    if names.is_empty() {
        return Ok(crate::methods().to_vec());
    }
    let known = || crate::methods().iter().map(|method| method.name()).collect::<Vec<_>>().join(", ");
    let named = |name: &String| {
        crate::method(name)
            .ok_or_else(|| CompareError::UnknownMethod { name: name.clone(), available: known() })
    };
    names.iter().map(named).collect()
}

/// Runs a case with several methods, `options.jobs` of them simultaneously. A failure of one does not stop the others. `tell` is called
/// with each result when it is complete.
///
/// # Errors
/// When the folder has a page that no comparison wrote, or runs that are neither to be continued nor replaced; when the system gives no
/// threads.
pub fn run(
    case: &Case,
    methods: &[&'static dyn Method],
    options: &CompareOptions,
    tell: &(dyn Fn(&MethodResult) + Sync),
) -> Result<Vec<MethodResult>, CompareError> {
    let page = options.output_folder.join(PAGE_FILE);
    let is_of_run =
        |method: &&dyn Method| options.output_folder.join(method.name()).join("summary.json").exists();
    if page.exists() && !crate::methods().iter().any(is_of_run) {
        let problem = std::io::Error::other(
            "exists already, and no comparison wrote it: choose another folder, or move the file",
        );
        return Err(OutputError::new(&page, problem).into());
    }
    if let Some(folder) = folder_with_other_run(case, methods, options) {
        let problem = "has a run already: continue with --resume, which keeps complete runs of this case, replace it \
                       with --overwrite, or choose another folder with --out";
        return Err(OutputError::coded(&folder, "folder-has-run", problem).into());
    }
    let jobs = options.jobs.clamp(1, methods.len().max(1));
    let own = CompareOptions { free_memory: options.free_memory / jobs as f64, ..options.clone() };
    let one = |method: &'static dyn Method| {
        let entrant = MethodCase::for_method(method, case);
        let size = method.problem_size(&entrant.case);
        let result = MethodResult {
            method: method.name(),
            chosen_options: entrant.chosen_options.clone(),
            estimated_memory: size.as_ref().map_or(f64::NAN, |size| size.memory),
            outcome: compare_one_method(method, &entrant.case, size, &own),
        };
        tell(&result);
        result
    };
    if jobs == 1 {
        return Ok(methods.iter().map(|method| one(*method)).collect());
    }
    let found = Mutex::new(Vec::new());
    let work = |number: usize| {
        let result = one(methods[number]);
        found.lock().unwrap_or_else(PoisonError::into_inner).push((number, result));
        Ok(())
    };
    let threads = rayon::current_num_threads() / jobs;
    run_in_parallel(methods.len(), (jobs, threads), work, CompareError::Threads)?;
    let mut found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    found.sort_by_key(|(number, _)| *number);
    Ok(found.into_iter().map(|(_, result)| result).collect())
}

/// Folder of a method that has a run which the options neither continue nor replace. The page of earlier runs remains.
fn folder_with_other_run(
    case: &Case,
    methods: &[&'static dyn Method],
    options: &CompareOptions,
) -> Option<PathBuf> {
    if options.resume || options.overwrite {
        return None;
    }
    let has_other_run = |method: &&&'static dyn Method| {
        let is_used = options.output_folder.join(method.name()).join("summary.json").exists();
        is_used && method.plan(&MethodCase::for_method(**method, case).case).is_ok()
    };
    let method = methods.iter().find(has_other_run)?;
    Some(options.output_folder.join(method.name()))
}

/// Runs one method; `size` is the problem size of the case.
fn compare_one_method(
    method: &dyn Method,
    case: &Case,
    size: Result<ProblemSize, CaseError>,
    options: &CompareOptions,
) -> MethodOutcome {
    let attempt = || {
        let plan = || {
            let size = size?;
            size.check_memory(options.free_memory)?;
            if let (Some(observer), Some(ahead)) = (&options.observer, size.size_notice()) {
                let event = &RunEvent::Warning(ahead);
                let (method, end_time) = (method.name(), case.end_time());
                observer.observe(&ObservedEvent { event, method, time: 0.0, end_time, step: 0 });
            }
            method.plan(case)
        };
        let plan = match plan() {
            Ok(plan) => plan,
            Err(refusal) => return MethodOutcome::Refused(refusal.to_string()),
        };
        let folder = options.output_folder.join(method.name());
        let state = completed_run::RunFolderState::of_folder(&folder, case);
        if state == completed_run::RunFolderState::Complete && options.resume {
            return read_outcome(&folder);
        }
        let run = RunOptions {
            method: method.name().to_owned(),
            output_folder: Some(folder.clone()),
            resume: options.resume && state == completed_run::RunFolderState::Incomplete,
            overwrite: options.overwrite,
            keep_frames: false,
            keep_specimen: false,
            stop_flag: options.stop_flag.clone(),
            observer: options.observer.clone(),
            commit: options.commit.clone(),
            warnings: plan.all_warnings(case),
        };
        let run = Run::new(Arc::new(case.clone()), method, run);
        match run.and_then(Run::finish) {
            Ok(report) if report.ending == RunEnd::Interrupted => MethodOutcome::Interrupted,
            Ok(_) => read_outcome(&folder),
            Err(RunError::Case(error)) => MethodOutcome::Refused(error.to_string()),
            Err(error) => MethodOutcome::Failed { code: error.code(), reason: error.to_string() },
        }
    };
    catch_unwind(AssertUnwindSafe(attempt))
        .unwrap_or_else(|_| MethodOutcome::Failed { code: "panic", reason: "the method panicked".to_owned() })
}

/// Outcome of a complete run, read from its folder.
fn read_outcome(folder: &Path) -> MethodOutcome {
    match CompletedRun::read(folder) {
        Ok(ran) => MethodOutcome::Completed(Box::new(ran)),
        Err(error) => MethodOutcome::Failed { code: error.code, reason: error.to_string() },
    }
}

/// Writes the page of a comparison into `folder`, with the profiles of a reference if any, and returns its path.
///
/// # Errors
/// When no method supports the case, a picture cannot be drawn, or a file cannot be written.
pub fn write_page(
    folder: &Path,
    case: &Case,
    results: &[MethodResult],
    plane: [usize; 2],
    reference: &ReferenceProfiles,
) -> Result<PathBuf, CompareError> {
    if results.iter().all(|result| matches!(result.outcome, MethodOutcome::Refused(_))) {
        let why = |result: &MethodResult| match &result.outcome {
            MethodOutcome::Refused(why) => format!("{}: {why}", result.method),
            _ => String::new(),
        };
        return Err(CompareError::NoMethod(results.iter().map(why).collect::<Vec<_>>().join("\n")));
    }
    let page = page::page(case, results, plane, reference)?.into_string();
    let file = folder.join(PAGE_FILE);
    create_folder(folder)?;
    write_atomically(&file, page.as_bytes())?;
    Ok(file)
}

/// Completed runs with the names of their methods.
fn completed_runs(results: &[MethodResult]) -> Vec<(&'static str, &CompletedRun)> {
    results
        .iter()
        .filter_map(|result| match &result.outcome {
            MethodOutcome::Completed(report) => Some((result.method, &**report)),
            _ => None,
        })
        .collect()
}
