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
//! [`Mpm`] is the entry: it turns a [`Case`] into a [`Solver`], or, with its options, into a [`MpmSolver`] that a program steps, reads and
//! changes:
//!
//! ```
//! use colluvium_case::{Body, Case, Domain, Side, Space, Stage, Wall};
//! use colluvium_constitutive::MohrCoulombSpec;
//! use colluvium_mpm::{Mpm, MpmOptions, ShapeFunctions};
//!
//! let sand = MohrCoulombSpec { cohesion: 500.0, ..MohrCoulombSpec::new(1925.0, 1.98e6, 0.23, 31.0) };
//! let case = Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [0.5, 0.15]))
//!     .gravity([0.0, -9.81])
//!     .material("sand", sand)
//!     .body(Body::block("column", "sand", [0.0, 0.0], [0.1, 0.1]))
//!     .wall(Side::XMin, Wall::Smooth)
//!     .wall(Side::YMin, Wall::frictional(1.0))
//!     .stage(Stage::new("release", 0.1));
//! let options = MpmOptions { shape: ShapeFunctions::Ugimp, ..MpmOptions::new(0.01) };
//! let mut solver = Mpm::new(options).solver::<2>(&case)?;
//! let mut fastest = 0.0;
//! while solver.time() < 0.1 {
//!     solver.step()?;
//!     fastest = solver.points().velocity().iter().map(|v| v[0]).fold(fastest, f64::max);
//! }
//! // The column stands: the height 4 c / (ρ g) tan(45° + φ/2) of a vertical cut in this sand is 0.19 m.
//! assert!(fastest > 0.0 && fastest < 0.05);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Quantities are in SI units, angles of case files in degrees, and stress is positive in tension.
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
    Capabilities, Case, CaseError, ConfigurableMethod, ConfiguredMethod, Method, Plan, ProblemSize, Solver,
    typed_method,
};
use schemars::Schema;

pub use config::{
    BodyContact, ContactTest, DomainStretch, FixedNodes, InternalForceIntegration, LagrangianFormulation,
    MeshSource, MpmOptions, NodalMass, ObstacleCoupling, PenaltyContact, ShapeFunctions, StepCriterion,
    StressScheme, VelocityTransfer, VolumetricStrain, WallFriction,
};
pub use solver::{MpmNode, MpmPoints, MpmSolver};

/// The explicit material point method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mpm;

impl Mpm {
    /// Method with its options, which builds solvers that a program steps.
    pub fn new(options: MpmOptions) -> ConfiguredMethod<Self> {
        ConfiguredMethod::new(options)
    }
}

impl ConfigurableMethod for Mpm {
    type Options = MpmOptions;

    fn instance() -> &'static Self {
        &Mpm
    }
}

typed_method!(Mpm, setup::typed_solver, 1 => MpmSolver<1>, 2 => MpmSolver<2>, 3 => MpmSolver<3>);

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
