//! The background grid of the material point methods.
//!
//! A [`Grid`] is a box of equal square (cubic) cells in one, two or three dimensions. A [`Basis`]
//! gives the shape functions of one axis (linear, GIMP, quadratic and cubic B-splines); a
//! [`Stencil`] is their product at a point, with [`NodeSupport::p2g`] (point to grid) and
//! [`NodeSupport::g2p`] (grid to point). Supports that are no such product ([`CpdiBasis`] of convected domains, the elements of a [`Mesh`])
//! have the same transfers as a [`NodeSupport`]. [`Layout`] keeps points sorted by cell; slabs of cells scatter in parallel in an order
//! fixed by the data, so that results are the same on any number of threads. Solvers use [`Transfers`], which are compiled here for each
//! kind of shape functions and point domains, and chosen
//! at run time by a [`ShapeFunctionKind`]. [`NodeWalls`] imposes the boundary conditions on the nodes.
//!
//! ```
//! use colluvium_grid::{Basis, Grid, NodeSupport, QuadraticSpline, Stencil};
//!
//! let grid = Grid::new([0.0, 0.0], [1.0, 0.5], 0.1)?;
//! let position = [0.43, 0.21];
//! // Quadratic splines have three nodes along each axis. Points have no width.
//! let stencil = Stencil::<2, 3>::new::<QuadraticSpline>(&grid, &position, &[0.0, 0.0]);
//! let nodes_in_row = QuadraticSpline::nodes(grid.cells[1]);
//! let (mut sum, mut mean, mut slope) = (0.0, 0.0, [0.0; 2]);
//! stencil.for_each(&[nodes_in_row, 1], |node, weight, gradient| {
//!     let x = QuadraticSpline::coordinate(node / nodes_in_row, grid.cells[0]) * grid.cell;
//!     sum += weight;
//!     mean += weight * x;
//!     slope = [slope[0] + gradient[0] * x, slope[1] + gradient[1] * x];
//! });
//! // A partition of unity that reproduces linear fields and their gradients.
//! assert!((sum - 1.0).abs() < 1e-14 && (mean - position[0]).abs() < 1e-14);
//! assert!((slope[0] - 1.0).abs() < 1e-13 && slope[1].abs() < 1e-13);
//! # Ok::<(), colluvium_grid::GridError>(())
//! ```
//!
//! Quantities are in SI units, and stress is positive in tension. The crate depends on no other of the workspace.
//! The equations are in `docs/sheets/mpm.md` of the repository (§2), and `docs/theory/mpm.md` lists the file of each.

mod boundary;
mod grid;
mod layout;
mod mesh;
mod nodes;
mod point_domain;
mod shape_functions;
mod transfers;

pub use crate::boundary::periodic_wrap::wrap_into_period;
pub use crate::boundary::walls::{NodeFace, NodeFaces, NodeWall, NodeWalls, WallKind};
pub use crate::mesh::msh::MshError;
pub use crate::nodes::nodal_state::{InterpolatedMotion, NodalState, Vector4};
pub use crate::point_domain::{
    ConvectedDomain, ConvectedQuadrilateral, DomainSlice, Domains, DomainsMut, ElementDomain, FixedDomain,
    GridView, PointDomain, ReferenceDomain, RightStretchDiagonal, RightStretchDomain, SquareMatrix,
    StretchingDomain,
};
pub use crate::shape_functions::basis::{Basis, ContiguousGimpBasis, GimpBasis, LinearBasis};
pub use crate::shape_functions::basis_1d::{Basis1d, BasisValues1d};
pub use crate::shape_functions::cpdi_basis::CpdiBasis;
pub use crate::shape_functions::node_support::{NodeList, NodeSupport};
pub use crate::shape_functions::reference_basis::ReferenceStencil;
pub use crate::shape_functions::spline_basis::{CubicSpline, QuadraticSpline};
pub use crate::shape_functions::stencil::Stencil;
pub use crate::transfers::shape_function_kind::ShapeFunctionKind;
pub use crate::transfers::{AffineFields, NodeRange, P2gInput, P2gPhaseInput, PointSlice, Transfers};
pub use grid::{Grid, GridError};
pub use layout::{Layout, sort_by_cell};
pub use mesh::{Element, Mesh, MeshError, SimplexBasis};
