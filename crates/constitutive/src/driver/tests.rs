use super::*;
use crate::laws::{
    DruckerPragerSpec, LinearElasticSpec, Matching, MohrCoulombSpec, NeoHookeanSpec, NewtonianFluidSpec,
    Softening, StrainMeasure, UndrainedSpec,
};

/// Set R1 of the sheet (Pa).
pub(super) const YOUNG: f64 = 20e6;
const BULK: f64 = YOUNG / (3.0 * 0.4);
pub(super) const SHEAR: f64 = YOUNG / 2.6;

pub(super) fn elastic() -> MaterialSpec {
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
        integration: Default::default(),
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
        tensile_strength: None,
        strain_measure: StrainMeasure::Rate,
    }
}

fn fluid() -> MaterialSpec {
    MaterialSpec::NewtonianFluid(NewtonianFluidSpec {
        density: 1000.0,
        bulk_modulus: 2e6,
        viscosity: 50.0,
        cavitation_strength: 0.0,
        equation_of_state: Default::default(),
    })
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

fn general(stress: [[f64; 6]; 6], strain: [[f64; 6]; 6], total: [f64; 6]) -> Path {
    Path::General {
        stress,
        strain,
        total,
        amplitude: [0.0; 6],
        phase: [0.0; 6],
        spin: [0.0; 3],
        fluid_stiffness: None,
    }
}

/// The unit matrix times `value`.
fn unit(value: f64) -> [[f64; 6]; 6] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { value } else { 0.0 }))
}

pub(super) fn close(found: f64, exact: f64, tolerance: f64) {
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
    let undrained = test(
        elastic(),
        50e3,
        &[(Path::TriaxialUndrained { axial_compression: 0.01, fluid_stiffness: None }, 10)],
    )
    .run()
    .unwrap();
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
    let path = Path::TriaxialUndrained { axial_compression: 0.1, fluid_stiffness: None };
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
    let shear = [[0.0, 3.0, 0.0], [0.0; 3], [0.0; 3]];
    let flow = |velocity_gradient| (Path::Flow { velocity_gradient }, 10);
    let run = test(fluid(), 0.0, &[flow(shear), flow([[0.0; 3]; 3])]).run().unwrap();
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
fn what_came_before_a_limit_load_is_kept() {
    let push = Path::Stress { increment: [0.0, 0.0, -300e3, 0.0, 0.0, 0.0] };
    let trace = test(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), 100e3, &[(push, 300)]).trace().unwrap();
    let stopped = trace.stopped.unwrap().to_string();
    assert!(stopped.starts_with("stages[0].path: limit load reached in step"), "{stopped}");
    assert!((234..=237).contains(&trace.path.rows.len()), "{}", trace.path.rows.len());
    // The last row stands within a thousandth of a step of the strength.
    close(trace.path.last("q"), 234_641.016, 1e-5);
}

#[test]
fn wrong_amounts_are_refused_with_their_path() {
    let wrong = |path: Path, steps: usize| {
        let error = test(elastic(), 0.0, &[(path, steps)]).run().unwrap_err();
        assert!(matches!(error, DriverError::Invalid(_)), "{error}");
        error.to_string()
    };
    let b = |b| Path::TrueTriaxial { axial_compression: 0.01, b };
    assert_eq!(wrong(b(1.5), 10), "stages[0].path.b: 1.5 is not in 0..=1");
    assert!(wrong(b(f64::NAN), 10).starts_with("stages[0].path.b: "));
    assert!(wrong(Path::Isotropic { pressure: f64::INFINITY }, 1).starts_with("stages[0].path.pressure: "));
    assert!(wrong(Path::Oedometer { axial_compression: 0.01 }, 0).starts_with("stages[0].steps: 0 "));
    assert!(wrong(Path::Oedometer { axial_compression: 3.0 }, 2).contains("take at least 3 steps"));
    assert!(wrong(Path::Reversal { fraction: 1.0 }, 1).contains("no stage before it"));
    let inverted = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let inverted = Path::DeformationGradient { deformation: inverted };
    assert!(wrong(inverted, 10).starts_with("stages[0].path.deformation: turns"));
    let increments = vec![[0.0; 6], [0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0]];
    let direct = Path::Direct { control: [Controlled::Strain; 6], increments, spins: vec![[0.0; 3]] };
    let lines = wrong(direct, 1);
    assert!(
        lines.contains("stages[0].path.increments[1][1]: NaN")
            && lines.contains("stages[0].path.spins: has 1")
    );
    let mut several = test(elastic(), f64::NAN, &[]);
    let error = several.validate().unwrap_err().to_string();
    assert!(error.starts_with("initial_stress[0]: ") && error.contains("\nstages: "), "{error}");
    several = test(
        MaterialSpec::MohrCoulomb(MohrCoulombSpec { friction_angle: 95.0, ..mohr_coulomb(0.0) }),
        0.0,
        &[],
    );
    assert!(several.validate().unwrap_err().to_string().starts_with("material.friction_angle: 95 "));
    several = test(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), 1e3, &[]);
    several.initial_stress[2] = -1e6;
    assert!(several.validate().unwrap_err().to_string().starts_with("initial_stress: "));
}

#[test]
fn a_path_without_rows_gives_nan_and_no_panic() {
    let empty = ElementPath { columns: vec![("q", "Pa")], rows: vec![] };
    assert!(empty.last_stress()[0].is_nan() && empty.stress(7)[3].is_nan() && empty.last("q").is_nan());
    let short = ElementPath { columns: vec![("time", "s"), ("q", "Pa")], rows: vec![vec![0.0]] };
    assert!(short.last("q").is_nan() && short.last_stress()[5].is_nan());
}

#[test]
fn triaxial_extension_has_youngs_modulus_and_its_own_strength() {
    let extend = |material, amount| {
        let path = Path::TriaxialExtension { axial_extension: amount };
        test(material, 100e3, &[(path, 100)]).run().unwrap()
    };
    let elastic = extend(elastic(), 0.001);
    close(elastic.last("stress_zz"), -100e3 + YOUNG * 0.001, 1e-9);
    close(elastic.last("lode_angle"), 0.0, 1e-6);
    // The axial stress becomes the largest: σ3 = k σ1 - 2c√k with σ3 the kept one.
    let failed = extend(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), 0.05);
    close(failed.last("stress_zz"), -(100e3 - 2.0 * 10e3 * 3f64.sqrt()) / 3.0, 1e-6);
}

#[test]
fn simple_shear_under_constant_normal_stress_keeps_it_and_slides_at_the_friction_angle() {
    let shear = Path::SimpleShearConstantNormalStress { shear: 1e-3 };
    let run = test(elastic(), 100e3, &[(shear, 50)]).run().unwrap();
    close(run.last("stress_yy"), -100e3, 1e-9);
    close(run.last("stress_xy"), SHEAR * 1e-3, 1e-3);
    let cohesionless = MohrCoulombSpec { cohesion: 0.0, ..mohr_coulomb(30.0) };
    let shear = Path::SimpleShearConstantNormalStress { shear: 0.05 };
    let run = test(MaterialSpec::MohrCoulomb(cohesionless), 100e3, &[(shear, 400)]).run().unwrap();
    // Associated: the plane of no extension is the plane of failure.
    close(run.last("stress_xy") / 100e3, 30f64.to_radians().tan(), 5e-3);
    let load = Path::SimpleShearStress { shear_stress: 1e3 };
    let run = test(elastic(), 100e3, &[(load, 10)]).run().unwrap();
    close(run.last("stress_xy"), 1e3, 1e-9);
    close(2.0 * run.last("strain_xy"), 1e3 / SHEAR, 1e-3);
}

#[test]
fn creep_and_relaxation_keep_stress_and_strain_while_time_passes() {
    let load = Path::TriaxialDrained { axial_compression: 0.001 };
    let stages = [(load, 10), (Path::Creep {}, 5), (Path::Relaxation {}, 5)];
    let run = test(elastic(), 100e3, &stages).run().unwrap();
    assert_eq!(run.rows.len(), 21);
    close(run.last("time"), 3.0, 1e-12);
    for column in ["stress_zz", "strain_zz", "strain_xx"] {
        let values = run.column(column).unwrap();
        close(values[20], values[10], 1e-9);
    }
    let flow = Path::Flow { velocity_gradient: [[0.0, 3.0, 0.0], [0.0; 3], [0.0; 3]] };
    let run = test(fluid(), 0.0, &[(flow, 10), (Path::Relaxation {}, 1)]).run().unwrap();
    close(run.rows[10][10], 150.0, 1e-9);
    assert_eq!(run.last("q"), 0.0);
    // All of the work of the flow is lost: μ γ̇² t.
    close(run.last("dissipated_work"), 50.0 * 9.0, 0.06);
}

#[test]
fn a_reversal_brings_an_elastic_point_back() {
    let stretched = [[1.2, 0.3, 0.0], [0.0, 0.9, 0.1], [0.0, 0.0, 1.1]];
    let wave = Path::General {
        stress: unit(0.0),
        strain: unit(1.0),
        total: [1e-3, 0.0, 0.0, 0.0, 0.0, 0.0],
        amplitude: [0.0, 2e-3, 0.0, 1e-3, 0.0, 0.0],
        phase: [0.0, 40.0, 0.0, 90.0, 0.0, 0.0],
        spin: [0.0; 3],
        fluid_stiffness: None,
    };
    let increments = vec![[1e-3, 0.0, 0.0, 2e-3, 0.0, 0.0], [0.0, -1e-3, 0.0, 0.0, 0.0, 1e-3]];
    let direct = Path::Direct { control: [Controlled::Strain; 6], increments, spins: vec![] };
    let hencky = MaterialSpec::LinearElastic(LinearElasticSpec {
        density: 2000.0,
        youngs_modulus: YOUNG,
        poissons_ratio: 0.3,
        strain_measure: StrainMeasure::Hencky,
    });
    for path in [
        Path::TriaxialUndrained { axial_compression: 0.01, fluid_stiffness: None },
        Path::Isotropic { pressure: 50e3 },
        Path::DeformationGradient { deformation: stretched },
        wave,
        direct,
    ] {
        let stages = [(path.clone(), 20), (Path::Reversal { fraction: 1.0 }, 20)];
        let run = test(hencky.clone(), 100e3, &stages).run().unwrap();
        for c in 0..6 {
            let (start, end) = (run.stress(0)[c], run.last_stress()[c]);
            assert!((start - end).abs() < 1e-4 * 100e3, "{path:?}: {start} {end}");
        }
        close(run.last("excess_pore_pressure"), 0.0, 1.0);
        assert!(run.last("dissipated_work").abs() < 0.2, "{path:?}: {}", run.last("dissipated_work"));
    }
    let half = [(Path::Oedometer { axial_compression: 0.01 }, 10), (Path::Reversal { fraction: 0.5 }, 10)];
    let run = test(elastic(), 0.0, &half).run().unwrap();
    close(run.last("strain_zz"), -0.005, 1e-12);
}

#[test]
fn rotation_and_spin_turn_the_stress_alike() {
    let start = [-100e3, -50e3, -70e3, 20e3, 0.0, 0.0];
    let turned = |path: Path| {
        let mut test = test(elastic(), 0.0, &[(path, 3)]);
        test.initial_stress = start;
        test.run().unwrap().last_stress()
    };
    let rotation = turned(Path::Rotation { angle: 30.0 });
    let direct = |control, increment| Path::Direct {
        control,
        increments: vec![increment],
        spins: vec![[0.0, 0.0, 30.0]],
    };
    let spin = turned(direct([Controlled::Strain; 6], [0.0; 6]));
    // Sheet V-02.
    for stress in [rotation, spin] {
        close(stress[0], -104_820.508_08, 1e-9);
        close(stress[3], -11_650.635_09, 1e-8);
    }
    // Stress control with spin: the axes are those of space.
    let kept = turned(direct([Controlled::Stress; 6], [1e3, 0.0, 0.0, 0.0, 0.0, 0.0]));
    (0..6).for_each(|c| close(kept[c], start[c] + if c == 0 { 1e3 } else { 0.0 }, 1e-9));
}

#[test]
fn a_direct_path_mixes_stress_and_strain_rows() {
    use Controlled::{Strain, Stress};
    let increments = vec![[0.0, 0.0, -0.001, 0.0, 0.0, 0.0], [0.0, 0.0, -0.001, 0.0, 0.0, 0.0]];
    let control = [Stress, Stress, Strain, Strain, Stress, Strain];
    let direct = Path::Direct { control, increments, spins: vec![] };
    let run = test(elastic(), 50e3, &[(direct, 5)]).run().unwrap();
    assert_eq!(run.rows.len(), 11);
    close(run.last("time"), 1.0, 1e-12);
    close(run.last("stress_zz"), -50e3 - YOUNG * 0.002, 1e-9);
    close(run.last("stress_xx"), -50e3, 1e-9);
}

#[test]
fn a_sine_of_strain_returns_after_its_period() {
    let mut amplitude = [0.0; 6];
    amplitude[2] = 0.001;
    let path = Path::General {
        stress: unit(0.0),
        strain: unit(1.0),
        total: [0.0; 6],
        amplitude,
        phase: [0.0; 6],
        spin: [0.0; 3],
        fluid_stiffness: None,
    };
    let run = test(elastic(), 0.0, &[(path, 40)]).run().unwrap();
    let strain = run.column("strain_zz").unwrap();
    close(strain[10], 0.001, 1e-12);
    close(strain[30], -0.001, 1e-12);
    close(strain[40], 0.0, 1e-12);
}

#[test]
fn work_is_stored_by_elasticity_and_lost_by_plasticity() {
    let neo = MaterialSpec::NeoHookean(NeoHookeanSpec {
        density: 2000.0,
        youngs_modulus: YOUNG,
        poissons_ratio: 0.3,
        volumetric_law: Default::default(),
    });
    let shear = Path::SimpleShearConstantVolume { shear: 0.5 };
    let run = test(neo, 0.0, &[(shear, 400)]).run().unwrap();
    // ½ G γ².
    close(run.last("stored_energy"), 0.5 * SHEAR * 0.25, 1e-9);
    close(run.last("dissipated_work") / run.last("stored_energy"), 0.0, 1e-5);
    let path = Path::TriaxialDrained { axial_compression: 0.05 };
    let run = test(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), 100e3, &[(path, 200)]).run().unwrap();
    let lost = run.column("dissipated_work").unwrap();
    assert!(lost.windows(2).all(|pair| pair[1] >= pair[0] - 1.0), "{lost:?}");
    // ψ = 0: q times plastic shear strain, 5 % less the elastic part.
    close(run.last("dissipated_work"), 234_641.0 * (0.05 - 234_641.0 / YOUNG), 1e-2);
}

#[test]
fn the_pore_pressure_of_an_undrained_test_is_minus_the_change_of_effective_pressure() {
    let path = Path::TriaxialUndrained { axial_compression: 0.01, fluid_stiffness: None };
    let run = test(elastic(), 100e3, &[(path, 20)]).run().unwrap();
    // Constant total lateral stress: u = q/3 where p' stays.
    close(run.last("excess_pore_pressure"), run.last("q") / 3.0, 1e-9);
    assert_eq!(run.standard_plots()[1].name, "pore-pressure-strain");
    let drained = Path::TriaxialDrained { axial_compression: 0.01 };
    let run = test(elastic(), 100e3, &[(drained, 20)]).run().unwrap();
    close(run.last("excess_pore_pressure"), 0.0, 1e-12);
    assert_eq!(run.standard_plots().map(|p| p.name), ["q-strain", "volume-strain", "q-p", "volume-ln-p"]);
}

#[test]
fn a_void_ratio_is_drawn_where_the_law_has_one() {
    let mut run = test(elastic(), 100e3, &[(Path::Oedometer { axial_compression: 0.01 }, 2)]).run().unwrap();
    run.columns.push(("void_ratio", ""));
    run.rows.iter_mut().for_each(|row| row.push(0.7));
    let plot = run.standard_plots()[3];
    assert_eq!((plot.name, plot.x, plot.y), ("void-ratio-ln-p", "ln_p", "void_ratio"));
}

#[test]
fn the_yield_line_is_the_strength_in_triaxial_compression() {
    let path = Path::TriaxialDrained { axial_compression: 0.05 };
    let spec = MaterialSpec::MohrCoulomb(mohr_coulomb(0.0));
    let trace = test(spec, 100e3, &[(path.clone(), 100)]).trace().unwrap();
    let lines = trace.yield_lines();
    assert_eq!(lines.len(), 1);
    // q = M p + 6 c cos φ / (3 - sin φ), M = 6 sin φ / (3 - sin φ).
    for (p, q) in &lines[0].points {
        close(*q, 1.2 * p + 2.4 * 10e3 * 3f64.sqrt() / 2.0, 1e-9);
    }
    assert!(lines[0].points.len() > 40);
    let softening = Softening {
        residual_friction_angle: 20.0,
        residual_cohesion: 1e3,
        friction_rate: 10.0,
        cohesion_rate: 10.0,
        hardening: false,
    };
    let spec = MohrCoulombSpec { softening: Some(softening), ..mohr_coulomb(0.0) };
    let trace = test(MaterialSpec::MohrCoulomb(spec), 100e3, &[(path.clone(), 100)]).trace().unwrap();
    assert_eq!(trace.yield_lines().len(), 2);
    assert!(test(elastic(), 100e3, &[(path, 10)]).trace().unwrap().yield_lines().is_empty());
}

#[test]
fn dependent_conditions_are_refused() {
    let mut strain = [[0.0; 6]; 6];
    (0..6).for_each(|i| strain[i][i.min(4)] = 1.0);
    let error = test(elastic(), 0.0, &[(general([[0.0; 6]; 6], strain, [0.0; 6]), 1)]).run().unwrap_err();
    assert!(error.to_string().starts_with("stages[0].path: "), "{error}");
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

/// `K_f/n` of water (2.15 GPa) at a porosity of 0.4.
const FLUID: f64 = 2.15e9 / 0.4;

#[test]
fn a_compressible_pore_fluid_adds_its_stiffness() {
    let undrained = BULK + FLUID;
    let poisson = (3.0 * undrained - 2.0 * SHEAR) / (2.0 * (3.0 * undrained + SHEAR));
    // The figures of §5.3 of the constitutive sheet.
    close(undrained, 5.391_667e9, 1e-7);
    close(poisson, 0.499_287, 1e-6);
    let path = Path::TriaxialUndrained { axial_compression: 0.01, fluid_stiffness: Some(FLUID) };
    let run = test(elastic(), 100e3, &[(path, 20)]).run().unwrap();
    close(run.last("q"), 2.0 * SHEAR * (1.0 + poisson) * 0.01, 1e-9);
    close(run.last("volumetric_strain"), -(1.0 - 2.0 * poisson) * 0.01, 1e-7);
    close(run.last("excess_pore_pressure"), FLUID * (1.0 - 2.0 * poisson) * 0.01, 1e-7);
    // The total lateral stress stays.
    close(run.last("stress_xx") - run.last("excess_pore_pressure"), -100e3, 1e-9);
}

#[test]
fn a_total_pressure_is_shared_by_skeleton_and_pore_fluid() {
    let mut total = [0.0; 6];
    total[..3].fill(-50e3);
    let path = Path::General {
        stress: unit(1.0),
        strain: unit(0.0),
        total,
        amplitude: [0.0; 6],
        phase: [0.0; 6],
        spin: [0.0; 3],
        fluid_stiffness: Some(FLUID),
    };
    let run = test(elastic(), 100e3, &[(path, 5)]).run().unwrap();
    close(run.last("excess_pore_pressure"), 50e3 * FLUID / (BULK + FLUID), 1e-9);
    close(run.last("p"), 100e3 + 50e3 * BULK / (BULK + FLUID), 1e-9);
}

#[test]
fn the_pore_fluid_and_the_undrained_wrapper_agree() {
    let skeleton = MaterialSpec::MohrCoulomb(mohr_coulomb(10.0));
    let path = Path::TriaxialUndrained { axial_compression: 0.02, fluid_stiffness: Some(5e7) };
    let driven = test(skeleton.clone(), 100e3, &[(path, 200)]).run().unwrap();
    let wrapped = MaterialSpec::Undrained(UndrainedSpec {
        fluid_bulk_modulus: 2e7,
        porosity: 0.4,
        initial_pore_pressure: 0.0,
        cavitation_strength: None,
        skeleton: Box::new(skeleton),
    });
    let path = Path::TriaxialDrained { axial_compression: 0.02 };
    let whole = test(wrapped, 100e3, &[(path, 200)]).run().unwrap();
    close(driven.last("q"), whole.last("q"), 1e-8);
    close(driven.last("excess_pore_pressure"), whole.last("pore_pressure"), 1e-8);
}
