//! Explicit material point method.

mod config;

pub use config::{FixedNodes, MpmOptions, ShapeFunctions, StressScheme};
