//! Commands and options of the command line.

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use crate::cli::{
    CommandError, check, compare, completions, element_test, explain, export, fit, new, plot, report, run,
    schema, specimen, sweep, verify, write_stderr,
};

/// Point-based numerical methods for geomechanics.
///
/// Exit codes: 0 done; 1 the run failed or its files could not be written; 2 wrong usage; 3 the case
/// file is wrong; 4 interrupted, continue with --resume.
#[derive(Parser)]
#[command(name = "colluvium", version, verbatim_doc_comment)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Writes a starting case from a template, or lists the templates.
    New(new::NewArguments),
    /// Checks a case without running it and prints its size, time step, duration and warnings.
    Check(check::CheckArguments),
    /// Runs a case and writes measures, frames and a summary.
    Run(run::RunArguments),
    /// Runs a case with every method that supports it and writes one page that compares the results.
    Compare(compare::CompareArguments),
    /// Runs a case with varied parameters and writes a table with misfit and convergence.
    Sweep(sweep::SweepArguments),
    /// Draws measures and points of a run.
    Plot(plot::PlotArguments),
    /// Writes the report of a run: one page with all its results.
    Report(report::ReportArguments),
    /// Writes frames and measures of a run as arrays for scripts (NPZ).
    Export(export::ExportArguments),
    /// Runs an element test (a single material point) and writes its table and pictures.
    ElementTest(element_test::ElementTestArguments),
    /// Fits the parameters of a material to laboratory tests and writes their values, uncertainties and pictures.
    Fit(fit::FitArguments),
    /// Prepares a specimen of grains and writes its grains and contacts as the initial state of other cases.
    Specimen(specimen::SpecimenArguments),
    /// Explains the code of a warning or an error: its meaning, how to find the cause, and what to change.
    Explain(explain::ExplainArguments),
    /// Checks that the files of a complete run have not changed since the run.
    Verify(verify::VerifyArguments),
    /// Prints the JSON Schema of a case file, or its reference as Markdown.
    Schema(schema::SchemaArguments),
    /// Prints a script that completes commands and options in a shell.
    Completions(completions::CompletionsArguments),
}

impl Command {
    /// Whether the user allows foreign libraries.
    fn allows_library(&self) -> bool {
        match self {
            Self::Check(arguments) => arguments.library.allow_library,
            Self::Run(arguments) => arguments.library.allow_library,
            Self::Compare(arguments) => arguments.library.allow_library,
            Self::Sweep(arguments) => arguments.library.allow_library,
            Self::Plot(arguments) => arguments.library.allow_library,
            Self::Report(arguments) => arguments.library.allow_library,
            Self::Export(arguments) => arguments.library.allow_library,
            Self::ElementTest(arguments) => arguments.library.allow_library,
            Self::Fit(arguments) => arguments.library.allow_library,
            Self::Specimen(arguments) => arguments.library.allow_library,
            Self::New(_) | Self::Verify(_) | Self::Explain(_) | Self::Schema(_) | Self::Completions(_) => {
                false
            }
        }
    }
}

/// Runs the command line as the main function of a program, as [`exit_code`].
pub fn main(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> ExitCode {
    exit_code(arguments).into()
}

/// Runs the command line with its arguments, the first of which is the name of the program, and returns the exit code: 0 done; 1 the run
/// failed or its files could not be written; 2 wrong usage; 3 the case file is wrong; 4 interrupted.
///
/// It writes to standard output and standard error, and handles Ctrl-C by itself.
pub fn exit_code(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> u8 {
    match CommandLine::try_parse_from(arguments) {
        Ok(line) => execute(line.command),
        Err(usage) => {
            let _ = usage.print();
            u8::try_from(usage.exit_code()).unwrap_or(2)
        }
    }
}

/// Runs a command, and returns the exit code.
fn execute(command: Command) -> u8 {
    crate::register_materials();
    if command.allows_library() {
        crate::constitutive::laws::allow_libraries();
    }
    let result = match command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Schema(arguments) => schema::run(&arguments),
        Command::New(arguments) => new::run(&arguments),
        Command::ElementTest(arguments) => element_test::run(&arguments),
        Command::Fit(arguments) => fit::run(&arguments),
        Command::Plot(arguments) => plot::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Report(arguments) => report::run(&arguments),
        Command::Specimen(arguments) => specimen::run(&arguments),
        Command::Sweep(arguments) => sweep::run(&arguments),
        Command::Explain(arguments) => explain::run(&arguments),
        Command::Verify(arguments) => verify::run(&arguments),
        Command::Completions(arguments) => completions::run(&arguments, &mut CommandLine::command()),
    };
    match result {
        Ok(()) => 0,
        Err(failure) => {
            failure.report();
            failure.exit_code()
        }
    }
}

impl CommandError {
    /// Prints the error to the standard error stream, line by line.
    fn report(&self) {
        for (code, line) in self.lines() {
            write_stderr(format_args!("error[{code}]: {line}"));
        }
    }
}
