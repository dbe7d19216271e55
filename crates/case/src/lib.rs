//! Case description, solver interface and run loop.
//!
//! A [`Case`] describes a problem once; a [`Method`] turns it into a [`Solver`].

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
pub use crate::bodies::point_changes::removed_points;
pub use crate::bodies::point_file::{GrainColumns, PointList};
pub use crate::description::formula::Formula;
pub use crate::description::properties::spatial;
pub use crate::files::column_file::{ColumnFile, ColumnRow, Quantity, read_pairs};
pub use crate::solver::equilibrium::{Equilibrium, EquilibriumScales};
pub use crate::solver::manufactured::{Manufactured, PrescribedState};
pub use crate::validate::time_scales::{BodyDensities, TimeScales};
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
    Advance, Budget, Dataset, DatasetGeometry, FailureReason, Field, FieldData, FieldRole, Frame,
    FrameRequest, Lattice, Method, MissedEquilibrium, PhaseBudget, Plan, PlanRaster, ProblemSize, Reaction,
    Resolution, Snapshot, Solver, SolverError, StepLimit, TimeStep, TimeStepError,
};
