//! `colluvium element-test`.

use std::path::{Path, PathBuf};

use crate::case::files::json;
use crate::case::output::{create_folder, write_atomically};
use crate::case::{CaseError, CaseErrorKind, CaseErrors};
use crate::constitutive::MaterialSpec;
use crate::constitutive::driver::incremental::{self, IncrementalTest};
use crate::constitutive::driver::{
    DriverError, ElementPath, StandardPlot, TestProblem, TestTrace, YieldCurve,
};
use crate::plots::{LineChart, Picture, Series, Style};
use clap::Args;

use super::{CommandError, LibraryArguments, print_warning};
use crate::case::Warning;
use crate::cli::file_kind;
use crate::cli::file_kind::FileKind;

#[derive(Args)]
#[command(
    after_help = "Usual calls:\n  colluvium element-test triaxial.json\n  colluvium element-test FOLDER --material law.json --stress-unit kPa"
)]
pub struct ElementTestArguments {
    /// The test file, or a folder with the files of an incrementalDriver: initialconditions.inp,
    /// test.inp and optionally parameters.inp.
    file: PathBuf,
    /// File with the material of the test in a folder: the object "material" of a test file.
    #[arg(long)]
    material: Option<PathBuf>,
    /// Unit of stress in the files of a folder: Pa (the default), kPa or MPa.
    #[arg(long, requires = "material", value_parser = ["Pa", "kPa", "MPa"])]
    stress_unit: Option<String>,
    /// Folder for table and pictures; the name of the file by default.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Format of the pictures: png or svg.
    #[arg(long, default_value = "png", value_parser = ["png", "svg"])]
    format: String,
    #[command(flatten)]
    pub library: LibraryArguments,
}

pub fn run(arguments: &ElementTestArguments) -> Result<(), CommandError> {
    let file = &arguments.file;
    file_kind::require_kind(file, FileKind::ElementTest)?;
    let (test, incremental) = match (file.is_dir(), &arguments.material) {
        (true, Some(material)) => {
            let test = read_incremental_driver(file, material, arguments.stress_unit.as_deref())?;
            (test.test.clone(), Some(test))
        }
        (true, None) => {
            return Err(CommandError::usage(
                "wrong-usage",
                "a folder has no material law: give the file of one with --material",
            ));
        }
        (false, Some(_)) => {
            return Err(CommandError::usage(
                "wrong-usage",
                "--material applies to a folder only; a test file has its own material",
            ));
        }
        (false, None) => (crate::load_element_test(file)?, None),
    };
    let stem = || PathBuf::from(file.canonicalize().unwrap_or_default().file_stem().unwrap_or_default());
    let out = arguments.out.clone().unwrap_or_else(stem);
    let broken = |error: DriverError| {
        CaseError::new(file.display().to_string(), CaseErrorKind::coded(error.code(), error.to_string()))
    };
    let mut trace = test.trace().map_err(broken)?;
    if let Some(incremental) = &incremental {
        incremental.remove_unwanted_rows(&mut trace.path);
    }
    write_results(&test.title, &trace, &out, &arguments.format)?;
    let [p, q] = ["p", "q"].map(|name| match trace.path.last(name) {
        value if value.is_finite() => format!("{value:.6e} Pa"),
        _ => "not a number".to_owned(),
    });
    print_line!("{} rows; at the end p = {p}, q = {q}; results in {}", trace.path.rows.len(), out.display());
    trace.stop_reason.map_or(Ok(()), |error| Err(CommandError::message(error.code(), error.to_string())))
}

/// Reads the files of an incrementalDriver test.
fn read_incremental_driver(
    folder: &Path,
    material: &Path,
    unit: Option<&str>,
) -> Result<IncrementalTest, CommandError> {
    let beside = |key: &str| format!("{}: {key}", material.display());
    let parameters = folder.join(incremental::PARAMETERS);
    let parameters = if parameters.exists() { Some(json::text(&parameters)?) } else { None };
    let input = incremental::IncrementalInput {
        parameters: parameters.as_deref(),
        initial: &json::text(&folder.join(incremental::INITIAL))?,
        test: &json::text(&folder.join(incremental::TEST))?,
        material: json::from_value::<MaterialSpec>(&json::value(material)?, "")
            .map_err(|errors| errors.with_file_name(material))?,
        stress_unit: match unit {
            Some("kPa") => 1e3,
            Some("MPa") => 1e6,
            _ => 1.0,
        },
    };
    let test = IncrementalTest::read(&input).map_err(|problems| {
        let located = problems.into_iter().map(|TestProblem { path, problem }| {
            // A key that is in none of the files belongs to the material.
            let inner = path.strip_prefix("material.").map(beside);
            CaseError::new(
                inner.unwrap_or_else(|| folder.join(path).display().to_string()),
                CaseErrorKind::coded("incremental-driver", problem),
            )
        });
        CaseErrors(located.collect())
    })?;
    let of_files = [
        (test.parameters.values.len(), incremental::PARAMETERS, "properties"),
        (test.state.iter().filter(|value| **value != 0.0).count(), incremental::INITIAL, "state variables"),
    ];
    for ((count, file, what), _) in
        of_files.iter().zip(test.uses_file_values).filter(|((count, ..), takes)| *count > 0 && !takes)
    {
        print_warning(&Warning::new(
            "unused-values",
            format!(
                "{file}: the law of --material does not use the {count} {what}. Check that it is the intended law"
            ),
        ));
    }
    Ok(test)
}

/// Writes the table and the pictures, in place of those of an earlier test.
fn write_results(title: &str, trace: &TestTrace, out: &Path, format: &str) -> Result<(), CommandError> {
    let fail = |error: std::io::Error| CommandError::message("output", format!("{}: {error}", out.display()));
    create_folder(out)?;
    let mut table = Vec::new();
    trace.path.write_csv(&mut table).map_err(|error| CommandError::message("output", error.to_string()))?;
    let path = out.join("path.csv");
    let pictures: Vec<PathBuf> = (StandardPlot::NAMES.iter())
        .flat_map(|name| ["png", "svg"].map(|format| out.join(format!("{name}.{format}"))))
        .filter(|picture| picture.exists())
        .collect();
    // All tables of element tests have the same beginning, which no other file has.
    let units = table.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let is_table = std::fs::read(&path).is_ok_and(|earlier| earlier.starts_with(units));
    let foreign = Some(&path).filter(|path| path.exists()).or(pictures.first());
    if let Some(file) = foreign.filter(|_| !is_table) {
        return Err(CommandError::message(
            "output",
            format!(
                "{} would be overwritten, and no element test wrote it: choose another folder with --out",
                file.display()
            ),
        ));
    }
    pictures.iter().try_for_each(std::fs::remove_file).map_err(fail)?;
    write_atomically(&path, &table)?;
    for plot in trace.path.standard_plots() {
        let yield_lines = if plot.name == "q-p" { trace.yield_lines() } else { Vec::new() };
        line_chart(title, &plot, &trace.path, yield_lines)
            .write(&out.join(format!("{}.{format}", plot.name)))?;
    }
    Ok(())
}

fn line_chart(
    title: &str,
    plot: &StandardPlot,
    path: &ElementPath,
    yield_lines: Vec<YieldCurve>,
) -> LineChart {
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
