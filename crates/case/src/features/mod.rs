//! Features of a case, and the capabilities of a method: no feature of a case is ignored silently.
//!
//! A *feature* is an optional key with a value other than its default, or a variant of an object, named by the keys from the top:
//! `stages.excavate`, `boundaries.wall=frictional`. The list follows from the JSON Schema of a case, so that a new key is a feature at
//! once, and is rejected by a method without a rule for it.

mod capabilities;
mod requested_features;

pub use crate::features::capabilities::{Capabilities, RequiredInput};
pub use crate::features::requested_features::RequestedFeature;
