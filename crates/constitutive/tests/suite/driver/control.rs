//! Prescribed quantities, and rejected ones.

use colluvium_testkit::assert_close;

use super::*;

#[test]
fn wrong_amounts_are_refused_with_their_path() {
    let wrong = |path: LoadingPath, steps: usize| {
        let error = test(elastic(), 0.0, &[(path, steps)]).run().unwrap_err();
        assert!(matches!(error, DriverError::Invalid(_)), "{error}");
        error.to_string()
    };
    let b = |b| LoadingPath::TrueTriaxial { axial_compression: 0.01, b };
    assert_eq!(wrong(b(1.5), 10), "stages[0].path.b: 1.5 is not in 0..=1");
    assert!(wrong(b(f64::NAN), 10).starts_with("stages[0].path.b: "));
    assert!(
        wrong(LoadingPath::Isotropic { pressure: f64::INFINITY }, 1).starts_with("stages[0].path.pressure: ")
    );
    assert!(wrong(LoadingPath::Oedometer { axial_compression: 0.01 }, 0).starts_with("stages[0].steps: 0 "));
    assert!(wrong(LoadingPath::Oedometer { axial_compression: 3.0 }, 2).contains("take at least 3 steps"));
    assert!(wrong(LoadingPath::Reversal { fraction: 1.0 }, 1).contains("no stage before it"));
    let inverted = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let inverted = LoadingPath::DeformationGradient { deformation: inverted };
    assert!(wrong(inverted, 10).starts_with("stages[0].path.deformation: inverts"));
    let increments = vec![[0.0; 6], [0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0]];
    let direct =
        LoadingPath::Direct { control: [ControlledQuantity::Strain; 6], increments, spins: vec![[0.0; 3]] };
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
fn creep_and_relaxation_keep_stress_and_strain_while_time_passes() {
    let load = LoadingPath::TriaxialDrained { axial_compression: 0.001 };
    let stages = [(load, 10), (LoadingPath::Creep {}, 5), (LoadingPath::Relaxation {}, 5)];
    let run = test(elastic(), 100e3, &stages).run().unwrap();
    assert_eq!(run.rows.len(), 21);
    assert_close(run.last("time"), 3.0, 1e-12);
    for column in ["stress_zz", "strain_zz", "strain_xx"] {
        let values = run.column(column).unwrap();
        assert_close(values[20], values[10], 1e-9);
    }
    let flow = LoadingPath::Flow { velocity_gradient: [[0.0, 3.0, 0.0], [0.0; 3], [0.0; 3]] };
    let run = test(fluid(), 0.0, &[(flow, 10), (LoadingPath::Relaxation {}, 1)]).run().unwrap();
    assert_close(run.rows[10][10], 150.0, 1e-9);
    assert_eq!(run.last("q"), 0.0);
    // All work of the flow is dissipated: μ γ̇² t.
    assert_close(run.last("dissipated_work"), 50.0 * 9.0, 0.06);
}

#[test]
fn a_reversal_brings_an_elastic_point_back() {
    let stretched = [[1.2, 0.3, 0.0], [0.0, 0.9, 0.1], [0.0, 0.0, 1.1]];
    let wave = LoadingPath::General {
        stress: unit(0.0),
        strain: unit(1.0),
        total: [1e-3, 0.0, 0.0, 0.0, 0.0, 0.0],
        amplitude: [0.0, 2e-3, 0.0, 1e-3, 0.0, 0.0],
        phase: [0.0, 40.0, 0.0, 90.0, 0.0, 0.0],
        spin: [0.0; 3],
        fluid_stiffness: None,
    };
    let increments = vec![[1e-3, 0.0, 0.0, 2e-3, 0.0, 0.0], [0.0, -1e-3, 0.0, 0.0, 0.0, 1e-3]];
    let direct = LoadingPath::Direct { control: [ControlledQuantity::Strain; 6], increments, spins: vec![] };
    let hencky = MaterialSpec::LinearElastic(LinearElasticSpec {
        density: 2000.0,
        youngs_modulus: YOUNG,
        poissons_ratio: 0.3,
        strain_measure: StrainMeasure::Hencky,
    });
    for path in [
        LoadingPath::TriaxialUndrained { axial_compression: 0.01, fluid_stiffness: None },
        LoadingPath::Isotropic { pressure: 50e3 },
        LoadingPath::DeformationGradient { deformation: stretched },
        wave,
        direct,
    ] {
        let stages = [(path.clone(), 20), (LoadingPath::Reversal { fraction: 1.0 }, 20)];
        let run = test(hencky.clone(), 100e3, &stages).run().unwrap();
        for c in 0..6 {
            let (start, end) = (run.stress(0)[c], run.last_stress()[c]);
            assert!((start - end).abs() < 1e-4 * 100e3, "{path:?}: {start} {end}");
        }
        assert_close(run.last("excess_pore_pressure"), 0.0, 1.0);
        assert!(run.last("dissipated_work").abs() < 0.2, "{path:?}: {}", run.last("dissipated_work"));
    }
    let half = [
        (LoadingPath::Oedometer { axial_compression: 0.01 }, 10),
        (LoadingPath::Reversal { fraction: 0.5 }, 10),
    ];
    let run = test(elastic(), 0.0, &half).run().unwrap();
    assert_close(run.last("strain_zz"), -0.005, 1e-12);
}

#[test]
fn rotation_and_spin_paths_rotate_the_stress_equally() {
    let start = [-100e3, -50e3, -70e3, 20e3, 0.0, 0.0];
    let turned = |path: LoadingPath| {
        let mut test = test(elastic(), 0.0, &[(path, 3)]);
        test.initial_stress = start;
        test.run().unwrap().last_stress()
    };
    let rotation = turned(LoadingPath::Rotation { angle: 30.0 });
    let direct = |control, increment| LoadingPath::Direct {
        control,
        increments: vec![increment],
        spins: vec![[0.0, 0.0, 30.0]],
    };
    let spin = turned(direct([ControlledQuantity::Strain; 6], [0.0; 6]));
    // sheet: constitutive V-02.
    for stress in [rotation, spin] {
        assert_close(stress[0], -104_820.508_08, 1e-9);
        assert_close(stress[3], -11_650.635_09, 1e-8);
    }
    // Stress control with spin: the axes are those of space.
    let kept = turned(direct([ControlledQuantity::Stress; 6], [1e3, 0.0, 0.0, 0.0, 0.0, 0.0]));
    (0..6).for_each(|c| assert_close(kept[c], start[c] + if c == 0 { 1e3 } else { 0.0 }, 1e-9));
}

#[test]
fn a_direct_path_mixes_stress_and_strain_rows() {
    use ControlledQuantity::{Strain, Stress};
    let increments = vec![[0.0, 0.0, -0.001, 0.0, 0.0, 0.0], [0.0, 0.0, -0.001, 0.0, 0.0, 0.0]];
    let control = [Stress, Stress, Strain, Strain, Stress, Strain];
    let direct = LoadingPath::Direct { control, increments, spins: vec![] };
    let run = test(elastic(), 50e3, &[(direct, 5)]).run().unwrap();
    assert_eq!(run.rows.len(), 11);
    assert_close(run.last("time"), 1.0, 1e-12);
    assert_close(run.last("stress_zz"), -50e3 - YOUNG * 0.002, 1e-9);
    assert_close(run.last("stress_xx"), -50e3, 1e-9);
}

#[test]
fn a_sine_of_strain_returns_after_its_period() {
    let mut amplitude = [0.0; 6];
    amplitude[2] = 0.001;
    let path = LoadingPath::General {
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
    assert_close(strain[10], 0.001, 1e-12);
    assert_close(strain[30], -0.001, 1e-12);
    assert_close(strain[40], 0.0, 1e-12);
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
    let path = LoadingPath::TrueTriaxial { axial_compression: 0.002, b: 0.5 };
    let run = test(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), 100e3, &[(path, 50)]).run().unwrap();
    let s = run.last_stress();
    assert_close((s[1] - s[0]) / (s[2] - s[0]), 0.5, 1e-8);
}
