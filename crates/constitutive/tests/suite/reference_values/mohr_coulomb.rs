//! Pyramids of Mohr–Coulomb and Tresca, and the tension cut-off.

use colluvium_constitutive::laws::mohr_coulomb::{Pyramid, YieldRegion};
use colluvium_constitutive::laws::{MohrCoulombSpec, multi_surface};
use colluvium_constitutive::{
    Hencky, InitialCondition, Mat3, MaterialSpec, Motion, Point, PointLaw, PrincipalReturn, SymTensor,
};
use colluvium_testkit::assert_close;

use super::returned;
use crate::reference_materials::r1;

fn mohr_coulomb(dilatancy_angle: f64) -> MohrCoulombSpec {
    crate::reference_materials::mohr_coulomb(1.0, dilatancy_angle)
}

#[test]
fn mohr_coulomb_returns_to_plane_edges_and_apex() {
    let pyramid = |psi: f64| Pyramid::new(30f64.to_radians(), 10.0, psi.to_radians());
    let table = [
        ([-50.0, -120.0, -400.0], 0.0, YieldRegion::Plane, [-103.8397, -120.0, -346.1603], 1e-4),
        (
            [-50.0, -120.0, -400.0],
            10.0,
            YieldRegion::Plane,
            [-113.441_955_45, -131.522_651_39, -374.966_882_51],
            1e-8,
        ),
        ([-50.0, -120.0, -400.0], 30.0, YieldRegion::Plane, [-124.5473, -144.8491, -408.2830], 1e-4),
        ([-40.0, -45.0, -400.0], 0.0, YieldRegion::CompressionEdge, [-90.0718, -90.0718, -304.8564], 1e-4),
        (
            [-40.0, -45.0, -400.0],
            10.0,
            YieldRegion::CompressionEdge,
            [-107.349_438_5, -107.349_438_5, -356.689_331_64],
            1e-8,
        ),
        ([-40.0, -45.0, -400.0], 30.0, YieldRegion::CompressionEdge, [-126.4502, -126.4502, -413.9917], 1e-4),
        ([-20.0, -300.0, -310.0], 0.0, YieldRegion::ExtensionEdge, [-80.1026, -274.9487, -274.9487], 1e-4),
        (
            [-20.0, -300.0, -310.0],
            10.0,
            YieldRegion::ExtensionEdge,
            [-87.716_210_85, -297.789_648_71, -297.789_648_71],
            1e-8,
        ),
        ([-20.0, -300.0, -310.0], 30.0, YieldRegion::ExtensionEdge, [-95.7292, -321.8287, -321.8287], 1e-4),
        ([60.0, 50.0, 40.0], 10.0, YieldRegion::Apex, [17.320_508_08; 3], 1e-8),
        ([60.0, 50.0, 40.0], 0.0, YieldRegion::Apex, [17.320_508_08; 3], 1e-8),
        (
            [100.0, 20.0, -10.0],
            10.0,
            YieldRegion::ExtensionEdge,
            [16.188_396_02, 13.924_171_92, 13.924_171_92],
            1e-8,
        ),
    ];
    for (trial, psi, region, exact, tolerance) in table {
        let (stress, found) = pyramid(psi).return_map(&r1(), trial);
        assert_eq!(found, region, "{trial:?}, ψ = {psi}");
        for c in 0..3 {
            assert!(
                (stress[c] - exact[c]).abs() < tolerance,
                "{trial:?}, ψ = {psi}: {stress:?} for {exact:?}"
            );
        }
    }
}

#[test]
fn mohr_coulomb_returns_a_full_tensor() {
    let law = mohr_coulomb(10.0).law().unwrap();
    let new = returned(&law, [-100.0, -350.0, -120.0, 120.0, 40.0, 0.0], Default::default()).stress;
    let exact = [-150.214_594, -337.741_476, -133.800_010, 88.636_360, 30.979_353, -8.603_396];
    for (found, exact) in new.0.into_iter().zip(exact) {
        assert!((found - exact).abs() < 1e-6, "{found} for {exact}");
    }
    let trial = SymTensor([-100.0, -350.0, -120.0, 120.0, 40.0, 0.0]);
    for (stress, exact) in [
        (trial, [-48.427_347, -118.420_994, -403.151_659]),
        (new, [-114.187_590, -130.364_705, -377.203_785]),
    ] {
        for (found, exact) in stress.principal_values().into_iter().zip(exact) {
            assert!((found - exact).abs() < 1e-6, "{found} for {exact}");
        }
    }
}

#[test]
fn without_friction_mohr_coulomb_is_tresca() {
    let prism = Pyramid::new(0.0, 20.0, 0.0);
    let table = [
        ([30.0, -20.0, -60.0], [5.0, -20.0, -35.0]),
        ([50.0, 45.0, -100.0], [11.666_667, 11.666_667, -28.333_333]),
        ([50.0, -90.0, -100.0], [-20.0, -60.0, -60.0]),
    ];
    for (trial, exact) in table {
        let (stress, _) = prism.return_map(&r1(), trial);
        for c in 0..3 {
            assert!((stress[c] - exact[c]).abs() < 1e-6, "{stress:?} for {exact:?}");
        }
    }
}

#[test]
fn associated_returns_are_closest_in_energy() {
    // The return of an associated law is the admissible stress nearest in complementary energy: no
    // admissible point on the way to any other admissible point is nearer.
    let law = mohr_coulomb(30.0).law().unwrap();
    let e = r1();
    let mut seed = 7u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    for _ in 0..10_000 {
        let trial: [f64; 6] =
            std::array::from_fn(|c| if c < 3 { 200.0 * random() - 150.0 } else { 80.0 * random() - 40.0 });
        let new = returned(&law, trial, Default::default()).stress;
        let plastic = e.strain(&(SymTensor(trial) - new));
        // Any other admissible stress: the return of another trial.
        let other: [f64; 6] =
            std::array::from_fn(|c| if c < 3 { 200.0 * random() - 150.0 } else { 80.0 * random() - 40.0 });
        let other = returned(&law, other, Default::default()).stress;
        assert!(plastic.dot(&(new - other)) >= -1e-9, "maximum dissipation at {trial:?}");
        assert!(
            law.yield_value(&Point { stress: new, state: Default::default() }).unwrap()
                <= 1e-8 * new.norm().max(10.0)
        );
    }
}

#[test]
fn hencky_mohr_coulomb_step_of_the_sheet() {
    let law = Hencky(mohr_coulomb(10.0).law().unwrap());
    let start = InitialCondition { stress: SymTensor::isotropic(-100.0), density: 2.0 };
    let old = PointLaw::initial(&law, &start).unwrap();
    let f = Mat3([[0.99, 0.02, 0.0], [0.0, 1.003, 0.0], [0.0, 0.0, 1.0]]);
    let motion = Motion::from_deformation(&f, 1.0, 2.0, 1.0).unwrap();
    // Trial: b of the initial stress, pushed forward; its return in principal Kirchhoff stresses.
    let initial = (-200.0 / (3.0 * r1().bulk_modulus)).exp();
    let strains =
        (SymTensor::IDENTITY * initial).rotated(&f).principal_values().map(|square: f64| 0.5 * square.ln());
    let volume: f64 = strains.iter().sum();
    let trial = strains.map(|strain| r1().lame() * volume + 2.0 * r1().shear_modulus * strain);
    let near = |found: f64, exact: f64, tolerance: f64| {
        assert!((found - exact).abs() < tolerance, "{found} for {exact}");
    };
    for (found, exact) in trial.into_iter().zip([-51.535_595, -181.401_849, -419.803_901]) {
        near(found, exact, 1e-6);
    }
    let kirchhoff = law.0.return_principal(trial, &Default::default()).unwrap().0;
    for (found, exact) in kirchhoff.into_iter().zip([-119.454_423, -193.737_612, -393.004_285]) {
        near(found, exact, 1e-6);
    }
    let [a, b, c] = kirchhoff;
    let elastic = r1().strain(&SymTensor::diagonal(a, b, c));
    for (found, exact) in elastic.0.into_iter().zip([0.002_828_41, -0.002, -0.014_952_33]) {
        near(found, exact, 1e-8);
    }
    // Larger than the 1 % from which §3.8 divides a step; the sheet's values are those of one step.
    let new = law.single_step(&motion, &old).unwrap();
    assert_close(new.state.jacobian, 0.992_97, 1e-9);
    for (c, exact) in [(0, -331.949_197), (1, -184.137_601), (2, -195.109_230), (3, 116.237_431)] {
        assert!((new.stress[c] - exact).abs() < 1e-6, "{} for {exact}", new.stress[c]);
    }
    for (c, exact) in [(0, -329.615_595), (1, -182.843_113), (2, -193.737_612), (3, 115.420_282)] {
        near(new.stress[c] * new.state.jacobian, exact, 1e-6);
    }
    for (c, exact) in [(0, 0.978_679_707_4), (1, 0.997_531_190_2), (2, 0.996_007_989_3), (3, 0.014_824_601_0)]
    {
        let unit = if c < 3 { 1.0 } else { 0.0 };
        assert!((unit + new.state.elastic[c] - exact).abs() < 1e-9);
    }
}

#[test]
fn tangent_blocks_of_the_mohr_coulomb_returns() {
    let pyramid = Pyramid::new(30f64.to_radians(), 10.0, 10f64.to_radians());
    let edge_1 = [6647.469, 6647.469, 9441.245];
    let edge_2 = [13_911.444, 19_758.099, 19_758.099];
    let table = [
        (
            [-50.0, -120.0, -400.0],
            [
                [6528.593, 4740.300, 9272.408],
                [7834.311, 25_688.360, 11_126.889],
                [19_585.778, 14_220.900, 27_817.223],
            ],
        ),
        ([-40.0, -45.0, -400.0], [edge_1, edge_1, [19_942.407, 19_942.407, 28_323.734]]),
        ([-20.0, -300.0, -310.0], [[4637.148, 6586.033, 6586.033], edge_2, edge_2]),
    ];
    for (trial, exact) in table {
        let block = pyramid.tangent(&r1(), pyramid.region(&r1(), trial));
        for (row, exact) in block.iter().zip(exact) {
            for (found, exact) in row.iter().zip(exact) {
                assert!((found - exact).abs() < 6e-4, "{trial:?}: {found} for {exact}");
            }
        }
    }
}

#[test]
fn without_tensile_strength_the_stress_in_extension_is_zero() {
    let elastic = r#""density": 2000, "youngs_modulus": 1e6, "poissons_ratio": 0.2, "tensile_strength": 0"#;
    for model in
        [r#""model": "tension-cut""#, r#""model": "mohr-coulomb", "friction_angle": 30, "cohesion": 1e3"#]
    {
        let spec: MaterialSpec = serde_json::from_str(&format!("{{ {model}, {elastic} }}")).unwrap();
        let material = spec.build().unwrap();
        let start = InitialCondition { stress: SymTensor::ZERO, density: 2000.0 };
        let (mut stress, mut states) = material.initial(&[start]).unwrap();
        for step in 0..50 {
            let turn = 1e-4 * f64::from(step % 7);
            let gradient = Mat3([[6e-4, 3e-4 + turn, 1e-4], [-2e-4, 4e-4, turn], [0.0, 1e-4, 3e-4]]);
            let motion = Motion::from_velocity_gradient(&gradient, 1.0, 2000.0, 1.0).unwrap();
            material.update(&[motion], &mut stress, &mut states.blocks_mut()[0]).unwrap();
        }
        assert_eq!(stress[0], SymTensor::ZERO, "{model}");
    }
}

#[test]
fn tension_cut_off_returns_of_the_sheet() {
    let pyramid =
        |cut_off: f64| Pyramid::new(30f64.to_radians(), 10.0, 10f64.to_radians()).with_cut_off(Some(cut_off));
    let table = [
        (2.0, [20.0, -15.0, -20.0], [2.0, -22.714_286, -27.714_286]),
        (2.0, [25.0, -5.0, -20.0], [2.0, -14.492_305, -28.641_016]),
        (2.0, [12.0, 10.0, -10.0], [2.0, 2.0, -15.4]),
        (2.0, [60.0, -30.0, -60.0], [-1.278_054, -38.475_177, -38.475_177]),
        (0.0, [30.0, 20.0, 10.0], [0.0, 0.0, -5.0]),
    ];
    for (cut_off, trial, exact) in table {
        let (found, region) = pyramid(cut_off).return_map(&r1(), trial);
        for (found, exact) in found.into_iter().zip(exact) {
            assert!((found - exact).abs() < 1e-6, "{trial:?} to {region:?}: {found} for {exact}");
        }
    }
}

#[test]
fn tresca_returns_of_the_sheet() {
    let prism = Pyramid::new(0.0, 20.0, 0.0);
    let third = 1.0 / 3.0;
    let table = [
        ([30.0, -20.0, -60.0], [5.0, -20.0, -35.0]),
        ([50.0, 45.0, -100.0], [35.0 * third, 35.0 * third, -85.0 * third]),
        ([50.0, -90.0, -100.0], [-20.0, -60.0, -60.0]),
    ];
    for (trial, exact) in table {
        let (found, _) = prism.return_map(&r1(), trial);
        for (found, exact) in found.into_iter().zip(exact) {
            assert!((found - exact).abs() < 1e-12, "{trial:?}: {found} for {exact}");
        }
    }
}

#[test]
fn region_returns_agree_with_the_general_one() {
    // V-08 and §3.7.4: the region form against planes tried one set after the other.
    let mut seed = 7_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    for (friction, cohesion, dilatancy) in [(30.0f64, 10.0, 10.0f64), (30.0, 10.0, 30.0), (0.0, 20.0, 0.0)] {
        let pyramid = Pyramid::new(friction.to_radians(), cohesion, dilatancy.to_radians());
        // All six, since at the apex planes of the reversed order are active too.
        let mut planes = pyramid.planes();
        for (plane, [i, j]) in planes[3..].iter_mut().zip([[1, 0], [2, 1], [2, 0]]) {
            let along = |x: f64| {
                std::array::from_fn(|c| {
                    if c == i {
                        x
                    } else if c == j {
                        -1.0
                    } else {
                        0.0
                    }
                })
            };
            let (normal, flow) = (along(pyramid.friction), along(pyramid.dilatancy));
            *plane = multi_surface::YieldPlane { normal, offset: pyramid.strength, flow };
        }
        for _ in 0..10_000 {
            let mut trial: [f64; 3] = std::array::from_fn(|_| 600.0 * random() - 500.0);
            trial.sort_by(|a, b| b.total_cmp(a));
            let (stress, region) = pyramid.return_map(&r1(), trial);
            if region == YieldRegion::Elastic {
                continue;
            }
            let set = multi_surface::active_set(&planes, &r1(), trial).expect("some set carries it");
            let other = multi_surface::return_to(&planes, set, &r1(), trial);
            for (one, other) in stress.into_iter().zip(other) {
                assert!((one - other).abs() < 1e-9, "{trial:?} {region:?} {set:?}: {one} and {other}");
            }
        }
    }
}

#[test]
fn contraction_with_a_negative_plastic_modulus_is_refused() {
    // aᵀ D b = λ (k - 1)(m - 1) + 2 G (k m + 1) turns negative for soft shear and steep contraction.
    let law = |psi: f64, nu: f64| {
        MohrCoulombSpec {
            dilatancy_angle: psi,
            poissons_ratio: nu,
            friction_angle: 45.0,
            ..mohr_coulomb(0.0)
        }
        .law()
    };
    assert!(law(-40.0, 0.2).is_ok());
    let error = law(-40.0, 0.49).unwrap_err().to_string();
    assert!(error.starts_with("dilatancy_angle: -40"), "{error}");
}
