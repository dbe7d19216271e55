//! `colluvium sweep`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::case::output::read_json;
use crate::case::run::{SearchCost, column_names, frame_memory, recorded_warnings};
use crate::case::{Plan, printable};
use crate::machine::{available_threads, free_memory, peak_memory};
use crate::select_method;
use crate::sweep::{
    Sweep, SweepCase, SweepOptions, SweepResults, SweepRunState, run_folder, run_sweep as run_all,
};
use clap::Args;

use super::{
    CommandError, LibraryArguments, OutputArguments, count_text, duration_text, print_note, print_warning,
    stop_on_interrupt, write_stdout,
};
use crate::case::Warning;
use crate::cli::file_kind;
use crate::cli::file_kind::FileKind;

#[derive(Args)]
#[command(after_help = "Usual calls:\n  colluvium sweep sweep.json --check\n  colluvium sweep sweep.json")]
pub struct SweepArguments {
    /// The file of the sweep.
    file: PathBuf,
    /// Number of simultaneous runs; by default the number of cores over that of the threads of a run.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Number of threads of each run. Results do not depend on it.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// Print the planned runs and do not run them.
    #[arg(long)]
    check: bool,
    #[command(flatten)]
    files: OutputArguments,
    #[command(flatten)]
    pub library: LibraryArguments,
}

/// Runs the cases of a sweep.
pub fn run(arguments: &SweepArguments) -> Result<(), CommandError> {
    let files = &arguments.files;
    file_kind::require_kind(&arguments.file, FileKind::Sweep)?;
    let (sweep, members) = Sweep::load(&arguments.file)?;
    let Some(first) = members.first() else { return Ok(()) };
    let method = select_method(&first.case, sweep.method.as_deref())?;
    let jobs = arguments
        .jobs
        .map_or_else(|| available_threads() / usize::from(arguments.threads), usize::from)
        .max(1);
    let (mut plans, free) = (Vec::new(), free_memory());
    for (number, SweepCase { values, case }) in members.iter().enumerate() {
        let plan = || {
            let size = method.problem_size(case)?;
            size.check_memory(free)?;
            if let Some(ahead) = size.size_notice().filter(|_| !files.quiet) {
                let text = format!("{}: {}", sweep.run_description(number, values), ahead.text);
                print_note(&Warning::new(ahead.code, text));
            }
            method.plan(case)
        };
        plans.push(plan().map_err(|error| sweep.with_run_context(number, values, error.into()))?);
    }
    let names = column_names(&first.case, &*method.build(&first.case)?);
    sweep.check_columns(&names)?;
    if !files.quiet {
        print_plan(&sweep, &members, &plans, jobs * usize::from(arguments.threads))?;
        print_memory(&plans, jobs, free)?;
    }
    if arguments.check {
        return Ok(());
    }
    let options = SweepOptions {
        output_folder: files.output_folder(&arguments.file, method.name()),
        jobs,
        threads: arguments.threads.into(),
        resume: files.resume,
        overwrite: files.overwrite,
        stop_flag: stop_on_interrupt(),
        commit: crate::COMMIT.map(str::to_owned),
    };
    let tell = |number: usize, state: &SweepRunState| {
        let (run, quiet) = (sweep.run_description(number, &members[number].values), files.quiet);
        let state = match state {
            SweepRunState::Failed { code, reason } => {
                return print_error_line!("error[{code}]: {run}: {}", reason.replace('\n', "; "));
            }
            _ if quiet => return,
            SweepRunState::AlreadyComplete => "already complete",
            SweepRunState::Completed => "completed",
            SweepRunState::Interrupted => "interrupted",
        };
        // If nobody reads the output, the program ends; any other failure appears again at the end.
        let _ = write_stdout(format_args!("{run}: {state}"));
    };
    let results = run_all(&sweep, &members, method, &options, &tell)?;
    write_results(&results, &options, files.quiet)
}

/// Prints the planned runs of a sweep.
fn print_plan(
    sweep: &Sweep,
    members: &[SweepCase],
    plans: &[Plan],
    threads: usize,
) -> Result<(), CommandError> {
    let seconds: f64 = plans.iter().map(Plan::seconds).sum();
    print_line!("{}", printable(&sweep.title));
    print_line!("runs           {}", members.len());
    print_line!("points         {} at most", plans.iter().map(|plan| plan.points).max().unwrap_or(0));
    print_line!("duration       about {} on {threads} threads", duration_text(seconds / threads as f64));
    let mut searches = [0.0; 2];
    for (plan, SweepCase { case, .. }) in plans.iter().zip(members) {
        for (_, search) in case.factors_of_safety() {
            let seconds = SearchCost::of_case(case, plan, search).seconds;
            (0..2).for_each(|which| searches[which] += seconds[which]);
        }
    }
    let [usual, longest] = searches.map(|seconds| seconds / threads as f64);
    if longest.is_nan() {
        print_line!(
            "searches       for factors of safety take additional time: see `colluvium check` of the case"
        );
    } else if longest > 0.0 {
        let (usual, longest) = (duration_text(usual), duration_text(longest));
        print_line!(
            "searches       about {usual} on {threads} threads, {longest} at most, in addition to the duration"
        );
    }
    let warnings = plans.iter().zip(members).flat_map(|(plan, member)| plan.all_warnings(&member.case));
    warnings.collect::<BTreeSet<_>>().iter().for_each(print_warning);
    Ok(())
}

/// Prints the memory of the largest simultaneous runs, with that of the program; warns where less is free.
fn print_memory(plans: &[Plan], jobs: usize, free: f64) -> Result<(), CommandError> {
    let mut runs: Vec<f64> =
        plans.iter().map(|plan| plan.memory as f64 + frame_memory(plan.points)).collect();
    runs.sort_by(|a, b| b.total_cmp(a));
    runs.truncate(jobs);
    // One of the runs has been built already, and counts in the memory of the program.
    let program = peak_memory().unwrap_or(0) as f64;
    let memory = runs.iter().sum::<f64>().max(program + runs.iter().skip(1).sum::<f64>());
    print_line!(
        "memory         about {:.1} MB for {} at a time",
        memory / 1e6,
        count_text(runs.len(), "run")
    );
    if memory > free {
        print_warning(&Warning::new(
            "sweep-memory",
            format!(
                "the simultaneous runs need about {:.2} GB of memory, and {:.2} GB are free: reduce --jobs",
                memory / 1e9,
                free / 1e9
            ),
        ));
    }
    Ok(())
}

/// Warns of runs whose results have remarks, with the number of runs for each code.
fn print_remarks(runs: usize, folder: &Path) {
    let mut codes: BTreeMap<String, usize> = BTreeMap::new();
    let mut concerned = 0;
    for number in 0..runs {
        let summary = read_json(&run_folder(folder, number).join("summary.json")).unwrap_or_default();
        let remarks: BTreeSet<String> = recorded_warnings(&summary["remarks"])
            .into_iter()
            .map(|remark| remark.code.into_owned())
            .collect();
        concerned += usize::from(!remarks.is_empty());
        remarks.into_iter().for_each(|code| *codes.entry(code).or_default() += 1);
    }
    if concerned > 0 {
        let counts: Vec<String> = codes.iter().map(|(code, count)| format!("{code} {count}")).collect();
        let text = format!(
            "the results of {concerned} of {runs} runs have remarks ({}): read `remarks` in their summary.json",
            counts.join(", ")
        );
        print_warning(&Warning::new("run-remarks", text));
    }
}

/// Writes tables and pictures of a sweep and prints its summary.
fn write_results(
    results: &SweepResults<'_>,
    options: &SweepOptions,
    quiet: bool,
) -> Result<(), CommandError> {
    let orders = results.write_convergence(&options.output_folder)?;
    let count = |status: &str| results.rows.iter().filter(|row| row.status == status).count();
    if !quiet {
        if let Some((number, misfit)) = results.best_run() {
            let run = results.sweep.run_description(number, &results.rows[number].values);
            print_line!("nearest to the targets: {run}, misfit {misfit:.3}");
        }
        for order in orders {
            print_line!("{order}");
        }
        print_line!(
            "{} of {} runs complete; results in {}",
            count("completed"),
            results.rows.len(),
            options.output_folder.display()
        );
    }
    results.warnings().iter().for_each(print_warning);
    print_remarks(results.rows.len(), &options.output_folder);
    match count("failed") {
        _ if results.rows.iter().any(|row| row.status.is_empty() || row.status == "interrupted") => {
            Err(CommandError::Interrupted)
        }
        0 => Ok(()),
        failed => Err(CommandError::message(
            "runs-failed",
            format!("{failed} of {} runs failed", results.rows.len()),
        )),
    }
}
