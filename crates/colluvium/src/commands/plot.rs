//! `colluvium plot`.

use std::path::PathBuf;

use clap::Args;
use colluvium::case::output::{Collection, Table, heading, read_frame};
use colluvium::case::plot::{LineChart, Picture, PointCloud, Series, Style};

use super::Failure;

#[derive(Args)]
pub struct Arguments {
    /// Folder of a run.
    folder: PathBuf,
    /// Field that colours the points; displacement, or the first there is, when absent.
    #[arg(long)]
    field: Option<String>,
    /// Number of the frame, or `last`.
    #[arg(long, default_value = "last")]
    frame: String,
    /// Format of the pictures: png or svg.
    #[arg(long, default_value = "png", value_parser = ["png", "svg"])]
    format: String,
    /// The two axes seen.
    #[arg(long, default_value = "xy", value_parser = ["xy", "xz", "yz"])]
    view: String,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = &arguments.folder;
    let table = Table::read(&folder.join("measures.csv"))?;
    let mut written = Vec::new();
    let skip = ["time", "step"];
    for (name, unit) in table.columns.iter().filter(|(name, _)| !skip.contains(&name.as_str())) {
        let points = table.pairs("time", name).unwrap_or_default();
        if points.iter().all(|(_, value)| !value.is_finite()) {
            continue;
        }
        let chart = LineChart {
            title: String::new(),
            x_label: "time (s)".to_owned(),
            y_label: heading(name, unit).replace('_', " "),
            log: false,
            series: vec![Series::new("", points, Style::Line)],
        };
        written.push(folder.join(format!("{name}.{}", arguments.format)));
        chart.write(&written[written.len() - 1])?;
    }
    written.push(points(arguments)?);
    say!("wrote {} pictures to {}", written.len(), folder.display());
    Ok(())
}

fn points(arguments: &Arguments) -> Result<PathBuf, Failure> {
    let folder = &arguments.folder;
    let frames = Collection::read(&folder.join("frames.pvd"))?.frames;
    let number = match arguments.frame.as_str() {
        "last" => frames.len().wrapping_sub(1),
        text => text.parse().map_err(|_| Failure::Usage(format!("--frame {text}: give a number or last")))?,
    };
    let (time, file) = frames.get(number).ok_or_else(|| {
        Failure::Usage(format!("--frame {}: the run has {} frames", arguments.frame, frames.len()))
    })?;
    let snapshot = read_frame(&folder.join(file), *time)?;
    let plane = match arguments.view.as_str() {
        "xz" => [0, 2],
        "yz" => [1, 2],
        _ => [0, 1],
    };
    let names: Vec<&str> = snapshot.fields.iter().map(|f| f.name.as_str()).collect();
    let usual = if names.contains(&"displacement") { Some("displacement") } else { names.first().copied() };
    let field = arguments.field.as_deref().or(usual).unwrap_or_default();
    let cloud = PointCloud::of(&snapshot, field, plane)
        .ok_or_else(|| Failure::Usage(format!("--field {field}: the frame has {}", names.join(", "))))?;
    let path = folder.join(format!("{field}-{number:05}.{}", arguments.format));
    cloud.write(&path)?;
    Ok(path)
}
