//! Comparisons of several methods on one case, with the tolerances of their agreement.

mod aluminium_bars;
mod dam_break;
mod elastic_bar;
mod grain_cell;
mod inclined_block;
mod slide;
mod slope_acads;
mod slope_clays;
mod slope_cut;
mod tipping_block;

use colluvium::case::{Case, RunReport};
use colluvium::compare::{self, CompletedRun, ReferenceProfiles};
use colluvium::output::run_pictures::view_plane_for_gravity;
use colluvium::plots::PointCloud;

use crate::benchmarks::{Benchmark, BenchmarkOutcome, recorder};

/// Benchmarks, in the order of the report.
pub const ALL: &[Benchmark] = &[
    elastic_bar::BENCHMARK,
    grain_cell::BENCHMARK,
    inclined_block::BENCHMARK,
    tipping_block::BENCHMARK,
    dam_break::BENCHMARK,
    aluminium_bars::BENCHMARK,
    slope_cut::BENCHMARK,
    slope_acads::ONE_SOIL,
    slope_acads::THREE_SOILS,
    slope_clays::LAYERS,
    slope_clays::WEAK_LAYER,
    slide::BENCHMARK,
];

/// Runs of one case by several methods, which the page of the benchmark shows side by side.
#[derive(Default)]
struct MethodComparison(Vec<(&'static str, CompletedRun)>);

impl MethodComparison {
    /// Adds the run of a method.
    fn add_run(&mut self, method: &'static str, report: &RunReport) {
        self.0.push((method, CompletedRun::from_report(report)));
    }

    /// Writes the sections of `colluvium compare` into the page, with the reference in the folder `validation/<folder>`.
    fn write_sections(
        &self,
        outcome: &mut BenchmarkOutcome,
        case: &Case,
        folder: &str,
    ) -> Result<(), String> {
        let file = crate::root().join("validation").join(folder).join("case.json");
        let reference = ReferenceProfiles::read_for_case(&file, None, recorder::record_file)
            .map_err(|error| error.to_string())?;
        let runs: Vec<(&'static str, &CompletedRun)> =
            self.0.iter().map(|(method, ran)| (*method, ran)).collect();
        let plane = view_plane_for_gravity(case.gravity.get(2).copied(), None);
        let sections = compare::sections(case, &runs, plane, &reference);
        outcome.comparison = Some(sections.map_err(|error| error.to_string())?);
        Ok(())
    }
}

/// Draws the points at the end of the failing trial with the least factor. `name` is that of the method.
fn draw_failure(outcome: &mut BenchmarkOutcome, name: &str, report: &RunReport) -> Result<(), String> {
    let cloud = report
        .failed_trials
        .get("safety")
        .and_then(|end| PointCloud::from_snapshot(end, "displacement", [0, 1]));
    let Some(cloud) = cloud else { return Ok(()) };
    outcome.png(&format!("{name}: displacement in the failing trial of the least factor."), &cloud)
}
