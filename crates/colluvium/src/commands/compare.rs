//! `colluvium compare`.

use std::path::PathBuf;

use clap::Args;
use colluvium::case::Case;
use colluvium::compare::{self, CompareOptions, Contender, Outcome, Reference};
use colluvium::pictures::plane_under;

use super::{
    Failure, ResultFiles, free_memory,
    kind::{self, Kind},
    pool, print, stop_on_interrupt,
};

#[derive(Args)]
pub struct Arguments {
    /// The case file.
    case: PathBuf,
    /// The methods, by name and separated by commas; all that can honour the case when absent.
    #[arg(long, value_delimiter = ',')]
    methods: Vec<String>,
    /// Number of threads; all cores by default. Results do not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Methods at a time, each on its share of the threads. One after the other when absent: times taken are then those of all threads.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: u16,
    /// CSV file of profiles to compare with: columns position and height (m), and time (s) where there are several; the file
    /// `reference.csv` beside the case when absent, where there is one.
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,
    /// The two axes seen; xy when absent, and xz in three dimensions with gravity along z.
    #[arg(long, value_parser = ["xy", "xz", "yz"])]
    view: Option<String>,
    #[command(flatten)]
    files: ResultFiles,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let files = &arguments.files;
    kind::expect(&arguments.case, Kind::Case)?;
    let case = Case::load(&arguments.case)?;
    let methods = compare::methods(&arguments.methods)?;
    let quiet = files.quiet;
    let reference = Reference::of(&arguments.case, arguments.reference.as_deref(), |file| {
        if !quiet {
            let _ = print(format_args!("reference: {}", file.display()));
        }
    })?;
    let out = files.folder(&arguments.case, "compare");
    let options = CompareOptions {
        out: out.clone(),
        resume: files.resume,
        overwrite: files.overwrite,
        progress: !files.quiet,
        jobs: arguments.jobs.into(),
        free_memory: free_memory(),
        stop: Some(stop_on_interrupt()),
        commit: colluvium::COMMIT.map(str::to_owned),
        warn: (!files.quiet).then_some(|remark| complain!("warning: {remark}")),
    };
    let pool = pool(arguments.threads)?;
    let results = pool.install(|| compare::run(&case, &methods, &options, &|result| tell(result, quiet)))?;
    if results.iter().any(|result| matches!(result.outcome, Outcome::Interrupted)) {
        return Err(Failure::Interrupted);
    }
    let plane = plane_under(case.gravity.get(2).copied(), arguments.view.as_deref());
    let page = compare::write(&out, &case, &results, plane, &reference)?;
    say!("comparison: {}", page.display());
    let failed = |result: &&Contender| matches!(result.outcome, Outcome::Failed(_));
    match results.iter().filter(failed).count() {
        0 => Ok(()),
        _ => Err(Failure::Other("not every method that began came to its end".to_owned())),
    }
}

/// Says what came of a method, and what was chosen for it.
fn tell(result: &Contender, quiet: bool) {
    let Contender { method, took, outcome, .. } = result;
    let line = match outcome {
        Outcome::Failed(why) => return complain!("error: {method}: {}", why.replace('\n', "; ")),
        _ if quiet => return,
        Outcome::Refused(why) => format!("{method}: not for this case: {why}"),
        Outcome::Interrupted => format!("{method}: interrupted"),
        Outcome::Done(report) => format!("{method}: {} steps in {:.1} s", report.steps, report.wall),
    };
    let chosen = if took.is_empty() { String::new() } else { format!("; it took {took}") };
    // Where nobody reads on the program ends; any other failure meets the last line too.
    let _ = print(format_args!("{line}{chosen}"));
}
