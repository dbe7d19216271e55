//! Transfers between points and nodes: particle to grid, FLIP, XPIC, APIC, and the grid itself.
//!
//! The module uses weights and masses, but no material law (sheet: mpm §2.3, §2.6).

pub(crate) mod affine_transfer;
pub(crate) mod background_grid;
pub(crate) mod dimension_dispatch;
pub(crate) mod p2g;
pub(crate) mod unstructured_mesh;
pub(crate) mod xpic;
