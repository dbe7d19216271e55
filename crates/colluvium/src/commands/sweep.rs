//! `colluvium sweep`.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;
use colluvium::case::run::{SearchCost, column_names, frame_memory};
use colluvium::case::{Plan, printable};
use colluvium::sweep::{Member, Results, RunState, Sweep, SweepOptions, run as run_all};

use super::{
    Failure, ResultFiles, choose, duration, free_memory,
    kind::{self, Kind},
    largest_memory, print, stop_on_interrupt, threads,
};

#[derive(Args)]
pub struct Arguments {
    /// The file of the sweep.
    file: PathBuf,
    /// Runs at a time; by default as many as there are cores for their threads.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Threads of each run. Results do not depend on it.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// Say what would be run, and run nothing.
    #[arg(long)]
    check: bool,
    #[command(flatten)]
    files: ResultFiles,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let files = &arguments.files;
    kind::expect(&arguments.file, Kind::Sweep)?;
    let (sweep, members) = Sweep::load(&arguments.file)?;
    let Some(first) = members.first() else { return Ok(()) };
    let method = choose(&first.case, sweep.method.as_deref())?;
    let jobs = arguments.jobs.map_or_else(|| threads() / usize::from(arguments.threads), usize::from).max(1);
    let (mut plans, free) = (Vec::new(), free_memory());
    for (number, Member { values, case }) in members.iter().enumerate() {
        let plan = || {
            let size = method.size(case)?;
            size.fit(free)?;
            if let Some(ahead) = size.beforehand().filter(|_| !files.quiet) {
                complain!("note: {}: {ahead}", sweep.describe(number, values));
            }
            method.plan(case)
        };
        plans.push(plan().map_err(|error| sweep.of_run(number, values, error.into()))?);
    }
    let names = column_names(&first.case, &*method.build(&first.case)?);
    sweep.check_columns(&names)?;
    if !files.quiet {
        say_what(&sweep, &members, &plans, jobs * usize::from(arguments.threads))?;
        tell_memory(&plans, jobs, free)?;
    }
    if arguments.check {
        return Ok(());
    }
    let options = SweepOptions {
        out: files.folder(&arguments.file, method.name()),
        jobs,
        threads: arguments.threads.into(),
        resume: files.resume,
        overwrite: files.overwrite,
        stop: stop_on_interrupt(),
        commit: colluvium::COMMIT.map(str::to_owned),
    };
    let tell = |number: usize, state: &RunState| {
        let (run, quiet) = (sweep.describe(number, &members[number].values), files.quiet);
        let state = match state {
            RunState::Failed(why) => return complain!("error: {run}: {}", why.replace('\n', "; ")),
            _ if quiet => return,
            RunState::Kept => "complete already",
            RunState::Completed => "completed",
            RunState::Interrupted => "interrupted",
        };
        // Where nobody reads on the program ends; any other failure meets the lines at the end too.
        let _ = print(format_args!("{run}: {state}"));
    };
    let results = run_all(&sweep, &members, method, &options, &tell)?;
    finish(&results, &options, files.quiet)
}

/// What would be run.
fn say_what(sweep: &Sweep, members: &[Member], plans: &[Plan], threads: usize) -> Result<(), Failure> {
    let seconds: f64 = plans.iter().map(Plan::seconds).sum();
    say!("{}", printable(&sweep.title));
    say!("runs           {}", members.len());
    say!("points         {} at most", plans.iter().map(|plan| plan.points).max().unwrap_or(0));
    say!("duration       about {} on {threads} threads", duration(seconds / threads as f64));
    let mut searches = [0.0; 2];
    for (plan, Member { case, .. }) in plans.iter().zip(members) {
        for (_, search) in case.factors_of_safety() {
            let seconds = SearchCost::of(case, plan, search).seconds;
            (0..2).for_each(|which| searches[which] += seconds[which]);
        }
    }
    let [usual, longest] = searches.map(|seconds| seconds / threads as f64);
    if longest.is_nan() {
        say!("searches       for factors of safety come on top: `check` of a case tells of them");
    } else if longest > 0.0 {
        let (usual, longest) = (duration(usual), duration(longest));
        say!("searches       about {usual} on {threads} threads, {longest} at most, beside the duration");
    }
    let warnings = plans.iter().zip(members).flat_map(|(plan, member)| plan.all_warnings(&member.case));
    for warning in warnings.collect::<BTreeSet<_>>() {
        complain!("warning: {warning}");
    }
    Ok(())
}

/// Memory of the largest runs side by side, with that of the program; a warning where there is less.
fn tell_memory(plans: &[Plan], jobs: usize, free: f64) -> Result<(), Failure> {
    let mut runs: Vec<f64> =
        plans.iter().map(|plan| plan.memory as f64 + frame_memory(plan.points)).collect();
    runs.sort_by(|a, b| b.total_cmp(a));
    runs.truncate(jobs);
    // One of the runs has been made by now, and counts in the memory of the program.
    let program = largest_memory().unwrap_or(0) as f64;
    let memory = runs.iter().sum::<f64>().max(program + runs.iter().skip(1).sum::<f64>());
    say!("memory         about {:.1} MB for {} at a time", memory / 1e6, counted(runs.len(), "run"));
    if memory > free {
        complain!(
            "warning: the runs at a time need about {:.2} GB, and {:.2} GB are free: give fewer --jobs",
            memory / 1e9,
            free / 1e9
        );
    }
    Ok(())
}

/// A number with a noun.
fn counted(number: usize, noun: &str) -> String {
    if number == 1 { format!("1 {noun}") } else { format!("{number} {noun}s") }
}

/// What came of it all.
fn finish(results: &Results<'_>, options: &SweepOptions, quiet: bool) -> Result<(), Failure> {
    let orders = results.write_convergence(&options.out)?;
    let count = |status: &str| results.rows.iter().filter(|row| row.status == status).count();
    if !quiet {
        if let Some((number, misfit)) = results.best() {
            let run = results.sweep.describe(number, &results.rows[number].values);
            say!("nearest to the targets: {run}, misfit {misfit:.3}");
        }
        for order in orders {
            say!("{order}");
        }
        say!(
            "{} of {} runs complete; results in {}",
            count("completed"),
            results.rows.len(),
            options.out.display()
        );
    }
    match count("failed") {
        _ if results.rows.iter().any(|row| row.status.is_empty() || row.status == "interrupted") => {
            Err(Failure::Interrupted)
        }
        0 => Ok(()),
        failed => Err(Failure::Other(format!("{failed} of {} runs failed", results.rows.len()))),
    }
}
