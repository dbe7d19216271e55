//! Files of a fit: tables, the fitted material, pictures.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::case::output::{DerivedFiles, OutputError, column_heading, create_folder, write_atomically};
use crate::constitutive::driver::cell;
use crate::fit::{Fit, FitProblem, FitSolution, LaboratoryTest, StageCurves};
use crate::plots::{LineChart, Picture, Series, Style};
use crate::sweep::ParameterScale;

/// Name of the copy of the fit in its folder.
const FIT_FILE: &str = "fit.json";
/// Name of the fitted material.
const MATERIAL_FILE: &str = "material.json";
/// Names of the tables of parameters and of correlations, without ending.
pub(super) const TABLES: [&str; 2] = ["fit", "correlations"];

/// Failure to write the results of a fit.
#[derive(Debug, Error)]
pub enum FitError {
    /// A file could not be written or read.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The folder cannot be used.
    #[error("{}: {problem}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Reason why it cannot be used.
        problem: String,
    },
}

impl FitError {
    /// Code of the error, as on the page of warnings and errors.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Output(error) => error.code,
            Self::Folder { .. } => "folder-has-run",
        }
    }
}

/// Folder for the results of a fit.
#[derive(Debug)]
pub struct FitFolder {
    path: PathBuf,
    files: DerivedFiles,
    /// Ending of pictures.
    format: String,
}

impl FitFolder {
    /// Checks that a folder can take the results of a fit, with pictures in a format, `png` or `svg`. With `overwrite` they replace those
    /// of an earlier fit, and no other files.
    ///
    /// # Errors
    /// When the folder has an earlier fit without `overwrite`, or a file of a name of the results that no fit wrote.
    pub fn open(path: &Path, fit: &Fit, format: &str, overwrite: bool) -> Result<Self, FitError> {
        let files = DerivedFiles::open(path, false)?;
        let refuse = |problem: String| Err(FitError::Folder { path: path.to_owned(), problem });
        if files.is_own(FIT_FILE)? && !overwrite {
            return refuse(
                "contains an earlier fit already (overwrite it or choose another folder)".to_owned(),
            );
        }
        for name in file_names(fit, format) {
            if path.join(&name).symlink_metadata().is_ok() && !files.is_own(&name)? {
                return refuse(format!(
                    "contains {name}, which no fit wrote in this state: choose another folder, or move the file"
                ));
            }
        }
        Ok(Self { path: path.to_owned(), files, format: format.to_owned() })
    }

    /// Writes the results, in place of those of an earlier fit. `input` is the text of the fit's file.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(
        &mut self,
        problem: &FitProblem,
        solution: &FitSolution,
        input: &str,
    ) -> Result<(), FitError> {
        create_folder(&self.path)?;
        if self.files.is_own(FIT_FILE)? {
            self.files.remove_own()?;
        }
        self.write_bytes(FIT_FILE, input.as_bytes())?;
        let material = serde_json::to_string_pretty(&problem.fitted_material(solution));
        let material = material.map_err(|error| OutputError::new(&self.path, error))?;
        self.write_bytes(MATERIAL_FILE, format!("{material}\n").as_bytes())?;
        self.write_lines(TABLES[0], &parameter_lines(solution))?;
        self.write_lines(TABLES[1], &correlation_lines(solution))?;
        for (number, test) in problem.fit.tests.iter().enumerate() {
            let of = |which: fn(&crate::fit::FittedParameter) -> f64| -> Vec<f64> {
                solution.parameters.iter().map(which).collect()
            };
            let values = [of(|parameter| parameter.start), of(|parameter| parameter.fitted)];
            self.write_lines(&test.name, &comparison_lines(problem, number, &values))?;
            self.draw(problem, number, &values)?;
        }
        Ok(())
    }

    /// Draws the curves of a test: data, start and fit.
    fn draw(&mut self, problem: &FitProblem, number: usize, values: &[Vec<f64>; 2]) -> Result<(), FitError> {
        let (test, data) = (&problem.fit.tests[number], &problem.data[number]);
        let computed = values.each_ref().map(|values| problem.stage_curves(number, values));
        for (k, curve) in data.curves.iter().enumerate() {
            let line = |curves: &Option<StageCurves>| -> Vec<(f64, f64)> {
                let pairs =
                    curves.iter().flat_map(|c| c.over.iter().copied().zip(c.curves[k].iter().copied()));
                pairs.collect()
            };
            let points = curve.values.iter().map(|value| (value.x, value.y)).collect();
            let chart = LineChart {
                series: vec![
                    Series::new("fit", line(&computed[1]), Style::Line),
                    Series::new("data", points, Style::Markers),
                    Series::new("start", line(&computed[0]), Style::Dashed),
                ],
                ..LineChart::new(
                    format!("{}: {}", problem.fit.title, test.name),
                    column_heading(&test.data.over, data.over_unit),
                    column_heading(&curve.name, curve.unit),
                )
            };
            self.files.write(&picture_name(test, &curve.name, &self.format), |path| chart.write(path))?;
        }
        Ok(())
    }

    /// Writes a file.
    fn write_bytes(&mut self, name: &str, bytes: &[u8]) -> Result<(), FitError> {
        Ok(self.files.write(name, |path| write_atomically(path, bytes))?)
    }

    /// Writes lines of cells as a CSV file with this stem.
    fn write_lines(&mut self, stem: &str, lines: &[Vec<String>]) -> Result<(), FitError> {
        let fail = |error: &dyn std::fmt::Display| OutputError::new(&self.path, error);
        let mut writer = csv::Writer::from_writer(Vec::new());
        lines.iter().try_for_each(|line| writer.write_record(line)).map_err(|error| fail(&error))?;
        let bytes = writer.into_inner().map_err(|error| fail(&error))?;
        self.write_bytes(&format!("{stem}.csv"), &bytes)
    }
}

/// Name of the picture of a curve.
fn picture_name(test: &LaboratoryTest, curve: &str, format: &str) -> String {
    format!("{}-{curve}.{format}", test.name)
}

/// Names of all files of a fit.
fn file_names(fit: &Fit, format: &str) -> Vec<String> {
    let mut names = vec![FIT_FILE.to_owned(), MATERIAL_FILE.to_owned()];
    names.extend(TABLES.map(|stem| format!("{stem}.csv")));
    for test in &fit.tests {
        names.push(format!("{}.csv", test.name));
        names.extend(test.data.curves.keys().map(|curve| picture_name(test, curve, format)));
    }
    names
}

/// Rows of the table of parameters.
fn parameter_lines(solution: &FitSolution) -> Vec<Vec<String>> {
    let heads = [
        "parameter",
        "unit",
        "start",
        "fitted",
        "standard_deviation",
        "determined",
        "lower",
        "upper",
        "scale",
    ];
    let mut lines = vec![heads.map(str::to_owned).to_vec()];
    lines.extend(solution.parameters.iter().map(|parameter| {
        let [lower, upper] = parameter.range.range.map(cell);
        let scale = match parameter.range.scale {
            ParameterScale::Linear => "linear",
            ParameterScale::Logarithmic => "logarithmic",
        };
        let determined = if parameter.is_determined { "yes" } else { "no" };
        let (name, unit) = (parameter.name.clone(), parameter.unit.clone());
        let [start, fitted, deviation] = [parameter.start, parameter.fitted, parameter.deviation].map(cell);
        vec![name, unit, start, fitted, deviation, determined.to_owned(), lower, upper, scale.to_owned()]
    }));
    lines
}

/// Rows of the table of correlations.
fn correlation_lines(solution: &FitSolution) -> Vec<Vec<String>> {
    let names = || solution.parameters.iter().map(|parameter| parameter.name.clone());
    let mut lines = vec![["parameter".to_owned()].into_iter().chain(names()).collect::<Vec<_>>()];
    let rows = names().zip(&solution.correlations);
    lines.extend(rows.map(|(name, row)| [name].into_iter().chain(row.iter().copied().map(cell)).collect()));
    lines
}

/// Rows of the table of a test: abscissa, and data, start and fit of each curve. Curves without a value in a row have empty cells.
fn comparison_lines(problem: &FitProblem, number: usize, values: &[Vec<f64>; 2]) -> Vec<Vec<String>> {
    let (test, data) = (&problem.fit.tests[number], &problem.data[number]);
    let computed = values.each_ref().map(|values| problem.computed(number, values).unwrap_or_default());
    let mut heads = vec![column_heading(&test.data.over, data.over_unit)];
    for curve in &data.curves {
        heads.extend(
            ["", "_start", "_fit"].map(|end| column_heading(&format!("{}{end}", curve.name), curve.unit)),
        );
    }
    let mut places: Vec<(u64, f64)> =
        data.curves.iter().flat_map(|curve| curve.values.iter().map(|value| (value.line, value.x))).collect();
    places.sort_by_key(|(line, _)| *line);
    places.dedup_by_key(|(line, _)| *line);
    let mut lines = vec![heads];
    for (line, x) in places {
        let mut cells = vec![cell(x)];
        for (k, curve) in data.curves.iter().enumerate() {
            let index = curve.values.iter().position(|value| value.line == line);
            let at = |computed: &Vec<Vec<f64>>| {
                let value = index.and_then(|index| computed.get(k)?.get(index).copied());
                value.map_or_else(String::new, cell)
            };
            cells.push(index.map_or_else(String::new, |index| cell(curve.values[index].y)));
            cells.extend(computed.iter().map(at));
        }
        lines.push(cells);
    }
    lines
}
