//! Case description, interface of the solvers, and runs.
//!
//! A [`Case`] describes a problem once: bodies, materials, walls, loads and stages. A [`Method`] turns it into a [`Solver`], a
//! [`Simulation`] steps a solver by hand, and a `Run` (feature `output`) records measures, frames and checkpoints. The methods are in the
//! crates `colluvium-mpm`, `colluvium-sph`, `colluvium-snow-mpm`, `colluvium-dem` and `colluvium-depth-sph`, each with an example on its
//! front page.
//!
//! A case is built in Rust or read from JSON. Both are checked by the same rules, and errors have the path of the value:
//!
//! ```
//! use colluvium_case::{Body, Case, CaseErrorKind, Domain, Side, Space, Stage, Wall};
//! use colluvium_constitutive::MohrCoulombSpec;
//!
//! let case = |density| {
//!     Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [0.5, 0.15]))
//!         .gravity([0.0, -9.81])
//!         .material("sand", MohrCoulombSpec::new(density, 1.98e6, 0.23, 31.0))
//!         .body(Body::block("column", "sand", [0.0, 0.0], [0.1, 0.1]))
//!         .wall(Side::YMin, Wall::frictional(0.6))
//!         .stage(Stage::new("release", 0.6))
//! };
//! let described = case(1925.0);
//! described.validate()?;
//! let read = Case::from_json(&described.to_json())?;
//! assert_eq!(read.fingerprint(), described.fingerprint());
//!
//! let errors = case(-1.0).validate().unwrap_err();
//! assert_eq!(errors.first().path, "materials.sand.density");
//! assert!(matches!(errors.first().kind, CaseErrorKind::OutOfRange { value, .. } if value == -1.0), "{errors}");
//! # Ok::<(), colluvium_case::CaseErrors>(())
//! ```
//!
//! Quantities are in SI units, angles in degrees, and stress is positive in tension. In plane strain masses, forces and energies are per
//! metre of thickness. Positions of a case are relative to the origin of its domain; those of its file are map coordinates. The laws are
//! those of `colluvium-constitutive`, shapes and surfaces those of `colluvium-points`. `docs/case-file.md` of the repository describes all
//! keys.

pub mod bodies;
mod case_file;
pub mod description;
mod error;
mod error_collector;
mod feature_list;
mod features;
pub mod files;
pub mod loads;
pub mod measure;
mod obstacle;
pub mod output;
pub mod rigid;
#[cfg(feature = "output")]
pub mod run;
mod simulation;
pub mod solver;
mod validate;

pub use crate::bodies::plan_region::PlanRegion;
pub use crate::bodies::point_changes::{GRAIN_COLUMNS, removed_points};
pub use crate::bodies::point_file::{GrainColumns, PointList};
pub use crate::description::formula::Formula;
pub use crate::description::properties::spatial;
pub use crate::files::column_file::{ColumnFile, ColumnRow, Quantity, read_pairs};
pub use crate::solver::equilibrium::{Equilibrium, EquilibriumScales};
pub use crate::solver::manufactured::{Manufactured, PrescribedState};
pub use crate::validate::time_scales::{BodyDensities, TimeScales};
pub use crate::validate::unit_checks::friction_warning;
pub use colluvium_constitutive::Warning;
pub use colluvium_points::{Sampling, Shape};
pub use description::{
    Axis, Body, Boundary, Case, Domain, EquilibriumCriterion, FactorOfSafety, InitialStress, Load,
    MethodOptions, Obstacle, ObstacleMotion, ObstacleShape, ObstacleWall, Output, Patch, PointFile,
    PoreFluid, PorePressure, PrescribedMotion, RemovalShape, Side, Space, Stage, Velocity, Wall,
};
pub use error::{CaseError, CaseErrorKind, CaseErrors, printable, shortened};
pub use feature_list::Feature;
pub use features::{Capabilities, RequestedFeature, RequiredInput};
pub use measure::Measure;
pub use obstacle::{
    MovingObstacle, MovingObstacles, OVERLAP_TOLERANCE, ObstacleLaw, ObstacleLaws, ObstacleOverlap,
    PlacedObstacle, ProgramMotion, constraining_obstacles, limit_step_by_obstacles, normal_inside,
};
#[cfg(feature = "output")]
pub use run::{
    Run, RunError, RunEvent, RunOptions, RunReport, SafetyResult, TrialVerdict, run, run_method,
    run_with_plan,
};
pub use simulation::{
    BodyForce, ConfigurableMethod, ConfiguredMethod, InvalidBodyForce, PointColumn, Simulation, TypedMethod,
    check_saved_body_force,
};
pub use solver::{
    Advance, Budget, Dataset, DatasetGeometry, FailureReason, Field, FieldData, FieldList, FieldRole, Frame,
    FrameRequest, Lattice, Method, MissedEquilibrium, PhaseBudget, Plan, PlanRaster, ProblemSize, Reaction,
    Resolution, Snapshot, Solver, SolverError, StepLimit, TimeStep, TimeStepError,
};
