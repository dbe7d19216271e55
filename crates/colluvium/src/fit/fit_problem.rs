//! Problem of a fit: residuals of the tests for values of the parameters, and the parameters with the smallest ones.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use serde_json::Value;

use crate::case::{CaseError, CaseErrors};
use crate::constitutive::MaterialSpec;
use crate::constitutive::driver::{DriverError, ElementTest, TestProblem, TestTrace};
use crate::fit::laboratory_data::{LaboratoryData, MeasuredCurve};
use crate::fit::least_squares::{LeastSquares, ResidualPoint, by_mean_square, central_jacobian};
use crate::fit::parameter_range::ParameterRanges;
use crate::fit::parameter_uncertainty::ParameterUncertainty;
use crate::fit::stage_curves::{StageCurves, TestFailure};
use crate::fit::{Fit, FitParameter};
use crate::sweep::sampling_plan::{SOBOL_DIMENSIONS, sobol};

/// Number of local searches from the best points of the global search.
const LOCAL_SEARCHES: usize = 3;
/// Smallest distance of their starts (share of a range).
const START_DISTANCE: f64 = 0.1;
/// Increase of the sum of squares over its variance within which another minimum fits equally well: two standard deviations.
const EQUAL_FIT: f64 = 4.0;
/// Distance of another minimum that is reported (share of a range).
const OTHER_DISTANCE: f64 = 0.25;
/// Increases of the mean square that are accepted for a plainer value: relative and absolute.
const PLAIN_VALUE: [f64; 2] = [1e-4, 1e-8];

/// Fit with its data, checked.
pub struct FitProblem {
    /// Description of the fit.
    pub fit: Fit,
    /// Data of the tests, in their order.
    pub data: Vec<LaboratoryData>,
    pub(super) ranges: ParameterRanges,
}

/// Fitted value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedParameter {
    /// JSON path in the material.
    pub name: String,
    /// Unit; empty without one.
    pub unit: String,
    /// Start value.
    pub start: f64,
    /// Fitted value.
    pub fitted: f64,
    /// Standard deviation, in the unit of the value.
    pub deviation: f64,
    /// Whether the tests determine the value.
    pub is_determined: bool,
    /// Range and scale.
    pub range: FitParameter,
}

/// Minimum other than the best one that fits the data equally well.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherMinimum {
    /// Misfit.
    pub misfit: f64,
    /// Values of the parameters.
    pub values: Vec<f64>,
}

/// Result of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct FitSolution {
    /// Parameters, in the order of their names.
    pub parameters: Vec<FittedParameter>,
    /// Correlations of the parameters, row by row.
    pub correlations: Vec<Vec<f64>>,
    /// Root mean square of the differences over their tolerances, with the start values.
    pub start_misfit: f64,
    /// Root mean square of the differences over their tolerances, with the fitted values.
    pub misfit: f64,
    /// Misfit of each curve of each test.
    pub curve_misfits: Vec<Vec<f64>>,
    /// Number of evaluations of all tests.
    pub evaluations: usize,
    /// Whether the search ended at its limit of evaluations.
    pub is_exhausted: bool,
    /// Number of evaluations that failed.
    pub failures: usize,
    /// One of their reasons: the first in alphabetical order.
    pub failure_reason: Option<String>,
    /// Another minimum that fits equally well.
    pub other_minimum: Option<OtherMinimum>,
}

impl FitProblem {
    /// Checks a fit whose file has the value `material`, and reads its data from the folder of the file.
    ///
    /// # Errors
    /// All errors of the fit, of its files, and of the tests with the start values.
    pub fn new(fit: Fit, material: &Value, folder: &Path) -> Result<Self, CaseErrors> {
        crate::register_materials();
        fit.validate()?;
        if fit.parameters.len() > SOBOL_DIMENSIONS {
            let problem =
                format!("are {}, and {SOBOL_DIMENSIONS} can be fitted at most", fit.parameters.len());
            return Err(CaseError::new("parameters", problem).into());
        }
        let ranges = ParameterRanges::new(&fit, material)?;
        let mut problem = Self { fit, data: Vec::new(), ranges };
        let mut errors: Vec<CaseError> = Vec::new();
        for test in 0..problem.fit.tests.len() {
            match problem.read_test(test, folder) {
                Ok(data) => problem.data.push(data),
                // Errors of the material appear once.
                Err(found) => {
                    errors.extend(found.0.into_iter().filter(|e| !errors.contains(e)).collect::<Vec<_>>());
                }
            }
        }
        if !errors.is_empty() {
            return Err(CaseErrors(errors));
        }
        let (values, parameters) = (problem.value_count(), problem.fit.parameters.len());
        if values < parameters {
            let text = format!("are {parameters}, but the data have only {values} values");
            return Err(CaseError::new("parameters", text).into());
        }
        Ok(problem)
    }

    /// Number of all measured values.
    pub fn value_count(&self) -> usize {
        self.data.iter().flat_map(|data| &data.curves).map(|curve| curve.values.len()).sum()
    }

    /// Reads the data of a test and compares it with the start values.
    fn read_test(&self, number: usize, folder: &Path) -> Result<LaboratoryData, CaseErrors> {
        let (test, at) = (&self.fit.tests[number], format!("tests[{number}]"));
        let trace =
            self.trace(number, &self.ranges.start).map_err(|error| self.test_errors(number, error))?;
        let data = LaboratoryData::read(&test.data, &trace.path.columns, folder, &format!("{at}.data"))?;
        let compared =
            StageCurves::new(trace, &test.data).and_then(|curves| curves.at_data(&test.data.over, &data));
        let file = &test.data.file;
        compared.map(|_| data).map_err(|failure| match failure {
            TestFailure::Driver(error) => self.test_errors(number, error),
            TestFailure::NotMonotone { .. } => {
                CaseError::new(format!("{at}.data.over"), failure.to_string()).into()
            }
            TestFailure::OutOfRange { .. } => {
                CaseError::new(format!("{at}.data.file"), format!("{file}: {failure}")).into()
            }
            _ => CaseError::new(format!("{at}.data"), failure.to_string()).into(),
        })
    }

    /// Errors of a test with the start values, at their paths in the file.
    fn test_errors(&self, number: usize, error: DriverError) -> CaseErrors {
        let own = |name: &str| self.fit.tests[number].material.contains_key(name);
        match error {
            DriverError::Invalid(problems) => {
                let located = problems.into_iter().map(|found| {
                    let path = match found.path.strip_prefix("material.") {
                        Some(name) if !own(name) => found.path,
                        None if found.path == "material" => found.path,
                        _ => format!("tests[{number}].{}", found.path),
                    };
                    CaseError::new(path, found.problem)
                });
                CaseErrors(located.collect())
            }
            other => {
                let problem = format!("with the start values the test stops before its data: {other}");
                CaseError::new(format!("tests[{number}].stages"), problem).into()
            }
        }
    }

    /// Runs a test with values of the parameters.
    fn trace(&self, number: usize, values: &[f64]) -> Result<TestTrace, DriverError> {
        let test = &self.fit.tests[number];
        let material = self.ranges.material_value(values, test.material.iter());
        let material: MaterialSpec = serde_json::from_value(material).map_err(|error| {
            DriverError::Invalid(vec![TestProblem {
                path: "material".to_owned(),
                problem: error.to_string(),
            }])
        })?;
        let (title, stages) = (test.name.clone(), test.stages.clone());
        ElementTest { title, material, initial_stress: test.initial_stress, stages }.trace()
    }

    /// Curves of a test with values of the parameters; `None` if they cannot be computed.
    pub fn stage_curves(&self, test: usize, values: &[f64]) -> Option<StageCurves> {
        let trace = self.trace(test, values).ok()?;
        StageCurves::new(trace, &self.fit.tests[test].data).ok()
    }

    /// Computed values of the curves of a test at the abscissae of its data.
    ///
    /// # Errors
    /// The reason why there are none.
    pub fn computed(&self, test: usize, values: &[f64]) -> Result<Vec<Vec<f64>>, String> {
        let data = &self.fit.tests[test].data;
        let trace = self.trace(test, values).map_err(TestFailure::Driver);
        let curves = trace.and_then(|trace| StageCurves::new(trace, data));
        let found = curves.and_then(|curves| curves.at_data(&data.over, &self.data[test]));
        found.map_err(|failure| format!("{}: {failure}", self.fit.tests[test].name))
    }

    /// Differences of the tests from their data over the tolerances, test by test and curve by curve.
    ///
    /// # Errors
    /// The reason why a test cannot be compared.
    pub fn residuals(&self, values: &[f64]) -> Result<Vec<Vec<Vec<f64>>>, String> {
        let of_test = |(test, data): (usize, &LaboratoryData)| {
            let computed = self.computed(test, values)?;
            let of_curve = |(curve, computed): (&MeasuredCurve, &Vec<f64>)| {
                let pairs = curve.values.iter().zip(computed);
                pairs.map(|(measured, computed)| (computed - measured.y) / curve.tolerance).collect()
            };
            Ok(data.curves.iter().zip(&computed).map(of_curve).collect())
        };
        self.data.iter().enumerate().map(of_test).collect()
    }

    /// Searches the parameters with the smallest misfit.
    pub fn solve(&self) -> FitSolution {
        let failed = Mutex::new((0, None::<String>));
        let residuals = |point: &[f64]| match self.residuals(&self.ranges.values(point)) {
            Ok(found) => Some(found.into_iter().flatten().flatten().collect()),
            Err(reason) => {
                let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                failed.0 += 1;
                if failed.1.as_ref().is_none_or(|first| reason < *first) {
                    failed.1 = Some(reason);
                }
                None
            }
        };
        let search = LeastSquares::new(&residuals, self.fit.evaluations());
        let (start, minima) = self.local_minima(&search);
        let best = search.minimise(minima[0].clone());
        let jacobian = central_jacobian(&residuals, &best);
        let mut uncertainty = ParameterUncertainty::new(&jacobian, &best.residuals);
        let (values, best) = self.plain_values(best, &uncertainty);
        uncertainty = ParameterUncertainty::new(&jacobian, &best.residuals);
        let evaluations = search.evaluations() + 2 * values.len();
        let (failures, failure_reason) = failed.lock().unwrap_or_else(PoisonError::into_inner).clone();
        FitSolution {
            parameters: self.fitted_parameters(&values, &uncertainty),
            start_misfit: start.mean_square.sqrt(),
            misfit: best.mean_square.sqrt(),
            curve_misfits: self.curve_misfits(&best.residuals),
            evaluations,
            is_exhausted: search.is_exhausted(),
            failures,
            failure_reason,
            other_minimum: self.other_minimum(&best, &minima[1..], &uncertainty),
            correlations: uncertainty.correlations,
        }
    }

    /// The start, and the minima of local searches from the best points of the global one, with the best one first.
    fn local_minima(&self, search: &LeastSquares<'_>) -> (ResidualPoint, Vec<ResidualPoint>) {
        let mut samples = vec![self.ranges.start_point()];
        let count = self.fit.samples().saturating_sub(1);
        samples.extend(sobol(count, self.fit.parameters.len(), self.fit.search.seed));
        let mut points: Vec<ResidualPoint> = search.evaluate(&samples).into_iter().flatten().collect();
        // The start has been computed before.
        let start = points[0].clone();
        points.sort_by(by_mean_square);
        let mut starts: Vec<ResidualPoint> = Vec::new();
        for point in points {
            let is_apart = |other: &ResidualPoint| distance(&point.point, &other.point) > START_DISTANCE;
            if starts.len() < LOCAL_SEARCHES && starts.iter().all(is_apart) {
                starts.push(point);
            }
        }
        let mut minima: Vec<ResidualPoint> =
            starts.into_iter().map(|start| search.levenberg_marquardt(start)).collect();
        minima.sort_by(by_mean_square);
        (start, minima)
    }

    /// Values of a minimum. Undetermined parameters keep their start values, and others are rounded to six digits, unless that increases
    /// the misfit.
    fn plain_values(
        &self,
        best: ResidualPoint,
        uncertainty: &ParameterUncertainty,
    ) -> (Vec<f64>, ResidualPoint) {
        let (mut values, mut best) = (self.ranges.values(&best.point), best);
        let limit = best.mean_square * (1.0 + PLAIN_VALUE[0]) + PLAIN_VALUE[1];
        for (k, range) in self.ranges.ranges.iter().enumerate() {
            let [low, high] = range.range;
            let rounded = format!("{:.5e}", values[k]).parse().unwrap_or(values[k]).clamp(low, high);
            let start = (!uncertainty.is_determined(k)).then_some(self.ranges.start[k]);
            for value in start.into_iter().chain([rounded]) {
                let mut trial = values.clone();
                trial[k] = value;
                if let Some(found) = self.point_at(&trial).filter(|found| found.mean_square <= limit) {
                    (values, best) = (trial, found);
                    break;
                }
            }
        }
        (values, best)
    }

    /// Point of the unit cube with values of the parameters and its residuals; `None` where a test fails.
    fn point_at(&self, values: &[f64]) -> Option<ResidualPoint> {
        let residuals: Vec<f64> = self.residuals(values).ok()?.into_iter().flatten().flatten().collect();
        let mean_square = mean_square(&residuals);
        Some(ResidualPoint { point: self.ranges.point(values), residuals, mean_square })
    }

    /// Fitted parameters with their standard deviations.
    fn fitted_parameters(&self, values: &[f64], uncertainty: &ParameterUncertainty) -> Vec<FittedParameter> {
        let ranges = &self.ranges;
        let parameter = |k: usize| FittedParameter {
            name: ranges.names[k].clone(),
            unit: ranges.units[k].clone(),
            start: ranges.start[k],
            fitted: values[k],
            deviation: uncertainty.deviations[k] * ranges.ranges[k].slope(values[k]),
            is_determined: uncertainty.is_determined(k),
            range: ranges.ranges[k],
        };
        (0..values.len()).map(parameter).collect()
    }

    /// Misfit of each curve of each test, from the residuals of all.
    fn curve_misfits(&self, residuals: &[f64]) -> Vec<Vec<f64>> {
        let mut rest = residuals;
        let mut misfit = |curve: &MeasuredCurve| {
            let (own, others) = rest.split_at(curve.values.len());
            rest = others;
            mean_square(own).sqrt()
        };
        self.data.iter().map(|data| data.curves.iter().map(&mut misfit).collect()).collect()
    }

    /// Another minimum that fits equally well, with other values of the determined parameters.
    fn other_minimum(
        &self,
        best: &ResidualPoint,
        minima: &[ResidualPoint],
        uncertainty: &ParameterUncertainty,
    ) -> Option<OtherMinimum> {
        let count = best.residuals.len() as f64;
        let is_other = |other: &&ResidualPoint| {
            let increase = (other.mean_square - best.mean_square) * count / best.mean_square.max(1.0);
            let pairs = best.point.iter().zip(&other.point).enumerate();
            let differs = |(k, (a, b)): (usize, (&f64, &f64))| {
                uncertainty.is_determined(k) && (a - b).abs() > OTHER_DISTANCE
            };
            increase < EQUAL_FIT && pairs.into_iter().any(differs)
        };
        minima.iter().find(is_other).map(|other| OtherMinimum {
            misfit: other.mean_square.sqrt(),
            values: self.ranges.values(&other.point),
        })
    }

    /// JSON value of the material with the fitted values.
    pub fn fitted_material(&self, solution: &FitSolution) -> Value {
        let values: Vec<f64> = solution.parameters.iter().map(|parameter| parameter.fitted).collect();
        self.ranges.material_value(&values, std::iter::empty())
    }
}

/// Mean square of numbers.
fn mean_square(numbers: &[f64]) -> f64 {
    numbers.iter().map(|number| number * number).sum::<f64>() / numbers.len() as f64
}

/// Largest difference of coordinates.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |largest, (a, b)| largest.max((a - b).abs()))
}
