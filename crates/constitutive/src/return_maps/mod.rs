//! Algorithms common to several return maps: radial return, substepping, scalar roots.
//!
//! They depend on tensors only.

pub(crate) mod radial_return;
pub(crate) mod scalar_roots;
pub(crate) mod substepping;
