//! Interface of all methods: a [`Method`] builds a [`Solver`] from a [`Case`].

pub(crate) mod equilibrium;
mod error;
mod failure_reason;
mod field_list;
mod frame;
mod frame_points;
pub(crate) mod manufactured;
mod plan;
mod plan_warnings;
mod snapshot;
mod time_step;

use std::io::{Read, Write};

use schemars::Schema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::description::Stage;
use crate::{Capabilities, Case, CaseError, Equilibrium};
use colluvium_constitutive::Warning;

pub use crate::solver::equilibrium::MissedEquilibrium;
pub use crate::solver::error::SolverError;
pub use crate::solver::failure_reason::FailureReason;
#[cfg(feature = "output")]
pub(crate) use crate::solver::frame_points::on_nodes;
pub use crate::solver::time_step::{Advance, StepLimit, TimeStep, TimeStepError};
pub use field_list::FieldList;
pub use frame::{
    Dataset, DatasetGeometry, FieldRole, Frame, FramePoints, FrameRequest, Lattice, PlanNodes, PlanRaster,
    PolygonMesh,
};
pub use plan::{Plan, ProblemSize};
pub use plan_warnings::Resolution;
pub use snapshot::{Field, FieldData, Snapshot};

/// Numerical method: its options, and the construction of a solver from a case.
pub trait Method: Send + Sync {
    /// Name of the method, the key under `methods` in a case file.
    fn name(&self) -> &'static str;

    /// Description of the method in one sentence.
    fn summary(&self) -> &'static str;

    /// JSON Schema of the options under `methods.<name>`.
    fn options_schema(&self) -> Schema;

    /// Whether bodies have a stiffness, and with it time scales of elastic waves and of consolidation. Depth-integrated flows have none.
    fn has_elasticity(&self) -> bool {
        true
    }

    /// Approximate size of the problem, without generating its points; zero for methods that do not estimate it.
    ///
    /// # Errors
    /// When its options are wrong.
    fn problem_size(&self, case: &Case) -> Result<ProblemSize, CaseError> {
        let _ = case;
        Ok(ProblemSize::default())
    }

    /// Support of the method for the features of a case, with its options in the case. Features without an entry are rejected. Combinations
    /// of its own options are checked by [`Method::plan_supported_case`] and [`Method::build_supported_case`].
    ///
    /// # Errors
    /// When its options are wrong.
    fn capabilities(&self, case: &Case) -> Result<Capabilities, CaseError>;

    /// Plans the solution of a case whose features the method supports; see [`Method::plan`].
    ///
    /// # Errors
    /// The first unsupported combination of options.
    fn plan_supported_case(&self, case: &Case) -> Result<Plan, CaseError>;

    /// Builds a solver of a case whose features the method supports; see [`Method::build`].
    ///
    /// # Errors
    /// See [`Method::plan_supported_case`].
    fn build_supported_case(&self, case: &Case) -> Result<Box<dyn Solver>, CaseError>;

    /// Plans and builds a case whose features the method supports; see [`Method::plan_and_build`]. Methods with expensive sampling generate
    /// their points once for both.
    ///
    /// # Errors
    /// See [`Method::plan_supported_case`].
    fn plan_and_build_supported_case(&self, case: &Case) -> Result<(Plan, Box<dyn Solver>), CaseError> {
        Ok((self.plan_supported_case(case)?, self.build_supported_case(case)?))
    }

    /// Plan of the solution of a case: its size, time step, cost and warnings. Rejects, by JSON path, all that the method does not support;
    /// ignored features are among the warnings. Not to be overridden.
    ///
    /// # Errors
    /// The first unsupported part of the case.
    fn plan(&self, case: &Case) -> Result<Plan, CaseError> {
        check_rules(case)?;
        let honours = self.capabilities(case)?;
        let notes = honours.check(case)?;
        self.plan_supported_case(case)?.complete(case, notes, honours.has_materials())
    }

    /// Plan and solver of a case, with less work than [`Method::plan`] and [`Method::build`] one after the other. Not to be overridden.
    ///
    /// # Errors
    /// See [`Method::plan`].
    fn plan_and_build(&self, case: &Case) -> Result<(Plan, Box<dyn Solver>), CaseError> {
        check_rules(case)?;
        let honours = self.capabilities(case)?;
        let notes = honours.check(case)?;
        let (plan, solver) = self.plan_and_build_supported_case(case)?;
        Ok((plan.complete(case, notes, honours.has_materials())?, solver))
    }

    /// Solver at time zero, before the first stage. Not to be overridden.
    ///
    /// # Errors
    /// See [`Method::plan`].
    fn build(&self, case: &Case) -> Result<Box<dyn Solver>, CaseError> {
        check_rules(case)?;
        self.capabilities(case)?.check(case)?;
        self.build_supported_case(case)
    }
}

/// Checks the rules of a case, which a program may have described or changed; the first error.
fn check_rules(case: &Case) -> Result<(), CaseError> {
    case.validate().map_err(|errors| errors.first().clone())
}

/// Name, unit and value of a measured number.
pub type ScalarOutput = (String, String, f64);

/// Totals of the whole system.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Budget {
    /// Mass (kg; per metre in plane strain, per radian in axisymmetry).
    pub mass: f64,
    /// Linear momentum (kg m/s).
    pub momentum: [f64; 3],
    /// Angular momentum about the origin (kg m²/s).
    pub angular_momentum: [f64; 3],
    /// Kinetic energy (J).
    pub kinetic: f64,
    /// Recoverable energy of the materials that define one (J).
    pub elastic: f64,
    /// Potential energy of gravity, zero at the origin (J).
    pub potential: f64,
    /// Part of the pore fluid in these totals; `None` without saturated material.
    pub liquid: Option<PhaseBudget>,
}

impl Budget {
    /// Budget of a method that does not record totals. NaN throughout.
    pub const UNKNOWN: Self = Self {
        mass: f64::NAN,
        momentum: [f64::NAN; 3],
        angular_momentum: [f64::NAN; 3],
        kinetic: f64::NAN,
        elastic: f64::NAN,
        potential: f64::NAN,
        liquid: None,
    };

    /// Sum of kinetic, recoverable and potential energy (J).
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.potential
    }
}

/// Totals of one phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PhaseBudget {
    /// Mass (kg).
    pub mass: f64,
    /// Linear momentum (kg m/s).
    pub momentum: [f64; 3],
    /// Kinetic energy (J).
    pub kinetic: f64,
    /// Energy of compression (J).
    pub elastic: f64,
    /// Potential energy of gravity, zero at the origin (J).
    pub potential: f64,
}

/// Action of the material on a rigid body, or on a patch of prescribed velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reaction {
    /// Force in the last step (N; per metre in plane strain, per radian in axisymmetry).
    pub force: [f64; 3],
    /// Impulse since the start (N s).
    pub impulse: [f64; 3],
    /// Moment of the force about the origin (N m; per metre in plane strain, where only the last component is used); `None` where the
    /// method does not compute it.
    pub moment: Option<[f64; 3]>,
}

impl Reaction {
    /// Moment of the force about a position `about` (m) (N m); `None` where the method does not compute it.
    pub fn moment_about(&self, about: &[f64; 3]) -> Option<[f64; 3]> {
        let force = &self.force;
        let arm = |c: usize| {
            let (a, b) = ((c + 1) % 3, (c + 2) % 3);
            about[a] * force[b] - about[b] * force[a]
        };
        self.moment.map(|moment| std::array::from_fn(|c| moment[c] - arm(c)))
    }
}

/// Error text for a body whose law cannot restart from its current stress, with the `reason`.
pub fn reset_error(reason: &str) -> String {
    format!(
        "reset of state at the end of the stage: its law cannot restart from the present stress ({reason})"
    )
}

/// Running instance of a method.
pub trait Solver: Send {
    /// Current time of the solver (s).
    fn time(&self) -> f64;

    /// Number of steps.
    fn step_count(&self) -> u64;

    /// Number of points.
    fn point_count(&self) -> usize;

    /// Largest stable step from the current state, with its safety factor, and its limit. It is constant until the next step.
    fn limit(&mut self) -> TimeStep;

    /// Advances by one step of at most `at_most` (s). A solver may take less, cut back and retry, or advance an increment of load; the
    /// result says which step it took.
    ///
    /// # Errors
    /// When a point cannot be continued; the solver must then not be used further.
    fn step(&mut self, at_most: f64) -> Result<Advance, SolverError>;

    /// Prepares a stage at its beginning: its boundaries, damping, gravity ramp and excavations. `stage` is an index into `Case::stages`,
    /// `start` the start time of the stage (s).
    ///
    /// # Errors
    /// When the stage cannot begin.
    fn begin_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError>;

    /// Prepares the stage of a restored state after [`Solver::restore`], without what happens once at its beginning.
    ///
    /// # Errors
    /// When the stage does not fit the state.
    fn resume_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError> {
        self.begin_stage(stage, start)
    }

    /// Ends a stage, and resets the quantities of its `reset` (velocities, displacements, plastic strains).
    ///
    /// # Errors
    /// When the stage cannot end.
    fn end_stage(&mut self, stage: &Stage) -> Result<(), SolverError>;

    /// Cell size of the grid (m); `None` for methods without a grid.
    fn cell_size(&self) -> Option<f64> {
        None
    }

    /// Number of steps between two calls of [`Solver::equilibrium`].
    fn steps_between_checks(&self) -> u64 {
        100
    }

    /// Distance from equilibrium after the last step; `None` where the method has no measure.
    fn equilibrium(&self) -> Option<Equilibrium>;

    /// Whether the time ramps of the options of the method are complete. Before that, no state counts as at rest.
    fn ramps_are_complete(&self) -> bool {
        true
    }

    /// Scalar outputs of the method in each row of the measures. Their names and order are constant; unknown values are NaN.
    fn scalar_outputs(&self) -> Vec<ScalarOutput> {
        Vec::new()
    }

    /// Travelled distance of each removal shape of the case (m), in their order; `None` before it begins to move. Empty for methods without
    /// removal shapes.
    fn removal_shape_travel(&self) -> Vec<Option<f64>> {
        Vec::new()
    }

    /// Force of the material on the rigid body or patch `name`; `None` for methods without reactions.
    fn reaction(&self, name: &str) -> Option<Reaction> {
        let _ = name;
        None
    }

    /// Depth (m) and velocity (m/s; NaN where it is dry) of a flow at a position in plan; `None` for methods without a depth.
    fn gauge(&self, place: &[f64]) -> Option<(f64, [f64; 3])> {
        let _ = place;
        None
    }

    /// Discharge across a line in plan (m³/s), positive to the right of its direction; `None` for methods without a depth.
    fn discharge(&self, from: [f64; 2], to: [f64; 2]) -> Option<f64> {
        let _ = (from, to);
        None
    }

    /// Energy (J) that the materials of the present points have dissipated since the start; `None` where the case does not measure it.
    fn dissipated(&self) -> Option<f64> {
        None
    }

    /// Whether the budget contains all energy and no external work is done in the stage. The run then reports growth of energy. False where
    /// a method cannot decide.
    fn is_isolated(&self) -> bool {
        false
    }

    /// Warning about the state during the run, such as a liquid in tension.
    fn warning(&self) -> Option<Warning> {
        None
    }

    /// Warnings about the state at the end of a run, such as points whose law is outside its range of validity.
    fn warnings_at_end(&self) -> Vec<Warning> {
        Vec::new()
    }

    /// Notes on a run that are no warnings, such as the density of grain packings.
    fn notes(&self) -> Vec<Warning> {
        Vec::new()
    }

    /// Current state as the datasets of `wanted`. Fields that it does not include are neither computed nor copied.
    fn frame(&self, wanted: FrameRequest<'_>) -> Frame;

    /// Results in addition to the frames, up to the current time, such as maxima over the plan.
    fn products(&self) -> Vec<Dataset> {
        Vec::new()
    }

    /// Current state as points: the dataset on points, or else the first dataset of the frame.
    fn snapshot(&self) -> Snapshot {
        self.frame(FrameRequest::Measured).into_measured_points()
    }

    /// Rasters among the results of [`Solver::products`].
    fn rasters(&self) -> Vec<PlanRaster> {
        self.products().iter().flat_map(Dataset::rasters).collect()
    }

    /// Budget of totals; `None` for methods without one.
    fn budget(&self) -> Option<Budget> {
        None
    }

    /// Budget of totals; [`Budget::UNKNOWN`] for methods without one.
    fn totals(&self) -> Budget {
        self.budget().unwrap_or(Budget::UNKNOWN)
    }

    /// Writes the complete state: a restored solver continues bit-identically. Large arrays are written without a copy of the whole state.
    ///
    /// # Errors
    /// When writing to `out` fails.
    fn save(&self, out: &mut dyn Write) -> Result<(), SolverError>;

    /// Restores the state of [`Solver::save`] of the same case.
    ///
    /// # Errors
    /// When the bytes are no such state.
    fn restore(&mut self, input: &mut dyn Read) -> Result<(), SolverError>;

    /// Text of a file with the points and their complete data, with which another case of the method can begin. `None` for methods without
    /// such a file.
    fn specimen(&self) -> Option<String> {
        None
    }

    /// Whether [`Solver::specimen`] returns a text. The folder of a run then has the state at its end.
    fn has_specimen(&self) -> bool {
        false
    }

    /// State of [`Solver::save`] as bytes.
    ///
    /// # Errors
    /// See [`Solver::save`].
    fn checkpoint_bytes(&self) -> Result<Vec<u8>, SolverError> {
        let mut bytes = Vec::new();
        self.save(&mut bytes)?;
        Ok(bytes)
    }
}

/// Writes a value as part of a saved state.
///
/// # Errors
/// When writing to `out` fails.
pub fn save_value<T: Serialize>(value: &T, out: &mut dyn Write) -> Result<(), SolverError> {
    let bytes = postcard::to_stdvec(value).map_err(|error| SolverError::Checkpoint(error.to_string()))?;
    out.write_all(&(bytes.len() as u64).to_le_bytes())?;
    Ok(out.write_all(&bytes)?)
}

/// Reads a value of [`save_value`].
///
/// # Errors
/// When the bytes are no such value.
pub fn restore_value<T: DeserializeOwned>(input: &mut dyn Read) -> Result<T, SolverError> {
    let mut length = [0; 8];
    input.read_exact(&mut length)?;
    let length = u64::from_le_bytes(length);
    let mut bytes = Vec::new();
    if input.take(length).read_to_end(&mut bytes)? as u64 != length {
        return Err(SolverError::Checkpoint("ends too early".to_owned()));
    }
    postcard::from_bytes(&bytes).map_err(|error| SolverError::Checkpoint(format!("cannot be read ({error})")))
}
