//! `colluvium specimen`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::case::output::{OutputError, read_json, write_atomically};
use crate::case::run::{RunEnd, last_state};
use crate::case::{Case, CaseError, Method, Run, RunOptions};
use crate::machine::free_memory;
use crate::run_progress::RunProgress;
use crate::select_method;
use clap::Args;

use super::{
    CommandError, LibraryArguments, check_run_folder, print_warning, stop_on_interrupt, thread_pool,
};
use crate::case::Warning;
use crate::cli::file_kind;
use crate::cli::file_kind::FileKind;

#[derive(Args)]
#[command(after_help = "Usual call:\n  colluvium specimen triaxial.json --until pack --out grains.json")]
pub struct SpecimenArguments {
    /// The case file, or the folder of a run of it, whose final state is taken without a new run.
    case: PathBuf,
    /// The file to write.
    #[arg(long)]
    out: PathBuf,
    /// Stage at whose end the specimen is taken; the last one by default.
    #[arg(long)]
    until: Option<String>,
    /// Name of the method; needed when the case has options for several.
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
    #[command(flatten)]
    pub library: LibraryArguments,
}

/// Prepares a specimen of grains and writes it to a file.
pub fn run(arguments: &SpecimenArguments) -> Result<(), CommandError> {
    let out = &arguments.out;
    if out.exists() && !arguments.overwrite {
        return Err(CommandError::usage(
            "wrong-usage",
            format!("{}: exists already: give --overwrite to replace it", out.display()),
        ));
    }
    let made =
        if arguments.case.is_dir() { specimen_of_run_folder(arguments)? } else { run_case(arguments)? };
    write_atomically(out, made.text.as_bytes())?;
    if !arguments.quiet {
        let PreparedSpecimen { grains, time, .. } = made;
        print_line!("wrote {grains} grains with their contacts at {time:.6} s to {}", out.display());
    }
    Ok(())
}

/// Specimen of grains, as the text of a file.
struct PreparedSpecimen {
    text: String,
    grains: usize,
    /// Time of the run (s).
    time: f64,
}

/// Error for a method without grains.
fn no_grains_error(method: &dyn Method) -> CommandError {
    CommandError::usage(
        "no-contacts",
        format!("a specimen consists of grains with contacts, and {} has none", method.name()),
    )
}

/// Runs the case.
fn run_case(arguments: &SpecimenArguments) -> Result<PreparedSpecimen, CommandError> {
    file_kind::require_kind(&arguments.case, FileKind::Case)?;
    let mut case = Case::from_file(&arguments.case)?;
    let method = select_method(&case, arguments.method.as_deref())?;
    let quiet = arguments.quiet;
    if let Some(stage) = &arguments.until {
        truncate_stages_after(&mut case, stage)?;
    }
    let case = Arc::new(case);
    method.problem_size(&case)?.check_memory(free_memory())?;
    let pool = thread_pool(arguments.threads)?;
    let (plan, solver) = pool.install(|| method.plan_and_build(&case))?;
    if !solver.has_specimen() {
        return Err(no_grains_error(method));
    }
    let progress = Arc::new(RunProgress::default());
    let options = RunOptions {
        method: method.name().to_owned(),
        keep_specimen: true,
        stop_flag: Some(stop_on_interrupt()),
        observer: (!quiet).then(|| progress.observer()),
        warnings: plan.all_warnings(&case),
        ..RunOptions::default()
    };
    options.warnings.iter().filter(|_| !quiet).for_each(print_warning);
    let run = Run::with_plan(Arc::clone(&case), method, solver, options)?;
    let report = pool.install(|| run.finish()).inspect_err(|_| progress.clear())?;
    if report.ending == RunEnd::Interrupted {
        return Err(CommandError::message(
            "interrupted",
            "interrupted before the specimen was ready: nothing is written".to_owned(),
        ));
    }
    let (grains, time) = (report.snapshot.ids.len(), report.snapshot.time);
    Ok(PreparedSpecimen { text: report.specimen.unwrap_or_default(), grains, time })
}

/// Reads the specimen from the folder of a run.
fn specimen_of_run_folder(arguments: &SpecimenArguments) -> Result<PreparedSpecimen, CommandError> {
    let from = arguments.case.as_path();
    check_run_folder(from)?;
    let path = from.join("case.json");
    let case = Case::from_file(&path).map_err(|errors| OutputError::new(&path, errors.first()))?;
    let summary = read_json(&from.join("summary.json"))?;
    let of_run = summary["method"].as_str().unwrap_or_default();
    if let Some(requested) = arguments.method.as_deref().filter(|requested| *requested != of_run) {
        let problem = format!("{}: is a run of {of_run}, not of {requested}", from.display());
        return Err(CommandError::usage("wrong-usage", problem));
    }
    let method = select_method(&case, Some(of_run))?;
    let again = format!("`colluvium specimen {}", path.display());
    if let Some(stage) = &arguments.until {
        truncate_stages_after(&mut case.clone(), stage)?;
        if case.stages.last().is_none_or(|last| last.name != *stage) {
            let problem = format!(
                "{}: contains the end of its last stage only; {again} --until {stage} --out {}` runs the case again to the end of {stage:?}",
                from.display(),
                arguments.out.display()
            );
            return Err(CommandError::usage("wrong-usage", problem));
        }
    }
    let pool = thread_pool(arguments.threads)?;
    let Some(solver) = pool.install(|| last_state(from, method, &case))? else {
        return Err(missing_state_error(from, method, &case, &again)?);
    };
    let Some(text) = solver.specimen() else { return Err(no_grains_error(method)) };
    let status = summary["status"].as_str().unwrap_or("unknown");
    if status != "completed" && !arguments.quiet {
        let (now, end) = (solver.time(), case.end_time());
        print_warning(&Warning::new(
            "specimen-of-checkpoint",
            format!(
                "the run is not complete ({status}): the specimen is that of its last checkpoint, {now} of {end} s. To complete the run, use --resume"
            ),
        ));
    }
    Ok(PreparedSpecimen { text, grains: solver.point_count(), time: solver.time() })
}

/// Error for a folder without the requested state, with the remedy.
fn missing_state_error(
    from: &Path,
    method: &dyn Method,
    case: &Case,
    again: &str,
) -> Result<CommandError, CommandError> {
    if !method.plan_and_build(case)?.1.has_specimen() {
        return Ok(no_grains_error(method));
    }
    Ok(CommandError::message(
        "history-missing",
        format!(
            "{}: checkpoint.bin with the history of the contacts is missing: {again} --out FILE` runs the case again; `colluvium export \
         --points {}` writes grains without contacts",
            from.display(),
            from.display()
        ),
    ))
}

/// Removes the stages after `stage`.
fn truncate_stages_after(case: &mut Case, stage: &str) -> Result<(), CommandError> {
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
