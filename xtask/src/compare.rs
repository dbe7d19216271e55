//! `cargo xtask compare`: `colluvium compare` with its page under `target/compare/`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use colluvium::case::Case;
use colluvium::compare::{self, CompareOptions, MethodOutcome, MethodResult, ReferenceProfiles};
use colluvium::output::run_pictures::view_plane_for_gravity;
use colluvium::run_progress::RunProgress;

#[derive(Args)]
pub struct CompareTaskArguments {
    /// The case file.
    case: PathBuf,
    /// Names of the methods, separated by commas; by default all that support the case.
    #[arg(long, value_delimiter = ',')]
    methods: Vec<String>,
    /// Number of simultaneous methods, each with its share of the threads.
    #[arg(long, default_value_t = 1)]
    jobs: u16,
    /// CSV file of reference profiles with the columns position and height (m), and time (s) for several profiles; by default the file
    /// `reference.csv` beside the case, if it exists.
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,
}

/// Runs the case with every method that supports it, and writes the page. Returns whether all runs that began have finished.
pub fn run(arguments: &CompareTaskArguments) -> Result<bool, String> {
    let case = Case::from_file(&arguments.case).map_err(|errors| errors.to_string())?;
    let methods = compare::methods_by_name(&arguments.methods).map_err(|error| error.to_string())?;
    let report_file = |file: &Path| println!("reference: {}", file.display());
    let reference =
        ReferenceProfiles::read_for_case(&arguments.case, arguments.reference.as_deref(), report_file);
    let reference = reference.map_err(|error| error.to_string())?;
    let stem = arguments.case.file_stem().unwrap_or_default();
    let out = crate::root().join("target/compare").join(stem);
    let has_bars = arguments.jobs <= 1;
    let progress = Arc::new(if has_bars { RunProgress::default() } else { RunProgress::of_warnings() });
    let options = CompareOptions {
        output_folder: out.clone(),
        overwrite: true,
        observer: Some(progress.observer()),
        jobs: arguments.jobs.into(),
        free_memory: f64::INFINITY,
        ..CompareOptions::default()
    };
    let show = |result: &MethodResult| {
        progress.clear();
        print_result(result);
    };
    let results = compare::run(&case, &methods, &options, &show).map_err(|error| error.to_string())?;
    let plane = view_plane_for_gravity(case.gravity.get(2).copied(), None);
    let file =
        compare::write_page(&out, &case, &results, plane, &reference).map_err(|error| error.to_string())?;
    println!("comparison: {}", file.display());
    Ok(!results.iter().any(|result| matches!(result.outcome, MethodOutcome::Failed { .. })))
}

/// Prints the result of a method.
fn print_result(MethodResult { method, chosen_options: took, outcome, .. }: &MethodResult) {
    match outcome {
        MethodOutcome::Refused(why) => println!("{method}: does not support this case: {why}"),
        MethodOutcome::Failed { reason, .. } => println!("{method}: FAILED, {reason}"),
        MethodOutcome::Interrupted => println!("{method}: interrupted"),
        MethodOutcome::Completed(report) => {
            println!("{method}: {} steps in {:.1} s", report.steps, report.wall_time);
        }
    }
    if !took.is_empty() {
        println!("{method}: chosen options: {took}");
    }
}
