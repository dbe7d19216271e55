//! The laws, one file each.

mod linear_elastic;

pub use linear_elastic::{Elasticity, LinearElastic};
