//! What every method offers: [`Method`] makes a [`Solver`] of a [`Case`].

pub(crate) mod equilibrium;
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
use thiserror::Error;

use crate::description::Stage;
use crate::measure::ScalarOutput;
use crate::{Capabilities, Case, CaseError, Equilibrium};

pub(crate) use crate::solver::frame_points::on_nodes;
pub use crate::solver::time_step::{Advance, StepLimit, TimeStep};
pub use frame::{
    Dataset, DatasetGeometry, FieldRole, Frame, FramePoints, FrameRequest, Lattice, PlanNodes, PlanRaster,
    PolygonMesh,
};
pub use plan::{Plan, ProblemSize};
pub use plan_warnings::Resolution;
pub use snapshot::{Field, FieldData, Snapshot};

/// A numerical method: its options, and the way from a case to a running solver.
pub trait Method: Send + Sync {
    /// Name of the method, the key under `methods` in a case file.
    fn name(&self) -> &'static str;

    /// One sentence on what the method is.
    fn summary(&self) -> &'static str;

    /// JSON Schema of the options under `methods.<name>`.
    fn options_schema(&self) -> Schema;

    /// Whether bodies have a stiffness, and with it times of elastic waves and of consolidation. Flows that are integrated over their depth
    /// have none.
    fn has_elasticity(&self) -> bool {
        true
    }

    /// About how large the problem is, without making its points. Methods that do not tell are of no size.
    ///
    /// # Errors
    /// When its options are wrong.
    fn problem_size(&self, case: &Case) -> Result<ProblemSize, CaseError> {
        let _ = case;
        Ok(ProblemSize::default())
    }

    /// What the method says to the features of a case, with the options that the case gives it. What it does not name is
    /// refused. Combinations of its own options are left to [`Method::plan_supported_case`] and [`Method::build_supported_case`].
    ///
    /// # Errors
    /// When its options are wrong.
    fn capabilities(&self, case: &Case) -> Result<Capabilities, CaseError>;

    /// [`Method::plan`] of a case whose features it honours.
    ///
    /// # Errors
    /// The first combination of options that it cannot honour.
    fn plan_supported_case(&self, case: &Case) -> Result<Plan, CaseError>;

    /// [`Method::build`] of a case whose features it honours.
    ///
    /// # Errors
    /// As [`Method::plan_supported_case`].
    fn build_supported_case(&self, case: &Case) -> Result<Box<dyn Solver>, CaseError>;

    /// [`Method::plan_and_build`] of a case whose features it honours. Methods whose points take long to place make them once for both.
    ///
    /// # Errors
    /// As [`Method::plan_supported_case`].
    fn plan_and_build_supported_case(&self, case: &Case) -> Result<(Plan, Box<dyn Solver>), CaseError> {
        Ok((self.plan_supported_case(case)?, self.build_supported_case(case)?))
    }

    /// What would be solved, without solving it. Refuses, by JSON path, whatever the method cannot honour; what it passes over
    /// is among the warnings. Not to be overridden.
    ///
    /// # Errors
    /// The first thing in the case that this method cannot honour.
    fn plan(&self, case: &Case) -> Result<Plan, CaseError> {
        let honours = self.capabilities(case)?;
        let notes = honours.check(case)?;
        self.plan_supported_case(case)?.complete(case, notes, honours.has_materials())
    }

    /// [`Method::plan`] and [`Method::build`] at once. Not to be overridden.
    ///
    /// # Errors
    /// As [`Method::plan`].
    fn plan_and_build(&self, case: &Case) -> Result<(Plan, Box<dyn Solver>), CaseError> {
        let honours = self.capabilities(case)?;
        let notes = honours.check(case)?;
        let (plan, solver) = self.plan_and_build_supported_case(case)?;
        Ok((plan.complete(case, notes, honours.has_materials())?, solver))
    }

    /// A solver at time zero, before the first stage begins. Not to be overridden.
    ///
    /// # Errors
    /// As [`Method::plan`].
    fn build(&self, case: &Case) -> Result<Box<dyn Solver>, CaseError> {
        self.capabilities(case)?.check(case)?;
        self.build_supported_case(case)
    }
}

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
    /// The share of the pore fluid in all of these; `None` where nothing is saturated.
    pub liquid: Option<PhaseBudget>,
}

impl Budget {
    /// That of a method that keeps none: not-a-number throughout.
    pub const UNKNOWN: Self = Self {
        mass: f64::NAN,
        momentum: [f64::NAN; 3],
        angular_momentum: [f64::NAN; 3],
        kinetic: f64::NAN,
        elastic: f64::NAN,
        potential: f64::NAN,
        liquid: None,
    };

    /// Kinetic, recoverable and potential energy (J).
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

/// What the material does to a rigid body or to a patch of prescribed velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reaction {
    /// Force in the last step (N; per metre in plane strain, per radian in axisymmetry).
    pub force: [f64; 3],
    /// Impulse since the start (N s).
    pub impulse: [f64; 3],
    /// Moment of the force about the zero of the coordinates (N m; per metre in plane strain, where the last component counts); `None`
    /// where the method does not tell it.
    pub moment: Option<[f64; 3]>,
}

impl Reaction {
    /// Moment of the force about a place `about` (m); `None` where the method does not tell it.
    pub fn moment_about(&self, about: &[f64; 3]) -> Option<[f64; 3]> {
        let force = &self.force;
        let arm = |c: usize| {
            let (a, b) = ((c + 1) % 3, (c + 2) % 3);
            about[a] * force[b] - about[b] * force[a]
        };
        self.moment.map(|moment| std::array::from_fn(|c| moment[c] - arm(c)))
    }
}

/// The problem of a body whose law cannot begin anew from the stress it has, for its own `reason`.
pub fn reset_error(reason: &str) -> String {
    format!(
        "reset of state at the end of the stage: its law cannot begin anew from the stress it has ({reason})"
    )
}

/// Why a run had to stop.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SolverError {
    /// A point left what the method can follow: NaN, runaway velocity, inverted, outside the grid.
    #[error("step {step}, t = {time:.6} s, point {point} at {position:.4?} m: {reason}")]
    Point {
        /// Step during which it happened.
        step: u64,
        /// Time at the start of that step (s).
        time: f64,
        /// Id of the first such point.
        point: u64,
        /// Its position (m).
        position: [f64; 3],
        /// What happened.
        reason: String,
    },
    /// A step that could not be done.
    #[error("step {step}, t = {time:.6} s: {reason}")]
    Step {
        /// The step.
        step: u64,
        /// Time at its start (s).
        time: f64,
        /// What happened.
        reason: String,
    },
    /// A checkpoint does not fit this case or this version.
    #[error("checkpoint: {0}")]
    Checkpoint(String),
}

impl SolverError {
    /// The same with its place moved by `origin` (m).
    pub(crate) fn on_map(mut self, origin: [f64; 3]) -> Self {
        if let Self::Point { position, .. } = &mut self {
            (0..3).for_each(|c| position[c] += origin[c]);
        }
        self
    }
}

/// A method's running instance.
pub trait Solver: Send {
    /// Time (s).
    fn time(&self) -> f64;

    /// Steps done.
    fn step_count(&self) -> u64;

    /// Number of points.
    fn points(&self) -> usize;

    /// The largest step from here, safety factor included, and what limits it: the same until the next step.
    fn limit(&mut self) -> TimeStep;

    /// Advances by one step, of `at_most` so much time (s); explicit solvers take [`TimeStep::limited_to`] of their limit. A
    /// solver may take less, cut back and try again, or advance an increment of load, and says what it has done.
    ///
    /// # Errors
    /// When a point can no longer be followed; the solver is then not to be used further.
    fn step(&mut self, at_most: f64) -> Result<Advance, SolverError>;

    /// Prepares a stage: its boundaries, damping, gravity ramp. Called once when the stage begins,
    /// and after [`Solver::restore`] with the stage the checkpoint lies in; `stage` is an index into
    /// `Case::stages`, `start` the time the stage began (s).
    ///
    /// # Errors
    /// When the stage cannot be begun.
    fn begin_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError>;

    /// Ends a stage: performs its `reset` (velocities, displacements, plastic strains).
    ///
    /// # Errors
    /// When the stage cannot be ended.
    fn end_stage(&mut self, stage: &Stage) -> Result<(), SolverError>;

    /// Width of the cells of its grid (m); `None` for methods without a grid.
    fn cell_size(&self) -> Option<f64> {
        None
    }

    /// Steps between two questions for [`Solver::equilibrium`].
    fn steps_between_checks(&self) -> u64 {
        100
    }

    /// Distance from equilibrium after the last step; `None` where the method has no measure of it.
    fn equilibrium(&self) -> Option<Equilibrium>;

    /// Whether what its own options let grow with time has its full size: before that nothing is at rest.
    fn ramps_are_complete(&self) -> bool {
        true
    }

    /// What else the method tells of itself in each row of the measures; always the same names in the same order, NaN for
    /// what it does not know at the time.
    fn scalar_outputs(&self) -> Vec<ScalarOutput> {
        Vec::new()
    }

    /// How far each cut of the case has moved (m), in their order; `None` of one that has not begun. Nothing from methods without cuts.
    fn removal_shape_travel(&self) -> Vec<Option<f64>> {
        Vec::new()
    }

    /// Force of the material on the rigid body or patch `name`; `None` for methods without them.
    fn reaction(&self, name: &str) -> Option<Reaction> {
        let _ = name;
        None
    }

    /// Depth (m) and velocity (m/s; not-a-number where it is dry) of a flow over a place in plan; `None` for methods that follow no
    /// depth.
    fn gauge(&self, place: &[f64]) -> Option<(f64, [f64; 3])> {
        let _ = place;
        None
    }

    /// Volume that crosses a line in plan per time (m³/s), positive to the right of who walks along it; `None` for methods that
    /// follow no depth.
    fn discharge(&self, from: [f64; 2], to: [f64; 2]) -> Option<f64> {
        let _ = (from, to);
        None
    }

    /// Energy (J) that the materials of the points that are there have dissipated since the start; `None` where the case
    /// does not measure it.
    fn dissipated(&self) -> Option<f64> {
        None
    }

    /// Whether the budget holds all energy there is and nothing works on it from outside in the stage: no loads, nothing that is
    /// driven, materials that all tell what they store. The run then says when energy grows. False where a method cannot tell.
    fn is_isolated(&self) -> bool {
        false
    }

    /// What of the state is worth a word while the run goes on: liquids in tension, … Asked at every row of the measures until
    /// there is something to say.
    fn warning(&self) -> Option<String> {
        None
    }

    /// What of the state is worth a word when a run ends: points that are where their law is no longer meant to hold, …
    fn warnings_at_end(&self) -> Vec<String> {
        Vec::new()
    }

    /// What is worth telling of the run with which nothing is wrong: how densely grains were filled in, …
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// The state as it is now, as the datasets that are `wanted`.
    fn frame(&self, wanted: FrameRequest) -> Frame;

    /// What a run leaves beside its frames, so far: peaks over the plan and the like, where the case asks for them.
    fn products(&self) -> Vec<Dataset> {
        Vec::new()
    }

    /// What is measured, as points: what is on points, or else what comes first in such a frame; no point where nothing is.
    fn snapshot(&self) -> Snapshot {
        self.frame(FrameRequest::Measured).into_measured()
    }

    /// The rasters among the products.
    fn rasters(&self) -> Vec<PlanRaster> {
        self.products().iter().flat_map(Dataset::rasters).collect()
    }

    /// Totals; `None` for methods that keep none.
    fn budget(&self) -> Option<Budget> {
        None
    }

    /// The budget; [`Budget::UNKNOWN`] where the method keeps none.
    fn totals(&self) -> Budget {
        self.budget().unwrap_or(Budget::UNKNOWN)
    }

    /// Writes the complete state: a restored solver continues bit-identically. Large arrays go out as they are, without a copy
    /// of all of them.
    ///
    /// # Errors
    /// When `out` refuses.
    fn save(&self, out: &mut dyn Write) -> Result<(), SolverError>;

    /// Takes the state of [`Solver::save`] of the same case.
    ///
    /// # Errors
    /// When the bytes are not such a state.
    fn restore(&mut self, input: &mut dyn Read) -> Result<(), SolverError>;

    /// The points with all that they carry, as the text of a file that another case of the method can begin with; `None` for methods
    /// without such a file.
    fn specimen(&self) -> Option<String> {
        None
    }

    /// Whether [`Solver::specimen`] gives one: the folder of a run then keeps the state at its end.
    fn has_specimen(&self) -> bool {
        false
    }

    /// The state of [`Solver::save`] as bytes.
    ///
    /// # Errors
    /// As [`Solver::save`].
    fn saved(&self) -> Result<Vec<u8>, SolverError> {
        let mut bytes = Vec::new();
        self.save(&mut bytes)?;
        Ok(bytes)
    }
}

impl From<std::io::Error> for SolverError {
    fn from(error: std::io::Error) -> Self {
        Self::Checkpoint(error.to_string())
    }
}

/// Writes a value as part of a state.
///
/// # Errors
/// When `out` refuses.
pub fn save_value<T: Serialize>(value: &T, out: &mut dyn Write) -> Result<(), SolverError> {
    let bytes = postcard::to_stdvec(value).map_err(|error| SolverError::Checkpoint(error.to_string()))?;
    out.write_all(&(bytes.len() as u64).to_le_bytes())?;
    Ok(out.write_all(&bytes)?)
}

/// Reads a value of [`save_value`].
///
/// # Errors
/// When the bytes are not such a value.
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
