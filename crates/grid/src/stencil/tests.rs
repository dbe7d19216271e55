use super::*;
use crate::{Gimp, Layout, Linear};

/// Two phases at once are each of them alone.
fn phases_are_independent<const D: usize, const S: usize, B: Basis<S>>() {
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
    let motions = stencil.gather_motions(&both, &strides);
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
        // To the last bit: which of them reads must not matter.
        assert_eq!(stencil.gather_motion(&one, &strides), [alone.velocity, alone.acceleration]);
        assert_eq!(motions[phase], [read[phase].velocity, read[phase].acceleration]);
    }
}

#[test]
fn phases_on_one_grid_do_not_mix() {
    phases_are_independent::<1, 2, Linear>();
    phases_are_independent::<2, 3, Gimp>();
    phases_are_independent::<3, 3, Gimp>();
}
