//! `colluvium plot`.

use std::path::PathBuf;

use clap::Args;
use colluvium::case::output::{Collection, Table};
use colluvium::maps::maps;
use colluvium::pictures::{charts, cloud, frame, plane};
use colluvium::plots::Picture;

use super::{Failure, a_run};

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
    /// The two axes seen; xy when absent, and xz in three dimensions with gravity along z.
    #[arg(long, value_parser = ["xy", "xz", "yz"])]
    view: Option<String>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = &arguments.folder;
    a_run(folder)?;
    let mut written = 0;
    for (name, chart) in charts(&Table::read(&folder.join("measures.csv"))?) {
        chart.write(&folder.join(format!("{name}.{}", arguments.format)))?;
        written += 1;
    }
    for (name, map) in maps(folder)? {
        map.write(&folder.join(format!("map-{name}.{}", arguments.format)))?;
        written += 1;
    }
    points(arguments)?;
    say!("wrote {} pictures to {}", written + 1, folder.display());
    Ok(())
}

fn points(arguments: &Arguments) -> Result<(), Failure> {
    let folder = &arguments.folder;
    let frames = Collection::read(&folder.join("frames.pvd"))?.frames;
    let number = match arguments.frame.as_str() {
        "last" => frames.len().wrapping_sub(1),
        text => text.parse().map_err(|_| Failure::Usage(format!("--frame {text}: give a number or last")))?,
    };
    let chosen = frames.get(number).ok_or_else(|| {
        Failure::Usage(format!("--frame {}: the run has {} frames", arguments.frame, frames.len()))
    })?;
    let asked = arguments.field.as_deref();
    let plane = plane(folder, arguments.view.as_deref())?;
    let (field, cloud) = cloud(&frame(folder, chosen)?, asked, plane).map_err(|known| {
        Failure::Usage(format!("--field {}: the frame has {known}", asked.unwrap_or_default()))
    })?;
    Ok(cloud.write(&folder.join(format!("{field}-{number:05}.{}", arguments.format)))?)
}
