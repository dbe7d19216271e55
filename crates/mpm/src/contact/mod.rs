//! Contact of bodies on the grid: gaps, normals, Coulomb friction, and rigid bodies.
//!
//! Two bodies in contact have a velocity field each. The module changes these fields (sheet: mpm §2.7), and the motion of free rigid bodies,
//! which also rest on walls and on the obstacles of `obstacles`. It knows neither stress nor loads; `boundary` and the modules above may
//! know it.

pub(crate) mod contact_correction;
pub(crate) mod contact_gap;
pub(crate) mod contact_law;
pub(crate) mod nodal_contact;
pub(crate) mod rigid_contact;
