//! Strain increments and stress at points: averages over cells and nodes, and integration over cells instead of points.
//!
//! The module reads nodal velocities and writes strains and stresses of points, cells and nodes (sheet: mpm §2.4, §3.4). It knows neither
//! walls nor contact; `transfer` and the modules above may know it.

pub(crate) mod averages;
pub(crate) mod cell_integration;
pub(crate) mod dual_domain;
pub(crate) mod force_columns;
pub(crate) mod free_surface;
pub(crate) mod stress_work;
pub(crate) mod volumetric_strain;
