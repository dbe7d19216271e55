//! Cohesive Cam Clay (sheet: constitutive §2.15, V-13, V-14, bad input of §7).

use colluvium_constitutive::laws::cohesive_cam_clay::YieldEllipse;
use colluvium_constitutive::laws::{
    CamClayHardening, CamClayIntegration, CohesiveCamClay, CohesiveCamClaySpec, CohesiveCamClayState,
    Elasticity, StressInvariants,
};
use colluvium_constitutive::{
    Hencky, HenckyState, InitialCondition, Mat3, Model, Motion, Point, PointLaw, PrincipalReturn,
    StressUpdate, SymTensor,
};
use colluvium_testkit::assert_near;

/// Reference set of §2.15.
pub(crate) fn slab() -> CohesiveCamClaySpec {
    CohesiveCamClaySpec {
        density: 250.0,
        youngs_modulus: 5e6,
        poissons_ratio: 0.3,
        critical_state_slope: 0.8,
        cohesion_ratio: 0.1,
        compressive_strength: 10e3,
        hardening_factor: 10.0,
        hardening: CamClayHardening::Slab,
        invariants: StressInvariants::Space,
        integration: CamClayIntegration::Implicit,
        return_initial_stress_to_yield: false,
    }
}

/// Weak layer of V-14.
pub(crate) fn weak_layer() -> CohesiveCamClaySpec {
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

pub(crate) fn fresh(law: &CohesiveCamClay) -> CohesiveCamClayState {
    law.initial(&InitialCondition { stress: SymTensor::ZERO, density: 250.0 }).unwrap().state
}

/// Material of the worked examples W1 and W2 (sheet: snow-mpm §3.9).
fn snow(integration: CamClayIntegration, invariants: StressInvariants) -> CohesiveCamClaySpec {
    CohesiveCamClaySpec {
        youngs_modulus: 3e6,
        critical_state_slope: 1.2,
        cohesion_ratio: 0.3,
        compressive_strength: 20e3,
        hardening_factor: 1.0,
        integration,
        invariants,
        ..slab()
    }
}

#[test]
fn returns_with_explicit_and_implicit_strength_are_those_of_the_sheet() {
    use CamClayIntegration::{Explicit, Implicit};
    // Trial strain, integration, p, q, plastic volumetric strain, p0.
    let table = [
        (
            [-0.006, -0.001, -0.001],
            Explicit,
            16_993.525_485,
            7_887.743_882,
            -0.001_202_589_806,
            23_006.585_908,
        ),
        (
            [-0.006, -0.001, -0.001],
            Implicit,
            18_147.779_532,
            9_075.390_812,
            -0.000_740_888_187,
            21_852.285_397,
        ),
        (
            [0.004, -0.003, -0.0012],
            Explicit,
            1_553.178_261,
            11_198.165_905,
            0.000_421_271_304,
            18_946.789_782,
        ),
        (
            [0.004, -0.003, -0.0012],
            Implicit,
            1_671.948_242,
            10_631.539_405,
            0.000_468_779_297,
            18_828.016_410,
        ),
        ([0.004, 0.002, 0.001], Explicit, -5_725.849_836, 2_519.418_855, 0.004_709_660_066, 8_225.651_350),
        ([0.004, 0.002, 0.001], Implicit, -986.822_565, 488.042_681, 0.006_605_270_974, 3_486.610_368),
        ([-0.004, -0.004, -0.004], Explicit, 20_000.0, 0.0, -0.004, 30_000.506_663),
        ([-0.004, -0.004, -0.004], Implicit, 25_000.101_663, 0.0, -0.001_999_959_335, 25_000.101_663),
        ([0.002, 0.002, 0.002], Explicit, -6_000.0, 0.0, 0.0036, 10_999.822_164),
        ([0.002, 0.002, 0.002], Implicit, -2_142.769_881, 0.0, 0.005_142_892_047, 7_142.566_271),
    ];
    for (trial, integration, p, q, volumetric, p0) in table {
        let law = snow(integration, StressInvariants::Space).law().unwrap();
        let (found, state) = returned(&law, trial, &fresh(&law));
        assert_near(found.pressure(), p, 1e-6);
        assert_near(found.q(), q, 1e-6);
        assert_near(state.volumetric, volumetric, 1e-12);
        assert_near(law.ellipse(&state).strength, p0, 1e-5);
    }
}

/// W2: a full tensor, in space and with invariants of the plane.
#[test]
fn a_step_in_the_plane_is_that_of_the_sheet() {
    use CamClayIntegration::{Explicit, Implicit};
    use StressInvariants::{Plane, Space};
    let deformation = Mat3([[1.002, 0.006, 0.0], [-0.001, 0.995, 0.0], [0.0, 0.0, 1.0]]);
    let motion = Motion::from_deformation(&deformation, 1e-3, 250.0, 1.0).unwrap();
    let jacobian = deformation.determinant();
    for (integration, [xx, xy, yy], p0) in [
        (Explicit, [-2_529.386_846, 4_035.081_754, -13_911.761_183], 20_112.817_001),
        (Implicit, [-2_513.085_335, 4_056.243_147, -13_955.152_858], 20_103.530_478),
    ] {
        let law = snow(integration, Space).law().unwrap();
        let hencky = Hencky(law.clone());
        let start = hencky.initial(&InitialCondition { stress: SymTensor::ZERO, density: 250.0 }).unwrap();
        let end = hencky.update(&motion, &start).unwrap();
        let kirchhoff = end.stress * jacobian;
        for (found, exact) in [(kirchhoff[0], xx), (kirchhoff[3], xy), (kirchhoff[1], yy)] {
            assert_near(found, exact, 2e-6);
        }
        assert_near(law.ellipse(&end.state.inner_state).strength, p0, 2e-6);
        // Work of the plastic strain.
        let dissipated = hencky.dissipation(&motion, &start, &end).unwrap() * jacobian;
        let exact = if integration == Explicit { 18.985_115_688 } else { 18.824_376_249 };
        assert_near(dissipated, exact, 1e-8);
    }
    let material = snow(Explicit, Plane).build().unwrap();
    let start = InitialCondition { stress: SymTensor::ZERO, density: 250.0 };
    let (mut stress, mut states) = material.initial(&[start]).unwrap();
    material.update(&[motion], &mut stress, &mut states.blocks_mut()[0]).unwrap();
    let kirchhoff = stress[0] * jacobian;
    assert_near(kirchhoff[0], -2_508.913_022, 2e-6);
    assert_near(kirchhoff[3], 4_098.018_983, 2e-6);
    assert_near(kirchhoff[1], -14_068.824_057, 2e-6);
    let mut out = [0.0; 4];
    material.outputs(&stress, &states.blocks()[0], &mut out);
    assert_near(out[2], 20_389.567_155, 2e-6);
    // Implicit, by the amendments.
    let law = snow(Implicit, Plane).law().unwrap();
    let landed = snow(Implicit, Plane).build().unwrap();
    let (mut stress, mut states) = landed.initial(&[start]).unwrap();
    landed.update(&[motion], &mut stress, &mut states.blocks_mut()[0]).unwrap();
    landed.outputs(&stress, &states.blocks()[0], &mut out);
    assert_near(out[2], 20_344.315_292, 1e-5);
    assert_near(out[1], -1.193_597_159e-4, 1e-13);
    let kirchhoff = stress[0] * jacobian;
    assert_near(-0.5 * (kirchhoff[0] + kirchhoff[1]), 8_334.119_275, 1e-5);
    assert!(law.initial_strain() < 0.0);
}

/// Return of a principal trial strain: invariants and state.
pub(crate) fn returned(
    law: &CohesiveCamClay,
    strain: [f64; 3],
    state: &CohesiveCamClayState,
) -> (SymTensor, CohesiveCamClayState) {
    let trial = stress(law.elasticity(), strain);
    let (found, state) = law.return_principal([trial[0], trial[1], trial[2]], state).unwrap();
    (SymTensor::diagonal(found[0], found[1], found[2]), state)
}

/// Trial strain, p and q of the trial (Pa), p and q (Pa), Δγ, elastic strain, plastic volumetric strain.
type Row = ([f64; 3], [f64; 2], [f64; 2], f64, [f64; 3], f64);

/// Returns to the ellipse of the sheet.
const RETURNS: [Row; 5] = [
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

#[test]
fn returns_at_fixed_strength() {
    let elasticity = Elasticity::new(5e6, 0.3).unwrap();
    assert_near(elasticity.bulk_modulus, 4_166_666.7, 0.05);
    assert_near(elasticity.shear_modulus, 1_923_076.9, 0.05);
    let ellipse = YieldEllipse { slope: 0.8, cohesion_ratio: 0.1, strength: 10e3 };
    let trial = |strain: [f64; 3]| {
        let trial = stress(&elasticity, strain);
        (trial, trial.pressure(), trial.q())
    };
    let (_, p, q) = trial([-5e-4, -4e-4, -3e-4]);
    assert_near(p, 5000.0, 1e-9);
    assert_near(q, 666.173, 5.1e-4);
    let f = ellipse.yield_value(p, q);
    // y is f times the sum of the terms whose difference is f.
    let radius = 0.5 * 0.8 * 1.1 * 10e3;
    assert_near(f * (f + 2.0 * radius), -1.866_75e7, 51.0);
    assert_eq!(ellipse.return_map(&elasticity, p, q).multiplier, 0.0);
    for (strain, at_trial, at_end, multiplier, elastic, volumetric) in RETURNS {
        let (trial, p, q) = trial(strain);
        assert_near(p, at_trial[0], 5.1e-4);
        assert_near(q, at_trial[1], 5.1e-4);
        let found = ellipse.return_map(&elasticity, p, q);
        assert_near(found.pressure, at_end[0], 5.1e-6);
        assert_near(found.q, at_end[1], 5.1e-6);
        assert_near(found.multiplier, multiplier, 5.1e-15);
        assert_near(found.volumetric, volumetric, 5.1e-12);
        let shrink = if q > 1e-6 { found.q / q } else { 0.0 };
        let stress = trial.deviator() * shrink - SymTensor::isotropic(found.pressure);
        for c in 0..3 {
            assert_near(elasticity.strain(&stress)[c], elastic[c], 5.1e-12);
        }
        assert_near(ellipse.yield_value(found.pressure, found.q), 0.0, 1e-10);
    }
}

#[test]
fn the_ellipse_has_the_tips_and_top_of_the_sheet() {
    let (m, beta, p0) = (0.8, 0.1, 10e3);
    let ellipse = YieldEllipse { slope: m, cohesion_ratio: beta, strength: p0 };
    let top = m * p0 * (1.0 + beta) / (2.0 * (1.0 + 2.0 * beta).sqrt());
    let points = [
        (p0, 0.0),
        (-beta * p0, 0.0),
        (0.5 * (1.0 - beta) * p0, top),
        (0.0, m * p0 * (beta / (1.0 + 2.0 * beta)).sqrt()),
    ];
    for (p, q) in points {
        assert_near(ellipse.yield_value(p, q), 0.0, 1e-11);
    }
}

#[test]
fn hardening_is_solved_with_the_return() {
    let law = slab().law().unwrap();
    let state = fresh(&law);
    assert_near(state.hardening_strain, -2.399_997_696_0e-4, 5.1e-15);

    let (stress, new) = returned(&law, [-3e-3; 3], &state);
    assert_near(new.volumetric, -5.999_912_293_5e-4, 5.1e-15);
    assert_near(stress.pressure(), 35_000.036_5, 5.1e-5);
    assert_near(law.ellipse(&new).strength, 35_000.036_5, 5.1e-5);
    assert_eq!(stress.q(), 0.0);

    let (stress, new) = returned(&law, [-8e-3, -1e-3, 0.0], &state);
    assert_near(new.volumetric, -8.888_219_439_7e-4, 5.1e-15);
    assert_near(stress.pressure(), 33_796.575_2, 5.1e-5);
    assert_near(stress.q(), 16_487.405_9, 5.1e-5);
    let ellipse = law.ellipse(&new);
    assert_near(ellipse.strength, 47_035.237_0, 5.1e-5);
    let trial = self::stress(law.elasticity(), [-8e-3, -1e-3, 0.0]);
    let multiplier = ellipse.return_map(law.elasticity(), trial.pressure(), trial.q()).multiplier;
    assert_near(multiplier, 5.497_645_58e-8, 5.1e-17);

    let (stress, new) = returned(&law, [2e-3, 1e-3, 0.0], &state);
    assert_eq!(stress, SymTensor::ZERO);
    assert_eq!(law.ellipse(&new).strength, 0.0);
    assert_near(new.volumetric, 3e-3, 1e-17);

    // With the strength frozen at the start of the step it would jump far beyond.
    let frozen = law.ellipse(&state).return_map(law.elasticity(), 37_500.0, 0.0).volumetric;
    let jump = CohesiveCamClayState { hardening_strain: state.hardening_strain + frozen, ..state };
    assert_near(law.ellipse(&jump).strength, 285_222.0, 0.5);
}

#[test]
fn a_gap_must_close_before_packing_carries_load() {
    let law = slab().law().unwrap();
    let (_, open) = returned(&law, [1e-3; 3], &fresh(&law));
    assert_near(open.hardening_strain, 3e-3 - 2.399_997_696_0e-4, 5.1e-15);
    let (stress, closing) = returned(&law, [-5e-4; 3], &open);
    assert_eq!(stress, SymTensor::ZERO);
    let (stress, closed) = returned(&law, [-1e-3; 3], &closing);
    assert!(stress.pressure() > 0.0 && closed.hardening_strain < 0.0);
}

type Layer = Hencky<CohesiveCamClay>;

/// Compresses a layer to the logarithmic volumetric compression `total`; returns pressure in `τ` and state at
/// every step.
pub(crate) fn compressed(
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
fn tangents_agree_with_differences_on_every_branch() {
    // Elastic, hardening, softening, stress-free, compacting debris in the step of the collapse.
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
                assert_near(block[a][b], slope, 1e-6 * law.elasticity().p_wave_modulus());
            }
        }
    }
}

#[test]
fn random_returns_lie_on_the_surface_by_associated_flow() {
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
            assert_near(k * volumetric, p - at_trial.pressure(), 1e-9 * scale);
            assert_near(3.0 * mu * (new.deviatoric - state.deviatoric), at_trial.q() - q, 1e-9 * scale);
            // Flow along the normal: the return of the trial to the surface at the end.
            let flowed = new != state && p.hypot(q) > 0.0 && new.collapsed == state.collapsed;
            if flowed {
                let again = ellipse.return_map(law.elasticity(), at_trial.pressure(), at_trial.q());
                assert_near(again.pressure, p, 1e-8 * scale);
                assert_near(again.q, q, 1e-8 * scale);
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
        (
            CohesiveCamClaySpec { compressive_strength: 1e12, ..slab() },
            "compressive_strength: 1000000000000 must be below",
        ),
        (CohesiveCamClaySpec { youngs_modulus: -1.0, ..slab() }, "youngs_modulus: -1"),
        (CohesiveCamClaySpec { poissons_ratio: 0.5, ..slab() }, "poissons_ratio: 0.5"),
    ] {
        let error = refused(spec);
        assert!(error.starts_with(message), "{error}");
    }
    let snap = CohesiveCamClaySpec { hardening: weak(3.0), ..weak_layer() };
    assert!(snap.warnings()[0].text.starts_with("hardening.softening_factor: 3"));
    let outside = InitialCondition { stress: SymTensor::isotropic(-11e3), density: 250.0 };
    let error = PointLaw::initial(&slab().law().unwrap(), &outside).unwrap_err().to_string();
    assert!(error.contains("outside the yield surface"), "{error}");
}

#[test]
fn an_initial_stress_outside_is_returned_to_the_surface_on_request() {
    let law = CohesiveCamClaySpec { return_initial_stress_to_yield: true, ..slab() }.law().unwrap();
    let initial = |stress| PointLaw::initial(&law, &InitialCondition { stress, density: 250.0 }).unwrap();
    // The hydrostatic and the shear trial of §2.15, at frozen p0.
    let trial = stress(&slab().law().unwrap().elasticity().clone(), [-8e-3, -1e-3, 0.0]);
    let moved = initial(trial);
    assert!((moved.stress.pressure() - 9_398.175_58).abs() < 1e-4);
    assert!((moved.stress.q() - 1_826.891_85).abs() < 1e-4);
    let inside = SymTensor::isotropic(-5e3);
    assert_eq!(initial(inside).stress, inside);
}
