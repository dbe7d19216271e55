//! The transfers for several phases that move apart on one grid: each node holds one entry a phase.

use crate::{Gathered, Lanes, Node, Stencil};

impl<const D: usize, const S: usize> Stencil<D, S> {
    /// As [`Stencil::deposit`], for `N` phases at once. The fourth lane of `body` is free for a scalar, which the
    /// force of the node sums up.
    #[inline(always)]
    pub fn deposit_phases<const N: usize>(
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

    /// As [`Stencil::deposit_motion`], for `N` phases at once.
    #[inline(always)]
    pub fn deposit_motions<const N: usize>(
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

    /// As [`Stencil::gather`], for `N` phases at once.
    #[inline(always)]
    pub fn gather_phases<const N: usize>(
        &self,
        nodes: &[[Node; N]],
        strides: &[usize; D],
    ) -> [Gathered<D>; N] {
        let last = D - 1;
        let zero = Lanes::ZERO;
        let mut out = [Gathered { velocity: zero, acceleration: zero, gradient: [zero; D] }; N];
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
                add(out, v, slope, w, g);
            }
        });
        out
    }

    /// As [`Stencil::gather_velocity`], for `N` phases at once.
    #[inline(always)]
    pub fn gather_velocities<const N: usize>(
        &self,
        nodes: &[[Lanes; N]],
        strides: &[usize; D],
    ) -> [Gathered<D>; N] {
        let last = D - 1;
        let zero = Lanes::ZERO;
        let mut out = [Gathered { velocity: zero, acceleration: zero, gradient: [zero; D] }; N];
        self.lines(strides, |start, w, g| {
            let line = &nodes[start..start + S];
            for (phase, out) in out.iter_mut().enumerate() {
                let (mut v, mut slope) = (zero, zero);
                for k in 0..S {
                    v += line[k][phase] * self.weights[last][k];
                    slope += line[k][phase] * self.gradients[last][k];
                }
                add(out, v, slope, w, g);
            }
        });
        out
    }
}

/// Adds what a line of nodes along the last axis gives to velocity and gradient.
#[inline(always)]
fn add<const D: usize>(out: &mut Gathered<D>, v: Lanes, slope: Lanes, w: f64, g: [f64; 2]) {
    out.velocity += v * w;
    out.gradient[D - 1] += slope * w;
    if D > 1 {
        out.gradient[0] += v * g[0];
    }
    if D > 2 {
        out.gradient[1] += v * g[1];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gimp, Grid, Layout, Linear};

    /// Two phases at once are each of them alone.
    fn phases_are_independent<const D: usize, const S: usize, B: crate::Basis<S>>() {
        let grid = Grid::new([0.0; D], [1.0; D], 0.25).unwrap();
        let layout = Layout::<D>::new::<S, B>(&grid);
        let strides = layout.strides();
        let stencil = Stencil::<D, S>::new::<B>(&grid, &[0.41; D], &[0.125; D]);
        let lanes = |seed: f64| Lanes::new([seed, 2.0 * seed, -seed, 0.5]);
        let motion = [lanes(1.0), lanes(-0.3)];
        let columns = [[lanes(0.2); D], [lanes(7.0); D]];
        let body = [lanes(3.0), lanes(0.1)];
        let mut both = vec![[Node::default(); 2]; layout.len()];
        stencil.deposit_phases(&mut both, 0, &strides, &motion, &columns, &body);
        let mut momenta = vec![[Lanes::ZERO; 2]; layout.len()];
        stencil.deposit_motions(&mut momenta, 0, &strides, &motion);
        let read = stencil.gather_phases(&both, &strides);
        let mapped = stencil.gather_velocities(&momenta, &strides);
        for phase in 0..2 {
            let mut one = vec![Node::default(); layout.len()];
            stencil.deposit(&mut one, 0, &strides, motion[phase], &columns[phase], Some(body[phase]));
            let close = |a: Lanes, b: Lanes| (a - b).abs().reduce_add() < 1e-12;
            assert!(one.iter().zip(&both).all(|(a, b)| close(a.motion, b[phase].motion)));
            assert!(one.iter().zip(&both).all(|(a, b)| close(a.force, b[phase].force)));
            assert!(one.iter().zip(&momenta).all(|(a, b)| close(a.motion, b[phase])));
            let alone = stencil.gather(&one, &strides);
            for other in [&read[phase], &mapped[phase]] {
                assert!(close(alone.velocity, other.velocity));
                assert!((0..D).all(|j| close(alone.gradient[j], other.gradient[j])));
            }
            assert!(close(alone.acceleration, read[phase].acceleration));
        }
    }

    #[test]
    fn phases_on_one_grid_do_not_mix() {
        phases_are_independent::<1, 2, Linear>();
        phases_are_independent::<2, 3, Gimp>();
        phases_are_independent::<3, 3, Gimp>();
    }
}
