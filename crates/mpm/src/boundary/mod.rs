//! Boundary conditions: walls, absorbing boundaries, loads, and bodies with prescribed or rigid motion.
//!
//! The module reads the case and the nodal velocities. It changes nodal velocities and forces (sheet: mpm §2.5). `BoundaryConditions` owns
//! all external actions, those of `contact` and `obstacles` among them. `transfer`, `phases` and the modules above may know it; it knows no
//! material law.

pub(crate) mod absorbing_boundary;
pub(crate) mod body_force;
pub(crate) mod boundary_conditions;
pub(crate) mod mesh_loads;
pub(crate) mod mesh_walls;
pub(crate) mod nodal_loads;
pub(crate) mod point_loads;
pub(crate) mod prescribed_motion;
pub(crate) mod rigid_bodies;
pub(crate) mod walls;
