//! Transfers of a point between its nodes.

use wide::f64x8;

use super::{Stencil, splat_pair};
use crate::nodes::nodal_state::{join_halves, split_halves, vector4};
use crate::{Basis, Grid, InterpolatedMotion, NodalState, NodeSupport, Vector4};

impl<const D: usize, const S: usize> NodeSupport<D> for Stencil<D, S> {
    #[inline(always)]
    fn for_each(&self, strides: &[usize; D], mut visit: impl FnMut(usize, f64, &[f64; D])) {
        let last = D - 1;
        self.for_each_line(strides, |start, w, g| {
            for k in 0..S {
                let (wk, gk) = (self.weights[last][k], self.gradients[last][k]);
                let slopes = std::array::from_fn(|axis| if axis == last { w * gk } else { g[axis] * wk });
                visit(start + k, w * wk, &slopes);
            }
        });
    }

    #[inline(always)]
    fn affine_moments<const T: usize, B: Basis<T>>(
        &self,
        grid: &Grid<D>,
        position: &[f64; D],
    ) -> (Self, [f64; D]) {
        let mut moments = *self;
        let mut squares = [0.0; D];
        let inverse = 1.0 / grid.cell;
        for axis in 0..D {
            let place = (position[axis] - grid.origin[axis]) * inverse;
            let nodes: [f64; T] = B::coordinates(self.first[axis], grid.cells[axis]);
            for k in 0..S {
                moments.gradients[axis][k] = self.weights[axis][k] * ((nodes[k] - place) * grid.cell);
            }
            // So the first node of a point does not wait for a sum.
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
    fn p2g(
        &self,
        nodes: &mut [NodalState],
        offset: usize,
        strides: &[usize; D],
        motion: Vector4,
        columns: &[Vector4; D],
        body: Option<Vector4>,
    ) {
        let last = D - 1;
        self.for_each_line(strides, |start, w, g| {
            let line = &mut nodes[start - offset..start - offset + S];
            let across = columns[last] * w;
            let mut along = Vector4::ZERO;
            if D > 1 {
                along += columns[0] * g[0];
            }
            if D > 2 {
                along += columns[1] * g[1];
            }
            if let Some(body) = body {
                along += body * w;
            }
            let (value, slope) = (join_halves(motion * w, along), join_halves(Vector4::ZERO, across));
            for k in 0..S {
                line[k].add(value * self.weights[last][k] + slope * self.gradients[last][k]);
            }
        });
    }

    #[inline(always)]
    fn p2g_affine(
        &self,
        nodes: &mut [NodalState],
        offset: usize,
        strides: &[usize; D],
        (motion, columns, body): (Vector4, &[Vector4; D], Option<Vector4>),
        (moments, affine): (&Self, &[Vector4; D]),
    ) {
        let last = D - 1;
        let ends = moments.paired_gradients(self);
        let value = join_halves(motion, body.unwrap_or(Vector4::ZERO));
        let mut both = [f64x8::ZERO; D];
        for j in 0..D {
            both[j] = join_halves(affine[j], columns[j]);
        }
        // Loops instead of a closure, which would be called for each line.
        for i in 0..Self::LINE_COUNTS[0] {
            for j in 0..Self::LINE_COUNTS[1] {
                let (start, w, arm, slope) = moments.node_line(self, strides, i, j);
                let line = &mut nodes[start - offset..start - offset + S];
                let mut along = value * w;
                if D > 1 {
                    along += both[0] * splat_pair(arm[0], slope[0]);
                }
                if D > 2 {
                    along += both[1] * splat_pair(arm[1], slope[1]);
                }
                let across = both[last] * w;
                for k in 0..S {
                    line[k].add(along * self.weights[last][k] + across * ends[k]);
                }
            }
        }
    }

    #[inline(always)]
    fn p2g_value<T>(
        &self,
        nodes: &mut [T],
        offset: usize,
        strides: &[usize; D],
        motion: Vector4,
        at: impl Fn(&mut T) -> &mut Vector4,
    ) {
        let last = D - 1;
        self.for_each_line(strides, |start, w, _| {
            let line = &mut nodes[start - offset..start - offset + S];
            let motion = motion * w;
            for k in 0..S {
                *at(&mut line[k]) += motion * self.weights[last][k];
            }
        });
    }

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
        let last = D - 1;
        self.for_each_line(strides, |start, w, g| {
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
    fn p2g_moments(
        &self,
        nodes: &mut [Vector4],
        offset: usize,
        strides: &[usize; D],
        value: Vector4,
        moments: Vector4,
    ) {
        let last = D - 1;
        self.for_each_line(strides, |start, w, g| {
            let line = &mut nodes[start - offset..start - offset + S];
            let along = value * w + moments * vector4::<D>(|axis| if axis < last { g[axis] } else { 0.0 });
            let across = moments * vector4::<D>(|axis| if axis == last { w } else { 0.0 });
            for k in 0..S {
                line[k] += along * self.weights[last][k] + across * self.gradients[last][k];
            }
        });
    }

    #[inline(always)]
    fn g2p_value<T>(&self, nodes: &[T], strides: &[usize; D], of: impl Fn(&T) -> Vector4) -> Vector4 {
        let mut sum = Vector4::ZERO;
        self.for_each_line(strides, |start, w, _| {
            let mut part = Vector4::ZERO;
            for (node, weight) in nodes[start..start + S].iter().zip(&self.weights[D - 1]) {
                part += of(node) * *weight;
            }
            sum += part * w;
        });
        sum
    }

    #[inline(always)]
    fn g2p(&self, nodes: &[NodalState], strides: &[usize; D]) -> InterpolatedMotion<D> {
        let last = D - 1;
        let mut out = InterpolatedMotion::ZERO;
        let mut both = f64x8::ZERO;
        self.for_each_line(strides, |start, w, g| {
            let line = &nodes[start..start + S];
            let (mut value, mut slope) = (f64x8::ZERO, Vector4::ZERO);
            for k in 0..S {
                value += line[k].as_f64x8() * self.weights[last][k];
                slope += line[k].momentum_and_mass * self.gradients[last][k];
            }
            both += value * w;
            let [v, _] = split_halves(value);
            out.add_gradient_of_line(v, slope, w, g);
        });
        [out.velocity, out.acceleration] = split_halves(both);
        out
    }

    #[inline(always)]
    fn g2p_motion(&self, nodes: &[NodalState], strides: &[usize; D]) -> [Vector4; 2] {
        let mut both = f64x8::ZERO;
        self.for_each_line(strides, |start, w, _| {
            let line = &nodes[start..start + S];
            both += self.sum_along_line(w, |k| line[k].as_f64x8());
        });
        split_halves(both)
    }

    #[inline(always)]
    fn g2p_with_affine(
        &self,
        other: &Self,
        nodes: &[NodalState],
        strides: &[usize; D],
    ) -> (InterpolatedMotion<D>, [Vector4; D]) {
        let last = D - 1;
        let ends = self.paired_gradients(other);
        let (mut both, mut slopes) = (f64x8::ZERO, [f64x8::ZERO; D]);
        for i in 0..Self::LINE_COUNTS[0] {
            for j in 0..Self::LINE_COUNTS[1] {
                let (start, w, g, h) = self.node_line(other, strides, i, j);
                let line = &nodes[start..start + S];
                let (mut value, mut slope) = (f64x8::ZERO, f64x8::ZERO);
                for k in 0..S {
                    value += line[k].as_f64x8() * self.weights[last][k];
                    slope += join_halves(line[k].momentum_and_mass, line[k].momentum_and_mass) * ends[k];
                }
                both += value * w;
                slopes[last] += slope * w;
                let [v, _] = split_halves(value);
                let twice = join_halves(v, v);
                if D > 1 {
                    slopes[0] += twice * splat_pair(g[0], h[0]);
                }
                if D > 2 {
                    slopes[1] += twice * splat_pair(g[1], h[1]);
                }
            }
        }
        let (mut out, mut others) = (InterpolatedMotion::ZERO, [Vector4::ZERO; D]);
        [out.velocity, out.acceleration] = split_halves(both);
        for j in 0..D {
            [out.gradient[j], others[j]] = split_halves(slopes[j]);
        }
        (out, others)
    }

    #[inline(always)]
    fn g2p_velocity(&self, nodes: &[Vector4], strides: &[usize; D]) -> InterpolatedMotion<D> {
        let last = D - 1;
        let zero = Vector4::ZERO;
        let mut out = InterpolatedMotion::ZERO;
        self.for_each_line(strides, |start, w, g| {
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
    fn p2g_phases<const N: usize>(
        &self,
        nodes: &mut [[NodalState; N]],
        offset: usize,
        strides: &[usize; D],
        motion: &[Vector4; N],
        columns: &[[Vector4; D]; N],
        body: &[Vector4; N],
    ) {
        let last = D - 1;
        self.for_each_line(strides, |start, w, g| {
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
                    line[k][phase].momentum_and_mass += motion * wk;
                    line[k][phase].force += along * wk + across * gk;
                }
            }
        });
    }

    #[inline(always)]
    fn p2g_phase_values<const N: usize>(
        &self,
        nodes: &mut [[Vector4; N]],
        offset: usize,
        strides: &[usize; D],
        motion: &[Vector4; N],
    ) {
        let last = D - 1;
        self.for_each_line(strides, |start, w, _| {
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
    fn g2p_phases<const N: usize>(
        &self,
        nodes: &[[NodalState; N]],
        strides: &[usize; D],
    ) -> [InterpolatedMotion<D>; N] {
        let last = D - 1;
        let zero = Vector4::ZERO;
        let mut out = [InterpolatedMotion::ZERO; N];
        self.for_each_line(strides, |start, w, g| {
            let line = &nodes[start..start + S];
            for (phase, out) in out.iter_mut().enumerate() {
                let (mut v, mut a, mut slope) = (zero, zero, zero);
                for k in 0..S {
                    v += line[k][phase].momentum_and_mass * self.weights[last][k];
                    a += line[k][phase].force * self.weights[last][k];
                    slope += line[k][phase].momentum_and_mass * self.gradients[last][k];
                }
                out.acceleration += a * w;
                out.add_line(v, slope, w, g);
            }
        });
        out
    }

    #[inline(always)]
    fn g2p_phase_motions<const N: usize>(
        &self,
        nodes: &[[NodalState; N]],
        strides: &[usize; D],
    ) -> [[Vector4; 2]; N] {
        let mut both = [f64x8::ZERO; N];
        self.for_each_line(strides, |start, w, _| {
            let line = &nodes[start..start + S];
            for (phase, both) in both.iter_mut().enumerate() {
                *both += self.sum_along_line(w, |k| line[k][phase].as_f64x8());
            }
        });
        both.map(split_halves)
    }

    #[inline(always)]
    fn g2p_phase_velocities<const N: usize>(
        &self,
        nodes: &[[Vector4; N]],
        strides: &[usize; D],
    ) -> [InterpolatedMotion<D>; N] {
        let last = D - 1;
        let zero = Vector4::ZERO;
        let mut out = [InterpolatedMotion::ZERO; N];
        self.for_each_line(strides, |start, w, g| {
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

impl<const D: usize> InterpolatedMotion<D> {
    /// Adds the contribution of a line of nodes along the last axis to velocity and gradient.
    #[inline(always)]
    fn add_line(&mut self, v: Vector4, slope: Vector4, w: f64, g: [f64; 2]) {
        self.velocity += v * w;
        self.add_gradient_of_line(v, slope, w, g);
    }

    /// Adds the contribution of a line of nodes to the velocity gradient; `v` is its velocity sum, `slope` its gradient sum along the last
    /// axis.
    #[inline(always)]
    fn add_gradient_of_line(&mut self, v: Vector4, slope: Vector4, w: f64, g: [f64; 2]) {
        self.gradient[D - 1] += slope * w;
        if D > 1 {
            self.gradient[0] += v * g[0];
        }
        if D > 2 {
            self.gradient[1] += v * g[1];
        }
    }
}
