//! `colluvium element-test`.

use std::path::{Path, PathBuf};

use clap::Args;
use colluvium::case::output::write_atomically;
use colluvium::case::plot::{LineChart, Picture, Series, Style};
use colluvium::case::{CaseError, CaseErrors};
use colluvium::constitutive::driver::{ElementPath, StandardPlot, Trace, YieldLine};

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
    let file = &arguments.file;
    let test = colluvium::element_test(&read(file)?)?;
    let stem = || PathBuf::from(file.file_stem().unwrap_or_default());
    let out = arguments.out.clone().unwrap_or_else(stem);
    let trace =
        test.trace().map_err(|error| CaseError::new(file.display().to_string(), error.to_string()))?;
    write(&test.title, &trace, &out, &arguments.format)?;
    let (p, q) = (trace.path.last("p"), trace.path.last("q"));
    println!(
        "{} rows; at the end p = {p:.6e} Pa, q = {q:.6e} Pa; results in {}",
        trace.path.rows.len(),
        out.display()
    );
    trace.stopped.map_or(Ok(()), |error| Err(Failure::Other(error.to_string())))
}

fn read(file: &Path) -> Result<String, CaseErrors> {
    let unreadable = |error| {
        CaseErrors::one(CaseError::new(file.display().to_string(), format!("cannot be read: {error}")))
    };
    std::fs::read_to_string(file).map_err(unreadable)
}

/// The table and the pictures.
fn write(title: &str, trace: &Trace, out: &Path, format: &str) -> Result<(), Failure> {
    std::fs::create_dir_all(out).map_err(|error| Failure::Other(format!("{}: {error}", out.display())))?;
    let mut table = Vec::new();
    trace.path.write_csv(&mut table).map_err(|error| Failure::Other(error.to_string()))?;
    write_atomically(&out.join("path.csv"), &table)?;
    for plot in trace.path.standard_plots() {
        let yield_lines = if plot.name == "q-p" { trace.yield_lines() } else { Vec::new() };
        chart(title, &plot, &trace.path, yield_lines).write(&out.join(format!("{}.{format}", plot.name)))?;
    }
    Ok(())
}

fn chart(title: &str, plot: &StandardPlot, path: &ElementPath, yield_lines: Vec<YieldLine>) -> LineChart {
    let column = |name: &str| path.column(name).unwrap_or_default();
    let points = column(plot.x).into_iter().zip(column(plot.y)).collect();
    let label = if yield_lines.is_empty() { "" } else { "path" };
    let mut series = vec![Series::new(label, points, Style::Line)];
    series.extend(yield_lines.into_iter().map(|line| Series::new(line.label, line.points, Style::Dashed)));
    LineChart {
        title: title.to_owned(),
        x_label: plot.x_label.to_owned(),
        y_label: plot.y_label.to_owned(),
        log: false,
        series,
    }
}
