//! Sweeps: runs of one case with varied parameters, for sensitivity, back-analysis and convergence.

mod convergence;
mod exceedance;
mod intensity;
pub(crate) mod json_path;
mod results_table;
mod run;
pub(crate) mod sampling_plan;

use std::collections::BTreeMap;
use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::case::files::json;
use crate::case::output::{PLAIN_NAME_RULE, is_plain};
use crate::case::{Case, CaseError, CaseErrorKind, CaseErrors};

pub use crate::sweep::results_table::{SweepResults, SweepRow};
pub use crate::sweep::sampling_plan::SamplingPlan;
pub use convergence::{ConvergenceOrder, observed_order};
pub use intensity::IntensityClass;
pub use run::{SweepError, SweepOptions, SweepRunState, run_folder, run_sweep};

/// Sweep of a case over values of its parameters, as described in its file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// Title of the sweep, in one line.
    pub title: String,
    /// Path of the case file, relative to the folder of the sweep's file.
    pub case: String,
    /// Name of the method; needed when the case has options for several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<String>,
    /// Varied parameters, by names of your own, of letters, digits, `_` and `-`: the columns of the table.
    pub parameters: BTreeMap<String, SweepParameter>,
    /// Sampling plan: combinations of values that are run.
    #[serde(default)]
    pub plan: SamplingPlan,
    /// Observed values, by the name of a column of the measures: the table has the difference of each run from them.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub targets: BTreeMap<String, ObservedTarget>,
    /// Thresholds of the rasters of the runs, by the name of the raster: `peak_thickness_vertical`, `final_thickness_vertical` (m),
    /// `peak_velocity` (m/s), `peak_dynamic_pressure` (Pa). For each threshold the sweep writes a raster with the share of the runs that
    /// reach it.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub exceedance: BTreeMap<String, Vec<f64>>,
    /// Intensity classes, from the weakest to the strongest, such as those of thickness and velocity in hazard maps. The sweep writes a
    /// raster with the strongest class of any run in each cell, and for each class one with the share of the runs that have it or a
    /// stronger one there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub intensities: Vec<IntensityClass>,
    /// Convergence study in one of the parameters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub convergence: Option<ConvergenceStudy>,
}

/// Varied parameter of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepParameter {
    /// JSON paths of the value in the case, as in error messages: `materials.sand.friction_angle`, `bodies[0].shape.max[1]`. Several
    /// paths get one value.
    #[serde(rename = "at")]
    pub paths: Vec<String>,
    /// Values of the parameter: numbers, words or true and false.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<Value>,
    /// Least and largest value, in place of `values`, for plans that draw values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Distribution of the values over the range.
    #[serde(default)]
    pub scale: ParameterScale,
}

/// Distribution of values over a range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ParameterScale {
    /// Uniform distribution of the values.
    #[default]
    Linear,
    /// Uniform distribution of the logarithms, for stiffness and permeability.
    Logarithmic,
}

/// Observed value of a measure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObservedTarget {
    /// Observed value, in the unit of the measure.
    pub value: f64,
    /// Uncertainty of the value, in its unit: a run with this difference has a misfit of one.
    pub tolerance: f64,
}

/// Convergence study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConvergenceStudy {
    /// Name of the refined parameter, such as a cell size, a spacing or a time step: smaller values are finer.
    pub parameter: String,
    /// Columns of the measures whose last values are compared.
    pub measures: Vec<String>,
}

/// Case of a sweep.
#[derive(Clone, Debug)]
pub struct SweepCase {
    /// Values of the parameters, in the order of their names.
    pub values: Vec<Value>,
    /// Case with these values.
    pub case: Case,
}

impl Sweep {
    /// Reads a sweep and builds its cases.
    ///
    /// # Errors
    /// When a file cannot be read, and all errors of the sweep or of its cases, each with its JSON path.
    pub fn load(path: &Path) -> Result<(Self, Vec<SweepCase>), CaseErrors> {
        let sweep: Self = json::read_file(path)?;
        sweep.validate()?;
        let file = path.parent().unwrap_or(Path::new("")).join(&sweep.case);
        let (base, folder) = (json::value(&file)?, file.parent().unwrap_or(Path::new("")));
        let case = Case::from_value(&base, folder).map_err(|errors| errors.with_file_name(&file))?;
        let members = sweep.checked_cases(&case, &base, folder)?;
        Ok((sweep, members))
    }

    /// Reads a sweep from its text and builds its cases from a base case, whose files are in `folder`. The path of the case in the text is
    /// not read.
    ///
    /// # Errors
    /// As [`Sweep::load`].
    pub fn of_case(text: &str, base: &Value, folder: &Path) -> Result<(Self, Vec<SweepCase>), CaseErrors> {
        let sweep: Self = json::read(text)?;
        sweep.validate()?;
        let members = sweep.checked_cases(&Case::from_value(base, folder)?, base, folder)?;
        Ok((sweep, members))
    }

    /// Checks the rasters of the sweep against the base case, and builds its cases.
    fn checked_cases(&self, case: &Case, base: &Value, folder: &Path) -> Result<Vec<SweepCase>, CaseErrors> {
        self.check_exceedance(case)?;
        self.check_intensities(case)?;
        self.cases(base, folder)
    }

    /// JSON Schema of a sweep's file.
    pub fn schema() -> Value {
        schemars::schema_for!(Self).to_value()
    }

    /// Builds the cases of the sweep from its base case and the folder of its file, in the order of their runs.
    ///
    /// # Errors
    /// All errors of the cases with their parameters, by run and JSON path.
    pub fn cases(&self, base: &Value, folder: &Path) -> Result<Vec<SweepCase>, CaseErrors> {
        let parameters: Vec<(&String, &SweepParameter)> = self.parameters.iter().collect();
        let mut members = Vec::new();
        for (number, values) in self.plan.values(&self.parameters).into_iter().enumerate() {
            let mut case = base.clone();
            for ((name, parameter), value) in parameters.iter().zip(&values) {
                for (k, at) in parameter.paths.iter().enumerate() {
                    json_path::set_value(&mut case, at, value).map_err(|problem| {
                        CaseError::new(
                            format!("parameters.{name}.at[{k}]"),
                            CaseErrorKind::coded("sweep-path", problem),
                        )
                    })?;
                }
            }
            let case = Case::from_value(&case, folder)
                .map_err(|errors| self.with_run_context(number, &values, errors))?;
            members.push(SweepCase { values, case });
        }
        Ok(members)
    }

    /// Errors of a case of a sweep, each preceded by the number of the run and its values.
    pub fn with_run_context(&self, number: usize, values: &[Value], errors: CaseErrors) -> CaseErrors {
        let of = self.run_description(number, values);
        let located = errors.0.into_iter().map(|e| CaseError::new(format!("{of}: {}", e.path), e.kind));
        CaseErrors(located.collect())
    }

    /// Text that identifies a run: `run 3 (friction = 25, width = 0.1)`.
    pub fn run_description(&self, number: usize, values: &[Value]) -> String {
        let named =
            self.parameters.keys().zip(values).map(|(name, value)| format!("{name} = {}", table_text(value)));
        format!("run {} ({})", number + 1, named.collect::<Vec<_>>().join(", "))
    }

    /// Checks the column names in targets and in the convergence study against those of the runs.
    ///
    /// # Errors
    /// Every unknown name, with its JSON path.
    pub fn check_columns(&self, columns: &[String]) -> Result<(), CaseErrors> {
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        let targets = self.targets.keys().map(|name| (format!("targets.{name}"), name));
        let measures = self.convergence.iter().flat_map(|study| study.measures.iter().enumerate());
        let measures = measures.map(|(k, name)| (format!("convergence.measures[{k}]"), name));
        let unknown = targets.chain(measures).filter(|(_, name)| !columns.contains(&name.as_str()));
        let errors: Vec<CaseError> = unknown
            .map(|(path, name)| {
                CaseError::new(path, CaseErrorKind::unknown_name(name, &columns, "a column of the measures"))
            })
            .collect();
        if errors.is_empty() { Ok(()) } else { Err(CaseErrors(errors)) }
    }

    /// Checks the sweep beyond its schema.
    fn validate(&self) -> Result<(), CaseErrors> {
        let mut errors = Vec::new();
        let mut wrong = |path: String, problem: &str| errors.push(CaseError::new(path, problem));
        if self.parameters.is_empty() {
            wrong("parameters".into(), "is empty: give at least one parameter");
        }
        for (name, parameter) in &self.parameters {
            if !is_plain(name) {
                wrong(format!("parameters.{name}"), PLAIN_NAME_RULE);
            }
            if let Some((key, problem)) = parameter.validation_error() {
                wrong(format!("parameters.{name}.{key}"), &problem);
            }
        }
        let mut places = BTreeMap::<&str, &str>::new();
        for (name, parameter) in &self.parameters {
            for (number, place) in parameter.paths.iter().enumerate() {
                if let Some(other) = places.insert(place, name) {
                    let problem = format!("{place} is set by the parameter {other:?} already");
                    wrong(format!("parameters.{name}.at[{number}]"), &problem);
                }
            }
        }
        for (path, problem) in self.plan.validation_errors(&self.parameters) {
            wrong(path, &problem);
        }
        for (name, target) in &self.targets {
            if !(target.tolerance > 0.0 && target.tolerance.is_finite()) {
                wrong(format!("targets.{name}.tolerance"), &format!("{} is not above 0", target.tolerance));
            }
            if !target.value.is_finite() {
                wrong(format!("targets.{name}.value"), "is not a number");
            }
        }
        if let Some(study) = &self.convergence {
            let problem = match self.parameters.get(&study.parameter) {
                None => Some("is not one of the parameters"),
                Some(parameter)
                    if !parameter.values.iter().all(is_positive) || parameter.values.len() < 3 =>
                {
                    Some("needs three or more values, all of them numbers above 0")
                }
                Some(_) => None,
            };
            if let Some(problem) = problem {
                wrong("convergence.parameter".into(), problem);
            }
            if study.measures.is_empty() {
                wrong("convergence.measures".into(), "is empty: give at least one measure");
            }
        }
        if errors.is_empty() { Ok(()) } else { Err(CaseErrors(errors)) }
    }
}

impl SweepParameter {
    /// Key and problem of the first error.
    fn validation_error(&self) -> Option<(&'static str, String)> {
        let plain = |value: &Value| value.is_number() || value.is_string() || value.is_boolean();
        if self.paths.is_empty() {
            return Some(("at", "is empty: give at least one path in the case".into()));
        }
        match (self.range, self.values.is_empty()) {
            (None, true) => Some(("values", "is missing; give values or a range".into())),
            (Some(_), false) => Some(("range", "is given beside values; give only one of them".into())),
            (None, false) if self.scale != ParameterScale::Linear => {
                Some(("scale", "applies to a range only".into()))
            }
            (None, false) => {
                let odd = self.values.iter().position(|value| !plain(value))?;
                Some(("values", format!("{} is not a number, a word, true or false", self.values[odd])))
            }
            (Some([low, high]), true) if !(low < high && low.is_finite() && high.is_finite()) => {
                Some(("range", format!("{low} is not below {high}")))
            }
            (Some([low, _]), true) if self.scale == ParameterScale::Logarithmic && low <= 0.0 => {
                Some(("range", format!("{low} is not above 0, which a logarithmic scale requires")))
            }
            (Some(_), true) => None,
        }
    }

    /// Value at a fraction of the range, from 0 to below 1.
    fn value_at_fraction(&self, fraction: f64) -> Value {
        match (self.range, self.scale) {
            (Some([low, high]), ParameterScale::Linear) => (low + fraction * (high - low)).into(),
            (Some([low, high]), ParameterScale::Logarithmic) => (low * (high / low).powf(fraction)).into(),
            (None, _) => {
                let index = (fraction * self.values.len() as f64) as usize;
                self.values[index.min(self.values.len() - 1)].clone()
            }
        }
    }
}

/// Value as text of a table, without quotes.
fn table_text(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// Whether a JSON value is a positive number.
fn is_positive(value: &Value) -> bool {
    value.as_f64().is_some_and(|value| value > 0.0)
}

#[cfg(test)]
mod tests;
