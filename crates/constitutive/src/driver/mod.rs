//! Element driver: one material point under prescribed strains and stresses
//! (sheet: constitutive §3.12), for tests and calibration of laws.
//!
//! An [`ElementTest`] is a material, an initial stress and a list of stages. Every step solves
//! `S Δσ + E Δε = ΔY` for the strain increment by Newton's method with the law's own tangent.
//! Axis z is the axis of triaxial and oedometer tests, y that of biaxial tests; shear is xy.

mod element_path;
pub mod incremental;
mod loading_path;
mod path_control;
mod standard_plots;
mod step_solver;
mod test_checks;
mod unconverged_step;

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{
    InitialCondition, Mat3, Material, MaterialError, MaterialSpec, Motion, StateBlock, States, SymTensor,
};

pub use crate::driver::element_path::{ElementPath, PATH_COLUMNS, cell};
pub use crate::driver::loading_path::{ControlledQuantity, LoadingPath};
pub use crate::driver::standard_plots::{StandardPlot, YieldCurve};
pub use crate::driver::test_checks::TestProblem;

use crate::driver::element_path::PathRecorder;

/// Test of a single material point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElementTest {
    /// Title of the test, one line.
    pub title: String,
    /// Material of the point.
    pub material: MaterialSpec,
    /// Initial stress (Pa, tension-positive): xx yy zz xy yz zx.
    #[serde(default)]
    pub initial_stress: [f64; 6],
    /// Stages of the test, in order.
    pub stages: Vec<TestStage>,
}

/// Stage of an element test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TestStage {
    /// Prescribed loading path.
    pub path: LoadingPath,
    /// Number of steps.
    #[serde(default = "steps")]
    pub steps: usize,
    /// Duration (s), for rate-dependent laws.
    #[serde(default = "duration")]
    pub duration: f64,
}

/// Default number of increments of a stage.
fn steps() -> usize {
    200
}

/// Default duration of a stage (s).
fn duration() -> f64 {
    1.0
}

/// Reason why an element test stopped.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DriverError {
    /// Invalid description of the test: all problems found, one a line.
    #[error("{}", test_checks::problem_lines(.0))]
    Invalid(Vec<TestProblem>),
    /// Stage that cannot be carried out.
    #[error("stages[{stage}].path: {problem}")]
    Stage {
        /// Number of the stage.
        stage: usize,
        /// Description of the problem.
        problem: String,
    },
    /// Limit load of the material: no strain gives the prescribed stress.
    #[error(
        "stages[{stage}].path: limit load reached in step {step}: no strain gives the prescribed stress ({row})"
    )]
    LimitLoad {
        /// Number of the stage.
        stage: usize,
        /// Step in the stage.
        step: usize,
        /// Condition that fails.
        row: String,
    },
    /// Failure of the law.
    #[error("stages[{stage}].path: step {step}: {source}")]
    Law {
        /// Number of the stage.
        stage: usize,
        /// Step in the stage.
        step: usize,
        /// Error of the law.
        source: MaterialError,
    },
}

impl DriverError {
    /// Stable code of the error, which `docs/messages.md` of the repository explains.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Invalid(_) => "test-invalid",
            Self::Stage { .. } => "test-stage",
            Self::LimitLoad { .. } => "limit-load",
            Self::Law { .. } => "test-law",
        }
    }
}

/// Material point under test.
#[derive(Clone)]
struct ElementSpecimen {
    material: Arc<dyn Material>,
    stress: SymTensor,
    states: States,
    density: f64,
}

impl ElementSpecimen {
    /// Specimen of the test with its initial stress, initial states and density.
    fn new(test: &ElementTest) -> Result<Self, MaterialError> {
        let material = test.material.build()?;
        let density = test.material.density();
        let condition = InitialCondition { stress: SymTensor(test.initial_stress), density };
        let (stresses, states) = material.initial(&[condition]).map_err(|error| error.source)?;
        Ok(Self { material, stress: stresses[0], states, density })
    }

    /// State block of the single point of the specimen.
    fn block(&self) -> &StateBlock {
        &self.states.blocks()[0]
    }

    /// Motion of an increment `L Δt` in the time `dt` (s) with the density at its end; `None` if the motion is invalid.
    fn motion(&self, gradient: &Mat3, dt: f64) -> Option<Motion> {
        let mut motion = Motion::from_velocity_gradient(&(*gradient * (1.0 / dt)), dt, 1.0, 1.0)?;
        motion.velocity_gradient_dt = *gradient;
        motion.density = self.density / motion.deformation.determinant();
        Some(motion)
    }

    /// Stress and states after a motion; the specimen itself is unchanged.
    fn trial_update(&self, motion: &Motion) -> Result<(SymTensor, States), MaterialError> {
        let mut states = self.states.clone();
        let mut stress = [self.stress];
        self.material
            .update(std::slice::from_ref(motion), &mut stress, &mut states.blocks_mut()[0])
            .map_err(|error| error.source)?;
        Ok((stress[0], states))
    }

    /// Tangent stiffness at the current state for a motion (Pa).
    fn tangent(&self, motion: &Motion) -> Result<crate::Tangent, MaterialError> {
        self.material.tangent(motion, &self.stress, self.block(), 0)
    }

    /// Replaces stress, states and density by those at the end of an increment.
    fn accept(&mut self, motion: &Motion, (stress, states): (SymTensor, States)) {
        self.stress = stress;
        self.states = states;
        self.density = motion.density;
    }

    /// Value of the yield function at the current stress (Pa).
    fn yield_value(&self) -> f64 {
        self.yield_value_at(&self.stress)
    }

    /// Yield value at another stress, in the present state of the specimen.
    fn yield_value_at(&self, stress: &SymTensor) -> f64 {
        let mut value = [0.0];
        self.material.yield_values(&[*stress], self.block(), &mut value);
        value[0]
    }

    /// Recoverable energy per volume (J/m³); NaN where the law has none.
    fn energy(&self) -> f64 {
        let mut value = [0.0];
        let defined = self.material.stored_energies(&[self.stress], self.block(), &mut value);
        if defined { value[0] } else { f64::NAN }
    }

    /// P-wave speed at the current state (m/s).
    fn wave_speed(&self) -> f64 {
        let mut modulus = [0.0];
        self.material.wave_moduli(&[self.stress], self.block(), &mut modulus);
        (modulus[0] / self.density).sqrt()
    }

    /// Output values of the material, in the order of its output names.
    fn outputs(&self) -> Vec<f64> {
        let mut values = vec![0.0; self.material.output_names().len()];
        self.material.outputs(&[self.stress], self.block(), &mut values);
        values
    }
}

/// Result of a test, complete or up to the step at which it stopped.
pub struct TestTrace {
    /// Path up to the end of the test or to the step at which it stopped.
    pub path: ElementPath,
    /// Reason for which the test stopped early; `None` for a complete test.
    pub stop_reason: Option<DriverError>,
    /// Row of the path with which each stage begins, for the stages that began.
    pub stage_rows: Vec<usize>,
    start: ElementSpecimen,
    end: ElementSpecimen,
}

impl TestStage {
    /// Stage along a path, in 200 steps over 1 s.
    #[must_use]
    pub fn new(path: LoadingPath) -> Self {
        Self { path, steps: steps(), duration: duration() }
    }
}

impl ElementTest {
    /// Test of a stress-free point without stages. The material is the parameters of a law of this crate, or
    /// [`ExternalSpec::from_law`](crate::ExternalSpec::from_law) of a law of the program.
    #[must_use]
    pub fn new(material: impl Into<MaterialSpec>) -> Self {
        let (title, material) = ("untitled".to_owned(), material.into());
        Self { title, material, initial_stress: [0.0; 6], stages: Vec::new() }
    }

    /// Test of a law of the program, with its initial density (kg/m³).
    #[must_use]
    pub fn of_law(name: impl Into<String>, density: f64, law: Arc<dyn Material>) -> Self {
        Self::new(crate::ExternalSpec::from_law(name, density, law))
    }

    /// Adds a stage.
    #[must_use]
    pub fn stage(mut self, stage: TestStage) -> Self {
        self.stages.push(stage);
        self
    }

    /// Checks the description before the test is run.
    ///
    /// # Errors
    /// [`DriverError::Invalid`] with all problems and their paths.
    pub fn validate(&self) -> Result<(), DriverError> {
        let problems = test_checks::problems(self);
        if problems.is_empty() { Ok(()) } else { Err(DriverError::Invalid(problems)) }
    }

    /// Runs the test to its end.
    ///
    /// # Errors
    /// When the material or a stage is wrong, the law fails, or a limit load is reached under stress
    /// control. [`ElementTest::trace`] keeps what was computed before.
    pub fn run(&self) -> Result<ElementPath, DriverError> {
        let trace = self.trace()?;
        trace.stop_reason.map_or(Ok(trace.path), Err)
    }

    /// Runs the test to its end or to the first failure, and returns the path up to there.
    ///
    /// # Errors
    /// When the description of the test is invalid; a failure during the test is in [`TestTrace::stop_reason`].
    pub fn trace(&self) -> Result<TestTrace, DriverError> {
        self.validate()?;
        let invalid = |error| DriverError::Invalid(vec![test_checks::material_problem(&error)]);
        let mut specimen = ElementSpecimen::new(self).map_err(invalid)?;
        if !specimen.stress.0.iter().all(|component| component.is_finite()) {
            let problem = "the initial stress is not a number: check the size of moduli and strengths";
            return Err(DriverError::Invalid(vec![TestProblem {
                path: "material".to_owned(),
                problem: problem.to_owned(),
            }]));
        }
        let is_column = |name: &&&str| PATH_COLUMNS.iter().any(|(column, _)| column == *name);
        if let Some(name) = specimen.material.output_names().iter().find(is_column) {
            let problem =
                format!("the output {name:?} of the law has the name of a column of every path: rename it");
            return Err(DriverError::Invalid(vec![TestProblem { path: "material".to_owned(), problem }]));
        }
        let start = specimen.clone();
        let mut record = PathRecorder::new(&specimen);
        let mut stage_rows = Vec::with_capacity(self.stages.len());
        let stop_reason = self.stages(&mut specimen, &mut record, &mut stage_rows).err();
        let path = record.into_path(specimen.material.output_names());
        Ok(TestTrace { path, stop_reason, stage_rows, start, end: specimen })
    }

    /// Runs the stages of the test one after another on the specimen and records the path, with the row at which each stage begins.
    fn stages(
        &self,
        specimen: &mut ElementSpecimen,
        record: &mut PathRecorder,
        stage_rows: &mut Vec<usize>,
    ) -> Result<(), DriverError> {
        let mut before = None;
        for (number, stage) in self.stages.iter().enumerate() {
            stage_rows.push(record.last_row());
            let program = stage.path.program(&specimen.stress, stage.duration, before.as_ref());
            let program = program.ok_or_else(|| DriverError::Stage {
                stage: number,
                problem: test_checks::NOTHING_TO_REVERSE.to_owned(),
            })?;
            step_solver::run_stage(specimen, record, &step_solver::StageContext { number, stage }, &program)?;
            before = Some(program);
        }
        Ok(())
    }
}
