//! The problem and its run: what a case file says, what a solver must offer, and the loop between.
//!
//! A [`Case`] describes a problem once; a [`Method`] turns it into a [`Solver`].

mod arc_layer;
mod closed_liquid;
mod columns;
pub mod damping;
mod decimal;
pub mod description;
mod equilibrium;
mod error;
mod features;
mod formula;
mod initial_stress;
pub mod json;
pub mod law;
mod layers;
pub mod lines;
mod load;
pub mod loads;
mod manufactured;
pub mod measure;
mod obstacle;
mod origin;
pub mod output;
mod plan_rasters;
mod plan_region;
mod point_list;
mod pore_fluid;
mod ramps;
pub mod rigid;
pub mod run;
mod samples;
pub mod solver;
mod surface;
mod time_scales;
mod validate;
mod warnings;

pub use columns::{ColumnFile, ColumnRow, Quantity, read_pairs};
pub use description::Case;
pub use equilibrium::{Equilibrium, EquilibriumScales};
pub use error::{CaseError, CaseErrors, printable, shortened};
pub use features::{Capabilities, RequestedFeature, RequiredInput};
pub use formula::Formula;
pub use load::spatial;
pub use manufactured::{Manufactured, PrescribedState};
pub use obstacle::{
    MovingObstacle, MovingObstacles, OVERLAP_TOLERANCE, ObstacleLaw, ObstacleLaws, ObstacleOverlap,
    PlacedObstacle, constraining_obstacles, limit_step_by_obstacles, normal_inside,
};
pub use plan_region::PlanRegion;
pub use point_list::{GrainColumns, PointList};
pub use run::{RunError, RunOptions, RunReport, SafetyResult, TrialVerdict, run, run_method, run_with_plan};
pub use solver::{
    Advance, Budget, Dataset, DatasetGeometry, Field, FieldData, FieldRole, Frame, FrameRequest, Lattice,
    Method, PhaseBudget, Plan, PlanRaster, ProblemSize, Reaction, Resolution, Snapshot, Solver, SolverError,
    StepLimit, TimeStep,
};
pub use time_scales::{BodyDensities, TimeScales};
