//! `colluvium plot`.

use std::path::{Path, PathBuf};

use crate::case::output::{
    Collection, DerivedFiles, OutputError, Table, create_folder, named_file, read_frame, read_lines,
    write_atomically,
};
use crate::case::{Dataset, Snapshot};
use crate::output::raster_maps::raster_maps;
use crate::output::rigid_geometry::rigid_geometry_of_run;
use crate::output::run_pictures::{
    charts, is_changing, line_picture, point_picture, read_case_value, read_collection_frame,
    set_force_units, view_plane,
};
use crate::plots::{
    CommonScales, ForceChains, FramePicture, LineChart, Picture, PointCloud, RigidGeometry, to_gif,
};
use clap::Args;

use super::{
    CommandError, LibraryArguments, check_run_folder, or_default_with_warning, print_note, print_warning,
};
use crate::case::Warning;

/// Largest number of frames of an animation.
const MAX_ANIMATION_FRAMES: usize = 120;

#[derive(Args)]
#[command(
    after_help = "Usual calls:\n  colluvium plot slope-mpm\n  colluvium plot slope-mpm --fields velocity --frame all --gif"
)]
pub struct PlotArguments {
    /// Folder of a run.
    folder: PathBuf,
    /// Dataset that is drawn: `points`, or another dataset of the run, such as `grid` of `output.grid` or `contacts` of `output.contacts`.
    /// Nodes are drawn as squares, polygons as dots in their middle, and contacts as lines with a width that shows their force or the
    /// field of `--fields`.
    #[arg(long, default_value = Dataset::POINTS)]
    dataset: String,
    /// Fields that colour the points, separated by commas, or components of them, such as `stress.yy`, `stress.q` or `velocity.x`; by
    /// default displacement, or the first available field. Vectors show their length and tensors the mean pressure `-tr/3`.
    #[arg(long, alias = "field", value_delimiter = ',')]
    fields: Vec<String>,
    /// Number of the frame, `last`, or `all`: all frames then have one scale of colours and one set of axes.
    #[arg(long, default_value = "last")]
    frame: String,
    /// Time (s) in place of `--frame`: the frame nearest to it.
    #[arg(long, value_name = "SECONDS", conflicts_with = "frame", allow_hyphen_values = true)]
    time: Option<f64>,
    /// Values of the first and of the last colour, as LOW,HIGH; by default the range of the field. Not available for contacts.
    #[arg(long, value_name = "LOW,HIGH", value_parser = parse_range, allow_hyphen_values = true)]
    range: Option<(f64, f64)>,
    /// Draw also an animated GIF of each field, of at most 120 evenly distributed frames.
    #[arg(long)]
    gif: bool,
    /// Folder for the pictures; by default `plots` in the folder of the run.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Replace files of equal names, even those that colluvium did not write.
    #[arg(long)]
    overwrite: bool,
    /// Format of the pictures: png or svg.
    #[arg(long, default_value = "png", value_parser = ["png", "svg"])]
    format: String,
    /// Axes of the view; by default xy, and xz in three dimensions with gravity along z.
    #[arg(long, value_parser = ["xy", "xz", "yz"])]
    view: Option<String>,
    #[command(flatten)]
    pub library: LibraryArguments,
}

/// Parses two numbers, the second larger than the first.
fn parse_range(text: &str) -> Result<(f64, f64), String> {
    let (low, high) = text.split_once(',').ok_or("give two numbers, LOW,HIGH")?;
    let number = |part: &str| {
        let value = part.trim().parse::<f64>().map_err(|_| format!("{part:?} is not a number"))?;
        if value.is_finite() { Ok(value) } else { Err(format!("{part:?} is not finite")) }
    };
    let (low, high) = (number(low)?, number(high)?);
    if low < high { Ok((low, high)) } else { Err(format!("{low} is not below {high}")) }
}

/// Draws the frames and measures of a run.
pub fn run(arguments: &PlotArguments) -> Result<(), CommandError> {
    let folder = &arguments.folder;
    check_run_folder(folder)?;
    let frames = match frame_list(folder, &arguments.dataset) {
        Err(CommandError::Output(error)) => {
            or_default_with_warning(Err::<Option<Vec<_>>, _>(error), "no frames are drawn")
        }
        read => Some(read?),
    };
    let chosen = frames.as_ref().map(|frames| selected_frames(arguments, frames)).transpose()?;
    let (frames, chosen) = (frames.unwrap_or_default(), chosen.unwrap_or_default());
    let ground = rigid_geometry_of_run(folder);
    if !ground.missing.is_empty() {
        let text = format!("{}: the pictures do not show terrain and obstacles", ground.missing);
        print_warning(&Warning::new("results-missing", text));
    }
    let out = arguments.out.clone().unwrap_or_else(|| folder.join("plots"));
    create_folder(&out)?;
    let mut files = DerivedFiles::open(&out, arguments.overwrite)?;
    let mut written = 0;
    let mut save = |picture: &dyn Fn(&Path) -> Result<(), CommandError>, name: &str, ending: &str| {
        written += 1;
        files.write(&output_file_name(&out, name, ending)?, picture)
    };
    let format = arguments.format.as_str();
    for (name, chart) in changing_charts(folder)? {
        save(&|file| Ok(chart.write(file)?), &name, format)?;
    }
    for (name, map) in raster_maps(folder)? {
        save(&|file| Ok(map.write(file)?), &format!("map-{name}"), format)?;
    }
    let fields: Vec<Option<&str>> = match &arguments.fields[..] {
        [] => vec![None],
        names => names.iter().map(|name| Some(name.as_str())).collect(),
    };
    for field in fields.into_iter().filter(|_| !chosen.is_empty()) {
        for (name, number, picture) in draw_pictures(arguments, (&frames, &chosen), field, &ground)? {
            let name = format!("{}-{number:05}", picture_name(arguments, &name));
            save(&|file| Ok(picture.write(file)?), &name, format)?;
        }
        if arguments.gif {
            let even = evenly_spaced(frames.len(), MAX_ANIMATION_FRAMES);
            let shown = draw_pictures(arguments, (&frames, &even), field, &ground)?;
            let name = shown.first().map_or_else(String::new, |(name, ..)| name.clone());
            let shown: Vec<FramePicture> = shown.into_iter().map(|(.., picture)| picture).collect();
            let bytes = to_gif(&shown, 0.1).map_err(|problem| CommandError::message("picture", problem))?;
            let name = picture_name(arguments, &name);
            save(&|file| Ok(write_atomically(file, &bytes)?), &name, "gif")?;
            print_shown_frames(&name, even.len(), frames.len())?;
        }
    }
    for (name, picture) in failing_pictures(arguments, &ground)? {
        save(&|file| Ok(picture.write(file)?), &name, format)?;
    }
    if written == 0 {
        return Err(OutputError::new(folder, "has no measures, rasters or frames to draw").into());
    }
    print_line!("wrote {} pictures to {}", written, out.display());
    Ok(())
}

/// Charts of the measures of a run. Those that do not change are named and left out.
fn changing_charts(folder: &Path) -> Result<Vec<(String, LineChart)>, CommandError> {
    let measures =
        or_default_with_warning(Table::read(&folder.join("measures.csv")), "no measures are drawn");
    let (changing, constant): (Vec<_>, Vec<_>) =
        charts(&measures).into_iter().partition(|(_, chart)| is_changing(&chart.series[0].points));
    if !constant.is_empty() {
        let names = constant.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ");
        print_line!("no chart of measures that do not change: {names}");
    }
    Ok(changing)
}

/// Pictures of the failure mechanisms that searches for factors of safety have found: displacement in the failing trial with the least
/// factor, in `failing-NAME.vtu`.
fn failing_pictures(
    arguments: &PlotArguments,
    ground: &RigidGeometry,
) -> Result<Vec<(String, PointCloud)>, CommandError> {
    let folder = &arguments.folder;
    let plane = view_plane(folder, arguments.view.as_deref())?;
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let names = files.filter_map(|file| file.file_name().into_string().ok());
    let mut names: Vec<String> =
        names.filter(|name| name.starts_with("failing-") && name.ends_with(".vtu")).collect();
    names.sort();
    let mut pictures = Vec::new();
    for file in names {
        let snapshot = read_frame(&folder.join(&file), 0.0)?;
        let name = file.trim_end_matches(".vtu").to_owned();
        if let Ok((_, cloud)) = point_picture(&snapshot, Some("trial_displacement"), plane) {
            let title = format!("{}: displacement in the failing trial", name.trim_start_matches("failing-"));
            pictures.push((name, PointCloud { title, lines: ground.lines_at(0.0), ..cloud }));
        }
    }
    Ok(pictures)
}

/// Prints the number of frames of an animation, as a note where some are left out.
fn print_shown_frames(name: &str, shown: usize, frames: usize) -> Result<(), CommandError> {
    let text = format!("{name}.gif shows {shown} of {frames} frames");
    if shown < frames {
        print_note(&Warning::new("frames-thinned", text));
    } else {
        print_line!("{text}");
    }
    Ok(())
}

/// Name of a file of the folder `out`.
fn output_file_name(out: &Path, stem: &str, ending: &str) -> Result<String, OutputError> {
    let file = named_file(out, stem, ending)?;
    Ok(file.file_name().unwrap_or_default().to_string_lossy().into_owned())
}

/// Times (s) and files of the frames of a dataset.
fn frame_list(folder: &Path, dataset: &str) -> Result<Vec<(f64, String)>, CommandError> {
    let first = Collection::read(&folder.join("frames.pvd"))?.frames;
    let own = folder.join(format!("{dataset}.pvd"));
    let is_own = |name: &str| first.first().is_some_and(|(_, file)| file.contains(&format!("/{name}-")));
    match dataset {
        // For a method without points, the dataset it has instead.
        Dataset::POINTS => Ok(first),
        _ if is_own(dataset) => Ok(first),
        _ if own.exists() => Ok(Collection::read(&own)?.frames),
        _ => {
            let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
            let names = files.filter_map(|file| file.file_name().into_string().ok());
            let beside = names.filter_map(|name| name.strip_suffix(".pvd").map(str::to_owned));
            let mut known: Vec<String> = beside.filter(|name| name != "frames").collect();
            known.push(Dataset::POINTS.to_owned());
            known.sort();
            Err(CommandError::usage(
                "wrong-usage",
                format!("--dataset {dataset}: is not a dataset of the run; there are {}", known.join(", ")),
            ))
        }
    }
}

/// Numbers of the requested frames.
fn selected_frames(arguments: &PlotArguments, frames: &[(f64, String)]) -> Result<Vec<usize>, CommandError> {
    let count = frames.len();
    if let Some(time) = arguments.time {
        let distance = |number: &usize| (frames[*number].0 - time).abs();
        let nearest = (0..count).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        if let Some(number) = nearest {
            print_line!("frame {number} at {} s", frames[number].0);
        }
        return Ok(nearest.into_iter().collect());
    }
    let number = match arguments.frame.as_str() {
        "all" => return Ok((0..count).collect()),
        "last" => count.wrapping_sub(1),
        text => text.parse().map_err(|_| {
            CommandError::usage("wrong-usage", format!("--frame {text}: give a number, last or all"))
        })?,
    };
    if number < count {
        return Ok(vec![number]);
    }
    Err(CommandError::usage(
        "wrong-usage",
        format!("--frame {}: the run has {count} frames", arguments.frame),
    ))
}

/// File name of a picture of a field, with the name of the dataset where it is not `points`.
fn picture_name(arguments: &PlotArguments, field: &str) -> String {
    match arguments.dataset.as_str() {
        Dataset::POINTS => field.to_owned(),
        other => format!("{other}-{field}"),
    }
}

/// Numbers of at most `limit` of `count` frames, evenly from the first to the last.
fn evenly_spaced(count: usize, limit: usize) -> Vec<usize> {
    let shown = count.min(limit);
    (0..shown).map(|k| if shown > 1 { k * (count - 1) / (shown - 1) } else { 0 }).collect()
}

/// Picture with the name of its field and the index of its frame.
type NumberedPicture<T> = (String, usize, T);

/// Draws pictures of frames: points coloured by a field, or lines whose width shows a field. Several pictures have a common scale and
/// common axes.
fn draw_pictures(
    arguments: &PlotArguments,
    (frames, numbers): (&[(f64, String)], &[usize]),
    field: Option<&str>,
    ground: &RigidGeometry,
) -> Result<Vec<NumberedPicture<FramePicture>>, CommandError> {
    let first = numbers.first().map(|number| read_lines(&arguments.folder.join(&frames[*number].1)));
    if let Some(Some(_)) = first.transpose()? {
        let found = line_pictures(arguments, (frames, numbers), field, ground)?;
        return Ok(found
            .into_iter()
            .map(|(name, number, one)| (name, number, FramePicture::Lines(one)))
            .collect());
    }
    let found = point_pictures(arguments, (frames, numbers), field, ground)?;
    Ok(found.into_iter().map(|(name, number, one)| (name, number, FramePicture::Points(one))).collect())
}

/// Error message for a frame without the requested field.
fn unknown_field_error(field: Option<&str>, known: &str) -> CommandError {
    CommandError::usage(
        "field-missing",
        format!(
            "--fields {}: is not a field of the frame, nor a component such as stress.yy or velocity.x; there are \
             {known}",
            field.unwrap_or_default()
        ),
    )
}

/// Pictures of the lines of frames, such as contacts, over the points at the same times.
fn line_pictures(
    arguments: &PlotArguments,
    (frames, numbers): (&[(f64, String)], &[usize]),
    field: Option<&str>,
    ground: &RigidGeometry,
) -> Result<Vec<NumberedPicture<ForceChains>>, CommandError> {
    let folder = &arguments.folder;
    if arguments.range.is_some() {
        let dataset = &arguments.dataset;
        return Err(CommandError::usage(
            "wrong-usage",
            format!("--range: applies to colours, and the lines of {dataset} show values as widths"),
        ));
    }
    let (plane, case) = (view_plane(folder, arguments.view.as_deref())?, read_case_value(folder)?);
    let states = Collection::read(&folder.join("frames.pvd"))?.of_points();
    let mut found = Vec::new();
    for &number in numbers {
        let (time, file) = &frames[number];
        let Some(mut contacts) = read_lines(&folder.join(file))? else { continue };
        set_force_units(&mut contacts.fields, &case);
        let nearest = states.iter().min_by(|a, b| (a.0 - time).abs().total_cmp(&(b.0 - time).abs()));
        let mut grains = match nearest {
            Some(state) if (state.0 - time).abs() <= 1e-9 * time.abs() => {
                read_collection_frame(folder, state)?
            }
            _ => Snapshot::default(),
        };
        grains.time = *time;
        let (name, chains) = line_picture(&contacts, &grains, field, plane)
            .map_err(|known| unknown_field_error(field, &known))?;
        found.push((name, number, ForceChains { ground: ground.lines_at(*time), ..chains }));
    }
    if found.len() > 1 {
        let shared = ForceChains::common_scales(found.iter().map(|(.., chains)| chains));
        found.iter_mut().for_each(|(.., chains)| chains.shared_scale = Some(shared.clone()));
    }
    Ok(found)
}

/// Pictures of the points of frames, coloured by a field. Several pictures have a common scale and common axes.
fn point_pictures(
    arguments: &PlotArguments,
    (frames, numbers): (&[(f64, String)], &[usize]),
    field: Option<&str>,
    ground: &RigidGeometry,
) -> Result<Vec<NumberedPicture<PointCloud>>, CommandError> {
    let plane = view_plane(&arguments.folder, arguments.view.as_deref())?;
    let case = read_case_value(&arguments.folder)?;
    let nothing = RigidGeometry::default();
    let ground = if arguments.dataset == Dataset::POINTS { ground } else { &nothing };
    let mut found = Vec::new();
    for &number in numbers {
        let mut snapshot = read_collection_frame(&arguments.folder, &frames[number])?;
        set_force_units(&mut snapshot.fields, &case);
        let (name, cloud) =
            point_picture(&snapshot, field, plane).map_err(|known| unknown_field_error(field, &known))?;
        found.push((name, number, PointCloud { lines: ground.lines_at(snapshot.time), ..cloud }));
    }
    if found.len() > 1 || arguments.range.is_some() {
        let mut shared = CommonScales::of_clouds(found.iter().map(|(.., cloud)| cloud));
        if let Some((low, high)) = arguments.range {
            shared.values = low..high;
        }
        found.iter_mut().for_each(|(.., cloud)| cloud.shared_scales = Some(shared.clone()));
    }
    Ok(found)
}
