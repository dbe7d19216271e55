//! The command line of Colluvium.

mod commands;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use commands::{
    CommandError, check, compare, element_test, export, new, plot, report, run, schema, specimen, sweep,
    verify,
};

/// Point-based numerical methods for geomechanics.
///
/// Exit codes: 0 done; 1 the run failed or its files could not be written; 2 wrong usage; 3 the case
/// file is wrong; 4 interrupted, continue with --resume.
#[derive(Parser)]
#[command(version, verbatim_doc_comment)]
struct CommandLine {
    /// Load the shared libraries that materials of the model `umat` name. They run with your rights: only for files that
    /// you trust. The environment variable COLLUVIUM_ALLOW_LIBRARY=1 does the same.
    #[arg(long, global = true)]
    allow_library: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Runs a case and writes measures, frames and a summary.
    Run(run::RunArguments),
    /// Runs a case with every method that can honour it, and writes one page that sets them side by side.
    Compare(compare::CompareArguments),
    /// Checks a case without running it and says what would be solved.
    Check(check::CheckArguments),
    /// Prints the JSON Schema of a case file, or its reference as Markdown.
    Schema(schema::SchemaArguments),
    /// Writes a starting case.
    New(new::NewArguments),
    /// Runs a test of a single material point: table and pictures.
    ElementTest(element_test::ElementTestArguments),
    /// Draws measures and points of a run.
    Plot(plot::PlotArguments),
    /// Writes frames and measures of a run as arrays for scripts (NPZ).
    Export(export::ExportArguments),
    /// Writes a report of a run: one page with all that it left.
    Report(report::ReportArguments),
    /// Prepares the specimen of a case of grains, and writes grains and contacts for other cases to begin with.
    Specimen(specimen::SpecimenArguments),
    /// Runs a case with many values of its parameters: table, misfit, convergence.
    Sweep(sweep::SweepArguments),
    /// Says whether the files of a complete run are still what it wrote.
    Verify(verify::VerifyArguments),
}

fn main() -> ExitCode {
    colluvium::register_materials();
    let arguments = CommandLine::parse();
    if arguments.allow_library {
        colluvium::constitutive::laws::allow_libraries();
    }
    let result = match arguments.command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Schema(arguments) => schema::run(&arguments),
        Command::New(arguments) => new::run(&arguments),
        Command::ElementTest(arguments) => element_test::run(&arguments),
        Command::Plot(arguments) => plot::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Report(arguments) => report::run(&arguments),
        Command::Specimen(arguments) => specimen::run(&arguments),
        Command::Sweep(arguments) => sweep::run(&arguments),
        Command::Verify(arguments) => verify::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.report();
            ExitCode::from(failure.exit_code())
        }
    }
}

impl CommandError {
    fn report(&self) {
        for line in self.to_string().lines() {
            commands::write_stderr(format_args!("error: {line}"));
        }
    }
}
