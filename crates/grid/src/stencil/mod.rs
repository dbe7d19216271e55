//! Shape functions of a point in `D` dimensions, and the two transfers.

use wide::f64x8;

use crate::node::{join, lanes_of, split};
use crate::{Basis, Gathered, Grid, Lanes, Node, Support};

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

impl<const D: usize, const S: usize> Stencil<D, S> {
    /// The stencil of `basis` at `position` (m) for a point of full widths `extent` (m).
    #[inline(always)]
    pub fn new<B: Basis<S>>(grid: &Grid<D>, position: &[f64; D], extent: &[f64; D]) -> Self {
        let inverse = 1.0 / grid.cell;
        let at = |axis: usize| {
            let x = (position[axis] - grid.origin[axis]) * inverse;
            B::evaluate(x, extent[axis] * inverse, grid.cells[axis])
        };
        // Not of zeros: to clear what is overwritten at once takes a tenth of a transfer.
        let (first, w, g) = at(0);
        let mut stencil = Self { first: [first; D], weights: [w; D], gradients: [g; D] };
        for axis in 0..D {
            let (first, w, g) = if axis == 0 { (first, w, g) } else { at(axis) };
            stencil.first[axis] = first;
            stencil.weights[axis] = w;
            for k in 0..S {
                stencil.gradients[axis][k] = g[k] * inverse;
            }
        }
        stencil
    }

    /// Lines of nodes along the last axis: so many along the first axis, and so many along the second of three.
    const LINES: [usize; 2] = [if D > 1 { S } else { 1 }, if D > 2 { S } else { 1 }];

    /// Of a line of nodes along the last axis: index of the first of `S` consecutive nodes, weight, and gradients of this stencil
    /// and of `other` on the same nodes; weight and gradients are those of the other axes.
    #[inline(always)]
    fn line(
        &self,
        other: &Self,
        strides: &[usize; D],
        i: usize,
        j: usize,
    ) -> (usize, f64, [f64; 2], [f64; 2]) {
        let start = self.first[D - 1];
        if D == 1 {
            return (start, 1.0, [0.0; 2], [0.0; 2]);
        }
        let start = start + (self.first[0] + i) * strides[0];
        let (wx, gx, hx) = (self.weights[0][i], self.gradients[0][i], other.gradients[0][i]);
        if D == 2 {
            return (start, wx, [gx, 0.0], [hx, 0.0]);
        }
        let start = start + (self.first[1] + j) * strides[1];
        let (wy, gy, hy) = (self.weights[1][j], self.gradients[1][j], other.gradients[1][j]);
        (start, wx * wy, [gx * wy, wx * gy], [hx * wy, wx * hy])
    }

    /// Calls `visit(index of the first of S consecutive nodes, weight, gradient)` for every line of
    /// nodes along the last axis; weight and gradient are those of the other axes.
    #[inline(always)]
    pub(crate) fn lines(&self, strides: &[usize; D], mut visit: impl FnMut(usize, f64, [f64; 2])) {
        for i in 0..Self::LINES[0] {
            for j in 0..Self::LINES[1] {
                let (start, w, g, _) = self.line(self, strides, i, j);
                visit(start, w, g);
            }
        }
    }

    /// What a line of nodes along the last axis gives of the numbers `of` them, where the other axes weigh `w`.
    #[inline(always)]
    fn along_line(&self, w: f64, of: impl Fn(usize) -> f64x8) -> f64x8 {
        let mut value = f64x8::ZERO;
        for k in 0..S {
            value += of(k) * self.weights[D - 1][k];
        }
        value * w
    }

    /// The gradients along the last axis of this stencil in four lanes, those of `other` in the other four.
    #[inline(always)]
    fn ends_of_two(&self, other: &Self) -> [f64x8; S] {
        let mut ends = [f64x8::ZERO; S];
        for k in 0..S {
            ends[k] = pair(self.gradients[D - 1][k], other.gradients[D - 1][k]);
        }
        ends
    }
}

/// Four times one number and four times another.
#[inline(always)]
fn pair(first: f64, second: f64) -> f64x8 {
    join(Lanes::splat(first), Lanes::splat(second))
}

impl<const D: usize, const S: usize> Support<D> for Stencil<D, S> {
    #[inline(always)]
    fn for_each(&self, strides: &[usize; D], mut visit: impl FnMut(usize, f64, &[f64; D])) {
        let last = D - 1;
        self.lines(strides, |start, w, g| {
            for k in 0..S {
                let (wk, gk) = (self.weights[last][k], self.gradients[last][k]);
                let slopes = std::array::from_fn(|axis| if axis == last { w * gk } else { g[axis] * wk });
                visit(start + k, w * wk, &slopes);
            }
        });
    }

    #[inline(always)]
    fn moments<const T: usize, B: Basis<T>>(&self, grid: &Grid<D>, position: &[f64; D]) -> (Self, [f64; D]) {
        let mut moments = *self;
        let mut squares = [0.0; D];
        let inverse = 1.0 / grid.cell;
        for axis in 0..D {
            let place = (position[axis] - grid.origin[axis]) * inverse;
            let nodes: [f64; T] = B::coordinates(self.first[axis], grid.cells[axis]);
            for k in 0..S {
                moments.gradients[axis][k] = self.weights[axis][k] * ((nodes[k] - place) * grid.cell);
            }
            // A point then waits for no sum before it reaches its first node.
            squares[axis] = if let Some(same) = B::second_moment(self.first[axis], grid.cells[axis]) {
                same * (grid.cell * grid.cell)
            } else {
                let square = |k: usize| moments.gradients[axis][k] * ((nodes[k] - place) * grid.cell);
                (0..S).fold(0.0, |sum, k| sum + square(k))
            };
        }
        (moments, squares)
    }

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
            let (value, slope) = (join(motion * w, along), join(Lanes::ZERO, across));
            for k in 0..S {
                line[k].add(value * self.weights[last][k] + slope * self.gradients[last][k]);
            }
        });
    }

    #[inline(always)]
    fn deposit_affine(
        &self,
        nodes: &mut [Node],
        offset: usize,
        strides: &[usize; D],
        (motion, columns, body): (Lanes, &[Lanes; D], Option<Lanes>),
        (moments, affine): (&Self, &[Lanes; D]),
    ) {
        let last = D - 1;
        let ends = moments.ends_of_two(self);
        let value = join(motion, body.unwrap_or(Lanes::ZERO));
        let mut both = [f64x8::ZERO; D];
        for j in 0..D {
            both[j] = join(affine[j], columns[j]);
        }
        // Loops and no closure, which would be called for each line.
        for i in 0..Self::LINES[0] {
            for j in 0..Self::LINES[1] {
                let (start, w, arm, slope) = moments.line(self, strides, i, j);
                let line = &mut nodes[start - offset..start - offset + S];
                let mut along = value * w;
                if D > 1 {
                    along += both[0] * pair(arm[0], slope[0]);
                }
                if D > 2 {
                    along += both[1] * pair(arm[1], slope[1]);
                }
                let across = both[last] * w;
                for k in 0..S {
                    line[k].add(along * self.weights[last][k] + across * ends[k]);
                }
            }
        }
    }

    #[inline(always)]
    fn deposit_motion(&self, nodes: &mut [Lanes], offset: usize, strides: &[usize; D], motion: Lanes) {
        let last = D - 1;
        self.lines(strides, |start, w, _| {
            let line = &mut nodes[start - offset..start - offset + S];
            let motion = motion * w;
            for k in 0..S {
                line[k] += motion * self.weights[last][k];
            }
        });
    }

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

    #[inline(always)]
    fn deposit_gradients(
        &self,
        nodes: &mut [Lanes],
        offset: usize,
        strides: &[usize; D],
        value: Lanes,
        moments: Lanes,
    ) {
        let last = D - 1;
        self.lines(strides, |start, w, g| {
            let line = &mut nodes[start - offset..start - offset + S];
            let along = value * w + moments * lanes_of::<D>(|axis| if axis < last { g[axis] } else { 0.0 });
            let across = moments * lanes_of::<D>(|axis| if axis == last { w } else { 0.0 });
            for k in 0..S {
                line[k] += along * self.weights[last][k] + across * self.gradients[last][k];
            }
        });
    }

    #[inline(always)]
    fn interpolate<T>(&self, nodes: &[T], strides: &[usize; D], of: impl Fn(&T) -> Lanes) -> Lanes {
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

    #[inline(always)]
    fn gather(&self, nodes: &[Node], strides: &[usize; D]) -> Gathered<D> {
        let last = D - 1;
        let mut out = Gathered::ZERO;
        let mut both = f64x8::ZERO;
        self.lines(strides, |start, w, g| {
            let line = &nodes[start..start + S];
            let (mut value, mut slope) = (f64x8::ZERO, Lanes::ZERO);
            for k in 0..S {
                value += line[k].whole() * self.weights[last][k];
                slope += line[k].motion * self.gradients[last][k];
            }
            both += value * w;
            let [v, _] = split(value);
            out.slopes_of_line(v, slope, w, g);
        });
        [out.velocity, out.acceleration] = split(both);
        out
    }

    #[inline(always)]
    fn gather_motion(&self, nodes: &[Node], strides: &[usize; D]) -> [Lanes; 2] {
        let mut both = f64x8::ZERO;
        self.lines(strides, |start, w, _| {
            let line = &nodes[start..start + S];
            both += self.along_line(w, |k| line[k].whole());
        });
        split(both)
    }

    #[inline(always)]
    fn gather_both(&self, other: &Self, nodes: &[Node], strides: &[usize; D]) -> (Gathered<D>, [Lanes; D]) {
        let last = D - 1;
        let ends = self.ends_of_two(other);
        let (mut both, mut slopes) = (f64x8::ZERO, [f64x8::ZERO; D]);
        for i in 0..Self::LINES[0] {
            for j in 0..Self::LINES[1] {
                let (start, w, g, h) = self.line(other, strides, i, j);
                let line = &nodes[start..start + S];
                let (mut value, mut slope) = (f64x8::ZERO, f64x8::ZERO);
                for k in 0..S {
                    value += line[k].whole() * self.weights[last][k];
                    slope += join(line[k].motion, line[k].motion) * ends[k];
                }
                both += value * w;
                slopes[last] += slope * w;
                let [v, _] = split(value);
                let twice = join(v, v);
                if D > 1 {
                    slopes[0] += twice * pair(g[0], h[0]);
                }
                if D > 2 {
                    slopes[1] += twice * pair(g[1], h[1]);
                }
            }
        }
        let (mut out, mut others) = (Gathered::ZERO, [Lanes::ZERO; D]);
        [out.velocity, out.acceleration] = split(both);
        for j in 0..D {
            [out.gradient[j], others[j]] = split(slopes[j]);
        }
        (out, others)
    }

    #[inline(always)]
    fn gather_velocity(&self, nodes: &[Lanes], strides: &[usize; D]) -> Gathered<D> {
        let last = D - 1;
        let zero = Lanes::ZERO;
        let mut out = Gathered::ZERO;
        self.lines(strides, |start, w, g| {
            let line = &nodes[start..start + S];
            let (mut v, mut slope) = (zero, zero);
            for k in 0..S {
                v += line[k] * self.weights[last][k];
                slope += line[k] * self.gradients[last][k];
            }
            out.add_line(v, slope, w, g);
        });
        out
    }

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
        let last = D - 1;
        self.lines(strides, |start, w, g| {
            let line = &mut nodes[start - offset..start - offset + S];
            for phase in 0..N {
                let across = columns[phase][last] * w;
                let mut along = body[phase] * w;
                if D > 1 {
                    along += columns[phase][0] * g[0];
                }
                if D > 2 {
                    along += columns[phase][1] * g[1];
                }
                let motion = motion[phase] * w;
                for k in 0..S {
                    let (wk, gk) = (self.weights[last][k], self.gradients[last][k]);
                    line[k][phase].motion += motion * wk;
                    line[k][phase].force += along * wk + across * gk;
                }
            }
        });
    }

    #[inline(always)]
    fn deposit_motions<const N: usize>(
        &self,
        nodes: &mut [[Lanes; N]],
        offset: usize,
        strides: &[usize; D],
        motion: &[Lanes; N],
    ) {
        let last = D - 1;
        self.lines(strides, |start, w, _| {
            let line = &mut nodes[start - offset..start - offset + S];
            for phase in 0..N {
                let motion = motion[phase] * w;
                for k in 0..S {
                    line[k][phase] += motion * self.weights[last][k];
                }
            }
        });
    }

    #[inline(always)]
    fn gather_phases<const N: usize>(&self, nodes: &[[Node; N]], strides: &[usize; D]) -> [Gathered<D>; N] {
        let last = D - 1;
        let zero = Lanes::ZERO;
        let mut out = [Gathered::ZERO; N];
        self.lines(strides, |start, w, g| {
            let line = &nodes[start..start + S];
            for (phase, out) in out.iter_mut().enumerate() {
                let (mut v, mut a, mut slope) = (zero, zero, zero);
                for k in 0..S {
                    v += line[k][phase].motion * self.weights[last][k];
                    a += line[k][phase].force * self.weights[last][k];
                    slope += line[k][phase].motion * self.gradients[last][k];
                }
                out.acceleration += a * w;
                out.add_line(v, slope, w, g);
            }
        });
        out
    }

    #[inline(always)]
    fn gather_motions<const N: usize>(&self, nodes: &[[Node; N]], strides: &[usize; D]) -> [[Lanes; 2]; N] {
        let mut both = [f64x8::ZERO; N];
        self.lines(strides, |start, w, _| {
            let line = &nodes[start..start + S];
            for (phase, both) in both.iter_mut().enumerate() {
                *both += self.along_line(w, |k| line[k][phase].whole());
            }
        });
        both.map(split)
    }

    #[inline(always)]
    fn gather_velocities<const N: usize>(
        &self,
        nodes: &[[Lanes; N]],
        strides: &[usize; D],
    ) -> [Gathered<D>; N] {
        let last = D - 1;
        let zero = Lanes::ZERO;
        let mut out = [Gathered::ZERO; N];
        self.lines(strides, |start, w, g| {
            let line = &nodes[start..start + S];
            for (phase, out) in out.iter_mut().enumerate() {
                let (mut v, mut slope) = (zero, zero);
                for k in 0..S {
                    v += line[k][phase] * self.weights[last][k];
                    slope += line[k][phase] * self.gradients[last][k];
                }
                out.add_line(v, slope, w, g);
            }
        });
        out
    }
}

impl<const D: usize> Gathered<D> {
    /// Adds what a line of nodes along the last axis gives to velocity and gradient.
    #[inline(always)]
    fn add_line(&mut self, v: Lanes, slope: Lanes, w: f64, g: [f64; 2]) {
        self.velocity += v * w;
        self.slopes_of_line(v, slope, w, g);
    }

    #[inline(always)]
    fn slopes_of_line(&mut self, v: Lanes, slope: Lanes, w: f64, g: [f64; 2]) {
        self.gradient[D - 1] += slope * w;
        if D > 1 {
            self.gradient[0] += v * g[0];
        }
        if D > 2 {
            self.gradient[1] += v * g[1];
        }
    }
}

#[cfg(test)]
mod tests;
