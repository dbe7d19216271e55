//! `colluvium specimen`.

use std::path::PathBuf;

use clap::Args;
use colluvium::case::output::write_atomically;
use colluvium::case::run::Ending;
use colluvium::case::{Case, CaseError, RunOptions, run_made};

use super::{Failure, choose, free_memory, pool, stop_on_interrupt};

#[derive(Args)]
pub struct Arguments {
    /// The case file.
    case: PathBuf,
    /// The file to write.
    #[arg(long)]
    out: PathBuf,
    /// The stage after whose end the specimen is taken; the last one by default.
    #[arg(long)]
    until: Option<String>,
    /// The method; needed when the case has options for several.
    #[arg(long)]
    method: Option<String>,
    /// Number of threads; all cores by default. Results do not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Replace an earlier file.
    #[arg(long)]
    overwrite: bool,
    /// Print nothing but errors.
    #[arg(long, short)]
    quiet: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut case = Case::load(&arguments.case)?;
    let method = choose(&case, arguments.method.as_deref())?;
    let (out, quiet) = (&arguments.out, arguments.quiet);
    if out.exists() && !arguments.overwrite {
        return Err(Failure::Usage(format!("{}: is there already: give --overwrite", out.display())));
    }
    if let Some(stage) = &arguments.until {
        end_with(&mut case, stage)?;
    }
    method.size(&case)?.fit(free_memory())?;
    let pool = pool(arguments.threads)?;
    let (plan, solver) = pool.install(|| method.made(&case))?;
    if solver.specimen().is_none() {
        let problem = format!("specimens are of grains with contacts, and {} has none", method.name());
        return Err(Failure::Usage(problem));
    }
    let options = RunOptions {
        method: method.name().to_owned(),
        progress: !quiet,
        keep_specimen: true,
        stop: Some(stop_on_interrupt()),
        warn: (!quiet).then_some(|remark| complain!("warning: {remark}")),
        warnings: plan.all_warnings(&case),
        ..RunOptions::default()
    };
    for warning in options.warnings.iter().filter(|_| !quiet) {
        complain!("warning: {warning}");
    }
    let report = pool.install(|| run_made(method, &case, solver, &options))?;
    if report.ending == Ending::Interrupted {
        return Err(Failure::Other(
            "interrupted before the specimen was ready: nothing is written".to_owned(),
        ));
    }
    let text = report.specimen.unwrap_or_default();
    write_atomically(out, text.as_bytes())?;
    if !quiet {
        let (count, time) = (report.snapshot.ids.len(), report.snapshot.time);
        say!("wrote {count} grains with their contacts at {time:.6} s to {}", out.display());
    }
    Ok(())
}

/// Leaves out what comes after a stage.
fn end_with(case: &mut Case, stage: &str) -> Result<(), Failure> {
    let Some(last) = case.stages.iter().position(|own| own.name == stage) else {
        let names: Vec<&str> = case.stages.iter().map(|own| own.name.as_str()).collect();
        let problem = format!("there is no stage {stage:?}; there are {}", names.join(", "));
        return Err(CaseError::new("stages", problem).into());
    };
    let later: Vec<String> = case.stages.drain(last + 1..).map(|own| own.name).collect();
    for options in case.methods.values_mut() {
        if let Some(stages) = options.get_mut("stages").and_then(|stages| stages.as_object_mut()) {
            stages.retain(|name, _| !later.contains(name));
        }
    }
    Ok(())
}
