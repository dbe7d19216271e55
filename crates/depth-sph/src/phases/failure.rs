//! Failures of nodes that end a run.

use colluvium_case::FailureReason;
use colluvium_points::SearchError;
use thiserror::Error;

use crate::phases::phase::PhaseSet;

/// Failure of a node that ends the run.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("node {node_id} at {position:?} m: {reason}")]
pub struct FlowFailure {
    /// Number of the node.
    pub node_id: u64,
    /// Position (m).
    pub position: Vec<f64>,
    /// Reason of the failure.
    pub reason: FailureReason,
}

impl FlowFailure {
    /// Failure of node `i` of a set.
    pub fn at_node<const D: usize>(set: &PhaseSet<D>, i: usize, reason: impl Into<FailureReason>) -> Self {
        Self { node_id: set.nodes.id[i], position: set.nodes.position[i].to_vec(), reason: reason.into() }
    }

    /// Failure of the node that a neighbour search reports.
    pub fn of_search<const D: usize>(set: &PhaseSet<D>, error: &SearchError) -> Self {
        match error {
            SearchError::NotFinite(number) if *number < set.nodes.len() => {
                Self::at_node(set, *number, FailureReason::NotFinite("its position is not finite".to_owned()))
            }
            SearchError::TooSpread(_, number) if *number < set.nodes.len() => {
                Self::at_node(set, *number, FailureReason::coded(error.code(), error.to_string()))
            }
            _ => Self {
                node_id: 0,
                position: Vec::new(),
                reason: FailureReason::coded(error.code(), error.to_string()),
            },
        }
    }
}
