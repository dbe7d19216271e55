//! The background grid of the material point methods.
//!
//! A [`Grid`] is a box of equal square (cubic) cells in one, two or three dimensions. A [`Basis`]
//! gives the shape functions of one axis (linear, GIMP, quadratic and cubic B-splines); a
//! [`Stencil`] is their product at a point, with [`Support::deposit`] (point to grid) and
//! [`Support::gather`] (grid to point). What is no such product ([`Corners`] of convected domains,
//! the elements of a [`Mesh`]) offers the same transfers as a [`Support`]. [`Layout`] keeps points sorted by cell and lets slabs of
//! cells scatter in parallel in an order fixed by the data: results are the same on any number of
//! threads. Solvers go through [`Sweeps`], which are compiled here for each kind of shape functions and point domains, and chosen
//! at run time by a [`Shape`]. [`Walls`] imposes the boundary conditions on the nodes.

mod axis;
mod basis;
mod corners;
mod domain;
mod grid;
mod layout;
mod mesh;
mod msh;
mod node;
mod pulled;
mod shape;
mod stencil;
mod support;
mod sweeps;
mod walls;
mod wrap;

pub use axis::{Axis, OnAxis};
pub use basis::{Basis, CubicSpline, Gimp, Linear, QuadraticSpline, WideGimp};
pub use corners::Corners;
pub use domain::{
    ConvectedCorners, ConvectedDomain, DomainSlice, Domains, DomainsMut, FixedDomain, Ground, InElement,
    PointDomain, ReferencePoint, RightStretch, Square, StretchingDomain, TurningDomain,
};
pub use grid::{Grid, GridError};
pub use layout::{Layout, sort_by_cell};
pub use mesh::{Element, Mesh, MeshError, Simplex};
pub use msh::MshError;
pub use node::{Gathered, Lanes, Node};
pub use pulled::Pulled;
pub use shape::Shape;
pub use stencil::Stencil;
pub use support::{NodeList, Support};
pub use sweeps::{Affine, Deposit, PhaseDeposit, Points, Sweeps, Window};
pub use walls::{Face, Faces, Wall, WallKind, Walls};
pub use wrap::wrap;
