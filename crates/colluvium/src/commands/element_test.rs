//! `colluvium element-test`.

use std::path::PathBuf;

use clap::Args;
use colluvium::case::output::write_atomically;
use colluvium::case::plot::{LineChart, Picture, Series, Style};
use colluvium::case::{CaseError, CaseErrors, json};
use colluvium::constitutive::driver::{ElementPath, ElementTest, STANDARD_PLOTS};

use super::Failure;

#[derive(Args)]
pub struct Arguments {
    /// The test file.
    file: PathBuf,
    /// Folder for table and pictures; the name of the file by default.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Format of the pictures: png or svg.
    #[arg(long, default_value = "png", value_parser = ["png", "svg"])]
    format: String,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let unreadable = |error: std::io::Error| {
        CaseErrors::one(CaseError::new(
            arguments.file.display().to_string(),
            format!("cannot be read: {error}"),
        ))
    };
    let text = std::fs::read_to_string(&arguments.file).map_err(unreadable)?;
    let test: ElementTest = json::read(&text)?;
    let path = test.run().map_err(|error| {
        use colluvium::constitutive::driver::DriverError;
        match error {
            DriverError::LimitLoad { .. } | DriverError::Law { .. } => Failure::Other(error.to_string()),
            wrong => CaseError::new(arguments.file.display().to_string(), wrong.to_string()).into(),
        }
    })?;
    let stem = || PathBuf::from(arguments.file.file_stem().unwrap_or_default());
    let out = arguments.out.clone().unwrap_or_else(stem);
    std::fs::create_dir_all(&out).map_err(|error| Failure::Other(format!("{}: {error}", out.display())))?;
    let mut table = Vec::new();
    path.write_csv(&mut table).map_err(|error| Failure::Other(error.to_string()))?;
    write_atomically(&out.join("path.csv"), &table)?;
    for chart in charts(&test.title, &path) {
        chart.1.write(&out.join(format!("{}.{}", chart.0, arguments.format)))?;
    }
    let (p, q) = (path.last("p"), path.last("q"));
    println!(
        "{} rows; at the end p = {p:.6e} Pa, q = {q:.6e} Pa; results in {}",
        path.rows.len(),
        out.display()
    );
    Ok(())
}

fn charts(title: &str, path: &ElementPath) -> Vec<(&'static str, LineChart)> {
    let chart = |plot: &colluvium::constitutive::driver::StandardPlot| {
        let x = path.column(plot.x).unwrap_or_default();
        let y = path.column(plot.y).unwrap_or_default();
        let points = x.into_iter().zip(y).collect();
        let chart = LineChart {
            title: title.to_owned(),
            x_label: plot.x_label.to_owned(),
            y_label: plot.y_label.to_owned(),
            log: false,
            series: vec![Series::new("", points, Style::Line)],
        };
        (plot.name, chart)
    };
    STANDARD_PLOTS.iter().map(chart).collect()
}
