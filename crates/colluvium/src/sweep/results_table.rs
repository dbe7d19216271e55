//! Results of the runs of a sweep: one row a run.

use std::path::Path;

use serde_json::Value;

use crate::case::Warning;
use crate::case::output::{
    OutputError, Table, column_heading, create_folder, named_file, read_json, write_atomically,
};
use crate::plots::{LineChart, Picture, Series, Style};
use crate::sweep::{Sweep, observed_order, table_text};

/// File names of the table of runs and of the table of convergence.
pub(super) const TABLE_FILES: [&str; 2] = ["runs.csv", "convergence.csv"];
/// Name of the folder of pictures.
pub(super) const PICTURE_FOLDER: &str = "pictures";

/// Row of a run in the table of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepRow {
    /// Values of the parameters, in the order of their names.
    pub values: Vec<Value>,
    /// Status of the run: `completed`, `failed`, `interrupted`; empty where it has not been run.
    pub status: String,
    /// Reason of a failure.
    pub reason: Option<String>,
    /// Last values of the measures, with the factors of safety: name, unit, value.
    pub measures: Vec<(String, String, f64)>,
    /// Wall-clock time (s).
    pub wall_time: f64,
}

impl SweepRow {
    /// Last value of a measure; `None` where the run is not complete.
    pub fn measure_value(&self, name: &str) -> Option<f64> {
        let mut measures = self.measures.iter().filter(|_| self.status == "completed");
        measures.find(|(measure, ..)| measure == name).map(|(.., value)| *value)
    }
}

/// Results of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepResults<'a> {
    /// Sweep of the results.
    pub sweep: &'a Sweep,
    /// Rows of the runs, in their order.
    pub rows: Vec<SweepRow>,
}

impl SweepResults<'_> {
    /// Root mean square difference of a run from the targets, over their tolerances. `None` without targets; NaN where the run lacks a
    /// value.
    pub fn misfit(&self, row: &SweepRow) -> Option<f64> {
        let targets = &self.sweep.targets;
        let square = |(name, target): (&String, &crate::sweep::ObservedTarget)| {
            let value = row.measure_value(name).unwrap_or(f64::NAN);
            ((value - target.value) / target.tolerance).powi(2)
        };
        let sum: f64 = targets.iter().map(square).sum();
        (!targets.is_empty()).then(|| (sum / targets.len() as f64).sqrt())
    }

    /// Index of the run with the smallest misfit, and this misfit.
    pub fn best_run(&self) -> Option<(usize, f64)> {
        let misfits =
            self.rows.iter().enumerate().filter_map(|(number, row)| Some((number, self.misfit(row)?)));
        misfits.filter(|(_, misfit)| misfit.is_finite()).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Warnings of parameters without effect: the measures of runs that differ only in them are equal to the last bit.
    pub fn warnings(&self) -> Vec<Warning> {
        let completed: Vec<&SweepRow> = self.rows.iter().filter(|row| row.status == "completed").collect();
        let is_equal = |a: &SweepRow, b: &SweepRow| {
            let numbers =
                |row: &SweepRow| -> Vec<u64> { row.measures.iter().map(|(.., v)| v.to_bits()).collect() };
            numbers(a) == numbers(b)
        };
        let pairs = || {
            completed.iter().enumerate().flat_map(|(k, a)| completed[k + 1..].iter().map(move |b| (*a, *b)))
        };
        let differ_only_in = |axis: usize, a: &SweepRow, b: &SweepRow| {
            (0..a.values.len()).all(|k| (a.values[k] == b.values[k]) == (k != axis))
        };
        let has_no_effect = |axis: usize| {
            let mut found = pairs().filter(|(a, b)| differ_only_in(axis, a, b)).peekable();
            found.peek().is_some() && found.all(|(a, b)| is_equal(a, b))
        };
        let names: Vec<&str> = self.sweep.parameters.keys().map(String::as_str).collect();
        let mut idle: Vec<&str> =
            (0..names.len()).filter(|axis| has_no_effect(*axis)).map(|axis| names[axis]).collect();
        if idle.is_empty()
            && completed.len() > 1
            && pairs().all(|(a, b)| a.values != b.values && is_equal(a, b))
        {
            idle.clone_from(&names);
        }
        let warning = |name: &&str| {
            let text = format!(
                "parameters.{name}: has no effect: runs that differ in it have equal measures. Check that the method uses the value at its path"
            );
            Warning::new("no-effect", text)
        };
        idle.iter().map(warning).collect()
    }

    /// Writes the table `runs.csv`.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, out: &Path) -> Result<(), OutputError> {
        let path = out.join(TABLE_FILES[0]);
        let mut columns: Vec<(&str, &str)> = Vec::new();
        for (name, unit, _) in self.rows.iter().flat_map(|row| &row.measures) {
            if !columns.iter().any(|(known, _)| known == name) {
                columns.push((name, unit));
            }
        }
        let mut lines = vec![["run", "status"].map(str::to_owned).to_vec()];
        lines[0].extend(self.sweep.parameters.keys().cloned());
        lines[0].extend((!self.sweep.targets.is_empty()).then(|| "misfit".to_owned()));
        lines[0].extend(columns.iter().map(|(name, unit)| column_heading(name, unit)));
        lines[0].extend(["wall_time (s)", "reason"].map(str::to_owned));
        for (number, row) in self.rows.iter().enumerate() {
            let mut line = vec![(number + 1).to_string(), row.status.clone()];
            line.extend(row.values.iter().map(table_text));
            if let Some(misfit) = self.misfit(row) {
                line.push(cell_text((!row.status.is_empty()).then_some(misfit)));
            }
            line.extend(columns.iter().map(|(name, _)| cell_text(row.measure_value(name))));
            line.push(cell_text((!row.status.is_empty()).then_some(row.wall_time)));
            line.push(row.reason.clone().unwrap_or_default());
            lines.push(line);
        }
        write_lines(&path, &lines)
    }

    /// Writes the convergence study, if there is one: the observed order for each measure and three successive runs. Returns its lines.
    /// Writes `convergence.csv`.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_convergence(&self, out: &Path) -> Result<Vec<String>, OutputError> {
        let Some(study) = &self.sweep.convergence else { return Ok(Vec::new()) };
        let Some(axis) = self.sweep.parameters.keys().position(|name| *name == study.parameter) else {
            return Ok(Vec::new());
        };
        let heads = ["measure", "others", "size", "value", "order", "limit", "index"];
        let (mut lines, mut messages) = (vec![heads.map(str::to_owned).to_vec()], Vec::new());
        for measure in &study.measures {
            for (others, runs) in self.parameter_series(axis, measure) {
                for (k, (size, value)) in runs.iter().enumerate() {
                    let three = |of: fn(&(f64, f64)) -> f64| [k - 2, k - 1, k].map(|k| of(&runs[k]));
                    let found = (k >= 2).then(|| observed_order(three(|run| run.0), three(|run| run.1)));
                    let text =
                        [measure.clone(), others.clone(), cell_text(Some(*size)), cell_text(Some(*value))];
                    let estimates = [
                        found.map(|o| o.order),
                        found.map(|o| o.limit),
                        found.map(|o| o.grid_convergence_index),
                    ];
                    lines.push([text.to_vec(), estimates.map(cell_text).to_vec()].concat());
                    if let (Some(found), true) = (found, k + 1 == runs.len()) {
                        let with = if others.is_empty() { String::new() } else { format!(" ({others})") };
                        messages.push(match found.order.is_nan() {
                            true => Warning::new("no-observed-order", format!("{measure}{with}: no observed order; {value:.6e} at {size}")).line("note"),
                            false => format!(
                                "{measure}{with}: order {:.2}, limit {:.6e}, uncertainty of the finest run {:.2} %",
                                found.order,
                                found.limit,
                                100.0 * found.grid_convergence_index
                            ),
                        });
                    }
                }
            }
        }
        write_lines(&out.join(TABLE_FILES[1]), &lines)?;
        Ok(messages)
    }

    /// Pairs of a numerical parameter and a measure, from the largest to the smallest parameter. There is one curve for each combination of
    /// the other parameters.
    fn parameter_series(&self, axis: usize, measure: &str) -> Vec<(String, Vec<(f64, f64)>)> {
        let mut series: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
        for row in &self.rows {
            let (Some(x), Some(y)) = (row.values[axis].as_f64(), row.measure_value(measure)) else {
                continue;
            };
            let others =
                self.sweep.parameters.keys().zip(&row.values).enumerate().filter(|(k, _)| *k != axis);
            let others: Vec<String> =
                others.map(|(_, (name, value))| format!("{name} = {}", table_text(value))).collect();
            let others = others.join(", ");
            match series.iter_mut().find(|(known, _)| *known == others) {
                Some((_, pairs)) => pairs.push((x, y)),
                None => series.push((others, vec![(x, y)])),
            }
        }
        series.iter_mut().for_each(|(_, pairs)| pairs.sort_by(|a, b| b.0.total_cmp(&a.0)));
        series
    }

    /// Draws the measures of the case over each numerical parameter, as `pictures/MEASURE-PARAMETER.svg`.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn draw(&self, out: &Path, measures: &[String]) -> Result<(), OutputError> {
        let folder = out.join(PICTURE_FOLDER);
        create_folder(&folder)?;
        for (axis, name) in self.sweep.parameters.keys().enumerate() {
            for measure in measures {
                let points: Vec<(f64, f64)> =
                    self.parameter_series(axis, measure).into_iter().flat_map(|(_, runs)| runs).collect();
                if points.len() < 2 {
                    continue;
                }
                let unit =
                    self.rows.iter().flat_map(|row| &row.measures).find(|(known, ..)| known == measure);
                let mut chart = LineChart {
                    title: self.sweep.title.clone(),
                    x_label: name.clone(),
                    y_label: column_heading(measure, unit.map_or("", |(_, unit, _)| unit)),
                    ..LineChart::default()
                };
                if let Some(target) = self.sweep.targets.get(measure) {
                    let ends =
                        points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], (x, _)| {
                            [low.min(*x), high.max(*x)]
                        });
                    let line = ends.map(|x| (x, target.value)).to_vec();
                    chart.series.push(Series::new("observed", line, Style::Dashed));
                }
                let label = if chart.series.is_empty() { "" } else { "runs" };
                chart.series.push(Series::new(label, points, Style::Markers));
                chart.write(&named_file(&folder, &format!("{measure}-{name}"), "svg")?)?;
            }
        }
        Ok(())
    }
}

/// Text of a number in a table; empty where there is none.
fn cell_text(value: Option<f64>) -> String {
    value.filter(|value| !value.is_nan()).map_or(String::new(), |value| format!("{value:e}"))
}

/// Writes lines of cells as a CSV file.
fn write_lines(path: &Path, lines: &[Vec<String>]) -> Result<(), OutputError> {
    let fail = |error: &dyn std::fmt::Display| OutputError::new(path, error);
    let mut writer = csv::Writer::from_writer(Vec::new());
    lines.iter().try_for_each(|line| writer.write_record(line)).map_err(|error| fail(&error))?;
    write_atomically(path, &writer.into_inner().map_err(|error| fail(&error))?)
}

/// Reads the row of a run from its folder.
///
/// # Errors
/// When its files cannot be read.
pub(super) fn read_row(folder: &Path, values: Vec<Value>) -> Result<SweepRow, OutputError> {
    let path = folder.join("summary.json");
    let summary = read_json(&path)?;
    let mut measures = Vec::new();
    if let Some(found) = summary["factors_of_safety"].as_object() {
        measures.extend(found.iter().map(|(name, safety)| {
            (name.clone(), String::new(), safety["factor"].as_f64().unwrap_or(f64::NAN))
        }));
    }
    let table = folder.join("measures.csv");
    if table.exists() {
        let table = Table::read(&table)?;
        let last = table.rows.last().cloned().unwrap_or_default();
        measures.extend(table.columns.into_iter().zip(last).map(|((name, unit), value)| (name, unit, value)));
    }
    // Requested measures come first.
    let is_requested =
        |name: &str| summary["case"]["measures"].get(name.split('.').next().unwrap_or(name)).is_some();
    measures.sort_by_key(|(name, ..)| !is_requested(name));
    Ok(SweepRow {
        values,
        status: summary["status"].as_str().unwrap_or_default().to_owned(),
        reason: summary["reason"].as_str().map(str::to_owned),
        measures,
        wall_time: summary["wall_time"].as_f64().unwrap_or(f64::NAN),
    })
}
