//! Finite-strain material point method for snow and other brittle, porous solids.
//!
//! Points carry mass, velocity, stress and the state of a law at finite strain. A step is fused: mass, momentum and forces of the points
//! are transferred to the nodes of a grid of B-splines, the nodal momentum equation is solved with the walls, and points interpolate
//! their new velocity, its gradient and, with APIC, its affine part (sheet: snow-mpm §3.5; see [`SnowSolver`]). Stress is updated last.
//! The grid is larger than the domain of the case, so that its shape functions are equal everywhere, and walls constrain the nodes on or
//! behind them.
//!
//! Stress is tension-positive; in the plane masses, forces and energies are per metre of thickness. [`SnowMpm`] is the entry point: it
//! turns a [`Case`] into a [`Solver`].

pub(crate) mod background_grid;
mod boundary;
mod checkpoint;
mod config;
mod critical_step;
mod momentum;
mod obstacles;
mod output;
mod points;
mod setup;
mod solver;
mod stress;
mod transfer;

use colluvium_case::{Capabilities, Case, CaseError, Method, Plan, ProblemSize, Solver};
use schemars::Schema;

pub use config::{DeformationUpdate, SnowOptions, SnowTransfer, SplineShape};
pub use solver::SnowSolver;

/// Finite-strain material point method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SnowMpm;

impl Method for SnowMpm {
    fn name(&self) -> &'static str {
        config::NAME
    }

    fn summary(&self) -> &'static str {
        "finite-strain material point method: B-splines, APIC or FLIP, stress last; for snow and other brittle, porous solids"
    }

    fn options_schema(&self) -> Schema {
        schemars::schema_for!(SnowOptions)
    }

    fn problem_size(&self, case: &Case) -> Result<ProblemSize, CaseError> {
        setup::problem_size(case)
    }

    fn capabilities(&self, case: &Case) -> Result<Capabilities, CaseError> {
        setup::options(case)?;
        Ok(setup::capabilities(case))
    }

    fn plan_supported_case(&self, case: &Case) -> Result<Plan, CaseError> {
        setup::plan(case)
    }

    fn build_supported_case(&self, case: &Case) -> Result<Box<dyn Solver>, CaseError> {
        setup::build(case, None)
    }
}
