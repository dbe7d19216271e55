//! Smoothed particle hydrodynamics (SPH) of soils, solids and fluids, for large deformations and free surfaces without a grid: collapses,
//! flows against obstacles, soil under moving bodies. Bodies are one phase, in one dimension, plane strain and three dimensions.
//!
//! A body is a set of particles that carry mass, velocity, density, stress and the state of its law. A field at a particle, its gradient
//! and its Laplacian are sums over the particles around it: [`kernel`] has the smoothing kernels, [`pairs::operators`] the sums. The
//! particles move by the momentum equation in leapfrog steps, with velocities half a step behind the positions, or by six other schemes.
//! Rough walls are layers of particles, smooth walls mirrors.
//!
//! [`Sph`] is the entry: it turns a [`Case`] into a [`Solver`], or, with its options, into a [`SphSolver`] that a program steps, reads and
//! changes:
//!
//! ```
//! use colluvium_case::{Body, Case, Domain, Side, Space, Stage, Wall};
//! use colluvium_constitutive::MohrCoulombSpec;
//! use colluvium_sph::{Sph, SphOptions};
//!
//! let sand = MohrCoulombSpec { cohesion: 500.0, ..MohrCoulombSpec::new(1925.0, 1.98e6, 0.23, 31.0) };
//! let case = Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [0.5, 0.15]))
//!     .gravity([0.0, -9.81])
//!     .material("sand", sand)
//!     .body(Body::block("column", "sand", [0.0, 0.0], [0.1, 0.1]))
//!     .wall(Side::XMin, Wall::Smooth)
//!     .wall(Side::YMin, Wall::frictional(1.0))
//!     .stage(Stage::new("release", 0.1));
//! let options = SphOptions { viscosity_linear: 0.2, ..SphOptions::new(0.01) };
//! let mut solver = Sph::new(options).solver::<2>(&case)?;
//! let mut fastest = 0.0;
//! while solver.time() < 0.1 {
//!     solver.step()?;
//!     fastest = solver.particles().velocity().iter().map(|v| v[0]).fold(fastest, f64::max);
//! }
//! // The column stands: the height 4 c / (ρ g) tan(45° + φ/2) of a vertical cut in this sand is 0.19 m.
//! assert!(fastest > 0.0 && fastest < 0.05);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Quantities are in SI units, angles of case files in degrees, and stress is positive in tension. In plane strain masses, forces and
//! energies are per metre of thickness.
//!
//! Cases, the loop over their stages and the interface of all methods are those of `colluvium-case`, laws those of
//! `colluvium-constitutive`, and `colluvium-points` has the search for neighbours. Equations and algorithms are in the specification sheet
//! `docs/sheets/sph.md` of the repository (sheet: sph §3.3 is the step), and `docs/theory/sph.md` lists the file of each equation.
//! [`RankedSolver`] distributes the particles over ranks that exchange copies of them; only runs use it.

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

use colluvium_case::{
    Capabilities, Case, CaseError, ConfigurableMethod, ConfiguredMethod, Method, Plan, ProblemSize, Solver,
    typed_method,
};
use schemars::Schema;

pub use config::{
    ConfiningPressure, ConfiningPressureTarget, ContinuityEquation, DensityReset, LagrangianFormulation,
    MomentumEquation, Regularisation, RoughWall, ShiftingSpeed, SmoothWall, SmoothingLength, SoundSpeed,
    SphOptions, Symmetrisation, Tensile, TimeHistory, TimeIntegration, VelocityGradientOperator, WallStress,
    WallVelocity,
};
pub use kernel::Kernel;
pub use ranks::RankedSolver;
pub use solver::{SphParticles, SphSolver};

/// Method of smoothed particle hydrodynamics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sph;

impl Sph {
    /// Method with its options, which builds solvers that a program steps.
    pub fn new(options: SphOptions) -> ConfiguredMethod<Self> {
        ConfiguredMethod::new(options)
    }
}

impl ConfigurableMethod for Sph {
    type Options = SphOptions;

    fn instance() -> &'static Self {
        &Sph
    }
}

typed_method!(Sph, setup::typed_solver, 1 => SphSolver<1>, 2 => SphSolver<2>, 3 => SphSolver<3>);

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
