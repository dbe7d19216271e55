//! Contact of bodies on the grid: gaps, normals, Coulomb friction, and rigid bodies.
//!
//! Two bodies in contact have a velocity field each. The module changes these fields (sheet: mpm §2.7).

pub(crate) mod contact_correction;
pub(crate) mod contact_gap;
pub(crate) mod contact_law;
pub(crate) mod nodal_contact;
pub(crate) mod rigid_contact;
