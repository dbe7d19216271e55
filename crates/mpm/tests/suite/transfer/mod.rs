//! Transfers of velocity, and shape functions.

mod shape_functions;
pub mod velocity_transfers;
