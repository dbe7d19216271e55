//! Report of a run: one page that needs no other file.

pub(crate) mod page;
mod parameters;
mod safety_factors;
mod tables;
mod value_text;

use std::path::{Path, PathBuf};

use serde_json::Value;
use thiserror::Error;

use crate::case::Snapshot;
use crate::case::Warning;
use crate::case::output::{
    Collection, DerivedFiles, OutputError, Table, named_file, read_json, write_atomically,
};
use crate::output::animation;
use crate::output::rigid_geometry::rigid_geometry_of_run;
use crate::output::run_pictures;
use crate::plots::{
    Animation, CommonScales, LineChart, Panel, Picture, PointCloud, RigidGeometry, Series, Style, TerrainMap,
    View,
};

/// Name of the report in the folder of its run.
pub const REPORT_FILE: &str = "report.html";

/// Options of a report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReportOptions {
    /// Fields that colour the points; displacement and velocity, as far as the frames have them, when empty.
    pub fields: Vec<String>,
    /// Number of frames of each field that are shown, including the first and the last one.
    pub frames: usize,
    /// The two axes of the view.
    pub plane: [usize; 2],
    /// Whether to replace a file of the report's name that no report wrote.
    pub overwrite: bool,
}

impl Default for ReportOptions {
    fn default() -> Self {
        Self { fields: Vec::new(), frames: 4, plane: [0, 1], overwrite: false }
    }
}

/// Failure of a report.
#[derive(Debug, Error)]
pub enum ReportError {
    /// A file could not be written or read.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The folder is not that of a run.
    #[error("{}: contains no run (summary.json is missing)", .0.display())]
    NoRun(PathBuf),
    /// The frames do not have the field.
    #[error("the frames have no field {name:?}; there are {available}")]
    Field {
        /// The requested field.
        name: String,
        /// The available fields.
        available: String,
    },
    /// A picture could not be drawn.
    #[error("picture of {subject}: {problem}")]
    Picture {
        /// Subject of the picture.
        subject: String,
        /// Description of the problem.
        problem: String,
    },
}

impl ReportError {
    /// Stable code of the error, which `docs/messages.md` of the repository explains.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Output(error) => error.code,
            Self::NoRun(_) => "not-a-run-folder",
            Self::Field { .. } => "field-missing",
            Self::Picture { .. } => "picture",
        }
    }
}

/// Results of a run, complete or not.
struct RunResults {
    summary: Value,
    case: Value,
    /// Measures over time; empty before the first row.
    measures: Table,
    /// Times (s) and files of the frames.
    frames: Vec<(f64, String)>,
    /// Profiles by name, each with columns time, position and height.
    profiles: Vec<(String, Table)>,
    /// Messages about missing or unreadable files, each with the part that the report lacks.
    missing_files: Vec<Warning>,
}

/// Report that was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// Path of the page.
    pub file: PathBuf,
    /// Files that are missing, changed or unreadable, and the parts that the page lacks without them.
    pub missing_files: Vec<Warning>,
}

impl RunResults {
    /// Reads the summary, case, measures and frames of a run.
    fn read(folder: &Path) -> Result<Self, ReportError> {
        let summary = folder.join("summary.json");
        if !summary.exists() {
            return Err(ReportError::NoRun(folder.to_owned()));
        }
        let summary = read_json(&summary)?;
        let case = match &summary["case"] {
            Value::Null => read_json(&folder.join("case.json"))?,
            case => case.clone(),
        };
        let mut missing = Vec::new();
        let table = Table::read(&folder.join("measures.csv")).map(run_pictures::without_rounding_noise);
        let table = table.unwrap_or_else(|error| {
            missing.push(Warning::new(
                "results-missing",
                format!("{error}: the report does not show the measures"),
            ));
            Table::default()
        });
        let frames = Collection::read(&folder.join("frames.pvd")).map(|collection| collection.frames);
        let frames = frames.unwrap_or_else(|error| {
            missing
                .push(Warning::new("results-missing", format!("{error}: the report does not show frames")));
            Vec::new()
        });
        let mut profiles = Vec::new();
        for (name, measure) in case["measures"].as_object().into_iter().flatten() {
            let file = named_file(folder, &format!("profile-{name}"), "csv")?;
            if measure["kind"] == "profile" && file.exists() {
                profiles.push((name.clone(), Table::read(&file)?));
            }
        }
        Ok(Self { summary, case, measures: table, frames, profiles, missing_files: missing })
    }

    /// Whether the case requests a column of the measures.
    fn is_requested(&self, column: &str) -> bool {
        let measures = self.case["measures"].as_object().into_iter().flatten();
        measures.into_iter().any(|(name, _)| {
            column.strip_prefix(&**name).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        })
    }

    /// Whether all stages and searches are complete.
    fn is_complete(&self) -> bool {
        self.summary["status"] == "completed"
    }
}

/// Picture with its caption.
struct ReportFigure {
    /// HTML or SVG element.
    element: String,
    caption: String,
}

/// Pictures of a report.
struct ReportPictures {
    /// Animation of the points; `None` before the second frame.
    animation: Option<String>,
    points: Vec<ReportFigure>,
    /// Measures and profiles that the case requests.
    requested_charts: Vec<ReportFigure>,
    charts: Vec<ReportFigure>,
    maps: Vec<ReportFigure>,
    safety: Vec<ReportFigure>,
}

/// Prefixes of the names of columns that describe the progress of a run rather than its results. These columns come last.
const RUN_COLUMN_PREFIXES: [&str; 6] =
    ["time_step", "kinetic_energy", "momentum", "angular_momentum", "mass", "points"];

/// Largest number of frames read for the animation.
const MAX_PLAYER_FRAMES: usize = 80;

/// Writes the report of the run in `folder`, complete or not, into that folder.
///
/// # Errors
/// When the folder has no run, its summary, case or a frame cannot be read, a field is not in the frames, or a file that no report wrote
/// has the report's name.
pub fn write(folder: &Path, options: &ReportOptions) -> Result<Report, ReportError> {
    let mut results = RunResults::read(folder)?;
    let mut files = DerivedFiles::open(folder, options.overwrite)?;
    files.check(REPORT_FILE)?;
    let ground = rigid_geometry_of_run(folder);
    if !ground.missing.is_empty() {
        results.missing_files.push(Warning::new(
            "results-missing",
            format!("{}: the pictures do not show terrain and obstacles", ground.missing),
        ));
    }
    let (requested, charts) = charts(&results)?;
    let pictures = ReportPictures {
        points: points(folder, &results, options, &ground)?,
        animation: animation_player(folder, &results, options, ground)?,
        requested_charts: requested,
        charts,
        maps: maps(folder)?,
        safety: safety_factors::safety_figures(folder, &results, options.plane)?,
    };
    let page = page::page(&results, &pictures).into_string();
    files.write(REPORT_FILE, |file| write_atomically(file, page.as_bytes()))?;
    Ok(Report { file: folder.join(REPORT_FILE), missing_files: results.missing_files })
}

/// Indices of at most `wanted` of `count` frames, evenly spaced from the first to the last.
pub(crate) fn evenly_spaced_frames(count: usize, wanted: usize) -> Vec<usize> {
    let shown = wanted.min(count);
    let last = count.saturating_sub(1);
    match shown {
        0 => Vec::new(),
        1 => vec![last],
        _ => (0..shown).map(|k| (k * last + (shown - 1) / 2) / (shown - 1)).collect(),
    }
}

/// Animation of the frames.
fn animation_player(
    folder: &Path,
    results: &RunResults,
    options: &ReportOptions,
    ground: RigidGeometry,
) -> Result<Option<String>, ReportError> {
    let read = |number| run_pictures::read_collection_frame(folder, &results.frames[number]);
    let mut frames: Vec<Snapshot> = evenly_spaced_frames(results.frames.len(), MAX_PLAYER_FRAMES)
        .into_iter()
        .map(read)
        .collect::<Result<_, _>>()?;
    frames.iter_mut().for_each(|frame| run_pictures::set_force_units(&mut frame.fields, &results.case));
    let name = results.summary["method"].as_str().unwrap_or("points").to_owned();
    let panel = Panel { name, frames: frames.iter().collect(), frame_count: results.frames.len() };
    let view = View { ground, ..animation::view(&results.case, options.plane, &options.fields) };
    Ok(Animation::from_panels(&[panel], &view).map(|animation| animation::player_html(&animation)))
}

/// Pictures of the points of some frames. They are PNG, because in SVG each point is an element. All pictures of a field have one scale of
/// colours and one set of axes.
fn points(
    folder: &Path,
    results: &RunResults,
    options: &ReportOptions,
    ground: &RigidGeometry,
) -> Result<Vec<ReportFigure>, ReportError> {
    let mut clouds: Vec<(String, Vec<(String, PointCloud)>)> = Vec::new();
    for number in evenly_spaced_frames(results.frames.len(), options.frames) {
        let mut snapshot = run_pictures::read_collection_frame(folder, &results.frames[number])?;
        run_pictures::set_force_units(&mut snapshot.fields, &results.case);
        let usual = ["displacement", "velocity"].iter().filter(|name| snapshot.field(name).is_some());
        let fields = match &options.fields[..] {
            [] => usual.map(|name| (*name).to_owned()).collect(),
            fields => fields.to_vec(),
        };
        for field in fields {
            let cloud = run_pictures::point_picture(&snapshot, Some(&field), options.plane);
            let (_, cloud) =
                cloud.map_err(|known| ReportError::Field { name: field.clone(), available: known })?;
            let cloud = PointCloud { lines: ground.lines_at(snapshot.time), ..cloud };
            let caption = format!(
                "{}, frame {number}, t = {} s",
                field.replace('_', " "),
                value_text::five_digits(snapshot.time)
            );
            match clouds.iter_mut().find(|(known, _)| *known == field) {
                Some((_, clouds)) => clouds.push((caption, cloud)),
                None => clouds.push((field, vec![(caption, cloud)])),
            }
        }
    }
    let mut figures = Vec::new();
    for (_, clouds) in clouds {
        let shared = CommonScales::of_clouds(clouds.iter().map(|(_, cloud)| cloud));
        for (caption, cloud) in clouds {
            let element = png(&PointCloud { shared_scales: Some(shared.clone()), ..cloud }, &caption)?;
            figures.push(ReportFigure { element, caption });
        }
    }
    Ok(figures)
}

/// HTML `img` element with the PNG data of a picture.
pub(crate) fn png(picture: &impl Picture, what: &str) -> Result<String, ReportError> {
    use base64::Engine;
    let fail = |problem| ReportError::Picture { subject: what.to_owned(), problem };
    let data = base64::engine::general_purpose::STANDARD.encode(picture.to_png().map_err(fail)?);
    Ok(maud::html! { img alt=(what) src=(format!("data:image/png;base64,{data}")); }.into_string())
}

/// Maps of the rasters, as PNG.
fn maps(folder: &Path) -> Result<Vec<ReportFigure>, ReportError> {
    let figure = |(name, map): (String, TerrainMap)| {
        let caption = name.replace('_', " ");
        Ok(ReportFigure { element: png(&map, &caption)?, caption })
    };
    crate::output::raster_maps::raster_maps(folder)?.into_iter().map(figure).collect()
}

/// Charts (SVG) of the measures that vary: those that the case requests, with the profiles, and all others.
fn charts(results: &RunResults) -> Result<(Vec<ReportFigure>, Vec<ReportFigure>), ReportError> {
    let of_run = |name: &str| RUN_COLUMN_PREFIXES.iter().any(|begin| name.starts_with(begin));
    let mut measures = run_pictures::charts(&results.measures);
    measures.retain(|(_, chart)| run_pictures::is_changing(&chart.series[0].points));
    measures.sort_by_key(|(name, _)| of_run(name));
    let (requested, others): (Vec<_>, Vec<_>) =
        measures.into_iter().partition(|(name, _)| results.is_requested(name));
    let profiles = results.profiles.iter().map(|(name, table)| (name.clone(), profile(table)));
    let figure = |(name, chart): (String, LineChart)| {
        let fail = |problem| ReportError::Picture { subject: name.clone(), problem };
        // The caption below the chart is its title.
        let chart = LineChart { title: String::new(), ..chart };
        Ok(ReportFigure { element: chart.to_svg().map_err(fail)?, caption: name.replace('_', " ") })
    };
    let requested: Result<_, ReportError> = requested.into_iter().chain(profiles).map(figure).collect();
    let others: Result<_, ReportError> = others.into_iter().map(figure).collect();
    Ok((requested?, others?))
}

/// Chart of a surface profile at several times.
fn profile(table: &Table) -> LineChart {
    let mut times: Vec<f64> = table.column("time").unwrap_or_default();
    times.dedup();
    let rows = |time: f64| table.rows.iter().filter(move |row| row[0] == time).map(|row| (row[1], row[2]));
    let shown = evenly_spaced_frames(times.len(), 5).into_iter().map(|k| times[k]);
    LineChart {
        x_label: "position (m)".to_owned(),
        y_label: "height (m)".to_owned(),
        series: shown
            .map(|time| {
                Series::new(
                    format!("t = {} s", value_text::five_digits(time)),
                    rows(time).collect(),
                    Style::Line,
                )
            })
            .collect(),
        ..LineChart::default()
    }
}

#[cfg(test)]
mod tests {
    use super::evenly_spaced_frames;

    #[test]
    fn frames_are_chosen_evenly_with_the_first_and_the_last() {
        assert_eq!(evenly_spaced_frames(11, 3), [0, 5, 10]);
        assert_eq!(evenly_spaced_frames(6, 4), [0, 2, 3, 5]);
        assert_eq!(evenly_spaced_frames(3, 8), [0, 1, 2]);
        assert_eq!(evenly_spaced_frames(5, 1), [4]);
        assert_eq!(evenly_spaced_frames(0, 4), [0; 0]);
    }
}
