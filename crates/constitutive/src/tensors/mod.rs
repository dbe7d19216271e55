//! Algebra of symmetric tensors and measures of strain.
//!
//! Tension is positive; components are in the order xx, yy, zz, xy, yz, zx.

pub(crate) mod spectral;
pub mod strain_measures;
pub(crate) mod tensor;
