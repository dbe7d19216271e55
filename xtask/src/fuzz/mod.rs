//! Broken case files and killed runs, many of them.

mod killed_runs;
mod mutate;
mod mutated_cases;

use clap::Args;
use colluvium::case::Case;

/// Result of an operation on scratch files.
type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

/// Which, and how many.
#[derive(Args)]
pub struct FuzzArguments {
    /// Number of files that are generated from all templates, benchmark cases and element tests.
    #[arg(default_value_t = 100_000)]
    files: u64,
    /// Seed of the random numbers; equal seeds generate equal files.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of the first file; with `1` as the number of files, the test of a failed file is repeated.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Only files generated from cases of this method.
    #[arg(long)]
    method: Option<String>,
    /// Kill runs of all methods at random moments instead, this number of times in total, and resume them.
    #[arg(long, value_name = "TIMES")]
    kill: Option<u64>,
    /// Run one case into a folder, as the process that `--kill` starts and kills.
    #[arg(long, num_args = 2, value_names = ["CASE", "FOLDER"], hide = true)]
    one: Option<Vec<std::path::PathBuf>>,
}

/// Runs the fuzz test; `false` where something failed.
///
/// # Errors
/// When scratch files cannot be written.
pub fn run(arguments: &FuzzArguments) -> Result<bool, String> {
    dispatch(arguments).map_err(|error| error.to_string())
}

/// Runs the fuzz test that the arguments select.
fn dispatch(arguments: &FuzzArguments) -> Fallible<bool> {
    if let Some([case, out]) = arguments.one.as_deref() {
        return killed_runs::run_one(&Case::from_file(case)?, out);
    }
    match arguments.kill {
        Some(times) => killed_runs::run(times, arguments.seed),
        None => {
            let numbers = arguments.first..arguments.first.saturating_add(arguments.files);
            mutated_cases::run(numbers, arguments.seed, arguments.method.as_deref())
        }
    }
}
