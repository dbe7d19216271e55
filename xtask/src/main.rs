//! Validation, comparison of methods and benchmarks.

mod analysis;
mod benchmarks;
mod book;
mod compare;
mod coverage;
mod downstream;
mod fuzz;
mod open_defects;
mod pages;
mod report;
mod same_bits;
mod speed;
mod tidy;
mod validate;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Work on the project: reproduce the benchmarks, compare methods, measure speed.
#[derive(Parser)]
struct CommandLine {
    #[command(subcommand)]
    command: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Runs the benchmarks and writes index.html and report.json under target/validation.
    Validate(validate::ValidateArguments),
    /// Builds the site of the documentation with mdBook.
    Book(book::BookArguments),
    /// Runs a case with every method that supports it and writes one page that compares the results.
    Compare(compare::CompareTaskArguments),
    /// Measures point-updates per second.
    Bench(speed::mpm::BenchArguments),
    /// Writes docs/coverage.md: every row of the checklists of specification sheets, with its files, tests and benchmarks.
    Coverage(coverage::CoverageArguments),
    /// Measures the speed of the solvers in a program outside the repository.
    Downstream(downstream::DownstreamArguments),
    /// Tests broken case files, or kills runs and resumes them.
    Fuzz(fuzz::FuzzArguments),
    /// Runs the commands and snippets of the documentation as a reader would.
    Pages(pages::PagesArguments),
    /// Runs short cases over all pairs of options with the program of another revision and with that of the working tree, and compares
    /// all results to the last bit.
    SameBits(same_bits::SameBitsArguments),
    /// Checks the house rules that can be checked automatically.
    Tidy(tidy::TidyArguments),
}

/// Runs the task of the arguments.
fn main() -> ExitCode {
    colluvium::register_materials();
    let result = match CommandLine::parse().command {
        Task::Validate(arguments) => validate::run(&arguments),
        Task::Book(arguments) => book::run(&arguments),
        Task::Compare(arguments) => compare::run(&arguments),
        Task::Bench(arguments) => speed::mpm::run(&arguments),
        Task::Coverage(arguments) => coverage::run(&arguments),
        Task::Downstream(arguments) => downstream::run(&arguments),
        Task::Fuzz(arguments) => fuzz::run(&arguments),
        Task::Pages(arguments) => pages::run(&arguments),
        Task::SameBits(arguments) => same_bits::run(&arguments),
        Task::Tidy(arguments) => tidy::run(&arguments),
    };
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Root folder of the repository.
fn root() -> &'static std::path::Path {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the repository")
}
