//! Transfers between points and nodes: particle to grid, FLIP, XPIC, APIC, and the update of points from the grid (sheet: mpm §2.3,
//! §2.6).
//!
//! Particle to grid sums the forces of all other modules: stress, contact, obstacles, loads. The update of points calls the material law.
//! Only `phases`, `solver`, `setup` and `output` may know this module.

pub(crate) mod affine_transfer;
pub(crate) mod p2g;
pub(crate) mod point_update;
pub(crate) mod xpic;
