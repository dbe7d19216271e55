//! The background grid of the material point methods.
//!
//! A [`Grid`] is a box of equal square (cubic) cells in one, two or three dimensions. A [`Basis`]
//! gives the shape functions of one axis (linear, GIMP, quadratic and cubic B-splines); a
//! [`Stencil`] is their product at a point, with [`Stencil::deposit`] (point to grid) and
//! [`Stencil::gather`] (grid to point). [`Layout`] keeps points sorted by cell and lets slabs of
//! cells scatter in parallel in an order fixed by the data: results are the same on any number of
//! threads. [`Walls`] imposes the boundary conditions on the nodes.

mod basis;
mod grid;
mod layout;
mod phases;
mod stencil;
mod walls;

pub use basis::{Basis, CubicSpline, Gimp, Linear, QuadraticSpline, WideGimp};
pub use grid::{Grid, GridError};
pub use layout::{Layout, sort_by_cell};
pub use stencil::{Gathered, Lanes, Node, Stencil};
pub use walls::{Wall, WallKind, Walls};
