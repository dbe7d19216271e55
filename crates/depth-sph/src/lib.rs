//! Depth-integrated smoothed particle hydrodynamics: flows over terrain.
//!
//! A node is a column of flowing material that moves in plan. Its depth is a sum over its neighbours (`neighbours::kernel`), and
//! depth gradients, slope ([`bed`]) and resistance of the bed (`phases::drag_and_resistance`) accelerate it. Grains and pore fluid may be
//! two sets of nodes that `phases::interphase_drag` couples; excess pore pressure is computed on a column of finite differences at every
//! node of the grains. [`flow::Flow`] has nodes and step, without a case; [`DepthSph`] is the entry point from a case.

pub mod analytical_solutions;
pub mod bed;
mod boundary;
pub mod config;
pub mod erosion;
pub mod flow;
pub mod inflow;
pub mod momentum;
pub mod neighbours;
pub mod output;
pub mod phases;
pub mod pore_pressure;
pub mod scalar_transport;
mod setup;
pub mod solver;

use colluvium_case::{Capabilities, Case, CaseError, Method, Plan, ProblemSize, Solver};
use schemars::Schema;

pub use crate::solver::DepthSolver;
pub use config::{
    BedRegion, ColumnOptions, DepthOptions, DilatancyOptions, EarthPressureOptions, FluidResistanceOptions,
    InflowOptions, MixtureOptions, SkeletonConfinement, SkeletonOptions, StopOptions,
};

/// Name of the method.
const NAME: &str = "depth-sph";

/// Depth-integrated smoothed particle hydrodynamics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DepthSph;

impl Method for DepthSph {
    fn name(&self) -> &'static str {
        NAME
    }

    fn summary(&self) -> &'static str {
        "depth-integrated SPH of flows over terrain: one phase, grains and pore fluid, or two layers; pore-pressure columns"
    }

    fn options_schema(&self) -> Schema {
        schemars::schema_for!(DepthOptions)
    }

    fn problem_size(&self, case: &Case) -> Result<ProblemSize, CaseError> {
        setup::problem_size(case)
    }

    fn has_elasticity(&self) -> bool {
        false
    }

    fn capabilities(&self, case: &Case) -> Result<Capabilities, CaseError> {
        setup::options(case)?;
        Ok(setup::capabilities())
    }

    fn plan_supported_case(&self, case: &Case) -> Result<Plan, CaseError> {
        setup::plan(case)
    }

    fn build_supported_case(&self, case: &Case) -> Result<Box<dyn Solver>, CaseError> {
        setup::build(case)
    }
}
