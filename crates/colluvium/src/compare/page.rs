//! Page of a comparison: pictures, charts and tables.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::charts::{self, MethodRuns, frames_at};
use super::{CompareError, CompletedRun, MethodOutcome, MethodResult, ReferenceProfiles, completed_runs};
use crate::case::{Case, Snapshot};
use crate::compare::key_figures::{CaseAxes, KeyFigures, ProfileColumns, five_digits};
use crate::compare::plan_cells::{PlanCells, displaced_share};
use crate::compare::reference_profiles::distance_to;
use crate::output::animation;
use crate::output::rigid_geometry::rigid_geometry;
use crate::plots::{Animation, CommonScales, LineChart, Panel, Picture, PointCloud, RigidGeometry, View};
use crate::report::page::coded;

/// Number of times at which pictures are shown.
const PICTURE_TIMES: usize = 5;
/// Approximate size of the animation (bytes).
const ANIMATION_BYTES: usize = 800_000;
/// Number of times at which surface profiles are shown.
const PROFILE_TIMES: usize = 4;

/// Style sheet of the page of a comparison, beside [`SECTIONS_STYLE`].
const PAGE_STYLE: &str = "
body { font: 15px/1.5 system-ui, sans-serif; color: #1d2733; max-width: 1400px; margin: 0 auto; padding: 28px 20px 60px; }
h1 { margin: 0 0 6px; font-size: 27px; } h2 { margin: 34px 0 8px; font-size: 19px; } h3 { margin: 12px 0 4px; font-size: 15px; }
table { border-collapse: collapse; font-size: 13.5px; }
td, th { text-align: left; padding: 4px 18px 4px 0; vertical-align: top; border-bottom: 1px solid #dde3e9; }
th { color: #5c6b7a; } td.number { font-variant-numeric: tabular-nums; white-space: nowrap; } .failed { color: #c0392b; }
.soft { color: #5c6b7a; }
";

/// Style sheet of [`sections`], for any page that has them.
pub const SECTIONS_STYLE: &str = "
.wide { overflow-x: auto; } .strip { display: grid; gap: 6px; } .strip img { width: 100%; height: auto; }
.charts { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(420px, 100%), 1fr)); gap: 10px; }
.charts svg { width: 100%; height: auto; }
";

/// Page that compares the results of the methods.
pub(super) fn page(
    case: &Case,
    results: &[MethodResult],
    plane: [usize; 2],
    reference: &ReferenceProfiles,
) -> Result<Markup, CompareError> {
    let runs = completed_runs(results);
    Ok(html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width";
                title { (case.title) ": comparison of methods" }
                style { (PreEscaped(PAGE_STYLE)) (PreEscaped(SECTIONS_STYLE)) }
            }
            body {
                h1 { (case.title) }
                @if !case.notes.is_empty() { p class="soft" { @for note in &case.notes { (note) " " } } }
                (run_sections(case, &runs, plane, reference)?)
                (difference_table(results, &runs, CaseAxes::of_case(case), reference))
                (method_table(results))
                (safety_table(case, &runs))
                (measure_section(&runs)?)
            }
        }
    })
}

/// Sections with pictures, animation and charts that compare runs of a case, for any page with [`SECTIONS_STYLE`].
///
/// # Errors
/// When a picture cannot be drawn.
pub fn sections(
    case: &Case,
    runs: &[(&'static str, &CompletedRun)],
    plane: [usize; 2],
    reference: &ReferenceProfiles,
) -> Result<String, CompareError> {
    let own = html! { (run_sections(case, runs, plane, reference)?) (difference_table(&[], runs, CaseAxes::of_case(case), reference)) };
    Ok(own.into_string())
}

/// Sections with pictures, animation, and charts of profiles, key figures and energies.
fn run_sections(
    case: &Case,
    runs: &MethodRuns<'_>,
    plane: [usize; 2],
    reference: &ReferenceProfiles,
) -> Result<Markup, CompareError> {
    let (axes, ground) = (CaseAxes::of_case(case), rigid_geometry(case));
    let strip = picture_strip(runs, plane, &ground)?;
    let player = animation_html(case, runs, plane, ground);
    let profiles = charts_to_svg(&charts::profile_charts(runs, axes, PROFILE_TIMES, reference))?;
    let figures = charts_to_svg(&charts::key_figure_charts(runs, axes))?;
    let energies = charts_to_svg(&charts::energy_charts(runs))?;
    Ok(html! {
        (strip)
        @if let Some(player) = &player {
            h2 { "Animation" }
            p class="soft" { "All methods at equal times, with a common colour scale and common axes." }
            (PreEscaped(player))
        }
        @if !profiles.is_empty() {
            h2 { "Profiles at equal times" }
            p class="soft" {
                "Highest point in each column; the columns are equal for all methods"
                @if !reference.profiles.is_empty() { ". The reference is shown at the frames nearest to its times" } "."
            }
            div class="charts" { @for chart in &profiles { div { (PreEscaped(chart)) } } }
        }
        @if !figures.is_empty() {
            h2 { "Key figures over time" }
            p class="soft" { "Measured from the frames, in the same way for all methods." }
            div class="charts" { @for chart in &figures { div { (PreEscaped(chart)) } } }
        }
        @if !energies.is_empty() {
            h2 { "Energy budget" }
            div class="charts" { @for chart in &energies { div { (PreEscaped(chart)) } } }
        }
    })
}

/// Section with charts of the measures of the case and of totals over time.
fn measure_section(runs: &MethodRuns<'_>) -> Result<Markup, CompareError> {
    let measures = charts_to_svg(&charts::measure_charts(runs))?;
    Ok(html! {
        @if !measures.is_empty() {
            h2 { "Measures of the case, and totals" }
            div class="charts" { @for chart in &measures { div { (PreEscaped(chart)) } } }
        }
    })
}

/// SVG elements of charts.
fn charts_to_svg(charts: &[LineChart]) -> Result<Vec<String>, CompareError> {
    charts.iter().map(|chart| chart.to_svg().map_err(CompareError::Picture)).collect()
}

/// Animation of all runs with one slider.
fn animation_html(
    case: &Case,
    runs: &MethodRuns<'_>,
    plane: [usize; 2],
    ground: RigidGeometry,
) -> Option<String> {
    let mut panels: Vec<Panel<'_>> = Vec::new();
    for (method, ran) in runs {
        panels.push(Panel {
            name: (*method).to_owned(),
            frames: ran.frames.iter().collect(),
            frame_count: ran.frames.len(),
        });
    }
    let text = serde_json::to_value(case).ok()?;
    let view = View { ground, bytes: ANIMATION_BYTES, ..animation::view(&text, plane, &[]) };
    Some(animation::player_html(&Animation::from_panels(&panels, &view)?))
}

/// Field that colours the points, which every run must have.
fn common_field(states: &[(&'static str, &Snapshot)]) -> Option<&'static str> {
    let all = |name: &&'static str| states.iter().all(|(_, snapshot)| snapshot.field(name).is_some());
    ["displacement", "velocity"].into_iter().find(all)
}

/// Pictures of all runs at equal times, one row for each time, with a common colour scale and common axes.
fn picture_strip(
    runs: &MethodRuns<'_>,
    plane: [usize; 2],
    ground: &RigidGeometry,
) -> Result<Markup, CompareError> {
    let times = charts::sampled_times(runs, PICTURE_TIMES);
    let rows: Vec<_> = times.iter().map(|time| frames_at(runs, *time)).collect();
    let Some(field) = rows.first().and_then(|states| common_field(states)) else { return Ok(html! {}) };
    let cloud = |snapshot: &Snapshot| {
        PointCloud::from_snapshot(snapshot, field, plane)
            .map(|cloud| PointCloud { lines: ground.lines_at(snapshot.time), ..cloud })
    };
    let clouds: Vec<Vec<Option<PointCloud>>> =
        rows.iter().map(|states| states.iter().map(|(_, snapshot)| cloud(snapshot)).collect()).collect();
    let shared = CommonScales::of_clouds(clouds.iter().flatten().flatten());
    let picture = |cloud: &PointCloud, method: &str| -> Result<Markup, CompareError> {
        let cloud = PointCloud { shared_scales: Some(shared.clone()), ..cloud.clone() };
        let alt = format!("{method}, {}", cloud.title);
        crate::report::png(&cloud, &alt)
            .map(PreEscaped)
            .map_err(|error| CompareError::Picture(error.to_string()))
    };
    let mut cells = Vec::new();
    for (states, clouds) in rows.iter().zip(&clouds) {
        for ((method, _), cloud) in states.iter().zip(clouds) {
            cells.push(match cloud {
                Some(cloud) => picture(cloud, method)?,
                None => html! { p { "no points left" } },
            });
        }
    }
    Ok(html! {
        h2 { "At equal times" }
        p class="soft" { "Common colour scale (" (field) ") and common axes." }
        div class="wide" {
            div class="strip" style=(format!("grid-template-columns: repeat({}, minmax(240px, 1fr))", runs.len())) {
                @for (method, _) in runs { h3 { (method) } }
                @for cell in &cells { div { (cell) } }
            }
        }
    })
}

/// Differences of the final states: of their masses in plan from the first method, and of their surface profiles from the reference.
struct FinalDifferences<'a> {
    axes: CaseAxes,
    cells: Option<PlanCells>,
    first: Vec<f64>,
    columns: Option<ProfileColumns>,
    reference: Option<&'a Vec<(f64, f64)>>,
}

impl<'a> FinalDifferences<'a> {
    /// Differences of several states from the first of them and from a reference, in common cells and columns.
    fn new(snapshots: &[&Snapshot], axes: CaseAxes, measured: Option<&'a Vec<(f64, f64)>>) -> Self {
        let cells = PlanCells::spanning(snapshots, axes);
        let first = cells.as_ref().zip(snapshots.first()).map(|(cells, snapshot)| cells.masses(snapshot));
        let columns = ProfileColumns::spanning(snapshots, axes);
        Self { axes, cells, first: first.unwrap_or_default(), columns, reference: measured }
    }

    /// Share of the mass that is at another place in plan than in the first state.
    fn displaced_share(&self, snapshot: &Snapshot) -> f64 {
        let masses = self.cells.as_ref().map(|cells| cells.masses(snapshot));
        masses.map_or(f64::NAN, |masses| displaced_share(&self.first, &masses))
    }

    /// Distance of a surface profile from the reference. Columns without points have the height zero, as references have beyond the deposit.
    fn distance_to_reference(&self, snapshot: &Snapshot) -> f64 {
        let heights = |columns: ProfileColumns| {
            let profile = columns.profile(snapshot, self.axes);
            profile
                .into_iter()
                .map(|(x, height)| (x, if height.is_nan() { 0.0 } else { height }))
                .collect::<Vec<_>>()
        };
        let profile = self.columns.map(heights);
        let pair = self.reference.zip(profile);
        pair.map_or(f64::NAN, |(measured, own)| distance_to(measured, &own))
    }
}

/// Row of the table of differences: the final state of a method, with its memory (MiB) where it is known.
fn difference_row(
    method: &str,
    ran: &CompletedRun,
    snapshot: &Snapshot,
    apart: &FinalDifferences<'_>,
    memory: Option<String>,
) -> Markup {
    let figures = KeyFigures::of_snapshot(snapshot, apart.axes);
    let value = |pick: fn(&KeyFigures) -> f64| five_digits(figures.as_ref().map_or(f64::NAN, pick));
    html! {
        tr {
            td { (method) }
            td class="number" { (value(|f| f.front)) }
            td class="number" { (value(|f| f.top)) }
            td class="number" { (value(|f| f.centre[0])) ", " (value(|f| f.centre[1])) }
            td class="number" { (value(|f| f.speed)) }
            td class="number" { (five_digits(ran.time_at_rest().unwrap_or(f64::NAN))) }
            td class="number" { (format!("{:.2} %", 100.0 * apart.displaced_share(snapshot))) }
            @if apart.reference.is_some() {
                td class="number" { (format!("{:.2} %", 100.0 * apart.distance_to_reference(snapshot))) }
            }
            td class="number" { (five_digits(ran.kinetic_energy)) }
            td class="number" { (ran.points) }
            td class="number" { (ran.steps) }
            td class="number" { (format!("{:.1}", ran.wall_time)) }
            td class="number" { (format!("{:.2} million", ran.updates_per_second() / 1e6)) }
            @if let Some(memory) = memory { td class="number" { (memory) } }
        }
    }
}

/// Table of the differences between the final states.
fn difference_table(
    results: &[MethodResult],
    runs: &MethodRuns<'_>,
    axes: CaseAxes,
    reference: &ReferenceProfiles,
) -> Markup {
    let common = charts::common_times(runs);
    let measured = common.last().and_then(|end| reference.nearest_profile(*end, &common));
    let memory = |method: &str| {
        let found = results.iter().find(|result| result.method == method);
        five_digits(found.map_or(f64::NAN, |result| result.estimated_memory / f64::from(1 << 20)))
    };
    let mut last: Vec<(&'static str, &CompletedRun, &Snapshot)> = Vec::new();
    for (method, ran) in runs {
        last.extend(ran.frames.last().map(|snapshot| (*method, *ran, snapshot)));
    }
    let apart = FinalDifferences::new(
        &last.iter().map(|(.., snapshot)| *snapshot).collect::<Vec<_>>(),
        axes,
        measured,
    );
    let head = last.first().map_or("", |(method, ..)| *method);
    html! {
        @if !last.is_empty() {
            h2 { "At the end" }
            div class="wide" { table {
                tr {
                    th { "Method" } th { "Front (m)" } th { "Top (m)" } th { "Centre of mass (m)" } th { "Speed (m/s)" } th { "At rest since (s)" }
                    th { "Mass at another place than in " (head) }
                    @if measured.is_some() { th { "Profile, difference from the reference" } }
                    th { "Kinetic energy (J)" } th { "Points" } th { "Steps" }
                    th { "Run time (s)" } th { "Updates per second" } @if !results.is_empty() { th { "Memory (MiB)" } }
                }
                @for (method, ran, snapshot) in &last {
                    (difference_row(method, ran, snapshot, &apart, (!results.is_empty()).then(|| memory(method))))
                }
            } }
            p class="soft" {
                "Front, top and speed refer to 99.9 % of the mass; the speed is grid_velocity where the frames have it. At rest: the kinetic energy stays below a hundredth of its largest value. \
                 Mass at another place: half the sum of the differences of mass in cells in plan, over the mass of the first method. \
                 Mass that a method lacks counts half."
                @if measured.is_some() { " Difference of profiles: root mean square of the difference over that of the reference." }
                @if !results.is_empty() { " Memory: least memory, estimated by the method." }
            }
        }
    }
}

/// Table of all methods, with the options chosen for each and its outcome.
fn method_table(results: &[MethodResult]) -> Markup {
    html! {
        h2 { "Methods" }
        table {
            tr { th { "Method" } th { "Result" } th { "Discretisation" } th { "Warnings" } }
            @for MethodResult { method, chosen_options: took, outcome, .. } in results {
                tr class=(if matches!(outcome, MethodOutcome::Failed { .. }) { "failed" } else { "" }) {
                    td { (method) }
                    td {
                        @match outcome {
                            MethodOutcome::Refused(why) => { "does not support this case: " (why) }
                            MethodOutcome::Failed { reason, .. } => { "failed: " (reason) }
                            MethodOutcome::Interrupted => { "interrupted; continue with --resume" }
                            MethodOutcome::Completed(_) => { "completed" }
                        }
                    }
                    td { @if took.is_empty() { "from the case" } @else { (took) } }
                    td {
                        @if let MethodOutcome::Completed(report) = outcome {
                            @for remark in &report.warnings { (coded(remark)) br; }
                        }
                    }
                }
            }
        }
    }
}

/// Table of factors of safety.
fn safety_table(case: &Case, runs: &MethodRuns<'_>) -> Markup {
    let names: Vec<&str> = case.factors_of_safety().map(|(name, _)| name).collect();
    let found =
        |ran: &CompletedRun, name: &str| match ran.safety_factors.iter().find(|(known, ..)| known == name) {
            None => "–".to_owned(),
            Some((_, [stable, failed], true)) => {
                format!("undecided (stable at {stable:.3}, failed at {failed:.3})")
            }
            Some((_, [stable, failed], _)) if *stable == 0.0 => format!("below {failed:.3}"),
            Some((_, [stable, failed], _)) if failed.is_infinite() => format!("above {stable:.3}"),
            Some((_, [stable, failed], _)) => {
                format!("{:.3} ({stable:.3} to {failed:.3})", 0.5 * (stable + failed))
            }
        };
    html! {
        @if !names.is_empty() {
            h2 { "Factors of safety" }
            table {
                tr { th { "Method" } @for name in &names { th { (name) } } }
                @for (method, ran) in runs {
                    tr { td { (method) } @for name in &names { td { (found(ran, name)) } } }
                }
            }
        }
    }
}
