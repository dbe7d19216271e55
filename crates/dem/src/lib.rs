//! Discrete element method: disks in the plane and spheres in space, by the same code.
//!
//! Grains are rigid bodies that overlap slightly in contact. Each pair of kinds has its laws ([`contact`]): normal, tangential
//! with friction, rolling resistance, attraction, bonds. Leap-frog steps integrate the motion, with velocities
//! half a step ahead (sheet: dem §3.4); [`DemSolver`] contains the step.
//!
//! In the plane masses, forces and stiffnesses are per metre of thickness. Stress is tension-positive. A normal points from
//! the second grain to the first, and an overlap is positive in contact.
//!
//! [`Dem`] is the entry point: it turns a [`Case`] into a [`Solver`].

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

use colluvium_case::{Capabilities, Case, CaseError, Method, Plan, ProblemSize, Solver};
use schemars::Schema;

pub use crate::output::void_ratio_bands::VoidRatioBands;
pub use config::{
    Adhesion, BodyGrains, BondSpec, CellControl, CellEntry, ContactVelocity, CyclicStrain, CyclicStress,
    DampingForm, DemOptions, Diameters, Fill, Friction, GrainKind, GrainStage, LatticePacking, LeverArm,
    MeasuringRegion, Membrane, NormalLaw, PairOverride, PairSpec, Pluviation, RollingSpec, Shaking,
    SpringReset, TangentialSpec, WallServo,
};
pub use contact::Contact;
pub use solver::DemSolver;
pub use specimen::Specimen;

/// Discrete element method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dem;

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
