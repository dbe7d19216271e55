//! Checks of a test before it is run.

use std::fmt;

use crate::driver::loading_path::LoadingPath;
use crate::driver::path_control::{Control, ControlEquations};
use crate::driver::{ElementSpecimen, ElementTest, TestStage, step_solver};
use crate::{Mat3, MaterialError, SymTensor};

/// Problem in the description of a test with the path of the value, such as `stages[1].path.b: 2 is not in 0..=1`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TestProblem {
    /// JSON path of the value.
    pub path: String,
    /// Description of the problem.
    pub problem: String,
}

impl fmt::Display for TestProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.path, self.problem)
    }
}

/// Text of the problems, one per line.
pub(super) fn problem_lines(problems: &[TestProblem]) -> String {
    let lines: Vec<String> = problems.iter().map(ToString::to_string).collect();
    lines.join("\n")
}

/// Largest number of steps of a stage, which bounds the memory for the rows of the path.
const MAX_STEPS: usize = 1_000_000;
/// Largest logarithmic axial strain of a stage.
const MAX_AXIAL_STRAIN: f64 = 4.0;

/// Largest strain of a step; with a larger one the deformation gradient of the step may invert.
const LARGEST_STRAIN: f64 = 1.0;

/// Message on a reversal as the first stage.
pub(super) const NOTHING_TO_REVERSE: &str = "there is no stage before it to reverse";

/// Problem from an error of a law, at the path of its parameter.
pub(super) fn material_problem(error: &MaterialError) -> TestProblem {
    let (path, problem) = match error {
        error if let Some((field, problem)) = error.parameter_problem() => {
            (format!("material.{field}"), problem)
        }
        MaterialError::Initial { reason, .. } => ("initial_stress".to_owned(), reason.clone()),
        other => ("material".to_owned(), other.to_string()),
    };
    TestProblem { path, problem }
}

/// All problems of `test`.
pub(super) fn problems(test: &ElementTest) -> Vec<TestProblem> {
    let mut findings = TestProblems(Vec::new());
    findings.finite("initial_stress", &test.initial_stress);
    if findings.0.is_empty()
        && let Err(error) = ElementSpecimen::new(test)
    {
        findings.0.push(material_problem(&error));
    }
    findings.require(!test.stages.is_empty(), "stages", || "at least one stage is needed".to_owned());
    for (number, stage) in test.stages.iter().enumerate() {
        let place = format!("stages[{number}]");
        findings.stage(&place, stage);
        let reverses = matches!(stage.path, LoadingPath::Reversal { .. });
        findings.require(number > 0 || !reverses, format!("{place}.path"), || NOTHING_TO_REVERSE.to_owned());
    }
    findings.0
}

/// Problems of an element test, collected by the checks.
struct TestProblems(Vec<TestProblem>);

impl TestProblems {
    /// Adds a problem at `path` unless the condition is true.
    fn require(&mut self, holds: bool, path: impl Into<String>, problem: impl FnOnce() -> String) {
        if !holds {
            self.0.push(TestProblem { path: path.into(), problem: problem() });
        }
    }

    /// Requires a finite number.
    fn number(&mut self, path: &str, value: f64) {
        self.require(value.is_finite(), path, || format!("{value} is not a finite number"));
    }

    /// Requires that all values are finite.
    fn finite(&mut self, path: &str, values: &[f64]) {
        for (index, value) in values.iter().enumerate() {
            self.number(&format!("{path}[{index}]"), *value);
        }
    }

    /// Checks the number of increments, the duration and the loading path of a stage.
    fn stage(&mut self, place: &str, stage: &TestStage) {
        let (steps, duration) = (stage.steps, stage.duration);
        self.require((1..=MAX_STEPS).contains(&steps), format!("{place}.steps"), || {
            format!("{steps} is not in 1..={MAX_STEPS}")
        });
        self.require(duration.is_finite() && duration > 0.0, format!("{place}.duration"), || {
            format!("{duration} is not positive (s)")
        });
        let before = self.0.len();
        let path = format!("{place}.path");
        self.check_path_numbers(&path, &stage.path);
        // The following checks need finite numbers.
        if self.0.len() == before {
            self.motion(&path, stage);
        }
    }

    /// Checks a logarithmic axial strain: one above [`MAX_AXIAL_STRAIN`] is probably in per cent.
    fn axial_strain(&mut self, place: &str, strain: f64) {
        self.number(place, strain);
        self.require(!(strain.abs() > MAX_AXIAL_STRAIN), place.to_owned(), || {
            format!(
                "{strain} is a fraction, and would change the height by a factor of {:.3e}: 5 % is 0.05",
                strain.exp()
            )
        });
    }

    /// Checks that every number of a path is finite and in its range.
    fn check_path_numbers(&mut self, place: &str, path: &LoadingPath) {
        let at = |key: &str| format!("{place}.{key}");
        match path {
            LoadingPath::Isotropic { pressure } => self.number(&at("pressure"), *pressure),
            LoadingPath::Oedometer { axial_compression }
            | LoadingPath::TriaxialDrained { axial_compression }
            | LoadingPath::BiaxialPlaneStrain { axial_compression } => {
                self.axial_strain(&at("axial_compression"), *axial_compression);
            }
            LoadingPath::TriaxialUndrained { axial_compression, fluid_stiffness } => {
                self.axial_strain(&at("axial_compression"), *axial_compression);
                self.fluid(&at("fluid_stiffness"), *fluid_stiffness);
            }
            LoadingPath::TriaxialExtension { axial_extension } => {
                self.axial_strain(&at("axial_extension"), *axial_extension);
            }
            LoadingPath::TrueTriaxial { axial_compression, b } => {
                self.axial_strain(&at("axial_compression"), *axial_compression);
                self.require((0.0..=1.0).contains(b), at("b"), || format!("{b} is not in 0..=1"));
            }
            LoadingPath::SimpleShearConstantVolume { shear }
            | LoadingPath::SimpleShearConstantNormalStress { shear } => {
                self.number(&at("shear"), *shear);
            }
            LoadingPath::SimpleShearStress { shear_stress } => {
                self.number(&at("shear_stress"), *shear_stress);
            }
            LoadingPath::Strain { increment } | LoadingPath::Stress { increment } => {
                self.finite(&at("increment"), increment);
            }
            LoadingPath::General { stress, strain, total, amplitude, phase, spin, fluid_stiffness } => {
                self.fluid(&at("fluid_stiffness"), *fluid_stiffness);
                self.rows(&at("stress"), stress);
                self.rows(&at("strain"), strain);
                for (key, values) in [("total", total), ("amplitude", amplitude), ("phase", phase)] {
                    self.finite(&at(key), values);
                }
                self.finite(&at("spin"), spin);
            }
            LoadingPath::Direct { increments, spins, .. } => {
                self.direct(place, increments, spins);
            }
            LoadingPath::Flow { velocity_gradient: rows } => self.rows(&at("velocity_gradient"), rows),
            LoadingPath::DeformationGradient { deformation: rows } => self.rows(&at("deformation"), rows),
            LoadingPath::Creep {} | LoadingPath::Relaxation {} => {}
            LoadingPath::Reversal { fraction } => {
                self.require(*fraction > 0.0 && fraction.is_finite(), at("fraction"), || {
                    format!("{fraction} is not positive")
                });
            }
            LoadingPath::Rotation { angle } => self.number(&at("angle"), *angle),
        }
    }

    /// Requires a positive stiffness of the pore fluid (Pa), where one is given.
    fn fluid(&mut self, path: &str, stiffness: Option<f64>) {
        let Some(stiffness) = stiffness else { return };
        let holds = stiffness.is_finite() && stiffness > 0.0;
        self.require(holds, path, || format!("{stiffness} is not positive (Pa)"));
    }

    /// Checks the increments of a direct path and that the number of rotations is zero or that of the increments.
    fn direct(&mut self, place: &str, increments: &[[f64; 6]], spins: &[[f64; 3]]) {
        let at = |key: &str| format!("{place}.{key}");
        let (count, turns) = (increments.len(), spins.len());
        self.require(count > 0, at("increments"), || "at least one increment is needed".to_owned());
        self.require(turns == 0 || turns == count, at("spins"), || {
            format!("has {turns} entries, one for each of the {count} increments is needed")
        });
        self.rows(&at("increments"), increments);
        self.rows(&at("spins"), spins);
    }

    /// Requires that all numbers of the rows are finite.
    fn rows<const N: usize>(&mut self, path: &str, rows: &[[f64; N]]) {
        for (number, row) in rows.iter().enumerate() {
            self.finite(&format!("{path}[{number}]"), row);
        }
    }

    /// Checks that the six conditions are independent, and no step is too large.
    fn motion(&mut self, path: &str, stage: &TestStage) {
        let Some(program) = stage.path.program(&SymTensor::ZERO, stage.duration, None) else { return };
        let steps = stage.steps.max(1) as f64;
        for (number, part) in program.segments.iter().enumerate() {
            let place =
                if program.segments.len() > 1 { format!("{path}.increments[{number}]") } else { path.into() };
            let strain = match part {
                Control::Mixed(conditions) => {
                    if let Err(problem) = step_solver::check_rank(conditions) {
                        self.require(false, place.as_str(), || problem);
                    }
                    largest_strain(conditions).max(conditions.spin.iter().fold(0.0, |m, a| a.abs().max(m)))
                }
                Control::PrescribedGradient(gradient) => size(gradient),
                Control::Rotation(angle) => angle.abs(),
                Control::Deformation { to, .. } => {
                    self.deformation(&format!("{path}.deformation"), to);
                    0.0
                }
            };
            self.require(strain / steps <= LARGEST_STRAIN, place, || {
                let smallest = (strain / LARGEST_STRAIN).ceil();
                format!(
                    "the amount {strain} in {steps} steps is more than {LARGEST_STRAIN} a step: take at least {smallest} steps"
                )
            });
        }
    }

    /// Checks that a deformation gradient is reached from the unit matrix without inversion.
    fn deformation(&mut self, path: &str, to: &Mat3) {
        let at = |share: f64| (Mat3::IDENTITY + (*to - Mat3::IDENTITY) * share).determinant();
        let inverts = (0..=100).any(|i| !(at(f64::from(i) / 100.0) > 0.0));
        self.require(!inverts, path, || {
            "inverts the material on the straight path from the unit matrix".to_owned()
        });
    }
}

/// Largest strain increment among the equations that prescribe strain only.
fn largest_strain(conditions: &ControlEquations) -> f64 {
    let amount = |row: usize| {
        let free = conditions.stress[row].iter().all(|s| *s == 0.0);
        let factor = conditions.strain[row].iter().fold(0.0, |m: f64, e| m.max(e.abs()));
        let total = conditions.total[row].abs() + 2.0 * conditions.amplitude[row].abs();
        if free && factor > 0.0 { total / factor } else { 0.0 }
    };
    (0..6).map(amount).fold(0.0, f64::max)
}

/// Largest absolute component of a velocity gradient.
fn size(gradient: &Mat3) -> f64 {
    gradient.0.iter().flatten().fold(0.0, |m: f64, a| m.max(a.abs()))
}
