//! The problem and its run: what a case file says, what a solver must offer, and the loop between.
//!
//! A [`Case`] describes a problem once; a [`Method`] turns it into a [`Solver`].

pub mod description;
mod error;
pub mod solver;

pub use description::Case;
pub use error::CaseError;
pub use solver::{
    Budget, Equilibrium, Field, FieldData, Method, Plan, Snapshot, Solver, SolverError, TimeStep,
};
