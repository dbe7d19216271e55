//! What a case asks for, and what a method says to it: nothing in a case is ignored.
//!
//! A *feature* is an optional key that a case sets to something else than its default, or a variant that it chooses, named by
//! the keys from the top: `stages.excavate`, `boundaries.wall=frictional`. The list follows from the JSON Schema of a case, so
//! that a new key is a feature at once, and a method that never heard of it refuses it.

mod capabilities;
mod requested_features;

pub use crate::features::capabilities::{Capabilities, RequiredInput};
pub use crate::features::requested_features::RequestedFeature;
