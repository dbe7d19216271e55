//! Weak layers of snow: cohesive Cam Clay that softens, collapses and packs (sheet: constitutive §2.15, V-14).

use colluvium_constitutive::laws::{CamClayHardening, CohesiveCamClaySpec};
use colluvium_constitutive::{
    Hencky, InitialCondition, Mat3, Model, Motion, PointLaw, PrincipalReturn, StressUpdate, SymTensor,
};
use colluvium_testkit::assert_near;

use crate::cohesive_cam_clay::{compressed, fresh, returned, weak_layer};

#[test]
fn a_weak_layer_softens_collapses_and_packs() {
    let law = Hencky(weak_layer().law().unwrap());
    let bulk = law.0.elasticity().bulk_modulus;
    assert_near(bulk, 833_333.3, 0.05);
    let path = compressed(&law, 0.02, 2000);
    let at = |strain: f64| {
        let below = path.partition_point(|(e, ..)| *e < strain - 1e-12);
        let (e, p, _) = &path[below];
        let (e0, p0, _) = &path[below.saturating_sub(1)];
        if below == 0 { *p } else { p0 + (p - p0) * (strain - e0) / (e - e0) }
    };
    // The sheet's tolerance, 10⁻³ with 2000 steps.
    assert_near(at(0.0024), 2000.0, 2.0);
    assert_near(at(0.0030), 1500.0, 1.5);
    assert_near(at(0.004_799_995_4), 0.0, 2.0);
    assert_near(at(0.006_299_995_4), 416.667, 0.417);
    assert_near(at(0.0198), 4_166.684, 4.17);
    // β vanishes at the collapse, and only there.
    let switch = path.iter().position(|(.., point)| point.state.inner_state.collapsed).unwrap();
    let (before, after) = (&path[switch - 1].2, &path[switch].2);
    assert_eq!(law.0.ellipse(&before.state.inner_state).cohesion_ratio, 0.1);
    assert_eq!(law.0.ellipse(&after.state.inner_state).cohesion_ratio, 0.0);
    assert_near(path[switch].0, 0.004_799_995_4, 0.02 / 2000.0);
}

#[test]
fn a_weak_layer_follows_its_closed_form_for_any_step() {
    // Stable (1, 0.5) and collapsing (50, 2) layers; the state at the end, not the path, is checked.
    for (softening_factor, hardening_factor, exact_at) in [(1.0, 0.5, true), (50.0, 2.0, false)] {
        let spec = CohesiveCamClaySpec {
            hardening: CamClayHardening::WeakLayer { softening_factor },
            hardening_factor,
            ..weak_layer()
        };
        assert_eq!(spec.warnings().is_empty(), exact_at);
        let law = Hencky(spec.law().unwrap());
        let bulk = law.0.elasticity().bulk_modulus;
        let start = (2e3 / bulk).asinh() / hardening_factor;
        for y in [1e-3, 1e-2] {
            let p = bulk * (hardening_factor * y).sinh();
            let total = start / softening_factor + y + p / bulk;
            for steps in [1, 7, 500] {
                let (_, found, point) = compressed(&law, total, steps).pop().unwrap();
                assert_near(found, p, 1e-9 * p);
                assert!(point.state.inner_state.collapsed);
            }
        }
    }
}

#[test]
fn a_layer_loaded_in_tension_collapses() {
    let law = weak_layer().law().unwrap();
    let (stress, state) = returned(&law, [4e-3, 2e-3, 1e-3], &fresh(&law));
    assert_eq!(stress, SymTensor::ZERO);
    assert!(state.collapsed);
    // The rest of the strain after the collapse opens a gap.
    assert_near(state.hardening_strain, 7e-3 - 0.004_799_995_4, 1e-10);
}

#[test]
fn uniaxial_compression_drops_in_the_weak_layer_and_hardens_in_the_slab() {
    let drive = |spec: CohesiveCamClaySpec| {
        let law = Hencky(spec.law().unwrap());
        let mut point = law.initial(&InitialCondition { stress: SymTensor::ZERO, density: 250.0 }).unwrap();
        let mut f = Mat3::IDENTITY;
        f.0[2][2] = (-1e-5f64).exp();
        let motion = Motion::from_deformation(&f, 1.0, 250.0, 1.0).unwrap();
        (0..700)
            .map(|_| {
                point = law.update(&motion, &point).unwrap();
                (point.stress.pressure(), point.stress.q())
            })
            .collect::<Vec<_>>()
    };
    let slab = drive(CohesiveCamClaySpec { hardening: CamClayHardening::Slab, ..weak_layer() });
    let weak = drive(weak_layer());
    let top =
        |path: &[(f64, f64)]| path.iter().fold((0.0, 0.0), |m: (f64, f64), v| (m.0.max(v.0), m.1.max(v.1)));
    let (end_of_slab, end_of_weak) = (slab[699], weak[699]);
    let (top_of_slab, top_of_weak) = (top(&slab), top(&weak));
    assert_eq!(end_of_slab.0, top_of_slab.0);
    assert!(end_of_weak.0 < 0.5 * top_of_weak.0 && end_of_weak.1 < 0.5 * top_of_weak.1);
}
