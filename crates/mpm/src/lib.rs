//! Explicit material point method.
//!
//! A body is a set of points that carry mass, velocity, stress and the state of its law. Each step
//! maps them to a background grid, solves the momentum equation on the nodes and maps the result
//! back (sheet: mpm §3.3; [`MpmSolver`] holds the step). Shape functions are linear, generalised
//! interpolation (GIMP) with fixed or stretching point domains, convected particle domains (CPDI), or quadratic and
//! cubic B-splines;
//! stress is updated first, last, or last from re-mapped velocities. One dimension, plane strain,
//! axisymmetry and three dimensions. Bodies with a pore fluid are solved as two phases that move apart.
//!
//! [`Mpm`] is the entry: it turns a [`Case`] into a [`Solver`].
//!
//! A module knows only the modules to the left of it: `config`, `clock`, `background_grid`, `points`, `momentum`, `obstacles`, `contact`,
//! `stress`, `boundary`, `transfer`, `phases`, `solver`, `setup`, `output`, `checkpoint`.

mod background_grid;
mod boundary;
mod checkpoint;
mod clock;
mod config;
mod contact;
mod momentum;
mod obstacles;
mod output;
mod phases;
mod points;
mod setup;
mod solver;
mod stress;
mod transfer;

use colluvium_case::{
    Capabilities, Case, CaseError, ConfiguredMethod, Method, Plan, ProblemSize, Solver, TypedMethod,
};
use schemars::Schema;

pub use boundary::body_force::BodyForce;
pub use config::{
    BodyContact, ContactTest, DomainStretch, FixedNodes, InternalForceIntegration, LagrangianFormulation,
    MeshSource, MpmOptions, NodalMass, ObstacleCoupling, PenaltyContact, ShapeFunctions, StepCriterion,
    StressScheme, VelocityTransfer, VolumetricStrain, WallFriction,
};
pub use solver::{MpmPoints, MpmSolver};

/// The explicit material point method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mpm;

impl Mpm {
    /// Method with its options, which builds solvers that a program steps.
    #[expect(
        clippy::new_ret_no_self,
        reason = "the method without options is a value of its own, for cases with options"
    )]
    pub fn new(options: MpmOptions) -> ConfiguredMethod<Self> {
        ConfiguredMethod::new(options)
    }
}

impl TypedMethod for Mpm {
    type Options = MpmOptions;
    type Solver<const D: usize> = MpmSolver<D>;

    fn typed_solver<const D: usize>(&self, case: &Case) -> Result<MpmSolver<D>, CaseError> {
        setup::typed_solver(case)
    }
}

impl Method for Mpm {
    fn name(&self) -> &'static str {
        "mpm"
    }

    fn summary(&self) -> &'static str {
        "explicit material point method: MPM, GIMP, CPDI and B-splines on a structured grid, triangles and \
         tetrahedra; one phase, or skeleton and pore fluid"
    }

    fn options_schema(&self) -> Schema {
        schemars::schema_for!(MpmOptions)
    }

    fn problem_size(&self, case: &Case) -> Result<ProblemSize, CaseError> {
        setup::problem_size::problem_size(case)
    }

    fn capabilities(&self, case: &Case) -> Result<Capabilities, CaseError> {
        setup::capabilities(case)
    }

    fn plan_supported_case(&self, case: &Case) -> Result<Plan, CaseError> {
        setup::plan(case)
    }

    fn build_supported_case(&self, case: &Case) -> Result<Box<dyn Solver>, CaseError> {
        setup::build(case)
    }
}
