//! Transfers of each kind of shape functions and point domains.

use std::fmt;
use std::marker::PhantomData;

use crate::point_domain::{Domains, GridView, PointDomain, SquareMatrix};
use crate::transfers::{AffineFields, NodeRange, P2gInput, P2gPhaseInput, PointSlice, Transfers};
use crate::{Basis, Basis1d, InterpolatedMotion, NodalState, NodeSupport, Vector4};

/// Transfers of the basis `B` (`S` nodes a point along an axis, or in total) over the domains `P`.
pub(crate) struct CompiledTransfers<const S: usize, B, P>(pub(crate) PhantomData<fn() -> (B, P)>);

impl<const S: usize, B: Basis<S>, P> fmt::Debug for CompiledTransfers<S, B, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(B::NAME)
    }
}

/// Calls `visit(point, its nodes)` for every point.
#[inline(always)]
fn for_each_point<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>>(
    ground: &GridView<'_, D>,
    points: &PointSlice<'_, D>,
    visit: impl FnMut(usize, &P::Support<S>),
) {
    let domains = P::typed_column(&points.domain);
    P::for_each_support::<S, B>(domains, ground, points.position, points.extent, visit);
}

/// Calls `visit(point, its nodes, their affine moments)` for every point.
#[inline(always)]
fn for_each_affine_point<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>>(
    ground: &GridView<'_, D>,
    points: &PointSlice<'_, D>,
    visit: impl FnMut(usize, &P::Support<S>, &(P::Support<S>, [f64; D])),
) {
    let domains = P::typed_column(&points.domain);
    P::for_each_affine_support::<S, B>(domains, ground, points.position, points.extent, visit);
}

/// Nodes of the first point.
#[inline(always)]
fn first_support<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>>(
    ground: &GridView<'_, D>,
    points: &PointSlice<'_, D>,
) -> P::Support<S> {
    P::typed_column(&points.domain)[0].support::<S, B>(ground, &points.position[0], points.extent)
}

/// Columns `m C e_j` of the affine momentum of point `p` with the affine velocity gradient `C` (1/s; sheet: mpm §2.6), from the second
/// moments of its nodes.
#[inline(always)]
fn affine_columns<const D: usize>(
    affine: &AffineFields<'_, D>,
    p: usize,
    squares: &[f64; D],
) -> [Vector4; D] {
    let mut columns = [Vector4::ZERO; D];
    for j in 0..D {
        let scale = if affine.moments { affine.mass[p] / squares[j] } else { affine.mass[p] };
        let mut column = [0.0; 4];
        for i in 0..D {
            column[i] = scale * affine.fields[p][i][j];
        }
        columns[j] = Vector4::new(column);
    }
    columns
}

/// Adds momenta without forces, or forces without momenta, to the nodes.
#[inline(always)]
fn p2g_of_one_kind<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>>(
    ground: &GridView<'_, D>,
    points: &PointSlice<'_, D>,
    to: NodeRange<'_, NodalState>,
    given: &P2gInput<'_, D>,
) {
    let (NodeRange { nodes, first }, strides) = (to, &ground.strides);
    if given.momentum_and_mass.is_empty() {
        return for_each_point::<D, S, B, P>(ground, points, |p, support| {
            let (columns, body) =
                (&given.stress_columns[p], given.body_force.get(p).copied().unwrap_or(Vector4::ZERO));
            support.p2g_with_gradients(nodes, first, strides, body, columns, |node| &mut node.force);
        });
    }
    let momenta = given.momentum_and_mass;
    let Some(affine) = &given.affine_fields else {
        return for_each_point::<D, S, B, P>(ground, points, |p, support| {
            support.p2g_value(nodes, first, strides, momenta[p], |node| &mut node.momentum_and_mass);
        });
    };
    for_each_affine_point::<D, S, B, P>(ground, points, |p, support, (moments, squares)| {
        support.p2g_value(nodes, first, strides, momenta[p], |node| &mut node.momentum_and_mass);
        let columns = affine_columns(affine, p, squares);
        moments.p2g_with_gradients(nodes, first, strides, Vector4::ZERO, &columns, |node| {
            &mut node.momentum_and_mass
        });
    });
}

/// Copies column vectors to a square matrix.
#[inline(always)]
fn set_columns<const D: usize>(square: &mut SquareMatrix<D>, columns: &[Vector4; D]) {
    for j in 0..D {
        let column = columns[j].to_array();
        for i in 0..D {
            square[i][j] = column[i];
        }
    }
}

impl<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>> Transfers<D>
    for CompiledTransfers<S, B, P>
{
    fn basis_1d(&self) -> Basis1d {
        Basis1d::from_basis::<S, B>()
    }

    fn domains(&self, count: usize) -> Domains<D> {
        P::new_column(count)
    }

    fn p2g(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        to: NodeRange<'_, NodalState>,
        given: &P2gInput<'_, D>,
    ) {
        if given.stress_columns.is_empty() || given.momentum_and_mass.is_empty() {
            return p2g_of_one_kind::<D, S, B, P>(ground, points, to, given);
        }
        let (NodeRange { nodes, first }, strides) = (to, &ground.strides);
        let of_point = |p: usize| {
            (given.momentum_and_mass[p], &given.stress_columns[p], given.body_force.get(p).copied())
        };
        let Some(affine) = &given.affine_fields else {
            return for_each_point::<D, S, B, P>(ground, points, |p, support| {
                let (motion, columns, body) = of_point(p);
                support.p2g(nodes, first, strides, motion, columns, body);
            });
        };
        for_each_affine_point::<D, S, B, P>(ground, points, |p, support, (moments, squares)| {
            let fields = affine_columns(affine, p, squares);
            support.p2g_affine(nodes, first, strides, of_point(p), (moments, &fields));
        });
    }

    fn p2g_values(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        to: NodeRange<'_, Vector4>,
        values: &[Vector4],
        affine: Option<AffineFields<'_, D>>,
    ) {
        let (NodeRange { nodes, first }, strides) = (to, &ground.strides);
        let Some(affine) = &affine else {
            return for_each_point::<D, S, B, P>(ground, points, |p, support| {
                support.p2g_value(nodes, first, strides, values[p], |node| node);
            });
        };
        for_each_affine_point::<D, S, B, P>(ground, points, |p, support, (moments, squares)| {
            support.p2g_value(nodes, first, strides, values[p], |node| node);
            let columns = affine_columns(affine, p, squares);
            moments.p2g_with_gradients(nodes, first, strides, Vector4::ZERO, &columns, |node| node);
        });
    }

    fn p2g_moments(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        to: NodeRange<'_, Vector4>,
        values: &[Vector4],
        moments: &[Vector4],
    ) {
        let (NodeRange { nodes, first }, strides) = (to, &ground.strides);
        for_each_point::<D, S, B, P>(ground, points, |p, support| {
            support.p2g_moments(nodes, first, strides, values[p], moments[p]);
        });
    }

    fn p2g_squared_weights(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        to: NodeRange<'_, f64>,
        values: &[f64],
    ) {
        let (NodeRange { nodes, first }, strides) = (to, &ground.strides);
        for_each_point::<D, S, B, P>(ground, points, |p, support| {
            support.for_each(strides, |number, w, _| nodes[number - first] += values[p] * w * w);
        });
    }

    fn g2p(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[NodalState],
        out: &mut [InterpolatedMotion<D>],
    ) {
        for_each_point::<D, S, B, P>(ground, points, |p, support| {
            out[p] = support.g2p(nodes, &ground.strides);
        });
    }

    fn g2p_motion(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[NodalState],
        out: &mut [InterpolatedMotion<D>],
    ) {
        for_each_point::<D, S, B, P>(ground, points, |p, support| {
            [out[p].velocity, out[p].acceleration] = support.g2p_motion(nodes, &ground.strides);
        });
    }

    fn g2p_velocity(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[Vector4],
        out: &mut [InterpolatedMotion<D>],
    ) {
        for_each_point::<D, S, B, P>(ground, points, |p, support| {
            out[p] = support.g2p_velocity(nodes, &ground.strides);
        });
    }

    fn g2p_affine(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[NodalState],
        moments: bool,
        out: &mut [SquareMatrix<D>],
    ) {
        let mut gather = |p: usize, support: &P::Support<S>| {
            set_columns(&mut out[p], &support.g2p(nodes, &ground.strides).gradient);
        };
        if moments {
            for_each_affine_point::<D, S, B, P>(ground, points, |p, _, (moments, _)| gather(p, moments));
        } else {
            for_each_point::<D, S, B, P>(ground, points, |p, support| {
                gather(p, &support.with_matching_gradients());
            });
        }
    }

    fn g2p_with_affine(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[NodalState],
        moments: bool,
        (out, fields): (&mut [InterpolatedMotion<D>], &mut [SquareMatrix<D>]),
    ) {
        if moments {
            return for_each_affine_point::<D, S, B, P>(ground, points, |p, support, (weighed, _)| {
                let (read, columns) = support.g2p_with_affine(weighed, nodes, &ground.strides);
                out[p] = read;
                set_columns(&mut fields[p], &columns);
            });
        }
        for_each_point::<D, S, B, P>(ground, points, |p, support| {
            let weighed = support.with_matching_gradients();
            let (read, columns) = support.g2p_with_affine(&weighed, nodes, &ground.strides);
            out[p] = read;
            set_columns(&mut fields[p], &columns);
        });
    }

    fn g2p_values(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[Vector4],
        out: &mut [Vector4],
    ) {
        for_each_point::<D, S, B, P>(ground, points, |p, support| {
            out[p] = support.g2p_value(nodes, &ground.strides, |node| *node);
        });
    }

    fn g2p_start_velocity(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[NodalState],
        dt: f64,
        out: &mut [Vector4],
    ) {
        for_each_point::<D, S, B, P>(ground, points, |p, support| {
            out[p] =
                support.g2p_value(nodes, &ground.strides, |node| node.momentum_and_mass - node.force * dt);
        });
    }

    fn second_moments(&self, ground: &GridView<'_, D>, points: &PointSlice<'_, D>, out: &mut [[f64; D]]) {
        for_each_affine_point::<D, S, B, P>(ground, points, |p, _, (_, squares)| out[p] = *squares);
    }

    fn for_each_weight(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        visit: &mut dyn FnMut(usize, usize, f64),
    ) {
        let domains = P::typed_column(&points.domain);
        for (p, (position, domain)) in points.position.iter().zip(domains).enumerate() {
            let support = domain.support::<S, B>(ground, position, points.extent);
            support.for_each(&ground.strides, |number, w, _| visit(p, number, w));
        }
    }

    fn momentum_at(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[NodalState],
    ) -> Vector4 {
        first_support::<D, S, B, P>(ground, points)
            .g2p_value(nodes, &ground.strides, |node| node.momentum_and_mass)
    }

    fn value_at(&self, ground: &GridView<'_, D>, points: &PointSlice<'_, D>, nodes: &[Vector4]) -> Vector4 {
        first_support::<D, S, B, P>(ground, points).g2p_value(nodes, &ground.strides, |node| *node)
    }

    fn p2g_phases(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        to: NodeRange<'_, [NodalState; 2]>,
        given: &P2gPhaseInput<'_, D>,
    ) {
        let (NodeRange { nodes, first }, strides) = (to, &ground.strides);
        for_each_point::<D, S, B, P>(ground, points, |p, support| {
            support.p2g_phases(
                nodes,
                first,
                strides,
                &given.momentum_and_mass[p],
                &given.stress_columns[p],
                &given.body_force[p],
            );
        });
    }

    fn p2g_phase_values(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        to: NodeRange<'_, [Vector4; 2]>,
        values: &[[Vector4; 2]],
    ) {
        let (NodeRange { nodes, first }, strides) = (to, &ground.strides);
        for_each_point::<D, S, B, P>(ground, points, |p, support| {
            support.p2g_phase_values(nodes, first, strides, &values[p]);
        });
    }

    fn g2p_phases(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[[NodalState; 2]],
        out: &mut [[InterpolatedMotion<D>; 2]],
    ) {
        for_each_point::<D, S, B, P>(ground, points, |p, support| {
            out[p] = support.g2p_phases(nodes, &ground.strides);
        });
    }

    fn g2p_phase_motions(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[[NodalState; 2]],
        out: &mut [[InterpolatedMotion<D>; 2]],
    ) {
        for_each_point::<D, S, B, P>(ground, points, |p, support| {
            let read = support.g2p_phase_motions(nodes, &ground.strides);
            for (out, read) in out[p].iter_mut().zip(read) {
                [out.velocity, out.acceleration] = read;
            }
        });
    }

    fn g2p_phase_velocities(
        &self,
        ground: &GridView<'_, D>,
        points: &PointSlice<'_, D>,
        nodes: &[[Vector4; 2]],
        out: &mut [[InterpolatedMotion<D>; 2]],
    ) {
        for_each_point::<D, S, B, P>(ground, points, |p, support| {
            out[p] = support.g2p_phase_velocities(nodes, &ground.strides);
        });
    }
}
