//! Finite-strain material point method for snow and other brittle, porous solids: slabs on weak layers, saw tests, release and flow of
//! avalanches. Bodies are one phase, in one dimension, plane strain and three dimensions.
//!
//! Points carry mass, velocity, stress and the state of a law at finite strain. A step is fused: mass, momentum and forces of the points
//! are transferred to the nodes of a grid of B-splines, the nodal momentum equation is solved with the walls, and points interpolate
//! their new velocity, its gradient and, with APIC, its affine part. Stress is updated last. The grid is larger than the domain of the
//! case, so that its shape functions are equal everywhere, and walls constrain the nodes on or behind them.
//!
//! [`SnowMpm`] is the entry: it turns a [`Case`] into a [`Solver`], or, with its options, into a [`SnowSolver`] that a program steps, reads
//! and changes:
//!
//! ```
//! use colluvium_case::{Body, Case, Domain, Side, Space, Stage, Wall};
//! use colluvium_constitutive::CohesiveCamClaySpec;
//! use colluvium_snow_mpm::{SnowMpm, SnowOptions};
//!
//! // Density, stiffness, slope of the critical state line, compressive strength, hardening factor.
//! let snow = CohesiveCamClaySpec {
//!     cohesion_ratio: 0.3,
//!     ..CohesiveCamClaySpec::new(400.0, 3e6, 0.3, 1.2, 3000.0, 1.0)
//! };
//! let case = Case::new(Space::PlaneStrain, Domain::new([-1.0, 0.0], [1.0, 0.6]))
//!     .gravity([0.0, -9.81])
//!     .material("snow", snow)
//!     .body(Body::ball("ball", "snow", [0.0, 0.24], 0.2).velocity([0.0, -5.0]))
//!     .wall(Side::YMin, Wall::Rough)
//!     .stage(Stage::new("impact", 0.02));
//! let mut solver = SnowMpm::new(SnowOptions::new(0.04)).solver::<2>(&case)?;
//! let mut densest = 0.0;
//! while solver.time() < 0.02 {
//!     solver.step()?;
//!     densest = solver.points().density().fold(densest, f64::max);
//! }
//! // The ball is compacted where it hits the floor.
//! assert!(densest > 1.1 * 400.0 && densest < 3.0 * 400.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Quantities are in SI units, angles of case files in degrees, and stress is positive in tension. In plane strain masses, forces and
//! energies are per metre of thickness.
//!
//! Cases, the loop over their stages and the interface of all methods are those of `colluvium-case`, laws those of
//! `colluvium-constitutive`; `colluvium-points` and `colluvium-grid` have the points and the transfers. Equations and algorithms are in the
//! specification sheet `docs/sheets/snow-mpm.md` of the repository (sheet: snow-mpm §3.5 is the step), and `docs/theory/snow-mpm.md` lists
//! the file of each equation.

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

use colluvium_case::{
    Capabilities, Case, CaseError, ConfigurableMethod, ConfiguredMethod, Method, Plan, ProblemSize, Solver,
    typed_method,
};
use schemars::Schema;

pub use config::{DeformationUpdate, SnowOptions, SnowTransfer, SplineShape};
pub use solver::{SnowPoints, SnowSolver};

/// Finite-strain material point method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SnowMpm;

impl SnowMpm {
    /// Method with its options, which builds solvers that a program steps.
    pub fn new(options: SnowOptions) -> ConfiguredMethod<Self> {
        ConfiguredMethod::new(options)
    }
}

impl ConfigurableMethod for SnowMpm {
    type Options = SnowOptions;

    fn instance() -> &'static Self {
        &SnowMpm
    }
}

typed_method!(SnowMpm, setup::typed_solver, 1 => SnowSolver<1>, 2 => SnowSolver<2>, 3 => SnowSolver<3>);

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
