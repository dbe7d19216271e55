//! Support nodes of a point, as both transfers use them for any shape functions.

use crate::nodes::nodal_state::vector4;
use crate::{Basis, Grid, InterpolatedMotion, NodalState, Vector4};

/// Nodes of a point with weights and gradients, and the transfers with them.
///
/// [`crate::Stencil`] is the product of one basis per axis with its own, faster transfers; a [`NodeList`] lists every node.
pub trait NodeSupport<const D: usize>: Copy + Send + Sync {
    /// Calls `visit(node number, weight, gradient)` for every node.
    fn for_each(&self, strides: &[usize; D], visit: impl FnMut(usize, f64, &[f64; D]));

    /// Nodes with `N (x_i - x_p)` (m) in place of the gradients, and `Σ N (x_i - x_p)²` along each axis (m²), for affine transfers (sheet:
    /// mpm §2.6). The mixed second moments are zero, because every family reproduces linear fields.
    fn affine_moments<const S: usize, B: Basis<S>>(
        &self,
        grid: &Grid<D>,
        position: &[f64; D],
    ) -> (Self, [f64; D]);

    /// Returns the nodes with the gradients in the configuration of the moments.
    #[inline(always)]
    fn with_matching_gradients(&self) -> Self {
        *self
    }

    /// Point to grid: adds `N motion` and `Σ_j ∂N/∂x_j columns[j] + N body` to the nodes, the first of which has the
    /// number `offset`. With `columns[j] = -V σ e_j` this is the internal force.
    #[inline(always)]
    fn p2g(
        &self,
        nodes: &mut [NodalState],
        offset: usize,
        strides: &[usize; D],
        motion: Vector4,
        columns: &[Vector4; D],
        body: Option<Vector4>,
    ) {
        self.for_each(strides, |number, w, g| {
            let node = &mut nodes[number - offset];
            let mut force = body.map_or(Vector4::ZERO, |body| body * w);
            for (column, slope) in columns.iter().zip(g) {
                force += *column * *slope;
            }
            node.momentum_and_mass += motion * w;
            node.force += force;
        });
    }

    /// Point to grid: [`NodeSupport::p2g`] of `(motion, columns, body)` with the momentum of an affine velocity field, given as nodes with
    /// moments and columns.
    #[inline(always)]
    fn p2g_affine(
        &self,
        nodes: &mut [NodalState],
        offset: usize,
        strides: &[usize; D],
        (motion, columns, body): (Vector4, &[Vector4; D], Option<Vector4>),
        (moments, affine): (&Self, &[Vector4; D]),
    ) {
        self.p2g(nodes, offset, strides, motion, columns, body);
        moments.p2g_with_gradients(nodes, offset, strides, Vector4::ZERO, affine, |node| {
            &mut node.momentum_and_mass
        });
    }

    /// Point to grid: adds `N value` to the vector that `at` selects from a node.
    #[inline(always)]
    fn p2g_value<T>(
        &self,
        nodes: &mut [T],
        offset: usize,
        strides: &[usize; D],
        value: Vector4,
        at: impl Fn(&mut T) -> &mut Vector4,
    ) {
        self.for_each(strides, |number, w, _| *at(&mut nodes[number - offset]) += value * w);
    }

    /// Point to grid: adds `N value + Σ_j ∂N/∂x_j columns[j]` to the vector that `at` selects from a node.
    #[inline(always)]
    fn p2g_with_gradients<T>(
        &self,
        nodes: &mut [T],
        offset: usize,
        strides: &[usize; D],
        value: Vector4,
        columns: &[Vector4; D],
        at: impl Fn(&mut T) -> &mut Vector4,
    ) {
        self.for_each(strides, |number, w, g| {
            let mut sum = value * w;
            for (column, slope) in columns.iter().zip(g) {
                sum += *column * *slope;
            }
            *at(&mut nodes[number - offset]) += sum;
        });
    }

    /// Point to grid: adds `N value`, and to lane `j` the product of `∂N/∂x_j` and lane `j` of `moments`.
    #[inline(always)]
    fn p2g_moments(
        &self,
        nodes: &mut [Vector4],
        offset: usize,
        strides: &[usize; D],
        value: Vector4,
        moments: Vector4,
    ) {
        self.for_each(strides, |number, w, g| {
            nodes[number - offset] += value * w + moments * vector4::<D>(|axis| g[axis]);
        });
    }

    /// Grid to point: `Σ N value` of the nodal values `of`.
    #[inline(always)]
    fn g2p_value<T>(&self, nodes: &[T], strides: &[usize; D], of: impl Fn(&T) -> Vector4) -> Vector4 {
        let mut sum = Vector4::ZERO;
        self.for_each(strides, |number, w, _| sum += of(&nodes[number]) * w);
        sum
    }

    /// Grid to point: velocity, acceleration and velocity gradient.
    #[inline(always)]
    fn g2p(&self, nodes: &[NodalState], strides: &[usize; D]) -> InterpolatedMotion<D> {
        let mut out = InterpolatedMotion::ZERO;
        self.for_each(strides, |number, w, g| {
            out.acceleration += nodes[number].force * w;
            out.add(nodes[number].momentum_and_mass, w, g);
        });
        out
    }

    /// Grid to point: velocity and acceleration as in [`NodeSupport::g2p`], without the gradient.
    #[inline(always)]
    fn g2p_motion(&self, nodes: &[NodalState], strides: &[usize; D]) -> [Vector4; 2] {
        let mut out = [Vector4::ZERO; 2];
        self.for_each(strides, |number, w, _| {
            out[1] += nodes[number].force * w;
            out[0] += nodes[number].momentum_and_mass * w;
        });
        out
    }

    /// Grid to point: [`NodeSupport::g2p`], with the sum of velocities times the gradients of `other` on the same nodes.
    #[inline(always)]
    fn g2p_with_affine(
        &self,
        other: &Self,
        nodes: &[NodalState],
        strides: &[usize; D],
    ) -> (InterpolatedMotion<D>, [Vector4; D]) {
        (self.g2p(nodes, strides), other.g2p(nodes, strides).gradient)
    }

    /// Grid to point: velocity and velocity gradient of the re-mapped velocities.
    #[inline(always)]
    fn g2p_velocity(&self, nodes: &[Vector4], strides: &[usize; D]) -> InterpolatedMotion<D> {
        let mut out = InterpolatedMotion::ZERO;
        self.for_each(strides, |number, w, g| out.add(nodes[number], w, g));
        out
    }

    /// Point to grid: [`NodeSupport::p2g`] for `N` phases together. The fourth lane of `body` is free for a scalar, which is summed in the
    /// nodal force.
    #[inline(always)]
    fn p2g_phases<const N: usize>(
        &self,
        nodes: &mut [[NodalState; N]],
        offset: usize,
        strides: &[usize; D],
        motion: &[Vector4; N],
        columns: &[[Vector4; D]; N],
        body: &[Vector4; N],
    ) {
        self.for_each(strides, |number, w, g| {
            let node = &mut nodes[number - offset];
            for phase in 0..N {
                let mut force = body[phase] * w;
                for (column, slope) in columns[phase].iter().zip(g) {
                    force += *column * *slope;
                }
                node[phase].momentum_and_mass += motion[phase] * w;
                node[phase].force += force;
            }
        });
    }

    /// Point to grid: [`NodeSupport::p2g_value`] for `N` phases together.
    #[inline(always)]
    fn p2g_phase_values<const N: usize>(
        &self,
        nodes: &mut [[Vector4; N]],
        offset: usize,
        strides: &[usize; D],
        motion: &[Vector4; N],
    ) {
        self.for_each(strides, |number, w, _| {
            for (node, motion) in nodes[number - offset].iter_mut().zip(motion) {
                *node += *motion * w;
            }
        });
    }

    /// Grid to point: [`NodeSupport::g2p`] for `N` phases together.
    #[inline(always)]
    fn g2p_phases<const N: usize>(
        &self,
        nodes: &[[NodalState; N]],
        strides: &[usize; D],
    ) -> [InterpolatedMotion<D>; N] {
        let mut out = [InterpolatedMotion::ZERO; N];
        self.for_each(strides, |number, w, g| {
            for (out, node) in out.iter_mut().zip(&nodes[number]) {
                out.acceleration += node.force * w;
                out.add(node.momentum_and_mass, w, g);
            }
        });
        out
    }

    /// Grid to point: [`NodeSupport::g2p_motion`] for `N` phases together.
    #[inline(always)]
    fn g2p_phase_motions<const N: usize>(
        &self,
        nodes: &[[NodalState; N]],
        strides: &[usize; D],
    ) -> [[Vector4; 2]; N] {
        let mut out = [[Vector4::ZERO; 2]; N];
        self.for_each(strides, |number, w, _| {
            for (out, node) in out.iter_mut().zip(&nodes[number]) {
                out[1] += node.force * w;
                out[0] += node.momentum_and_mass * w;
            }
        });
        out
    }

    /// Grid to point: [`NodeSupport::g2p_velocity`] for `N` phases together.
    #[inline(always)]
    fn g2p_phase_velocities<const N: usize>(
        &self,
        nodes: &[[Vector4; N]],
        strides: &[usize; D],
    ) -> [InterpolatedMotion<D>; N] {
        let mut out = [InterpolatedMotion::ZERO; N];
        self.for_each(strides, |number, w, g| {
            for (out, node) in out.iter_mut().zip(&nodes[number]) {
                out.add(*node, w, g);
            }
        });
        out
    }
}

impl<const D: usize> InterpolatedMotion<D> {
    /// Interpolated motion before contributions are added.
    pub const ZERO: Self =
        Self { velocity: Vector4::ZERO, acceleration: Vector4::ZERO, gradient: [Vector4::ZERO; D] };

    /// Adds the velocity of a node with its weight and the slopes of its shape function.
    #[inline(always)]
    fn add(&mut self, velocity: Vector4, weight: f64, slopes: &[f64; D]) {
        self.velocity += velocity * weight;
        for (column, slope) in self.gradient.iter_mut().zip(slopes) {
            *column += velocity * *slope;
        }
    }
}

/// List of up to `N` node numbers with weights and gradients; a node may occur more than once.
#[derive(Clone, Copy, Debug)]
pub struct NodeList<const D: usize, const N: usize> {
    /// Node numbers.
    pub nodes: [u32; N],
    /// Positions of the nodes (m).
    pub positions: [[f64; D]; N],
    /// Weights.
    pub weights: [f64; N],
    /// Gradients (1/m).
    pub gradients: [[f64; D]; N],
}

impl<const D: usize, const N: usize> NodeList<D, N> {
    /// List without nodes.
    pub const EMPTY: Self =
        Self { nodes: [0; N], positions: [[0.0; D]; N], weights: [0.0; N], gradients: [[0.0; D]; N] };
}

impl<const D: usize, const N: usize> NodeSupport<D> for NodeList<D, N> {
    #[inline(always)]
    fn for_each(&self, _strides: &[usize; D], mut visit: impl FnMut(usize, f64, &[f64; D])) {
        for k in 0..N {
            visit(self.nodes[k] as usize, self.weights[k], &self.gradients[k]);
        }
    }

    fn affine_moments<const S: usize, B: Basis<S>>(
        &self,
        _grid: &Grid<D>,
        position: &[f64; D],
    ) -> (Self, [f64; D]) {
        let mut moments = *self;
        let mut squares = [0.0; D];
        for k in 0..N {
            for axis in 0..D {
                let arm = self.positions[k][axis] - position[axis];
                moments.gradients[k][axis] = self.weights[k] * arm;
                squares[axis] += self.weights[k] * arm * arm;
            }
        }
        (moments, squares)
    }
}
