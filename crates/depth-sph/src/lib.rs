//! Depth-integrated smoothed particle hydrodynamics: flows over terrain.
//!
//! A node is a column of flowing material that moves in plan. Its depth is a sum over its neighbours (`kernel`), and
//! depth gradients, slope ([`bed`]) and resistance of the bed (`momentum::drag_and_resistance`) accelerate it. Grains and pore fluid may be
//! two sets of nodes that `laws::interphase_drag` couples; excess pore pressure is computed on a column of finite differences at every
//! node of the grains. [`flow::Flow`] has nodes and step, without a case; [`DepthSph`] is the entry point from a case.

pub mod analytical_solutions;
pub mod bed;
mod boundary;
pub mod clock;
pub mod config;
mod context;
mod energy_balance;
pub mod flow;
mod flow_nodes;
pub mod inflow;
pub mod kernel;
pub mod laws;
mod momentum;
mod neighbours;
pub mod output;
mod phases;
pub mod points;
pub mod pore_pressure;
pub mod scalar_transport;
mod setup;
pub mod solver;

use colluvium_case::{Capabilities, Case, CaseError, Method, Plan, PointList, ProblemSize, Snapshot, Solver};
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

/// Points of a depth-resolved model from the nodes of a depth-integrated flow (sheet: depth-sph §3.2, 4). Each node becomes a stack of
/// points about as high as wide.
///
/// # Errors
/// When the frame is not one of depth-integrated flow of one phase, or of grains and fluid.
pub fn point_stacks(case: &Case, snapshot: &Snapshot) -> Result<PointList, CaseError> {
    output::export_points::point_stacks(case, &setup::options(case)?, snapshot)
}
