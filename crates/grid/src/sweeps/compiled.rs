//! The sweeps of each kind of shape functions and point domains.

use std::fmt;
use std::marker::PhantomData;

use super::{Affine, Deposit, PhaseDeposit, Points, Sweeps, Window};
use crate::domain::{Domains, Ground, PointDomain, Square};
use crate::{Axis, Basis, Gathered, Lanes, Node, Support};

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
    let mut columns = [Lanes::ZERO; D];
    let mut scales = [affine.mass[p]; D];
    if affine.moments {
        for j in 0..D {
            scales[j] /= squares[j];
        }
    }
    for j in 0..D {
        let scale = scales[j];
        let mut column = [0.0; 4];
        for i in 0..D {
            column[i] = scale * affine.fields[p][i][j];
        }
        columns[j] = Lanes::new(column);
    }
    (moments, columns)
}

/// The nodes of point `p` with what the affine transfers weigh velocities with.
#[inline(always)]
fn weighed<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>>(
    ground: &Ground<'_, D>,
    points: &Points<'_, D>,
    moments: bool,
    p: usize,
    support: &P::Support<S>,
) -> P::Support<S> {
    if !moments {
        return support.of_moments();
    }
    let anchor = P::of(&points.domain)[p].anchor(&points.position[p]);
    support.moments::<S, B>(ground.grid, &anchor).0
}

#[inline(always)]
fn put_columns<const D: usize>(square: &mut Square<D>, columns: &[Lanes; D]) {
    for j in 0..D {
        let column = columns[j].to_array();
        for i in 0..D {
            square[i][j] = column[i];
        }
    }
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
            let (motion, columns, body) = (given.motion[p], &given.columns[p], given.body.get(p).copied());
            let Some(affine) = &given.affine else {
                support.deposit(nodes, first, strides, motion, columns, body);
                return;
            };
            let (moments, fields) = affine_momentum::<D, S, B, P>(ground, points, affine, p, support);
            support.deposit_affine(nodes, first, strides, (motion, columns, body), (&moments, &fields));
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

    fn deposit_gradients(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        to: Window<'_, Lanes>,
        values: &[Lanes],
        moments: &[Lanes],
    ) {
        let (Window { nodes, first }, strides) = (to, &ground.strides);
        each::<D, S, B, P>(ground, points, |p, support| {
            support.deposit_gradients(nodes, first, strides, values[p], moments[p]);
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

    fn gather_motion(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[Node],
        out: &mut [Gathered<D>],
    ) {
        each::<D, S, B, P>(ground, points, |p, support| {
            [out[p].velocity, out[p].acceleration] = support.gather_motion(nodes, &ground.strides);
        });
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
        each::<D, S, B, P>(ground, points, |p, support| {
            let weighed = weighed::<D, S, B, P>(ground, points, moments, p, support);
            put_columns(&mut out[p], &weighed.gather(nodes, &ground.strides).gradient);
        });
    }

    fn gather_both(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[Node],
        moments: bool,
        (out, fields): (&mut [Gathered<D>], &mut [Square<D>]),
    ) {
        each::<D, S, B, P>(ground, points, |p, support| {
            let weighed = weighed::<D, S, B, P>(ground, points, moments, p, support);
            let (read, columns) = support.gather_both(&weighed, nodes, &ground.strides);
            out[p] = read;
            put_columns(&mut fields[p], &columns);
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

    fn gather_motions(
        &self,
        ground: &Ground<'_, D>,
        points: &Points<'_, D>,
        nodes: &[[Node; 2]],
        out: &mut [[Gathered<D>; 2]],
    ) {
        each::<D, S, B, P>(ground, points, |p, support| {
            let read = support.gather_motions(nodes, &ground.strides);
            for (out, read) in out[p].iter_mut().zip(read) {
                [out.velocity, out.acceleration] = read;
            }
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
