//! `colluvium run`.

use std::path::{Path, PathBuf};

use clap::Args;
use colluvium::case::output::{OutputError, read_json};
use colluvium::case::run::Ending;
use colluvium::case::{Case, RunOptions, RunReport};
use colluvium::maps::maps;
use colluvium::plots::Picture;

use super::{
    Failure, ResultFiles, choose, free_memory,
    kind::{self, Kind},
    pool, stop_on_interrupt,
};

#[derive(Args)]
pub struct Arguments {
    /// The case file.
    case: PathBuf,
    /// The method; needed when the case has options for several.
    #[arg(long)]
    method: Option<String>,
    /// Number of threads; all cores by default. Results do not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    #[command(flatten)]
    files: ResultFiles,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let files = &arguments.files;
    kind::expect(&arguments.case, Kind::Case)?;
    let case = Case::load(&arguments.case)?;
    let method = choose(&case, arguments.method.as_deref())?;
    let size = method.size(&case)?;
    size.fit(free_memory())?;
    if let Some(ahead) = size.beforehand().filter(|_| !files.quiet) {
        complain!("note: {ahead}");
    }
    let out = files.folder(&arguments.case, method.name());
    if files.resume && ended_without_map(&case, &out) {
        draw_map(&out)?;
        say!("the run was complete but for its map: {}", out.join(MAP).display());
        return Ok(());
    }
    let pool = pool(arguments.threads)?;
    let (plan, solver) = pool.install(|| method.made(&case))?;
    let warnings = plan.all_warnings(&case);
    let options = RunOptions {
        method: method.name().to_owned(),
        out: Some(out.clone()),
        resume: files.resume,
        overwrite: files.overwrite,
        progress: !files.quiet,
        keep_frames: false,
        keep_specimen: false,
        stop: Some(stop_on_interrupt()),
        commit: colluvium::COMMIT.map(str::to_owned),
        warn: (!files.quiet).then_some(|remark| complain!("warning: {remark}")),
        warnings,
    };
    if !files.quiet {
        for warning in &options.warnings {
            complain!("warning: {warning}");
        }
    }
    let report = pool.install(|| colluvium::case::run_made(method, &case, solver, &options))?;
    if report.ending == Ending::Interrupted {
        return Err(Failure::Interrupted);
    }
    if case.output.rasters.is_some()
        && let Err(problem) = draw_map(&out)
    {
        complain!("warning: no map is drawn: {problem}");
    }
    if !files.quiet {
        for remark in report.remarks.iter().filter(|remark| !report.said.contains(remark)) {
            complain!("warning: {remark}");
        }
        for fact in &report.facts {
            complain!("note: {fact}");
        }
        print(&report, &out)?;
    }
    Ok(())
}

/// Place of the map in the folder of a run.
pub(super) const MAP: &str = "rasters/map.png";

/// Whether a folder holds rasters of which a map would be drawn, and no map.
pub(super) fn lacks_map(out: &Path) -> bool {
    !out.join(MAP).exists() && maps(out).is_ok_and(|maps| !maps.is_empty())
}

/// Whether a run of the case is complete in the folder, but was killed before its map was drawn.
fn ended_without_map(case: &Case, out: &Path) -> bool {
    let summary = read_json(&out.join("summary.json")).unwrap_or_default();
    let same = summary["fingerprint"] == format!("{:016x}", case.fingerprint()).as_str();
    same && summary["status"] == "completed" && case.output.rasters.is_some() && lacks_map(out)
}

/// Draws the most telling raster of the run beside the rasters.
fn draw_map(out: &Path) -> Result<(), OutputError> {
    match maps(out)?.first() {
        Some((_, map)) => map.write(&out.join(MAP)),
        None => Ok(()),
    }
}

fn print(report: &RunReport, out: &Path) -> Result<(), Failure> {
    say!(
        "{} steps to t = {:.6} s in {:.1} s ({:.2} million point-updates per second)",
        report.steps,
        report.snapshot.time,
        report.wall,
        report.updates_per_second / 1e6
    );
    if report.start.mass.is_nan() {
        say!("the method keeps no totals of mass and energy");
    } else {
        say!("mass {:.6} kg, from {:.6} kg", report.end.mass, report.start.mass);
        say!("kinetic energy {:.4e} J, from {:.4e} J", report.end.kinetic, report.start.kinetic);
    }
    for (name, safety) in &report.safety {
        say!("{name}: {}", safety.told());
    }
    say!("results in {}", out.display());
    Ok(())
}
