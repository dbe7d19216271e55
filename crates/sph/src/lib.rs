//! Smoothed particle hydrodynamics of solids.
//!
//! A body is a set of particles that carry mass, velocity, density, stress and the state of its law. A
//! field at a particle, its gradient and its Laplacian are sums over the particles around it: [`kernel`] has the smoothing kernels,
//! [`pairs::operators`] the sums. The solver moves particles by the momentum equation in leapfrog steps, velocities half a step ahead
//! (sheet: sph §3.3; [`SphSolver`]).
//! One dimension, plane strain and three dimensions; rough walls are layers of particles, smooth walls
//! mirrors. [`RankedSolver`] distributes the particles over ranks that exchange copies of them.
//!
//! [`Sph`] is the entry point: it turns a [`Case`] into a [`Solver`].

mod boundary;
mod checkpoint;
mod clock;
mod config;
mod context;
mod critical_step;
pub mod kernel;
mod momentum;
mod neighbours;
mod obstacles;
mod output;
pub mod pairs;
mod points;
mod ranks;
pub(crate) mod rates;
pub mod setup;
mod solver;
mod stress;
mod walls;

use colluvium_case::{Capabilities, Case, CaseError, Method, Plan, ProblemSize, Solver};
use schemars::Schema;

pub use config::{
    ConfiningPressure, ConfiningPressureTarget, ContinuityEquation, DensityReset, LagrangianFormulation,
    MomentumEquation, Regularisation, RoughWall, SmoothWall, SmoothingLength, SoundSpeed, SphOptions,
    Symmetrisation, Tensile, TimeHistory, TimeIntegration, VelocityGradientOperator, WallStress,
    WallVelocity,
};
pub use ranks::RankedSolver;
pub use solver::SphSolver;

/// Method of smoothed particle hydrodynamics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sph;

impl Method for Sph {
    fn name(&self) -> &'static str {
        "sph"
    }

    fn summary(&self) -> &'static str {
        "smoothed particle hydrodynamics of solids and fluids as one phase; mirror and particle walls"
    }

    fn options_schema(&self) -> Schema {
        schemars::schema_for!(SphOptions)
    }

    fn problem_size(&self, case: &Case) -> Result<ProblemSize, CaseError> {
        setup::problem_size(case)
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
