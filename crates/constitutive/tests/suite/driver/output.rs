//! Limit loads, energies, pore pressure, tables and yield lines.

use colluvium_testkit::assert_close;

use super::*;

/// Fluid stiffness `K_f/n` of water (2.15 GPa) at a porosity of 0.4.
const FLUID: f64 = 2.15e9 / 0.4;

#[test]
fn stress_control_stops_at_the_limit_load() {
    let push = LoadingPath::Stress { increment: [0.0, 0.0, -300e3, 0.0, 0.0, 0.0] };
    let error = test(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), 100e3, &[(push, 300)]).run().unwrap_err();
    // q = 234.6 kPa is reached in step 234.
    assert!(matches!(error, DriverError::LimitLoad { stage: 0, step: 233..=235, .. }), "{error}");
}

#[test]
fn rows_before_a_limit_load_are_kept() {
    let push = LoadingPath::Stress { increment: [0.0, 0.0, -300e3, 0.0, 0.0, 0.0] };
    let trace = test(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), 100e3, &[(push, 300)]).trace().unwrap();
    let stopped = trace.stop_reason.unwrap().to_string();
    assert!(stopped.starts_with("stages[0].path: limit load reached in step"), "{stopped}");
    assert!((234..=237).contains(&trace.path.rows.len()), "{}", trace.path.rows.len());
    // The last row lies within a thousandth of a step of the strength.
    assert_close(trace.path.last("q"), 234_641.016, 1e-5);
}

#[test]
fn work_is_stored_by_elasticity_and_lost_by_plasticity() {
    let neo = MaterialSpec::NeoHookean(NeoHookeanSpec {
        density: 2000.0,
        youngs_modulus: YOUNG,
        poissons_ratio: 0.3,
        volumetric_law: Default::default(),
    });
    let shear = LoadingPath::SimpleShearConstantVolume { shear: 0.5 };
    let run = test(neo, 0.0, &[(shear, 400)]).run().unwrap();
    // ½ G γ².
    assert_close(run.last("stored_energy"), 0.5 * SHEAR * 0.25, 1e-9);
    assert_close(run.last("dissipated_work") / run.last("stored_energy"), 0.0, 1e-5);
    let path = LoadingPath::TriaxialDrained { axial_compression: 0.05 };
    let run = test(MaterialSpec::MohrCoulomb(mohr_coulomb(0.0)), 100e3, &[(path, 200)]).run().unwrap();
    let lost = run.column("dissipated_work").unwrap();
    assert!(lost.windows(2).all(|pair| pair[1] >= pair[0] - 1.0), "{lost:?}");
    // ψ = 0: q times plastic shear strain, 5 % less the elastic part.
    assert_close(run.last("dissipated_work"), 234_641.0 * (0.05 - 234_641.0 / YOUNG), 1e-2);
}

#[test]
fn the_pore_pressure_of_an_undrained_test_is_minus_the_change_of_effective_pressure() {
    let path = LoadingPath::TriaxialUndrained { axial_compression: 0.01, fluid_stiffness: None };
    let run = test(elastic(), 100e3, &[(path, 20)]).run().unwrap();
    // Constant total lateral stress: u = q/3 where p' is constant.
    assert_close(run.last("excess_pore_pressure"), run.last("q") / 3.0, 1e-9);
    assert_eq!(run.standard_plots()[1].name, "pore-pressure-strain");
    let drained = LoadingPath::TriaxialDrained { axial_compression: 0.01 };
    let run = test(elastic(), 100e3, &[(drained, 20)]).run().unwrap();
    assert_close(run.last("excess_pore_pressure"), 0.0, 1e-12);
    assert_eq!(run.standard_plots().map(|p| p.name), ["q-strain", "volume-strain", "q-p", "volume-ln-p"]);
}

#[test]
fn a_void_ratio_is_drawn_where_the_law_has_one() {
    let mut run =
        test(elastic(), 100e3, &[(LoadingPath::Oedometer { axial_compression: 0.01 }, 2)]).run().unwrap();
    run.columns.push(("void_ratio", ""));
    run.rows.iter_mut().for_each(|row| row.push(0.7));
    let plot = run.standard_plots()[3];
    assert_eq!((plot.name, plot.x, plot.y), ("void-ratio-ln-p", "ln_p", "void_ratio"));
}

#[test]
fn the_yield_line_is_the_strength_in_triaxial_compression() {
    let path = LoadingPath::TriaxialDrained { axial_compression: 0.05 };
    let spec = MaterialSpec::MohrCoulomb(mohr_coulomb(0.0));
    let trace = test(spec, 100e3, &[(path.clone(), 100)]).trace().unwrap();
    let lines = trace.yield_lines();
    assert_eq!(lines.len(), 1);
    // q = M p + 6 c cos φ / (3 - sin φ), M = 6 sin φ / (3 - sin φ).
    for (p, q) in &lines[0].points {
        assert_close(*q, 1.2 * p + 2.4 * 10e3 * 3f64.sqrt() / 2.0, 1e-9);
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
fn the_table_reads_as_csv() {
    let run = test(elastic(), 0.0, &[(LoadingPath::Oedometer { axial_compression: 0.01 }, 3)]).run().unwrap();
    let mut text = Vec::new();
    run.write_csv(&mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 2 + 4);
    assert!(lines.iter().skip(1).all(|line| line.split(',').count() == run.columns.len()));
}

#[test]
fn a_compressible_pore_fluid_adds_its_stiffness() {
    let undrained = BULK + FLUID;
    let poisson = (3.0 * undrained - 2.0 * SHEAR) / (2.0 * (3.0 * undrained + SHEAR));
    // Values of `sheet: constitutive §5.3`.
    assert_close(undrained, 5.391_667e9, 1e-7);
    assert_close(poisson, 0.499_287, 1e-6);
    let path = LoadingPath::TriaxialUndrained { axial_compression: 0.01, fluid_stiffness: Some(FLUID) };
    let run = test(elastic(), 100e3, &[(path, 20)]).run().unwrap();
    assert_close(run.last("q"), 2.0 * SHEAR * (1.0 + poisson) * 0.01, 1e-9);
    assert_close(run.last("volumetric_strain"), -(1.0 - 2.0 * poisson) * 0.01, 1e-7);
    assert_close(run.last("excess_pore_pressure"), FLUID * (1.0 - 2.0 * poisson) * 0.01, 1e-7);
    // The total lateral stress is constant.
    assert_close(run.last("stress_xx") - run.last("excess_pore_pressure"), -100e3, 1e-9);
}

#[test]
fn a_total_pressure_is_shared_by_skeleton_and_pore_fluid() {
    let mut total = [0.0; 6];
    total[..3].fill(-50e3);
    let path = LoadingPath::General {
        stress: unit(1.0),
        strain: unit(0.0),
        total,
        amplitude: [0.0; 6],
        phase: [0.0; 6],
        spin: [0.0; 3],
        fluid_stiffness: Some(FLUID),
    };
    let run = test(elastic(), 100e3, &[(path, 5)]).run().unwrap();
    assert_close(run.last("excess_pore_pressure"), 50e3 * FLUID / (BULK + FLUID), 1e-9);
    assert_close(run.last("p"), 100e3 + 50e3 * BULK / (BULK + FLUID), 1e-9);
}

#[test]
fn the_pore_fluid_and_the_undrained_wrapper_agree() {
    let skeleton = MaterialSpec::MohrCoulomb(mohr_coulomb(10.0));
    let path = LoadingPath::TriaxialUndrained { axial_compression: 0.02, fluid_stiffness: Some(5e7) };
    let driven = test(skeleton.clone(), 100e3, &[(path, 200)]).run().unwrap();
    let wrapped = MaterialSpec::Undrained(UndrainedSpec {
        fluid_bulk_modulus: 2e7,
        porosity: 0.4,
        initial_pore_pressure: 0.0,
        cavitation_strength: None,
        skeleton: Box::new(skeleton),
    });
    let path = LoadingPath::TriaxialDrained { axial_compression: 0.02 };
    let whole = test(wrapped, 100e3, &[(path, 200)]).run().unwrap();
    assert_close(driven.last("q"), whole.last("q"), 1e-8);
    assert_close(driven.last("excess_pore_pressure"), whole.last("pore_pressure"), 1e-8);
}
