//! `colluvium compare`.

use std::path::PathBuf;
use std::sync::Arc;

use crate::case::{Case, Warning};
use crate::compare::{self, CompareOptions, MethodOutcome, MethodResult, ReferenceProfiles};
use crate::machine::free_memory;
use crate::output::run_pictures::view_plane_for_gravity;
use crate::run_progress::RunProgress;
use clap::Args;

use super::{CommandError, LibraryArguments, OutputArguments, stop_on_interrupt, thread_pool, write_stdout};
use crate::cli::file_kind;
use crate::cli::file_kind::FileKind;

#[derive(Args)]
#[command(
    after_help = "Usual calls:\n  colluvium compare landslide.json\n  colluvium compare landslide.json --methods mpm,sph"
)]
pub struct CompareArguments {
    /// The case file.
    case: PathBuf,
    /// Names of the methods, separated by commas; by default all that support the case.
    #[arg(long, value_delimiter = ',')]
    methods: Vec<String>,
    /// Number of threads; all cores by default. Results do not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Number of simultaneous methods, each with its share of the threads. By default methods run one after the other, and run times are
    /// those of all threads.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: u16,
    /// CSV file of reference profiles with the columns position and height (m), and time (s) for several profiles; by default the file
    /// `reference.csv` beside the case, if it exists.
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,
    /// Axes of the view; by default xy, and xz in three dimensions with gravity along z.
    #[arg(long, value_parser = ["xy", "xz", "yz"])]
    view: Option<String>,
    #[command(flatten)]
    files: OutputArguments,
    #[command(flatten)]
    pub library: LibraryArguments,
}

/// Runs a case with several methods, and writes the page that compares them.
pub fn run(arguments: &CompareArguments) -> Result<(), CommandError> {
    let files = &arguments.files;
    file_kind::require_kind(&arguments.case, FileKind::Case)?;
    let case = Case::from_file(&arguments.case)?;
    let methods = compare::methods_by_name(&arguments.methods)?;
    let quiet = files.quiet;
    let reference =
        ReferenceProfiles::read_for_case(&arguments.case, arguments.reference.as_deref(), |file| {
            if !quiet {
                let _ = write_stdout(format_args!("reference: {}", file.display()));
            }
        })?;
    let out = files.output_folder(&arguments.case, "compare");
    let has_bars = arguments.jobs <= 1;
    let progress = if has_bars { RunProgress::default() } else { RunProgress::of_warnings() };
    let progress = Arc::new(progress);
    let options = CompareOptions {
        output_folder: out.clone(),
        resume: files.resume,
        overwrite: files.overwrite,
        jobs: arguments.jobs.into(),
        free_memory: free_memory(),
        stop_flag: Some(stop_on_interrupt()),
        commit: crate::COMMIT.map(str::to_owned),
        observer: (!quiet).then(|| progress.observer()),
    };
    let pool = thread_pool(arguments.threads)?;
    let show = |result: &MethodResult| {
        progress.clear();
        print_method_result(result, quiet);
    };
    let results = pool.install(|| compare::run(&case, &methods, &options, &show))?;
    if results.iter().any(|result| matches!(result.outcome, MethodOutcome::Interrupted)) {
        return Err(CommandError::Interrupted);
    }
    let plane = view_plane_for_gravity(case.gravity.get(2).copied(), arguments.view.as_deref());
    let page = compare::write_page(&out, &case, &results, plane, &reference)?;
    print_line!("comparison: {}", page.display());
    let failed = |result: &&MethodResult| matches!(result.outcome, MethodOutcome::Failed { .. });
    match results.iter().filter(failed).count() {
        0 => Ok(()),
        _ => Err(CommandError::message("methods-failed", "the run of at least one method failed")),
    }
}

/// Prints the result of a method and the options chosen for it.
fn print_method_result(result: &MethodResult, quiet: bool) {
    let MethodResult { method, chosen_options: took, outcome, .. } = result;
    let line = match outcome {
        MethodOutcome::Failed { code, reason } => {
            return print_error_line!("error[{code}]: {method}: {}", reason.replace('\n', "; "));
        }
        _ if quiet => return,
        MethodOutcome::Refused(why) => {
            Warning::new("method-refused", format!("{method}: does not support this case: {why}"))
                .line("note")
        }
        MethodOutcome::Interrupted => format!("{method}: interrupted"),
        MethodOutcome::Completed(report) => {
            format!("{method}: {} steps in {:.1} s", report.steps, report.wall_time)
        }
    };
    // If nobody reads the output, the program ends; any other failure appears again at the last line.
    let _ = write_stdout(format_args!("{line}"));
    let is_refused = matches!(outcome, MethodOutcome::Refused(_));
    if !took.is_empty() && !is_refused {
        let chosen = Warning::new("chosen-options", format!("{method}: chosen options: {took}"));
        let _ = write_stdout(format_args!("{}", chosen.line("note")));
    }
}
