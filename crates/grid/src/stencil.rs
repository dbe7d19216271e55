//! Shape functions of a point in `D` dimensions, and the two transfers.

use wide::f64x4;

use crate::{Basis, Grid};

/// Four numbers handled at once: three components of a vector and one more.
pub type Lanes = f64x4;

/// What a node holds. While points scatter: momentum and, in the fourth lane, mass; internal and
/// other forces. After the momentum solve: velocity (mass stays in the fourth lane); acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Node {
    /// Momentum (kg m/s) and mass (kg), later velocity (m/s) and mass.
    pub motion: Lanes,
    /// Force (N), later acceleration (m/s²).
    pub force: Lanes,
}

/// Weights and gradients of the `S^D` nodes at a point, as products over the axes.
#[derive(Clone, Copy, Debug)]
pub struct Stencil<const D: usize, const S: usize> {
    /// First node along each axis.
    pub first: [usize; D],
    /// Weights along each axis.
    pub weights: [[f64; S]; D],
    /// Gradients along each axis (1/m).
    pub gradients: [[f64; S]; D],
}

/// What a point reads off the grid.
#[derive(Clone, Copy, Debug)]
pub struct Gathered<const D: usize> {
    /// `Σ N v`.
    pub velocity: Lanes,
    /// `Σ N a`.
    pub acceleration: Lanes,
    /// `gradient[j] = Σ v ∂N/∂x_j`: column `j` of the velocity gradient.
    pub gradient: [Lanes; D],
}

impl<const D: usize, const S: usize> Stencil<D, S> {
    /// The stencil of `basis` at `position` (m) for a point of full widths `extent` (m).
    #[inline(always)]
    pub fn new<B: Basis<S>>(grid: &Grid<D>, position: &[f64; D], extent: &[f64; D]) -> Self {
        let inverse = 1.0 / grid.cell;
        let mut stencil = Self { first: [0; D], weights: [[0.0; S]; D], gradients: [[0.0; S]; D] };
        for axis in 0..D {
            let x = (position[axis] - grid.origin[axis]) * inverse;
            let (first, w, g) = B::evaluate(x, extent[axis] * inverse, grid.cells[axis]);
            stencil.first[axis] = first;
            stencil.weights[axis] = w;
            stencil.gradients[axis] = g.map(|g| g * inverse);
        }
        stencil
    }

    /// Calls `visit(index of the first of S consecutive nodes, weight, gradient)` for every line of
    /// nodes along the last axis; weight and gradient are those of the other axes.
    #[inline(always)]
    pub(crate) fn lines(&self, strides: &[usize; D], mut visit: impl FnMut(usize, f64, [f64; 2])) {
        match D {
            1 => visit(self.first[0], 1.0, [0.0; 2]),
            2 => {
                for i in 0..S {
                    let start = (self.first[0] + i) * strides[0] + self.first[1];
                    visit(start, self.weights[0][i], [self.gradients[0][i], 0.0]);
                }
            }
            _ => {
                for i in 0..S {
                    for j in 0..S {
                        let start = (self.first[0] + i) * strides[0]
                            + (self.first[1] + j) * strides[1]
                            + self.first[2];
                        let (wx, wy) = (self.weights[0][i], self.weights[1][j]);
                        visit(start, wx * wy, [self.gradients[0][i] * wy, wx * self.gradients[1][j]]);
                    }
                }
            }
        }
    }

    /// Point to grid: adds `N motion` and `Σ_j ∂N/∂x_j columns[j] + N body` to the nodes.
    ///
    /// `nodes` starts at node number `offset`. With `columns[j] = -V σ e_j` this is the internal force.
    #[inline(always)]
    pub fn deposit(
        &self,
        nodes: &mut [Node],
        offset: usize,
        strides: &[usize; D],
        motion: Lanes,
        columns: &[Lanes; D],
        body: Option<Lanes>,
    ) {
        let last = D - 1;
        self.lines(strides, |start, w, g| {
            let line = &mut nodes[start - offset..start - offset + S];
            let across = columns[last] * w;
            let mut along = Lanes::ZERO;
            if D > 1 {
                along += columns[0] * g[0];
            }
            if D > 2 {
                along += columns[1] * g[1];
            }
            if let Some(body) = body {
                along += body * w;
            }
            let motion = motion * w;
            for k in 0..S {
                let (wk, gk) = (self.weights[last][k], self.gradients[last][k]);
                line[k].motion += motion * wk;
                line[k].force += along * wk + across * gk;
            }
        });
    }

    /// Point to grid, velocities only: adds `N motion`.
    #[inline(always)]
    pub fn deposit_motion(&self, nodes: &mut [Lanes], offset: usize, strides: &[usize; D], motion: Lanes) {
        let last = D - 1;
        self.lines(strides, |start, w, _| {
            let line = &mut nodes[start - offset..start - offset + S];
            let motion = motion * w;
            for k in 0..S {
                line[k] += motion * self.weights[last][k];
            }
        });
    }

    /// Point to grid: adds `N value + Σ_j ∂N/∂x_j columns[j]` to what `at` finds in a node.
    #[inline(always)]
    pub fn deposit_slopes<T>(
        &self,
        nodes: &mut [T],
        offset: usize,
        strides: &[usize; D],
        value: Lanes,
        columns: &[Lanes; D],
        at: impl Fn(&mut T) -> &mut Lanes,
    ) {
        let last = D - 1;
        self.lines(strides, |start, w, g| {
            let line = &mut nodes[start - offset..start - offset + S];
            let across = columns[last] * w;
            let mut along = value * w;
            if D > 1 {
                along += columns[0] * g[0];
            }
            if D > 2 {
                along += columns[1] * g[1];
            }
            for k in 0..S {
                let (wk, gk) = (self.weights[last][k], self.gradients[last][k]);
                *at(&mut line[k]) += along * wk + across * gk;
            }
        });
    }

    /// The same nodes with `N (x_i - x_p)` (m) in place of the gradients, and `Σ N (x_i - x_p)²` (m²) along each
    /// axis: what the affine transfers weigh with (MPM sheet §2.6). The mixed second moments are zero, because
    /// every family reproduces linear fields. `coordinate(index, cells)` says where a node lies.
    #[inline(always)]
    pub(crate) fn moments_at(
        &self,
        grid: &Grid<D>,
        position: &[f64; D],
        coordinate: impl Fn(usize, usize) -> f64,
    ) -> (Self, [f64; D]) {
        let mut moments = *self;
        let mut squares = [0.0; D];
        for axis in 0..D {
            let place = (position[axis] - grid.origin[axis]) / grid.cell;
            for k in 0..S {
                let node = coordinate(self.first[axis] + k, grid.cells[axis]);
                let arm = (node - place) * grid.cell;
                moments.gradients[axis][k] = self.weights[axis][k] * arm;
                squares[axis] += self.weights[axis][k] * arm * arm;
            }
        }
        (moments, squares)
    }

    /// Grid to point: `Σ N value` of what `of` finds in a node.
    #[inline(always)]
    pub fn interpolate<T>(&self, nodes: &[T], strides: &[usize; D], of: impl Fn(&T) -> Lanes) -> Lanes {
        let mut sum = Lanes::ZERO;
        self.lines(strides, |start, w, _| {
            let mut part = Lanes::ZERO;
            for (node, weight) in nodes[start..start + S].iter().zip(&self.weights[D - 1]) {
                part += of(node) * *weight;
            }
            sum += part * w;
        });
        sum
    }

    /// Grid to point: velocity, acceleration and velocity gradient.
    #[inline(always)]
    pub fn gather(&self, nodes: &[Node], strides: &[usize; D]) -> Gathered<D> {
        let last = D - 1;
        let zero = Lanes::ZERO;
        let mut out = Gathered { velocity: zero, acceleration: zero, gradient: [zero; D] };
        self.lines(strides, |start, w, g| {
            let line = &nodes[start..start + S];
            let (mut v, mut a, mut slope) = (zero, zero, zero);
            for k in 0..S {
                v += line[k].motion * self.weights[last][k];
                a += line[k].force * self.weights[last][k];
                slope += line[k].motion * self.gradients[last][k];
            }
            out.velocity += v * w;
            out.acceleration += a * w;
            out.gradient[last] += slope * w;
            if D > 1 {
                out.gradient[0] += v * g[0];
            }
            if D > 2 {
                out.gradient[1] += v * g[1];
            }
        });
        out
    }

    /// Grid to point: velocity and velocity gradient of the re-mapped velocities.
    #[inline(always)]
    pub fn gather_velocity(&self, nodes: &[Lanes], strides: &[usize; D]) -> Gathered<D> {
        let last = D - 1;
        let zero = Lanes::ZERO;
        let mut out = Gathered { velocity: zero, acceleration: zero, gradient: [zero; D] };
        self.lines(strides, |start, w, g| {
            let line = &nodes[start..start + S];
            let (mut v, mut slope) = (zero, zero);
            for k in 0..S {
                v += line[k] * self.weights[last][k];
                slope += line[k] * self.gradients[last][k];
            }
            out.velocity += v * w;
            out.gradient[last] += slope * w;
            if D > 1 {
                out.gradient[0] += v * g[0];
            }
            if D > 2 {
                out.gradient[1] += v * g[1];
            }
        });
        out
    }
}
