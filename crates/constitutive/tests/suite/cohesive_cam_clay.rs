//! Cohesive Cam Clay (constitutive sheet §2.15, V-13, V-14, bad input of §7).

use crate::common::near;
use colluvium_constitutive::laws::cohesive_cam_clay::Ellipse;
use colluvium_constitutive::laws::{
    CamClayHardening, CamClayInvariants, CohesiveCamClay, CohesiveCamClaySpec, CohesiveCamClayState,
    Elasticity,
};
use colluvium_constitutive::{
    Hencky, HenckyState, InitialCondition, Mat3, Model, Motion, Point, PrincipalReturn, SmallStrain,
    StressUpdate, SymTensor,
};

/// The reference set of §2.15.
fn slab() -> CohesiveCamClaySpec {
    CohesiveCamClaySpec {
        density: 250.0,
        youngs_modulus: 5e6,
        poissons_ratio: 0.3,
        critical_state_slope: 0.8,
        cohesion_ratio: 0.1,
        compressive_strength: 10e3,
        hardening_factor: 10.0,
        hardening: CamClayHardening::Slab,
        invariants: CamClayInvariants::Space,
        project: false,
    }
}

/// The weak layer of V-14.
fn weak_layer() -> CohesiveCamClaySpec {
    CohesiveCamClaySpec {
        youngs_modulus: 1e6,
        compressive_strength: 2e3,
        hardening_factor: 0.5,
        hardening: CamClayHardening::WeakLayer { softening_factor: 1.0 },
        ..slab()
    }
}

fn stress(elasticity: &Elasticity, strain: [f64; 3]) -> SymTensor {
    elasticity.stress(&SymTensor::diagonal(strain[0], strain[1], strain[2]))
}

fn fresh(law: &CohesiveCamClay) -> CohesiveCamClayState {
    law.initial(&InitialCondition { stress: SymTensor::ZERO, density: 250.0 }).unwrap().state
}

/// Return of a principal trial strain: invariants and state.
fn returned(
    law: &CohesiveCamClay,
    strain: [f64; 3],
    state: &CohesiveCamClayState,
) -> (SymTensor, CohesiveCamClayState) {
    let trial = stress(law.elasticity(), strain);
    let (found, state) = law.return_principal([trial[0], trial[1], trial[2]], state).unwrap();
    (SymTensor::diagonal(found[0], found[1], found[2]), state)
}

#[test]
fn returns_at_fixed_strength() {
    let elasticity = Elasticity::new(5e6, 0.3).unwrap();
    near(elasticity.bulk_modulus, 4_166_666.7, 0.05);
    near(elasticity.shear_modulus, 1_923_076.9, 0.05);
    let ellipse = Ellipse { slope: 0.8, cohesion_ratio: 0.1, strength: 10e3 };
    let trial = |strain: [f64; 3]| {
        let trial = stress(&elasticity, strain);
        (trial, trial.pressure(), trial.q())
    };
    let (_, p, q) = trial([-5e-4, -4e-4, -3e-4]);
    near(p, 5000.0, 1e-9);
    near(q, 666.173, 5.1e-4);
    let f = ellipse.yield_value(p, q);
    // y is f times the sum of the terms whose difference f is.
    let radius = 0.5 * 0.8 * 1.1 * 10e3;
    near(f * (f + 2.0 * radius), -1.866_75e7, 51.0);
    assert_eq!(ellipse.return_map(&elasticity, p, q).multiplier, 0.0);

    // Trial, p and q of the trial, p, q, Δγ, elastic strain, plastic volumetric strain.
    type Row = ([f64; 3], [f64; 2], [f64; 2], f64, [f64; 3], f64);
    let rows: [Row; 5] = [
        (
            [-8e-3, -1e-3, 0.0],
            [37_500.0, 29_037.825],
            [9_398.175_58, 1_826.891_85],
            1.075_725_439_0e-6,
            [-1.066_425_11e-3, -6.260_256_23e-4, -5.631_114_11e-4],
            -6.744_437_86e-3,
        ),
        ([-3e-3; 3], [37_500.0, 0.0], [10_000.0, 0.0], 9.375e-7, [-8e-4; 3], -6.6e-3),
        (
            [2e-3, 1e-3, 0.0],
            [-12_500.0, 6_661.734],
            [-828.153_121, 996.201_939],
            4.107_373_118_1e-7,
            [2.157_931_89e-4, 6.625_224_97e-5, -8.328_868_93e-5],
            2.801_243_25e-3,
        ),
        ([1e-3; 3], [-12_500.0, 0.0], [-1_000.0, 0.0], 3.920_454_5e-7, [8e-5; 3], 2.76e-3),
        (
            [4e-3, -2.2e-3, -2.3e-3],
            [2_083.333, 24_040.769],
            [3_679.772_91, 3_971.715_16],
            3.649_384_748_1e-7,
            [3.939_827_16e-4, -6.303_037_33e-4, -6.468_244_82e-4],
            3.831_455_00e-4,
        ),
    ];
    for (strain, at_trial, at_end, multiplier, elastic, volumetric) in rows {
        let (trial, p, q) = trial(strain);
        near(p, at_trial[0], 5.1e-4);
        near(q, at_trial[1], 5.1e-4);
        let found = ellipse.return_map(&elasticity, p, q);
        near(found.pressure, at_end[0], 5.1e-6);
        near(found.q, at_end[1], 5.1e-6);
        near(found.multiplier, multiplier, 5.1e-15);
        near(found.volumetric, volumetric, 5.1e-12);
        let shrink = if q > 1e-6 { found.q / q } else { 0.0 };
        let stress = trial.deviator() * shrink - SymTensor::isotropic(found.pressure);
        for c in 0..3 {
            near(elasticity.strain(&stress)[c], elastic[c], 5.1e-12);
        }
        near(ellipse.yield_value(found.pressure, found.q), 0.0, 1e-10);
    }
}

#[test]
fn the_ellipse_has_the_tips_and_top_of_the_sheet() {
    let (m, beta, p0) = (0.8, 0.1, 10e3);
    let ellipse = Ellipse { slope: m, cohesion_ratio: beta, strength: p0 };
    let top = m * p0 * (1.0 + beta) / (2.0 * (1.0 + 2.0 * beta).sqrt());
    let points = [
        (p0, 0.0),
        (-beta * p0, 0.0),
        (0.5 * (1.0 - beta) * p0, top),
        (0.0, m * p0 * (beta / (1.0 + 2.0 * beta)).sqrt()),
    ];
    for (p, q) in points {
        near(ellipse.yield_value(p, q), 0.0, 1e-11);
    }
}

#[test]
fn hardening_is_solved_with_the_return() {
    let law = slab().law().unwrap();
    let state = fresh(&law);
    near(state.hardening_strain, -2.399_997_696_0e-4, 5.1e-15);

    let (stress, new) = returned(&law, [-3e-3; 3], &state);
    near(new.volumetric, -5.999_912_293_5e-4, 5.1e-15);
    near(stress.pressure(), 35_000.036_5, 5.1e-5);
    near(law.ellipse(&new).strength, 35_000.036_5, 5.1e-5);
    assert_eq!(stress.q(), 0.0);

    let (stress, new) = returned(&law, [-8e-3, -1e-3, 0.0], &state);
    near(new.volumetric, -8.888_219_439_7e-4, 5.1e-15);
    near(stress.pressure(), 33_796.575_2, 5.1e-5);
    near(stress.q(), 16_487.405_9, 5.1e-5);
    let ellipse = law.ellipse(&new);
    near(ellipse.strength, 47_035.237_0, 5.1e-5);
    let trial = self::stress(law.elasticity(), [-8e-3, -1e-3, 0.0]);
    let multiplier = ellipse.return_map(law.elasticity(), trial.pressure(), trial.q()).multiplier;
    near(multiplier, 5.497_645_58e-8, 5.1e-17);

    let (stress, new) = returned(&law, [2e-3, 1e-3, 0.0], &state);
    assert_eq!(stress, SymTensor::ZERO);
    assert_eq!(law.ellipse(&new).strength, 0.0);
    near(new.volumetric, 3e-3, 1e-17);

    // Frozen at the start of the step the strength would jump far beyond.
    let frozen = law.ellipse(&state).return_map(law.elasticity(), 37_500.0, 0.0).volumetric;
    let jump = CohesiveCamClayState { hardening_strain: state.hardening_strain + frozen, ..state };
    near(law.ellipse(&jump).strength, 285_222.0, 0.5);
}

#[test]
fn a_gap_must_close_before_packing_carries_load() {
    let law = slab().law().unwrap();
    let (_, open) = returned(&law, [1e-3; 3], &fresh(&law));
    near(open.hardening_strain, 3e-3 - 2.399_997_696_0e-4, 5.1e-15);
    let (stress, closing) = returned(&law, [-5e-4; 3], &open);
    assert_eq!(stress, SymTensor::ZERO);
    let (stress, closed) = returned(&law, [-1e-3; 3], &closing);
    assert!(stress.pressure() > 0.0 && closed.hardening_strain < 0.0);
}

type Layer = Hencky<CohesiveCamClay>;

/// Drives a layer to the logarithmic volumetric compression `total` and returns pressure in `τ` and state at
/// every step.
fn compressed(
    law: &Layer,
    total: f64,
    steps: usize,
) -> Vec<(f64, f64, Point<HenckyState<CohesiveCamClayState>>)> {
    let mut point = law.initial(&InitialCondition { stress: SymTensor::ZERO, density: 250.0 }).unwrap();
    let stretch = (-total / (3 * steps) as f64).exp();
    let motion = Motion::from_deformation(&(Mat3::IDENTITY * stretch), 1.0, 250.0, 1.0).unwrap();
    (1..=steps)
        .map(|step| {
            point = law.update(&motion, &point).unwrap();
            let strain = total * step as f64 / steps as f64;
            (strain, point.stress.pressure() * point.state.jacobian, point.clone())
        })
        .collect()
}

#[test]
fn a_weak_layer_softens_collapses_and_packs() {
    let law = Hencky(weak_layer().law().unwrap());
    let bulk = law.0.elasticity().bulk_modulus;
    near(bulk, 833_333.3, 0.05);
    let path = compressed(&law, 0.02, 2000);
    let at = |strain: f64| {
        let below = path.partition_point(|(e, ..)| *e < strain - 1e-12);
        let (e, p, _) = &path[below];
        let (e0, p0, _) = &path[below.saturating_sub(1)];
        if below == 0 { *p } else { p0 + (p - p0) * (strain - e0) / (e - e0) }
    };
    // The sheet's tolerance, 10⁻³ with 2000 steps.
    near(at(0.0024), 2000.0, 2.0);
    near(at(0.0030), 1500.0, 1.5);
    near(at(0.004_799_995_4), 0.0, 2.0);
    near(at(0.006_299_995_4), 416.667, 0.417);
    near(at(0.0198), 4_166.684, 4.17);
    // β goes at the switch, and only there.
    let switch = path.iter().position(|(.., point)| point.state.inner.collapsed).unwrap();
    let (before, after) = (&path[switch - 1].2, &path[switch].2);
    assert_eq!(law.0.ellipse(&before.state.inner).cohesion_ratio, 0.1);
    assert_eq!(law.0.ellipse(&after.state.inner).cohesion_ratio, 0.0);
    near(path[switch].0, 0.004_799_995_4, 0.02 / 2000.0);
}

#[test]
fn a_weak_layer_follows_its_closed_form_whatever_the_step() {
    // Stable (1, 0.5) and snapping (50, 2) layers; the state at the end, not the path, is checked.
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
                near(found, p, 1e-9 * p);
                assert!(point.state.inner.collapsed);
            }
        }
    }
}

#[test]
fn a_layer_torn_apart_collapses_too() {
    let law = weak_layer().law().unwrap();
    let (stress, state) = returned(&law, [4e-3, 2e-3, 1e-3], &fresh(&law));
    assert_eq!(stress, SymTensor::ZERO);
    assert!(state.collapsed);
    // What is left after the collapse opens a gap.
    near(state.hardening_strain, 7e-3 - 0.004_799_995_4, 1e-10);
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

#[test]
fn tangents_hold_on_every_branch() {
    // Elastic, hardening, softening, without stress, packing debris in the step of the collapse.
    let cases = [
        (slab(), [-8e-3, -1e-3, 0.0]),
        (slab(), [4e-3, -2.2e-3, -2.3e-3]),
        (slab(), [2e-3, 1e-3, 0.0]),
        (weak_layer(), [-2e-3, -1e-3, -0.5e-3]),
        (weak_layer(), [-2e-3, -4e-3, -3e-3]),
        (weak_layer(), [-3e-3, -2e-3, -6e-3]),
    ];
    for (spec, strain) in cases {
        let law = spec.law().unwrap();
        let state = fresh(&law);
        let trial = |strain: [f64; 3]| {
            let trial = stress(law.elasticity(), strain);
            [trial[0], trial[1], trial[2]]
        };
        let block = law.principal_tangent(trial(strain), &state).unwrap();
        let h = 1e-8;
        for b in 0..3 {
            let moved = |h: f64| {
                let mut strain = strain;
                strain[b] += h;
                law.return_principal(trial(strain), &state).unwrap().0
            };
            let (plus, minus) = (moved(h), moved(-h));
            for a in 0..3 {
                let slope = (plus[a] - minus[a]) / (2.0 * h);
                near(block[a][b], slope, 1e-6 * law.elasticity().p_wave_modulus());
            }
        }
    }
}

#[test]
fn random_returns_land_on_their_surface_by_associated_flow() {
    let mut seed = 11u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    for case in 0..20_000 {
        let spec = CohesiveCamClaySpec {
            critical_state_slope: 0.1 + 2.0 * random(),
            cohesion_ratio: if case % 5 == 0 { 0.0 } else { 3.0 * random() * random() },
            compressive_strength: 10f64.powf(1.0 + 5.0 * random()),
            hardening_factor: 10f64.powf(-1.0 + 3.0 * random()),
            hardening: if case % 2 == 0 {
                CamClayHardening::Slab
            } else {
                CamClayHardening::WeakLayer { softening_factor: 10f64.powf(-1.0 + 3.0 * random()) }
            },
            ..slab()
        };
        let law = spec.law().unwrap();
        let (k, mu) = (law.elasticity().bulk_modulus, law.elasticity().shear_modulus);
        let mut state = fresh(&law);
        let mut elastic = [0.0; 3];
        for _ in 0..4 {
            let size = 10f64.powf(-5.0 + 4.5 * random());
            let trial: [f64; 3] = elastic.map(|e| e + size * (2.0 * random() - 1.0));
            let at_trial = stress(law.elasticity(), trial);
            let (found, new) = returned(&law, trial, &state);
            let (p, q) = (found.pressure(), found.q());
            let scale = at_trial.norm() + 1e3;
            let ellipse = law.ellipse(&new);
            let excess = ellipse.yield_value(p, q);
            assert!(excess <= 1e-9 * scale, "{spec:?}: f = {excess}");
            let volumetric = new.volumetric - state.volumetric;
            near(k * volumetric, p - at_trial.pressure(), 1e-9 * scale);
            near(3.0 * mu * (new.deviatoric - state.deviatoric), at_trial.q() - q, 1e-9 * scale);
            // Flow along the normal: the return of the trial to the surface of the end.
            let flowed = new != state && p.hypot(q) > 0.0 && new.collapsed == state.collapsed;
            if flowed {
                let again = ellipse.return_map(law.elasticity(), at_trial.pressure(), at_trial.q());
                near(again.pressure, p, 1e-8 * scale);
                near(again.q, q, 1e-8 * scale);
            }
            let kept = law.elasticity().strain(&found);
            (elastic, state) = ([kept[0], kept[1], kept[2]], new);
        }
    }
}

#[test]
fn parameters_out_of_range_are_named() {
    let refused = |spec: CohesiveCamClaySpec| spec.law().unwrap_err().to_string();
    let weak = |softening_factor| CamClayHardening::WeakLayer { softening_factor };
    for (spec, message) in [
        (CohesiveCamClaySpec { critical_state_slope: 0.0, ..slab() }, "critical_state_slope: 0"),
        (CohesiveCamClaySpec { cohesion_ratio: -0.1, ..slab() }, "cohesion_ratio: -0.1"),
        (CohesiveCamClaySpec { hardening_factor: 0.0, ..slab() }, "hardening_factor: 0"),
        (CohesiveCamClaySpec { hardening: weak(0.0), ..slab() }, "hardening.softening_factor: 0"),
        (CohesiveCamClaySpec { compressive_strength: 0.0, ..slab() }, "compressive_strength: 0"),
        (CohesiveCamClaySpec { compressive_strength: f64::NAN, ..slab() }, "compressive_strength: NaN"),
        (CohesiveCamClaySpec { youngs_modulus: -1.0, ..slab() }, "youngs_modulus: -1"),
        (CohesiveCamClaySpec { poissons_ratio: 0.5, ..slab() }, "poissons_ratio: 0.5"),
    ] {
        let error = refused(spec);
        assert!(error.starts_with(message), "{error}");
    }
    let snap = CohesiveCamClaySpec { hardening: weak(3.0), ..weak_layer() };
    assert!(snap.warnings()[0].starts_with("hardening.softening_factor: 3"));
    let outside = InitialCondition { stress: SymTensor::isotropic(-11e3), density: 250.0 };
    let error = SmallStrain::initial(&slab().law().unwrap(), &outside).unwrap_err().to_string();
    assert!(error.contains("outside the yield surface"), "{error}");
}

#[test]
fn an_initial_stress_outside_is_moved_to_the_surface_on_wish() {
    let law = CohesiveCamClaySpec { project: true, ..slab() }.law().unwrap();
    let initial = |stress| SmallStrain::initial(&law, &InitialCondition { stress, density: 250.0 }).unwrap();
    // The hydrostatic and the shear trial of §2.15, at frozen p0.
    let trial = stress(&slab().law().unwrap().elasticity().clone(), [-8e-3, -1e-3, 0.0]);
    let moved = initial(trial);
    assert!((moved.stress.pressure() - 9_398.175_58).abs() < 1e-4);
    assert!((moved.stress.q() - 1_826.891_85).abs() < 1e-4);
    let inside = SymTensor::isotropic(-5e3);
    assert_eq!(initial(inside).stress, inside);
}

/// Invariants of the plane, d = 2.
mod plane {
    use super::*;

    fn walk(motions: &[Mat3]) -> (SymTensor, f64) {
        let spec = CohesiveCamClaySpec { invariants: CamClayInvariants::Plane, ..slab() };
        let law = spec.build().unwrap();
        let start = InitialCondition { stress: SymTensor::ZERO, density: 250.0 };
        let (mut stresses, mut states) = law.initial(&[start]).unwrap();
        for f in motions {
            let motion = Motion::from_deformation(f, 1.0, 250.0, 1.0).unwrap();
            law.update(&[motion], &mut stresses, &mut states.blocks_mut()[0]).unwrap();
        }
        let mut value = [0.0];
        law.yield_values(&stresses, &states.blocks()[0], &mut value);
        (stresses[0], value[0])
    }

    fn diagonal(x: f64, y: f64) -> Mat3 {
        Mat3([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, 1.0]])
    }

    #[test]
    fn elastic_stress_has_the_bulk_modulus_of_the_plane() {
        let (x, y) = ((-4e-4f64).exp(), (-2e-4f64).exp());
        let (found, value) = walk(&[diagonal(x, y)]);
        let (lame, mu) = (5e6 * 0.3 / (1.3 * 0.4), 5e6 / 2.6);
        // K = λ + μ.
        let pressure = (lame + mu) * 6e-4;
        let jacobian = x * y;
        assert!((found[0] * jacobian - (-pressure - 2.0 * mu * 1e-4)).abs() < 1e-8);
        assert!((found[1] * jacobian - (-pressure + 2.0 * mu * 1e-4)).abs() < 1e-8);
        assert!(value < 0.0);
        // q of the plane, √(3/2 s:s) with the two deviators ±2μ·10⁻⁴.
        assert!((found.q() * jacobian - 3f64.sqrt() * 2.0 * mu * 1e-4).abs() < 1e-8);
    }

    #[test]
    fn isotropic_compaction_follows_the_closed_form() {
        // p = K sinh(ξ (x0 + x)), strain = x + p/K beyond p0/K.
        let modulus: f64 = 5e6 * 0.3 / (1.3 * 0.4) + 5e6 / 2.6;
        let x0 = (10e3 / modulus).asinh() / 10.0;
        let (plastic, steps): (f64, u32) = (1e-3, 50);
        let pressure = modulus * (10.0 * (x0 + plastic)).sinh();
        let strain = plastic + pressure / modulus;
        let part = (-0.5 * strain / f64::from(steps)).exp();
        let (found, value) = walk(&vec![diagonal(part, part); steps as usize]);
        let kirchhoff = found.pressure() * (-strain).exp();
        assert!((kirchhoff / pressure - 1.0).abs() < 1e-9, "{kirchhoff} for {pressure}");
        assert!(value.abs() < 1e-9 * pressure);
    }

    #[test]
    fn a_turned_observer_sees_the_turned_stress() {
        let path = [
            Mat3([[0.995, 0.004, 0.0], [0.0, 1.001, 0.0], [0.0, 0.0, 1.0]]),
            Mat3([[1.002, 0.01, 0.0], [-0.003, 0.97, 0.0], [0.0, 0.0, 1.0]]),
        ];
        let q = Mat3::rotation_z(0.7);
        let (here, _) = walk(&path);
        let (there, value) = walk(&path.map(|f| q * f * q.transpose()));
        assert!((there - here.rotated(&q)).norm() < 1e-12 * 5e6 * 0.03);
        assert!(value < 1e-9 * 1e3);
    }

    #[test]
    fn motions_out_of_the_plane_are_refused() {
        let spec = CohesiveCamClaySpec { invariants: CamClayInvariants::Plane, ..slab() };
        let law = spec.build().unwrap();
        let start = InitialCondition { stress: SymTensor::ZERO, density: 250.0 };
        let (mut stresses, mut states) = law.initial(&[start]).unwrap();
        let f = Mat3([[1.0, 0.0, 1e-3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let motion = Motion::from_deformation(&f, 1.0, 250.0, 1.0).unwrap();
        let refused = law.update(&[motion], &mut stresses, &mut states.blocks_mut()[0]);
        assert!(refused.unwrap_err().to_string().contains("leaves the plane"));
    }
}
