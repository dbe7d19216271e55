//! The nodes a point stands on: what the two transfers need of any shape functions.

use crate::node::lanes_of;
use crate::{Basis, Gathered, Grid, Lanes, Node};

/// Weights and gradients of the nodes at a point, and the transfers with them.
///
/// [`crate::Stencil`] is the product of one basis per axis and has its own, faster transfers; a [`NodeList`] names every node.
pub trait Support<const D: usize>: Copy + Send + Sync {
    /// Calls `visit(node number, weight, gradient)` for every node.
    fn for_each(&self, strides: &[usize; D], visit: impl FnMut(usize, f64, &[f64; D]));

    /// The same nodes with `N (x_i - x_p)` (m) in place of the gradients, and `Σ N (x_i - x_p)²` (m²) along each
    /// axis: what the affine transfers weigh with (sheet: mpm §2.6). The mixed second moments are zero, because every
    /// family reproduces linear fields.
    fn moments<const S: usize, B: Basis<S>>(&self, grid: &Grid<D>, position: &[f64; D]) -> (Self, [f64; D]);

    /// The same nodes with the gradients of the configuration that the moments are of.
    #[inline(always)]
    fn of_moments(&self) -> Self {
        *self
    }

    /// Point to grid: adds `N motion` and `Σ_j ∂N/∂x_j columns[j] + N body` to the nodes, the first of which has the
    /// number `offset`. With `columns[j] = -V σ e_j` this is the internal force.
    #[inline(always)]
    fn deposit(
        &self,
        nodes: &mut [Node],
        offset: usize,
        strides: &[usize; D],
        motion: Lanes,
        columns: &[Lanes; D],
        body: Option<Lanes>,
    ) {
        self.for_each(strides, |number, w, g| {
            let node = &mut nodes[number - offset];
            let mut force = body.map_or(Lanes::ZERO, |body| body * w);
            for (column, slope) in columns.iter().zip(g) {
                force += *column * *slope;
            }
            node.motion += motion * w;
            node.force += force;
        });
    }

    /// As [`Support::deposit`] of `(motion, columns, body)`, and adds to the momenta the `(nodes with their moments, columns)` of
    /// an affine velocity field.
    #[inline(always)]
    fn deposit_affine(
        &self,
        nodes: &mut [Node],
        offset: usize,
        strides: &[usize; D],
        (motion, columns, body): (Lanes, &[Lanes; D], Option<Lanes>),
        (moments, affine): (&Self, &[Lanes; D]),
    ) {
        self.deposit(nodes, offset, strides, motion, columns, body);
        moments.deposit_slopes(nodes, offset, strides, Lanes::ZERO, affine, |node| &mut node.motion);
    }

    /// Point to grid: adds `N value`.
    #[inline(always)]
    fn deposit_motion(&self, nodes: &mut [Lanes], offset: usize, strides: &[usize; D], value: Lanes) {
        self.for_each(strides, |number, w, _| nodes[number - offset] += value * w);
    }

    /// Point to grid: adds `N value + Σ_j ∂N/∂x_j columns[j]` to what `at` finds in a node.
    #[inline(always)]
    fn deposit_slopes<T>(
        &self,
        nodes: &mut [T],
        offset: usize,
        strides: &[usize; D],
        value: Lanes,
        columns: &[Lanes; D],
        at: impl Fn(&mut T) -> &mut Lanes,
    ) {
        self.for_each(strides, |number, w, g| {
            let mut sum = value * w;
            for (column, slope) in columns.iter().zip(g) {
                sum += *column * *slope;
            }
            *at(&mut nodes[number - offset]) += sum;
        });
    }

    /// Point to grid: adds `N value`, and to lane `j` the share `∂N/∂x_j` of lane `j` of `moments`.
    #[inline(always)]
    fn deposit_gradients(
        &self,
        nodes: &mut [Lanes],
        offset: usize,
        strides: &[usize; D],
        value: Lanes,
        moments: Lanes,
    ) {
        self.for_each(strides, |number, w, g| {
            nodes[number - offset] += value * w + moments * lanes_of::<D>(|axis| g[axis]);
        });
    }

    /// Grid to point: `Σ N value` of what `of` finds in a node.
    #[inline(always)]
    fn interpolate<T>(&self, nodes: &[T], strides: &[usize; D], of: impl Fn(&T) -> Lanes) -> Lanes {
        let mut sum = Lanes::ZERO;
        self.for_each(strides, |number, w, _| sum += of(&nodes[number]) * w);
        sum
    }

    /// Grid to point: velocity, acceleration and velocity gradient.
    #[inline(always)]
    fn gather(&self, nodes: &[Node], strides: &[usize; D]) -> Gathered<D> {
        let mut out = Gathered::ZERO;
        self.for_each(strides, |number, w, g| {
            out.acceleration += nodes[number].force * w;
            out.add(nodes[number].motion, w, g);
        });
        out
    }

    /// The velocity and the acceleration of [`Support::gather`], without the gradient.
    #[inline(always)]
    fn gather_motion(&self, nodes: &[Node], strides: &[usize; D]) -> [Lanes; 2] {
        let mut out = [Lanes::ZERO; 2];
        self.for_each(strides, |number, w, _| {
            out[1] += nodes[number].force * w;
            out[0] += nodes[number].motion * w;
        });
        out
    }

    /// As [`Support::gather`], and the velocities times the gradients of `other`, which has the same nodes.
    #[inline(always)]
    fn gather_both(&self, other: &Self, nodes: &[Node], strides: &[usize; D]) -> (Gathered<D>, [Lanes; D]) {
        (self.gather(nodes, strides), other.gather(nodes, strides).gradient)
    }

    /// Grid to point: velocity and velocity gradient of the re-mapped velocities.
    #[inline(always)]
    fn gather_velocity(&self, nodes: &[Lanes], strides: &[usize; D]) -> Gathered<D> {
        let mut out = Gathered::ZERO;
        self.for_each(strides, |number, w, g| out.add(nodes[number], w, g));
        out
    }

    /// As [`Support::deposit`], for `N` phases at once. The fourth lane of `body` is free for a scalar, which the force
    /// of the node sums up.
    #[inline(always)]
    fn deposit_phases<const N: usize>(
        &self,
        nodes: &mut [[Node; N]],
        offset: usize,
        strides: &[usize; D],
        motion: &[Lanes; N],
        columns: &[[Lanes; D]; N],
        body: &[Lanes; N],
    ) {
        self.for_each(strides, |number, w, g| {
            let node = &mut nodes[number - offset];
            for phase in 0..N {
                let mut force = body[phase] * w;
                for (column, slope) in columns[phase].iter().zip(g) {
                    force += *column * *slope;
                }
                node[phase].motion += motion[phase] * w;
                node[phase].force += force;
            }
        });
    }

    /// As [`Support::deposit_motion`], for `N` phases at once.
    #[inline(always)]
    fn deposit_motions<const N: usize>(
        &self,
        nodes: &mut [[Lanes; N]],
        offset: usize,
        strides: &[usize; D],
        motion: &[Lanes; N],
    ) {
        self.for_each(strides, |number, w, _| {
            for (node, motion) in nodes[number - offset].iter_mut().zip(motion) {
                *node += *motion * w;
            }
        });
    }

    /// As [`Support::gather`], for `N` phases at once.
    #[inline(always)]
    fn gather_phases<const N: usize>(&self, nodes: &[[Node; N]], strides: &[usize; D]) -> [Gathered<D>; N] {
        let mut out = [Gathered::ZERO; N];
        self.for_each(strides, |number, w, g| {
            for (out, node) in out.iter_mut().zip(&nodes[number]) {
                out.acceleration += node.force * w;
                out.add(node.motion, w, g);
            }
        });
        out
    }

    /// As [`Support::gather_motion`], for `N` phases at once.
    #[inline(always)]
    fn gather_motions<const N: usize>(&self, nodes: &[[Node; N]], strides: &[usize; D]) -> [[Lanes; 2]; N] {
        let mut out = [[Lanes::ZERO; 2]; N];
        self.for_each(strides, |number, w, _| {
            for (out, node) in out.iter_mut().zip(&nodes[number]) {
                out[1] += node.force * w;
                out[0] += node.motion * w;
            }
        });
        out
    }

    /// As [`Support::gather_velocity`], for `N` phases at once.
    #[inline(always)]
    fn gather_velocities<const N: usize>(
        &self,
        nodes: &[[Lanes; N]],
        strides: &[usize; D],
    ) -> [Gathered<D>; N] {
        let mut out = [Gathered::ZERO; N];
        self.for_each(strides, |number, w, g| {
            for (out, node) in out.iter_mut().zip(&nodes[number]) {
                out.add(*node, w, g);
            }
        });
        out
    }
}

impl<const D: usize> Gathered<D> {
    /// Nothing read yet.
    pub const ZERO: Self =
        Self { velocity: Lanes::ZERO, acceleration: Lanes::ZERO, gradient: [Lanes::ZERO; D] };

    #[inline(always)]
    fn add(&mut self, velocity: Lanes, weight: f64, slopes: &[f64; D]) {
        self.velocity += velocity * weight;
        for (column, slope) in self.gradient.iter_mut().zip(slopes) {
            *column += velocity * *slope;
        }
    }
}

/// Up to `N` nodes by number, in a fixed order; a node may be named more than once.
#[derive(Clone, Copy, Debug)]
pub struct NodeList<const D: usize, const N: usize> {
    /// Node numbers.
    pub nodes: [u32; N],
    /// Positions of the nodes (m).
    pub places: [[f64; D]; N],
    /// Weights.
    pub weights: [f64; N],
    /// Gradients (1/m).
    pub gradients: [[f64; D]; N],
}

impl<const D: usize, const N: usize> NodeList<D, N> {
    /// No nodes yet.
    pub const EMPTY: Self =
        Self { nodes: [0; N], places: [[0.0; D]; N], weights: [0.0; N], gradients: [[0.0; D]; N] };
}

impl<const D: usize, const N: usize> Support<D> for NodeList<D, N> {
    #[inline(always)]
    fn for_each(&self, _strides: &[usize; D], mut visit: impl FnMut(usize, f64, &[f64; D])) {
        for k in 0..N {
            visit(self.nodes[k] as usize, self.weights[k], &self.gradients[k]);
        }
    }

    fn moments<const S: usize, B: Basis<S>>(&self, _grid: &Grid<D>, position: &[f64; D]) -> (Self, [f64; D]) {
        let mut moments = *self;
        let mut squares = [0.0; D];
        for k in 0..N {
            for axis in 0..D {
                let arm = self.places[k][axis] - position[axis];
                moments.gradients[k][axis] = self.weights[k] * arm;
                squares[axis] += self.weights[k] * arm * arm;
            }
        }
        (moments, squares)
    }
}
