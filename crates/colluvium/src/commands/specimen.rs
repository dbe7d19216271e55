//! `colluvium specimen`.

use std::path::{Path, PathBuf};

use clap::Args;
use colluvium::case::output::{OutputError, read_json, write_atomically};
use colluvium::case::run::{Ending, last_state};
use colluvium::case::{Case, CaseError, Method, RunOptions, run_made};

use super::{
    Failure, a_run, choose, free_memory,
    kind::{self, Kind},
    pool, stop_on_interrupt,
};

#[derive(Args)]
pub struct Arguments {
    /// The case file, or the folder of a run of it, whose end is taken without running again.
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
    let out = &arguments.out;
    if out.exists() && !arguments.overwrite {
        return Err(Failure::Usage(format!("{}: is there already: give --overwrite", out.display())));
    }
    let made = if arguments.case.is_dir() { left(arguments)? } else { prepared(arguments)? };
    write_atomically(out, made.text.as_bytes())?;
    if !arguments.quiet {
        let Made { grains, time, .. } = made;
        say!("wrote {grains} grains with their contacts at {time:.6} s to {}", out.display());
    }
    Ok(())
}

/// A specimen.
struct Made {
    text: String,
    grains: usize,
    /// Time of the run (s).
    time: f64,
}

/// What a method without grains is told.
fn of_grains(method: &dyn Method) -> Failure {
    Failure::Usage(format!("specimens are of grains with contacts, and {} has none", method.name()))
}

/// Runs the case.
fn prepared(arguments: &Arguments) -> Result<Made, Failure> {
    kind::expect(&arguments.case, Kind::Case)?;
    let mut case = Case::load(&arguments.case)?;
    let method = choose(&case, arguments.method.as_deref())?;
    let quiet = arguments.quiet;
    if let Some(stage) = &arguments.until {
        end_with(&mut case, stage)?;
    }
    method.size(&case)?.fit(free_memory())?;
    let pool = pool(arguments.threads)?;
    let (plan, solver) = pool.install(|| method.made(&case))?;
    if !solver.has_specimen() {
        return Err(of_grains(method));
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
    let (grains, time) = (report.snapshot.ids.len(), report.snapshot.time);
    Ok(Made { text: report.specimen.unwrap_or_default(), grains, time })
}

/// Takes what a run has left in its folder.
fn left(arguments: &Arguments) -> Result<Made, Failure> {
    let from = arguments.case.as_path();
    a_run(from)?;
    let path = from.join("case.json");
    let case = Case::load(&path).map_err(|errors| OutputError::new(&path, errors.first()))?;
    let summary = read_json(&from.join("summary.json"))?;
    let of_run = summary["method"].as_str().unwrap_or_default();
    if let Some(asked) = arguments.method.as_deref().filter(|asked| *asked != of_run) {
        let problem = format!("{}: is a run of {of_run}, not of {asked}", from.display());
        return Err(Failure::Usage(problem));
    }
    let method = choose(&case, Some(of_run))?;
    let again = format!("`colluvium specimen {}", path.display());
    if let Some(stage) = &arguments.until {
        end_with(&mut case.clone(), stage)?;
        if case.stages.last().is_none_or(|last| last.name != *stage) {
            let problem = format!(
                "{}: holds the end of its last stage only; {again} --until {stage} --out {}` runs up to that of {stage:?} again",
                from.display(),
                arguments.out.display()
            );
            return Err(Failure::Usage(problem));
        }
    }
    let pool = pool(arguments.threads)?;
    let Some(solver) = pool.install(|| last_state(from, method, &case))? else {
        return Err(nothing_left(from, method, &case, &again)?);
    };
    let Some(text) = solver.specimen() else { return Err(of_grains(method)) };
    let status = summary["status"].as_str().unwrap_or("unknown");
    if status != "completed" && !arguments.quiet {
        let (now, end) = (solver.time(), case.end_time());
        complain!(
            "warning: the run is not complete ({status}): this is its last checkpoint, {now} of {end} s"
        );
    }
    Ok(Made { text, grains: solver.points(), time: solver.time() })
}

/// Why a folder has no state to take, and what to do.
fn nothing_left(from: &Path, method: &dyn Method, case: &Case, again: &str) -> Result<Failure, Failure> {
    if !method.made(case)?.1.has_specimen() {
        return Ok(of_grains(method));
    }
    Ok(Failure::Other(format!(
        "{}: what contacts remember is in checkpoint.bin, which is not there: {again} --out FILE` runs the case again; `colluvium export \
         --points {}` writes grains without contacts",
        from.display(),
        from.display()
    )))
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
