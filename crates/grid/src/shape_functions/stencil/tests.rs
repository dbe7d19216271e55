use crate::shape_functions::stencil::*;
use crate::{GimpBasis, Layout, LinearBasis, NodalState, NodeSupport};

/// Transfers of two phases at once equal those of each phase alone.
fn phases_are_independent<const D: usize, const S: usize, B: Basis<S>>() {
    let grid = Grid::new([0.0; D], [1.0; D], 0.25).unwrap();
    let layout = Layout::<D>::new::<S, B>(&grid);
    let strides = layout.strides();
    let stencil = Stencil::<D, S>::new::<B>(&grid, &[0.41; D], &[0.125; D]);
    let lanes = |seed: f64| Vector4::new([seed, 2.0 * seed, -seed, 0.5]);
    let motion = [lanes(1.0), lanes(-0.3)];
    let columns = [[lanes(0.2); D], [lanes(7.0); D]];
    let body = [lanes(3.0), lanes(0.1)];
    let mut both = vec![[NodalState::default(); 2]; layout.len()];
    stencil.p2g_phases(&mut both, 0, &strides, &motion, &columns, &body);
    let mut momenta = vec![[Vector4::ZERO; 2]; layout.len()];
    stencil.p2g_phase_values(&mut momenta, 0, &strides, &motion);
    let read = stencil.g2p_phases(&both, &strides);
    let mapped = stencil.g2p_phase_velocities(&momenta, &strides);
    let motions = stencil.g2p_phase_motions(&both, &strides);
    for phase in 0..2 {
        let mut one = vec![NodalState::default(); layout.len()];
        stencil.p2g(&mut one, 0, &strides, motion[phase], &columns[phase], Some(body[phase]));
        let close = |a: Vector4, b: Vector4| (a - b).abs().reduce_add() < 1e-12;
        assert!(one.iter().zip(&both).all(|(a, b)| close(a.momentum_and_mass, b[phase].momentum_and_mass)));
        assert!(one.iter().zip(&both).all(|(a, b)| close(a.force, b[phase].force)));
        assert!(one.iter().zip(&momenta).all(|(a, b)| close(a.momentum_and_mass, b[phase])));
        let alone = stencil.g2p(&one, &strides);
        for other in [&read[phase], &mapped[phase]] {
            assert!(close(alone.velocity, other.velocity));
            assert!((0..D).all(|j| close(alone.gradient[j], other.gradient[j])));
        }
        assert!(close(alone.acceleration, read[phase].acceleration));
        // Bitwise equal: both functions must give the same result.
        assert_eq!(stencil.g2p_motion(&one, &strides), [alone.velocity, alone.acceleration]);
        assert_eq!(motions[phase], [read[phase].velocity, read[phase].acceleration]);
    }
}

#[test]
fn phases_on_one_grid_do_not_mix() {
    phases_are_independent::<1, 2, LinearBasis>();
    phases_are_independent::<2, 3, GimpBasis>();
    phases_are_independent::<3, 3, GimpBasis>();
}
