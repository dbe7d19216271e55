//! Sweeps over points and their nodes: the only code that is compiled for each kind of shape functions and point domains.
//!
//! A solver chooses its [`Sweeps`] once ([`crate::Shape`]) and calls them for the points of a body in a slab ([`crate::Layout::scatter`]) or
//! in a block, never for a single one ([`Sweeps::weights`] excepted). A sweep knows places and nodes; what is carried between them comes in and goes out in
//! slices, one entry a point.
//!
//! A step of any material point method is `deposit`, a solve on the nodes, and `gather`. The affine transfers (APIC, TPIC) add
//! [`Affine`] to what is deposited and gather with [`Sweeps::gather_affine`]; fields of nodes of any meaning go through
//! [`Sweeps::deposit_values`] and [`Sweeps::interpolate`].

use std::fmt;
use std::marker::PhantomData;
use std::ops::Range;

use crate::domain::{DomainSlice, Domains, Ground, PointDomain, Square};
use crate::{Axis, Basis, Gathered, Lanes, Node, Support};

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

    /// Points to grid: adds `N value + Σ_j ∂N/∂x_j columns[j]`.
    fn deposit_slopes(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        to: Window<'_, Lanes>,
        values: &[Lanes],
        columns: &[[Lanes; D]],
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

    /// As [`Sweeps::gather_velocity`], for two phases at once.
    fn gather_velocities(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[[Lanes; 2]],
        out: &mut [[Gathered<D>; 2]],
    );
}

/// The sweeps of the basis `B` (`S` nodes a point along an axis, or in all) over the domains `P`.
pub(crate) struct Of<const S: usize, B, P>(pub(crate) PhantomData<fn() -> (B, P)>);

impl<const S: usize, B: Basis<S>, P> fmt::Debug for Of<S, B, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(B::NAME)
    }
}

/// Calls `visit(point, its nodes)` for every point.
#[inline(always)]
fn each<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>>(
    ground: &Ground<'_, D>,
    points: &Points<'_, D>,
    mut visit: impl FnMut(usize, &P::Support<S>),
) {
    let domains = P::of(&points.domain);
    for (p, (position, domain)) in points.position.iter().zip(domains).enumerate() {
        visit(p, &domain.support::<S, B>(ground, position, points.extent));
    }
}

/// What point `p` adds to the momentum of its nodes beyond `N m v`: the nodes with their moments and the columns `m C e_j`,
/// with the affine velocity `C` (1/s) (sheet: mpm §2.6).
#[inline(always)]
fn affine_momentum<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>>(
    ground: &Ground<'_, D>,
    points: &Points<'_, D>,
    affine: &Affine<'_, D>,
    p: usize,
    support: &P::Support<S>,
) -> (P::Support<S>, [Lanes; D]) {
    let anchor = P::of(&points.domain)[p].anchor(&points.position[p]);
    let (moments, squares) = support.moments::<S, B>(ground.grid, &anchor);
    let columns = std::array::from_fn(|j| {
        let scale = affine.mass[p] * if affine.moments { 1.0 / squares[j] } else { 1.0 };
        let at = |i: usize| if i < D { scale * affine.fields[p][i][j] } else { 0.0 };
        Lanes::new([at(0), at(1), at(2), 0.0])
    });
    (moments, columns)
}

impl<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>> Sweeps<D> for Of<S, B, P> {
    fn axis(&self) -> Axis {
        Axis::of::<S, B>()
    }

    fn domains(&self, count: usize) -> Domains<D> {
        P::column(count)
    }

    fn deposit(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        to: Window<'_, Node>,
        given: &Deposit<'_, D>,
    ) {
        let (Window { nodes, first }, strides) = (to, &ground.strides);
        each::<D, S, B, P>(ground, points, |p, support| {
            let body = given.body.get(p).copied();
            support.deposit(nodes, first, strides, given.motion[p], &given.columns[p], body);
            if let Some(affine) = &given.affine {
                let (moments, columns) = affine_momentum::<D, S, B, P>(ground, points, affine, p, support);
                moments.deposit_slopes(nodes, first, strides, Lanes::ZERO, &columns, |node| &mut node.motion);
            }
        });
    }

    fn deposit_values(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        to: Window<'_, Lanes>,
        values: &[Lanes],
        affine: Option<Affine<'_, D>>,
    ) {
        let (Window { nodes, first }, strides) = (to, &ground.strides);
        each::<D, S, B, P>(ground, points, |p, support| {
            support.deposit_motion(nodes, first, strides, values[p]);
            if let Some(affine) = &affine {
                let (moments, columns) = affine_momentum::<D, S, B, P>(ground, points, affine, p, support);
                moments.deposit_slopes(nodes, first, strides, Lanes::ZERO, &columns, |node| node);
            }
        });
    }

    fn deposit_slopes(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        to: Window<'_, Lanes>,
        values: &[Lanes],
        columns: &[[Lanes; D]],
    ) {
        let (Window { nodes, first }, strides) = (to, &ground.strides);
        each::<D, S, B, P>(ground, points, |p, support| {
            support.deposit_slopes(nodes, first, strides, values[p], &columns[p], |node| node);
        });
    }

    fn deposit_squares(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        to: Window<'_, f64>,
        values: &[f64],
    ) {
        let (Window { nodes, first }, strides) = (to, &ground.strides);
        each::<D, S, B, P>(ground, points, |p, support| {
            support.for_each(strides, |number, w, _| nodes[number - first] += values[p] * w * w);
        });
    }

    fn gather(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[Node],
        out: &mut [Gathered<D>],
    ) {
        each::<D, S, B, P>(ground, points, |p, support| out[p] = support.gather(nodes, &ground.strides));
    }

    fn gather_velocity(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[Lanes],
        out: &mut [Gathered<D>],
    ) {
        each::<D, S, B, P>(ground, points, |p, support| {
            out[p] = support.gather_velocity(nodes, &ground.strides);
        });
    }

    fn gather_affine(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[Node],
        moments: bool,
        out: &mut [Square<D>],
    ) {
        let domains = P::of(&points.domain);
        each::<D, S, B, P>(ground, points, |p, support| {
            let weighed = if moments {
                support.moments::<S, B>(ground.grid, &domains[p].anchor(&points.position[p])).0
            } else {
                support.of_moments()
            };
            let slopes = weighed.gather(nodes, &ground.strides);
            for (j, column) in slopes.gradient.iter().enumerate() {
                let column = column.to_array();
                (0..D).for_each(|i| out[p][i][j] = column[i]);
            }
        });
    }

    fn interpolate(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[Lanes],
        out: &mut [Lanes],
    ) {
        each::<D, S, B, P>(ground, points, |p, support| {
            out[p] = support.interpolate(nodes, &ground.strides, |node| *node);
        });
    }

    fn interpolate_start(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[Node],
        dt: f64,
        out: &mut [Lanes],
    ) {
        each::<D, S, B, P>(ground, points, |p, support| {
            out[p] = support.interpolate(nodes, &ground.strides, |node| node.motion - node.force * dt);
        });
    }

    fn second_moments(&self, ground: &Ground<'_, D>, points: &Points<'_, D>, out: &mut [[f64; D]]) {
        let domains = P::of(&points.domain);
        each::<D, S, B, P>(ground, points, |p, support| {
            out[p] = support.moments::<S, B>(ground.grid, &domains[p].anchor(&points.position[p])).1;
        });
    }

    fn weights(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        visit: &mut dyn FnMut(usize, usize, f64),
    ) {
        each::<D, S, B, P>(ground, points, |p, support| {
            support.for_each(&ground.strides, |number, w, _| visit(p, number, w));
        });
    }

    fn deposit_phases(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        to: Window<'_, [Node; 2]>,
        given: &PhaseDeposit<'_, D>,
    ) {
        let (Window { nodes, first }, strides) = (to, &ground.strides);
        each::<D, S, B, P>(ground, points, |p, support| {
            support.deposit_phases(
                nodes,
                first,
                strides,
                &given.motion[p],
                &given.columns[p],
                &given.body[p],
            );
        });
    }

    fn deposit_motions(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        to: Window<'_, [Lanes; 2]>,
        values: &[[Lanes; 2]],
    ) {
        let (Window { nodes, first }, strides) = (to, &ground.strides);
        each::<D, S, B, P>(ground, points, |p, support| {
            support.deposit_motions(nodes, first, strides, &values[p]);
        });
    }

    fn gather_phases(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[[Node; 2]],
        out: &mut [[Gathered<D>; 2]],
    ) {
        each::<D, S, B, P>(ground, points, |p, support| {
            out[p] = support.gather_phases(nodes, &ground.strides);
        });
    }

    fn gather_velocities(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[[Lanes; 2]],
        out: &mut [[Gathered<D>; 2]],
    ) {
        each::<D, S, B, P>(ground, points, |p, support| {
            out[p] = support.gather_velocities(nodes, &ground.strides);
        });
    }
}
