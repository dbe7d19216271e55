//! Tests of the return of several points at once against the bracketed solve.

use proptest::prelude::*;

use super::{
    CamClayHardening, CamClayIntegration, CohesiveCamClay, CohesiveCamClaySpec, CohesiveCamClayState,
    ReturnEnd,
};
use crate::Model;
use crate::laws::cohesive_cam_clay::batch_newton::{InvariantBatch, MAX_HYPERBOLIC_ARGUMENT, hyperbolic};

/// Laws of the samples, and snow of soft and hard slabs and of a brittle layer.
fn laws() -> Vec<CohesiveCamClay> {
    let sample = CohesiveCamClaySpec::examples().remove(0);
    let snow = |p0, m, beta, xi, hardening| CohesiveCamClaySpec {
        youngs_modulus: 3e6,
        critical_state_slope: m,
        cohesion_ratio: beta,
        compressive_strength: p0,
        hardening_factor: xi,
        hardening,
        ..sample.clone()
    };
    let slab = CamClayHardening::Slab;
    let layer = CamClayHardening::WeakLayer { softening_factor: 50.0 };
    let mut all = CohesiveCamClaySpec::examples();
    all.extend([
        snow(3e3, 0.5, 0.0, 1.0, slab),
        snow(8e3, 1.2, 0.3, 0.1, slab),
        snow(30e3, 1.5, 1.0, 10.0, slab),
        snow(3e3, 1.2, 0.3, 0.02, layer),
        snow(3e3, 0.6, 0.8, 0.01, layer),
    ]);
    let explicit = all
        .clone()
        .into_iter()
        .map(|spec| CohesiveCamClaySpec { integration: CamClayIntegration::Explicit, ..spec });
    let explicit: Vec<_> = explicit.collect();
    all.extend(explicit);
    all.iter().map(|spec| spec.law().unwrap()).collect()
}

/// State of a given strength: `p0` over that at the start.
fn state(law: &CohesiveCamClay, strength: f64, collapsed: bool) -> CohesiveCamClayState {
    let ratio = strength * law.spec.compressive_strength / law.elasticity.bulk_modulus;
    let hardening_strain = -ratio.asinh() / law.spec.hardening_factor;
    let collapsed = collapsed && law.spec.hardening != CamClayHardening::Slab;
    CohesiveCamClayState { hardening_strain, volumetric: 0.0, deviatoric: 0.0, collapsed }
}

#[test]
fn hyperbolic_functions_by_series() {
    for i in 0..=400 {
        let x = 0.01 * f64::from(i);
        let (sinh, cosh) = hyperbolic(x);
        assert!(
            (sinh - x.sinh()).abs() <= 4e-15 * x.sinh() && (cosh - x.cosh()).abs() <= 4e-15 * x.cosh(),
            "{x}"
        );
    }
    assert!(hyperbolic(MAX_HYPERBOLIC_ARGUMENT).0.is_finite());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn newtons_method_ends_where_the_bracketed_solve_does(
        which in 0..laws().len(),
        strength in -3.0..0.5f64,
        collapsed in any::<bool>(),
        along in -6.0..6.0f64,
        across in 0.0..6.0f64,
        size in -4.0..1.0f64,
    ) {
        let law = &laws()[which];
        let state = state(law, 10f64.powf(strength), collapsed);
        let ellipse = law.ellipse(&state);
        // From the surface outwards by a share of its size.
        let length = along.hypot(across).max(1e-3);
        let (p, q) = (ellipse.strength * along / length, ellipse.strength * across / length);
        let edge = (0..60).fold((0.0, 1.0), |(low, high), _| {
            let middle = 0.5 * (low + high);
            if ellipse.yield_value(middle * p, middle * q) > 0.0 { (low, middle) } else { (middle, high) }
        }).1;
        let trial = ((edge + 10f64.powf(size)) * p, (edge + 10f64.powf(size)) * q);
        let (quick, new) = law.return_map(trial, &state).unwrap();
        let (slow, old) = law.return_map_bracketed(trial, &state).unwrap();
        match (quick, slow) {
            (ReturnEnd::Elastic, ReturnEnd::Elastic) | (ReturnEnd::StressFree, ReturnEnd::StressFree) => prop_assert_eq!(new, old),
            (ReturnEnd::Surface(quick), ReturnEnd::Surface(slow)) => {
                let (a, b) = (quick.projection, slow.projection);
                let size = slow.ellipse.strength.max(b.pressure.abs() + b.q);
                let apart = (a.pressure - b.pressure).abs() + (a.q - b.q).abs();
                prop_assert!(apart <= 1e-10 * size, "{:?} {:?}: {:e}", a, b, apart / size);
                prop_assert!((a.multiplier / b.multiplier - 1.0).abs() <= 1e-8, "{} {}", a.multiplier, b.multiplier);
                let strains = (new.hardening_strain - old.hardening_strain).abs() + (new.volumetric - old.volumetric).abs();
                prop_assert!(strains <= 1e-10 * (new.volumetric.abs() + size / law.elasticity.bulk_modulus));
                prop_assert_eq!(new.collapsed, old.collapsed);
                // On the surface at the end of the step.
                let y = quick.ellipse.yield_value(a.pressure, a.q);
                prop_assert!(y.abs() <= 1e-12 * quick.ellipse.radius(), "{y}");
            }
            _ => prop_assert!(false, "one of them is elastic or without stress"),
        }
    }

    #[test]
    fn the_return_of_a_point_is_independent_of_its_batch(
        which in 0..laws().len(),
        trials in proptest::array::uniform8((-2.0..2.0f64, 0.0..2.0f64, 0.01..2.0f64)),
    ) {
        let law = &laws()[which];
        let p0 = law.spec.compressive_strength;
        let states = trials.map(|(_, _, strength)| state(law, strength, strength > 1.0));
        let mut together = InvariantBatch::from_trials(trials.map(|t| t.0 * p0), trials.map(|t| t.1 * p0));
        let mut after = states;
        law.return_invariant_batch(&mut together, &mut after);
        for i in 0..8 {
            let mut alone = InvariantBatch::from_trials([trials[i].0 * p0], [trials[i].1 * p0]);
            let mut state = [states[i]];
            law.return_invariant_batch(&mut alone, &mut state);
            prop_assert_eq!(alone.pressure[0].to_bits(), together.pressure[i].to_bits());
            prop_assert_eq!(alone.q[0].to_bits(), together.q[i].to_bits());
            prop_assert_eq!(alone.fallback[0], together.fallback[i]);
            prop_assert_eq!(state[0], after[i]);
        }
    }
}
