//! The background grid of the material point methods.
//!
//! A [`Grid`] is a box of equal square (cubic) cells in one, two or three dimensions. A [`Basis`]
//! gives the shape functions of one axis (linear, GIMP, quadratic and cubic B-splines); a
//! [`Stencil`] is their product at a point, with [`Support::deposit`] (point to grid) and
//! [`Support::gather`] (grid to point). What is no such product ([`Corners`] of convected domains,
//! the elements of a [`Mesh`]) offers the same transfers as a [`Support`]. [`Layout`] keeps points sorted by cell and lets slabs of
//! cells scatter in parallel in an order fixed by the data: results are the same on any number of
//! threads. [`Walls`] imposes the boundary conditions on the nodes.

mod basis;
mod corners;
mod grid;
mod layout;
mod mesh;
mod msh;
mod pulled;
mod stencil;
mod support;
mod walls;

pub use basis::{Basis, CubicSpline, Gimp, Linear, QuadraticSpline, WideGimp};
pub use corners::Corners;
pub use grid::{Grid, GridError};
pub use layout::{Layout, sort_by_cell};
pub use mesh::{Element, Mesh, MeshError, Simplex};
pub use msh::MshError;
pub use pulled::Pulled;
pub use stencil::{Gathered, Lanes, Node, Stencil};
pub use support::{NodeList, Support};
pub use walls::{Wall, WallKind, Walls};
