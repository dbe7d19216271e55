//! Shape functions of the background grid: linear, GIMP, CPDI and B-splines, and the support nodes of a point.
//!
//! A basis has weights and gradients along an axis; a stencil is their product (sheet: mpm §2.2).
//! The module depends on the grid only.

pub(crate) mod basis;
pub(crate) mod basis_1d;
pub(crate) mod cpdi_basis;
pub(crate) mod node_support;
pub(crate) mod reference_basis;
pub(crate) mod spline_basis;
pub(crate) mod stencil;
