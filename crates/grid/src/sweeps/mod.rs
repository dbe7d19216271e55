//! Sweeps over points and their nodes: the only code that is compiled for each kind of shape functions and point domains.
//!
//! A solver chooses its [`Sweeps`] once ([`crate::Shape`]) and calls them for the points of a body in a slab ([`crate::Layout::scatter`]) or
//! in a block, never for a single one ([`Sweeps::weights`] excepted). A sweep knows places and nodes; what is carried between them comes in and goes out in
//! slices, one entry a point.
//!
//! A step of any material point method is `deposit`, a solve on the nodes, and `gather`. The affine transfers (APIC, TPIC) add
//! [`Affine`] to what is deposited and gather with [`Sweeps::gather_affine`]; fields of nodes of any meaning go through
//! [`Sweeps::deposit_values`] and [`Sweeps::interpolate`].

mod compiled;

use std::fmt;
use std::ops::Range;

use crate::domain::{DomainSlice, Domains, Ground, Square};
use crate::{Axis, Gathered, Lanes, Node};

pub(crate) use compiled::Of;

/// Points of one body, borrowed.
#[derive(Clone, Copy, Debug)]
pub struct Points<'a, const D: usize> {
    /// Positions (m).
    pub position: &'a [[f64; D]],
    /// Domains.
    pub domain: DomainSlice<'a, D>,
    /// Full width of the domains at the start (m).
    pub extent: &'a [f64; D],
}

impl<const D: usize> Points<'_, D> {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Some of them.
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

/// The nodes that a sweep may add to.
pub struct Window<'a, T> {
    /// The nodes.
    pub nodes: &'a mut [T],
    /// Number of the first.
    pub first: usize,
}

/// What points carry of the affine velocity fields around them.
#[derive(Clone, Copy, Debug)]
pub struct Affine<'a, const D: usize> {
    /// Whether they are moments `Σ N v (x_i - x_p)ᵀ` (APIC, m²/s) or gradients (TPIC, 1/s).
    pub moments: bool,
    /// They; row `i`, column `j`.
    pub fields: &'a [Square<D>],
    /// Masses of the points (kg).
    pub mass: &'a [f64],
}

/// What points give to their nodes in one phase.
#[derive(Clone, Copy, Debug)]
pub struct Deposit<'a, const D: usize> {
    /// Momentum, and mass in the fourth lane.
    pub motion: &'a [Lanes],
    /// `-V σ e_j`: what is multiplied by the gradients.
    pub columns: &'a [[Lanes; D]],
    /// Forces that are multiplied by the weights; empty where there are none.
    pub body: &'a [Lanes],
    /// What is added to the momentum for the velocity fields around the points.
    pub affine: Option<Affine<'a, D>>,
}

/// The same in two phases, of which each node has one entry.
#[derive(Clone, Copy, Debug)]
pub struct PhaseDeposit<'a, const D: usize> {
    /// Momenta, and masses in the fourth lanes.
    pub motion: &'a [[Lanes; 2]],
    /// What is multiplied by the gradients.
    pub columns: &'a [[[Lanes; D]; 2]],
    /// Forces that are multiplied by the weights; the fourth lane is free for a scalar, which the force of the node sums up.
    pub body: &'a [[Lanes; 2]],
}

/// Sweeps over the points of one body and their nodes.
pub trait Sweeps<const D: usize>: Send + Sync + fmt::Debug {
    /// The shape functions along an axis.
    fn axis(&self) -> Axis;

    /// Domains of so many points, which have not moved yet.
    fn domains(&self, count: usize) -> Domains<D>;

    /// Points to grid: adds `N motion` and `Σ_j ∂N/∂x_j columns[j] + N body`.
    fn deposit(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        to: Window<'_, Node>,
        given: &Deposit<'_, D>,
    );

    /// Points to grid: adds `N value`, and what the `affine` fields add to momenta.
    fn deposit_values(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        to: Window<'_, Lanes>,
        values: &[Lanes],
        affine: Option<Affine<'_, D>>,
    );

    /// Points to grid: adds `N value`, and to lane `j` the share `∂N/∂x_j` of lane `j` of the point's moments.
    fn deposit_gradients(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        to: Window<'_, Lanes>,
        values: &[Lanes],
        moments: &[Lanes],
    );

    /// Points to grid: adds `N² value`.
    fn deposit_squares(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        to: Window<'_, f64>,
        values: &[f64],
    );

    /// Grid to points: velocity, acceleration and velocity gradient.
    fn gather(&self, ground: &Ground<'_, D>, points: &Points<'_, D>, nodes: &[Node], out: &mut [Gathered<D>]);

    /// The velocities and accelerations of [`Sweeps::gather`]; what `out` has of gradients stays.
    fn gather_motion(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[Node],
        out: &mut [Gathered<D>],
    );

    /// Grid to points: velocity and velocity gradient.
    fn gather_velocity(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[Lanes],
        out: &mut [Gathered<D>],
    );

    /// Grid to points: moments (APIC) or gradients (TPIC) of the velocities.
    fn gather_affine(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[Node],
        moments: bool,
        out: &mut [Square<D>],
    );

    /// [`Sweeps::gather`] and [`Sweeps::gather_affine`] in one sweep, with the same results.
    fn gather_both(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[Node],
        moments: bool,
        out: (&mut [Gathered<D>], &mut [Square<D>]),
    );

    /// Grid to points: `Σ N value`.
    fn interpolate(&self, ground: &Ground<'_, D>, points: &Points<'_, D>, nodes: &[Lanes], out: &mut [Lanes]);

    /// Grid to points: `Σ N (v - a dt)`, the velocity at the start of a step of `dt` (s).
    fn interpolate_start(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[Node],
        dt: f64,
        out: &mut [Lanes],
    );

    /// `Σ N (x_i - x_p)²` (m²) along each axis.
    fn second_moments(&self, ground: &Ground<'_, D>, points: &Points<'_, D>, out: &mut [[f64; D]]);

    /// Calls `visit(point, node, N)` for every node of every point, for what a few points do by themselves.
    fn weights(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        visit: &mut dyn FnMut(usize, usize, f64),
    );

    /// As [`Sweeps::deposit`], for two phases at once.
    fn deposit_phases(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        to: Window<'_, [Node; 2]>,
        given: &PhaseDeposit<'_, D>,
    );

    /// Points to grid: adds `N value`, for two phases at once.
    fn deposit_motions(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        to: Window<'_, [Lanes; 2]>,
        values: &[[Lanes; 2]],
    );

    /// As [`Sweeps::gather`], for two phases at once.
    fn gather_phases(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[[Node; 2]],
        out: &mut [[Gathered<D>; 2]],
    );

    /// As [`Sweeps::gather_motion`], for two phases at once.
    fn gather_motions(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[[Node; 2]],
        out: &mut [[Gathered<D>; 2]],
    );

    /// As [`Sweeps::gather_velocity`], for two phases at once.
    fn gather_velocities(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[[Lanes; 2]],
        out: &mut [[Gathered<D>; 2]],
    );
}
