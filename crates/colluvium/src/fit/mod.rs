//! Fits: parameters of a constitutive law from laboratory tests.
//!
//! A [`Fit`] has a material with start values, ranges of its varied parameters, and tests with data. [`FitProblem`] computes the
//! difference of the tests from their data, [`FitProblem::solve`] the parameters with the smallest one and their uncertainty.

mod fit_problem;
mod fit_remarks;
mod fit_results;
mod laboratory_data;
mod least_squares;
mod parameter_range;
mod parameter_uncertainty;
mod stage_curves;

use std::collections::BTreeMap;
use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::case::files::json;
use crate::case::output::{PLAIN_NAME_RULE, is_plain};
use crate::case::{CaseError, CaseErrors};
use crate::constitutive::MaterialSpec;
use crate::constitutive::driver::TestStage;
use crate::fit::fit_results::TABLES;
use crate::sweep::ParameterScale;

pub use crate::fit::fit_problem::{FitProblem, FitSolution, FittedParameter, OtherMinimum};
pub use crate::fit::fit_remarks::{short, uncertainty_text};
pub use crate::fit::fit_results::{FitError, FitFolder};
pub use crate::fit::laboratory_data::{LaboratoryData, MeasuredCurve, MeasuredValue};
pub use crate::fit::parameter_uncertainty::ParameterUncertainty;
pub use crate::fit::stage_curves::StageCurves;

/// Number of points of the global search per parameter.
const SAMPLES: usize = 16;
/// Largest number of evaluations per parameter.
const EVALUATIONS: usize = 300;
/// Share of the largest absolute value of a curve that is its tolerance if the file gives none.
const RELATIVE_TOLERANCE: f64 = 0.05;

/// Fit of a material to laboratory tests, as described in its file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fit {
    /// Title of the fit, in one line.
    pub title: String,
    /// Longer notes; ignored.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Material with the start values of the fitted parameters.
    pub material: MaterialSpec,
    /// Fitted parameters, by their JSON path in the material: `youngs_modulus`, `softening.residual_cohesion`.
    pub parameters: BTreeMap<String, FitParameter>,
    /// Laboratory tests.
    pub tests: Vec<LaboratoryTest>,
    /// Settings of the search.
    #[serde(default)]
    pub search: SearchSettings,
}

/// Fitted parameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FitParameter {
    /// Least and largest value.
    pub range: [f64; 2],
    /// Measure of distances in the range.
    #[serde(default)]
    pub scale: ParameterScale,
}

/// Laboratory test: an element test with the measured curves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LaboratoryTest {
    /// Name of the test, of letters, digits, `_` and `-`: the name of its table.
    pub name: String,
    /// Parameters of the material that this test has of its own, by their JSON path: `void_ratio` of the specimen.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub material: BTreeMap<String, f64>,
    /// Initial stress (Pa, tension-positive): xx yy zz xy yz zx.
    #[serde(default)]
    pub initial_stress: [f64; 6],
    /// Stages of the test, in order.
    pub stages: Vec<TestStage>,
    /// Measured curves.
    pub data: DataFile,
}

/// File with the data of a test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DataFile {
    /// CSV file, relative to the folder of the fit's file.
    pub file: String,
    /// Stage with which the data begin, from 0. Strains, work, pore pressure and time count from its beginning.
    #[serde(default)]
    pub stage: usize,
    /// Column of the element test along which data and computation are compared. It must rise or fall throughout the data's stages.
    pub over: String,
    /// Compared curves, by the name of their column of the element test.
    pub curves: BTreeMap<String, CurveSettings>,
    /// Headings in the file of columns that have another name there, by the name of the column of the element test.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub columns: BTreeMap<String, String>,
}

/// Settings of a compared curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurveSettings {
    /// Uncertainty of a value, in SI units; by default 5 % of the largest absolute value of the curve.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// Factor of the data, such as -1 for data with the opposite sign.
    #[serde(default = "one")]
    pub factor: f64,
}

/// Default factor of the data.
fn one() -> f64 {
    1.0
}

/// Settings of the search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SearchSettings {
    /// Number of points of the global search; by default 16 per parameter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub samples: Option<usize>,
    /// Largest number of evaluations of all tests; by default 300 per parameter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evaluations: Option<usize>,
    /// Seed of the global search.
    #[serde(default)]
    pub seed: u32,
}

impl Fit {
    /// Reads a fit with its data.
    ///
    /// # Errors
    /// When a file cannot be read, and all errors of the fit, each with its JSON path.
    pub fn load(path: &Path) -> Result<FitProblem, CaseErrors> {
        let text = json::text(path)?;
        let value = json::parse(&text).map_err(|error| CaseErrors::from_error(error).with_file_name(path))?;
        let fit: Self = json::from_value(&value, "")?;
        FitProblem::new(fit, &value["material"], path.parent().unwrap_or(Path::new("")))
    }

    /// JSON Schema of a fit's file.
    pub fn schema() -> Value {
        schemars::schema_for!(Self).to_value()
    }

    /// Number of points of the global search, the start included.
    pub fn samples(&self) -> usize {
        self.search.samples.unwrap_or(SAMPLES * self.parameters.len())
    }

    /// Largest number of evaluations of all tests.
    pub fn evaluations(&self) -> usize {
        self.search.evaluations.unwrap_or(EVALUATIONS * self.parameters.len())
    }

    /// Checks the fit beyond its schema, without its data.
    fn validate(&self) -> Result<(), CaseErrors> {
        let mut errors = Vec::new();
        let mut wrong = |path: String, problem: String| errors.push(CaseError::new(path, problem));
        if self.parameters.is_empty() {
            wrong("parameters".into(), "is empty: give at least one parameter".into());
        }
        if self.tests.is_empty() {
            wrong("tests".into(), "is empty: give at least one test".into());
        }
        for (name, parameter) in &self.parameters {
            if let Some(problem) = parameter.range_problem() {
                wrong(format!("parameters.{name}.range"), problem);
            }
        }
        for (key, number) in [("samples", self.search.samples), ("evaluations", self.search.evaluations)] {
            if number == Some(0) {
                wrong(format!("search.{key}"), "0 is not above 0".into());
            }
        }
        for (number, test) in self.tests.iter().enumerate() {
            let first = self.tests.iter().position(|other| other.name == test.name);
            if first != Some(number) {
                wrong(
                    format!("tests[{number}].name"),
                    format!("{:?} is the name of another test", test.name),
                );
            }
            for (key, problem) in test.problems(&self.parameters) {
                wrong(format!("tests[{number}].{key}"), problem);
            }
        }
        if errors.is_empty() { Ok(()) } else { Err(CaseErrors(errors)) }
    }
}

impl LaboratoryTest {
    /// Keys and problems of all errors that need no data.
    fn problems(&self, parameters: &BTreeMap<String, FitParameter>) -> Vec<(String, String)> {
        let mut found = Vec::new();
        let mut wrong = |key: &str, problem: String| found.push((key.to_owned(), problem));
        if !is_plain(&self.name) {
            wrong("name", PLAIN_NAME_RULE.to_owned());
        } else if TABLES.contains(&self.name.as_str()) {
            wrong("name", format!("{:?} is the name of another table of the results", self.name));
        }
        for own in self.material.keys().filter(|own| parameters.contains_key(*own)) {
            wrong(&format!("material.{own}"), "is a fitted parameter: remove it here or there".to_owned());
        }
        let data = &self.data;
        if data.stage >= self.stages.len() {
            let count = self.stages.len();
            wrong("data.stage", format!("{} is not below the number of stages, {count}", data.stage));
        }
        if data.curves.is_empty() {
            wrong("data.curves", "is empty: give at least one curve".to_owned());
        }
        for (name, curve) in &data.curves {
            let key = |key: &str| format!("data.curves.{name}{key}");
            if *name == data.over {
                wrong(&key(""), "is the abscissa of the curves".to_owned());
            }
            if let Some(tolerance) = curve.tolerance.filter(|value| !(*value > 0.0 && value.is_finite())) {
                wrong(&key(".tolerance"), format!("{tolerance} is not above 0"));
            }
            if curve.factor == 0.0 || !curve.factor.is_finite() {
                wrong(&key(".factor"), format!("{} is not a number other than 0", curve.factor));
            }
        }
        for name in data.columns.keys().filter(|name| **name != data.over && !data.curves.contains_key(*name))
        {
            wrong(&format!("data.columns.{name}"), "is neither the abscissa nor a curve".to_owned());
        }
        found
    }
}

#[cfg(test)]
mod tests;
