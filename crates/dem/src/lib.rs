//! Discrete element method: disks in the plane and spheres in space, by the same code.
//!
//! It computes packings and flows of grains, laboratory tests on them, and rocks of bonded grains. Grains are rigid bodies that overlap
//! slightly in contact; each pair of kinds has its laws ([`contact`]): normal, tangential with friction, rolling resistance, attraction,
//! bonds. Leap-frog steps integrate the motion, with velocities half a step ahead (sheet: dem §3.4); [`DemSolver`] contains the step.
//!
//! [`Dem`] is the entry point: it turns a [`Case`] into a [`Solver`], or, with its options, into a [`DemSolver`] that a program steps,
//! reads and changes:
//!
//! ```
//! use colluvium_case::{Body, Case, Domain, Side, Space, Stage, Wall};
//! use colluvium_constitutive::LinearElasticSpec;
//! use colluvium_dem::{Dem, DemOptions, Fill, GrainKind, NormalLaw, PairSpec};
//!
//! let case = Case::new(Space::PlaneStrain, Domain::new([-1.0, -0.1], [1.0, 1.0]))
//!     .gravity([0.0, -10.0])
//!     .material("grain", LinearElasticSpec::new(2650.0, 1e7, 0.3)) // only its name is used
//!     .body(Body::ball("ball", "grain", [0.0, 0.45], 0.05))
//!     .wall(Side::YMin, Wall::Smooth)
//!     .stage(Stage::new("fall", 1.0));
//! let law = NormalLaw::linear(1e6).restitution(0.5);
//! let kind = GrainKind { fill: Some(Fill::Single), ..GrainKind::new(2650.0) };
//! let options = DemOptions::new([("grain", kind)], [PairSpec::new(["grain", "grain"], law).friction(0.5)]);
//! let mut solver = Dem::new(options).solver::<2>(&case)?;
//! let mut fastest: f64 = 0.0;
//! while solver.time() < 0.4 {
//!     solver.step()?;
//!     fastest = fastest.max(solver.grains().velocity()[0][1]);
//! }
//! // It falls by 0.5 m, and rebounds at half of its speed of √(2 g h) = 3.16 m/s.
//! assert!((fastest / 10.0_f64.sqrt() - 0.5).abs() < 0.02);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! It depends on the crates of the cases, the constitutive laws and the points. Quantities are in SI units; in the plane masses, forces and
//! stiffnesses are per metre of thickness. Stress is tension-positive. A normal points from the second grain to the first, and an overlap is
//! positive in contact. The theory is in `docs/theory/dem.md` and in the sheet `docs/sheets/dem.md`.

pub mod boundary;
mod checkpoint;
mod clock;
mod config;
pub mod contact;
mod force_loop;
pub mod material;
mod momentum;
mod neighbours;
mod obstacles;
pub mod output;
mod points;
mod setup;
mod solver;
pub mod specimen;

use colluvium_case::{
    Capabilities, Case, CaseError, ConfigurableMethod, ConfiguredMethod, Method, Plan, ProblemSize, Solver,
    typed_method,
};
use schemars::Schema;

pub use crate::output::void_ratio_bands::VoidRatioBands;
pub use config::{
    Adhesion, BodyGrains, BondSpec, CellControl, CellEntry, ContactVelocity, CyclicStrain, CyclicStress,
    DampingForm, DemOptions, Diameters, Fill, Friction, GrainKind, GrainStage, LatticePacking, LeverArm,
    MeasuringRegion, Membrane, NormalLaw, PairOverride, PairSpec, Pluviation, RollingSpec, Shaking,
    SpringReset, TangentialSpec, WallServo,
};
pub use contact::Contact;
pub use solver::{DemContacts, DemGrains, DemSolver, DemWall};
pub use specimen::Specimen;

/// Discrete element method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dem;

impl Dem {
    /// Method with its options, which builds solvers that a program steps.
    pub fn new(options: DemOptions) -> ConfiguredMethod<Self> {
        ConfiguredMethod::new(options)
    }
}

impl ConfigurableMethod for Dem {
    type Options = DemOptions;

    fn instance() -> &'static Self {
        &Dem
    }
}

typed_method!(Dem, setup::solver, 2 => DemSolver<2, 1>, 3 => DemSolver<3, 3>);

impl Method for Dem {
    fn name(&self) -> &'static str {
        "dem"
    }

    fn summary(&self) -> &'static str {
        "discrete element method: disks and spheres with friction, rolling resistance, adhesion and bonds"
    }

    fn options_schema(&self) -> Schema {
        schemars::schema_for!(DemOptions)
    }

    fn problem_size(&self, case: &Case) -> Result<ProblemSize, CaseError> {
        setup::problem_size(case)
    }

    fn capabilities(&self, case: &Case) -> Result<Capabilities, CaseError> {
        setup::options(case)?;
        Ok(setup::capabilities())
    }

    fn plan_supported_case(&self, case: &Case) -> Result<Plan, CaseError> {
        setup::plan(case)
    }

    fn plan_and_build_supported_case(&self, case: &Case) -> Result<(Plan, Box<dyn Solver>), CaseError> {
        setup::plan_and_build(case)
    }

    fn build_supported_case(&self, case: &Case) -> Result<Box<dyn Solver>, CaseError> {
        setup::build(case)
    }
}

/// Solver of a case in the plane with its concrete type, which gives access to its contacts.
///
/// # Errors
/// As [`Dem::build`].
pub fn disks(case: &Case) -> Result<DemSolver<2, 1>, CaseError> {
    setup::solver(case)
}

/// Solver of a case in space with its concrete type.
///
/// # Errors
/// As [`Dem::build`].
pub fn spheres(case: &Case) -> Result<DemSolver<3, 3>, CaseError> {
    setup::solver(case)
}

/// Names of the kinds of grains of a case, in the order of the numbers in the output field `kind`.
///
/// # Errors
/// When the case has no options of the method, or invalid ones.
pub fn kinds(case: &Case) -> Result<Vec<String>, CaseError> {
    Ok(setup::options(case)?.grains.into_keys().collect())
}
