//! Depth-integrated smoothed particle hydrodynamics: flows over terrain.
//!
//! It computes debris flows, landslides, avalanches and floods, with runout, depths and speeds. A node is a column of flowing material that
//! moves in plan. Its depth is a sum over its neighbours (`kernel`), and depth gradients, slope ([`bed`]) and resistance of the bed
//! (`momentum::drag_and_resistance`) accelerate it. Grains and pore fluid may be two sets of nodes that `laws::interphase_drag` couples;
//! excess pore pressure is computed on a column of finite differences at every node of the grains.
//!
//! [`flow::Flow`] has nodes and step, without a case; [`DepthSph`] is the entry point: it turns a [`Case`] into a [`Solver`], or, with its
//! options, into a [`DepthSolver`] that a program steps, reads and changes:
//!
//! ```
//! use colluvium_case::{Body, Case, Domain, Side, Space, Stage, Wall};
//! use colluvium_constitutive::NewtonianFluidSpec;
//! use colluvium_depth_sph::{DepthOptions, DepthSph};
//!
//! let case = Case::new(Space::PlaneStrain, Domain::new([-20.0, 0.0], [20.0, 2.0]))
//!     .gravity([0.0, -9.81])
//!     .material("water", NewtonianFluidSpec::new(1000.0, 2e6))
//!     .body(Body::block("reservoir", "water", [-10.0, 0.0], [0.0, 1.0]))
//!     .wall(Side::YMin, Wall::Smooth)
//!     .stage(Stage::new("dam break", 1.0));
//! let mut solver = DepthSph::new(DepthOptions::new(0.05)).solver::<1>(&case)?;
//! while !solver.is_complete() {
//!     solver.step()?;
//! }
//! let (position, depth) = (solver.nodes().position(), solver.nodes().depth());
//! let at_dam = position.iter().zip(depth.iter()).filter(|(x, _)| x[0].abs() < 0.1).map(|(_, depth)| *depth);
//! let (sum, count) = at_dam.fold((0.0, 0), |(sum, count), h| (sum + h, count + 1));
//! // The depth at the dam is 4/9 of that of the reservoir (Ritter).
//! assert!((sum / f64::from(count) - 4.0 / 9.0).abs() < 0.01);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The number is that of the dimensions of the plan: 1 for a profile in plane strain, 2 for terrain in three dimensions. The crate depends
//! on those of the cases, the constitutive laws and the points. Quantities are in SI units, per metre of width in a profile; levels are
//! positive upwards, and pressures in compression. The theory is in `docs/theory/depth-sph.md` and in the sheet
//! `docs/sheets/depth-sph.md`.

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

use colluvium_case::{
    Capabilities, Case, CaseError, ConfigurableMethod, ConfiguredMethod, Method, Plan, PointList,
    ProblemSize, Snapshot, Solver, typed_method,
};
use schemars::Schema;

pub use crate::kernel::Kernel;
pub use crate::laws::erosion::Erosion;
pub use crate::laws::interphase_drag::InterphaseDrag;
pub use crate::laws::pore_pressure_column::{Drainage, LowerBound, PressureProfile};
pub use crate::solver::{DepthNodes, DepthSolver};
pub use config::choices::{
    DepthFrame, FlowLayer, InflowDistribution, Metric, Phases, PressureForceForm, SearchOrientation,
    ThicknessEquation, TimeScheme,
};
pub use config::{
    BedRegion, ColumnOptions, DamOptions, DepthOptions, DilatancyOptions, EarthPressureOptions,
    FluidResistanceOptions, InflowOptions, MixtureOptions, SkeletonConfinement, SkeletonOptions, StopOptions,
};

/// Name of the method.
const NAME: &str = "depth-sph";

/// Depth-integrated smoothed particle hydrodynamics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DepthSph;

impl DepthSph {
    /// Method with its options, which builds solvers that a program steps.
    pub fn new(options: DepthOptions) -> ConfiguredMethod<Self> {
        ConfiguredMethod::new(options)
    }
}

impl ConfigurableMethod for DepthSph {
    type Options = DepthOptions;

    fn instance() -> &'static Self {
        &DepthSph
    }

    fn dimension(&self, case: &Case) -> usize {
        case.dimension().saturating_sub(1).max(1)
    }
}

typed_method!(DepthSph, setup::typed_solver, 1 => DepthSolver<1>, 2 => DepthSolver<2>);

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
