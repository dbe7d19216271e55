//! `colluvium run`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::case::output::{OutputError, read_json};
use crate::case::run::RunEnd;
use crate::case::{Case, Run, RunOptions, RunReport, Warning};
use crate::machine::free_memory;
use crate::output::raster_maps::raster_maps;
use crate::plots::Picture;
use crate::run_progress::RunProgress;
use crate::select_method;
use clap::Args;

use super::{
    CommandError, LibraryArguments, OutputArguments, print_note, print_warning, stop_on_interrupt,
    thread_pool,
};
use crate::cli::file_kind;
use crate::cli::file_kind::FileKind;

#[derive(Args)]
#[command(
    after_help = "Usual calls:\n  colluvium run slope.json\n  colluvium run slope.json --method sph --out slope-sph"
)]
pub struct RunArguments {
    /// The case file.
    case: PathBuf,
    /// Name of the method; needed when the case has options for several.
    #[arg(long)]
    method: Option<String>,
    /// Number of threads; all cores by default. Results do not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    #[command(flatten)]
    files: OutputArguments,
    #[command(flatten)]
    pub library: LibraryArguments,
}

/// Runs a case, and writes its output.
pub fn run(arguments: &RunArguments) -> Result<(), CommandError> {
    let files = &arguments.files;
    file_kind::require_kind(&arguments.case, FileKind::Case)?;
    let case = Arc::new(Case::from_file(&arguments.case)?);
    let method = select_method(&case, arguments.method.as_deref())?;
    let size = method.problem_size(&case)?;
    size.check_memory(free_memory())?;
    if let Some(ahead) = size.size_notice().filter(|_| !files.quiet) {
        print_note(&ahead);
    }
    let out = files.output_folder(&arguments.case, method.name());
    if files.resume && is_complete_without_map(&case, &out) {
        draw_map(&out)?;
        print_line!(
            "the run was complete except for its map, which is now drawn: {}",
            out.join(MAP_FILE).display()
        );
        return Ok(());
    }
    let pool = thread_pool(arguments.threads)?;
    let (plan, solver) = pool.install(|| method.plan_and_build(&case))?;
    let warnings = plan.all_warnings(&case);
    let progress = Arc::new(RunProgress::default());
    let options = RunOptions {
        method: method.name().to_owned(),
        output_folder: Some(out.clone()),
        resume: files.resume,
        overwrite: files.overwrite,
        keep_frames: false,
        keep_specimen: false,
        stop_flag: Some(stop_on_interrupt()),
        observer: (!files.quiet).then(|| progress.observer()),
        commit: crate::COMMIT.map(str::to_owned),
        warnings,
    };
    if !files.quiet {
        options.warnings.iter().for_each(print_warning);
    }
    let run = Run::with_plan(Arc::clone(&case), method, solver, options)?;
    let report = pool.install(|| run.finish()).inspect_err(|_| progress.clear())?;
    report_end(&case, &report, &progress.warnings(), files, &out)
}

/// Draws the map of a run that has ended, and prints its report and the warnings that are not among those `printed`.
fn report_end(
    case: &Case,
    report: &RunReport,
    printed: &[Warning],
    files: &OutputArguments,
    out: &Path,
) -> Result<(), CommandError> {
    if report.ending == RunEnd::Interrupted {
        return Err(CommandError::Interrupted);
    }
    if case.output.rasters.is_some()
        && let Err(problem) = draw_map(out)
    {
        print_warning(&Warning::new(
            "no-map",
            format!("no map is drawn: {problem}. Run again with --resume, which draws it"),
        ));
    }
    if !files.quiet {
        let is_new = |warning: &&Warning| !printed.contains(warning);
        report.warnings_at_end.iter().filter(is_new).for_each(print_warning);
        report.notes.iter().for_each(print_note);
        print_report(report, out)?;
    }
    Ok(())
}

/// Path of the map in the folder of a run.
pub(super) const MAP_FILE: &str = "rasters/map.png";

/// Whether a folder has rasters that a map would be drawn of, and no map.
pub(super) fn is_map_missing(out: &Path) -> bool {
    !out.join(MAP_FILE).exists() && raster_maps(out).is_ok_and(|maps| !maps.is_empty())
}

/// Whether a run of the case is complete in the folder, but was killed before its map was drawn.
fn is_complete_without_map(case: &Case, out: &Path) -> bool {
    let summary = read_json(&out.join("summary.json")).unwrap_or_default();
    let same = summary["fingerprint"] == format!("{:016x}", case.fingerprint()).as_str();
    same && summary["status"] == "completed" && case.output.rasters.is_some() && is_map_missing(out)
}

/// Draws the raster of the run with the highest priority as a map.
fn draw_map(out: &Path) -> Result<(), OutputError> {
    match raster_maps(out)?.first() {
        Some((_, map)) => map.write(&out.join(MAP_FILE)),
        None => Ok(()),
    }
}

/// Prints the number of steps, the duration, and the mass and energy at both ends of a run.
fn print_report(report: &RunReport, out: &Path) -> Result<(), CommandError> {
    print_line!(
        "{} steps to t = {:.6} s in {:.1} s ({:.2} million point-updates per second)",
        report.steps,
        report.snapshot.time,
        report.wall,
        report.updates_per_second / 1e6
    );
    if report.start.mass.is_nan() {
        print_line!("the method does not record totals of mass and energy");
    } else {
        print_line!("mass {:.6} kg, initially {:.6} kg", report.end.mass, report.start.mass);
        print_line!("kinetic energy {:.4e} J, initially {:.4e} J", report.end.kinetic, report.start.kinetic);
    }
    for (name, safety) in &report.safety {
        match safety.note_code() {
            Some(code) => print_line!("note[{code}]: {name}: {}", safety.message()),
            None => print_line!("{name}: {}", safety.message()),
        }
    }
    print_line!("results in {}", out.display());
    Ok(())
}
