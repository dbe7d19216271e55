//! Closed forms of laws on the standard paths.

use colluvium_testkit::assert_close;

use super::*;

#[test]
fn elastic_paths_have_the_elastic_moduli() {
    let oedometer =
        test(elastic(), 0.0, &[(LoadingPath::Oedometer { axial_compression: 0.01 }, 10)]).run().unwrap();
    assert_close(oedometer.last("stress_zz"), -269_230.769_230_769, 1e-9);
    assert_close(oedometer.last("stress_xx"), -115_384.615_384_615, 1e-9);
    let drained = test(elastic(), 50e3, &[(LoadingPath::TriaxialDrained { axial_compression: 0.01 }, 10)])
        .run()
        .unwrap();
    assert_close(drained.last("q"), YOUNG * 0.01, 1e-9);
    let undrained = test(
        elastic(),
        50e3,
        &[(LoadingPath::TriaxialUndrained { axial_compression: 0.01, fluid_stiffness: None }, 10)],
    )
    .run()
    .unwrap();
    assert_close(undrained.last("q"), 3.0 * SHEAR * 0.01, 1e-9);
    assert_close(undrained.last("p"), 50e3, 1e-9);
    let isotropic = test(elastic(), 0.0, &[(LoadingPath::Isotropic { pressure: 100e3 }, 10)]).run().unwrap();
    assert_close(isotropic.last("volumetric_strain"), -100e3 / BULK, 1e-9);
}

#[test]
fn jaumann_simple_shear_follows_the_sine_to_second_order() {
    let error = |steps: usize| {
        let path = LoadingPath::SimpleShearConstantVolume { shear: 2.0 };
        let end = test(elastic(), 0.0, &[(path, steps)]).run().unwrap();
        let (xy, xx) = (end.last("stress_xy") / SHEAR, end.last("stress_xx") / SHEAR);
        (xy - 2f64.sin()).hypot(xx - 1.0 + 2f64.cos())
    };
    let order = (error(20) / error(100)).ln() / 5f64.ln();
    assert!(order >= 1.95, "order {order}");
    let path = LoadingPath::SimpleShearConstantVolume { shear: 2.0 };
    let coarse = test(elastic(), 0.0, &[(path, 10)]).run().unwrap();
    assert_close(coarse.last("stress_xy") / SHEAR, 0.912_263_68, 2e-8);
    assert_close(coarse.last("stress_xx") / SHEAR, 1.418_169_62, 2e-8);
}

#[test]
fn drucker_prager_matched_to_plane_strain_fails_like_mohr_coulomb() {
    let fail = |material: MaterialSpec| {
        let path = LoadingPath::BiaxialPlaneStrain { axial_compression: 0.4 };
        test(material, 100e3, &[(path, 400)]).run().unwrap().last_stress()
    };
    let exact = -334_641.016_15;
    assert_close(fail(drucker_prager(Matching::PlaneStrain, 0.0))[1], exact, 1e-6);
    assert_close(fail(drucker_prager(Matching::PlaneStrain, 0.0))[2], -217_320.5, 1e-6);
    assert_close(fail(drucker_prager(Matching::PlaneStrain, 10.0))[1], exact, 1e-6);
    assert_close(fail(drucker_prager(Matching::PlaneStrain, 10.0))[2], -237_693.0, 1e-6);
    let associated = fail(drucker_prager(Matching::PlaneStrainAssociated, 30.0));
    assert_close(associated[1], exact, 1e-6);
    assert_close(associated[2], -275_980.8, 1e-6);
    assert_close(fail(drucker_prager(Matching::Compression, 0.0))[1], -629_214.908_38, 1e-6);
    assert_close(fail(drucker_prager(Matching::Compression, 30.0))[1], -826_723.0, 1e-6);
    for dilatancy in [0.0, 10.0] {
        assert_close(fail(MaterialSpec::MohrCoulomb(mohr_coulomb(dilatancy)))[1], exact, 1e-6);
    }
}

#[test]
fn plane_strain_failure_dilates_at_the_dilatancy_angle() {
    let path = LoadingPath::BiaxialPlaneStrain { axial_compression: 0.4 };
    let run = test(drucker_prager(Matching::PlaneStrain, 10.0), 100e3, &[(path, 200)]).run().unwrap();
    let rate = |name: &str| {
        let values = run.column(name).unwrap();
        values[200] - values[190]
    };
    let (x, y) = (rate("strain_xx"), rate("strain_yy"));
    assert_close((x + y) / (x - y), 0.173_648_18, 1e-6);
}

#[test]
fn mohr_coulomb_reaches_its_strength_in_every_test() {
    let drained = |pressure: f64| {
        let path = LoadingPath::TriaxialDrained { axial_compression: 0.1 };
        test(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), pressure, &[(path, 200)]).run().unwrap().last("q")
    };
    assert_close(drained(50e3), 134_641.016, 1e-6);
    assert_close(drained(100e3), 234_641.016, 1e-6);
    let path = LoadingPath::TriaxialUndrained { axial_compression: 0.1, fluid_stiffness: None };
    let undrained = test(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), 100e3, &[(path, 200)]).run().unwrap();
    assert_close(undrained.last("q"), 140_784.610, 1e-6);
    assert_close(undrained.last("p"), 100e3, 1e-6);
}

#[test]
fn cohesionless_oedometer_locks_its_stress_ratio() {
    let spec = MohrCoulombSpec { cohesion: 0.0, poissons_ratio: 0.2, ..mohr_coulomb(0.0) };
    let path = |amount| LoadingPath::Oedometer { axial_compression: amount };
    let from_zero = test(MaterialSpec::MohrCoulomb(spec.clone()), 0.0, &[(path(0.01), 100)]).run().unwrap();
    assert_close(from_zero.last("stress_zz"), -200e3, 1e-6);
    assert_close(from_zero.last("stress_xx"), -200e3 / 3.0, 1e-6);
    let from_pressure =
        test(MaterialSpec::MohrCoulomb(spec), 100e3, &[(path(0.036), 100), (path(0.01), 100)]).run().unwrap();
    assert_close(from_pressure.rows[100][9], -900e3, 1e-6);
    assert_close(from_pressure.last("stress_zz"), -900e3 - 20e6 * 0.01, 1e-6);
}

#[test]
fn unloading_and_reloading_closes_the_loop() {
    let path = |amount| (LoadingPath::TriaxialDrained { axial_compression: amount }, 100);
    let paths = [path(0.05), path(-0.002), path(0.002), path(0.001)];
    let run = test(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), 100e3, &paths).run().unwrap();
    assert_close(run.rows[100][14], run.rows[300][14], 1e-9);
    assert_close(run.rows[200][14], run.rows[100][14] - YOUNG * 0.002, 1e-9);
    assert_close(run.last("q"), run.rows[100][14], 1e-9);
}

#[test]
fn a_newtonian_fluid_relaxes_at_once_and_flows_at_its_viscosity() {
    let shear = [[0.0, 3.0, 0.0], [0.0; 3], [0.0; 3]];
    let flow = |velocity_gradient| (LoadingPath::Flow { velocity_gradient }, 10);
    let run = test(fluid(), 0.0, &[flow(shear), flow([[0.0; 3]; 3])]).run().unwrap();
    assert_close(run.rows[10][10], 150.0, 1e-9);
    assert_eq!(run.last("q"), 0.0);
}

#[test]
fn triaxial_extension_has_youngs_modulus_and_its_own_strength() {
    let extend = |material, amount| {
        let path = LoadingPath::TriaxialExtension { axial_extension: amount };
        test(material, 100e3, &[(path, 100)]).run().unwrap()
    };
    let elastic = extend(elastic(), 0.001);
    assert_close(elastic.last("stress_zz"), -100e3 + YOUNG * 0.001, 1e-9);
    assert_close(elastic.last("lode_angle"), 0.0, 1e-6);
    // The axial stress becomes the largest: σ3 = k σ1 - 2c√k with σ3 the constant one.
    let failed = extend(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), 0.05);
    assert_close(failed.last("stress_zz"), -(100e3 - 2.0 * 10e3 * 3f64.sqrt()) / 3.0, 1e-6);
}

#[test]
fn simple_shear_under_constant_normal_stress_keeps_it_and_slides_at_the_friction_angle() {
    let shear = LoadingPath::SimpleShearConstantNormalStress { shear: 1e-3 };
    let run = test(elastic(), 100e3, &[(shear, 50)]).run().unwrap();
    assert_close(run.last("stress_yy"), -100e3, 1e-9);
    assert_close(run.last("stress_xy"), SHEAR * 1e-3, 1e-3);
    let cohesionless = MohrCoulombSpec { cohesion: 0.0, ..mohr_coulomb(30.0) };
    let shear = LoadingPath::SimpleShearConstantNormalStress { shear: 0.05 };
    let run = test(MaterialSpec::MohrCoulomb(cohesionless), 100e3, &[(shear, 400)]).run().unwrap();
    // Associated: the plane of no extension is the plane of failure.
    assert_close(run.last("stress_xy") / 100e3, 30f64.to_radians().tan(), 5e-3);
    let load = LoadingPath::SimpleShearStress { shear_stress: 1e3 };
    let run = test(elastic(), 100e3, &[(load, 10)]).run().unwrap();
    assert_close(run.last("stress_xy"), 1e3, 1e-9);
    assert_close(2.0 * run.last("strain_xy"), 1e3 / SHEAR, 1e-3);
}
