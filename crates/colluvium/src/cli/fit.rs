//! `colluvium fit`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::case::files::json;
use crate::case::output::column_heading;
use crate::case::printable;
use crate::fit::{Fit, FitFolder, FitProblem, FitSolution, FittedParameter, short, uncertainty_text};
use clap::Args;

use super::{
    CommandError, LibraryArguments, count_text, duration_text, print_note, print_warning, thread_pool,
};
use crate::cli::file_kind;
use crate::cli::file_kind::FileKind;

#[derive(Args)]
#[command(after_help = "Usual calls:\n  colluvium fit --check fit.json\n  colluvium fit fit.json")]
pub struct FitArguments {
    /// The file of the fit.
    file: PathBuf,
    /// Check the file and its data, and do not search.
    #[arg(long)]
    check: bool,
    /// Folder for the results; the name of the file by default.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Format of the pictures: png or svg.
    #[arg(long, default_value = "png", value_parser = ["png", "svg"])]
    format: String,
    /// Number of threads; all cores by default. Results do not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Replace the results of an earlier fit.
    #[arg(long)]
    overwrite: bool,
    /// Print nothing but warnings and errors.
    #[arg(long, short)]
    quiet: bool,
    #[command(flatten)]
    pub library: LibraryArguments,
}

/// Fits the parameters of a material to tests.
pub fn run(arguments: &FitArguments) -> Result<(), CommandError> {
    let file = &arguments.file;
    file_kind::require_kind(file, FileKind::Fit)?;
    let pool = thread_pool(arguments.threads)?;
    let begin = Instant::now();
    let problem = Fit::load(file)?;
    let seconds = begin.elapsed().as_secs_f64();
    if !arguments.quiet {
        print_problem(&problem)?;
    }
    if arguments.check {
        let (evaluations, threads) = (problem.fit.evaluations(), pool.current_num_threads());
        let longest = duration_text(seconds * evaluations as f64 / threads as f64);
        print_line!("duration    {longest} at most, for {evaluations} evaluations on {threads} threads");
        return Ok(());
    }
    let out = arguments.out.clone().unwrap_or_else(|| default_folder(file));
    let mut folder = FitFolder::open(&out, &problem.fit, &arguments.format, arguments.overwrite)?;
    let input = json::text(file)?;
    let solution = pool.install(|| problem.solve());
    folder.write(&problem, &solution, &input)?;
    if !arguments.quiet {
        print_solution(&problem, &solution)?;
    }
    for warning in solution.warnings() {
        print_warning(&warning);
    }
    if !arguments.quiet {
        for note in solution.notes() {
            print_note(&note);
        }
        print_line!("results in {}", out.display());
    }
    Ok(())
}

/// Folder with the name of the file, in the current folder.
fn default_folder(file: &Path) -> PathBuf {
    file.canonicalize().unwrap_or_default().file_stem().unwrap_or_default().into()
}

/// Prints the title and the data of each test.
fn print_problem(problem: &FitProblem) -> Result<(), CommandError> {
    print_line!("{}", printable(&problem.fit.title));
    for (test, data) in problem.fit.tests.iter().zip(&problem.data) {
        let curves = data.curves.iter().map(|curve| {
            let unit = if curve.unit.is_empty() { String::new() } else { format!(" {}", curve.unit) };
            let count = count_text(curve.values.len(), "value");
            format!("{} ({count}, tolerance {}{unit})", curve.name, short(curve.tolerance))
        });
        let curves: Vec<String> = curves.collect();
        print_line!("{:<11} {}: {}", test.name, count_text(data.rows, "row"), curves.join(", "));
        if !data.unused.is_empty() {
            print_line!("{:<11} not used: {}", "", data.unused.join(", "));
        }
    }
    Ok(())
}

/// Prints the table of parameters and the misfits.
fn print_solution(problem: &FitProblem, solution: &FitSolution) -> Result<(), CommandError> {
    let row = |parameter: &FittedParameter| {
        let deviation = if parameter.is_determined {
            uncertainty_text(parameter.deviation)
        } else {
            "not determined".to_owned()
        };
        let [low, high] = parameter.range.range.map(short);
        [
            column_heading(&parameter.name, &parameter.unit),
            short(parameter.start),
            short(parameter.fitted),
            deviation,
            format!("{low} to {high}"),
        ]
    };
    let mut table = vec![["parameter", "start", "fitted", "deviation", "range"].map(str::to_owned)];
    table.extend(solution.parameters.iter().map(row));
    let width = |column: usize| table.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths = [0, 1, 2, 3].map(width);
    for [name, start, fitted, deviation, range] in &table {
        let [w0, w1, w2, w3] = widths;
        print_line!("{name:<w0$}  {start:>w1$}  {fitted:>w2$}  {deviation:>w3$}  {range}");
    }
    let evaluations = count_text(solution.evaluations, "evaluation");
    print_line!(
        "misfit      {:.3} at the start, {:.3} at the end; {evaluations}",
        solution.start_misfit,
        solution.misfit
    );
    for ((test, data), misfits) in problem.fit.tests.iter().zip(&problem.data).zip(&solution.curve_misfits) {
        let pairs = data.curves.iter().zip(misfits);
        let curves: Vec<String> =
            pairs.map(|(curve, misfit)| format!("{} {misfit:.3}", curve.name)).collect();
        print_line!("{:<11} {}", test.name, curves.join(", "));
    }
    Ok(())
}
