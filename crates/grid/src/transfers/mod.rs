//! Transfers between points and nodes: the only code that is compiled for each kind of shape functions and point domains.
//!
//! A solver chooses its [`Transfers`] once ([`crate::ShapeFunctionKind`]) and calls them for the points of a body in a slab
//! ([`crate::Layout::for_each_slab`]) or in a block. Functions for single points are [`Transfers::for_each_weight`],
//! [`Transfers::momentum_at`] and [`Transfers::value_at`]. A transfer uses positions and nodes; its input and output are slices with one
//! entry a point.
//!
//! A step of any material point method is [`Transfers::p2g`], a solve on the nodes, and [`Transfers::g2p`]. The affine transfers (APIC,
//! TPIC) add [`AffineFields`] in P2G and use [`Transfers::g2p_affine`]; nodal fields of any meaning use
//! [`Transfers::p2g_values`] and [`Transfers::g2p_values`].

mod compiled;
pub(crate) mod shape_function_kind;

use std::fmt;
use std::ops::Range;

use crate::point_domain::{DomainSlice, Domains, GridView, SquareMatrix};
use crate::{Basis1d, InterpolatedMotion, NodalState, Vector4};

pub(crate) use crate::transfers::compiled::CompiledTransfers;

/// Points of one body, borrowed.
#[derive(Clone, Copy, Debug)]
pub struct PointSlice<'a, const D: usize> {
    /// Positions (m).
    pub position: &'a [[f64; D]],
    /// Domains of the points.
    pub domain: DomainSlice<'a, D>,
    /// Full width of the domains at the start (m).
    pub extent: &'a [f64; D],
}

impl<const D: usize> PointSlice<'_, D> {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// View of a range of the points.
    #[inline(always)]
    #[must_use]
    pub fn range(&self, points: Range<usize>) -> Self {
        Self {
            position: &self.position[points.clone()],
            domain: self.domain.range(points),
            extent: self.extent,
        }
    }
}

/// Range of nodes that a transfer may add to.
pub struct NodeRange<'a, T> {
    /// Nodes of the range.
    pub nodes: &'a mut [T],
    /// Number of the first node.
    pub first: usize,
}

/// Affine velocity fields of points.
#[derive(Clone, Copy, Debug)]
pub struct AffineFields<'a, const D: usize> {
    /// Whether they are moments `Σ N v (x_i - x_p)ᵀ` (APIC, m²/s) or gradients (TPIC, 1/s).
    pub moments: bool,
    /// Fields; row `i`, column `j`.
    pub fields: &'a [SquareMatrix<D>],
    /// Masses of the points (kg).
    pub mass: &'a [f64],
}

/// Quantities of the points that are transferred to the nodes of one phase.
#[derive(Clone, Copy, Debug)]
pub struct P2gInput<'a, const D: usize> {
    /// Momentum, and mass in the fourth lane; empty for a transfer of forces alone.
    pub momentum_and_mass: &'a [Vector4],
    /// Columns `-V σ e_j`, multiplied by the gradients; empty for a transfer of momenta alone.
    pub stress_columns: &'a [[Vector4; D]],
    /// Body forces of the points (N), which are multiplied by the weights; empty if there are none.
    pub body_force: &'a [Vector4],
    /// Affine velocity fields that contribute to the momentum; `None` without.
    pub affine_fields: Option<AffineFields<'a, D>>,
}

/// Quantities of the points that are transferred to nodes with two phases.
#[derive(Clone, Copy, Debug)]
pub struct P2gPhaseInput<'a, const D: usize> {
    /// Momenta, and masses in the fourth lanes.
    pub momentum_and_mass: &'a [[Vector4; 2]],
    /// Columns `-V σ e_j`, multiplied by the gradients.
    pub stress_columns: &'a [[[Vector4; D]; 2]],
    /// Forces that are multiplied by the weights; the fourth lane is free for a scalar, which is summed in the nodal force.
    pub body_force: &'a [[Vector4; 2]],
}

/// Transfers between the points of a body and the nodes.
pub trait Transfers<const D: usize>: Send + Sync + fmt::Debug {
    /// The shape functions along an axis.
    fn basis_1d(&self) -> Basis1d;

    /// Domains of `count` points at the start of a run.
    fn domains(&self, count: usize) -> Domains<D>;

    /// Points to grid: adds `N motion` and `Σ_j ∂N/∂x_j columns[j] + N body`.
    fn p2g(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        to: NodeRange<'_, NodalState>,
        given: &P2gInput<'_, D>,
    );

    /// Points to grid: adds `N value`, and the momenta of the affine fields.
    fn p2g_values(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        to: NodeRange<'_, Vector4>,
        values: &[Vector4],
        affine: Option<AffineFields<'_, D>>,
    );

    /// Points to grid: adds `N value`, and to lane `j` the product of `∂N/∂x_j` and lane `j` of the point's moments.
    fn p2g_moments(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        to: NodeRange<'_, Vector4>,
        values: &[Vector4],
        moments: &[Vector4],
    );

    /// Points to grid: adds `N² value`.
    fn p2g_squared_weights(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        to: NodeRange<'_, f64>,
        values: &[f64],
    );

    /// Grid to points: velocity, acceleration and velocity gradient.
    fn g2p(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[NodalState],
        out: &mut [InterpolatedMotion<D>],
    );

    /// Grid to points: velocities and accelerations as in [`Transfers::g2p`]; the gradients in `out` are unchanged.
    fn g2p_motion(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[NodalState],
        out: &mut [InterpolatedMotion<D>],
    );

    /// Grid to points: velocity and velocity gradient.
    fn g2p_velocity(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[Vector4],
        out: &mut [InterpolatedMotion<D>],
    );

    /// Grid to points: moments (APIC) or gradients (TPIC) of the velocities.
    fn g2p_affine(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[NodalState],
        moments: bool,
        out: &mut [SquareMatrix<D>],
    );

    /// Grid to points: [`Transfers::g2p`] and [`Transfers::g2p_affine`] together, with the same results.
    fn g2p_with_affine(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[NodalState],
        moments: bool,
        out: (&mut [InterpolatedMotion<D>], &mut [SquareMatrix<D>]),
    );

    /// Grid to points: `Σ N value`.
    fn g2p_values(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[Vector4],
        out: &mut [Vector4],
    );

    /// Grid to the first point: `Σ N value` of the momenta, or velocities, of the nodes.
    fn momentum_at(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[NodalState],
    ) -> Vector4;

    /// Grid to the first point: `Σ N value`.
    fn value_at(&self, ground: &GridView<'_, D>, points: &PointSlice<'_, D>, nodes: &[Vector4]) -> Vector4;

    /// Grid to points: `Σ N (v - a dt)`, the velocity at the start of a step of `dt` (s).
    fn g2p_start_velocity(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[NodalState],
        dt: f64,
        out: &mut [Vector4],
    );

    /// Second moments `Σ N (x_i - x_p)²` (m²) along each axis.
    fn second_moments(&self, ground: &GridView<'_, D>, points: &PointSlice<'_, D>, out: &mut [[f64; D]]);

    /// Calls `visit(point, node, N)` for every node of every point, for operations on a few points.
    fn for_each_weight(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        visit: &mut dyn FnMut(usize, usize, f64),
    );

    /// Points to grid: [`Transfers::p2g`] for two phases together.
    fn p2g_phases(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        to: NodeRange<'_, [NodalState; 2]>,
        given: &P2gPhaseInput<'_, D>,
    );

    /// Points to grid: adds `N value` for two phases together.
    fn p2g_phase_values(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        to: NodeRange<'_, [Vector4; 2]>,
        values: &[[Vector4; 2]],
    );

    /// Grid to points: [`Transfers::g2p`] for two phases together.
    fn g2p_phases(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[[NodalState; 2]],
        out: &mut [[InterpolatedMotion<D>; 2]],
    );

    /// Grid to points: [`Transfers::g2p_motion`] for two phases together.
    fn g2p_phase_motions(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[[NodalState; 2]],
        out: &mut [[InterpolatedMotion<D>; 2]],
    );

    /// Grid to points: [`Transfers::g2p_velocity`] for two phases together.
    fn g2p_phase_velocities(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[[Vector4; 2]],
        out: &mut [[InterpolatedMotion<D>; 2]],
    );
}
