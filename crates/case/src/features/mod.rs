//! Features of a case, and the capabilities of a method: no feature of a case is ignored silently.
//!
//! A *feature* is an optional key with a value other than its default, or a variant of an object, named by the keys from the top:
//! `stages.excavate`, `boundaries.wall=frictional`. [`Feature`](crate::Feature) lists them. The list follows from the JSON Schema of a case: a test fails
//! for a new key until the list is made anew, and then a method rejects the key until it has a rule for it.

mod capabilities;
mod requested_features;
mod schema;
#[cfg(test)]
mod schema_tests;

pub use crate::features::capabilities::{Capabilities, RequiredInput};
pub use crate::features::requested_features::RequestedFeature;
