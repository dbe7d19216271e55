use super::*;
use crate::laws::{
    DruckerPragerSpec, LinearElasticSpec, Matching, MohrCoulombSpec, NewtonianFluidSpec, StrainMeasure,
};

/// Set R1 of the sheet (Pa).
const YOUNG: f64 = 20e6;
const BULK: f64 = YOUNG / (3.0 * 0.4);
const SHEAR: f64 = YOUNG / 2.6;

fn elastic() -> MaterialSpec {
    MaterialSpec::LinearElastic(LinearElasticSpec {
        density: 2000.0,
        youngs_modulus: YOUNG,
        poissons_ratio: 0.3,
        strain_measure: StrainMeasure::Rate,
    })
}

fn drucker_prager(matching: Matching, dilatancy_angle: f64) -> MaterialSpec {
    MaterialSpec::DruckerPrager(DruckerPragerSpec {
        density: 2000.0,
        youngs_modulus: YOUNG,
        poissons_ratio: 0.3,
        friction_angle: 30.0,
        cohesion: 10e3,
        dilatancy_angle,
        matching,
        softening: None,
        dilatancy_decay: 0.0,
        strain_measure: StrainMeasure::Rate,
    })
}

fn mohr_coulomb(dilatancy_angle: f64) -> MohrCoulombSpec {
    MohrCoulombSpec {
        density: 2000.0,
        youngs_modulus: YOUNG,
        poissons_ratio: 0.3,
        friction_angle: 30.0,
        cohesion: 10e3,
        dilatancy_angle,
        softening: None,
        dilatancy_decay: 0.0,
        strain_measure: StrainMeasure::Rate,
    }
}

fn test(material: MaterialSpec, pressure: f64, paths: &[(Path, usize)]) -> ElementTest {
    let stage =
        |(path, steps): &(Path, usize)| TestStage { path: path.clone(), steps: *steps, duration: 1.0 };
    ElementTest {
        title: "test".into(),
        material,
        initial_stress: [-pressure, -pressure, -pressure, 0.0, 0.0, 0.0],
        stages: paths.iter().map(stage).collect(),
    }
}

fn close(found: f64, exact: f64, tolerance: f64) {
    assert!((found - exact).abs() <= tolerance * exact.abs().max(1.0), "{found} for {exact}");
}

#[test]
fn elastic_paths_have_the_elastic_moduli() {
    let oedometer = test(elastic(), 0.0, &[(Path::Oedometer { axial_compression: 0.01 }, 10)]).run().unwrap();
    close(oedometer.last("stress_zz"), -269_230.769_230_769, 1e-9);
    close(oedometer.last("stress_xx"), -115_384.615_384_615, 1e-9);
    let drained =
        test(elastic(), 50e3, &[(Path::TriaxialDrained { axial_compression: 0.01 }, 10)]).run().unwrap();
    close(drained.last("q"), YOUNG * 0.01, 1e-9);
    let undrained =
        test(elastic(), 50e3, &[(Path::TriaxialUndrained { axial_compression: 0.01 }, 10)]).run().unwrap();
    close(undrained.last("q"), 3.0 * SHEAR * 0.01, 1e-9);
    close(undrained.last("p"), 50e3, 1e-9);
    let isotropic = test(elastic(), 0.0, &[(Path::Isotropic { pressure: 100e3 }, 10)]).run().unwrap();
    close(isotropic.last("volumetric_strain"), -100e3 / BULK, 1e-9);
}

#[test]
fn jaumann_simple_shear_follows_the_sine_to_second_order() {
    let error = |steps: usize| {
        let path = Path::SimpleShearConstantVolume { shear: 2.0 };
        let end = test(elastic(), 0.0, &[(path, steps)]).run().unwrap();
        let (xy, xx) = (end.last("stress_xy") / SHEAR, end.last("stress_xx") / SHEAR);
        (xy - 2f64.sin()).hypot(xx - 1.0 + 2f64.cos())
    };
    let order = (error(20) / error(100)).ln() / 5f64.ln();
    assert!(order >= 1.95, "order {order}");
    let path = Path::SimpleShearConstantVolume { shear: 2.0 };
    let coarse = test(elastic(), 0.0, &[(path, 10)]).run().unwrap();
    close(coarse.last("stress_xy") / SHEAR, 0.912_263_68, 2e-8);
    close(coarse.last("stress_xx") / SHEAR, 1.418_169_62, 2e-8);
}

#[test]
fn drucker_prager_matched_to_plane_strain_fails_like_mohr_coulomb() {
    let fail = |material: MaterialSpec| {
        let path = Path::BiaxialPlaneStrain { axial_compression: 0.4 };
        test(material, 100e3, &[(path, 400)]).run().unwrap().last_stress()
    };
    let exact = -334_641.016_15;
    close(fail(drucker_prager(Matching::PlaneStrain, 0.0))[1], exact, 1e-6);
    close(fail(drucker_prager(Matching::PlaneStrain, 0.0))[2], -217_320.5, 1e-6);
    close(fail(drucker_prager(Matching::PlaneStrain, 10.0))[1], exact, 1e-6);
    close(fail(drucker_prager(Matching::PlaneStrain, 10.0))[2], -237_693.0, 1e-6);
    let associated = fail(drucker_prager(Matching::PlaneStrainAssociated, 30.0));
    close(associated[1], exact, 1e-6);
    close(associated[2], -275_980.8, 1e-6);
    close(fail(drucker_prager(Matching::Compression, 0.0))[1], -629_214.908_38, 1e-6);
    for dilatancy in [0.0, 10.0] {
        close(fail(MaterialSpec::MohrCoulomb(mohr_coulomb(dilatancy)))[1], exact, 1e-6);
    }
}

#[test]
fn plane_strain_failure_dilates_at_the_dilatancy_angle() {
    let path = Path::BiaxialPlaneStrain { axial_compression: 0.4 };
    let run = test(drucker_prager(Matching::PlaneStrain, 10.0), 100e3, &[(path, 200)]).run().unwrap();
    let rate = |name: &str| {
        let values = run.column(name).unwrap();
        values[200] - values[190]
    };
    let (x, y) = (rate("strain_xx"), rate("strain_yy"));
    close((x + y) / (x - y), 0.173_648_18, 1e-6);
}

#[test]
fn mohr_coulomb_reaches_its_strength_in_every_test() {
    let drained = |pressure: f64| {
        let path = Path::TriaxialDrained { axial_compression: 0.1 };
        test(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), pressure, &[(path, 200)]).run().unwrap().last("q")
    };
    close(drained(50e3), 134_641.016, 1e-6);
    close(drained(100e3), 234_641.016, 1e-6);
    let path = Path::TriaxialUndrained { axial_compression: 0.1 };
    let undrained = test(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), 100e3, &[(path, 200)]).run().unwrap();
    close(undrained.last("q"), 140_784.610, 1e-6);
    close(undrained.last("p"), 100e3, 1e-6);
}

#[test]
fn cohesionless_oedometer_locks_its_stress_ratio() {
    let spec = MohrCoulombSpec { cohesion: 0.0, poissons_ratio: 0.2, ..mohr_coulomb(0.0) };
    let path = |amount| Path::Oedometer { axial_compression: amount };
    let from_zero = test(MaterialSpec::MohrCoulomb(spec.clone()), 0.0, &[(path(0.01), 100)]).run().unwrap();
    close(from_zero.last("stress_zz"), -200e3, 1e-6);
    close(from_zero.last("stress_xx"), -200e3 / 3.0, 1e-6);
    let from_pressure =
        test(MaterialSpec::MohrCoulomb(spec), 100e3, &[(path(0.036), 100), (path(0.01), 100)]).run().unwrap();
    close(from_pressure.rows[100][9], -900e3, 1e-6);
    close(from_pressure.last("stress_zz"), -900e3 - 20e6 * 0.01, 1e-6);
}

#[test]
fn unloading_and_reloading_closes_the_loop() {
    let path = |amount| (Path::TriaxialDrained { axial_compression: amount }, 100);
    let paths = [path(0.05), path(-0.002), path(0.002), path(0.001)];
    let run = test(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), 100e3, &paths).run().unwrap();
    close(run.rows[100][14], run.rows[300][14], 1e-9);
    close(run.rows[200][14], run.rows[100][14] - YOUNG * 0.002, 1e-9);
    close(run.last("q"), run.rows[100][14], 1e-9);
}

#[test]
fn a_newtonian_fluid_relaxes_at_once_and_flows_at_its_viscosity() {
    let fluid = MaterialSpec::NewtonianFluid(NewtonianFluidSpec {
        density: 1000.0,
        bulk_modulus: 2e6,
        viscosity: 50.0,
        cavitation_strength: 0.0,
        equation_of_state: Default::default(),
    });
    let shear = [[0.0, 3.0, 0.0], [0.0; 3], [0.0; 3]];
    let flow = |velocity_gradient| (Path::Flow { velocity_gradient }, 10);
    let run = test(fluid, 0.0, &[flow(shear), flow([[0.0; 3]; 3])]).run().unwrap();
    close(run.rows[10][10], 150.0, 1e-9);
    assert_eq!(run.last("q"), 0.0);
}

#[test]
fn stress_control_stops_at_the_limit_load() {
    let push = Path::Stress { increment: [0.0, 0.0, -300e3, 0.0, 0.0, 0.0] };
    let error = test(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), 100e3, &[(push, 300)]).run().unwrap_err();
    // q = 234.6 kPa is reached in step 234.
    assert!(matches!(error, DriverError::LimitLoad { stage: 0, step: 233..=235, .. }), "{error}");
}

#[test]
fn dependent_conditions_are_refused() {
    let mut strain = [[0.0; 6]; 6];
    (0..6).for_each(|i| strain[i][i.min(4)] = 1.0);
    let path = Path::General { stress: [[0.0; 6]; 6], strain, total: [0.0; 6] };
    let error = test(elastic(), 0.0, &[(path, 1)]).run().unwrap_err();
    assert!(error.to_string().contains("rank 5"), "{error}");
}

#[test]
fn true_triaxial_keeps_its_ratio() {
    let path = Path::TrueTriaxial { axial_compression: 0.002, b: 0.5 };
    let run = test(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), 100e3, &[(path, 50)]).run().unwrap();
    let s = run.last_stress();
    close((s[1] - s[0]) / (s[2] - s[0]), 0.5, 1e-8);
}

#[test]
fn the_table_reads_as_csv() {
    let run = test(elastic(), 0.0, &[(Path::Oedometer { axial_compression: 0.01 }, 3)]).run().unwrap();
    let mut text = Vec::new();
    run.write_csv(&mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 2 + 4);
    assert!(lines.iter().skip(1).all(|line| line.split(',').count() == run.columns.len()));
}
